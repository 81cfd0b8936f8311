"""The spindle speed of an NC program from the lobes of its tool, at the heaviest contact that the program has."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.physics.cutting import stability
from cutwise.physics.cutting.stability import limit_depth
from cutwise.physics.engagement.stock import removal_area
from cutwise.physics.structure.modes import Modes, free_motion
from cutwise.process import assemble_mill
from cutwise.process.loops_drives import Cut
from cutwise.process.milling_contact import SteadyPatch, patch_of
from cutwise.process.milling_stability import coefficients_of, milling_of, stays_stable
from cutwise.programs.rewrite import with_speed
from cutwise.programs.trace import traced
from cutwise.results import Infeasible
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault
from cutwise.spec.milling import MillingScenario
from cutwise.spec.scenario import Scenario
from cutwise.study.correct import feed
from cutwise.study.correct.cells import FloatArray
from cutwise.study.correct.feed import Ready, prepared
from cutwise.study.correct.limits import asked
from cutwise.study.correct.loads import tip_compliance
from cutwise.study.correct.objective import cost_at
from cutwise.study.correct.outcome import Change, Proposal, Task

KEY = "operation.spindle_speed"
_GRID = (100.0, 10.0)  # rpm: speeds that are looked at, and more closely where none of them is stable
_AROUND = (0.5, 1.5)  # of the speed, where no range is given
_FARTHEST = 20_000.0  # rpm, up to which speeds are looked for to be told
_UNSURE = 0.02  # share by which natural frequencies may be off: assumed, where no fit tells their scatter
_DEEPEST = 4.0  # of the depth: how far a limit is looked for
_TOLD = 2  # other speeds that are told
_RPM = math.pi / 30.0
_TRIED, _CLOSER = 9, 2  # speeds over the range whose cost is looked at, and how often closer around the cheapest


class Depths(NamedTuple):
    """Limits of the axial depth at a speed [m]."""

    speed: float  # [rpm]
    limit: float
    slower: float  # with natural frequencies 2 % lower
    quicker: float  # 2 % higher

    @property
    def least(self) -> float:
        """The least of the three."""
        return min(self.limit, self.slower, self.quicker)


class Lobes(NamedTuple):
    """A contact and the tip that meets it."""

    cut: Cut
    tip: Modes
    patch: SteadyPatch

    def growth(self, speeds: FloatArray) -> FloatArray:
        """Growth of vibration per tooth at the depth of the contact, at speeds [rpm]."""
        case = milling_of(self.cut, self.patch, coefficients_of(self.cut, self.patch))
        found = stability.lobes(
            speeds * _RPM,
            np.array([self.patch.depth]),
            case,
            stability.Tip(*self.tip),
            lambda t: free_motion(self.tip, t),
        )
        return np.asarray(found[:, 0])

    def depths(self, speed: float) -> Depths:
        """Limits at a speed [rpm], also with frequencies that are off."""
        case = milling_of(self.cut, self.patch, coefficients_of(self.cut, self.patch))

        def limit(factor: float) -> float:
            tip = self.tip._replace(frequency=self.tip.frequency * factor, mass=self.tip.mass / factor**2)
            deepest = _DEEPEST * self.patch.depth
            return limit_depth(speed * _RPM, case, stability.Tip(*tip), lambda t: free_motion(tip, t), deepest)

        return Depths(speed, *(limit(factor) for factor in (1.0, 1.0 - _UNSURE, 1.0 + _UNSURE)))


def corrected(task: Task) -> Proposal:
    """The quickest stable speed of the range, at the top of its lobe; feeds stay what they are."""
    scenario = task.scenario
    assert isinstance(scenario, MillingScenario)
    ready = prepared(scenario, task.said)
    now = float(ready.cutting.spindle[0]) / _RPM
    low, high = _range(task, now)
    if task.said.objective == "cost":
        return _cheapest(task, ready, now, low, high)
    if not scenario.tool.modes:
        return _proposal(task, now, high, "no mode of the tool limits it: the upper end of the range", {}, ())
    lobes = _lobes(scenario, ready.cells.patches, now)
    chosen, others = _chosen(lobes, low, high)
    depth = lobes.patch.depth
    if chosen is None:
        told = "; ".join(_shown(one, depth) for one in others) or "none that was looked at"
        raise Infeasible(
            f"no spindle speed from {low:.0f} to {high:.0f} rpm is stable at the depth of {units.show(depth, 'length', 3)}: {told}"
        )
    before = lobes.depths(now)
    why = (
        f"the heaviest contact {'chattered' if before.limit <= depth else 'was stable'}, limit depth "
        f"{units.show(before.limit, 'length', 3)} → {units.show(chosen.limit, 'length', 3)}"
    )
    measures = {"stability_margin": (chosen.limit / depth, "dimensionless")}
    return _proposal(task, now, chosen.speed, why, measures, tuple(_said(chosen, others, depth)))


def _cheapest(task: Task, ready: Ready, now: float, low: float, high: float) -> Proposal:
    """The speed at which a part costs least with the feeds that go with it, of the stable ones."""
    scenario = ready.scenario
    static = feed.static_before(ready)
    wanted = asked(scenario, task.said, walls=bool(tip_compliance(scenario).any()))
    lobes = _lobes(scenario, ready.cells.patches, now) if scenario.tool.modes else None
    cost: dict[float, float] = {}
    width = high - low
    speeds = np.unique(np.append(np.linspace(low, high, _TRIED), np.clip(now, low, high)))
    for _ in range(_CLOSER + 1):
        for speed in speeds.round(0).tolist():
            if speed not in cost and speed > 0.0 and (lobes is None or _stands(lobes, speed)):
                cost[speed] = cost_at(ready, task, static, wanted, speed * _RPM)
        known = {speed: value for speed, value in cost.items() if math.isfinite(value)}
        if not known:
            raise Infeasible(f"no spindle speed from {low:.0f} to {high:.0f} rpm is stable and keeps the limits")
        best = min(known, key=known.__getitem__)
        width /= 0.5 * (_TRIED - 1)
        speeds = np.clip(best + width * np.linspace(-0.5, 0.5, 5), low, high)
    shown = ", ".join(
        f"{units.show(cost[s], 'money', 4)} at {s:.0f} rpm" for s in sorted({min(known), best, max(known)})
    )
    return _proposal(task, now, best, f"the part is cheapest there by the plan ({shown})", {}, ())


def _stands(lobes: Lobes, speed: float) -> bool:
    """Whether the heaviest contact is stable at a speed [rpm]."""
    return bool(lobes.growth(np.array([speed]))[0] < 1.0) and stays_stable(
        lobes.cut, lobes.tip, lobes.patch, speed * _RPM
    )


def refusals(scenario: Scenario, said: Correction, unroll: bool) -> Iterator[Fault]:
    """What the speed of a program cannot be chosen for."""
    assert isinstance(scenario, MillingScenario)
    yield from feed.refusals(scenario, said, unroll)
    if scenario.in_3d:
        yield Fault(("correct", "change"), "speed: chatter is not looked at in a stock in 3D, and every tool has its own speed, "
                    "so that none is better than another; change: feed, and write S in the program")  # fmt: skip
        return
    if scenario.program is not None and scenario.stock is None:
        yield Fault(("stock",), "missing: without it the heaviest contact is not known, and the speed stays")
    modes = scenario.tool is None or scenario.tool.modes
    if not modes and KEY not in said.ranges and said.objective != "cost":
        yield Fault(("tool", "modes"), f"missing: no speed is better than another; write the modes, or correct.ranges: {{{KEY}: "
                    "[8000 rpm, 9700 rpm]} for a tool that does not chatter")  # fmt: skip
    for key in said.ranges:
        if key != KEY:
            yield Fault(("correct", "ranges", key), f"is nothing that is turned here; speed turns {KEY}")
    yield from _wrong_range(said)


def _wrong_range(said: Correction) -> Iterator[Fault]:
    """What is wrong with the ends of a range."""
    ends = []
    for place, text in enumerate(said.ranges.get(KEY, ())):
        try:
            ends.append(units.parse(text, "angular_speed"))
        except units.UnitFault as fault:
            yield Fault(("correct", "ranges", KEY, place), str(fault))
    if len(ends) == 2 and not 0.0 < ends[0] <= ends[1]:
        yield Fault(("correct", "ranges", KEY), "has to go from a positive speed up to a higher one")


def _range(task: Task, now: float) -> tuple[float, float]:
    """Speeds between which one is looked for [rpm]."""
    given = task.said.ranges.get(KEY)
    low, high = _AROUND[0] * now, _AROUND[1] * now
    if given is not None:
        low, high = (units.parse(text, "angular_speed") / _RPM for text in given)
    assert isinstance(task.scenario, MillingScenario)
    machine = task.scenario.drives
    for curve in (machine.spindle_power, machine.spindle_torque):  # the spindle has nothing beyond its curves
        if curve is not None:
            at = curve.points()[0]
            low, high = max(low, at[0] / _RPM), min(high, at[-1] / _RPM)
    if low > high:
        raise Infeasible(f"{KEY}: the curves of the spindle have no speed of the range")
    return low, high


def _lobes(scenario: MillingScenario, patches: FloatArray, now: float) -> Lobes:
    """The contact with the largest cross-section, in which a tool chatters first."""
    area = removal_area(patches, 0.5 * scenario.tool.diameter)
    heaviest = int(np.argmax(area))
    if not area[heaviest] > 0.0:
        raise Infeasible("the program meets no material: no speed is better than another")
    cut = assemble_mill.cut(scenario, now * _RPM, float(patches[..., 3].max()))
    tip = assemble_mill.tip_modes(scenario)
    assert tip is not None
    fed = scenario.operation.feed or 0.0
    chip = max(fed * 2.0 * math.pi / (now * _RPM * scenario.tool.flutes), 1e-5)
    return Lobes(cut, tip, patch_of(patches[heaviest], chip))


def _chosen(lobes: Lobes, low: float, high: float) -> tuple[Depths | None, Sequence[Depths]]:
    """The top of the quickest stable lobe of the range, and others that may be told."""
    for grid in _GRID:
        speeds = np.arange(math.ceil(low / grid), math.floor(high / grid) + 1).astype(np.float64) * grid
        speeds = speeds[speeds > 0.0]
        if speeds.size == 0:
            continue
        growth = lobes.growth(speeds)
        for band in reversed(_bands(growth < 1.0)):
            tops = sorted(
                (lobes.depths(float(speed)) for speed in speeds[band]), key=lambda one: one.least, reverse=True
            )
            found = next(
                (one for one in tops if stays_stable(lobes.cut, lobes.tip, lobes.patch, one.speed * _RPM)), None
            )
            if found is not None:
                return found, _others(lobes, found.speed)
    return None, _others(lobes, math.nan)


def _bands(good: np.ndarray) -> list[np.ndarray]:
    """Runs of neighbours that are good; of a wide one seven evenly taken."""
    at = np.flatnonzero(good)
    runs = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size else []
    return [run[np.unique(np.linspace(0, run.size - 1, min(run.size, 7)).round().astype(int))] for run in runs]


def _others(lobes: Lobes, chosen: float) -> list[Depths]:
    """Tops of the lobes over all speeds that are looked at, the deepest first."""
    now = lobes.cut.spindle / _RPM
    speeds = np.arange(math.ceil(_AROUND[0] * now / 100.0), max(_FARTHEST, _AROUND[1] * now) / 100.0 + 1) * 100.0
    growth = lobes.growth(speeds)
    inner = np.flatnonzero((growth[1:-1] <= growth[:-2]) & (growth[1:-1] <= growth[2:])) + 1
    tops = [lobes.depths(float(speeds[k])) for k in inner[np.argsort(growth[inner])][: _TOLD + 1]]
    return sorted((one for one in tops if one.speed != chosen), key=lambda one: one.least, reverse=True)[:_TOLD]


def _shown(one: Depths, depth: float) -> str:
    del depth
    deep = [units.show(value, "length", 3) if math.isfinite(value) else "no limit found" for value in one[1:]]
    return (
        f"{one.speed:.0f} rpm holds {deep[0]} ({deep[1]} and {deep[2]} with natural frequencies 2 % lower and higher)"
    )


def _said(chosen: Depths, others: Sequence[Depths], depth: float) -> Iterator[str]:
    """How sure the choice is, and what else there is."""
    if chosen.least > depth:
        yield f"stable also with natural frequencies 2 % off (assumed): {_shown(chosen, depth)}"
        return
    rivals = " or ".join(
        f"{one.speed:.0f} rpm ({units.show(one.limit, 'length', 3)})" for one in others if one.least > depth
    )
    yield (
        f"{units.show(depth, 'length', 3)} is stable at {chosen.speed:.0f} rpm only if natural frequencies are known better than "
        f"2 % (assumed): {_shown(chosen, depth)}; sure are {units.show(chosen.least, 'length', 2)} at {chosen.speed:.0f} rpm"
        f"{', or ' + rivals if rivals else ''}"
    )


def _proposal(
    task: Task, now: float, speed: float, why: str, measures: dict[str, tuple[float, str]], told: tuple[str, ...]
) -> Proposal:  # fmt: skip
    """The scenario and its program at another speed."""
    scenario = task.scenario
    assert isinstance(scenario, MillingScenario)
    given = scenario.program
    assert given is not None
    trace = traced(given.text, given.file, setup_of(given))
    assert trace is not None
    text, written = with_speed(trace, speed)
    if abs(speed - now) < 1e-6 * now:
        return Proposal(scenario, (), measures, (*told, f"the spindle speed stays at {now:.0f} rpm: {why}"))
    update: dict[str, object] = {"program": given.model_copy(update={"text": text})}
    origins = dict(scenario.origins)
    key = "S"
    if scenario.operation.spindle_speed is not None or not written:
        key = KEY if not written else f"S and {KEY}"
        update["operation"] = scenario.operation.model_copy(update={"spindle_speed": speed * _RPM})
        origins.pop(KEY, None)
    new = scenario.model_copy(update=update).with_origins(origins)
    change = Change(key, f"{now:.0f} rpm", f"{speed:.0f} rpm", why)
    return Proposal(new, (change,), measures, told)
