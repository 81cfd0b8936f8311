"""Feeds of an NC program: as quick as its limits allow, block by block, proved by the simulation of the new text."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.process.assemble_mill import program_path, spindle_limits, spindle_speed
from cutwise.process.program_path import ProgramPath, kept_moves
from cutwise.process.stock_moves import FLAT
from cutwise.programs.interpreter import Interpreted
from cutwise.programs.move_table import Moves
from cutwise.programs.rewrite import Handle, handles, rewritten
from cutwise.programs.trace import Ran, Trace, traced
from cutwise.results import Result
from cutwise.spec.correct import LIMITED, Correction
from cutwise.spec.drives import CncMachine
from cutwise.spec.faults import Fault
from cutwise.spec.milling import MillingScenario
from cutwise.spec.program import Program
from cutwise.spec.scenario import Scenario
from cutwise.study.correct import ends, front, objective, prove, told
from cutwise.study.correct.cells import BoolArray, Cells, FloatArray, cells_of
from cutwise.study.correct.limits import Asked, asked, resolved
from cutwise.study.correct.loads import (
    NAMES,
    PLUNGE,
    Allowed,
    Cutting,
    binding,
    cutting_of,
    greatest,
    plunge_forces,
    quickest,
    tip_compliance,
    values_at,
)
from cutwise.study.correct.meridians import OF_SPINDLE, Turning, in_stock
from cutwise.study.correct.outcome import Along, Change, Proposal, Task
from cutwise.study.correct.refused_in_3d import refusals_in_3d
from cutwise.study.correct.schedule import Bed, Schedule, bed_of, scheduled

_ROUNDED = 0.01  # of a feed, by which rounding down may miss what a least chip takes
_LISTED = 4  # lines that are named one by one


class Ready(NamedTuple):
    """A program with all that a schedule of its feeds stands on."""

    scenario: MillingScenario
    program: Interpreted
    trace: Trace
    path: ProgramPath
    cells: Cells
    cutting: Cutting | Turning
    bed: Bed
    known: Mapping[int, Handle]


def corrected(task: Task) -> Proposal:
    """The program with the quickest feeds that keep the limits, or as it was with the reason."""
    ready = prepared(task.scenario, task.said)
    wanted = asked(task.scenario, task.said, walls=bool(tip_compliance(ready.scenario).any()))
    first = task.before.scenario
    static = as_run(ready, static_before(ready if first is task.scenario else prepared(first, task.said)), task.before)
    limits: Mapping[str, float] = limits_of(ready, wanted, static)
    aim = objective.aimed(ready, task, wanted, limits, static)
    room, wanted, limits = aim.room, aim.wanted, aim.limits
    proof = prove.proved(ready, task, aim)
    done = proof.schedule
    feed = speeds_of(ready) if proof.unchanged else done.feed
    said = [*told.said(ready, wanted, limits, static), *proof.told, *told.passing_thin(ready, room, feed, limits)]
    said += ends.told(ready, speeds_of(ready), driven(ready, feed), limits)
    kept = [*told.helpless(ready, wanted, room, limits), *told.thin(ready, room, feed, limits), *proof.missed]
    most = task.said.blocks_max
    if most is not None and done.blocks > most and not proof.unchanged:
        kept.append(f"{done.blocks} blocks are the fewest, more than correct.blocks_max: {most}")
    values = dict(proof.measures) | _static_measures(ready, proof, static)
    values |= _binding_lengths(ready, room)
    values["time_bound"] = done.bound, "time"
    values["blocks_before"] = float(_blocks(ready)), "dimensionless"
    values["blocks_after"] = float(done.blocks), "dimensionless"
    changes = tuple(_changes(ready, room, done, proof))
    return Proposal(
        proof.scenario, changes, values, tuple(said), tuple(kept), (_along(ready, room, done),), proof.after,
        tuple(front.rows(ready, task, static)),
    )  # fmt: skip


def prepared(scenario: Scenario, said: Correction) -> Ready:
    """Read the program once as moves and once as text, and look at all of its cells."""
    assert isinstance(scenario, MillingScenario)
    given: Program | None = scenario.program
    assert given is not None
    cutting: Cutting | Turning
    if scenario.in_3d:
        planned, cells, cutting = in_stock(scenario, said.station)
        given, path = planned.given, planned.path  # with the diameters of the tools
    trace = traced(given.text, given.file, setup_of(given))
    assert trace is not None  # APT is G-code by now
    program = Interpreted(Moves(step.move for step in trace.steps if isinstance(step, Ran)), (), (), given.text)
    if not scenario.in_3d:
        path = program_path(scenario, program)
        cells = cells_of(scenario, path, said.station)
        cutting = cutting_of(scenario, path, cells, spindle_speed(scenario, program))
    known = handles(trace)
    keep, _ = kept_moves(program.moves)
    bed = bed_of(path, cells, keep, known, _keeps(scenario, path, cells, said, cutting) | ~(cutting.spindle > 0.0))
    return Ready(scenario, program, trace, path, cells, cutting, bed, known)


def limits_of(ready: Ready, wanted: Asked, static: Mapping[str, float]) -> dict[str, float]:
    """All limits of a schedule [SI]: what is asked for, and what the spindle has at its speed."""
    limits = resolved(wanted, static)
    if isinstance(ready.cutting, Turning):
        return limits  # every tool has its own speed, at which the spindle is asked
    for name, most in spindle_limits(ready.scenario.drives, float(ready.cutting.spindle[0])).items():
        limits[name] = min(limits.get(name, math.inf), OF_SPINDLE * most)
    return limits


def refusals(scenario: Scenario, said: Correction, unroll: bool) -> Iterator[Fault]:  # noqa: ARG001
    """What feeds and speeds of a program cannot be corrected for."""
    assert isinstance(scenario, MillingScenario)
    if scenario.program is None and not scenario.setups:
        yield Fault(("program",), "missing: feeds are corrected in the text of a program (or give the corner as one)")
    if scenario.in_3d:
        yield from refusals_in_3d(scenario, said)
        yield from front.refusals(said)
        return
    if not isinstance(scenario.machine, CncMachine):
        yield Fault(("machine",), "feeds are corrected for a machine with feed drives: machine: {library: fadal2216}")
    if PLUNGE in said.limits and (scenario.tool is None or scenario.tool.end_core is None or scenario.stock is None):
        yield Fault(("correct", "limits", PLUNGE), "the end of the mill has no force here: write tool.end_core (0 mm: it cuts over "
                    "its centre) and a stock; plunges keep their feed otherwise")  # fmt: skip
    elif PLUNGE in said.limits and scenario.material is not None and scenario.material.law != "linear":
        yield Fault(("correct", "limits", PLUNGE), "has a linear law of force alone; take a linear material")
    for name in said.limits:
        if name.startswith(("tip_deflection", "chatter")) and not (scenario.tool is not None and scenario.tool.modes):
            yield Fault(
                ("correct", "limits", name),
                "no run of this scenario has such a measure; it needs modes of the tool (tool.modes)",
            )
    yield from objective.refusals(scenario, said)
    yield from front.refusals(said)
    if scenario.stock is None and said.air_clearance is not None:
        yield Fault(("correct", "air_clearance"), "without a stock nothing is known to be air")


def _keeps(
    scenario: MillingScenario, path: ProgramPath, cells: Cells, said: Correction, cutting: Cutting | Turning
) -> BoolArray:
    """Cells that keep their feed: moves in air, or what of them is near the stock, and plunges in contact."""
    block = cells.block
    upright = _upright(path)[path.origin[block]]  # a plunge, and what of a blend belongs to it
    in_air = ~np.bincount(path.origin[block], cells.cuts, path.programmed.count).astype(bool)[path.origin[block]]
    held = in_air | upright
    if PLUNGE in said.limits or PLUNGE in scenario.requirements:  # its own limit says how fast a plunge may be
        held &= ~(cells.plunges & ~cutting.endless if isinstance(cutting, Turning) else cells.plunges)
    if said.air_clearance is None or scenario.stock is None:
        return np.asarray(held)
    return np.asarray(held & (_near(path, cells, said.air_clearance) | (upright & ~(cells.flat < FLAT))))


def _upright(path: ProgramPath) -> BoolArray:
    """Which blocks of the programmed path go straight up or down."""
    told = path.programmed
    return np.asarray(told.straight & (np.hypot(told.along[:, 0], told.along[:, 1]) < FLAT))


def _near(path: ProgramPath, cells: Cells, clearance: float) -> BoolArray:
    """Cells in contact with the stock, and those within a clearance before one [m]."""
    end = path.curve.knots[cells.block] + cells.begin + cells.length
    met = cells.cuts | cells.plunges
    following = np.minimum.accumulate(np.where(met, end - cells.length, np.inf)[::-1])[::-1]
    return np.asarray(met | (following - end < clearance - 1e-9))


def speeds_of(ready: Ready) -> FloatArray:
    """Speed along the path that every cell is programmed for, as far as the machine can run it [m/s]."""
    return np.where(ready.bed.rapid, 0.0, driven(ready, ready.path.feed[ready.cells.block]))


def driven(ready: Ready, feed: FloatArray) -> FloatArray:
    """Feeds as far as the machine can run them, 0 for rapid moves [m/s]."""
    most = ready.scenario.drives.limits.velocity
    able = quickest(ready.scenario, ready.path)[ready.cells.block] if ready.scenario.in_3d else np.full(feed.size, most)
    return np.where(np.isfinite(feed), np.minimum(feed, able), 0.0)


def static_before(ready: Ready) -> dict[str, float]:
    """What the program comes to at its own feeds, the tip at rest."""
    speed = speeds_of(ready)
    found = greatest(ready.cells, values_at(ready.cells, ready.cutting, speed))
    force = plunge_forces(ready.scenario, ready.cells, ready.cutting, speed)
    return found | ({PLUNGE: force} if force is not None else {})


def as_run(ready: Ready, static: dict[str, float], before: Result) -> dict[str, float]:
    """What is held to be equal: of a run in 3D, whose loads are static too, no more than that run has at its own places."""
    if not ready.scenario.in_3d:
        return static
    told = {name: one.value for name, one in before.measures.items()}
    return {name: min(value, told.get(name, value)) for name, value in static.items()}


def with_text(scenario: MillingScenario, text: str) -> MillingScenario:
    """The scenario with another text of its program, whose feeds count: a feed of the operation gives way to them."""
    assert scenario.program is not None
    program: Program = scenario.program.model_copy(update={"text": text})
    operation = scenario.operation.model_copy(update={"feed": None})
    origins = {key: origin for key, origin in scenario.origins.items() if key != "operation.feed"}
    return scenario.model_copy(update={"program": program, "operation": operation}).with_origins(origins)


def proposed(ready: Ready, room: Allowed, ceiling: FloatArray, said: Correction) -> tuple[Schedule, MillingScenario]:
    """The schedule under limits and what simulations have left to the cells [m/s], and the scenario with its text."""
    done = schedule_of(ready, room, ceiling, said)
    return done, with_text(ready.scenario, rewritten(ready.trace, done.parts, ready.known))


def schedule_of(ready: Ready, room: Allowed, ceiling: FloatArray, said: Correction) -> Schedule:
    """The schedule under limits and what simulations have left to the cells [m/s]."""
    own = np.minimum(room.own, ceiling)
    own = np.where(own > 0.0, own, np.minimum(speeds_of(ready), room.each[:, -1]))  # what no feed helps keeps its own
    own = np.maximum(own, 1e-6)
    own = np.where(ends.not_quicker(ready), np.minimum(own, speeds_of(ready)), own)
    if ready.scenario.stock is None:
        own = np.minimum(own, ready.path.feed[ready.cells.block])
    plunging = np.isfinite(room.each[:, NAMES.index(PLUNGE)])
    clearance = said.air_clearance
    if clearance is not None and ready.scenario.stock is not None:  # no quicker than programmed just before contact
        close = _near(ready.path, ready.cells, clearance) & ~(ready.cells.cuts | plunging) & np.isnan(ready.bed.fixed)
        own = np.where(close, np.minimum(own, speeds_of(ready)), own)
        own = np.maximum(own, 1e-6)
    elif clearance is None and ready.scenario.stock is not None:  # what a cutting block runs in air keeps its feed
        own = np.where(ready.cells.cuts | plunging, own, np.minimum(own, np.maximum(speeds_of(ready), 1e-6)))
    inch = ready.trace.first.inch if not ready.trace.looked_at else ready.trace.states[ready.trace.looked_at[-1]].inch
    return scheduled(ready.path, ready.cells, ready.bed, own, ready.scenario.drives, said, inch)


def _blocks(ready: Ready) -> int:
    return int(np.isfinite(ready.path.feed).sum()) if not ready.path.blended else len(
        np.unique(ready.path.origin[np.isfinite(ready.path.feed)])
    )  # fmt: skip


def _static_measures(ready: Ready, proof: prove.Proof, static: Mapping[str, float]) -> dict[str, tuple[float, str]]:
    """Before and after of the largest of all cells at their feeds, the tip at rest; ``static_`` where a run tells it too."""
    after = static if proof.unchanged else greatest(ready.cells, proof.values)
    out = {}
    for name in static.keys() & after.keys() - {"removal_rate_max"}:
        label = f"static_{name}" if name in proof.after.measures else name
        out[f"{label}_before"] = static[name], LIMITED[name]
        out[f"{label}_after"] = after[name], LIMITED[name]
    return {name: out[name] for name in sorted(out)}


def _binding_lengths(ready: Ready, room: Allowed) -> dict[str, tuple[float, str]]:
    """Length of the cells whose own limit each sets."""
    free = np.isnan(ready.bed.fixed) & ~ready.bed.rapid
    which = binding(room.each)
    found = {}
    for place, name in enumerate(NAMES):
        length = float(ready.cells.length[free & (which == place)].sum())
        if length > 0.0:
            found[f"binding_length_{name}"] = length, "length"
    return found


def _changes(ready: Ready, room: Allowed, done: Schedule, proof: prove.Proof) -> Iterator[Change]:
    """One line for the whole, and which limit binds how far."""
    binds = sorted(_binding_lengths(ready, room).items(), key=lambda item: -item[1][0])
    told = ", ".join(
        f"{name.removeprefix('binding_length_')} on {units.show(value, 'length', 3)}" for name, (value, _) in binds[:4]
    )
    if done.parts and not proof.unchanged:
        lines = len(done.parts)
        yield Change(
            "F", f"{_blocks(ready)} blocks", f"{done.blocks} blocks", f"feeds of {lines} lines; what binds: {told}"
        )


def _along(ready: Ready, room: Allowed, done: Schedule) -> Along:
    """Feed before and after over what the place allows."""
    moving = ~ready.bed.rapid
    return Along(
        ready.cells.way[moving], speeds_of(ready)[moving], done.feed[moving], done.cap[moving],
        np.where(np.isnan(ready.bed.fixed), binding(room.each), -1)[moving].astype(np.int64), NAMES, "speed",
        "feed along the path",
    )  # fmt: skip
