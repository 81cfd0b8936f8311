"""Rotating tools. Shared by the processes: each takes the kind it needs, all draw on the shelf ``tools``."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from cutwise.spec.base import (
    Angle,
    ByChance,
    Count,
    Frequency,
    Length,
    LibrarySpec,
    Notice,
    Number,
    SmallLength,
    Spec,
    Stiffness,
    Usual,
)


class ToolMode(Spec):
    """A vibration mode of the tool tip."""

    direction: Literal["x", "y"] = Field(description="direction of the tip's motion", examples=["x"])
    frequency: Annotated[Frequency, Usual("50 Hz", "10000 Hz")] = Field(
        description="natural frequency", examples=["922 Hz"], gt=0
    )
    damping: Annotated[Number, Usual(0.005, 0.15)] = Field(description="damping ratio", examples=[0.011], ge=0, lt=1)
    stiffness: Stiffness = Field(description="modal stiffness", examples=["1.34 N/um"], gt=0)


class RotatingTool(LibrarySpec):
    """What every rotating tool has."""

    library_shelf: ClassVar[str] = "tools"

    diameter: Annotated[Length, Usual("1 mm", "32 mm")] = Field(description="diameter D", examples=["8 mm"], gt=0)
    flutes: Annotated[Count, Usual(1, 40)] = Field(description="number of flutes N", examples=[20], ge=1, le=200)
    flute_length: Length | None = Field(
        default=None, description="length of the cutting edges from the tip", examples=["20 mm"], gt=0
    )


class HelicalMill(RotatingTool):
    """A cylindrical end mill or bur with helical flutes."""

    helix: Annotated[Angle, Usual("0 deg", "50 deg")] = Field(
        description="helix angle β, positive for a right-hand helix",
        examples=["20 deg"],
        gt=-math.radians(80),
        lt=math.radians(80),
    )
    runout: Annotated[SmallLength, Usual("0 um", "50 um")] = Field(
        default=0.0,
        description="run-out ρ: offset of the tool axis from the spindle axis (left out: none)",
        examples=["5 um"],
        ge=0,
    )
    runout_angle: Annotated[Angle, ByChance()] = Field(
        default=0.0,
        description="direction λ of the run-out, counted from flute 0 in the sense in which the tool turns",
        examples=["0 deg"],
    )

    def contradictions(self) -> Iterator[Notice]:
        """Run-out that reaches the axis."""
        if self.runout >= self.diameter / 2:
            yield Notice(("runout",), "is as large as the radius of the tool")

    def unused(self) -> Iterator[Notice]:
        """The direction of a run-out that is not there."""
        if not self.runout:
            yield Notice(("runout_angle",), "there is no run-out (tool.runout)")


def bends_twice(tool: Any) -> Iterator[Notice]:
    """A tool whose bending is said by a stiffness and by modes."""
    if tool.modes and tool.stiffness is not None:
        yield Notice(("modes",), "and tool.stiffness both say how the tool bends; write one of them")


class BendingTool(LibrarySpec):
    """A tool that may bend: by one stiffness at its tip, or by modes."""

    library_shelf: ClassVar[str] = "tools"

    stiffness: Annotated[Stiffness, Usual("0.1 N/um", "100 N/um")] | None = Field(
        default=None, description="static stiffness of the tool at its tip across its axis; left out: rigid",
        examples=["5 N/um"], gt=0,
    )  # fmt: skip
    modes: tuple[ToolMode, ...] = Field(
        default=(), description="vibration modes of the tool tip, which count at rest: F/k",
        examples=["[{direction: y, frequency: 1020 Hz, damping: 0.035, stiffness: 20 N/um}]"],
    )  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """One way in which a tool bends."""
        yield from super().contradictions()
        yield from bends_twice(self)


class BendingMill(BendingTool, HelicalMill):
    """A mill that may bend."""


class Bur(BendingMill):
    """A mill or bur along an edge, which may bend."""

    def notices(self) -> Iterator[Notice]:
        """What of a mode does not count."""
        if self.modes:
            yield Notice(
                ("modes",), "count by their stiffness alone: along an edge they do not swing, whatever holds the tool"
            )


class EndMill(BendingMill):
    """A cylindrical end mill; with modes its tip may vibrate."""

    helix: Annotated[Angle, Usual("0 deg", "50 deg")] = Field(
        description="helix angle β of a right-hand helix", examples=["30 deg"], ge=0, lt=math.radians(80)
    )
    end_core: Length | None = Field(
        default=None, description="radius inside which bottom edges do not cut (0 mm: they cut over the centre); left out: plunges "
        "have no force", examples=["0 mm"], ge=0,
    )  # fmt: skip
    modes: tuple[ToolMode, ...] = Field(
        default=(), description="vibration modes of the tool tip; none: the tool is rigid",
        examples=["[{direction: x, frequency: 922 Hz, damping: 0.011, stiffness: 1.34 N/um}]"],
    )  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """A core that is more than the bottom."""
        yield from super().contradictions()
        if self.end_core is not None and self.end_core > 0.5 * self.diameter * (1.0 + 1e-12):
            yield Notice(("end_core",), "is more than half the diameter")
