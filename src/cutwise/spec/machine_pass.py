"""The pass of a machine tool: its path or program, the forces that act, and the surface that it finishes."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import Angle, AngularSpeed, Count, Force, Length, Notice, Number, Spec, Speed, Usual
from cutwise.spec.fields import tag
from cutwise.spec.geometry_errors import COMPONENTS
from cutwise.spec.machine import Place
from cutwise.spec.program import Program
from cutwise.spec.robot import Direction


class AxisPosition(Spec):
    """Commands of the axes at a point of the path; an axis left out stays where it was (at first: 0)."""

    X: Length | None = Field(default=None, description="linear axis X", examples=["0 mm"])
    Y: Length | None = Field(default=None, description="linear axis Y", examples=["0 mm"])
    Z: Length | None = Field(default=None, description="linear axis Z", examples=["0 mm"])
    A: Angle | None = Field(default=None, description="rotary axis A", examples=["0 deg"])
    B: Angle | None = Field(default=None, description="rotary axis B", examples=["0 deg"])
    C: Angle | None = Field(default=None, description="rotary axis C", examples=["0 deg"])

    def given(self) -> dict[str, float]:
        """The axes that are named."""
        return {axis: value for axis in COMPONENTS if (value := getattr(self, axis)) is not None}


class MachinePath(Spec):
    """A path of straight moves of the axes."""

    points: tuple[AxisPosition, ...] = Field(
        description="commands at the corners of the path", examples=["[{X: 0 mm}, {X: 260 mm}]"], min_length=2
    )
    feed: Annotated[Speed, Usual("0.1 mm/s", "500 mm/s")] = Field(
        description="feed along the path of the linear axes", examples=["400 mm/min"], gt=0
    )
    tool_axis: Direction = Field(
        default=(0.0, 0.0, -1.0), description="direction from the motor to the tool tip in the part, for a robot",
        examples=["[0, 0, -1]"],
    )  # fmt: skip
    samples: Annotated[Count, Usual(3, 100000)] = Field(
        default=27,
        description="places evaluated, equally spaced along the path, besides its corners",
        examples=[27],
        ge=3,
        le=1_000_000,
    )

    def contradictions(self) -> Iterator[Notice]:
        """An axis with a length."""
        if not any(self.tool_axis):
            yield Notice(("tool_axis",), "has no length; write for example [0, 0, -1]")

    def corners(self) -> list[dict[str, float]]:
        """All axes at each corner."""
        found: list[dict[str, float]] = []
        here = dict.fromkeys(COMPONENTS, 0.0)
        for point in self.points:
            here = {**here, **point.given()}
            found.append(here)
        return found


class ProgramPass(Program):
    """A G-code program, and how it stands on the machine."""

    zero: Place = Field(
        default=(0.0, 0.0, 0.0), description="program zero in the part's frame", examples=["[0 mm, 0 mm, 300 mm]"]
    )
    words: Literal["part", "axes"] = Field(
        default="part",
        description="X, Y, Z of the program are places of the tool point in the part (tool centre point control), or "
        "positions of the axes; the same but for a shift without rotary axes",
        examples=["part"],
    )
    samples: Annotated[Count, Usual(50, 100000)] = Field(
        default=400, description="places evaluated, equally spaced along the feed moves, besides the ends of the "
        "blocks and every 10° of an arc", examples=[400], ge=3, le=1_000_000,
    )  # fmt: skip


class FromCutting(Spec):
    """The mean force of the cut, from the coefficients of the material."""

    axial_depth: Length | None = Field(
        default=None, description="axial depth of cut a_p; with a stock it follows from the program", examples=["5 mm"],
        gt=0,
    )  # fmt: skip
    radial_depth: Length | None = Field(
        default=None,
        description="radial depth of cut a_e, climb milling with the wall on the right; left out: a full slot",
        examples=["4 mm"], gt=0,
    )  # fmt: skip
    spindle_speed: Annotated[AngularSpeed, Usual("50 rpm", "60000 rpm")] | None = Field(
        default=None, description="spindle speed; a program has its own (S), which this replaces", examples=["500 rpm"],
        gt=0,
    )  # fmt: skip


def _force_kind(value: Any) -> str:
    return "<cut>" if isinstance(value, dict | FromCutting) else "<vector>"


CuttingForce = Annotated[
    Annotated[tuple[Force, Force, Force], tag("vector")] | Annotated[FromCutting, tag("cut")],
    Discriminator(_force_kind),
]


class MachineLoad(Spec):
    """What acts on the machine."""

    force: CuttingForce | None = Field(
        default=None,
        description="cutting force on the tool in the part's frame, or {axial_depth, radial_depth, spindle_speed}: the "
        "mean force of that cut by the material's coefficients, along the path",
        examples=["[4000 N, 4000 N, 2000 N]"],
    )
    weights: bool = Field(default=True, description="weights of part and bodies count", examples=[True])
    feed_moment: bool = Field(
        default=True, description="false leaves out the moment of the x forces on tables; not physical", examples=[True]
    )


class CutSurface(Spec):
    """Where the finished surface is on the tool."""

    either: ClassVar[tuple[tuple[str, ...], ...]] = (("normal",), ("side",))

    normal: tuple[Number, Number, Number] | None = Field(
        default=None, description="normal of the wall in the part's frame, from the part to the tool",
        examples=["[0, 1, 0]"],
    )  # fmt: skip
    side: Literal["right", "left"] | None = Field(
        default=None, description="side of the feed on which the wall is; right in climb milling", examples=["right"]
    )
    depth: Length = Field(description="axial depth of cut: height of the wall", examples=["5 mm"], gt=0)

    def contradictions(self) -> Iterator[Notice]:
        """One of the two, and a normal with a length."""
        if (self.normal is None) == (self.side is None):
            yield Notice((), "give exactly one of normal (a wall that keeps its direction) and side")
        if self.normal is not None and not any(self.normal):
            yield Notice(("normal",), "has zero length")
