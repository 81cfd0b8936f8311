"""What carries the tool along a path: the path in the part, where the part stands, and a robot along it."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, create_model

from cutwise import units
from cutwise.spec.base import Angle, AngularAcceleration, AngularSpeed, Inertia, Length, Mass, Notice, Spec, Usual
from cutwise.spec.fields import tag
from cutwise.spec.robot import AXES, Angles, Direction, Position, Robot

_EXAMPLES = {"from": "[1900 mm, -150 mm, 800 mm]", "to": "[1900 mm, 150 mm, 800 mm]"}


class _Line(Spec):
    """A straight line."""

    def contradictions(self) -> Iterator[Notice]:
        """Two different ends."""
        if self.length < 1e-6:
            yield Notice(("to",), "is the same point as from: the path has no length")

    @property
    def start(self) -> tuple[float, float, float]:
        """First point [m]; Python keeps the word of the scenario for itself."""
        return self.__dict__["from"]  # type: ignore[no-any-return]

    @property
    def end(self) -> tuple[float, float, float]:
        """Last point [m]."""
        return self.__dict__["to"]  # type: ignore[no-any-return]

    @property
    def length(self) -> float:
        """Length [m]."""
        return math.dist(self.start, self.end)


# "from" is a word of Python, and the word for it all the same.
Line: Any = create_model(  # type: ignore[call-overload]
    "Line",
    __base__=_Line,
    __doc__="A straight line between two points of the part.",
    **{
        "from": (Position, Field(description="where the feed starts", examples=[_EXAMPLES["from"]])),
        "to": (Position, Field(description="where it ends", examples=[_EXAMPLES["to"]])),
    },
)


class _Arc(Spec):
    """An arc."""

    @property
    def start(self) -> float:
        """Angle of the first point [rad]."""
        return self.__dict__["from"]  # type: ignore[no-any-return]


Arc: Any = create_model(  # type: ignore[call-overload]
    "Arc",
    __base__=_Arc,
    __doc__="An arc around the work, at a right angle to the tool axis; with the work on the right it runs clockwise.",
    **{
        "centre": (Position, Field(description="centre of the arc", examples=["[1900 mm, 0 mm, 800 mm]"])),
        "radius": (Length, Field(description="radius of the edge", examples=["50 mm"], gt=0)),
        "from": (Angle, Field(description="where it starts, from x of the part to the left", examples=["90 deg"])),
        "sweep": (
            Angle, Field(description="how far it goes round", examples=["180 deg"], gt=0, le=2 * math.pi * (1 + 1e-9)),
        ),
    },
)  # fmt: skip


class CarriedPath(Spec):
    """The nominal edge or wall that the tool is carried along, in the frame of the part."""

    elsewhere: ClassVar[bool] = False  # the part may give line or arc

    line: Line | None = Field(
        default=None, description="a straight path", examples=[f"{{from: {_EXAMPLES['from']}, to: {_EXAMPLES['to']}}}"]
    )
    arc: Arc | None = Field(
        default=None, description="a round edge",
        examples=["{centre: [1900 mm, 0 mm, 800 mm], radius: 50 mm, from: 90 deg, sweep: 180 deg}"],
    )  # fmt: skip
    orientation: Literal["follow", "fixed"] | None = Field(
        default=None,
        description="on an arc: the tool turns with the edge (follow; default with a robot), or keeps its attitude (fixed)",
        examples=["follow"],
    )
    tool_axis: Direction = Field(description="direction from the motor to the tool tip", examples=["[0, 0, -1]"])
    work: Literal["right", "left"] | None = Field(
        default=None,
        description="side of the feed on which the work stands; follows from down (right) or up milling (left)",
        examples=["right"],
    )

    def contradictions(self) -> Iterator[Notice]:
        """A path, and an axis at a right angle to it."""
        if self.line is not None and self.arc is not None:
            yield Notice(("arc",), "a path is a line or an arc; write one of them")
        unknown = self.line is None and self.arc is None
        if unknown and not self.elsewhere:
            yield Notice(("line",), f"missing; write {{from: {_EXAMPLES['from']}, to: {_EXAMPLES['to']}}}, or an arc")
            return
        if self.orientation is not None and self.line is not None:
            yield Notice(("orientation",), "is for arcs: on a line there is nothing to turn with")
        axis = np.array(self.tool_axis)
        if np.linalg.norm(axis) < 1e-9:
            yield Notice(("tool_axis",), "has no length; write for example [0, 0, -1]")
            return
        if self.line is None:
            return
        way = np.subtract(self.line.end, self.line.start)
        lean = abs(float(way @ axis)) / float(np.linalg.norm(way) * np.linalg.norm(axis))
        if lean > 1e-6:
            yield Notice(
                ("tool_axis",),
                f"leans {math.degrees(math.asin(min(1.0, lean))):.3g} deg along the feed; the mill stands at a right "
                "angle to its path",
            )

    @property
    def length(self) -> float:
        """Length of the path [m]."""
        if self.arc is not None:
            return float(self.arc.radius * self.arc.sweep)
        return float(self.line.length) if self.line is not None else 0.0


class PartPath(CarriedPath):
    """The nominal edge that the tool is carried along: given here, or chosen among the edges of a STEP part."""

    elsewhere: ClassVar[bool] = True


class Standing(Spec):
    """Where the part stands in the frame of the robot's base."""

    origin: Position = Field(
        default=(0.0, 0.0, 0.0), description="origin of the part in the base frame", examples=["[0 mm, 0 mm, 0 mm]"]
    )
    rotation: Angles = Field(
        default=(0.0, 0.0, 0.0),
        description="roll, pitch and yaw of the part about the fixed axes of the base",
        examples=["[0 deg, 0 deg, 0 deg]"],
    )


Choice = Literal["best_constant", "along_path"]


def _angle_or_choice(value: Any) -> str:
    letters = isinstance(value, str) and value[:1].isalpha()
    return "<choice>" if letters else "<angle>"


RedundancyAngle = Annotated[
    Annotated[Angle, tag("angle")] | Annotated[Choice, tag("choice")], Discriminator(_angle_or_choice)
]


class Link(Spec):
    """Mass of a link, which hangs on the joint before it."""

    mass: Mass = Field(description="mass of the link", examples=["315 kg"], gt=0)
    centre: Position = Field(
        description="its centre of mass in the frame of its joint", examples=["[575 mm, 0 mm, 0 mm]"]
    )
    inertia: tuple[Inertia, Inertia, Inertia] | tuple[Inertia, Inertia, Inertia, Inertia, Inertia, Inertia] | None = (
        Field(
            default=None,
            description="moments of inertia about its centre, in the axes of the frame of its joint: xx, yy, zz, and the "
            "entries xy, xz, yz of the tensor; left out: a point",
            examples=["[10 kg m^2, 40 kg m^2, 40 kg m^2]"],
        )
    )

    def contradictions(self) -> Iterator[Notice]:
        """Moments of inertia that no body has."""
        if self.inertia is None:
            return
        xx, yy, zz, xy, xz, yz = (*self.inertia, 0.0, 0.0, 0.0)[:6]
        moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if moments[0] < -1e-12 * max(1.0, moments[2]) or moments[2] > (moments[0] + moments[1]) * (1 + 1e-9):
            yield Notice(("inertia",), "is that of no body: each principal moment is at most the sum of the other two")


class CarryingRobot(Robot):
    """A robot that carries its tool along a path."""

    listed: ClassVar[bool] = True
    carries: ClassVar[bool] = True

    redundancy_angle: RedundancyAngle = Field(  # type: ignore[assignment]
        default="best_constant",
        description="angle of the tool about its axis, or how to choose it: best_constant (one for the whole path), or "
        "along_path (turned on the way, which yields least)",
        examples=["0 deg", "along_path"],
    )
    objective: Literal["wall", "stiffness"] = Field(
        default="wall",
        description="what the choice of the angle makes small: the yielding of the surface, or the compliance normal to it",
        examples=["wall"],
    )
    dynamics: Literal["static", "modal", "links"] = Field(
        default="modal",
        description="how the arm answers to the cut: by its joint stiffness alone, as a swinging mass (modal_mass), or by the "
        "masses of its links (links, tool_mass)",
        examples=["static"],
    )
    joint_speed: tuple[AngularSpeed, ...] | None = Field(
        default=None,
        description="largest speed of each joint",
        examples=["[105 deg/s, 101 deg/s, 107 deg/s, 122 deg/s, 113 deg/s, 175 deg/s]"],
        min_length=AXES,
    )
    joint_acceleration: tuple[AngularAcceleration, ...] | None = Field(
        default=None,
        description="largest acceleration of each joint: with operation.limit_feed the feed changes no faster than they let it",
        examples=["[260 deg/s^2, 250 deg/s^2, 270 deg/s^2, 300 deg/s^2, 280 deg/s^2, 440 deg/s^2]"],
        min_length=AXES,
    )
    sag: Literal["ignored", "relative", "absolute"] = Field(
        default="relative",
        description="yielding under the weight of tool and links: ignored, its change along the path (taught at the "
        "start), or all of it",
        examples=["relative"],
    )
    links: tuple[Link, ...] | None = Field(
        default=None, description="masses of the links, one for each joint (library kr270_r2700_masses has them)",
        examples=["[{mass: 315 kg, centre: [175 mm, 0 mm, 0 mm]}]"],
    )  # fmt: skip
    tool_mass: Annotated[Mass, Usual("1 kg", "200 kg")] | None = Field(
        default=None, description="mass of spindle and tool on the flange", examples=["30 kg"], gt=0
    )
    tool_centre: tuple[Length, Length, Length] | None = Field(
        default=None, description="its centre of mass in the flange frame", examples=["[100 mm, 0 mm, -150 mm]"]
    )

    def contradictions(self) -> Iterator[Notice]:
        """What a weight lacks."""
        yield from super().contradictions()
        for key in ("joint_speed", "joint_acceleration"):
            if any(value <= 0.0 for value in getattr(self, key) or ()):
                yield Notice((key,), "every joint needs one above zero")
        if self.links is not None and len(self.links) != len(self.joints):
            yield Notice(("links",), f"has {len(self.links)} links for {len(self.joints)} joints")
        if self.dynamics == "links" and self.links is None:
            yield Notice(("links",), f"missing; {self.library or 'this robot'} has no masses of its links, which dynamics: links "
                         "needs; kr270_r2700_masses has them")  # fmt: skip
        if self.dynamics == "links" and self.body_compliance is not None:
            yield Notice(
                ("dynamics",),
                "links swing on joints: robot.body_compliance gives springs of bodies instead; write modal or static, or "
                "joint_stiffness",
            )
        if (self.tool_mass is None) != (self.tool_centre is None):
            missing = "tool_centre" if self.tool_centre is None else "tool_mass"
            yield Notice((missing,), "missing; mass and centre of the tool go together")

    def notices(self) -> Iterator[Notice]:
        """What the errors of the surface do not hold."""
        yield from super().notices()
        if self.accuracy is not None:
            own = units.show(self.accuracy, "length", 3)
            yield Notice(
                ("accuracy",),
                f"{own} is the error of the arm itself; errors of the surface hold what it yields by, and this adds to them",
            )
        weighs = (
            self.links is not None or self.tool_mass is not None or (self.errors is not None and self.errors.of_gravity)
        )
        if "gravity" in self.model_fields_set and not weighs:
            yield Notice(("gravity",), "counts for a compliant spindle alone: no weight of links or tool is given")
        if self.payload is not None and (self.tool_mass or 0.0) > self.payload:
            rated = units.show(self.payload, "mass")
            yield Notice(("tool_mass",), f"is more than the rated payload of the arm, {rated} (robot.payload)")

    def unused(self) -> Iterator[Notice]:
        """Weights that do not count, a sag without weights, and what is chosen where nothing is left to choose."""
        yield from super().unused()
        if self.payload is not None and self.tool_mass is None:
            yield Notice(("payload",), "it is held against robot.tool_mass, which is not given")
        if self.sag == "ignored" and self.dynamics != "links":
            for key in ("links", "tool_mass", "tool_centre"):
                yield Notice((key,), "robot.sag is ignored")
        elif self.links is None and self.tool_mass is None and self.errors is None:
            yield Notice(("sag",), "no weight of tool or links is given (robot.tool_mass, robot.links)")
        if self.links is not None and self.errors is not None and self.errors.of_gravity:
            yield Notice(
                ("links",), "what the joints yield by under the links is among robot.errors (gravity_compliance)"
            )
        if self.dynamics == "links":
            yield Notice(("modal_mass",), "links have masses of their own (robot.dynamics)")
        else:
            for number in range(len(self.links or ())):
                yield Notice(("links", number, "inertia"), "counts with robot.dynamics: links")
        if not isinstance(self.redundancy_angle, str):
            yield Notice(("objective",), "the angle of the tool is given (robot.redundancy_angle)")


def limited_feed(scenario: Any) -> Iterator[Notice]:
    """A feed that shall be lowered where the joints cannot follow it, in a scenario that may have a robot."""
    operation, robot = scenario.operation, scenario.robot
    if not operation.limit_feed:
        return
    if robot is None:
        yield Notice(
            ("operation", "limit_feed"), "lowers the feed where the joints of a robot cannot follow; there is none"
        )
    elif robot.joint_speed is None:
        yield Notice(("robot", "joint_speed"), "missing; operation.limit_feed needs to know how fast the joints can turn "
                     "(kr270_r2700 has it)")  # fmt: skip
