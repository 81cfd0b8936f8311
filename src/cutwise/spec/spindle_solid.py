"""The moving body of a compliant spindle as a solid: mass, centre and inertia follow from it."""

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Discriminator, Field

from cutwise.spec.base import Density, Length, Notice, Spec, Usual
from cutwise.spec.fields import tag


class SpindleSolid(Spec):
    """Sizes of motor, collet, mill and housing, all round and on one axis; the joint O is its origin.

    The motor hangs from the joint, then comes the collet, then the shank, and the flutes end at the tip
    (``tool_reach``). The pistons stand round the motor at ``piston_arm``; they and the housing do not move.
    """

    motor_diameter: Length = Field(description="diameter of the motor", examples=["38 mm"], gt=0)
    motor_length: Length = Field(description="length of the motor, from O towards the tip", examples=["110 mm"], gt=0)
    motor_density: Annotated[Density, Usual("2000 kg/m^3", "8500 kg/m^3")] = Field(
        description="mean density of the motor with what is in it", examples=["4800 kg/m^3"], gt=0
    )
    collet_diameter: Length = Field(description="diameter of the collet", examples=["16 mm"], gt=0)
    collet_length: Length = Field(description="length of the collet below the motor", examples=["20 mm"], ge=0)
    collet_density: Density = Field(description="density of the collet", examples=["7850 kg/m^3"], gt=0)
    shank_diameter: Length = Field(
        description="diameter of the shank between collet and flutes", examples=["6 mm"], gt=0
    )
    mill_diameter: Length = Field(description="diameter of the mill", examples=["8 mm"], gt=0)
    mill_length: Length = Field(description="length of the flutes, up from the tip", examples=["10 mm"], gt=0)
    mill_density: Density = Field(description="density of shank and mill", examples=["14500 kg/m^3"], gt=0)
    piston_diameter: Length = Field(description="diameter of a piston", examples=["4.43 mm"], gt=0)
    housing_gap: Length = Field(description="gap between motor and housing", examples=["8 mm"], gt=0)
    housing_wall: Length = Field(description="wall of the housing", examples=["4 mm"], gt=0)

    def contradictions(self) -> Iterator[Notice]:
        """A collet wider than the motor."""
        if self.collet_diameter > self.motor_diameter:
            yield Notice(("collet_diameter",), "is larger than the motor")


class SpindleStep(Spec):
    """The user's own CAD model of all that tilts about the joint, with one density for all of it."""

    step: str = Field(description="STEP file of the moving body, beside the scenario", examples=["moving_body.step"])
    density: Density = Field(description="mean density of the body", examples=["7850 kg/m^3"], gt=0)
    joint: tuple[Length, Length, Length] = Field(
        description="the joint O in the coordinates of the file", examples=[["0 mm", "0 mm", "0 mm"]]
    )
    axis: tuple[float, float, float] = Field(
        description="direction from the joint to the tool tip in the file", examples=[[0, 0, -1]]
    )

    def contradictions(self) -> Iterator[Notice]:
        """A direction of no length."""
        if not any(self.axis):
            yield Notice(("axis",), "has no direction: write for example [0, 0, -1]")


def _solid_kind(value: Any) -> str:
    if isinstance(value, SpindleStep) or (isinstance(value, dict) and "step" in value):
        return "<step>"
    return "<parametric>"


SolidBody = Annotated[
    Annotated[SpindleSolid, tag("parametric")] | Annotated[SpindleStep, tag("step")], Discriminator(_solid_kind)
]
