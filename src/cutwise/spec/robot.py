"""Industrial robots as serial arms with elastic joints."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import Angle, AngularStiffness, Length, LibrarySpec, Mass, Number, Remark, Spec, Usual
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
    limits: tuple[Angle, Angle] = Field(description="lower and upper limit", examples=["[-170 deg, 170 deg]"])

    def contradictions(self) -> Iterator[Remark]:
        """Limits in the wrong order, an axis without length."""
        if self.limits[0] >= self.limits[1]:
            yield Remark(("limits",), "the lower limit is not below the upper one")
        if math.hypot(*self.axis) < 1e-9:
            yield Remark(("axis",), "has no length; write for example [0, 0, 1]")


class Robot(LibrarySpec):
    """A six-axis arm: joints with limits and stiffness, the drill spindle on its flange, and how it swings."""

    library_shelf: ClassVar[str] = "robots"
    either: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("joints", "flange_origin", "flange_rotation", "urdf_remarks"),
        ("urdf", "tip_link"),
    )

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
        description="the six joints from the base, or given by the URDF",
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
    joint_stiffness: Annotated[tuple[AngularStiffness, ...], _PerJoint] = Field(
        description="stiffness of the six joints at their output",
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
    singularity_margin: Number = Field(
        default=0.05,
        description="smallest |sin| of the wrist angle that counts as regular",
        examples=[0.05],
        ge=0,
        lt=1,
    )

    def contradictions(self) -> Iterator[Remark]:
        """Six joints, stiffnesses above zero."""
        if len(self.joints) != AXES:
            yield Remark(("joints",), f"has {len(self.joints)} joints; an arm has six")
        if any(k <= 0 for k in self.joint_stiffness):
            yield Remark(("joint_stiffness",), "every joint needs a stiffness above zero")

    def remarks(self) -> Iterator[Remark]:
        """Traps of URDF files, stiffness in the wrong unit, a pairing of different machines."""
        for text in self.urdf_remarks:
            yield Remark(("urdf",), text)
        low, high = min(self.joint_stiffness), max(self.joint_stiffness)
        if low < 1e4 or high > 5e7:
            odd = low if low < 1e4 else high
            yield Remark(
                ("joint_stiffness",),
                f"{odd:.3g} N m/rad is unusual; usual for arms that drill is 1e5 to 1e7 N m/rad at the joint's output",
            )
        if self.pairing:
            yield Remark(("pairing",), self.pairing)
        if self.joint_angles is not None and isinstance(self.redundancy_angle, str):
            yield Remark(("joint_angles",), f"is not used: the posture is chosen ({self.redundancy_angle})")
