"""The straight wall that a mill passes by: a line of the part, as a robot or a machine follows it."""

import math
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field, create_model

from cutwise import units
from cutwise.spec.base import Angle, Length, Notice, Spec, Usual
from cutwise.spec.carrier import CarriedPath
from cutwise.spec.robot import Direction, Position

_FROM = "[-100 mm, -40 mm]"


class _MillLine(Spec):
    """A straight line from a point of the part."""

    to: tuple[Length, ...] | None = Field(
        default=None, description="where it ends (or angle and length)", examples=["[0 mm, -40 mm]"],
        min_length=2, max_length=3,
    )  # fmt: skip
    angle: Angle | None = Field(
        default=None, description="direction in the xy plane, from x to the left", examples=["30 deg"]
    )
    length: Length | None = Field(default=None, description="length, beside angle", examples=["100 mm"], gt=0)

    @property
    def given_start(self) -> tuple[float, ...]:
        """First point as written, two or three coordinates [m]; Python keeps the word of the scenario for itself."""
        return self.__dict__["from"]  # type: ignore[no-any-return]

    def contradictions(self) -> Iterator[Notice]:
        """One way to say where it ends, and another point than the first."""
        polar = [key for key in ("angle", "length") if getattr(self, key) is not None]
        if self.to is not None and polar:
            yield Notice((polar[0],), "says where the line ends, and so does to; write one of them")
        elif self.to is None and len(polar) < 2:
            missing = "length" if polar == ["angle"] else "angle" if polar else "to"
            yield Notice((missing,), "missing; write to: [0 mm, -40 mm], or angle: 30 deg and length: 100 mm")
        elif self.to is not None and len(self.to) != len(self.given_start):
            yield Notice(("to",), f"has {len(self.to)} coordinates, from has {len(self.given_start)}")
        elif self.to is not None and math.dist(self.to, self.given_start) < 1e-6:
            yield Notice(("to",), "is the same point as from: the path has no length")

    @property
    def flat(self) -> bool:
        """Whether it has two coordinates: it then lies at the height of the machine's tool point."""
        return len(self.given_start) == 2

    @property
    def start(self) -> Position:
        """First point [m]; the height that is not written is zero."""
        return self._whole(self.given_start)

    @property
    def end(self) -> Position:
        """Last point [m]."""
        if self.to is not None:
            return self._whole(self.to)
        assert self.angle is not None
        assert self.length is not None
        x, y, z = self.start
        return x + self.length * math.cos(self.angle), y + self.length * math.sin(self.angle), z

    @property
    def extent(self) -> float:
        """Length [m]."""
        return math.dist(self.start, self.end) if self.length is None else self.length

    @staticmethod
    def _whole(point: tuple[float, ...]) -> Position:
        return (*point, 0.0) if len(point) == 2 else point  # type: ignore[return-value]


# "from" is a word of Python, and the word for it all the same.
MillLine: Any = create_model(  # type: ignore[call-overload]
    "MillLine",
    __base__=_MillLine,
    __doc__="A straight line of the part, to a point or in a direction.",
    **{
        "from": (
            tuple[Length, ...],
            Field(
                description="where the feed starts; of two coordinates: at the height of the machine's tool point",
                examples=[_FROM], min_length=2, max_length=3,
            ),
        ),
    },
)  # fmt: skip


class MilledPath(CarriedPath):
    """The wall that the mill passes by, in the frame of the part: of the tool centre on a machine, of a robot's tool."""

    line: MillLine | None = Field(
        default=None, description="a straight path",
        examples=[f"{{from: {_FROM}, angle: 30 deg, length: 100 mm}}",
                  "{from: [1900 mm, -150 mm, 800 mm], to: [1900 mm, 150 mm, 800 mm]}"],
    )  # fmt: skip
    tool_axis: Direction | None = Field(  # type: ignore[assignment]
        default=None, description="direction from the motor to the tool tip, for a robot", examples=["[0, 0, -1]"]
    )
    cut_from: Annotated[Length, Usual("0 mm", "500 mm")] | None = Field(
        default=None, description="place on the path at which the cut begins, fully engaged (of a machine); left out: the start",
        examples=["30 mm"], ge=0,
    )  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """A path, a cut that begins on it, and an axis at a right angle to it."""
        if self.tool_axis is not None:
            yield from super().contradictions()
        elif self.line is None and self.arc is None:
            yield Notice(("line",), f"missing; write line: {{from: {_FROM}, angle: 30 deg, length: 100 mm}}")
        if self.line is not None and self.cut_from is not None and self.cut_from >= self.line.extent * (1 - 1e-9):
            yield Notice(
                ("cut_from",), f"is not before the end of the line at {units.show(self.line.extent, 'length')}"
            )

    @property
    def length(self) -> float:
        """Length of the path [m]."""
        return float(self.line.extent) if self.line is not None else super().length


def robot_faults(path: MilledPath) -> Iterator[Notice]:
    """What a robot cannot do with a path, or needs of it."""
    if path.tool_axis is None:
        yield Notice(("path", "tool_axis"), "missing; a robot needs the direction from the motor to the tip, for "
                     "example [0, 0, -1]")  # fmt: skip
    if path.line is not None and path.line.flat:
        yield Notice(("path", "line"), "has two coordinates; a robot needs three: [1900 mm, -150 mm, 800 mm]")
    if path.arc is not None:
        yield Notice(("path", "arc"), "is for a robot that deburrs; a robot mills along a line, the contact of a curved wall "
                     "is not modelled")  # fmt: skip
    if path.cut_from is not None:
        yield Notice(("path", "cut_from"), "is for a machine; a robot is looked at wherever the path goes")


def machine_faults(path: MilledPath) -> Iterator[Notice]:
    """What a machine with its spindle along z cannot do with a path."""
    if path.arc is not None:
        yield Notice(
            ("path", "arc"), "is for a robot that deburrs; a machine takes path.line, path.corner or a program"
        )
    axis = path.tool_axis
    if axis is not None and (axis[2] >= 0.0 or math.hypot(axis[0], axis[1]) > -1e-6 * axis[2]):
        yield Notice(("path", "tool_axis"), "leans; the spindle of this machine stands along z: write [0, 0, -1], or "
                     "leave it out")  # fmt: skip
    if path.line is not None and abs(path.line.end[2] - path.line.start[2]) > 1e-9:
        yield Notice(("path", "line", "to"), "changes height; the mill passes by a wall at one height of the part")
