"""A program of a CNC machine, and how it runs through its corners."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import Length, Spec
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
