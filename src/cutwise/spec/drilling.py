"""The scenario of drilling with a robot: one hole, or a pattern of holes."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from cutwise import units
from cutwise.spec import needs
from cutwise.spec.base import (
    Angle,
    AngularSpeed,
    Count,
    FeedPerRevolution,
    Length,
    LibrarySpec,
    Notice,
    Number,
    Spec,
    Stiffness,
    Stress,
    Time,
    Usual,
)
from cutwise.spec.cell import ONE_CARRIER, REFUSED
from cutwise.spec.chained import CarryingMachine, block_faults, tip_faults, what_yields_alone
from cutwise.spec.measures import DRILLING
from cutwise.spec.needs import Needs
from cutwise.spec.part_block import PartBlock
from cutwise.spec.robot import Direction, Position, Robot
from cutwise.spec.scenario import MeasureSpec, Scenario


class Drill(LibrarySpec):
    """A twist drill with two lips."""

    refused: ClassVar[Mapping[str, str]] = {
        "modes": REFUSED["drill", "tip_modes"],
        "stiffness": REFUSED["drill", "tip"],
    }

    library_shelf: ClassVar[str] = "drills"

    diameter: Annotated[Length, Usual("1 mm", "32 mm")] = Field(description="diameter D", examples=["6 mm"], gt=0)
    point_angle: Annotated[Angle, Usual("100 deg", "150 deg")] = Field(
        description="full angle of the drill point", examples=["118 deg"], gt=math.radians(10), lt=math.radians(180)
    )
    chisel_radius: Length = Field(
        description="half the chisel edge r_a: the work is indented inside and cut outside", examples=["0.5 mm"], gt=0
    )
    web: Length = Field(
        description="web offset w: distance of a lip from the parallel plane through the axis", examples=["0.45 mm"],
        ge=0,
    )  # fmt: skip
    helix: Annotated[Angle, Usual("10 deg", "45 deg")] = Field(
        description="helix angle at the outer diameter", examples=["30 deg"], ge=0, lt=math.radians(80)
    )
    rake: Annotated[Angle, Usual("0 deg", "30 deg")] = Field(
        description="rake angle of the lips (mean along the lip)", examples=["15 deg"], gt=-math.radians(60),
        lt=math.radians(60),
    )  # fmt: skip
    chisel_rake: Annotated[Angle, Usual("-70 deg", "-30 deg")] = Field(
        description="rake angle of the chisel edge", examples=["-50 deg"], gt=-math.radians(85), le=0
    )
    lip_model: Literal["simple", "oblique"] = Field(
        default="simple",
        description="simple: lips through the axis with one rake; oblique: web offset and rake along the lip, for "
        "coefficients calibrated with it",
        examples=["simple"],
    )
    margin_width: Length = Field(description="width of a margin", examples=["0.4 mm"], ge=0)
    margin_length: Length = Field(description="length over which a margin rubs", examples=["3 mm"], ge=0)
    flute_length: Length = Field(description="length that can drill, from the tip", examples=["28 mm"], gt=0)
    lip_height_error: Annotated[Length, Usual("0 mm", "0.05 mm")] = Field(
        description="difference of the lips that makes a turning force, for the estimate of circularity",
        examples=["0.01 mm"], ge=0,
    )  # fmt: skip

    @property
    def cone_height(self) -> float:
        """Height of the drill point [m]."""
        return 0.5 * self.diameter / math.tan(0.5 * self.point_angle)

    def contradictions(self) -> Iterator[Notice]:
        """Chisel edge and web inside the drill."""
        for key in ("chisel_radius", "web"):
            if getattr(self, key) >= 0.5 * self.diameter:
                yield Notice((key,), "is as large as the radius of the drill")

    def notices(self) -> Iterator[Notice]:
        """Half a point angle."""
        if self.point_angle < math.radians(85):
            given, full = (units.show(k * self.point_angle, "angle", 4) for k in (1, 2))
            yield Notice(("point_angle",), f"{given} looks like half the angle; the full one would be {full}")


class DrilledMaterial(LibrarySpec):
    """Specific cutting force of the drilled material and how it acts on lip and chisel edge."""

    library_shelf: ClassVar[str] = "drilled_materials"

    k_c11: Annotated[Stress, Usual("300 N/mm^2", "5000 N/mm^2")] = Field(
        description="Kienzle's specific cutting force at h = 1 mm", examples=["650 N/mm^2"], gt=0
    )
    m_c: Annotated[Number, Usual(0.1, 0.4)] = Field(description="Kienzle's exponent", examples=[0.25], ge=0, lt=1)
    rake_friction: Annotated[Number, Usual(0.2, 0.9)] = Field(
        description="friction between chip and rake face of the lips", examples=[0.6], ge=0
    )
    chisel_factor: Annotated[Number, Usual(0.8, 3)] = Field(
        description="normal stress on the chisel edge over the specific cutting force", examples=[1.3], ge=0
    )
    chisel_friction: Number = Field(description="friction on the chisel edge", examples=[0.3], ge=0)
    margin_stress: Annotated[Stress, Usual("0 N/mm^2", "5 N/mm^2")] = Field(
        description="shear stress of the rubbing margins", examples=["0.5 N/mm^2"], ge=0
    )
    hardness: Annotated[Number, Usual(40, 450)] | None = Field(
        default=None, description="Brinell hardness, for comparison with Shaw and Oxford's formula", examples=[200],
        gt=0,
    )  # fmt: skip
    tungaloy_factor: Annotated[Number, Usual(0.8, 4)] | None = Field(
        default=None, description="material factor K of Tungaloy's drilling formula, for comparison", examples=[1.01],
        gt=0,
    )  # fmt: skip


class DrillingOperation(Spec):
    """Feed and speed."""

    feed_per_rev: Annotated[FeedPerRevolution, Usual("0.01 mm/rev", "0.6 mm/rev")] = Field(
        description="feed per revolution", examples=["0.1 mm/rev"], gt=0
    )
    spindle_speed: Annotated[AngularSpeed, Usual("50 rpm", "20000 rpm")] = Field(
        description="spindle speed", examples=["3000 rpm"], gt=0
    )


class HoleGrid(Spec):
    """Holes in rows and columns in the plane normal to the drill axis, from the first hole on."""

    columns: Count = Field(default=1, description="holes along the first direction", examples=[3], ge=1, le=1000)
    rows: Count = Field(default=1, description="holes along the second direction", examples=[2], ge=1, le=1000)
    pitch: tuple[Length, Length] = Field(
        description="distance between columns and between rows", examples=["[100 mm, 80 mm]"]
    )


class HoleCorrection(Spec):
    """Where the tool is led so that the hole comes out where it is wanted; in the axes of the tool at the hole."""

    shift: tuple[Length, Length] = Field(
        default=(0.0, 0.0), description="of the target along x and y of the tool", examples=["[-18 um, 6 um]"]
    )
    tilt: tuple[Angle, Angle] = Field(
        default=(0.0, 0.0),
        description="of the drill axis towards x and y of the tool",
        examples=["[-0.5 mrad, 0.05 mrad]"],
    )


class Hole(Spec):
    """Where to drill, in the base frame of the robot, or in the frame of the part on a machine."""

    position: Position = Field(
        description="entry point of the (first) hole; on a machine in the frame of the part",
        examples=["[1900 mm, 300 mm, 800 mm]"],
    )  # fmt: skip
    axis: Direction = Field(description="feed direction", examples=["[0, 0, -1]"])
    grid: HoleGrid | None = Field(
        default=None,
        description="pattern of holes; columns along x of the base (made normal to the axis), rows along axis times x",
        examples=["{columns: 3, rows: 2, pitch: [100 mm, 80 mm]}"],
    )
    others: tuple[Position, ...] = Field(
        default=(), description="entry points of further holes", examples=["[[1950 mm, 300 mm, 800 mm]]"]
    )

    corrections: tuple[HoleCorrection, ...] = Field(
        default=(), description="where the tool is led instead, one for each hole (first, pattern, others), see cutwise correct",
        examples=["[{shift: [-18 um, 6 um], tilt: [-0.5 mrad, 0.05 mrad]}]"],
    )  # fmt: skip

    @property
    def count(self) -> int:
        """Number of holes."""
        return (self.grid.columns * self.grid.rows if self.grid is not None else 1) + len(self.others)

    def contradictions(self) -> Iterator[Notice]:
        """An axis with a length; a correction for each hole."""
        if math.hypot(*self.axis) < 1e-9:
            yield Notice(("axis",), "has no length; write for example [0, 0, -1]")
        if self.corrections and len(self.corrections) != self.count:
            yield Notice(("corrections",), f"are {len(self.corrections)} for {self.count} holes; write one for each")


class Placement(Spec):
    """Places at which the part may be put, tried one after the other; the holes move with it."""

    x: tuple[Length, Length] = Field(
        default=(0.0, 0.0), description="range of shifts along x of the base", examples=["[-200 mm, 200 mm]"]
    )
    y: tuple[Length, Length] = Field(
        default=(0.0, 0.0), description="range of shifts along y of the base", examples=["[-200 mm, 200 mm]"]
    )
    z: tuple[Length, Length] = Field(
        default=(0.0, 0.0), description="range of shifts along z of the base", examples=["[0 mm, 0 mm]"]
    )
    steps: Annotated[Count, Usual(2, 15)] = Field(
        default=3, description="places along every range that is not zero", examples=[3], ge=2, le=50
    )


class DrilledPart(Spec):
    """The plate."""

    thickness: Annotated[Length, Usual("0.5 mm", "60 mm")] = Field(
        description="thickness along the drill axis", examples=["5 mm"], gt=0
    )
    inclination: Angle = Field(
        default=0.0, description="slope of the surfaces against the normal plane of the drill axis", examples=["0 deg"]
    )
    slope_direction: Angle = Field(
        default=0.0,
        description="direction about the drill axis, from redundancy angle zero, in which the surface falls away into "
        "the feed",
        examples=["0 deg"],
    )
    stiffness: Annotated[Stiffness, Usual("0.1 N/um", "10000 N/um")] | None = Field(
        default=None, description="stiffness of the part along the drill axis; left out: rigid", examples=["20 N/um"],
        gt=0,
    )  # fmt: skip
    block: PartBlock | None = Field(
        default=None,
        description="the part as a block on the table of a machine, which bends under the thrust",
        examples=["{width_x: 260 mm, width_y: 90 mm, height: 300 mm, weight: 540 N, flexible: false}"],
    )
    placement: Placement | None = Field(
        default=None, description="where the part may be put; the place with the best worst hole is taken",
        examples=["{x: [-200 mm, 200 mm], y: [-200 mm, 200 mm], steps: 3}"],
    )  # fmt: skip


class Contact(Spec):
    """How the hole holds the drill. No source gives these values."""

    friction: Annotated[Number, Usual(0.05, 0.6)] = Field(
        description="friction between tip and work that keeps the tip from skating", examples=[0.2], ge=0
    )
    wall_stiffness: Annotated[Stiffness, Usual("0 N/um", "100 N/um")] = Field(
        description="stiffness k_w of the hole wall against the drill; 0: no wall", examples=["5 N/um"], ge=0
    )
    wander_length: Annotated[Length, Usual("0.5 mm", "50 mm")] = Field(
        description="depth L_w over which the hole follows a drill that is pushed aside", examples=["6 mm"], gt=0
    )
    drill_torque_on_arm: bool = Field(default=False, description="let the drill torque twist the arm", examples=[False])


class DrillingNumerics(Spec):
    """How the computation is done."""

    time_step: Annotated[Time, Usual("1 us", "0.5 ms")] = Field(
        default=1e-4, description="time step of the cycle", examples=["0.1 ms"], gt=0
    )
    lip_elements: Annotated[Count, Usual(50, 5000)] = Field(
        default=400, description="elements per lip (oblique lips only)", examples=[400], ge=8, le=100_000
    )
    azimuths: Annotated[Count, Usual(90, 7200)] = Field(
        default=360, description="azimuths per turn (inclined surfaces only)", examples=[360], ge=8, le=100_000,
        multiple_of=2,
    )  # fmt: skip
    angle_step: Angle = Field(
        default=math.radians(2), description="step of the redundancy angle in the search for a posture",
        examples=["2 deg"], gt=math.radians(0.01), le=math.radians(45),
    )  # fmt: skip


class DrillingMachine(CarryingMachine):
    """A machine tool that drills, as a chain of bodies that yield."""

    refused: ClassVar[Mapping[str, str]] = {"drives": REFUSED["drill", "drives"]}


class DrillingScenario(Scenario):
    """Drilling a plate with a robot (Garnier, Subrin, Waiyagan 2017), or on a machine tool."""

    refused: ClassVar[Mapping[str, str]] = {"spindle": REFUSED["drill", "pistons"]}
    measures: ClassVar[Mapping[str, MeasureSpec]] = DRILLING
    needs: ClassVar[Needs] = needs.DRILLING
    starts: ClassVar[Mapping[str, str]] = {
        "tool.library": "twist_6mm",
        "material.library": "al2024",
        "robot.library": "kr270_2f",
        "robot.redundancy_angle": "best",
        "contact.friction": "{value: 0.2, status: assumed, source: no value found}",
        "contact.wall_stiffness": "{value: 5 N/um, status: assumed, source: no value found}",
        "contact.wander_length": "{value: 6 mm, status: assumed, source: no value found}",
        "requirements": "{hole_position_error_entry: {max: 0.02 mm}, hole_position_error_exit: {max: 0.05 mm}}",
    }

    levers: ClassVar[Mapping[str, tuple[str, str]]] = {
        "operation.feed_per_rev": ("0.02 mm/rev", "0.4 mm/rev"),
        "operation.spindle_speed": ("300 rpm", "8000 rpm"),
        "robot.redundancy_angle": ("-180 deg", "180 deg"),
    }

    def turned(self) -> Mapping[str, tuple[str, str]]:
        """A machine has no angle to choose."""
        idle = {"robot.redundancy_angle"} if self.robot is None else set()
        return {key: ends for key, ends in self.levers.items() if key not in idle}

    def unasked(self) -> int:
        """A pattern drills every hole, a part may be placed, and the best posture is found by drilling: seconds a run."""
        if self.hole.grid is not None or self.hole.others or self.part.placement is not None:
            return 10
        return 12 if self.robot is not None and self.robot.redundancy_angle == "best" else 100

    process: Literal["drill"] = Field(description="which operation is simulated", examples=["drill"])
    operation: DrillingOperation = Field(description="feed and speed")
    hole: Hole = Field(description="where to drill")
    part: DrilledPart = Field(description="the plate")
    tool: Drill = Field(description="the drill")
    material: DrilledMaterial = Field(description="the drilled material")
    contact: Contact = Field(description="how the hole holds the drill")
    robot: Robot | None = Field(default=None, description="the robot and its posture (or give machine)")
    machine: DrillingMachine | None = Field(
        default=None, description="the machine tool that drills, as bodies that yield (or give robot)"
    )
    numerics: DrillingNumerics = Field(default_factory=DrillingNumerics, description="how the computation is done")

    @property
    def focus(self) -> str:  # type: ignore[override]
        """The position of the hole, with the error of the arm itself where that is known."""
        own = None if self.robot is None else self.robot.accuracy
        return "hole_position_error_exit" if own is None else "hole_position_error_total"

    def caveat(self, measure: str) -> str:
        """Positions of a robot whose chain nobody has measured hold what it yields by, and no more."""
        unmeasured = self.robot is not None and self.robot.errors is None
        if unmeasured and measure in ("hole_position_error_entry", "hole_position_error_exit"):
            return "compliance only; an uncalibrated arm is off by tenths of a millimetre"
        return ""

    def checks(self) -> Iterator[Iterator[Notice]]:
        """The drill in its plate; what carries it."""
        yield self._hole_faults()
        yield self._carrier_faults()

    def contradictions(self) -> Iterator[Notice]:
        """What contradicts itself between sections."""
        for check in self.checks():
            yield from check

    def _carrier_faults(self) -> Iterator[Notice]:
        """One carrier; a part that yields in one way, and stands where it is on a machine."""
        if self.robot is not None and self.machine is not None:
            yield Notice(("robot",), ONE_CARRIER)
        if self.robot is None and self.machine is None:
            yield Notice(("robot",), "missing; write robot.library (or machine.library for a machine that drills)")
        yield from block_faults(self.machine, self.part.block, self.part.stiffness)
        if self.machine is not None:
            yield from tip_faults(self.machine)
            for number, one in enumerate(self.hole.corrections):
                if any(one.tilt):
                    yield Notice(
                        ("hole", "corrections", number, "tilt"),
                        "a machine does not tilt its spindle: shift the hole alone",
                    )
        if self.machine is not None and self.part.placement is not None:
            yield Notice(
                ("part", "placement"),
                "tries places before a robot; on a machine the hole lies in the frame of the part",
            )

    def _hole_faults(self) -> Iterator[Notice]:
        """A drill that does not get through; a slope that the point meets with its corner first."""
        need = self.part.thickness + self.tool.cone_height
        if self.tool.flute_length < need:
            yield Notice(
                ("tool", "flute_length"),
                f"the drill is shorter than the hole: {_mm(self.tool.flute_length)}, thickness and drill point need "
                f"{_mm(need)}",
            )
        steepest = math.pi / 2 - 0.5 * self.tool.point_angle
        if abs(self.part.inclination) >= steepest:
            yield Notice(
                ("part", "inclination"),
                f"must be below {units.show(steepest, 'angle', 4)} for this point angle: the corner of the drill would "
                "touch before its tip",
            )

    def unused(self) -> Iterator[Notice]:
        """Where a flat surface falls away; numerics of what is not computed."""
        yield from super().unused()
        if not self.part.inclination:
            flat = "the surfaces are not inclined (part.inclination)"
            yield Notice(("part", "slope_direction"), flat)
            yield Notice(("numerics", "azimuths"), flat)
        if self.tool.lip_model == "simple":
            yield Notice(("numerics", "lip_elements"), "simple lips need no elements (tool.lip_model)")
        if self.robot is None:
            yield Notice(("numerics", "angle_step"), "a machine has no angle to choose")
        elif not isinstance(self.robot.redundancy_angle, str):
            yield Notice(("numerics", "angle_step"), "the angle of the tool is given (robot.redundancy_angle)")

    def notices(self) -> Iterator[Notice]:
        """Chips too thin or too thick for the coefficients; slopes where the first turns matter."""
        if self.machine is not None:
            yield from what_yields_alone(self.machine)
        chip = 0.5 * self.operation.feed_per_rev * math.sin(0.5 * self.tool.point_angle)
        if chip < 5e-6 or chip > 0.5e-3:
            yield Notice(
                ("operation", "feed_per_rev"),
                f"the chip is {units.show(chip, 'small_length', 3)} thick; Kienzle's law is usually for 5 to 500 µm",
            )
        if abs(self.part.inclination) > math.radians(20):
            yield Notice(
                ("part", "inclination"), "is steep: usual without a pilot or a milled seat is up to 10 to 15 deg"
            )


def _mm(value: float) -> str:
    return units.show(value, "length", 4)
