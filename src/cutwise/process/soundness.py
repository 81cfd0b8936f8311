"""What leaves nothing to be judged, process by process: findings that decide the verdict before any requirement does."""

from collections.abc import Iterator, Mapping

import numpy as np

from cutwise.physics.structure.pistons import SWEEPS
from cutwise.process import milling_wall
from cutwise.process.chamfer import ChamferRun
from cutwise.process.chamfer_cut import FAR_ROUND
from cutwise.process.deburring import EdgeRun
from cutwise.process.drilling import DrillRun, dynamics
from cutwise.process.loops_drilling import step_limit
from cutwise.process.loops_drives import NO_FORCE
from cutwise.process.machine import MachinePass
from cutwise.process.milling import MillRun, tip_limit
from cutwise.process.milling_measures import SETTLED
from cutwise.process.milling_stability import TipStability, stable_settings
from cutwise.results import Finding, Place
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.milling import MillingScenario

_STOP = 1e-9  # share of a stroke
_DRIFT = 5e-6  # [m] by which the edge may still move over the part of the pass that is judged
_GONE = 0.01  # share of the edge along which contact may be lost
_LAST = 0.25  # of the time at the end point, in which a tool that has settled moves no more
_CREEP = 0.5e-6  # [m]
_WATCHED = 0.2  # [s] at least, before a tool that stands off its end point counts as held there by friction


def deburr(scenario: DeburringScenario, run: EdgeRun) -> Iterator[Finding]:
    """At the stop, never touching, contact lost, still moving, pistons not solved."""
    travel, stroke = run.history.response.travel, run.cell.ring.piston.stroke
    time = run.history.motion.time
    stopped = np.flatnonzero(travel.max(axis=1) >= stroke * (1.0 - _STOP))
    if stopped.size:
        yield Finding("at_stop", Place(time=float(time[stopped[0]])), float(travel.max()), stroke, "length")
    depth = run.history.engagement.burr_depth + run.history.engagement.work_depth
    if depth[run.steady].max() <= 0.0:
        yield Finding("untouched")
    else:
        yield from _left_standing(scenario, run, depth)
    yield from _drifting(run)
    unsolved = np.flatnonzero(run.history.response.sweeps >= SWEEPS)
    if unsolved.size:
        yield Finding("unsolved", Place(time=float(time[unsolved[0]])), float(unsolved.size), 0.0)


def _left_standing(scenario: DeburringScenario, run: EdgeRun, depth: np.ndarray) -> Iterator[Finding]:
    """A mill that is off the work although it is led into it, and leaves more than the tolerance there."""
    motion, cell = run.history.motion, run.cell
    led = motion.height < np.interp(motion.position, cell.layers.burr_height.at, cell.layers.burr_height.value)
    judged = (motion.time >= cell.path.lead_in) & (np.arange(motion.time.size) < run.steady.stop)
    gone = led & judged & (depth <= 0.0)
    left = gone & (run.error_at_tool > scenario.operation.tolerance)
    share = float(left.sum() / max(1, judged.sum()))
    if share > _GONE:
        first = int(np.flatnonzero(left)[0])
        where = Place(time=float(motion.time[first]), position=float(motion.position[first]))
        yield Finding("contact_lost", where, share, _GONE)


def _drifting(run: EdgeRun) -> Iterator[Finding]:
    """A steady part that begins before the lead-in has ended, or in which the edge still moves though nothing else does."""
    motion, steady, layers = run.history.motion, run.steady, run.cell.layers
    began = float(motion.time[steady.start])
    if run.cell.path.lead_in > began:
        yield Finding("unsettled", Place(time=began), run.cell.path.lead_in, began, "time")
        return
    at = motion.position[steady]
    led = (motion.height[steady], *(np.interp(at, p.at, p.value) for p in (layers.burr_height, layers.burr_width)))
    if any(np.ptp(one) > 1e-9 for one in led):
        return  # waves of path and burr: the edge follows them for good
    error = run.error_at_tool[steady]
    third = max(1, error.size // 3)
    drift = float(error[-third:].mean() - error[:third].mean())
    if abs(drift) > _DRIFT:
        yield Finding("unsettled", Place(time=began), drift, _DRIFT, "small_length")


def mill(
    scenario: MillingScenario, run: MillRun, steady: TipStability | None, *, helped: bool = True
) -> Iterator[Finding]:
    """Chatter, a tip that has swung away, a mill that cuts nothing, rapid moves through the stock, a tool still moving.

    ``helped``: what would be stable is looked for and run.
    """
    if steady is not None:
        yield from _chatter(scenario, steady, helped=helped)
    if run.lost is not None:
        yield Finding("tip_lost", Place(time=run.lost), limit=tip_limit(scenario), dimension="length")
    asked = run.cut.law != NO_FORCE or scenario.stock is not None
    if asked and not run.contact.immersion.any():
        yield Finding("untouched")
    yield from _collisions(run.contact.into.collisions)
    if run.wall is not None:
        yield from milling_wall.findings(scenario, run.wall)
    yield from _moving(run)


def _chatter(scenario: MillingScenario, steady: TipStability, *, helped: bool) -> Iterator[Finding]:
    growing = {name: case.chatter.growth for name, case in steady.cases.items() if not case.chatter.stable}
    remedy = stable_settings(scenario, steady) if growing and helped else None
    for name, growth in growing.items():
        yield Finding("unstable", Place(name), growth, 1.0, measure=f"chatter_growth_{name}", remedy=remedy)


def arm_mill(found: Mapping[str, float]) -> Iterator[Finding]:
    """A depth at which the arm chatters; the value is the depth over its limit."""
    if found.get("depth_margin", 1.0) <= 0.0:
        yield Finding("unstable", Place("arm"), 1.0 - found["depth_margin"], 1.0, measure="depth_margin")


def _collisions(lines: tuple[int, ...]) -> Iterator[Finding]:
    if lines:
        yield Finding("collides", Place(line=lines[0]), float(len(lines)), 0.0)


def _moving(run: MillRun) -> Iterator[Finding]:
    """A tool that is not at the end point when the run ends, and moves or was not watched long enough to be stuck."""
    after = run.reference.time >= run.reference.end
    if run.lost is not None or not after.any():
        return
    place = run.history.position[after, :2]
    last = place[int((1.0 - _LAST) * len(place)) :]
    away = float(np.hypot(*(last - run.reference.point[-1, :2]).T).max())
    watched = float(run.reference.time[-1]) - run.reference.end
    if away > SETTLED and (watched < _WATCHED or float(np.ptp(last, axis=0).max()) > _CREEP):
        yield Finding("unsettled", Place("the end point"), away, SETTLED, "small_length")


def chamfer(run: ChamferRun, found: Mapping[str, float]) -> Iterator[Finding]:
    """At the stop, dragged round the bends, an edge that still stands, a rod that rubs, a ball that cuts nothing."""
    for path, one in zip(run.paths, run.deflected, strict=False):
        if one.stopped:
            yield Finding("at_stop", Place(path.work.name), one.travel, one.travel, "length")
        elif one.round_bend > FAR_ROUND:
            yield Finding("tip_lost", Place(path.work.name), one.round_bend, FAR_ROUND, "angle")
        elif one.moves.unsolved:
            yield Finding("unsolved", Place(path.work.name), float(one.moves.unsolved), 0.0)
    if run.forces and not any(forces.force.any() for forces in run.forces):
        yield Finding("untouched")
    for name in ("width_min", "width_deflected_min"):
        if found.get(name) == 0.0:
            yield Finding("edge_stands", measure=name, value=0.0, dimension="length")
    planned = min((path.rod.value for path in run.paths if path.rod is not None), default=0.0)
    rod = found.get("rod_clearance_deflected_min", found.get("rod_clearance_min", 0.0))
    if rod < 0.0 <= planned:  # carried there by the spindle, or by preset and part error
        yield Finding("rubs", value=rod, limit=0.0, dimension="length")


def drill(run: DrillRun, time_step: float) -> Iterator[Finding]:
    """A tip that is pushed out of the cut, a step too long for the arm."""
    for number, hole in enumerate(run.holes, 1):
        if hole.posture is None or hole.outcome is None:
            continue
        if hole.outcome.feed_min <= 0.0:
            yield Finding("contact_lost", Place(f"hole {number}"), hole.outcome.feed_min, 0.0, "feed_per_revolution")
        largest = step_limit(run.cell.cycle, dynamics(run.cell, hole.posture), float(run.cell.profile.thrust.max()))
        if time_step > largest:
            yield Finding("unsolved", Place(f"hole {number}"), time_step, largest, "time")


def machine(run: MachinePass | None) -> Iterator[Finding]:
    """A program that cuts nothing, rapid moves through the stock, a spindle at rest in the cut."""
    if run is None:
        return
    cut, way = run.run.cell.cut, run.run.cell.way
    if cut.immersion is not None and not cut.immersion.any():
        yield Finding("untouched")
    yield from _collisions(way.into.collisions)
    if way.still:
        yield Finding("at_rest", Place(line=way.still[0]), float(len(way.still)), 0.0)
