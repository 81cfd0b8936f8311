"""The deburring pass: how the tool is led along the edge, and how far the robot is off."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import (
    AngularSpeed,
    ByChance,
    Count,
    Frequency,
    Length,
    LibrarySpec,
    Notice,
    Spec,
    Speed,
    Time,
    Usual,
)
from cutwise.spec.fields import tag
from cutwise.spec.tables import Column, Table


class SinePathError(Spec):
    """A sine normal to the edge that starts at the end of the lead-in."""

    amplitude: Annotated[Length, Usual("0 mm", "2 mm")] = Field(
        description="amplitude of the path error", examples=["0.2 mm"], ge=0
    )
    frequency: Annotated[Frequency, Usual("0.05 Hz", "50 Hz")] = Field(
        description="frequency of the path error", examples=["2 Hz"], gt=0
    )


class TabulatedPathError(Table):
    """A path error over the way along the edge (w = 0 at the start of the run) or over time."""

    over: ClassVar[tuple[Column, ...]] = (Column("w", "length"), Column("t", "time"))
    ordinate: ClassVar[Column] = Column("error", "length")


class PathErrorComponent(Spec):
    """A sine of the path error with a random phase, by its wavelength along the path or by its frequency."""

    either: ClassVar[tuple[tuple[str, ...], ...]] = (("wavelength",), ("frequency",))

    amplitude: Length = Field(description="amplitude of this component", examples=["0.1 mm"], ge=0)
    wavelength: Length | None = Field(
        default=None,
        description="wavelength along the path (gear errors keep it at every feed)",
        examples=["63 mm"],
        gt=0,
    )
    frequency: Frequency | None = Field(
        default=None, description="frequency (structural ringing keeps it at every feed)", examples=["10 Hz"], gt=0
    )

    def contradictions(self) -> Iterator[Notice]:
        """One of wavelength and frequency."""
        if (self.wavelength is None) == (self.frequency is None):
            yield Notice((), "give exactly one of wavelength and frequency")


class PathErrorSpectrum(LibrarySpec):
    """A path error of several sines with random phases; the same seed gives the same phases."""

    library_shelf: ClassVar[str] = "path_errors"

    spectrum: tuple[PathErrorComponent, ...] = Field(
        description="the components", examples=["[{amplitude: 0.1 mm, wavelength: 63 mm}]"], min_length=1
    )
    seed: Annotated[Count, ByChance()] = Field(default=0, description="seed of the random phases", examples=[1], ge=0)


def _path_error_kind(value: Any) -> str:
    if isinstance(value, Table):
        return "<table>"
    if isinstance(value, PathErrorSpectrum):
        return "<spectrum>"
    if isinstance(value, dict):
        return "<spectrum>" if "spectrum" in value else "<table>" if "columns" in value else "<sine>"
    return "<sine>" if isinstance(value, SinePathError) else "<none>"


PathError = Annotated[
    Annotated[Literal["none"], tag("none")]
    | Annotated[SinePathError, tag("sine")]
    | Annotated[TabulatedPathError, tag("table")]
    | Annotated[PathErrorSpectrum, tag("spectrum")],
    Discriminator(_path_error_kind),
]


class FeedProfile(Table):
    """The feed over the way along the edge, straight lines between places; w = 0 at the start of the run."""

    over: ClassVar[tuple[Column, ...]] = (Column("w", "length"),)
    ordinate: ClassVar[Column] = Column("feed", "speed", 0.0)

    columns: dict[str, tuple[float, ...]] = Field(
        description="columns by their titles with units; a CSV file named by `table` is read into here",
        examples=['{"w [mm]": [0, 50], "feed [mm/s]": [80, 60]}'],
    )

    def contradictions(self) -> Iterator[Notice]:
        """A feed of nothing, beside what any table may have."""
        found = list(super().contradictions())
        yield from found
        if not found:
            still = [row for row, feed in enumerate(self.points()[1]) if feed == 0.0]
            title = next(title for title in self.columns if title.lstrip().lower().startswith("feed"))
            for row in still:
                yield Notice(("columns", title, row), "must be above 0: the tool would stop there")


class DeburringOperation(Spec):
    """A deburring pass along one edge, whose length or duration covers lead-in and lead-out."""

    either: ClassVar[tuple[tuple[str, ...], ...]] = (("length",), ("duration",))

    limit_feed: bool = Field(
        default=False, description="the feed is lowered where the joints of the robot cannot follow it (robot.joint_speed, "
        "joint_acceleration)", examples=[True],
    )  # fmt: skip
    feed: Annotated[Speed, Usual("5 mm/s", "300 mm/s")] = Field(
        description="feed along the edge", examples=["80 mm/s"], gt=0
    )
    feed_profile: FeedProfile | None = Field(
        default=None, description="another feed at places of the edge, {table: file.csv} with w and feed; the lead-in takes its "
        "time at operation.feed, and is run at this pace too",
        examples=['{columns: {"w [mm]": [0, 500], "feed [mm/s]": [90, 60]}}'],
    )  # fmt: skip
    spindle_speed: Annotated[AngularSpeed, Usual("5000 rpm", "80000 rpm")] = Field(
        description="spindle speed", examples=["40000 rpm"], gt=0
    )
    preset: Annotated[Length, Usual("0.5 mm", "3 mm")] = Field(
        description="how far the undeflected mill reaches below the nominal edge; more than path error plus tolerance",
        examples=["2 mm"],
    )
    milling: Literal["down", "up"] = Field(
        default="down", description="down (climb) or up (conventional) milling", examples=["down"]
    )
    length: Length | None = Field(
        default=None, description="length of the run along the edge (or give duration)", examples=["48 mm"], gt=0
    )
    duration: Time | None = Field(
        default=None, description="time of the run, lead-in and lead-out included (or give length)",
        examples=["0.6 s"], gt=0,
    )  # fmt: skip
    lead_in_time: Time = Field(
        description="time in which the mill is lowered (cosine) from the clearance to the preset",
        examples=["0.2 s"],
        ge=0,
    )
    lead_out_time: Time = Field(
        default=0.0, description="time in which it is raised again at the end", examples=["0 s"], ge=0
    )
    clearance: Annotated[Length, Usual("0 mm", "10 mm")] = Field(
        description="height of the mill above the burr at the start", examples=["0.5 mm"], ge=0
    )
    path_error: PathError = Field(
        default="none",
        description="error of the robot normal to the edge, positive away from the work: none, "
        "{amplitude, frequency}, {table: file.csv}, {spectrum: [...], seed} or {library: industrial_robot, seed}",
        examples=["{amplitude: 0.2 mm, frequency: 2 Hz}"],
    )
    tolerance: Annotated[Length, Usual("0.001 mm", "0.5 mm")] = Field(
        default=0.05e-3,
        description="an edge error within plus or minus this counts as ideal", examples=["0.05 mm"], gt=0,
    )  # fmt: skip

    @property
    def run_time(self) -> float:
        """Duration of the whole run [s]."""
        if self.duration is not None:
            return self.duration
        assert self.length is not None
        return self.length / self.feed

    @property
    def run_length(self) -> float:
        """Way along the edge in the whole run [m]."""
        return self.run_time * self.feed

    def contradictions(self) -> Iterator[Notice]:
        """One of length and duration, long enough for both leads, within the table of the path error."""
        if self.length is None and self.duration is None:
            return  # the path of the scenario gives it
        if self.length is not None and self.duration is not None:
            yield Notice(("duration",), "length is given too; write exactly one of length and duration")
            return
        if self.lead_in_time + self.lead_out_time >= self.run_time:
            yield Notice(
                ("lead_in_time",),
                f"lead-in {self.lead_in_time:g} s and lead-out {self.lead_out_time:g} s leave nothing of a run of "
                f"{self.run_time:.4g} s; make the run longer or the leads shorter",
            )
        if isinstance(self.path_error, TabulatedPathError):
            end = self.run_time if self.path_error.variable == "t" else self.run_length
            yield from uncovered(self.path_error, end, ("path_error",))
        if self.feed_profile is not None:
            yield from uncovered(self.feed_profile, self.run_length, ("feed_profile",))
            yield from self._profile_faults()

    def _profile_faults(self) -> Iterator[Notice]:
        """What goes with time, and not with the way, beside another feed."""
        error = self.path_error
        timed = isinstance(error, SinePathError) or (isinstance(error, Table) and error.variable == "t")
        if timed or (isinstance(error, PathErrorSpectrum) and any(one.frequency is not None for one in error.spectrum)):
            yield Notice(("feed_profile",), "beside a path error over time (frequency, t) is not covered: give the path error over "
                         "the way (w, wavelength)")  # fmt: skip
        if self.limit_feed:
            yield Notice(("feed_profile",), "and limit_feed both say how fast the tool goes; write one of them")

    def notices(self) -> Iterator[Notice]:
        """Lead-in that reaches into the steady part; path error beyond the preset."""
        known = self.length is not None or self.duration is not None  # else the part gives the length
        if known and self.lead_in_time > 0.75 * (self.run_time - self.lead_out_time):
            yield Notice(
                ("lead_in_time",),
                "reaches into the steady part (the last quarter of the run), whose means are reported",
            )
        if isinstance(self.path_error, SinePathError) and self.preset < self.path_error.amplitude + self.tolerance:
            yield Notice(
                ("preset",), "is less than path error plus tolerance: the mill may leave the edge; usual is 1 to 3 mm"
            )


def uncovered(table: Table, end: float, path: tuple[str, ...]) -> Iterator[Notice]:
    """A table that does not reach over the run from 0 to ``end`` [SI]; nothing is extrapolated."""
    places = table.points()[0]
    scale, unit = (1.0, "s") if table.variable == "t" else (1e3, "mm")
    slack = 1e-9 * end
    if places[0] > slack or places[-1] < end - slack:
        yield Notice(
            path,
            f"the table covers {table.variable} = {places[0] * scale:g} to {places[-1] * scale:g} {unit}, the run "
            f"needs 0 to {end * scale:g} {unit}; nothing is extrapolated",
        )
