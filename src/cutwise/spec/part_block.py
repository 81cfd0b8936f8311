"""The part as it yields: a block that stands on its clamping on a machine tool, or one stiffness."""

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Discriminator, Field

from cutwise.spec.base import Elasticity, Force, Length, Notice, Number, Spec, Stiffness, Usual
from cutwise.spec.fields import tag


class PartBlock(Spec):
    """The part: a block standing on its clamping, its frame in the middle of its lower face."""

    width_x: Length = Field(description="size in x", examples=["260 mm"], gt=0)
    width_y: Length = Field(description="size in y", examples=["90 mm"], gt=0)
    height: Length = Field(description="size in z", examples=["300 mm"], gt=0)
    weight: Force = Field(description="weight, at half its height", examples=["540 N"], ge=0)
    flexible: bool = Field(description="bends under the reaction to the cutting force", examples=[True])
    youngs_modulus: Elasticity | None = Field(
        default=None, description="Young's modulus", examples=["210 kN/mm^2"], gt=0
    )
    poisson_ratio: Annotated[Number, Usual(0.2, 0.4)] | None = Field(
        default=None, description="Poisson's ratio", examples=[0.3], gt=-1, lt=0.5
    )
    shear_factor: Number | None = Field(
        default=None, description="share of the section that carries shear", examples=[0.8333333], gt=0, le=1
    )

    def contradictions(self) -> Iterator[Notice]:
        """What a flexible part needs."""
        for key in ("youngs_modulus", "poisson_ratio", "shear_factor"):
            if self.flexible and getattr(self, key) is None:
                yield Notice((key,), "missing")


class PartSpring(Spec):
    """The part as one stiffness, wherever it stands."""

    stiffness: Annotated[Stiffness, Usual("0.01 N/um", "1000 N/um")] = Field(
        description="stiffness of the part against the tool, off its wall", examples=["20 N/um"], gt=0
    )


def _part_kind(value: Any) -> str:
    written = value if isinstance(value, dict) else {}
    return "<spring>" if isinstance(value, PartSpring) or "stiffness" in written else "<block>"


YieldingPart = Annotated[
    Annotated[PartBlock, tag("block")] | Annotated[PartSpring, tag("spring")], Discriminator(_part_kind)
]
