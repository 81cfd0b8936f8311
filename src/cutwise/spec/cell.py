"""The five slots of a cell and the rows that fill them: what a scenario may name, what goes together, why the rest does not.

A process is a preset: it says which rows may stand in its slots. The sections of the scenario fill them (``robot`` gives
an arm, ``spindle`` pistons); ``cell`` names them, so that what is run is what was meant.
"""

from collections.abc import Iterator, Mapping
from typing import Any, Literal, NamedTuple, get_args

from pydantic import Field

from cutwise.spec.base import Notice, Spec

Motion = Literal["programmed", "drives", "machine", "driven_machine", "robot"]
Engagement = Literal[
    "edge", "edge_memory", "wedge", "hole", "wall", "corner", "program", "stock", "stock_3d", "pass", "working_space",
    "bar",
]  # fmt: skip
Cutting = Literal["flutes", "ball", "lips", "insert", "prescribed", "none"]
Term = Literal["pistons", "tip", "tip_modes", "arm", "base", "bodies", "part", "shaft"]
Surface = Literal["edge", "chamfer", "hole", "wall", "contour", "part", "tool_point", "shaft"]

SLOTS: Mapping[str, Any] = {
    "motion": Motion, "engagement": Engagement, "cutting": Cutting, "structure": Term, "surface": Surface
}  # fmt: skip

ONE_CARRIER = "the tool has one carrier: write robot or machine"


class Row(NamedTuple):
    """What can stand in a slot."""

    meaning: str
    filled: str  # what to write in a scenario for it
    left_out: str = ""  # what to write to be without it


ROWS: Mapping[str, Mapping[str, Row]] = {
    "motion": {
        "programmed": Row("the tool goes as programmed", "neither robot nor machine", "robot or machine"),
        "drives": Row("feed drives: look-ahead, controllers, friction", "machine: {library: fadal2216}"),
        "machine": Row("a chain of bodies along x, y, z", "machine: {library: demec_mill}"),
        "driven_machine": Row(
            "a chain of bodies, moved by feed drives", "machine: {library: demec_mill, drives: {library: fadal2216}}"
        ),
        "robot": Row("an arm along poses", "robot: {library: kr270_r2700}"),
    },
    "engagement": {
        "edge": Row("edge with burr: arcs from the present position", "process: deburr, numerics.engagement: arcs"),
        "edge_memory": Row("edge with burr: a swept surface with memory", "process: deburr, numerics.engagement: swept"),
        "wedge": Row("ball in the wedge of two faces", "process: chamfer"),
        "hole": Row("drill in its own hole, which guides it", "process: drill"),
        "wall": Row("straight wall or slot", "process: mill, path.line"),
        "corner": Row("inner corner between two walls", "process: mill, path.corner"),
        "program": Row("NC program at given depths", "process: mill, program"),
        "stock": Row("NC program in a block: exact arcs", "process: mill, program, stock: {x, y, z}"),
        "stock_3d": Row("NC program in any stock: a map in 3D", "process: mill, program, tools or stock: {file}"),
        "pass": Row("places of a pass at rest", "process: machine, path or program"),
        "working_space": Row("no cut: the working space is mapped", "process: machine, volume"),
        "bar": Row("bar that turns against an insert", "process: turn"),
    },
    "cutting": {
        "flutes": Row("flutes of a cylinder: edge or Kienzle coefficients", "material"),
        "ball": Row("ball, disc by disc", "material, operation.spindle_speed, tool.flutes"),
        "lips": Row("lips, chisel edge and margins of a drill", "material"),
        "insert": Row("nose and edge of a turning insert", "material"),
        "prescribed": Row("a force that is given", "load.force: [4000 N, 4000 N, 2000 N]"),
        "none": Row("no force of the cut", "no material, load.force or numerics.force: none"),
    },
    "structure": {
        "pistons": Row("motor on pneumatic pistons (time, memory)", "spindle: {library: berselli2016}", "spindle: rigid"),
        "tip": Row("tool by one stiffness at its tip", "tool.stiffness: 20 N/um", "tool.stiffness: null"),
        "tip_modes": Row(
            "tool by its vibration modes",
            "tool.modes: [{direction: y, frequency: 1020 Hz, damping: 0.035, stiffness: 20 N/um}]", "tool.modes: []",
        ),
        "arm": Row("joints of a robot", "robot: {library: kr270_r2700}", "robot: null"),
        "base": Row("ground under a robot", "robot.base_compliance", "robot.base_compliance: null"),
        "bodies": Row("bodies, guides and block of a machine", "machine: {library: demec_mill}", "machine: null, or drives alone"),
        "part": Row("part that yields", "part.stiffness or a block", "no part.stiffness, a block with flexible: false"),
        "shaft": Row("shaft in chuck, centre and rest", "part and lathe of process: turn"),
    },
    "surface": {
        "edge": Row("edge error along the edge", "process: deburr"),
        "chamfer": Row("width of the chamfer", "process: chamfer"),
        "hole": Row("position, tilt and size of holes", "process: drill"),
        "wall": Row("error of a wall and its floor", "process: mill with path.line, process: machine with surface"),
        "contour": Row("contour of a corner or program", "process: mill with path.corner or program"),
        "part": Row("machined stock against the nominal part", "process: mill with a stock in 3D"),
        "tool_point": Row("deviation of the tool point", "process: machine without surface"),
        "shaft": Row("diameter, roughness and roundness", "process: turn"),
    },
}  # fmt: skip


class Preset(NamedTuple):
    """The rows that may stand in the slots of a process."""

    motion: tuple[Motion, ...]
    engagement: tuple[Engagement, ...]
    cutting: tuple[Cutting, ...]
    structure: tuple[Term, ...]
    surface: tuple[Surface, ...]


_CARRIED: tuple[Motion, ...] = get_args(Motion)
_SERIES: tuple[Term, ...] = ("pistons", "tip", "tip_modes", "arm", "base", "bodies", "part")

PRESETS: Mapping[str, Preset] = {
    "deburr": Preset(_CARRIED, ("edge", "edge_memory"), ("flutes",), _SERIES, ("edge",)),
    "chamfer": Preset(_CARRIED, ("wedge",), ("ball", "none"), _SERIES, ("chamfer",)),
    "mill": Preset(
        _CARRIED, ("wall", "corner", "program", "stock", "stock_3d"), ("flutes", "none"), _SERIES,
        ("wall", "contour", "part"),
    ),
    "drill": Preset(("robot", "machine"), ("hole",), ("lips",), ("arm", "base", "bodies", "part"), ("hole",)),
    "machine": Preset(
        ("machine", "robot"), ("pass", "working_space"), ("prescribed", "flutes", "none"), _SERIES[1:],
        ("wall", "tool_point"),
    ),
    "turn": Preset(("programmed",), ("bar",), ("insert",), ("tip", "tip_modes", "shaft"), ("shaft",)),
}  # fmt: skip

_STILL = "drives need time stepping; use process: mill"
_GUIDED = "drives hold still while a drill feeds along z: leave them out"
_LATHE = "the slides of a lathe are led as programmed, and yield as tool.stiffness: write motion: programmed"
_SHAFT = "a shaft is turned in a chuck; to mill or deburr a part that yields write part.stiffness"

REFUSED: Mapping[tuple[str, str], str] = {
    ("drill", "pistons"): "a spindle tilting on pistons cannot guide a drill: leave it out",
    ("drill", "tip_modes"): "bending modes of a free drill do not hold once the hole guides it: leave them out",
    (
        "drill",
        "tip",
    ): "the hole guides the drill, whose tip stays where it cuts: write what carries it, robot or machine",
    ("drill", "programmed"): "a drill that goes as programmed makes a hole without error: write robot or machine",
    ("drill", "drives"): _GUIDED,
    ("drill", "driven_machine"): _GUIDED,
    ("machine", "pistons"): "pistons remember how they were loaded, machine is still; use process: deburr or mill",
    ("machine", "drives"): _STILL,
    ("machine", "driven_machine"): _STILL,
    (
        "machine",
        "programmed",
    ): "an error budget is that of a machine or a robot: write machine.library or robot.library",
    (
        "turn",
        "pistons",
    ): "a bar is turned against a tool held rigidly: a spindle on pistons holds a bur; use process: deburr",
    **{("turn", row): _LATHE for row in ("drives", "machine", "driven_machine", "robot", "arm", "base", "bodies")},
    ("turn", "part"): "the part of a lathe yields as a shaft on its supports: write shaft",
    **{(process, "shaft"): _SHAFT for process in PRESETS if process != "turn"},
}
"""Rows of motion and structure that physics forbids in a process, each with the reason and what can be used instead."""

_MEANT = {
    "wedge": "two faces that meet are chamfered by a ball, wherever its axis leans: write ball",
    "edge": "an edge is trimmed by the flutes of a cylinder: write flutes",
    "edge_memory": "an edge is trimmed by the flutes of a cylinder: write flutes",
    "hole": "a drill cuts by lips and chisel edge along its axis: write lips",
    "bar": "a bar is turned by one edge that stands still: write insert",
}
_MILLED = "flutes that turn cut here: write flutes, or process: drill, chamfer or turn for another edge"


class Slots(Spec):
    """The rows that fill the five slots; a slot that is left out has what the sections say."""

    motion: Motion | None = Field(
        default=None, description="what moves the tool: as programmed, feed drives, the bodies of a machine, both, or a robot",
        examples=["robot"],
    )  # fmt: skip
    engagement: Engagement | None = Field(default=None, description="what the tool meets", examples=["edge"])
    cutting: Cutting | None = Field(default=None, description="where the force of the cut is from", examples=["flutes"])
    structure: tuple[Term, ...] | None = Field(
        default=None, description="everything that yields, in series; []: rigid. Under --set it takes the other terms out",
        examples=["[pistons, arm]"],
    )  # fmt: skip
    surface: Surface | None = Field(default=None, description="what is left, and measured", examples=["edge"])

    @property
    def processes(self) -> tuple[str, ...]:
        """The processes that have what is met, cut with and left."""
        return processes_with({slot: getattr(self, slot) for slot in ("engagement", "cutting", "surface")})

    def contradictions(self) -> Iterator[Notice]:
        """Rows that do not go together, whatever the sections say."""
        if self.structure is not None and len(set(self.structure)) < len(self.structure):
            yield Notice(
                ("structure",), "names a term twice: displacements of a series add, write its compliance instead"
            )
        yield from self._carried_faults()
        met = processes_with({"engagement": self.engagement}) if self.engagement else ()
        if self.cutting is not None and met and self.cutting not in PRESETS[met[0]].cutting:
            yield Notice(("cutting",), f"{self.cutting} does not go with {self.engagement}: "
                         f"{_MEANT.get(str(self.engagement), _MILLED)}")  # fmt: skip
        elif self.surface is not None and not self.processes:
            fit = sorted({row for process in met or PRESETS for row in PRESETS[process].surface})
            yield Notice(("surface",), f"{self.surface} is not what is left here: write {' or '.join(fit)}")
        yield from illegal(self, self.processes)

    def _carried_faults(self) -> Iterator[Notice]:
        """Terms of a carrier that is not there."""
        terms = self.structure or ()
        if "bodies" in terms and {"arm", "base"} & set(terms):
            yield Notice(("structure",), ONE_CARRIER)
        for term, carriers in (("arm", ("robot",)), ("base", ("robot",)), ("bodies", ("machine", "driven_machine"))):
            if term in terms and self.motion is not None and self.motion not in carriers:
                yield Notice(("structure",), f"{term}: yields where a {carriers[0]} carries the tool; write motion: "
                             f"{' or '.join(carriers)}")  # fmt: skip
        for carried, term in (("robot", "arm"), ("machine", "bodies"), ("driven_machine", "bodies")):
            if self.motion == carried and self.structure is not None and term not in terms:
                word, other = carried.replace("_", " "), {"arm": "programmed"}.get(term, "drives")
                yield Notice(
                    ("structure",),
                    f"leaves out {term}, by which a {word} always yields: add it, or write motion: {other}",
                )


def processes_with(named: Mapping[str, str | None]) -> tuple[str, ...]:
    """The processes that have all of some rows in their slots."""
    return tuple(
        process for process, preset in PRESETS.items()
        if all(row is None or row in getattr(preset, slot) for slot, row in named.items())
    )  # fmt: skip


def illegal(named: Slots, processes: tuple[str, ...]) -> Iterator[Notice]:
    """Rows that are refused by every process that may be meant, with the reason of the first."""
    for slot, rows in (("motion", (named.motion,)), ("structure", named.structure or ())):
        for row in rows:
            why = [REFUSED.get((process, row or "")) for process in processes]
            if why and all(why):
                yield Notice((slot,), f"{row}: {why[0]}")
