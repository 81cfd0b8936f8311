"""The scenario of milling with CNC drives: a pocket corner, or a G-code program."""

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias

from annotated_types import Gt
from pydantic import Discriminator, Field, ValidationError, model_validator

from cutwise import units
from cutwise.spec import milling_carriers, needs
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
from cutwise.spec.carrier import CarriedPath, CarryingRobot, Standing, limited_feed
from cutwise.spec.chained import what_yields_alone
from cutwise.spec.cutter import Cutter
from cutwise.spec.drives import CncMachine
from cutwise.spec.fields import tag
from cutwise.spec.material import Material
from cutwise.spec.measures import MILLING
from cutwise.spec.milled_path import MilledPath, machine_faults
from cutwise.spec.milling_machine import MillingLoad, MillingMachine, ToolMachine, drives_key, drives_of
from cutwise.spec.needs import Needs
from cutwise.spec.part_block import PartBlock, PartSpring
from cutwise.spec.pocket import Pocket
from cutwise.spec.program import Blend, MilledProgram, PathMode, StockBlock
from cutwise.spec.scenario import Limit, MeasureSpec, Scenario
from cutwise.spec.shop import Shop, Wear
from cutwise.spec.spindle import CompliantSpindle, Spindle
from cutwise.spec.stock import AnyFixture, AnyPart, AnyStock, NominalPart, SetUp, StockNumerics
from cutwise.spec.stock_milling import STOCK_CHECKS, stock_notices, stock_unused
from cutwise.spec.tool import EndMill


def _path_kind(value: Any) -> str:
    written = value if isinstance(value, dict) else {}
    carried = isinstance(value, CarriedPath) or bool({"line", "arc", "tool_axis", "work", "cut_from"} & set(written))
    return "<line>" if carried else "<corner>"


def _corner_kind(value: Any) -> str:
    if isinstance(value, dict | Blend):
        return "<blend>"
    return "<sharp>" if value == "sharp" else "<fillet>"


if TYPE_CHECKING:  # only a stock in 3D can be without them, and it is checked apart
    _Mill: TypeAlias = EndMill
    _Material: TypeAlias = Material
else:
    _Mill = EndMill | None
    _Material = Material | None

MADE = "pocket.nc"
"""Name of the program that is made of a pocket."""

_LONG_FLUTES = 5.0  # diameters
_STEP = 20e-6  # [s] where nothing else sets it

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
    limit_feed: bool = Field(
        default=False, description="the feed is lowered where the joints of the robot cannot follow it (robot.joint_speed, "
        "joint_acceleration)", examples=[True],
    )  # fmt: skip
    lead_in_time: Time = Field(
        default=0.0,
        description="time in which the programmed tool goes from the uncut surface to its radial depth, at the start of a "
        "line without drives; 0: it starts fully engaged",
        examples=["0.2 s"], ge=0,
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
        description="time steps of drives and forces, or each place of the path at rest (a robot, a machine without drives)",
        examples=["step"],
    )
    time_step: Annotated[Time, Usual("0.1 us", "400 us")] | None = Field(
        default=None,
        description="largest time step: the substeps of drives are divided by the least whole number that brings them to it; "
        "left out: 20 us without drives or with a compliant spindle, else the substeps as they are",
        examples=["20 us"], gt=0,
    )  # fmt: skip
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
    either: ClassVar[tuple[tuple[str, ...], ...]] = (("path",), ("program", "pocket"), ("setups",))
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
        return 5 if self.stock is not None or self.tool.modes else 12

    process: Literal["mill"] = Field(description="which operation is simulated", examples=["mill"])
    path: (
        Annotated[Annotated[CornerPath, tag("corner")] | Annotated[MilledPath, tag("line")], Discriminator(_path_kind)]
        | None
    ) = Field(default=None, description="a pocket corner, or a straight wall (or give program)")
    placement: Standing | None = Field(default=None, description="where the part stands before the robot")
    robot: CarryingRobot | None = Field(
        default=None, description="the robot that carries the mill instead of a machine"
    )
    program: MilledProgram | None = Field(default=None, description="an NC program (or give path)")
    pocket: Pocket | None = Field(
        default=None, description="a rectangular pocket, whose program is made (instead of program)",
        examples=["{x: [0 mm, 100 mm], y: [0 mm, 60 mm], depth: 5 mm, strategy: contour, stepover: 4 mm, feed: 40 mm/s, "
                  "plunge_feed: 5 mm/s, spindle_speed: 8000 rpm}"],
    )  # fmt: skip
    shop: Shop | None = Field(default=None, description="what an hour and a tool cost: the cost of a part is then told")
    wear: Wear | None = Field(default=None, description="how long the tool lasts: its share of the cost of a part")
    stock: AnyStock | None = Field(
        default=None,
        description="what a program cuts, a block, a cylinder, a file or what an earlier run left: contact then follows from what "
        "its moves have left, the depths of the operation are not needed",
    )
    tools: tuple[Cutter, ...] = Field(
        default=(), description="tools that the program calls, by their profiles (instead of tool): the stock is then cut in 3D",
        examples=["[{number: 1, shape: flat, diameter: 10 mm, flutes: 3, helix: 30 deg}]"],
    )  # fmt: skip
    fixtures: tuple[AnyFixture, ...] = Field(
        default=(), description="clamps and jaws that no tool may touch: blocks, STEP or STL files",
        examples=["[{x: [-30 mm, -5 mm], y: [0 mm, 20 mm], z: [-20 mm, 10 mm]}]"],
    )  # fmt: skip
    setups: tuple[SetUp, ...] = Field(
        default=(), description="several set-ups one after the other (instead of program): each with its program, the axis of its "
        "tools and its zero in the part", examples=["[{program: {file: top.nc}}, {program: {file: side.nc}, axis: [0, 1, 0]}]"],
    )  # fmt: skip
    path_mode: PathMode = Field(
        default="exact_path",
        description="corners between blocks: exact_path (G61), exact_stop (G61.1) or {blend: tolerance} (G64 P)",
        examples=["exact_path"],
    )
    operation: MillingOperation = Field(default_factory=MillingOperation, description="the cut")
    tool: _Mill = Field(default=None, description="the end mill (or give tools)")  # type: ignore[assignment]
    spindle: Spindle = Field(
        default="rigid", description="rigid, or a compliant spindle, whose pistons yield along a straight wall",
        examples=["{library: berselli2016}"],
    )  # fmt: skip
    material: _Material = Field(  # type: ignore[assignment]
        default=None,
        description="cutting coefficients of the material with this tool; of a stock in 3D left out: no forces",
    )
    machine: ToolMachine | None = Field(
        default=None,
        description="the machine: its drives, or bodies that yield, with or without drives (or give robot)",
    )
    part: AnyPart | None = Field(
        default=None, description="the part: a block on a machine with bodies, or one stiffness, left out: rigid; or the nominal "
        "part that a program is to leave of its stock (file)",
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

    @model_validator(mode="before")
    @classmethod
    def _program_of_the_pocket(cls, given: Any) -> Any:
        """The program of a pocket is made of it, whatever was made of an earlier one."""
        if not isinstance(given, Mapping) or not isinstance(given.get("pocket"), Mapping | Pocket):
            return given
        written = given.get("program")
        if written is not None and not (isinstance(written, Mapping) and written.get("file") == MADE):
            return given  # two programs: told with what else contradicts itself
        tool = given.get("tool")
        try:
            pocket = Pocket.model_validate(given["pocket"])
            diameter = (tool if isinstance(tool, EndMill) else EndMill.model_validate(tool)).diameter
        except ValidationError:
            return given  # its faults are told at their places
        if any(pocket.misfits(diameter)):
            return given
        kept = dict(written) if isinstance(written, Mapping) else {}
        return {**given, "program": {**kept, "file": MADE, "text": pocket.program(diameter)}}

    def document(self) -> dict[str, Any]:
        """The scenario as plain values; the program that is made of a pocket is left to be made again."""
        plain = super().document()
        if self.pocket is not None and self.program is not None and self.program.file == MADE:
            kept = {key: value for key, value in plain["program"].items() if key not in ("file", "text")}
            plain |= {"program": kept | {"file": MADE}} if kept else {}
            if not kept:
                del plain["program"]
        return plain

    @property
    def focus(self) -> str:  # type: ignore[override]
        """How far drives leave the path, the wall of a tool that goes as programmed, or the surface of a stock in 3D."""
        if self.in_3d:
            return "deviation_max" if self.nominal is not None else "cutting_power_max"
        return "wall_error_max" if self.programmed else "contour_error_max"

    @property
    def programmed(self) -> bool:
        """Whether the tool goes as programmed: nothing has feed drives."""
        if self.in_3d:
            return False
        if self.robot is not None or "machine" not in vars(
            self
        ):  # a machine with faults of its own has drives, probably
            return self.robot is not None
        if self.machine is None:
            return isinstance(self.path, MilledPath)
        return isinstance(self.machine, MillingMachine) and self.machine.drives is None

    @property
    def block(self) -> PartBlock | None:
        """The part, if it is a block on the table of a machine."""
        return self.part if isinstance(self.part, PartBlock) else None

    @property
    def part_stiffness(self) -> float | None:
        """Stiffness of the part off the wall [N/m], if it is said in one number."""
        return self.part.stiffness if isinstance(self.part, PartSpring) else None

    @property
    def compliant(self) -> CompliantSpindle | None:
        """The spindle, if it yields."""
        return self.spindle if isinstance(self.spindle, CompliantSpindle) else None

    @property
    def modes_at_rest(self) -> bool:
        """Whether modes of the tool count by their stiffness: another term of the structure is there."""
        others = self.compliant is not None or self.part_stiffness is not None
        return others or self.programmed or isinstance(self.machine, MillingMachine)

    @property
    def time_step(self) -> float:
        """Largest time step [s]; infinite where drives alone set it."""
        asked = self.programmed or self.compliant is not None
        return self.numerics.time_step or (_STEP if asked else math.inf)

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
        listed = any(bool(there.get(key, True)) for key in ("tools", "fixtures", "setups"))
        return listed or nominal or odd

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
            **self.requirements,
            **{name: limit for name, limit in implied.items() if name not in self.requirements},
        }

    @property
    def drives(self) -> CncMachine:
        """The feed drives: those of the machine, or the machine itself where it is nothing else."""
        found = drives_of(self.machine)
        assert found is not None
        return found

    @property
    def drives_key(self) -> str:
        """Dotted key of the feed drives."""
        return drives_key(self.machine)

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
            with suppress(AttributeError):  # of a tool that is missing, which is told
                yield from check

    def checks(self) -> Iterator[Iterator[Notice]]:
        """A fault within the machine hides none of those of the cut."""
        if self.in_3d:
            yield from (check(self) for check in STOCK_CHECKS)
            return
        yield self._pocket_faults()
        yield self._missing()
        yield milling_carriers.carrier_faults(self)
        yield milling_carriers.yielding_faults(self)
        yield limited_feed(self)
        yield self._cut_faults()

    def _pocket_faults(self) -> Iterator[Notice]:
        """A pocket that the mill does not fit, or beside another program; a tool that wears for nothing."""
        if self.pocket is not None:
            yield from (Notice(("pocket", *one.path), one.message) for one in self.pocket.misfits(self.tool.diameter))
            if self.program is not None and self.program.file != MADE:
                yield Notice(("pocket",), "makes the program, and program names another: write one of them")
        if self.wear is not None and (self.shop is None or self.shop.tool_price is None):
            yield Notice(("wear",), "says how long a tool lasts, and shop.tool_price is not there: write what it costs")
        if self.programmed and self.shop is not None:
            yield Notice(("shop",), "the cost of a part is told of a cut with drives (machine.x, y, control)")

    def _missing(self) -> Iterator[Notice]:
        """What only a stock in 3D can do without."""
        for key, sample in (("tool", "tool: {library: endmill_20_3}"), ("material", "material: {library: al7075t6}")):
            if getattr(self, key) is None:
                yield Notice((key,), f"missing; write it, for example {sample}")

    def _cut_faults(self) -> Iterator[Notice]:
        """Path and program, feed and speed, depths."""
        if self.programmed:
            yield from milling_carriers.programmed_faults(self)
            return
        if (self.path is None) == (self.program is None) and self.pocket is None:
            yield Notice(("path",), "give exactly one of path (a corner or a line) and program (a G-code file)")
        if isinstance(self.path, MilledPath):
            yield from machine_faults(self.path)
            yield from milling_carriers.side_faults(self)
            if self.operation.milling == "up" and self.numerics.force == "tooth_resolved" and self.tool.modes:
                yield Notice(("operation", "milling"), "up is not covered for a tip that swings tooth by tooth (tool.modes); "
                             "write numerics.force: averaged, or mill down")  # fmt: skip
        if self.path is not None:
            for key, sample in (("feed", "40 mm/s"), ("spindle_speed", "8000 rpm")):
                if getattr(self.operation, key) is None:
                    yield Notice(("operation", key), f"missing; write it as text with a unit, for example {sample}")
        yield from self._depth_faults()

    def _depth_faults(self) -> Iterator[Notice]:
        """Depths missing, or more than engagement and tool cover; a stock without a program."""
        operation = self.operation
        if self.stock is not None and self.program is None and self.pocket is None:
            yield Notice(
                ("stock",), "is cut by a program; a corner has its depths (operation.radial_depth, .axial_depth)"
            )
        for key, example in (("axial_depth", "5 mm"), ("radial_depth", "4 mm")):
            if self.stock is None and getattr(operation, key) is None:
                hint = " (or describe the stock)" if self.program is not None else ""
                yield Notice(("operation", key), f"missing; write it as text with a unit, for example {example}{hint}")
        if self.stock is None and (operation.radial_depth or 0.0) > self.tool.diameter * (1 + 1e-9):
            yield Notice(
                ("operation", "radial_depth"),
                f"{_mm(operation.radial_depth or 0.0)} is more than the diameter of the mill ({_mm(self.tool.diameter)}), "
                "a full slot: split the pass, take a larger mill, or describe the stock of a program",
            )
        length, depth = self.tool.flute_length, operation.axial_depth
        if length is not None and depth is not None and depth > length * (1 + 1e-9):
            yield Notice(
                ("operation", "axial_depth"), f"is more than the flute length ({_mm(length)}, tool.flute_length)"
            )

    def unused(self) -> Iterator[Notice]:
        """What belongs to a tool that vibrates, to time stepping or to a robot; the group of the material."""
        yield from super().unused()
        if self.in_3d:
            yield from stock_unused(self)
            return
        if self.numerics.stock != StockNumerics():
            yield Notice(
                ("numerics", "stock"), "the stock is no map in 3D: that takes tools, a nominal part or another stock"
            )
        if self.stock is not None:
            yield Notice(("program", "top"), "the stock has its own top (stock.z)")
        if self.programmed or not self.tool.modes:
            yield Notice(("stability",), "the tool has no modes (tool.modes), which could chatter")
        yield Notice(("material", "group"), "deburring alone holds its cutting speed against that of the group")
        if self.programmed:
            yield from milling_carriers.unused(self)
            return
        yield Notice(("operation", "lead_in_time"), "drives come from rest, and are in the cut from path.cut_from on")
        if isinstance(self.path, CarriedPath):
            yield Notice(("path_mode",), "a line has no corners")
            for key in ("tool_axis", "orientation"):
                yield Notice(("path", key), "it is for a robot; the tool of a machine stands as its chain says")
            if self.numerics.force != "tooth_resolved":
                yield Notice(("stability",), "chatter is looked at tooth by tooth (numerics.force)")
        yield Notice(("numerics", "station"), "there is no robot, whose path is looked at in stations")
        if self.program is not None and self.correct is None:
            yield Notice(
                ("tool", "stiffness"), "a run of a program takes the tool as rigid (or swinging: tool.modes); cutwise correct "
                "holds walls to it",
            )  # fmt: skip
        if self.lobes.model_fields_set and (not self.tool.modes or self.numerics.force != "tooth_resolved"):
            why = (
                "the tool has no modes (tool.modes)" if not self.tool.modes else "force is not resolved tooth by tooth"
            )
            yield Notice(("lobes",), f"{why}: no map of stability is drawn")
        if isinstance(self.path, CornerPath) and self.path.corner == "sharp" and self.path_mode == "exact_stop":
            yield Notice(("path_mode",), "the tool stops in a sharp corner anyway (path.corner)")

    def notices(self) -> Iterator[Notice]:
        """Feed per tooth, depth and sampling that are unusual; what does not count."""
        yield from self._spindle_notices()
        if self.in_3d:
            yield from stock_notices(self)
            return
        if isinstance(self.machine, MillingMachine):
            yield from what_yields_alone(self.machine, weights=False)
        if self.compliant is not None and self.tool.modes:
            yield Notice(
                ("tool", "modes"), "were given for a rigid spindle: beside pistons they count by their stiffness alone"
            )
        if self.stock is not None:
            for key in ("axial_depth", "radial_depth"):
                if getattr(self.operation, key) is not None:
                    yield Notice(("operation", key), "is not used: the stock says what the program meets")
        if self.tool.end_core is not None and (
            self.stock is None or self.material is None or self.material.law != "linear"
        ):
            yield Notice(
                ("tool", "end_core"), "does not count: a plunge has a force in a stock, by a linear law of force"
            )
        if not self.programmed and self.numerics.force != "tooth_resolved":
            still = self.modes_at_rest and self.numerics.force == "averaged"  # modes are F/k
            for key in ("runout",) if still else ("modes", "runout"):
                if getattr(self.tool, key):
                    yield Notice(("tool", key), f"does not count with numerics.force: {self.numerics.force}")
        if self.line is not None and self.numerics.discs and not self.tool.modes:
            yield Notice(("numerics", "discs"), "does not count along a line: the flutes are taken in closed form")
        depth, length = self.operation.axial_depth, self.tool.flute_length
        if depth is not None and length is None and depth > _LONG_FLUTES * self.tool.diameter:
            yield Notice(
                ("operation", "axial_depth"), f"is {depth / self.tool.diameter:.3g} diameters of the mill; usual is up to "
                f"{_LONG_FLUTES:g} (tool.flute_length is not given)",
            )  # fmt: skip
        yield from self._chip_notices()

    def _spindle_notices(self) -> Iterator[Notice]:
        """Curves of the spindle where no torque is known, or none is held against them."""
        machine = drives_of(self.machine)
        given = [
            key
            for key in ("spindle_power", "spindle_torque")
            if machine is not None and getattr(machine, key) is not None
        ]
        if given and self.in_3d:
            why = (
                "does not count in a run of a stock in 3D (cutwise correct holds feeds to it): hold cutting_power_max and "
                "spindle_torque_max by requirements"
            )
        elif given and self.numerics.force == "none":
            why = "does not count with numerics.force: none"
        else:
            return
        yield from (Notice((*self.drives_key.split("."), key), why) for key in given)

    def _chip_notices(self) -> Iterator[Notice]:
        feed, speed = self.operation.feed, self.operation.spindle_speed
        limits = None if self.programmed else self.drives.limits
        if feed is not None and limits is not None and limits.act_on == "path" and feed > limits.velocity:
            yield Notice(
                ("operation", "feed"),
                f"is above {self.drives_key}.limits.velocity: no more than {units.show(limits.velocity, 'speed')} is run",
            )
            feed = limits.velocity
        if feed is not None and speed is not None:
            chip = 2.0 * math.pi * feed / (speed * self.tool.flutes)
            if not 5e-6 <= chip <= 0.4e-3:
                yield Notice(
                    ("operation", "feed"),
                    f"is {units.show(chip, 'small_length', 3)} per tooth; usual is 5 to 400 µm",
                )
            if beyond := self.material.beyond(chip):
                yield Notice(("material",), beyond)
            if self.programmed:
                return
            step = self.drives.control.sample_time / self.numerics.substeps
            tooth = 2.0 * math.pi / (speed * self.tool.flutes)
            if self.numerics.force == "tooth_resolved" and step > tooth / 10:
                yield Notice(
                    ("numerics", "substeps"),
                    f"leave {tooth / step:.3g} steps per tooth; ten or more resolve the peaks, or use averaged force",
                )


def _mm(value: float) -> str:
    return units.show(value, "length")
