"""A machine tool as a chain of bodies from the part to the tool, with joints, elastic elements, weights and errors."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from cutwise.spec.base import (
    Angle,
    AngularStiffness,
    Area,
    Elasticity,
    Force,
    Length,
    LibrarySpec,
    Notice,
    Number,
    Pressure,
    SmallLength,
    Spec,
    Stiffness,
    Usual,
)
from cutwise.spec.geometry_errors import GeometryErrors

Place = tuple[Length, Length, Length]
Stiffnesses = tuple[Stiffness, Stiffness, Stiffness]

_PadStiffness = Annotated[Stiffness, Usual("1 N/um", "20000 N/um")]


class Drive(Spec):
    """A feed drive: its stiffness is spread in equal parts over the pads, so that it adds to the yaw stiffness."""

    direction: Literal["x", "y", "z"] = Field(description="direction of travel", examples=["x"])
    stiffness: _PadStiffness = Field(description="axial stiffness of the whole drive", examples=["100 N/um"], gt=0)


class PadGroup(Spec):
    """Carriages or pads as springs; any three off one line hold a body."""

    points: tuple[Place, ...] = Field(
        description="pads relative to the element's place",
        examples=["[[90 mm, 100 mm, 0 mm], [90 mm, -100 mm, 0 mm], [-90 mm, 0 mm, 0 mm]]"],
        min_length=1,
    )
    stiffness: Stiffnesses = Field(
        description="springs of one pad along x, y, z", examples=["[0 N/um, 200 N/um, 300 N/um]"]
    )
    drive: Drive | None = Field(
        default=None, description="feed drive", examples=["{direction: x, stiffness: 100 N/um}"]
    )


class ContactGroup(Spec):
    """Sliding pads with the contact law δ = c p^m (Levina and Reshetov), preloaded."""

    points: tuple[Place, ...] = Field(
        description="pads relative to the element's place",
        examples=["[[90 mm, 100 mm, 0 mm], [90 mm, -100 mm, 0 mm], [-90 mm, 0 mm, 0 mm]]"],
        min_length=1,
    )
    normal: Literal["+x", "-x", "+y", "-y", "+z", "-z"] = Field(
        description="from the body that supports to the one that moves", examples=["+z"]
    )
    tangential: Stiffnesses = Field(
        description="springs of one pad along x, y, z; 0 along the normal", examples=["[50 N/um, 50 N/um, 0 N/um]"]
    )
    drive: Drive | None = Field(
        default=None, description="feed drive", examples=["{direction: x, stiffness: 100 N/um}"]
    )
    area: Area = Field(description="area of one pad", examples=["5000 mm^2"], gt=0)
    coefficient: SmallLength = Field(description="c: approach at a pressure of 1 MPa", examples=["10 um"], gt=0)
    exponent: Annotated[Number, Usual(0.3, 1.0)] = Field(
        description="m of the contact law, about 0.5", examples=[0.5], gt=0, le=1
    )
    preload: Annotated[Pressure, Usual("0.2 bar", "50 bar")] = Field(
        description="pressure without load", examples=["4 bar"], gt=0
    )
    closed_guide: bool = Field(description="an equal pad behind each one (gib)", examples=[True])


class Springs(Spec):
    """Springs without coupling: a joint, a bearing."""

    stiffness: Stiffnesses = Field(description="along x, y, z", examples=["[200 N/um, 200 N/um, 250 N/um]"])
    angular_stiffness: tuple[AngularStiffness, AngularStiffness, AngularStiffness] = Field(
        description="about x, y, z", examples=["[1e6 N m/rad, 1e6 N m/rad, 1e6 N m/rad]"]
    )


class Beam(Spec):
    """A Timoshenko cantilever from the previous body; the element's place is its free end."""

    section: Literal["box", "block", "round"] = Field(description="cross-section", examples=["box"])
    width_x: Length | None = Field(default=None, description="outer width in x", examples=["220 mm"], gt=0)
    width_y: Length | None = Field(default=None, description="outer width in y", examples=["260 mm"], gt=0)
    wall: Length | None = Field(default=None, description="wall of a box", examples=["15 mm"], gt=0)
    diameter: Length | None = Field(default=None, description="diameter of a round beam", examples=["80 mm"], gt=0)
    length: Length = Field(description="length along z", examples=["515 mm"], gt=0)
    youngs_modulus: Elasticity = Field(description="Young's modulus", examples=["120 kN/mm^2"], gt=0)
    poisson_ratio: Annotated[Number, Usual(0.2, 0.35)] = Field(
        description="Poisson's ratio", examples=[0.26], gt=-1, lt=0.5
    )
    shear_factor: Number = Field(description="share of the section that carries shear", examples=[0.5], gt=0, le=1)
    hangs: bool = Field(description="goes along -z instead of +z", examples=[False])

    def contradictions(self) -> Iterator[Notice]:
        """The sizes that the section needs, and a wall that fits."""
        needed = {"box": ("width_x", "width_y", "wall"), "block": ("width_x", "width_y"), "round": ("diameter",)}
        for key in needed[self.section]:
            if getattr(self, key) is None:
                yield Notice((key,), "missing")
        for key in ("width_x", "width_y", "wall", "diameter"):
            if getattr(self, key) is not None and key not in needed[self.section]:
                yield Notice((key,), f"is no size of a {self.section}; it has {', '.join(needed[self.section])}")
        widths = [width for width in (self.width_x, self.width_y) if width is not None]
        if self.section == "box" and self.wall is not None and widths and 2 * self.wall >= min(widths):
            yield Notice(("wall",), "is thicker than half of the box")


class ElasticElement(Spec):
    """What yields at a joint, at a place that travels with one of its two bodies."""

    either: ClassVar[tuple[tuple[str, ...], ...]] = (("pads",), ("contact",), ("springs",), ("beam",), ("compliance",))

    name: str = Field(description="name in the budget", examples=["x guide"])
    at: Place = Field(
        description="where it acts, in the frame of the body it travels with", examples=["[0 mm, 0 mm, 0 mm]"]
    )
    travels_with: str | None = Field(
        default=None, description="this body (left out) or the previous one of the chain", examples=["saddle"]
    )
    pads: PadGroup | None = Field(default=None, description="carriages or pads as springs")
    contact: ContactGroup | None = Field(default=None, description="sliding pads with the contact law")
    springs: Springs | None = Field(default=None, description="springs without coupling")
    beam: Beam | None = Field(default=None, description="a cantilever")
    compliance: tuple[tuple[Number, ...], ...] | None = Field(
        default=None, description="6 x 6 compliance in m, rad over N, N m", examples=["[[5e-9, 0, 0, 0, 0, 0]]"]
    )


class Joint(Spec):
    """How a body sits on the previous one of the chain (towards the part)."""

    kind: Literal["fixed", "prismatic", "revolute"] = Field(description="kind of joint", examples=["prismatic"])
    side: Literal["part", "tool"] = Field(
        description="part: the previous body is carried by this one (tables); tool: this one by the previous one",
        examples=["tool"],
    )
    offset: Place = Field(
        description="origin of this body's frame in the frame of the previous one, at zero",
        examples=["[0 mm, 0 mm, 42 mm]"],
    )
    rotation: tuple[Angle, Angle, Angle] | None = Field(
        default=None, description="fixed roll, pitch, yaw of this body's frame", examples=["[0 deg, 0 deg, 90 deg]"]
    )
    axis: tuple[Number, Number, Number] | None = Field(
        default=None, description="direction in which the body that moves goes, or about which it turns",
        examples=["[1, 0, 0]"],
    )  # fmt: skip
    command: Literal["X", "Y", "Z", "A", "B", "C"] | None = Field(
        default=None, description="ISO 841 letter of the axis", examples=["X"]
    )
    positive: Literal["table", "tool"] | None = Field(
        default=None,
        description="part side: commands and errors are those of the table, or those of the tool against it",
        examples=["table"],
    )
    errors_act: Literal["after", "before"] = Field(
        default="after",
        description="error motions of this axis (E.., not the constant location errors) act after its motion, in the "
        "frame that moves, or before it, in the frame that stands, as rotary axes are measured",
        examples=["before"],
    )
    travel: tuple[Length, Length] | None = Field(
        default=None, description="least and greatest command of a prismatic joint", examples=["[-200 mm, 200 mm]"]
    )
    turn: tuple[Angle, Angle] | None = Field(
        default=None, description="least and greatest command of a revolute joint", examples=["[-110 deg, 110 deg]"]
    )

    @property
    def limits(self) -> tuple[float, float] | None:
        """Least and greatest command, SI."""
        return self.travel if self.kind == "prismatic" else self.turn if self.kind == "revolute" else None


class Body(Spec):
    """A body of the chain; the first one is the part, which has no previous body."""

    name: str = Field(description="name, also in measures", examples=["table"], pattern=r"^[A-Za-z][A-Za-z0-9_]*$")
    parent: str | None = Field(
        default=None, description="previous body of the chain, towards the part", examples=["part"]
    )
    joint: Joint | None = Field(default=None, description="how it sits on the previous body")
    elements: tuple[ElasticElement, ...] = Field(default=(), description="what yields at this joint", examples=["[]"])
    weight: Force | None = Field(default=None, description="weight", examples=["220 N"], ge=0)
    weight_at: Place | None = Field(
        default=None, description="centre of mass in the body's frame", examples=["[0 mm, 0 mm, -50 mm]"]
    )


class Machine(LibrarySpec):
    """A machine tool from the library, or written out as a chain."""

    library_shelf: ClassVar[str] = "machines"

    chain: tuple[Body, ...] = Field(description="bodies from the part to the tool", examples=["[{name: part}]"])
    gravity: tuple[Number, Number, Number] = Field(
        description="direction of weights in the frame of the bed", examples=["[0, 0, -1]"]
    )
    geometry_errors: GeometryErrors | None = Field(
        default=None, description="geometric errors of its axes by ISO 230-1 names"
    )

    @property
    def ordered(self) -> tuple[Body, ...]:
        """The bodies from the part to the tool, by their parents."""
        by_parent = {body.parent: body for body in self.chain}
        found: list[Body] = []
        here = by_parent.get(None)
        while here is not None and len(found) <= len(self.chain):
            found.append(here)
            here = by_parent.get(here.name)
        return tuple(found)

    @property
    def ground(self) -> int:
        """Place of the body at rest in the chain: the last one on the part side."""
        sides = [body.joint.side for body in self.ordered[1:] if body.joint is not None]
        return sides.count("part")

    def axes(self) -> dict[str, Joint]:
        """The moving joints by their letters."""
        return {
            body.joint.command: body.joint
            for body in self.chain
            if body.joint is not None and body.joint.command is not None
        }


def stiffnesses(machine: Machine) -> Iterator[tuple[int, int, str]]:
    """Body, element and key of what makes the elements of a chain stiff, where it is written as such."""
    for body, of_body in enumerate(machine.chain):
        for element, given in enumerate(of_body.elements):
            if given.pads is not None:
                yield body, element, "pads.stiffness"
            if given.springs is not None:
                yield body, element, "springs.stiffness"
                yield body, element, "springs.angular_stiffness"


def merged_errors(machine: Machine, own: Any) -> dict[str, Any]:
    """Geometric errors that count: the scenario's, and those of the machine that it does not name."""
    found: dict[str, Any] = {}
    for errors in (machine.geometry_errors, own):
        if errors is not None:
            found |= {name: value for name in type(errors).model_fields if (value := getattr(errors, name)) is not None}
    return found


def gantry() -> Machine:
    """Three axes X, Y and Z along those of the part, which yield nowhere and go anywhere: where a tool is led, and no more."""
    bodies = [Body.model_construct(name="part")]
    for letter, axis in zip("XYZ", ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), strict=True):
        joint = Joint.model_construct(
            kind="prismatic", side="tool", offset=(0.0, 0.0, 0.0), axis=axis, command=letter, travel=(-1e6, 1e6)
        )
        bodies.append(Body.model_construct(name=f"axis_{letter}", parent=bodies[-1].name, joint=joint))
    return Machine.model_construct(chain=tuple(bodies), gravity=(0.0, 0.0, -1.0))
