"""Tools by their profile: what a program calls by number, and cuts a stock in 3D with."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from cutwise import units
from cutwise.spec.base import Angle, ByChance, Count, Length, Notice, SmallLength, Spec, Stiffness, Usual
from cutwise.spec.tool import ToolMode, bends_twice

Shape = Literal["flat", "ball", "bull_nose", "taper", "ball_taper", "drill", "chamfer"]

_OF_SHAPE: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = {  # dimensions beside the diameter: needed, possible
    "flat": ((), ()),
    "ball": ((), ()),
    "bull_nose": (("corner_radius",), ()),
    "taper": (("tip_diameter", "half_angle"), ()),
    "ball_taper": (("ball_radius", "half_angle"), ()),
    "drill": (("point_angle",), ("tip_diameter",)),
    "chamfer": (("point_angle",), ("tip_diameter",)),
}
_SAMPLES = {
    "corner_radius": "1 mm", "tip_diameter": "2 mm", "half_angle": "10 deg", "ball_radius": "1 mm", "point_angle": "118 deg",
}  # fmt: skip
_DIMENSIONS = tuple(_SAMPLES)
_REFUSED = "shapes that are wider above than below from inside (lollipop, T-slot, dovetail) cut under the surface"


class Cutter(Spec):
    """A tool of revolution: the profile of its cutting end, its shank and its holder."""

    refused: ClassVar[Mapping[str, str]] = {
        "undercut": f"{_REFUSED}: a height map cannot hold what they leave",
        "neck_diameter": "a neck is given as a point of the holder: holder: [[height above the tip, diameter], ...]",
    }

    number: Count = Field(description="number by which the program calls it (T)", examples=[1], ge=1)
    shape: Shape = Field(
        description="flat, ball, bull_nose (corner_radius), taper (tip_diameter, half_angle), ball_taper (ball_radius, "
        "half_angle), drill and chamfer (point_angle, tip_diameter)",
        examples=["flat"],
    )  # fmt: skip
    diameter: Annotated[Length, Usual("0.1 mm", "200 mm")] = Field(
        description="largest diameter of the cutting end", examples=["10 mm"], gt=0
    )
    flutes: Annotated[Count, Usual(1, 40)] = Field(description="number of teeth", examples=[3], ge=1, le=200)
    helix: Annotated[Angle, Usual("0 deg", "50 deg")] = Field(
        description="helix angle β of a right-hand helix",
        examples=["30 deg"],
        gt=-math.radians(80),
        lt=math.radians(80),
    )
    flute_length: Length | None = Field(
        default=None, description="length of the cutting edges from the tip; left out: no shank is looked at, and the edges "
        "have no end", examples=["20 mm"], gt=0,
    )  # fmt: skip
    corner_radius: Length | None = Field(
        default=None, description="radius of the corner of a bull-nose", examples=["1 mm"], gt=0
    )
    tip_diameter: Length | None = Field(
        default=None, description="diameter of the flat tip of a taper, drill or chamfer tool", examples=["2 mm"], ge=0
    )
    half_angle: Angle | None = Field(
        default=None, description="angle between axis and side of a taper", examples=["10 deg"], gt=0, lt=0.5 * math.pi
    )
    ball_radius: Length | None = Field(
        default=None, description="radius of the ball at the tip of a ball taper", examples=["1 mm"], gt=0
    )
    point_angle: Angle | None = Field(
        default=None,
        description="whole angle of the point of a drill or chamfer tool",
        examples=["118 deg"],
        gt=0,
        lt=math.pi,
    )
    shank_diameter: Length | None = Field(
        default=None, description="diameter above the cutting edges; left out: the shank is not looked at",
        examples=["10 mm"], gt=0,
    )  # fmt: skip
    end_core: Length | None = Field(
        default=None, description="radius inside which bottom edges do not cut (0 mm: they cut over the centre); left out: the "
        "bottom of a flat tip has no force", examples=["0 mm"], ge=0,
    )  # fmt: skip
    runout: Annotated[SmallLength, Usual("0 um", "50 um")] = Field(
        default=0.0, description="run-out ρ: offset of the tool axis from the spindle axis (left out: none)",
        examples=["5 um"], ge=0,
    )  # fmt: skip
    runout_angle: Annotated[Angle, ByChance()] = Field(
        default=0.0, description="direction λ of the run-out, counted from flute 0 in the sense in which the tool turns",
        examples=["0 deg"],
    )  # fmt: skip
    stiffness: Annotated[Stiffness, Usual("0.1 N/um", "100 N/um")] | None = Field(
        default=None, description="static stiffness of the tool at its tip across its axis; left out: rigid",
        examples=["5 N/um"], gt=0,
    )  # fmt: skip
    modes: tuple[ToolMode, ...] = Field(
        default=(), description="vibration modes of the tool tip, which count at rest: F/k",
        examples=["[{direction: y, frequency: 1020 Hz, damping: 0.035, stiffness: 20 N/um}]"],
    )  # fmt: skip
    holder: tuple[tuple[Length, Length], ...] = Field(
        default=(), description="outline of the holder, from below: pairs of height above the tip and diameter",
        examples=["[[45 mm, 20 mm], [70 mm, 40 mm]]"],
    )  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """Dimensions that the shape lacks or does not have; sizes that do not fit one another."""
        needed, possible = _OF_SHAPE[self.shape]
        for key in _DIMENSIONS:
            value = getattr(self, key)
            if key in needed and value is None:
                yield Notice((key,), f"missing; a tool of shape {self.shape} needs it, for example {_SAMPLES[key]}")
            elif value is not None and key not in (*needed, *possible):
                others = ", ".join(shape for shape, (a, b) in _OF_SHAPE.items() if key in (*a, *b))
                yield Notice((key,), f"does not belong to shape {self.shape}; it is for {others}")
        yield from self._size_faults()
        yield from bends_twice(self)
        if self.runout >= 0.5 * self.diameter:
            yield Notice(("runout",), "is as large as the radius of the tool")
        heights = [height for height, _ in self.holder]
        if heights != sorted(heights):
            yield Notice(("holder",), "goes down again: write its points from below, by height above the tip")
        elif self.flute_length is not None and heights and heights[0] < self.flute_length * (1 - 1e-9):
            yield Notice(("holder",), f"begins within the flutes ({_mm(self.flute_length)}, flute_length)")
        if any(diameter <= 0.0 for _, diameter in self.holder):
            yield Notice(("holder",), "has a diameter that is not positive")

    def _size_faults(self) -> Iterator[Notice]:
        radius = 0.5 * self.diameter
        if self.corner_radius is not None and self.corner_radius > radius * (1 + 1e-12):
            yield Notice(("corner_radius",), f"is more than half the diameter ({_mm(radius)}): a ball has no more")
        if self.tip_diameter is not None and self.tip_diameter > self.diameter * (1 + 1e-12):
            yield Notice(("tip_diameter",), f"is more than the diameter ({_mm(self.diameter)})")
        if self.ball_radius is not None and self.half_angle is not None:
            touch = self.ball_radius * math.cos(self.half_angle)
            if touch > radius * (1 + 1e-12):
                yield Notice(
                    ("ball_radius",), f"makes the ball {_mm(2 * touch)} wide where the cone touches it, more than the "
                    f"diameter ({_mm(self.diameter)})",
                )  # fmt: skip
        if self.end_core is not None and self.end_core > radius * (1 + 1e-12):
            yield Notice(("end_core",), f"is more than half the diameter ({_mm(radius)})")
        foot = self.point_height
        if self.flute_length is not None and foot is not None and foot > self.flute_length * (1 + 1e-9):
            yield Notice(
                ("flute_length",), f"ends before the full diameter is reached, {_mm(foot)} above the tip; give the diameter at "
                "the end of the edges",
            )  # fmt: skip

    @property
    def flat_radius(self) -> float:
        """Radius of the flat part of the tip [m], 0 where there is none."""
        if self.shape == "flat":
            return 0.5 * self.diameter
        if self.shape == "bull_nose":
            return 0.5 * self.diameter - (self.corner_radius or 0.0)
        return 0.5 * (self.tip_diameter or 0.0)

    @property
    def point_height(self) -> float | None:
        """Height above the tip at which the full diameter is reached [m]; None if a dimension is missing."""
        radius, tip = 0.5 * self.diameter, 0.5 * (self.tip_diameter or 0.0)
        if self.shape in ("flat", "ball"):
            return 0.0 if self.shape == "flat" else radius
        if self.shape == "bull_nose":
            return self.corner_radius
        half = self.half_angle if self.shape in ("taper", "ball_taper") else 0.5 * (self.point_angle or 0.0)
        if not half:
            return None
        if self.shape == "ball_taper":
            ball = self.ball_radius or 0.0
            return ball * (1.0 - math.sin(half)) + max(radius - ball * math.cos(half), 0.0) / math.tan(half)
        return (radius - tip) / math.tan(half)

    def unused(self) -> Iterator[Notice]:
        """A core of a bottom that is not there, the direction of a run-out that is not there."""
        if not self.runout:
            yield Notice(("runout_angle",), "there is no run-out (runout)")
        if self.flat_radius <= 0.0:
            yield Notice(("end_core",), f"a tool of shape {self.shape} has no flat tip here")

    def notices(self) -> Iterator[Notice]:
        """A shank or holder that cannot be looked at."""
        if self.shank_diameter is not None and self.flute_length is None:
            yield Notice(("shank_diameter",), "begins where the flutes end: without flute_length it is not looked at")


def _mm(value: float) -> str:
    return units.show(value, "length")
