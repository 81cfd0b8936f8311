"""A rectangular pocket that is cleared by a strategy: its program is made of it."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from cutwise.programs.pocket import STRATEGIES, Rectangle
from cutwise.spec.base import AngularSpeed, Length, Notice, Spec, Speed, Usual

_MM = 1e3
_PER_MINUTE = 60e3


class Pocket(Spec):
    """A rectangular pocket without islands, from z = 0 down, and how it is cleared in one layer."""

    x: tuple[Length, Length] = Field(description="least and greatest x of its walls", examples=["[0 mm, 100 mm]"])
    y: tuple[Length, Length] = Field(description="least and greatest y of its walls", examples=["[0 mm, 60 mm]"])
    depth: Annotated[Length, Usual("0.5 mm", "40 mm")] = Field(
        description="below z = 0, in one layer", examples=["5 mm"], gt=0
    )
    strategy: Literal["contour", "zigzag", "trochoid"] = Field(
        description="contour: passes round the middle from the inside out; zigzag: rows, then round the walls; trochoid: circles "
        "along a slot as wide as the pocket", examples=["contour"],
    )  # fmt: skip
    stepover: Annotated[Length, Usual("0.1 mm", "40 mm")] = Field(
        description="distance of passes or rows, at most; of the centres of circles", examples=["4 mm"], gt=0
    )
    corner_radius: Length = Field(
        default=0.0, description="radius of the centre path in the corners (contour), at most", examples=["5 mm"], ge=0
    )
    feed: Annotated[Speed, Usual("1 mm/s", "500 mm/s")] = Field(
        description="along the passes", examples=["40 mm/s"], gt=0
    )
    plunge_feed: Annotated[Speed, Usual("0.1 mm/s", "50 mm/s")] = Field(
        description="down into the material", examples=["5 mm/s"], gt=0
    )
    spindle_speed: Annotated[AngularSpeed, Usual("500 rpm", "60000 rpm")] = Field(
        description="spindle speed", examples=["8000 rpm"], gt=0
    )
    clearance: Length = Field(
        default=5e-3, description="height at which the tool comes and goes", examples=["5 mm"], gt=0
    )

    def contradictions(self) -> Iterator[Notice]:
        """Sides that run backwards."""
        for side in ("x", "y"):
            low, high = getattr(self, side)
            if low >= high:
                yield Notice((side,), "ends before it begins: write the smaller value first")
        if self.corner_radius and self.strategy != "contour":
            yield Notice(("corner_radius",), f"is of the contour; a {self.strategy} has none")

    def misfits(self, diameter: float) -> Iterator[Notice]:
        """What a tool cannot do here."""
        if self.x[0] >= self.x[1] or self.y[0] >= self.y[1]:
            return
        least = min(self.x[1] - self.x[0], self.y[1] - self.y[0])
        side = "x" if self.x[1] - self.x[0] == least else "y"
        if least <= diameter * (1 + 1e-9):
            yield Notice((side,), f"the pocket is {_mm(least)} wide there, no more than the mill ({_mm(diameter)})")
            return
        circle = 0.5 * (least - diameter)
        if self.strategy == "trochoid" and circle > 0.5 * diameter * (1 + 1e-9):
            yield Notice(
                (side,),
                f"of a trochoid must be at most {_mm(2.0 * diameter)}, two diameters of the mill: a core would stay",
            )
        elif self.strategy == "trochoid" and self.stepover >= min(circle, 0.5 * diameter):
            yield Notice(
                ("stepover",), f"of a trochoid must be below the radius of its circles ({_mm(circle)}) and of the mill"
            )
        elif self.strategy != "trochoid" and self.stepover > diameter * (1 + 1e-9):
            yield Notice(("stepover",), f"is more than the diameter of the mill ({_mm(diameter)}): ridges stay")

    def program(self, diameter: float) -> str:
        """The G-code that clears it with a mill of a diameter [m]."""
        rectangle = Rectangle(
            (_MM * self.x[0], _MM * self.x[1]), (_MM * self.y[0], _MM * self.y[1]), _MM * self.depth, _MM * diameter,
            _MM * self.stepover, _MM * self.corner_radius, _PER_MINUTE * self.feed, _PER_MINUTE * self.plunge_feed,
            self.spindle_speed * 30.0 / math.pi, _MM * self.clearance,
        )  # fmt: skip
        return STRATEGIES[self.strategy](rectangle)


def _mm(value: float) -> str:
    return f"{_MM * value:.4g} mm"
