"""The scenario of deburring one edge with a compliant spindle."""

import math
from collections.abc import Iterator, Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from cutwise import units
from cutwise.spec import needs
from cutwise.spec.base import Notice
from cutwise.spec.carrier import CarryingRobot, PartPath, Standing, limited_feed
from cutwise.spec.cell import ONE_CARRIER
from cutwise.spec.chained import block_faults, tip_faults, what_yields_alone
from cutwise.spec.material import Material
from cutwise.spec.measures import DEBURRING
from cutwise.spec.milling_machine import ToolMachine, bodies_of, drives_of
from cutwise.spec.needs import Needs
from cutwise.spec.numerics import TimeStepping
from cutwise.spec.operation import DeburringOperation, SinePathError, uncovered
from cutwise.spec.part import DeburringPart
from cutwise.spec.part_block import PartBlock
from cutwise.spec.scenario import MeasureSpec, Scenario
from cutwise.spec.spindle import CompliantSpindle, Spindle
from cutwise.spec.tables import Table
from cutwise.spec.tool import Bur

_UPRIGHT = 1e-6  # sine of the angle to gravity at which a spindle hangs upright

# Upper end of the usual cutting speeds of carbide burs [m/min] by ISO 513 group, as recalled from makers' catalogues.
USUAL_CUTTING_SPEED = {"P": 600.0, "M": 350.0, "K": 600.0, "N": 900.0, "S": 350.0, "H": 350.0}


class DeburringScenario(Scenario):
    """Deburring one edge with a pneumatic compliant spindle (Berselli et al. 2016)."""

    measures: ClassVar[Mapping[str, MeasureSpec]] = DEBURRING
    needs: ClassVar[Needs] = needs.DEBURRING
    starts: ClassVar[Mapping[str, str]] = {
        "operation.feed": "50 mm/s",
        "operation.spindle_speed": "30000 rpm",
        "operation.length": "80 mm",
        "operation.lead_in_time": "0.5 s",
        "operation.clearance": "0.2 mm",
        "operation.path_error": "{amplitude: 0.1 mm, frequency: 1 Hz}",
        "part.burr.height": "0.3 mm",
        "part.burr.width": "0.3 mm",
        "part.contact_length": "10 mm",
        "tool.library": "berselli2016",
        "material.library": "deburr_aluminium",
        "spindle.library": "default",
        "spindle.gravity": "-z",
        "requirements": "{surface_error_max: {max: 0.1 mm}, surface_error_min: {min: -0.1 mm}}",
    }
    levers: ClassVar[Mapping[str, tuple[str, str]]] = {
        "spindle.pressure": ("2 bar", "6.5 bar"),
        "operation.feed": ("20 mm/s", "200 mm/s"),
        "operation.preset": ("0.2 mm", "5 mm"),
        "operation.lead_in_time": ("0.05 s", "0.8 s"),
    }
    sound: ClassVar[Mapping[str, float]] = {"stroke_margin": 1e-6}  # the tool off its stop
    focus: ClassVar[str] = "surface_error_mean"

    process: Literal["deburr"] = Field(description="which operation is simulated", examples=["deburr"])
    operation: DeburringOperation = Field(description="the pass along the edge")
    part: DeburringPart = Field(description="the edge, its burr and the part below it")
    tool: Bur = Field(description="the mill or bur")
    material: Material = Field(description="cutting coefficients of the material with this tool")
    spindle: Spindle = Field(description="the compliant spindle, or rigid")
    path: PartPath | None = Field(
        default=None, description="where the edge lies in the part, for a robot or a machine to follow"
    )
    placement: Standing | None = Field(default=None, description="where the part stands before the robot")
    robot: CarryingRobot | None = Field(default=None, description="the robot that carries the spindle along the path")
    machine: ToolMachine | None = Field(
        default=None,
        description="the machine tool that carries the spindle along the path: bodies that yield, feed drives, or both",
    )
    numerics: TimeStepping = Field(default_factory=TimeStepping, description="how the computation is done")

    @property
    def follows(self) -> bool:
        """Whether the tool turns with an edge that is an arc: as a robot does unless it is told otherwise."""
        assert self.path is not None
        return self.path.orientation == "follow" or (self.robot is not None and self.path.orientation is None)

    @model_validator(mode="after")
    def _as_long_as_its_path(self) -> Self:
        """A path gives the run its length; what the engineer wrote stays what was written."""
        operation = self.operation
        if self.path is not None and self.path.length and operation.length is None and operation.duration is None:
            filled = operation.model_copy(update={"length": self.path.length})
            filled.model_fields_set.discard("length")
            object.__setattr__(self, "operation", filled)
        return self

    def turned(self) -> Mapping[str, tuple[str, str]]:
        """At rest nothing is led in, and no pistons are under pressure."""
        idle = {"operation.lead_in_time", "spindle.pressure"} if self.numerics.mode == "still" else set()
        if self.spindle == "rigid":
            idle |= {"spindle.pressure"}
        return {key: ends for key, ends in self.levers.items() if key not in idle}

    def checks(self) -> Iterator[Iterator[Notice]]:
        """Edge and mill; what carries the spindle."""
        yield self._edge_faults()
        yield self._carrier_faults()
        yield self._machine_faults()
        yield self._rest_faults()
        yield limited_feed(self)

    def contradictions(self) -> Iterator[Notice]:
        """What contradicts itself between sections."""
        for check in self.checks():
            yield from check

    def _carrier_faults(self) -> Iterator[Notice]:
        """A robot without a path, a path beside another length, a side of the work that the milling contradicts."""
        operation, path = self.operation, self.path
        yield from self._part_faults()
        if operation.length is None and operation.duration is None and path is None:
            yield Notice(
                ("operation", "duration"),
                "missing; write duration (for example 0.6 s) or length (for example 48 mm)",
            )
        if path is None:
            for carrier in ("robot", "machine"):
                if getattr(self, carrier) is not None:
                    yield Notice(("path",), f"missing; a {carrier} needs to know where the edge is, for example path: {{line: "
                                 "{from: [1900 mm, -150 mm, 800 mm], to: [1900 mm, 150 mm, 800 mm]}, "
                                 "tool_axis: [0, 0, -1]}")  # fmt: skip
            if self.placement is not None:
                yield Notice(("placement",), "has nothing to place: there is no path")
            return
        if self.robot is None and self.machine is None and path.arc is None and self.part.step is None:
            yield Notice(
                ("path",), "is followed by a robot or a machine; write robot.library, or operation.length alone"
            )
        yield from self._arc_faults(path)
        if self.robot is not None and self.robot.dynamics == "static" and self.numerics.engagement == "swept":
            yield Notice(
                ("numerics", "engagement"), "a surface with memory needs an arm with mass; write robot.dynamics: modal, or "
                "engagement: arcs",
            )  # fmt: skip
        if path.length and (operation.length or operation.duration) and operation.run_length > path.length * (1 + 1e-9):
            key = "length" if operation.length is not None else "duration"
            yield Notice(
                ("operation", key), f"the run is {_mm(operation.run_length)} long, the path only {_mm(path.length)}"
            )
        side = "right" if operation.milling == "down" else "left"
        if path.work not in (None, side):
            yield Notice(
                ("path", "work"),
                f"{path.work} contradicts operation.milling: a right-hand tool mills {operation.milling} with the work on "
                f"the {side} of the feed",
            )

    def _part_faults(self) -> Iterator[Notice]:
        """An edge that is given twice or not at all."""
        part, path = self.part, self.path
        given = path is not None and (path.line is not None or path.arc is not None)
        if part.step is None:
            if part.edges is not None:
                yield Notice(("part", "edges"), "chooses among the edges of a part: write part.step")
            if path is not None and not given:
                yield Notice(
                    ("path", "line"),
                    "missing; write {from: [1900 mm, -150 mm, 800 mm], to: [1900 mm, 150 mm, 800 mm]}, an arc, or part.step",
                )
        elif path is None:
            yield Notice(
                ("path",), "missing; with part.step say how the mill stands, for example path: {tool_axis: [0, 0, -1]}"
            )
        elif given:
            key = "line" if path.line is not None else "arc"
            yield Notice(
                ("path", key), "names the edge a second time: part.step and part.edges give it; keep one of them"
            )

    def _machine_faults(self) -> Iterator[Notice]:
        """Two carriers, a chain that is not one, a part that yields in two ways."""
        bodies, drives, path = bodies_of(self.machine), drives_of(self.machine), self.path
        yield from block_faults(bodies, self.part.block, self.part.stiffness)
        if bodies is not None:
            yield from tip_faults(bodies)
        if self.machine is None:
            return
        if self.robot is not None:
            yield Notice(("robot",), ONE_CARRIER)
        if self.placement is not None:
            yield Notice(
                ("placement",), "places a part before a robot; on a machine the path lies in the frame of the part"
            )
        if path is not None and path.arc is not None and path.orientation == "follow":
            yield Notice(("path", "orientation"), "a machine does not turn its spindle with the edge: write fixed")
        if drives is not None and self.operation.feed_profile is not None:
            yield Notice(
                ("operation", "feed_profile"), "with feed drives is not covered: they run a line at operation.feed"
            )
        if drives is not None and self.numerics.mode == "still":
            yield Notice(("numerics", "mode"), "drives need time stepping: write mode: step, or leave the drives out")

    def _rest_faults(self) -> Iterator[Notice]:
        """What has a memory cannot be at rest, and what has none is not stepped."""
        numerics = self.numerics
        if numerics.mode != "still":
            return
        if self.spindle != "rigid":
            yield Notice(
                ("numerics", "mode"), "pistons remember how they were loaded, still has no time: write mode: step, or "
                "spindle: rigid",
            )  # fmt: skip
        for key, needed, why in (
            ("force", "averaged", "at rest the mean force of the teeth counts; write averaged"),
            ("engagement", "arcs", "a surface with memory needs time stepping; write arcs"),
        ):
            if getattr(numerics, key) not in (needed, "auto"):
                yield Notice(("numerics", key), why)
        if self.tool.runout > 0.0:
            yield Notice(("tool", "runout"), "needs a surface with memory, which has no place at rest; leave it out")
        robot = self.robot
        if robot is not None and robot.dynamics != "static" and "dynamics" in robot.model_fields_set:
            yield Notice(("robot", "dynamics"), "a mass has no place at rest; write static")

    def _arc_faults(self, path: PartPath) -> Iterator[Notice]:
        """What an arc needs to be told, and what is not modelled along one."""
        if path.arc is None:
            return
        if self.robot is None and self.machine is None and path.orientation is None:
            yield Notice(
                ("path", "orientation"),
                "missing; fixed (the tool keeps its attitude) or follow (it turns with the edge)",
            )
        if self.numerics.engagement == "swept":
            yield Notice(("numerics", "engagement"), "a surface with memory is for straight edges; write arcs")
        if self.operation.milling == "up":
            yield Notice(("operation", "milling"), "up milling along an arc is not modelled; write down")
        if self.follows and self._hangs_across(path):
            yield Notice(
                ("spindle", "gravity"),
                "the weight across the spindle turns about it while it follows the arc, which is not modelled; write "
                "path.orientation: fixed, or spindle.gravity: off to leave the weight out",
            )

    @property
    def block(self) -> PartBlock | None:
        """The part, if it is a block on the table of a machine."""
        return self.part.block

    def _hangs_across(self, path: PartPath) -> bool:
        """Whether the weight of the spindle leans on its pistons."""
        spindle = self.spindle
        if not isinstance(spindle, CompliantSpindle) or spindle.gravity == "off":
            return False
        if spindle.mass is None or spindle.centre_of_mass is None:
            return False
        if self.robot is None or "gravity" in spindle.model_fields_set:
            return math.hypot(*spindle.gravity[:2]) > _UPRIGHT
        from cutwise.maths.frames import rotation_from_rpy  # numba comes with it, which no other check needs

        turn = rotation_from_rpy(*(self.placement or Standing()).rotation)
        axis = turn @ np.array(path.tool_axis) / math.hypot(*path.tool_axis)
        return float(np.linalg.norm(np.cross(axis, self.robot.down))) > _UPRIGHT

    def _edge_faults(self) -> Iterator[Notice]:
        """Burr and part outside the flutes; tables that end before the run does."""
        part, burr = self.part, self.part.burr
        if self.tool.flute_length is not None:
            reach = self.tool.flute_length * (1 + 1e-9)
            if part.axial_start + part.contact_length > reach:
                yield Notice(
                    ("part", "contact_length"),
                    f"the part reaches {_mm(part.axial_start + part.contact_length)} up the mill, the flutes only "
                    f"{_mm(self.tool.flute_length)} (tool.flute_length)",
                )
            if isinstance(burr.width, float) and burr.axial_start + burr.width > reach:
                yield Notice(
                    ("part", "burr", "width"),
                    f"the burr reaches {_mm(burr.axial_start + burr.width)} up the mill, the flutes only "
                    f"{_mm(self.tool.flute_length)} (tool.flute_length)",
                )
        given = self.operation.length or self.operation.duration
        for name in ("height", "width"):
            size = getattr(burr, name)
            if isinstance(size, Table) and given:
                yield from uncovered(size, self.operation.run_length, ("part", "burr", name))

    def unused(self) -> Iterator[Notice]:
        """Places along a path that nothing follows; what belongs to time, at rest."""
        yield from super().unused()
        still = self.numerics.mode == "still"
        if self.robot is None and self.machine is None and not still:
            yield Notice(("numerics", "station"), "there is no carrier, whose compliance is taken at stations")
        if self.robot is None:
            yield Notice(("placement",), "there is no robot, before which the part would stand")
        if self.robot is not None and not self.operation.limit_feed:
            yield Notice(("robot", "joint_acceleration"), "it counts with operation.limit_feed")
        if drives_of(self.machine) is None:
            yield Notice(("numerics", "substeps"), "there are no feed drives (machine.drives)")
        if still:
            for section, key in (("operation", "lead_in_time"), ("operation", "lead_out_time"), ("operation", "clearance"),
                                 ("numerics", "time_step")):  # fmt: skip
                yield Notice((section, key), "every place is at rest (numerics.mode)")

    def notices(self) -> Iterator[Notice]:
        """Combinations of sections that are possible but unusual."""
        yield from self._chip_and_speed()
        yield from self._preset_and_stroke()
        bodies = bodies_of(self.machine)
        if bodies is not None:
            yield from what_yields_alone(bodies)
        if isinstance(self.part.burr.height, float) and self.part.burr.height > self.tool.diameter:
            yield Notice(("part", "burr", "height"), "is more than the diameter of the mill")
        if self.numerics.force == "tooth_resolved":
            tooth = 2 * math.pi / (self.operation.spindle_speed * self.tool.flutes)
            if self.numerics.time_step > tooth / 10:
                yield Notice(
                    ("numerics", "time_step"),
                    f"is more than a tenth of a tooth period ({tooth * 1e6:.3g} µs): the ripple is not resolved; usual "
                    "is 2.5 µs or less",
                )
        elif self.tool.runout > 0 and self.numerics.time_step > 5e-6 * (1 + 1e-9):
            yield Notice(("numerics", "time_step"), "is more than the 5 µs that run-out asks for")

    def _chip_and_speed(self) -> Iterator[Notice]:
        speed = math.pi * self.tool.diameter * self.operation.spindle_speed / (2 * math.pi) * 60
        group = self.material.group
        usual = USUAL_CUTTING_SPEED[group] if group else max(USUAL_CUTTING_SPEED.values())
        if speed > usual * (1 + 1e-9):
            where = f"in group {group}" if group else "even in soft aluminium"
            yield Notice(
                ("operation", "spindle_speed"),
                f"the cutting speed is {speed:.4g} m/min; usual for burs is up to {usual:g} m/min {where}",
            )
        chip = self.operation.feed * 2 * math.pi / (self.operation.spindle_speed * self.tool.flutes)
        if beyond := self.material.beyond(chip):
            yield Notice(("material",), beyond)

    def _preset_and_stroke(self) -> Iterator[Notice]:
        spindle, operation = self.spindle, self.operation
        error = operation.path_error.amplitude if isinstance(operation.path_error, SinePathError) else 0.0
        if isinstance(spindle, CompliantSpindle):
            tip_stroke = spindle.stroke * spindle.tool_reach / spindle.piston_arm
            if operation.preset + error >= tip_stroke:
                yield Notice(
                    ("operation", "preset"),
                    f"with the path error it takes the whole stroke of the tip ({_mm(tip_stroke)}): the spindle meets its "
                    "stop",
                )
        height = self.part.burr.height
        if isinstance(height, float) and operation.preset + height <= 0:
            yield Notice(("operation", "preset"), "leaves the mill above the burr: nothing is cut")


def _mm(value: float) -> str:
    return units.show(value, "length")


def _um(value: float) -> str:
    return units.show(value, "small_length", 3)
