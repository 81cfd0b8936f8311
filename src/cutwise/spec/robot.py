"""Industrial robots as serial arms with elastic joints."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import (
    Angle,
    AngularCompliance,
    AngularStiffness,
    Compliance,
    Count,
    Length,
    LibrarySpec,
    Mass,
    Notice,
    Number,
    Spec,
    Usual,
)
from cutwise.spec.fields import tag

AXES = 6

Position = tuple[Length, Length, Length]
Angles = tuple[Angle, Angle, Angle]
Direction = tuple[Number, Number, Number]
Choice = Literal["stiffest", "least_skating", "best"]


def _angle_or_choice(value: Any) -> str:
    letters = isinstance(value, str) and value[:1].isalpha()
    return "<choice>" if letters else "<angle>"


RedundancyAngle = Annotated[
    Annotated[Angle, tag("angle")] | Annotated[Choice, tag("choice")], Discriminator(_angle_or_choice)
]
_PerJoint = Field(min_length=AXES, max_length=AXES)
_ARM_STILL_NEEDS = "an arm has six that move on their own"


class Mimic(Spec):
    """How a joint without a motor follows another, as in a URDF."""

    joint: str = Field(description="name of the joint that it follows", examples=["joint_a2"])
    multiplier: Number = Field(default=1.0, description="turn per turn of that joint", examples=[-1])
    offset: Angle = Field(default=0.0, description="angle when that joint is at zero", examples=["0 deg"])


class HeldJoint(Spec):
    """A joint that does not move in this operation: the seventh of a seven-axis arm, the slide of a rail."""

    joint: str = Field(description="name of the joint", examples=["joint_3"])
    angle: Angle | None = Field(default=None, description="where a turning joint is held", examples=["20 deg"])
    position: Length | None = Field(
        default=None, description="where a sliding joint of the URDF is held", examples=["500 mm"]
    )

    def contradictions(self) -> Iterator[Notice]:
        """One place."""
        if (self.angle is None) == (self.position is None):
            yield Notice((), "needs one place: angle for a turning joint, position for a sliding one")


class Linkage(Spec):
    """A joint whose motor sits before another joint and turns it through a parallel linkage, as J3 of many arms."""

    joint: str = Field(description="name of the joint that the linkage turns", examples=["joint_a3"])
    driver: str = Field(description="name of the joint before whose motion the motor stands", examples=["joint_a2"])
    ratio: Number | None = Field(
        default=None,
        description="turn of the joint per turn of the driver while the motor of the joint stands still; left out: a "
        "parallelogram, the link behind the joint keeps its direction",
        examples=[-1],
    )
    limits: tuple[Angle, Angle] | None = Field(
        default=None,
        description="limits of the angle between the two links; the limits of the joint are those of its motor",
        examples=["[-130 deg, -10 deg]"],
    )

    def contradictions(self) -> Iterator[Notice]:
        """Limits in order, two joints, a ratio that turns something."""
        if self.limits is not None and self.limits[0] >= self.limits[1]:
            yield Notice(("limits",), "the lower limit is not below the upper one")
        if self.joint == self.driver:
            yield Notice(("driver",), "is the joint itself")
        if self.ratio == 0.0:
            yield Notice(("ratio",), "0 is no linkage; leave it out")


class Joint(Spec):
    """A turning joint, placed on the link before it as URDF does."""

    name: str = Field(default="", description="name of the joint", examples=["joint_a1"])
    origin: Position = Field(
        description="origin of the joint in the frame of the joint before", examples=["[0 mm, 0 mm, 675 mm]"]
    )
    rotation: Angles = Field(
        default=(0.0, 0.0, 0.0),
        description="roll, pitch and yaw of the joint's frame about the fixed axes of the frame before",
        examples=["[0 deg, 0 deg, 0 deg]"],
    )
    axis: Direction = Field(description="axis of rotation in the joint's frame", examples=["[0, 0, -1]"])
    limits: tuple[Angle, Angle] = Field(
        description="lower and upper limit; with a linkage, of its motor", examples=["[-170 deg, 170 deg]"]
    )
    mimic: Mimic | None = Field(
        default=None, description="the joint has no motor and follows another", examples=["{joint: joint_a2}"]
    )

    def contradictions(self) -> Iterator[Notice]:
        """Limits in the wrong order, an axis without length."""
        if self.limits[0] >= self.limits[1]:
            yield Notice(("limits",), "the lower limit is not below the upper one")
        if math.hypot(*self.axis) < 1e-9:
            yield Notice(("axis",), "has no length; write for example [0, 0, 1]")


class _BodySpring(Spec):
    """One of the ways in which a body of an arm yields."""

    listed: ClassVar[bool] = False

    body: Literal["base", "flange"] | Count = Field(
        description="base, flange, or number of the joint (from 1) whose frame yields after its turn", examples=[1]
    )
    axis: Literal["x", "y", "z"] = Field(description="axis of that frame", examples=["z"])


class TurningBody(_BodySpring):
    """A body of an arm that yields by turning."""

    motion: Literal["rotation"] = Field(description="how it moves", examples=["rotation"])
    value: AngularCompliance = Field(description="compliance", examples=["0.65 urad/(N m)"], ge=0)


class ShiftingBody(_BodySpring):
    """A body of an arm that yields by shifting."""

    motion: Literal["translation"] = Field(description="how it moves", examples=["translation"])
    value: Compliance = Field(description="compliance", examples=["0.16 um/N"], ge=0)


def _motion(value: Any) -> str:
    said = value.get("motion") if isinstance(value, Mapping) else getattr(value, "motion", None)
    return "<translation>" if said == "translation" else "<rotation>"


BodySpring = Annotated[
    Annotated[TurningBody, tag("rotation")] | Annotated[ShiftingBody, tag("translation")], Discriminator(_motion)
]


class LinkWeight(Spec):
    """Mass of a link and where its centre is."""

    mass: Mass = Field(description="mass of the link", examples=["12.7 kg"], ge=0)
    centre: Position = Field(
        description="centre of mass in the frame of the joint that moves the link",
        examples=["[-0.232 m, 0 m, 0.158 m]"],
    )


class JointWaves(Spec):
    """Errors of the angle of a joint that repeat with it: orders 1, 2 ... of sine and cosine."""

    listed: ClassVar[bool] = False

    sine: tuple[Angle, ...] = Field(default=(), description="of sine, from order 1", examples=["[120 urad, -40 urad]"])
    cosine: tuple[Angle, ...] = Field(
        default=(), description="of cosine, from order 1", examples=["[80 urad, 15 urad]"]
    )

    def contradictions(self) -> Iterator[Notice]:
        """As many of both."""
        if len(self.sine) != len(self.cosine):
            yield Notice(("cosine",), f"has {len(self.cosine)} orders, sine has {len(self.sine)}")


Twist = tuple[Length, Length, Length, Angle, Angle, Angle]


class ArmErrors(Spec):
    """Geometric errors of an arm, as cutwise calibrate robot-geometry finds them."""

    bodies: tuple[Twist, ...] = Field(
        default=(),
        description="displacement and rotation of each body after the turn of its joint, in the frame of the joint",
        examples=["[[0.1 mm, 0 mm, -0.2 mm, 0.3 mrad, 0 mrad, 0 mrad]]"],
    )
    joints: tuple[JointWaves, ...] = Field(
        default=(), description="periodic errors of each joint", examples=["[{sine: [120 urad], cosine: [80 urad]}]"]
    )
    gravity_compliance: tuple[AngularCompliance, ...] = Field(
        default=(),
        description="by how much each joint turns under the moment of the links' weights behind it (link_weights)",
        examples=["[0 urad/(N m), 9.4 urad/(N m), 9.4 urad/(N m), 0 urad/(N m), 0 urad/(N m), 0 urad/(N m)]"],
    )
    ranges: tuple[tuple[Angle, Angle], ...] = Field(
        default=(), description="joint angles at which the arm was measured, modulo a turn: beyond them the errors are not known",
        examples=["[[-180 deg, 175 deg]]"],
    )  # fmt: skip
    compensated: bool = Field(
        default=False,
        description="whether the joint angles of the program were found with these errors, so that they are no longer there",
        examples=[True],
    )

    @property
    def of_gravity(self) -> bool:
        """Whether joints that yield under the weight of the links are among the errors."""
        return any(self.gravity_compliance)


class Robot(LibrarySpec):
    """An arm with six motors: joints with limits and stiffness, the drill spindle on its flange, and how it swings."""

    library_shelf: ClassVar[str] = "robots"
    carries: ClassVar[bool] = False  # a tool along a path, with weights of its own
    either: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("joints", "flange_origin", "flange_rotation", "urdf_remarks"),
        ("urdf", "tip_link"),
    )
    instead: ClassVar[Mapping[str, tuple[str, ...]]] = {"body_compliance": ("joint_stiffness", "base_compliance")}

    urdf: str | None = Field(
        default=None, description="URDF file that gives the joints, beside the scenario", examples=["my_robot.urdf"]
    )
    tip_link: str | None = Field(
        default=None,
        description="link of the URDF that carries the tool; left out: the last moving one (not tool0)",
        examples=["flange"],
    )
    urdf_remarks: tuple[str, ...] = Field(
        default=(), description="what is unusual about the URDF; filled in when it is read", examples=["[]"]
    )
    joints: tuple[Joint, ...] = Field(
        description="the joints from the base, or given by the URDF: six, and those that are held or follow others",
        examples=["[{origin: [0 mm, 0 mm, 675 mm], axis: [0, 0, -1], limits: [-170 deg, 170 deg]}]"],
    )
    flange_origin: Position = Field(
        default=(0.0, 0.0, 0.0),
        description="origin of the flange in the frame of the last joint",
        examples=["[0 mm, 0 mm, 0 mm]"],
    )
    flange_rotation: Angles = Field(
        default=(0.0, 0.0, 0.0),
        description="roll, pitch and yaw of the flange in the frame of the last joint",
        examples=["[0 deg, 0 deg, 0 deg]"],
    )
    held_joints: tuple[HeldJoint, ...] = Field(
        default=(),
        description="joints that stand still, at any number above six",
        examples=["[{joint: joint_3, angle: 20 deg}]"],
    )
    linkages: tuple[Linkage, ...] = Field(
        default=(),
        description="joints that are turned from before another joint, through a parallel linkage (J2-J3)",
        examples=["[{joint: joint_a3, driver: joint_a2}]"],
    )
    joint_stiffness: Annotated[tuple[AngularStiffness, ...], Field(min_length=AXES)] | None = Field(
        default=None,
        description="stiffness of the joints at their output, in their order; held ones yield too, followers have none",
        examples=["[3.8e6 N m/rad, 6.6e6 N m/rad, 3.9e6 N m/rad, 5.6e5 N m/rad, 6.6e5 N m/rad, 4.7e5 N m/rad]"],
    )
    pairing: str | None = Field(
        default=None,
        description="what to know about joints and stiffness that come from different machines; shown as a warning",
        examples=["the stiffness was measured on another arm of the series"],
    )
    tool_position: Position = Field(
        description="tip of the drill in the flange frame", examples=["[200 mm, 0 mm, -300 mm]"]
    )
    tool_rotation: Angles = Field(
        description="roll, pitch and yaw of the tool axes (z = feed direction) in the flange frame",
        examples=["[180 deg, 0 deg, 0 deg]"],
    )
    accuracy: Annotated[Length, Usual("0.02 mm", "3 mm")] | None = Field(
        default=None,
        description="position error of the arm itself at the tool, stated or measured: its repeatability for a hole that "
        "is taught, its absolute accuracy for one that is programmed; adds to what the arm yields by",
        examples=["0.5 mm"],
        gt=0,
    )
    payload: Annotated[Mass, Usual("5 kg", "1500 kg")] | None = Field(
        default=None, description="rated payload, for the check of the joint stiffness", examples=["270 kg"], gt=0
    )
    modal_mass: Annotated[Mass, Usual("10 kg", "600 kg")] = Field(
        description="mass that swings at the tool, the same in every direction", examples=["150 kg"], gt=0
    )
    damping: Annotated[Number, Usual(0.01, 0.06)] = Field(
        description="damping ratio of the arm's modes", examples=[0.05], gt=0, lt=1
    )
    redundancy_angle: RedundancyAngle = Field(
        default="best",
        description="angle of the tool about the drill axis, or how to choose it: stiffest, least_skating, or best "
        "(smallest predicted hole error, the larger of entry and exit)",
        examples=["26 deg"],
    )
    joint_angles: Annotated[tuple[Angle, ...], _PerJoint] | None = Field(
        default=None,
        description="posture near which the solution at a given redundancy angle is taken; left out: the stiffest one",
        examples=["[-18 deg, 39 deg, -115 deg, 45 deg, 80 deg, -10 deg]"],
    )
    base_compliance: (
        tuple[Compliance, Compliance, Compliance]
        | tuple[Compliance, Compliance, Compliance, AngularCompliance, AngularCompliance, AngularCompliance]
        | None
    ) = Field(
        default=None,
        description="compliance of the base at its origin: three of translation, or six with rotation",
        examples=["[0.01 um/N, 0.01 um/N, 0.01 um/N]"],
    )
    body_compliance: tuple[BodySpring, ...] | None = Field(
        default=None,
        description="springs of the bodies, instead of joint_stiffness and base_compliance: what cutwise calibrate "
        "robot-stiffness fits with fit.model=bodies",
        examples=["[{body: 1, motion: rotation, axis: z, value: 0.65 urad/(N m)}]"],
    )
    errors: ArmErrors | None = Field(default=None, description="geometric errors of the arm itself, without load")
    link_weights: tuple[LinkWeight, ...] = Field(
        default=(),
        description="masses of the links, one for each joint, under which the joints of errors.gravity_compliance yield",
        examples=["[{mass: 7 kg, centre: [0 m, 0 m, 0 m]}]"],
    )
    gravity: Direction = Field(
        default=(0.0, 0.0, -1.0),
        description="which way is down, in the base frame: for links, tool and a compliant spindle; another one for an arm that "
        "hangs or stands on a wall",
        examples=["[0, 0, -1]"],
    )
    singularity_margin: Number = Field(
        default=0.05,
        description="smallest |sin| of the wrist angle that counts as regular",
        examples=[0.05],
        ge=0,
        lt=1,
    )

    def contradictions(self) -> Iterator[Notice]:
        """Six joints that move on their own, couplings between joints that exist, stiffnesses above zero."""
        yield from self._coupled()
        names = self.names
        doubled = sorted({name for name in names if names.count(name) > 1})
        if doubled:
            yield Notice(("joints",), f"more than one joint is called {', '.join(doubled)}")
        moving = [names[k] for k in self.motors]
        if len(moving) > AXES:
            free = next((name for name in moving[2:] if name), moving[0])
            yield Notice(
                ("joints",),
                f"has {len(moving)} joints that move on their own ({', '.join(moving)}); {_ARM_STILL_NEEDS}: hold the "
                f"others, for example robot.held_joints: [{{joint: {free}, angle: 0 deg}}]",
            )
        elif len(moving) < AXES:
            yield Notice(("joints",), f"has {len(moving)} joints that move on their own; {_ARM_STILL_NEEDS}")
        yield from self._springs()
        yield from self._errors()
        if self.joint_stiffness is None:
            return
        if len(self.joint_stiffness) != len(self.yielding):
            yield Notice(
                ("joint_stiffness",),
                f"has {len(self.joint_stiffness)} values for {len(self.yielding)} joints "
                f"({', '.join(names[k] for k in self.yielding)}); a joint that is held yields too",
            )
        if any(k <= 0 for k in self.joint_stiffness):
            yield Notice(("joint_stiffness",), "every joint needs a stiffness above zero")
        if any(value < 0.0 for value in self.base_compliance or ()):
            yield Notice(("base_compliance",), "a compliance is not below zero")

    def unused(self) -> Iterator[Notice]:
        """Weights that errors do not need, and errors that are said to be gone."""
        if self.errors is None or not self.errors.of_gravity:
            for key in ("link_weights", *(() if self.carries else ("gravity",))):
                yield Notice((key,), "no joint yields under the links (robot.errors.gravity_compliance)")
        if self.errors is not None and self.errors.compensated:
            for key in ("bodies", "joints", "gravity_compliance"):
                yield Notice(("errors", key), "the program was made with it (robot.errors.compensated)")

    def _springs(self) -> Iterator[Notice]:
        """One description of what yields, of bodies that exist."""
        if self.body_compliance is None:
            if self.joint_stiffness is None:
                yield Notice(
                    ("joint_stiffness",), "missing; write the stiffness of each joint, or body_compliance in its place"
                )
            return
        if not any(one.value > 0.0 for one in self.body_compliance):
            yield Notice(("body_compliance",), "nothing yields; write joint_stiffness, or springs above zero")
        for key in ("joint_stiffness", "base_compliance"):
            if getattr(self, key) is not None:
                yield Notice((key,), "is in body_compliance already; write one of them")
        for n, one in enumerate(self.body_compliance):
            if isinstance(one.body, int) and not 1 <= one.body <= len(self.joints):
                yield Notice(
                    ("body_compliance", n, "body"),
                    f"there is no body {one.body}; they are base, 1 to {len(self.joints)}, flange",
                )

    def _errors(self) -> Iterator[Notice]:
        """Errors of each joint, and the weights that they need."""
        if self.link_weights and len(self.link_weights) != len(self.joints):
            message = f"has {len(self.link_weights)} links for {len(self.joints)} joints; write one for each joint"
            yield Notice(("link_weights",), message)
        if math.hypot(*self.gravity) < 1e-9:
            yield Notice(("gravity",), "has no length; write for example [0, 0, -1]")
        if self.errors is None:
            return
        for key in ("bodies", "joints", "gravity_compliance", "ranges"):
            count = len(getattr(self.errors, key))
            if count not in (0, len(self.joints)):
                yield Notice(("errors", key), f"has {count} entries for {len(self.joints)} joints")
        if self.errors.of_gravity and not self.link_weights:
            yield Notice(
                ("link_weights",),
                "missing; errors.gravity_compliance needs the masses of the links, one for each joint",
            )

    @property
    def down(self) -> tuple[float, float, float]:
        """Unit vector of gravity, base axes."""
        long = math.hypot(*self.gravity)
        return self.gravity[0] / long, self.gravity[1] / long, self.gravity[2] / long

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints; one without a name goes by its number."""
        return tuple(joint.name or str(number) for number, joint in enumerate(self.joints, 1))

    @property
    def yielding(self) -> tuple[int, ...]:
        """Joints with a motor or a brake of their own."""
        return tuple(k for k, joint in enumerate(self.joints) if joint.mimic is None)

    @property
    def motors(self) -> tuple[int, ...]:
        """Joints that move on their own."""
        held = {entry.joint for entry in self.held_joints}
        return tuple(k for k in self.yielding if self.names[k] not in held)

    def _coupled(self) -> Iterator[Notice]:
        """Names in held joints, followers and linkages."""
        names, known = self.names, f"the joints are {', '.join(self.names)}"
        own = {names[k] for k in self.motors}
        for n, held in enumerate(self.held_joints):
            if held.position is not None and self.urdf is not None:
                continue  # a slide of the URDF, which is part of the links by now
            if held.joint not in names:
                yield Notice(("held_joints", n, "joint"), f"there is no joint {held.joint}; {known}")
            elif held.angle is None:
                yield Notice(("held_joints", n, "position"), f"joint {held.joint} turns; write angle")
            elif self.joints[names.index(held.joint)].mimic is not None:
                yield Notice(("held_joints", n, "joint"), f"joint {held.joint} follows another and cannot be held")
            else:
                low, high = self.joints[names.index(held.joint)].limits
                if not low <= held.angle <= high:
                    yield Notice(("held_joints", n, "angle"), f"is beyond the limits of joint {held.joint}")
        for n, joint in enumerate(self.joints):
            if joint.mimic is not None and (joint.mimic.joint not in names or joint.mimic.joint == names[n]):
                yield Notice(("joints", n, "mimic"), f"there is no other joint {joint.mimic.joint}; {known}")
            elif joint.mimic is not None and self.joints[names.index(joint.mimic.joint)].mimic is not None:
                yield Notice(("joints", n, "mimic"), f"joint {joint.mimic.joint} follows another itself; name that one")
        for n, linkage in enumerate(self.linkages):
            for key, name in (("joint", linkage.joint), ("driver", linkage.driver)):
                if name not in own:
                    why = "has no motor of its own or is held" if name in names else f"does not exist; {known}"
                    yield Notice(("linkages", n, key), f"joint {name} {why}")
        turned = [linkage.joint for linkage in self.linkages]
        for n, linkage in enumerate(self.linkages):
            if turned.count(linkage.joint) > 1 or linkage.driver in turned:
                yield Notice(("linkages", n), "one linkage for a joint, driven from a joint without one")

    def notices(self) -> Iterator[Notice]:
        """Traps of URDF files, stiffness in the wrong unit, a pairing of different machines."""
        for text in self.urdf_remarks:
            yield Notice(("urdf",), text)
        low, high = min(self.joint_stiffness or (1e5,)), max(self.joint_stiffness or (1e5,))
        if low < 1e4 or high > 5e7:
            odd = low if low < 1e4 else high
            yield Notice(
                ("joint_stiffness",),
                f"{odd:.3g} N m/rad is unusual; usual for arms that drill is 1e5 to 1e7 N m/rad at the joint's output",
            )
        if self.pairing:
            yield Notice(("pairing",), self.pairing)
        if self.joint_angles is not None and isinstance(self.redundancy_angle, str):
            yield Notice(("joint_angles",), f"is not used: the posture is chosen ({self.redundancy_angle})")
