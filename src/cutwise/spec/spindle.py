"""The compliant spindle: motor on a pivot, held by a ring of pneumatic pistons."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Discriminator, Field, PlainSerializer, WithJsonSchema
from pydantic_core import PydanticCustomError

from cutwise.spec.base import (
    Angle,
    Count,
    Damping,
    Force,
    Inertia,
    Length,
    LibrarySpec,
    Mass,
    Notice,
    Number,
    Power,
    Pressure,
    SmallLength,
    Speed,
    Usual,
)
from cutwise.spec.fields import tag
from cutwise.spec.spindle_solid import SolidBody

Vector = tuple[float, float, float]

_AXES: dict[str, Vector] = {
    sign + axis: tuple(factor * (axis == name) + 0.0 for name in "xyz")  # type: ignore[misc]
    for axis in "xyz"
    for sign, factor in (("", 1.0), ("+", 1.0), ("-", -1.0))
}


def _direction(value: Any) -> Any:
    """``off``, an axis such as ``-y``, or a vector of any length."""
    if value is False or value == "off":
        return "off"
    if isinstance(value, str) and value.strip() in _AXES:
        return _AXES[value.strip()]
    if isinstance(value, list | tuple) and len(value) == 3 and all(_is_number(x) for x in value):
        size = math.hypot(*value)
        if size > 0:
            return tuple(float(x) / size if abs(size - 1.0) > 1e-12 else float(x) for x in value)
    raise PydanticCustomError(
        "direction",
        "expected off, an axis of the process frame such as -y, or a vector such as [0, -1, 0] (x feed, y off the "
        "work, z toward the motor)",
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _axis_name(value: Any) -> Any:
    for name, axis in _AXES.items():
        if value == axis:
            return name
    return list(value) if isinstance(value, tuple) else value


_SCHEMA = {
    "anyOf": [
        {"enum": ["off", *_AXES]},
        {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
    ]
}
Gravity = Annotated[
    Literal["off"] | Vector,
    BeforeValidator(_direction),
    PlainSerializer(_axis_name, when_used="json"),
    WithJsonSchema(_SCHEMA),
]
Friction = Literal["set_valued", "presliding", "none", "regularised"]


class CompliantSpindle(LibrarySpec):
    """Pneumatic compliant spindle with radial compliance: pistons on a common chamber round the motor."""

    library_shelf: ClassVar[str] = "spindles"

    pressure: Annotated[Pressure, Usual("1.2 bar", "6.5 bar")] = Field(
        description="gauge pressure in the chamber", examples=["5 bar"], ge=0
    )
    pistons: Annotated[Count, Usual(5, 12)] = Field(description="number of pistons", examples=[7], ge=3, le=100)
    piston_force: Force = Field(description="force of one piston at the reference pressure", examples=["7.7 N"], gt=0)
    friction_static: Force = Field(
        description="static friction of one piston's seal at the reference pressure", examples=["3.9 N"], ge=0
    )
    friction_dynamic: Force = Field(
        description="dynamic friction of one piston's seal at the reference pressure", examples=["2.8 N"], ge=0
    )
    reference_pressure: Pressure = Field(
        description="gauge pressure at which piston force and friction are given", examples=["5 bar"], gt=0
    )
    friction_preload_fraction: Number = Field(
        description="share of the friction at the reference pressure that remains without pressure",
        examples=[0.3], ge=0, le=1,
    )  # fmt: skip
    friction: Friction = Field(
        description="friction law: set_valued (Coulomb with true stick), presliding (elastic seals), none, "
        "regularised (tanh; creeps, for comparison with multibody programs only)",
        examples=["presliding"],
    )
    breakaway_travel: Annotated[SmallLength, Usual("10 um", "100 um")] | None = Field(
        default=None, description="elastic travel z_s of a seal before it slips (presliding)", examples=["50 um"], gt=0
    )
    stribeck_velocity: Annotated[Speed, Usual("0.1 mm/s", "10 mm/s")] | None = Field(
        default=None,
        description="velocity scale v_s: of the fall from static to dynamic friction (set_valued and presliding; left out: "
        "at once), or of the tanh (regularised)",
        examples=["1 mm/s"], gt=0,
    )  # fmt: skip
    seal_damping: Annotated[Damping, Usual("0 N s/m", "500 N s/m")] | None = Field(
        default=None,
        description="viscous damping of one piston's seal; elastic seals without it can let a climbing mill vibrate "
        "along the feed (left out: none)",
        examples=["50 N s/m"], ge=0,
    )  # fmt: skip
    piston_arm: Annotated[Length, Usual("20 mm", "300 mm")] = Field(
        description="distance l_p from the pivot O to the ring of pistons", examples=["100 mm"], gt=0
    )
    tool_reach: Annotated[Length, Usual("50 mm", "400 mm")] = Field(
        description="distance L_t from the pivot O to the tool tip", examples=["150 mm"], gt=0
    )
    inertia: Annotated[Inertia, Usual("1e-4 kg m^2", "0.1 kg m^2")] = Field(
        description="moment of inertia of motor and tool about O, transverse", examples=["4.1e-3 kg m^2"], gt=0
    )
    mass: Annotated[Mass, Usual("0.1 kg", "5 kg")] | None = Field(
        default=None, description="moving mass (needed for gravity)", examples=["0.6 kg"], gt=0
    )
    centre_of_mass: Length | None = Field(
        default=None, description="distance from O to the centre of the moving mass (needed for gravity)",
        examples=["75 mm"], gt=0,
    )  # fmt: skip
    gravity: Gravity = Field(
        default=(0.0, 0.0, -1.0),
        description="direction of gravity in the process frame at the start of the path (x feed, y off the work, z along "
        "the spindle toward the motor): an axis such as -y for a spindle that lies flat above the edge, a vector, or off; "
        "left out: that of the robot which carries it, else along the spindle, which hangs upright",
        examples=["-y"],
    )
    stroke: Annotated[Length, Usual("1 mm", "20 mm")] = Field(
        description="travel of a piston up to its stop", examples=["5 mm"], gt=0
    )
    piston_azimuth: Angle = Field(description="direction of piston 0, from +x toward +y", examples=["90 deg"])
    solid: SolidBody | None = Field(
        default=None,
        description="the moving body as a solid, from which mass, centre_of_mass and inertia come unless they are "
        "written: sizes of motor, collet and mill, or {step: moving_body.step, density, joint, axis}",
        examples=["{step: moving_body.step, density: 7850 kg/m^3, joint: [0 mm, 0 mm, 0 mm], axis: [0, 0, -1]}"],
    )
    solid_remarks: tuple[str, ...] = Field(
        default=(), description="what was noticed when the solid was worked out (filled in)", examples=["[]"]
    )
    power_rating: Power | None = Field(
        default=None, description="rated power of the motor, for comparison only", examples=["340 W"], gt=0
    )

    def contradictions(self) -> Iterator[Notice]:
        """Friction, friction law and mass that cannot be."""
        if self.friction_static < self.friction_dynamic:
            yield Notice(("friction_static",), "is below friction_dynamic; static friction is the larger one")
        if self.friction == "presliding" and self.breakaway_travel is None:
            yield Notice(("breakaway_travel",), "missing; presliding friction needs it, for example 50 um")
        if self.friction == "regularised" and self.stribeck_velocity is None:
            yield Notice(("stribeck_velocity",), "missing; regularised friction needs it, for example 1 mm/s")
        if self.gravity != "off" and any(self.gravity[:2]):
            for key, example in (("mass", "0.6 kg"), ("centre_of_mass", "75 mm")):
                if getattr(self, key) is None:
                    yield Notice(
                        (key,),
                        f"missing; a weight across the spindle needs it, for example {example}; or write gravity: off",
                    )
        if self.mass is not None and self.centre_of_mass is not None:
            least = self.mass * self.centre_of_mass**2
            if self.inertia < least * (1 - 1e-9):
                yield Notice(
                    ("inertia",),
                    f"{self.inertia:.3g} kg m^2 is less than mass times centre_of_mass squared ({least:.3g} kg m^2), the "
                    f"least that {self.mass:.4g} kg with its centre {1e3 * self.centre_of_mass:.4g} mm from O can have",
                )

    def notices(self) -> Iterator[Notice]:
        """Geometry, friction and law that are possible but unusual."""
        if "gravity" not in self.model_fields_set:
            yield Notice(
                ("gravity",),
                "is not given: on a robot it is that of the base (robot.gravity), else the spindle is taken to hang upright, its "
                "weight along its axis; if it lies across, write the direction (-y: flat above the edge)",
            )
        for text in self.solid_remarks:
            yield Notice(("solid",), text)
        if self.piston_arm >= self.tool_reach:
            yield Notice(("piston_arm",), "is not shorter than tool_reach; usual is between 0.5 and 0.8 of it")
        ratio = self.pressure / self.reference_pressure
        share = self.friction_preload_fraction + (1 - self.friction_preload_fraction) * ratio
        if self.friction != "none" and share * self.friction_static >= ratio * self.piston_force:
            yield Notice(
                ("pressure",), "the static friction of the seals holds the pistons back: the spindle does not re-centre"
            )
        if self.friction == "regularised":
            yield Notice(("friction",), "regularised friction creeps: the edge error drifts to the frictionless answer")

    def unused(self) -> Iterator[Notice]:
        """What the friction law does not ask for; a weight without gravity."""
        law = f"friction is {self.friction}"
        if self.friction != "presliding":
            yield Notice(("breakaway_travel",), f"{law}; seals that give before they slip are presliding")
        if self.friction == "none":
            yield Notice(("stribeck_velocity",), law)
        if self.gravity == "off" and self.solid is None:
            for key in ("mass", "centre_of_mass"):
                yield Notice((key,), "gravity is off, and the inertia is given")


def _kind(value: Any) -> str:
    return "<compliant>" if isinstance(value, dict | CompliantSpindle) else "<rigid>"


Spindle = Annotated[
    Annotated[Literal["rigid"], tag("rigid")] | Annotated[CompliantSpindle, tag("compliant")], Discriminator(_kind)
]
