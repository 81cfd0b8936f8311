"""The scenario of milling with CNC drives: a pocket corner, or a G-code program."""

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Annotated, Any, ClassVar, Literal

from annotated_types import Gt
from pydantic import Discriminator, Field

from cutwise import units
from cutwise.spec import needs
from cutwise.spec.base import (
    Angle,
    AngularSpeed,
    Count,
    Length,
    Notice,
    Spec,
    Speed,
    Time,
    Usual,
)
from cutwise.spec.carrier import CarriedPath, CarryingRobot, Standing
from cutwise.spec.chained import tip_faults, what_yields_alone
from cutwise.spec.cutter import Cutter
from cutwise.spec.drives import CncMachine
from cutwise.spec.fields import tag
from cutwise.spec.material import Material
from cutwise.spec.measures import MILLING
from cutwise.spec.milled_path import MilledPath, machine_faults, robot_faults
from cutwise.spec.milling_machine import MillingLoad, MillingMachine, machine_kind
from cutwise.spec.needs import Needs
from cutwise.spec.part_block import PartBlock
from cutwise.spec.program import Blend, PathMode, Program, StockBlock
from cutwise.spec.scenario import Limit, MeasureSpec, Scenario
from cutwise.spec.stock import AnyFixture, AnyStock, NominalPart, StockNumerics
from cutwise.spec.stock_milling import STOCK_CHECKS, stock_notices, stock_unused
from cutwise.spec.tool import HelicalMill, ToolMode


def _path_kind(value: Any) -> str:
    written = value if isinstance(value, dict) else {}
    carried = isinstance(value, CarriedPath) or bool({"line", "arc", "tool_axis", "work", "cut_from"} & set(written))
    return "<line>" if carried else "<corner>"


def _corner_kind(value: Any) -> str:
    if isinstance(value, dict | Blend):
        return "<blend>"
    return "<sharp>" if value == "sharp" else "<fillet>"


def _part_kind(value: Any) -> str:
    nominal = isinstance(value, NominalPart) or (
        isinstance(value, dict) and bool({"file", "step", "tolerance"} & set(value))
    )
    return "<nominal>" if nominal else "<yielding>"


_LONG_FLUTES = 5.0  # diameters

CornerShape = Annotated[
    Annotated[Literal["sharp"], tag("sharp")] | Annotated[Length, Gt(0), tag("fillet")], Discriminator(_corner_kind)
]

Strategy = Annotated[
    Annotated[Literal["sharp"], tag("sharp")]
    | Annotated[Length, Gt(0), tag("fillet")]
    | Annotated[Blend, tag("blend")],
    Discriminator(_corner_kind),
]


class CornerPath(Spec):
    """Along one wall, through an inner corner to the left, along the next wall; the path is that of the tool centre."""

    corner: CornerShape = Field(
        description="sharp (the tool stops in the corner), or the fillet radius of the centre path", examples=["sharp"]
    )
    lead: Annotated[Length, Usual("10 mm", "500 mm")] = Field(
        default=30e-3, description="way before and after the corner point", examples=["30 mm"], gt=0
    )
    turn: Angle = Field(
        default=0.5 * math.pi, description="angle of the turn", examples=["90 deg"], gt=0, lt=math.radians(175)
    )
    compare: tuple[Strategy, ...] = Field(
        default=(),
        description="other corners to run and show in one table: sharp (exact stop), fillet radii, blends of a tolerance",
        examples=["[sharp, 2 mm, {blend: 0.1 mm, shape: clothoid}]"],
    )

    @property
    def fillet(self) -> float:
        """Radius of the centre path in the corner [m], 0 if sharp."""
        return 0.0 if isinstance(self.corner, str) else self.corner

    def contradictions(self) -> Iterator[Notice]:
        """A fillet that does not fit between the ends."""
        for shape in (self.corner, *self.compare):
            if isinstance(shape, float) and shape * math.tan(0.5 * self.turn) >= self.lead * (1 - 1e-9):
                yield Notice(
                    ("corner",), f"a fillet of {_mm(shape)} takes the whole lead of {_mm(self.lead)}; make it smaller"
                )


class MillingOperation(Spec):
    """The cut: climb milling along a wall, the previous pass offset by the radial depth; or what a program meets."""

    feed: Annotated[Speed, Usual("1 mm/s", "500 mm/s")] | None = Field(
        default=None,
        description="feed along the path; a program has its own (F), which this replaces where it cuts: plunges and "
        "moves above the material keep theirs",
        examples=["40 mm/s"], gt=0,
    )  # fmt: skip
    spindle_speed: Annotated[AngularSpeed, Usual("500 rpm", "60000 rpm")] | None = Field(
        default=None, description="spindle speed; a program has its own (S), which this replaces",
        examples=["8000 rpm"], gt=0,
    )  # fmt: skip
    axial_depth: Length | None = Field(
        default=None, description="axial depth of cut a_p; with a stock it follows from the program", examples=["5 mm"],
        gt=0,
    )  # fmt: skip
    radial_depth: Length | None = Field(
        default=None, description="radial depth of cut a_e; with a stock it follows from the program",
        examples=["4 mm"], gt=0,
    )  # fmt: skip
    milling: Literal["down", "up"] = Field(
        default="down", description="down (climb) or up (conventional) milling of a robot; drives mill down",
        examples=["down"],
    )  # fmt: skip


class LobeDiagram(Spec):
    """The map of stability over spindle speed and axial depth."""

    spindle_speed_min: AngularSpeed | None = Field(
        default=None, description="lowest speed; left out: half of the operation's", examples=["4000 rpm"], gt=0
    )
    spindle_speed_max: AngularSpeed | None = Field(
        default=None, description="highest speed; left out: one and a half times the operation's",
        examples=["12000 rpm"], gt=0,
    )  # fmt: skip
    depth_max: Length | None = Field(
        default=None, description="greatest axial depth; left out: three times that of the operation",
        examples=["15 mm"], gt=0,
    )  # fmt: skip
    speeds: Annotated[Count, Usual(10, 400)] = Field(default=60, description="speeds of the map", examples=[60], ge=2)
    depths: Annotated[Count, Usual(10, 200)] = Field(default=40, description="depths of the map", examples=[40], ge=2)

    def contradictions(self) -> Iterator[Notice]:
        """Speeds that run backwards."""
        low, high = self.spindle_speed_min, self.spindle_speed_max
        if low is not None and high is not None and low >= high:
            yield Notice(("spindle_speed_min",), "is not below spindle_speed_max")


class EndMill(HelicalMill):
    """A cylindrical end mill; with modes its tip may vibrate."""

    helix: Annotated[Angle, Usual("0 deg", "50 deg")] = Field(
        description="helix angle β of a right-hand helix", examples=["30 deg"], ge=0, lt=math.radians(80)
    )
    modes: tuple[ToolMode, ...] = Field(
        default=(), description="vibration modes of the tool tip; none: the tool is rigid",
        examples=["[{direction: x, frequency: 922 Hz, damping: 0.011, stiffness: 1.34 N/um}]"],
    )  # fmt: skip


class DriveStepping(Spec):
    """How drives and forces are stepped."""

    substeps: Annotated[Count, Usual(4, 100)] = Field(
        default=10, description="steps of drives and forces in a sample of the controller", examples=[10], ge=1
    )
    force: Literal["tooth_resolved", "averaged", "none"] = Field(
        default="tooth_resolved",
        description="cutting force tooth by tooth, averaged over a revolution, or none",
        examples=["tooth_resolved"],
    )
    discs: Annotated[Count, Usual(10, 400)] | None = Field(
        default=None, description="axial discs of the mill (midpoint rule); left out: flutes in closed form",
        examples=[20], ge=1,
    )  # fmt: skip
    mode: Literal["step", "still"] = Field(
        default="step",
        description="time steps of drives and forces, or each place of the path at rest (a robot)",
        examples=["step"],
    )
    station: Annotated[Length, Usual("0.5 mm", "50 mm")] = Field(
        default=5e-3, description="distance of the places along a path that are looked at at rest", examples=["5 mm"],
        gt=0,
    )  # fmt: skip
    settling_time: Time = Field(
        default=1.0, description="time at the end point in which settling is watched", examples=["1 s"], ge=0
    )
    stock: StockNumerics = Field(default_factory=StockNumerics, description="how a stock in 3D is computed")


class MillingScenario(Scenario):
    """Milling a pocket with a CNC machine (Ozcan et al. 2017)."""

    measures: ClassVar[Mapping[str, MeasureSpec]] = MILLING
    needs: ClassVar[Needs] = needs.MILLING
    either: ClassVar[tuple[tuple[str, ...], ...]] = (("path",), ("program",))
    starts: ClassVar[Mapping[str, str]] = {
        "path.corner": "2 mm",
        "path.compare": "[sharp, 2 mm, 5 mm]",
        "operation.feed": "40 mm/s",
        "operation.spindle_speed": "8000 rpm",
        "operation.axial_depth": "5 mm",
        "operation.radial_depth": "4 mm",
        "tool.library": "endmill_20_3",
        "material.library": "al7075t6",
        "machine.library": "fadal2216",
        "machine.reading": "kp_ki_swapped",
        "requirements": "{contour_error_max: {max: 50 um}, force_xy_peak: {max: 800 N}}",
    }

    levers: ClassVar[Mapping[str, tuple[str, str]]] = {
        "operation.feed": ("5 mm/s", "150 mm/s"),
        "operation.spindle_speed": ("2000 rpm", "20000 rpm"),
        "operation.axial_depth": ("0.5 mm", "20 mm"),
        "operation.radial_depth": ("0.2 mm", "8 mm"),
        "path.corner": ("0.5 mm", "10 mm"),
        "path_mode.blend": ("2 um", "500 um"),
    }
    focus: ClassVar[str] = "contour_error_max"
    implied: ClassVar[Mapping[str, float]] = {"chatter_growth_corner": 1.0, "chatter_growth_straight": 1.0}

    def turned(self) -> Mapping[str, tuple[str, str]]:
        """What this cut has: a program or a line no corner, a stock no depths; a corner no blend unless it is asked for."""
        if self.in_3d:
            return {key: self.levers[key] for key in ("operation.feed", "operation.spindle_speed")}
        idle = {"path.corner"} if not isinstance(self.path, CornerPath) else set()
        if self.stock is not None:
            idle |= {"operation.axial_depth", "operation.radial_depth"}
        if self.program is None and not isinstance(self.path_mode, Blend):
            idle.add("path_mode.blend")
        return {key: ends for key, ends in self.levers.items() if key not in idle}

    def unasked(self) -> int:
        """A program takes seconds, one that is followed through its stock or on a vibrating tip many."""
        if self.program is None:
            return 100
        if self.in_3d:
            return 0
        return 5 if self.stock is not None or (self.tool is not None and self.tool.modes) else 12

    process: Literal["mill"] = Field(description="which operation is simulated", examples=["mill"])
    path: (
        Annotated[Annotated[CornerPath, tag("corner")] | Annotated[MilledPath, tag("line")], Discriminator(_path_kind)]
        | None
    ) = Field(default=None, description="a pocket corner, or a straight wall (or give program)")
    placement: Standing | None = Field(default=None, description="where the part stands before the robot")
    robot: CarryingRobot | None = Field(
        default=None, description="the robot that carries the mill instead of a machine"
    )
    program: Program | None = Field(default=None, description="an NC program (or give path)")
    stock: AnyStock | None = Field(
        default=None,
        description="what a program cuts, a block, a cylinder, a file or what an earlier run left: contact then follows from what "
        "its moves have left, the depths of the operation are not needed",
    )
    tools: tuple[Cutter, ...] = Field(
        default=(),
        description="tools that the program calls, by their profiles (instead of tool): the stock is then cut in 3D",
    )
    fixtures: tuple[AnyFixture, ...] = Field(
        default=(), description="clamps and jaws that no tool may touch: blocks, STEP or STL files",
        examples=["[{x: [-30 mm, -5 mm], y: [0 mm, 20 mm], z: [-20 mm, 10 mm]}]"],
    )  # fmt: skip
    path_mode: PathMode = Field(
        default="exact_path",
        description="corners between blocks: exact_path (G61), exact_stop (G61.1) or {blend: tolerance} (G64 P)",
        examples=["exact_path"],
    )
    operation: MillingOperation = Field(default_factory=MillingOperation, description="the cut")
    tool: EndMill | None = Field(default=None, description="the end mill (or give tools)")
    material: Material | None = Field(
        default=None,
        description="cutting coefficients of the material with this tool; of a stock in 3D left out: no forces",
    )
    machine: (
        Annotated[
            Annotated[CncMachine, tag("drives")] | Annotated[MillingMachine, tag("bodies")], Discriminator(machine_kind)
        ]
        | None
    ) = Field(default=None, description="the machine: its drives, or bodies that yield and drives (or give robot)")
    part: (
        Annotated[Annotated[PartBlock, tag("yielding")] | Annotated[NominalPart, tag("nominal")], Discriminator(_part_kind)]
        | None
    ) = Field(
        default=None, description="the part on a machine with bodies, left out: rigid; or the nominal part that a program is to "
        "leave of its stock (file)",
    )  # fmt: skip
    load: MillingLoad = Field(default_factory=MillingLoad, description="loads on the machine besides the cut")
    lobes: LobeDiagram = Field(
        default_factory=LobeDiagram, description="map of stability, drawn where the tool has modes"
    )
    numerics: DriveStepping = Field(default_factory=DriveStepping, description="how the computation is done")
    stability: Literal["required", "ignore"] = Field(
        default="required",
        description="whether a tool that chatters fails (required); ignore: it does not, and the run never passes",
        examples=["ignore"],
    )

    @property
    def in_3d(self) -> bool:
        """Whether the stock is a map in 3D, because tools, part, stock or fixtures ask for it; otherwise arcs are exact.

        Of a scenario that is only partly right, sections that are not there have faults of their own: they were written.
        """
        there = vars(self)
        odd = not isinstance(there.get("stock"), StockBlock | None)
        nominal = isinstance(there.get("part"), NominalPart) or (
            "part" not in there and there.get("program") is not None
        )
        return bool(there.get("tools", True)) or bool(there.get("fixtures", True)) or nominal or odd

    @property
    def nominal(self) -> NominalPart | None:
        """The part that the program is to leave, if it is given."""
        return self.part if isinstance(self.part, NominalPart) else None

    @property
    def asked(self) -> Mapping[str, Limit]:
        """A tolerance of the nominal part asks for the deviation to be within it, unless a requirement says otherwise."""
        tolerance = self.nominal.tolerance if self.nominal is not None else None
        if tolerance is None:
            return self.requirements
        implied = {"deviation_min": Limit(min=-tolerance), "deviation_max": Limit(max=tolerance)}
        return {
            **{name: limit for name, limit in implied.items() if name not in self.requirements},
            **self.requirements,
        }

    @property
    def mill(self) -> EndMill:
        """The one end mill."""
        if self.tool is None:
            raise AttributeError("tool")  # a check that needs it ends there; that it is missing is told
        return self.tool

    @property
    def drives(self) -> CncMachine:
        """The feed drives: those of the machine, or the machine itself where it is nothing else."""
        found = self.machine.drives if isinstance(self.machine, MillingMachine) else self.machine
        assert found is not None
        return found

    @property
    def drives_key(self) -> str:
        """Dotted key of the feed drives."""
        return "machine.drives" if isinstance(self.machine, MillingMachine) else "machine"

    @property
    def line(self) -> MilledPath | None:
        """The straight wall along which a machine mills, if there is one."""
        return self.path if self.robot is None and isinstance(self.path, MilledPath) else None

    @property
    def set_aside(self) -> frozenset[str]:
        """Chatter, where the scenario ignores it."""
        return frozenset({"unstable"} if self.stability == "ignore" else ())

    def contradictions(self) -> Iterator[Notice]:
        """What carries the tool; path and program, feed and speed missing, depths that engagement or tool do not cover."""
        for check in self.checks():
            with suppress(AttributeError):  # of the tool, which is told to be missing
                yield from check

    def checks(self) -> Iterator[Iterator[Notice]]:
        """A fault within the machine hides none of those of the cut."""
        if self.in_3d:
            yield from (check(self) for check in STOCK_CHECKS)
            return
        yield self._missing()
        yield self._carrier_faults()
        yield self._cut_faults()

    def _missing(self) -> Iterator[Notice]:
        """What only a stock in 3D can do without."""
        for key, sample in (("tool", "tool: {library: endmill_20_3}"), ("material", "material: {library: al7075t6}")):
            if getattr(self, key) is None:
                yield Notice((key,), f"missing; write it, for example {sample}")

    def _cut_faults(self) -> Iterator[Notice]:
        """Path and program, feed and speed, depths."""
        if self.robot is not None:
            yield from self._robot_faults()
            return
        if (self.path is None) == (self.program is None):
            yield Notice(("path",), "give exactly one of path (a corner or a line) and program (a G-code file)")
        if isinstance(self.path, MilledPath):
            yield from machine_faults(self.path)
            yield from self._side_faults(self.path)
            if self.operation.milling == "up" and self.numerics.force == "tooth_resolved" and self.mill.modes:
                yield Notice(("operation", "milling"), "up is not covered for a tip that swings tooth by tooth (tool.modes); "
                             "write numerics.force: averaged, or mill down")  # fmt: skip
        if self.path is not None:
            for key, sample in (("feed", "40 mm/s"), ("spindle_speed", "8000 rpm")):
                if getattr(self.operation, key) is None:
                    yield Notice(("operation", key), f"missing; write it as text with a unit, for example {sample}")
        yield from self._depth_faults()

    def _carrier_faults(self) -> Iterator[Notice]:
        """One carrier, and a path that fits it."""
        if self.robot is not None and self.machine is not None:
            yield Notice(("robot",), "the tool has one carrier: write robot or machine")
        if self.robot is None and self.machine is None:
            yield Notice(("machine",), "missing; write machine.library (or robot.library for a robot that mills)")
        if isinstance(self.machine, MillingMachine):
            yield from self._bodies_faults(self.machine)
        elif self.robot is None and self.part is not None:
            yield Notice(("part",), "yields with the bodies of a machine; there are none (machine.library: demec_mill)")
        if self.robot is not None and self.part is not None:
            yield Notice(("part",), "stands on a machine; before a robot it is rigid: leave it out")
        if self.robot is None and self.placement is not None:
            yield Notice(("placement",), "places a part before a robot; there is none")
        if self.robot is None and self.operation.milling == "up" and self.line is None:
            yield Notice(("operation", "milling"), "up is for a line; a corner or program on a machine is milled down")
        if self.robot is None and self.numerics.mode == "still":
            yield Notice(("numerics", "mode"), "drives need time stepping: still is for a robot")

    def _bodies_faults(self, machine: MillingMachine) -> Iterator[Notice]:
        """What a machine with bodies that yield cannot do."""
        yield from tip_faults(machine)
        if machine.drives is None:
            yield Notice(("machine", "drives"), "missing; name the feed drives, for example drives: {library: fadal2216} "
                         "(a machine that stands still is process: machine)")  # fmt: skip
        if self.path is not None and self.line is None and self.robot is None:
            yield Notice(("path",), "bodies of a machine yield along a straight wall (path.line); a corner is run with "
                         "drives alone: machine: {library: fadal2216}")  # fmt: skip
        if self.program is not None:
            yield Notice(("program",), "bodies of a machine yield along a straight wall (path.line); a program is run with "
                         "drives alone (machine: {library: fadal2216}), or at rest (process: machine)")  # fmt: skip
        if self.numerics.force == "tooth_resolved" and self.mill.modes:
            yield Notice(("numerics", "force"), "tooth_resolved steps the modes of the tool with drives alone; beside "
                         "bodies of a machine write averaged: the modes then yield by F/k")  # fmt: skip

    def _side_faults(self, path: MilledPath) -> Iterator[Notice]:
        """A side of the work that contradicts the sense of milling."""
        side = "right" if self.operation.milling == "down" else "left"
        if path.work not in (None, side):
            yield Notice(
                ("path", "work"),
                f"{path.work} contradicts operation.milling: a right-hand tool mills {self.operation.milling} with the "
                f"work on the {side} of the feed",
            )

    def _robot_faults(self) -> Iterator[Notice]:
        """What a robot that mills needs, and what it cannot do."""
        operation = self.operation
        if isinstance(self.path, MilledPath):
            yield from robot_faults(self.path)
            yield from self._side_faults(self.path)
        else:
            yield Notice(("path",), "a robot needs to know where the wall is, for example path: {line: {from: [1900 mm, "
                         "-150 mm, 800 mm], to: [1900 mm, 150 mm, 800 mm]}, tool_axis: [0, 0, -1]}")  # fmt: skip
        for key, why in (
            ("program", "a robot follows path.line; programs are for machines"),
            ("stock", "belongs to a program; a robot has its depths (operation.radial_depth, .axial_depth)"),
        ):
            if getattr(self, key) is not None:
                yield Notice((key,), why)
        if self.numerics.mode != "still":
            yield Notice(("numerics", "mode"), "a robot that mills is computed at rest: write mode: still")
        for key, sample in (("feed", "40 mm/s"), ("spindle_speed", "8000 rpm"), ("axial_depth", "5 mm"),
                            ("radial_depth", "4 mm")):  # fmt: skip
            if getattr(operation, key) is None:
                yield Notice(("operation", key), f"missing; write it as text with a unit, for example {sample}")
        radial = operation.radial_depth
        if radial is not None and radial > self.mill.diameter * (1 + 1e-9):
            yield Notice(
                ("operation", "radial_depth"), f"is more than the diameter of the mill ({_mm(self.mill.diameter)})"
            )
        length, depth = self.mill.flute_length, operation.axial_depth
        if length is not None and depth is not None and depth > length * (1 + 1e-9):
            yield Notice(
                ("operation", "axial_depth"), f"is more than the flute length ({_mm(length)}, tool.flute_length)"
            )

    def _depth_faults(self) -> Iterator[Notice]:
        """Depths missing, or more than engagement and tool cover; a stock without a program."""
        operation = self.operation
        if self.stock is not None and self.program is None:
            yield Notice(
                ("stock",), "is cut by a program; a corner has its depths (operation.radial_depth, .axial_depth)"
            )
        for key, example in (("axial_depth", "5 mm"), ("radial_depth", "4 mm")):
            if self.stock is None and getattr(operation, key) is None:
                hint = " (or describe the stock)" if self.program is not None else ""
                yield Notice(("operation", key), f"missing; write it as text with a unit, for example {example}{hint}")
        if self.stock is None and (operation.radial_depth or 0.0) > self.mill.diameter * (1 + 1e-9):
            yield Notice(
                ("operation", "radial_depth"),
                f"{_mm(operation.radial_depth or 0.0)} is more than the diameter of the mill ({_mm(self.mill.diameter)}), "
                "a full slot: split the pass, take a larger mill, or describe the stock of a program",
            )
        length, depth = self.mill.flute_length, operation.axial_depth
        if length is not None and depth is not None and depth > length * (1 + 1e-9):
            yield Notice(
                ("operation", "axial_depth"), f"is more than the flute length ({_mm(length)}, tool.flute_length)"
            )

    def unused(self) -> Iterator[Notice]:
        """What belongs to a tool that vibrates, to time stepping or to a robot; the group of the material."""
        if self.in_3d:
            yield from stock_unused(self)
            return
        yield Notice(
            ("numerics", "stock"),
            "the stock is no map in 3D: that takes tools, a nominal part or another form of stock",
        )
        if self.stock is not None:
            yield Notice(("program", "top"), "the stock has its own top (stock.z)")
        if self.robot is not None or not self.mill.modes:
            yield Notice(("stability",), "the tool has no modes (tool.modes), which could chatter")
        yield Notice(("material", "group"), "deburring alone holds its cutting speed against that of the group")
        if self.robot is not None:
            still = "a robot is computed at rest, with the mean force of the cut"
            for key in ("substeps", "force", "discs", "settling_time"):
                yield Notice(("numerics", key), still)
            for key in ("runout", "runout_angle"):
                yield Notice(("tool", key), still)
            yield Notice(("path_mode",), "a robot follows its path; corners between blocks are those of a program")
            yield Notice(("lobes",), "the depth at which the arm chatters is told along its path, not over the speed")
            yield Notice(("robot", "dynamics"), "the cut is computed at rest, and chatter with the swinging mass")
            return
        if isinstance(self.path, CarriedPath):
            yield Notice(("path_mode",), "a line has no corners")
            for key in ("tool_axis", "orientation"):
                yield Notice(("path", key), "it is for a robot; the tool of a machine stands as its chain says")
            if self.numerics.force != "tooth_resolved":
                yield Notice(("stability",), "chatter is looked at tooth by tooth (numerics.force)")
        yield Notice(("numerics", "station"), "there is no robot, whose path is looked at in stations")
        if self.lobes.model_fields_set and (not self.mill.modes or self.numerics.force != "tooth_resolved"):
            why = (
                "the tool has no modes (tool.modes)" if not self.mill.modes else "force is not resolved tooth by tooth"
            )
            yield Notice(("lobes",), f"{why}: no map of stability is drawn")
        if isinstance(self.path, CornerPath) and self.path.corner == "sharp" and self.path_mode == "exact_stop":
            yield Notice(("path_mode",), "the tool stops in a sharp corner anyway (path.corner)")

    def notices(self) -> Iterator[Notice]:
        """Feed per tooth, depth and sampling that are unusual; what does not count."""
        if self.in_3d:
            yield from stock_notices(self)
            return
        if isinstance(self.machine, MillingMachine):
            yield from what_yields_alone(self.machine, weights=False)
        if self.stock is not None:
            for key in ("axial_depth", "radial_depth"):
                if getattr(self.operation, key) is not None:
                    yield Notice(("operation", key), "is not used: the stock says what the program meets")
        if self.robot is None and self.numerics.force != "tooth_resolved":
            still = isinstance(self.machine, MillingMachine) and self.numerics.force == "averaged"  # modes are F/k
            for key in ("runout",) if still else ("modes", "runout"):
                if getattr(self.mill, key):
                    yield Notice(("tool", key), f"does not count with numerics.force: {self.numerics.force}")
        if self.line is not None and self.numerics.discs and not self.mill.modes:
            yield Notice(("numerics", "discs"), "does not count along a line: the flutes are taken in closed form")
        depth, length = self.operation.axial_depth, self.mill.flute_length
        if depth is not None and length is None and depth > _LONG_FLUTES * self.mill.diameter:
            yield Notice(
                ("operation", "axial_depth"), f"is {depth / self.mill.diameter:.3g} diameters of the mill; usual is up to "
                f"{_LONG_FLUTES:g} (tool.flute_length is not given)",
            )  # fmt: skip
        yield from self._chip_notices()

    def _chip_notices(self) -> Iterator[Notice]:
        feed, speed = self.operation.feed, self.operation.spindle_speed
        limits = self.drives.limits if self.machine is not None else None
        if feed is not None and limits is not None and limits.act_on == "path" and feed > limits.velocity:
            yield Notice(
                ("operation", "feed"),
                f"is above {self.drives_key}.limits.velocity: no more than {units.show(limits.velocity, 'speed')} is run",
            )
            feed = limits.velocity
        if feed is not None and speed is not None:
            chip = 2.0 * math.pi * feed / (speed * self.mill.flutes)
            if not 5e-6 <= chip <= 0.4e-3:
                yield Notice(
                    ("operation", "feed"),
                    f"is {units.show(chip, 'small_length', 3)} per tooth; usual is 5 to 400 µm",
                )
            if self.material is not None and (beyond := self.material.beyond(chip)):
                yield Notice(("material",), beyond)
            if self.machine is None:
                return
            step = self.drives.control.sample_time / self.numerics.substeps
            tooth = 2.0 * math.pi / (speed * self.mill.flutes)
            if self.numerics.force == "tooth_resolved" and step > tooth / 10:
                yield Notice(
                    ("numerics", "substeps"),
                    f"leave {tooth / step:.3g} steps per tooth; ten or more resolve the peaks, or use averaged force",
                )


def _mm(value: float) -> str:
    return units.show(value, "length")
