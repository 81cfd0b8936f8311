"""A program of a CNC machine, how it runs through its corners, and the stock that it cuts."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import Length, Remark, Spec
from cutwise.spec.fields import tag


class Program(Spec):
    """A G-code program."""

    file: str = Field(description="the G-code file", examples=["pocket.nc"])
    text: str = Field(
        default="", description="the text of the program (read from the file)", examples=["G21 G90 G1 X10 F600"]
    )


class Blend(Spec):
    """Corners rounded within a tolerance."""

    blend: Length = Field(description="largest distance from the programmed corner", examples=["0.02 mm"], gt=0)
    shape: Literal["arc", "clothoid"] = Field(
        default="arc",
        description="arc, at whose ends the normal acceleration jumps, or two clothoids, which keep the jerk limit",
        examples=["clothoid"],
    )


def _mode_kind(value: Any) -> str:
    return "<blend>" if isinstance(value, dict | Blend) else "<mode>"


PathMode = Annotated[
    Annotated[Literal["exact_path", "exact_stop"], tag("mode")] | Annotated[Blend, tag("blend")],
    Discriminator(_mode_kind),
]


class StockBlock(Spec):
    """A rectangular block before the first move, in the coordinates of the program."""

    x: tuple[Length, Length] = Field(description="least and greatest x", examples=["[-10 mm, 110 mm]"])
    y: tuple[Length, Length] = Field(description="least and greatest y", examples=["[-10 mm, 70 mm]"])
    z: tuple[Length, Length] = Field(description="bottom and top", examples=["[-20 mm, 0 mm]"])

    def contradictions(self) -> Iterator[Remark]:
        """Sides that run backwards."""
        for side in ("x", "y", "z"):
            low, high = getattr(self, side)
            if low >= high:
                yield Remark((side,), "ends before it begins: write the smaller value first")
