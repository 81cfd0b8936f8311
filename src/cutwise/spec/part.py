"""The edge to be deburred: its burr and the part below it."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from annotated_types import Ge, Gt
from pydantic import Discriminator, Field

from cutwise.spec.base import ByChance, Count, Length, Notice, Spec, Stiffness, Usual
from cutwise.spec.fields import tag
from cutwise.spec.part_block import PartBlock
from cutwise.spec.tables import Column, Table


class BurrHeightTable(Table):
    """Burr height over the way w along the edge, w = 0 at the start of the run."""

    over: ClassVar[tuple[Column, ...]] = (Column("w", "length"),)
    ordinate: ClassVar[Column] = Column("height", "length", 0.0)


class BurrWidthTable(Table):
    """Burr width over the way w along the edge, w = 0 at the start of the run."""

    over: ClassVar[tuple[Column, ...]] = (Column("w", "length"),)
    ordinate: ClassVar[Column] = Column("width", "length", 0.0)


_SHORTEST = 10e-6  # [m]; an eighth of it is the grid of a curve


class RandomField(Spec):
    """A random, normally distributed size along the edge; below zero there is no burr. Same seed, same burr."""

    mean: Length = Field(description="mean size", examples=["1 mm"], ge=0)
    deviation: Length = Field(description="standard deviation", examples=["0.2 mm"], ge=0)
    correlation_length: Length = Field(
        description="distance along the edge over which the size changes", examples=["10 mm"], gt=0
    )
    seed: Annotated[Count, ByChance()] = Field(default=0, description="seed of the random numbers", examples=[1], ge=0)
    lever: Count | None = Field(
        default=None, description="number of the lever in a study, whose curves of this seed are taken; with case",
        examples=[0], ge=0,
    )  # fmt: skip
    case: Count | None = Field(
        default=None, description="case of that study, whose curve this is", examples=[1921], ge=0
    )

    @property
    def curve(self) -> tuple[int, int] | None:
        """Lever and case of a study; None: the one curve of the seed."""
        return None if self.lever is None or self.case is None else (self.lever, self.case)

    def contradictions(self) -> Iterator[Notice]:
        """A curve of a study that is half said, or one of more points than an edge has."""
        if self.correlation_length < _SHORTEST:
            yield Notice(("correlation_length",), f"is below {_SHORTEST * 1e6:g} um, shorter than any burr changes")
        for key, other in (("lever", "case"), ("case", "lever")):
            if getattr(self, key) is None and getattr(self, other) is not None:
                yield Notice((key,), f"missing; {other} belongs to it")

    def notices(self) -> Iterator[Notice]:
        """A deviation so large that much of the field is cut off at zero."""
        if self.deviation > 0.5 * self.mean:
            yield Notice(("deviation",), "is more than half the mean: the size is cut off at zero in many places")


def _size_kind(value: Any) -> str:
    if isinstance(value, Table):
        return "<table>"
    if isinstance(value, dict):
        return "<table>" if "columns" in value else "<random>"
    return "<random>" if isinstance(value, RandomField) else "<constant>"


BurrHeight = Annotated[
    Annotated[Length, Ge(0), Usual("0 mm", "3 mm"), tag("constant")]
    | Annotated[BurrHeightTable, tag("table")]
    | Annotated[RandomField, tag("random")],
    Discriminator(_size_kind),
]
BurrWidth = Annotated[
    Annotated[Length, Gt(0), Usual("0 mm", "5 mm"), tag("constant")]
    | Annotated[BurrWidthTable, tag("table")]
    | Annotated[RandomField, tag("random")],
    Discriminator(_size_kind),
]


class Burr(Spec):
    """The burr on the edge: a strip of rectangular section."""

    height: BurrHeight = Field(
        description="height of the burr above the nominal edge: constant, {table: file.csv}, or "
        "{mean, deviation, correlation_length, seed}",
        examples=["1 mm"],
    )
    width: BurrWidth = Field(
        description="width of the burr along the mill axis, as constant, table or random field", examples=["1 mm"]
    )
    axial_start: Length = Field(
        default=0.0, description="height above the mill tip at which the burr begins", examples=["0 mm"], ge=0
    )


class DeburringPart(Spec):
    """The part at the edge: what the mill meets once it has gone through the burr."""

    burr: Burr = Field(description="the burr")
    step: str | None = Field(
        default=None, description="a STEP file, beside the scenario, whose edge is deburred", examples=["disc.step"]
    )
    edges: str | None = Field(
        default=None,
        description="which edge of the STEP part, a line or an arc: outer, inner, closed, open, hole:N, edge:N, longer:5mm, "
        "shorter:5mm, sharper:80deg, blunter:100deg, facing:+z, joined by commas (any) and & (all), ! for not",
        examples=["edge:1"],
    )
    contact_length: Annotated[Length, Usual("0.5 mm", "50 mm")] = Field(
        description="length a of the part's face along the mill axis", examples=["10 mm"], gt=0
    )
    axial_start: Length = Field(
        default=0.0, description="height above the mill tip at which the part begins", examples=["0 mm"], ge=0
    )
    slices: Annotated[Count, Usual(1, 50)] = Field(
        default=1, description="slices along the mill axis; more than one resolves the taper of a tilted mill",
        examples=[1], ge=1, le=1000,
    )  # fmt: skip

    stiffness: Annotated[Stiffness, Usual("0.01 N/um", "1000 N/um")] | None = Field(
        default=None, description="stiffness of the part against the tool, off its edge; left out: rigid",
        examples=["0.2 N/um"], gt=0,
    )  # fmt: skip
    block: PartBlock | None = Field(
        default=None,
        description="the part as a block on the table of a machine, which bends under the cut",
        examples=["{width_x: 260 mm, width_y: 90 mm, height: 300 mm, weight: 540 N, flexible: false}"],
    )

    def notices(self) -> Iterator[Notice]:
        """A burr that the part does not carry."""
        if isinstance(self.burr.width, float):
            burr_end = self.burr.axial_start + self.burr.width
            part_end = self.axial_start + self.contact_length
            if burr_end > part_end * (1 + 1e-9) or self.burr.axial_start < self.axial_start * (1 - 1e-9):
                yield Notice(("burr",), "reaches beyond the part's face along the mill axis")
