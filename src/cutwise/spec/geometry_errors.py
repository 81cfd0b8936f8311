"""Geometric errors of machine axes by their ISO 230-1 and ISO 230-7 names: tables, polynomials, sines, or drawn."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Field, create_model

from cutwise.spec.base import Angle, Count, Length, Notice, SmallAngle, SmallLength, Spec
from cutwise.spec.fields import tag
from cutwise.spec.tables import Column, Table

LINEAR_AXES = ("X", "Y", "Z")
ROTARY_AXES = ("A", "B", "C")
COMPONENTS = LINEAR_AXES + ROTARY_AXES
SQUARENESS = {"A0Z": ("Z", 0), "B0Z": ("Z", 1), "A0Y": ("Y", 0), "C0Y": ("Y", 2), "B0X": ("X", 1), "C0X": ("X", 2)}
"""Squareness: axis whose motion it turns, and about which direction."""


class TabulatedDisplacement(Table):
    """An error displacement over the command of a linear or rotary axis."""

    over: ClassVar[tuple[Column, ...]] = (Column("position", "length"), Column("angle", "angle"))
    ordinate: ClassVar[Column] = Column("error", "small_length")


class TabulatedRotation(Table):
    """An error rotation over the command of a linear or rotary axis."""

    over: ClassVar[tuple[Column, ...]] = (Column("position", "length"), Column("angle", "angle"))
    ordinate: ClassVar[Column] = Column("error", "small_angle")


class _Periodic(Spec):
    """What errors along an axis have in common: the command over which they repeat or are scaled."""

    wavelength: Length | None = Field(
        default=None, description="command over which it repeats, linear axis", examples=["500 mm"], gt=0
    )
    period: Angle | None = Field(
        default=None, description="command over which it repeats, rotary axis", examples=["360 deg"], gt=0
    )

    @property
    def over(self) -> float:
        """Wavelength or period, SI."""
        return self.wavelength if self.wavelength is not None else self.period or 0.0

    @property
    def rotary(self) -> bool:
        """Whether it is over the command of a rotary axis."""
        return self.period is not None

    def contradictions(self) -> Iterator[Notice]:
        """One of the two."""
        if (self.wavelength is None) == (self.period is None):
            yield Notice((), "give exactly one of wavelength (linear axis) and period (rotary axis)")


class _Sines(_Periodic):
    """Sines of orders 1, 2 ... of the wavelength."""

    phases: tuple[Angle, ...] = Field(description="phase of each order", examples=['["0 deg", "90 deg"]'], min_length=1)

    def contradictions(self) -> Iterator[Notice]:
        """As many phases as amplitudes."""
        yield from super().contradictions()
        count = len(getattr(self, "amplitudes", ()))
        if count != len(self.phases):
            yield Notice(("phases",), f"has {len(self.phases)} entries for {count} amplitudes")


class SineDisplacement(_Sines):
    """A displacement as a sum of sines."""

    amplitudes: tuple[SmallLength, ...] = Field(
        description="amplitude of each order", examples=['["5 um", "2 um"]'], min_length=1
    )


class SineRotation(_Sines):
    """A rotation as a sum of sines."""

    amplitudes: tuple[SmallAngle, ...] = Field(
        description="amplitude of each order", examples=['["20 urad", "8 urad"]'], min_length=1
    )


class _Powers(Spec):
    """A polynomial in the command over a scale."""

    scale: Length | None = Field(
        default=None, description="command that counts as 1, linear axis", examples=["500 mm"], gt=0
    )
    angle_scale: Angle | None = Field(
        default=None, description="command that counts as 1, rotary axis", examples=["90 deg"], gt=0
    )

    @property
    def over(self) -> float:
        """Command that counts as 1, SI."""
        return self.scale if self.scale is not None else self.angle_scale or 0.0

    @property
    def rotary(self) -> bool:
        """Whether it is over the command of a rotary axis."""
        return self.angle_scale is not None

    def contradictions(self) -> Iterator[Notice]:
        """One of the two scales."""
        if (self.scale is None) == (self.angle_scale is None):
            yield Notice((), "give exactly one of scale (linear axis) and angle_scale (rotary axis)")


class PolynomialDisplacement(_Powers):
    """A displacement as a polynomial."""

    polynomial: tuple[SmallLength, ...] = Field(
        description="coefficients of powers 0, 1, 2 ... of command/scale", examples=['["0 um", "5 um"]'], min_length=1
    )


class PolynomialRotation(_Powers):
    """A rotation as a polynomial."""

    polynomial: tuple[SmallAngle, ...] = Field(
        description="coefficients of powers 0, 1, 2 ... of command/scale", examples=['["0 urad", "9 urad"]'],
        min_length=1,
    )  # fmt: skip


class _Drawn(_Periodic):
    orders: Count = Field(default=3, description="number of sines", examples=[3], ge=1, le=50)
    seed: Count = Field(description="seed; the same seed gives the same error", examples=[1], ge=0)


class DrawnDisplacement(_Drawn):
    """A random smooth displacement."""

    deviation: SmallLength = Field(description="standard deviation", examples=["2 um"], ge=0)


class DrawnRotation(_Drawn):
    """A random smooth rotation."""

    deviation: SmallAngle = Field(description="standard deviation", examples=["10 urad"], ge=0)


def _kind(value: Any) -> str:
    given = (
        set(value) if isinstance(value, dict) else set(type(value).model_fields) if isinstance(value, Spec) else set()
    )
    for key, name in (("columns", "table"), ("polynomial", "polynomial"), ("deviation", "random")):
        if key in given:
            return f"<{name}>"
    return "<sines>"


Displacement = Annotated[
    Annotated[SineDisplacement, tag("sines")]
    | Annotated[PolynomialDisplacement, tag("polynomial")]
    | Annotated[DrawnDisplacement, tag("random")]
    | Annotated[TabulatedDisplacement, tag("table")],
    Discriminator(_kind),
]
Rotation = Annotated[
    Annotated[SineRotation, tag("sines")]
    | Annotated[PolynomialRotation, tag("polynomial")]
    | Annotated[DrawnRotation, tag("random")]
    | Annotated[TabulatedRotation, tag("table")],
    Discriminator(_kind),
]

_EXAMPLE = {
    True: "{amplitudes: [5 um], phases: [0 deg], wavelength: 500 mm}",
    False: "{amplitudes: [20 urad], phases: [0 deg], wavelength: 500 mm}",
}


def _motion_fields() -> Iterator[tuple[str, Any]]:
    for axis in COMPONENTS:
        for component in COMPONENTS:
            straight = component in LINEAR_AXES
            words = (
                f"displacement along {component}"
                if straight
                else f"rotation about {'XYZ'[COMPONENTS.index(component) - 3]}"
            )
            kind: Any = Displacement if straight else Rotation
            field = Field(
                default=None, description=f"{words} of the body that axis {axis} moves", examples=[_EXAMPLE[straight]]
            )
            yield f"E{component}{axis}", (kind | None, field)


def _constant_fields() -> Iterator[tuple[str, Any]]:
    for name, (axis, about) in SQUARENESS.items():
        field = Field(default=None, description=f"squareness of axis {axis} about {'XYZ'[about]}", examples=["12 urad"])
        yield name, (SmallAngle | None, field)
    for axis in ROTARY_AXES:
        for component in COMPONENTS:
            straight = component in LINEAR_AXES
            kind: Any = SmallLength if straight else SmallAngle
            words = f"along {component}" if straight else f"about {'XYZ'[COMPONENTS.index(component) - 3]}"
            field = Field(
                default=None,
                description=f"location error of rotary axis {axis}, {words}, before its rotation",
                examples=["8 um" if straight else "12 urad"],
            )
            yield f"{component}O{axis}", (kind | None, field)


class _Named(Spec):
    listed: ClassVar[bool] = False


GeometryErrors: Any = create_model(
    "GeometryErrors",
    __base__=_Named,
    __doc__="""Geometric errors by name: functions of ISO 230-1, squareness, location errors of ISO 230-7.""",
    **dict(_motion_fields()),
    **dict(_constant_fields()),
)
