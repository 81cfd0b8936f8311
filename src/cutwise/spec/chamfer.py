"""The scenario of a chamfer of constant width along the edges of a drilled pipe or of a CAD part."""

import math
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, field_validator

from cutwise import units
from cutwise.spec import needs
from cutwise.spec.base import (
    Angle,
    AngularSpeed,
    Count,
    Length,
    LibrarySpec,
    Notice,
    SmallLength,
    Spec,
    Speed,
    Stiffness,
    Usual,
    contradiction,
)
from cutwise.spec.carrier import CarryingRobot, Standing, limited_feed
from cutwise.spec.cell import ONE_CARRIER
from cutwise.spec.chained import tip_faults, what_yields_alone
from cutwise.spec.fields import tag
from cutwise.spec.material import Material
from cutwise.spec.measures import CHAMFER
from cutwise.spec.milling_machine import ToolMachine, bodies_of
from cutwise.spec.needs import Needs
from cutwise.spec.part import BurrHeight, BurrWidth
from cutwise.spec.scenario import MeasureSpec, Scenario
from cutwise.spec.spindle import CompliantSpindle
from cutwise.spec.tables import Column, Table
from cutwise.spec.tool import ToolMode, bends_twice

_MOST_ON_CAD = 20_000
SELECTORS = (
    "all, outer, inner, closed, open, hole:N, edge:N or edge:N-M, longer:5mm, shorter:5mm, sharper:80deg, blunter:100deg, "
    "facing:+z; joined by commas (any of them), by & (all of them), with ! or not: before one that must not hold"
)
_SELECTOR = re.compile(
    r"(?:!|not:)*(?:all|outer|inner|closed|open|(?:hole|edge):\d+(?:-\d+)?|(?:longer|shorter|sharper|blunter):.+|facing:[+-][xyz])"
)


class Pipe(Spec):
    """A round pipe with one drilled hole; the pipe runs along y, the hole is drilled from +z."""

    radius: Annotated[Length, Usual("2 mm", "500 mm")] = Field(
        description="outer radius R of the pipe", examples=["15 mm"], gt=0
    )
    wall: Length = Field(description="wall thickness t", examples=["2 mm"], gt=0)
    hole_radius: Annotated[Length, Usual("0.5 mm", "100 mm")] = Field(
        description="radius r of the hole", examples=["4 mm"], gt=0
    )
    eccentricity: Length = Field(
        default=0.0, description="distance e of the drill axis from the pipe axis", examples=["0 mm"]
    )
    inclination: Angle = Field(
        default=0.0, description="lean α of the drill axis from the normal of the pipe axis", examples=["0 deg"],
        gt=-math.radians(80), lt=math.radians(80),
    )  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """Walls and holes larger than the pipe."""
        if self.wall >= self.radius:
            yield Notice(("wall",), f"is as thick as the pipe: its radius is {_mm(self.radius)}")
        if self.hole_radius >= self.radius:
            yield Notice(("hole_radius",), f"is larger than the pipe: its radius is {_mm(self.radius)}")


class BlockHole(Spec):
    """A through hole in a block."""

    x: Length = Field(description="centre of the hole on the top face", examples=["20 mm"])
    y: Length = Field(description="centre of the hole on the top face", examples=["15 mm"])
    radius: Length = Field(description="radius", examples=["4 mm"], gt=0)
    inclination: Angle = Field(
        default=0.0, description="lean of the axis from +z towards +y", examples=["0 deg"],
        gt=-math.radians(60), lt=math.radians(60),
    )  # fmt: skip


class Block(Spec):
    """A rectangular block with through holes and, if wanted, a bore along x; it is made and read back as STEP."""

    length: Length = Field(description="size along x, from 0", examples=["60 mm"], gt=0)
    width: Length = Field(description="size along y, from 0", examples=["40 mm"], gt=0)
    height: Length = Field(description="size along z, from 0", examples=["30 mm"], gt=0)
    holes: tuple[BlockHole, ...] = Field(
        default=(),
        description="holes from the top through the block",
        examples=["[{x: 20 mm, y: 20 mm, radius: 4 mm}]"],
    )
    bore_radius: Length | None = Field(
        default=None, description="radius of a bore along x through the middle of the block", examples=["6 mm"], gt=0
    )

    def contradictions(self) -> Iterator[Notice]:
        """Holes that are not inside the block."""
        for i, hole in enumerate(self.holes):
            room = min(hole.x, self.length - hole.x, hole.y, self.width - hole.y) - hole.radius
            if room <= 0.0:
                yield Notice(("holes", i), "is not inside the top face of the block")
        if self.bore_radius is not None and 2.0 * self.bore_radius >= min(self.width, self.height):
            yield Notice(("bore_radius",), "is as large as the block")


class ChamferBurr(Spec):
    """A burr along the edge: a strip of rectangular section on one of its two faces, cut together with the edge."""

    height: BurrHeight = Field(
        description="how far the burr stands off its face: constant, {table: file.csv} over the way w along the edge, "
        "or {mean, deviation, correlation_length, seed}",
        examples=["0.3 mm"],
    )
    width: BurrWidth = Field(
        description="how far it reaches along its face from the edge, as constant, table or random field",
        examples=["0.2 mm"],
    )
    on: Literal["wall", "face"] = Field(
        description="the face that carries it: the wall along the rod (of the hole), or the other one",
        examples=["wall"],
    )


class ChamferPart(Spec):
    """The part, and which of its edges."""

    pipe: Pipe | None = Field(default=None, description="a drilled pipe")
    step: str | None = Field(default=None, description="a STEP file, beside the scenario", examples=["bracket.step"])
    block: Block | None = Field(default=None, description="a drilled block, made and read back as STEP")
    edges: str = Field(
        default="all",
        description="which edges: all, outer or inner; of a CAD part also closed, open, hole:N, edge:N-M, "
        "longer:5mm, shorter:5mm, sharper:80deg, blunter:100deg, facing:+z, joined by commas (any) and & (all), ! for not",
        examples=["inner"],
    )
    burr: ChamferBurr | None = Field(default=None, description="a burr along the edges; it changes the forces")
    stiffness: Annotated[Stiffness, Usual("0.01 N/um", "1000 N/um")] | None = Field(
        default=None, description="stiffness of the part against the tool, off its chamfer; left out: rigid",
        examples=["20 N/um"], gt=0,
    )  # fmt: skip

    @field_validator("edges")
    @classmethod
    def _selects(cls, text: str) -> str:
        """Words that no selector has are told with all other faults, before a part is read."""
        words = [word for term in text.replace(" ", "").split(",") for word in term.split("&")]
        strange = [word for word in words if not _SELECTOR.fullmatch(word)]
        if strange:
            raise contradiction(
                [
                    Notice((), f'"{word}" selects nothing: write inner, outer or all; of a CAD part {SELECTORS}')
                    for word in strange
                ]
            )
        return text

    def contradictions(self) -> Iterator[Notice]:
        """One part, and a selector that fits it."""
        if self.pipe is None and self.step is None and self.block is None:
            yield Notice((), "names no part: write pipe, step or block")
        if self.pipe is not None and (self.step is not None or self.block is not None):
            yield Notice((), "names two parts: keep one of pipe, step and block")
        if self.pipe is not None and self.edges not in ("all", "outer", "inner"):
            yield Notice(("edges",), f'"{self.edges}" is no edge of a pipe; write inner, outer or all')

    def notices(self) -> Iterator[Notice]:
        """A file that stands in for the block."""
        if self.step is not None and self.block is not None:
            yield Notice(("block",), "is not used: part.step names the part")


class ChamferSize(Spec):
    """The chamfer that is wanted."""

    width: Annotated[Length, Usual("0.02 mm", "3 mm")] = Field(
        description="width between the borders of the chamfer, or its leg (see definition)", examples=["0.3 mm"], gt=0
    )
    definition: Literal["chord", "leg"] = Field(
        default="chord",
        description="what the width is: the chord between both borders, or the leg on each face",
        examples=["chord"],
    )
    tier: Literal["tangent", "surface", "envelope"] = Field(
        default="envelope",
        description="how exact the path is: tangent planes, true surfaces, or also the envelope of the moving ball",
        examples=["envelope"],
    )
    tilt: Annotated[Literal["auto"], tag("auto")] | Annotated[Angle, tag("angle")] = Field(
        default="auto",
        description="turns the chamfer away from the rod, towards the hole; auto takes the smallest that is needed",
        examples=["auto"],
    )
    clearance: Length = Field(
        default=0.0, description="distance that the rod keeps from the part", examples=["0.1 mm"], ge=0
    )


class BallEndCutter(LibrarySpec):
    """A ball on a rod, with the knife on a part of the ball."""

    library_shelf: ClassVar[str] = "tools"

    ball_radius: Annotated[Length, Usual("0.2 mm", "20 mm")] = Field(
        description="radius R_B of the ball", examples=["2 mm"], gt=0
    )
    rod_radius: Length = Field(description="radius R_od of the rod", examples=["1.25 mm"], gt=0)
    knife_limit_angle: Angle = Field(
        description="angle β from the rod at which the knife begins; the makers' 360° minus 2β", examples=["38.7 deg"],
        ge=0, lt=math.pi / 2,
    )  # fmt: skip
    pole_limit_angle: Angle = Field(
        default=0.0, description="angle round the pole where the knife does not cut", examples=["0 deg"], ge=0,
        lt=math.pi / 2,
    )  # fmt: skip
    flutes: Count | None = Field(default=None, description="number of flutes", examples=[2], ge=1, le=200)
    helix: Angle | None = Field(default=None, description="lead angle of the knives", examples=["15 deg"])
    axis: Literal["auto", "+x", "-x", "+y", "-y", "+z", "-z"] = Field(
        default="auto",
        description="direction of the rod, away from the ball; auto is the axis of the hole, or the best of six",
        examples=["auto"],
    )

    stiffness: Annotated[Stiffness, Usual("0.1 N/um", "100 N/um")] | None = Field(
        default=None, description="static stiffness of the tool at its tip across the rod; left out: rigid",
        examples=["5 N/um"], gt=0,
    )  # fmt: skip
    modes: tuple[ToolMode, ...] = Field(
        default=(), description="vibration modes of the tool tip, which count at rest: F/k; along x and y of a machine, "
        "otherwise along the two axes across the rod from which piston azimuths count",
        examples=["[{direction: y, frequency: 1020 Hz, damping: 0.035, stiffness: 20 N/um}]"],
    )  # fmt: skip

    def notices(self) -> Iterator[Notice]:
        """What of a mode does not count."""
        if self.modes:
            yield Notice(("modes",), "count by their stiffness alone: the mean force of the cut does not excite them")

    def contradictions(self) -> Iterator[Notice]:
        """A rod that hides the ball; a knife inside the rod; two ways to bend."""
        yield from bends_twice(self)
        if self.rod_radius >= self.ball_radius:
            yield Notice(("rod_radius",), f"is not smaller than the ball ({_mm(self.ball_radius)})")
            return
        neck = math.asin(self.rod_radius / self.ball_radius)
        if self.knife_limit_angle < neck - 1e-9:
            shown = units.show(neck, "angle")
            yield Notice(("knife_limit_angle",), f"begins inside the rod: the rod hides the ball up to {shown}")


class PresetProfile(Table):
    """How much deeper the path is, over the way along the edge from where the path begins; straight lines between places."""

    over: ClassVar[tuple[Column, ...]] = (Column("w", "length", 0.0),)
    ordinate: ClassVar[Column] = Column("preset", "length")

    columns: dict[str, tuple[float, ...]] = Field(
        description="columns by their titles with units; a CSV file named by `table` is read into here",
        examples=['{"w [mm]": [0, 30], "preset [mm]": [0.01, 0.02]}'],
    )


class ChamferOperation(Spec):
    """Feed and speed."""

    either: ClassVar[tuple[tuple[str, ...], ...]] = (("contact_feed",), ("centre_feed",))

    contact_feed: Annotated[Speed, Usual("0.1 mm/s", "200 mm/s")] | None = Field(
        default=None, description="speed of the contact along the edge", examples=["200 mm/min"], gt=0
    )
    centre_feed: Annotated[Speed, Usual("0.1 mm/s", "200 mm/s")] | None = Field(
        default=None, description="speed of the ball centre", examples=["200 mm/min"], gt=0
    )
    spindle_speed: AngularSpeed | None = Field(
        default=None, description="spindle speed; with tool.flutes and material the run has forces",
        examples=["40000 rpm"], gt=0,
    )  # fmt: skip
    retract: Length = Field(
        default=5e-3, description="how far the tool goes clear of the edge", examples=["5 mm"], gt=0
    )
    limit_feed: bool = Field(
        default=False, description="the feed is lowered where the joints of the robot cannot follow it (robot.joint_speed, "
        "joint_acceleration)", examples=[True],
    )  # fmt: skip
    preset: Length = Field(
        default=0.0,
        description="how much deeper than nominal the path is, across the tool axis: for a compliant spindle, whose force "
        "then reaches breakaway; a rigid tool cuts that much deeper",
        examples=["0 mm"],
    )  # fmt: skip
    preset_profile: PresetProfile | None = Field(
        default=None,
        description="what is added to the preset over the way along the edge, as columns or {table: file.csv}; cutwise correct "
        "--change offset writes it",
        examples=['{columns: {"w [mm]": [0, 30], "preset [mm]": [0.01, 0.02]}}'],
    )
    part_error: Length = Field(
        default=0.0,
        description="how much farther than nominal the part stands towards the tool, across its axis; a rigid tool cuts "
        "that much deeper",
        examples=["0 mm"],
    )

    def contradictions(self) -> Iterator[Notice]:
        """One feed."""
        if (self.contact_feed is None) == (self.centre_feed is None):
            yield Notice((), "give exactly one of contact_feed and centre_feed, for example contact_feed: 200 mm/min")


class PathResolution(Spec):
    """How many points the path has."""

    either: ClassVar[tuple[tuple[str, ...], ...]] = (("chord_tolerance",), ("points",))

    chord_tolerance: Annotated[SmallLength, Usual("0.05 um", "50 um")] | None = Field(
        default=None, description="largest distance between path and its chords", examples=["2 um"], ge=1e-8
    )
    points: Annotated[Count, Usual(16, 100_000)] | None = Field(
        default=None, description="number of points, evenly spread", examples=[2880], ge=8, le=100_000
    )

    def contradictions(self) -> Iterator[Notice]:
        """One of them."""
        if (self.chord_tolerance is None) == (self.points is None):
            yield Notice((), "give exactly one of chord_tolerance and points, for example chord_tolerance: 2 um")


class SetupErrors(Spec):
    """Standard deviations of what is not known when the part is clamped; the widths to expect follow from them."""

    position: Length = Field(default=0.0, description="of the part, in each direction", examples=["0.02 mm"], ge=0)
    radius: Length = Field(default=0.0, description="of the radii of pipe and hole", examples=["0.02 mm"], ge=0)
    wall: Length = Field(default=0.0, description="of the wall of a pipe", examples=["0.05 mm"], ge=0)
    angle: Angle = Field(default=0.0, description="of the drill axis of a pipe", examples=["0.1 deg"], ge=0)
    ball_radius: Length = Field(default=0.0, description="of the radius of the ball", examples=["5 um"], ge=0)
    samples: Count = Field(default=5000, description="number of random set-ups", examples=[5000], ge=10, le=1_000_000)
    seed: Count = Field(default=0, description="seed of the random numbers", examples=[0], ge=0)


def _mounting(value: Any) -> str:
    return "<rigid>" if isinstance(value, str) else "<compliant>"


Mounted = Annotated[
    Annotated[CompliantSpindle, tag("compliant")] | Annotated[Literal["rigid"], tag("rigid")], Discriminator(_mounting)
]


class ChamferScenario(Scenario):
    """A chamfer of constant width along the edges of a drilled pipe or a CAD part (Sato et al. 2016)."""

    measures: ClassVar[Mapping[str, MeasureSpec]] = CHAMFER
    needs: ClassVar[Needs] = needs.CHAMFER
    focus: ClassVar[str] = "width_min"
    levers: ClassVar[Mapping[str, tuple[str, str]]] = {
        "chamfer.width": ("0.05 mm", "2 mm"),
        "path.chord_tolerance": ("0.1 um", "20 um"),
        "spindle.pressure": ("1.5 bar", "6.5 bar"),
        "operation.contact_feed": ("1 mm/s", "150 mm/s"),
        "operation.preset": ("0 mm", "1 mm"),
    }
    sound: ClassVar[Mapping[str, float]] = {"rod_clearance_min": -1e-9, "knife_margin_min": -1e-9}
    starts: ClassVar[Mapping[str, str]] = {
        "part.pipe.radius": "15 mm",
        "part.pipe.wall": "2 mm",
        "part.pipe.hole_radius": "4 mm",
        "part.edges": "inner",
        "chamfer.width": "0.3 mm",
        "tool.library": "sato2016",
        "operation.spindle_speed": "20000 rpm",
        "material.library": "deburr_aluminium",
        "operation.contact_feed": "200 mm/min",
        "path.points": "720",
        "requirements": "{width_min: {min: 0.295 mm}, width_max: {max: 0.305 mm}, gouge_max: {max: 2 um}}",
    }

    def turned(self) -> Mapping[str, tuple[str, str]]:
        """A rigid spindle has no pressure."""
        idle = set() if self.compliant is not None else {"spindle.pressure"}
        return {key: ends for key, ends in self.levers.items() if key not in idle}

    def unasked(self) -> int:
        """A path on a CAD part, or a spindle that yields, takes half a second a run."""
        return 10 if self.part.step is not None or self.part.block is not None or self.compliant is not None else 40

    process: Literal["chamfer"] = Field(description="which operation is simulated", examples=["chamfer"])
    part: ChamferPart = Field(description="the part and its edges")
    chamfer: ChamferSize = Field(description="the chamfer")
    tool: BallEndCutter = Field(description="the cutter")
    operation: ChamferOperation = Field(description="feed and speed")
    path: PathResolution = Field(description="how fine the path is")
    material: Material | None = Field(default=None, description="cutting coefficients: gives forces")
    spindle: Mounted | None = Field(
        default=None, description="a compliant spindle, which gives the width under deflection, or rigid",
        examples=["{library: berselli2016}"],
    )  # fmt: skip
    robot: CarryingRobot | None = Field(default=None, description="a robot that carries the tool along the paths")
    machine: ToolMachine | None = Field(
        default=None,
        description="a machine tool that carries the tool along the paths: bodies that yield, feed drives, or both",
    )
    placement: Standing | None = Field(
        default=None, description="where the part stands before the robot, or in the frame of the part of the machine"
    )
    setup: SetupErrors | None = Field(default=None, description="uncertainty of the set-up")

    def contradictions(self) -> Iterator[Notice]:
        """Widths larger than the tool; a tilt with legs; a spindle without forces."""
        chord = self.chamfer.width
        if self.chamfer.definition == "chord" and chord >= 2.0 * self.tool.ball_radius:
            yield Notice(
                ("chamfer", "width"),
                f"is larger than the tool: the ball has a diameter of {_mm(2 * self.tool.ball_radius)}",
            )
        if self.chamfer.definition == "leg":
            if chord >= self.tool.ball_radius:
                yield Notice(
                    ("chamfer", "width"), f"is a leg larger than the radius of the ball ({_mm(self.tool.ball_radius)})"
                )
            if self.chamfer.tilt not in ("auto", 0.0):
                yield Notice(("chamfer", "tilt"), "changes the legs: use it with definition: chord, or leave it out")
        yield from self._carrier_faults()
        if self.compliant is not None and not self.has_forces:
            yield Notice(
                ("spindle",), "needs forces to yield to: give material, operation.spindle_speed and tool.flutes"
            )
        if self.part.pipe is None and (self.path.points or 0) > _MOST_ON_CAD:
            yield Notice(
                ("path", "points"), f"is more than {_MOST_ON_CAD} points, the most along an edge of a CAD part"
            )

    def _carrier_faults(self) -> Iterator[Notice]:
        """Two carriers, one without forces to yield to, a robot whose turning tool would turn the pistons."""
        robot, machine = self.robot, self.machine
        if robot is not None and machine is not None:
            yield Notice(("robot",), ONE_CARRIER)
        bodies = bodies_of(machine)
        if bodies is not None:
            yield from tip_faults(bodies)
        if robot is None and machine is None and self.placement is not None:
            yield Notice(("placement",), "has nothing to place: there is no robot and no machine")
        for key, there in (
            (("robot",), robot is not None), (("machine",), machine is not None),
            (("tool", "stiffness"), self.tool.stiffness is not None), (("tool", "modes"), bool(self.tool.modes)),
            (("part", "stiffness"), self.part.stiffness is not None),
        ):  # fmt: skip
            if there and not self.has_forces:
                yield Notice(key, "needs forces to yield to: give material, operation.spindle_speed and tool.flutes")
        yield from limited_feed(self)
        if robot is None:
            return
        if self.compliant is not None and robot.redundancy_angle == "along_path":
            yield Notice(
                ("robot", "redundancy_angle"),
                "along_path would turn the pistons with the tool, which is not modelled along a chamfer; write "
                "best_constant or an angle, or spindle: rigid",
            )

    @property
    def compliant(self) -> CompliantSpindle | None:
        """The spindle, if it yields."""
        return self.spindle if isinstance(self.spindle, CompliantSpindle) else None

    @property
    def yields(self) -> bool:
        """Whether anything yields to the forces."""
        return self.has_forces and (self.compliant is not None or self.carried)

    @property
    def carried(self) -> bool:
        """Whether a carrier, the tool or the part yields, besides the spindle."""
        there = (self.robot, self.machine, self.tool.stiffness, self.part.stiffness)
        return any(one is not None for one in there) or bool(self.tool.modes)

    @property
    def has_forces(self) -> bool:
        """Whether everything that cutting forces need is given."""
        return None not in (self.material, self.operation.spindle_speed, self.tool.flutes)

    def _chip_notices(self) -> Iterator[Notice]:
        """Chips for which the coefficients do not hold; no chip is thicker than the feed per tooth."""
        feed = self.operation.contact_feed or self.operation.centre_feed
        if self.has_forces and feed is not None:
            assert self.material is not None
            assert self.operation.spindle_speed is not None
            assert self.tool.flutes is not None
            chip = 2.0 * math.pi * feed / (self.operation.spindle_speed * self.tool.flutes)
            if beyond := self.material.beyond(chip):
                yield Notice(("material",), beyond)

    def unused(self) -> Iterator[Notice]:
        """What forces averaged over a tooth do not ask for; the group of the material."""
        yield from super().unused()
        if self.robot is not None and not self.operation.limit_feed:
            yield Notice(("robot", "joint_acceleration"), "it counts with operation.limit_feed")
        yield Notice(("tool", "helix"), "the forces of the ball are averaged over a tooth, whatever its helix")
        if self.material is not None:
            yield Notice(("material", "group"), "deburring alone holds its cutting speed against that of the group")

    def notices(self) -> Iterator[Notice]:
        """Half of what forces need; coefficients that do not hold."""
        yield from self._chip_notices()
        bodies = bodies_of(self.machine)
        if bodies is not None:
            yield from what_yields_alone(bodies)
        given = [self.material is not None, self.operation.spindle_speed is not None, self.tool.flutes is not None]
        if any(given) and not all(given):
            yield Notice((), "forces need all of material, operation.spindle_speed and tool.flutes: none are reported")
        if self.part.burr is not None and not self.has_forces:
            yield Notice(("part", "burr"), "changes nothing without forces: give material, spindle speed and flutes")
        if (
            self.part.pipe is None
            and self.setup is not None
            and (self.setup.wall or self.setup.angle or self.setup.radius)
        ):
            yield Notice(("setup",), "radius, wall and angle apply to a pipe only; position and ball_radius are used")


def _mm(value: float) -> str:
    return units.show(value, "length")
