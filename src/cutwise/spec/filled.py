"""Which rows the sections of a scenario put into the slots of its cell, held against those that it names."""

from collections.abc import Iterator, Mapping
from typing import Any

from cutwise.spec.base import Notice, Spec
from cutwise.spec.cell import PRESETS, REFUSED, ROWS, Slots, illegal

Filled = Mapping[str, tuple[str, ...]]


def rows_of(scenario: Any) -> Filled:
    """The rows in the slots of a scenario, by slot; several in ``structure`` alone, or where the run itself decides.

    Raises
    ------
    AttributeError
        A section that decides is not there: the scenario is only partly right.
    """
    engagement, cutting, surface = _BY_PROCESS[scenario.process](scenario)
    return {
        "motion": (motion_of(scenario),),
        "engagement": engagement,
        "cutting": (cutting,),
        "structure": tuple(structure_of(scenario)),
        "surface": (surface,),
    }


def motion_of(scenario: Any) -> str:
    """What moves the tool."""
    if _section(scenario, "robot") is not None:
        return "robot"
    machine = _section(scenario, "machine")
    if machine is None:
        return "programmed"
    if not hasattr(machine, "chain"):
        return "drives"
    return "machine" if getattr(machine, "drives", None) is None else "driven_machine"


def structure_of(scenario: Any) -> Iterator[str]:
    """Everything that yields, from the tool to the part."""
    tool, part = _section(scenario, "tool"), _section(scenario, "part")
    robot, motion = _section(scenario, "robot"), motion_of(scenario)
    if _section(scenario, "spindle") not in (None, "rigid"):
        yield "pistons"
    if getattr(tool, "stiffness", None) is not None or getattr(tool, "flexible", False):
        yield "tip"
    if getattr(tool, "modes", ()):
        yield "tip_modes"
    if robot is not None:
        yield "arm"
        if getattr(robot, "base_compliance", None) is not None:
            yield "base"
    if motion in ("machine", "driven_machine"):
        yield "bodies"
    blocks = (part, getattr(part, "block", None))
    if getattr(part, "stiffness", None) is not None or any(getattr(block, "flexible", False) for block in blocks):
        yield "part"
    if scenario.process == "turn":
        yield "shaft"


def _section(scenario: Any, name: str) -> Any:
    """A section, None where the process has no such; an error where it has faults of its own."""
    return getattr(scenario, name) if name in type(scenario).model_fields else None


Rows = tuple[tuple[str, ...], str, str]  # engagement, cutting, surface


def _deburr(scenario: Any) -> Rows:
    by = {"arcs": ("edge",), "swept": ("edge_memory",), "auto": ("edge", "edge_memory")}
    return by[scenario.numerics.engagement], "flutes", "edge"


def _chamfer(scenario: Any) -> Rows:
    return ("wedge",), "ball" if scenario.has_forces else "none", "chamfer"


def _drill(scenario: Any) -> Rows:
    del scenario
    return ("hole",), "lips", "hole"


def _turn(scenario: Any) -> Rows:
    del scenario
    return ("bar",), "insert", "shaft"


def _machine(scenario: Any) -> Rows:
    force = scenario.load.force
    cutting = "none" if force is None else "flutes" if isinstance(force, Spec) else "prescribed"
    return ("pass" if scenario.has_pass else "working_space",), cutting, "wall" if scenario.surface else "tool_point"


def _mill(scenario: Any) -> Rows:
    if scenario.in_3d:
        return ("stock_3d",), "none" if scenario.material is None else "flutes", "part"
    cutting = "none" if scenario.numerics.force == "none" and not scenario.programmed else "flutes"
    if scenario.program is not None:
        return ("stock" if scenario.stock is not None else "program",), cutting, "contour"
    straight = hasattr(scenario.path, "line")
    return ("wall" if straight else "corner",), cutting, "wall" if straight else "contour"


_BY_PROCESS = {
    "deburr": _deburr, "chamfer": _chamfer, "drill": _drill, "turn": _turn, "machine": _machine, "mill": _mill
}  # fmt: skip


def slot_faults(scenario: Any) -> Iterator[Notice]:
    """Rows that are named and that no section fills, or that a section fills and that are not named."""
    named: Slots | None = scenario.cell
    if named is None:
        return
    process = scenario.process
    if process not in named.processes:
        fits = " or ".join(named.processes)
        if fits:  # otherwise its rows contradict one another, which is told
            row = next(
                (slot, getattr(named, slot)) for slot in ("engagement", "cutting", "surface")
                if getattr(named, slot) not in (None, *getattr(PRESETS[process], slot))
            )  # fmt: skip
            yield Notice(("cell", row[0]), f"{row[1]} is not of process: {process}; write process: {fits}, or "
                         f"{' or '.join(getattr(PRESETS[process], row[0]))}")  # fmt: skip
        return
    told = {notice.path for notice in illegal(named, named.processes)}
    yield from (Notice(("cell", *n.path), n.message) for n in illegal(named, (process,)) if n.path not in told)
    there = rows_of(scenario)
    for slot in ("motion", "engagement", "cutting", "surface"):
        row = getattr(named, slot)
        if row is not None and there[slot] != (row,) and (process, row) not in REFUSED:
            yield Notice(("cell", slot), f"is {row}, the rest of the scenario says {' or '.join(there[slot])}; for {row} write "
                         f"{ROWS[slot][row].filled}")  # fmt: skip
    yield from _series_faults(process, named, there["structure"])


def _series_faults(process: str, named: Slots, there: tuple[str, ...]) -> Iterator[Notice]:
    """Terms of the structure that are named and not there, or there and not named."""
    if named.structure is None:
        return
    rows = ROWS["structure"]
    for row in named.structure:
        if row not in there and (process, row) not in REFUSED:
            yield Notice(
                ("cell", "structure"), f"names {row}, which nothing fills; write {rows[row].filled}, or leave it out"
            )
    carried = {"arm": "robot", "bodies": "machine"}
    for present in there:
        of_carrier = named.motion is not None and present in carried and carried[present] in named.motion
        if present not in named.structure and not of_carrier:
            without = f", or write {rows[present].left_out}" if rows[present].left_out else ""
            yield Notice(("cell", "structure"), f"leaves out {present}, which the scenario has; name it{without}")


def in_words(scenario: Any) -> str:
    """The cell of a scenario in one line."""
    rows = rows_of(scenario)
    return "; ".join(
        f"{slot} {(' + ' if slot == 'structure' else ' or ').join(rows[slot]) or 'rigid'}" for slot in ROWS
    )
