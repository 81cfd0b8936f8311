"""``change: feed`` of a deburring pass: the feed at which a yielding spindle takes the burr off, place by place."""

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.revision import revisions
from cutwise.io.scenario import read_document
from cutwise.maths.curves import FloatArray, Polyline
from cutwise.physics.structure.statics import borders
from cutwise.process import deburring, deburring_part
from cutwise.process.assemble import deburring_cell
from cutwise.process.loops import EdgeCell, programmed_time
from cutwise.process.plateaus import equilibrium, feed_for
from cutwise.spec.correct import Correction
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.spindle import CompliantSpindle
from cutwise.study.band import simulate
from cutwise.study.correct.outcome import Along, Change, Proposal, Task
from cutwise.study.levers import levers_of

_NODES = 2e-3  # [m] between places whose feed is told, where correct.station is left out
_QUANTILE = 1.6448536269514722  # of the normal distribution at 95 %
_UNKNOWN = 0.4  # of the tolerance: how far below zero is aimed where nothing says how the burr scatters
_GAINS = 1e-3  # of the time: less is nothing
_LOOKS = 7  # halvings of the search for the aim
_FEED = "operation.feed"
_ONCE = ("spindle.pressure", "operation.preset")  # what is set once for a pass
_VALUES = 7  # of each of them that are tried


class Pass(NamedTuple):
    """A pass that was run: edge error at the lowest point of the mill over the way of the tool."""

    time: float  # [s] of the whole
    place: FloatArray  # [m] along the edge, commanded, shape (n,)
    error: FloatArray  # [m], shape (n,)

    def judged(self, begin: float, end: float) -> tuple[float, float]:
        """Least and greatest error between two places [m]."""
        inside = self.error[(self.place >= begin) & (self.place <= end)]
        return float(inside.min()), float(inside.max())

    def share(self, begin: float, end: float, tolerance: float) -> float:
        """Share of the length between two places whose error is within the tolerance."""
        inside = (self.place >= begin) & (self.place <= end)
        way = np.gradient(self.place[inside])
        return float((way * (np.abs(self.error[inside]) <= tolerance)).sum() / way.sum())


class Plan(NamedTuple):
    """What a feed law is made of."""

    scenario: DeburringScenario
    cell: EdgeCell
    nodes: FloatArray  # [m], shape (n,)
    ahead: float  # [m] how far a node looks ahead
    feeds: tuple[float, float]  # [m/s]
    begin: float  # [m] from where the edge is judged
    end: float


class Answer(NamedTuple):
    """A feed law with what is set once, and what it leaves."""

    given: DeburringScenario
    plan: Plan
    feeds: FloatArray
    aim: float
    told: list[str]
    after: Pass
    kept: list[str]


def corrected(task: Task) -> Proposal:
    """The feed along an edge that holds the spindle at its plateau, and a little into the work.

    Raises
    ------
    ScenarioFault
        The spindle does not yield, or the pass has no feed of its own.
    """
    first = task.scenario
    assert isinstance(first, DeburringScenario)
    settings = list(_settings(first, task.said))
    answers = [_answer(first, one, task.said) for one in settings]
    chosen = min(range(len(answers)), key=lambda k: (len(answers[k].kept), answers[k].after.time))
    given, plan, feeds, aim, told, after, _ = answers[chosen]
    tolerance = plan.scenario.operation.tolerance
    best = _with_feeds(given, plan, feeds)
    before = _run(_cell_of(first), first)
    found = _found(plan, task.said, feeds, before, after)
    kept = _kept(found, tolerance) or _not_gained(first, plan, task.said, before, after)
    return Proposal(
        best,
        (*_turned(first, settings[chosen]), _change(plan, feeds, before, after)),
        {**found, "edge_error_aimed": (aim, "small_length"), "look_ahead": (plan.ahead, "small_length")},
        (*told, *_limited(plan, feeds)),
        tuple(kept),
        (_along(plan, feeds),),
        simulate(best, None),
    )


def _settings(scenario: DeburringScenario, said: Correction) -> Iterator[Mapping[str, float]]:
    """What is set once for a pass: every combination of a few values within ``correct.ranges``."""
    unknown = said.ranges.keys() - {_FEED, *_ONCE}
    if unknown:
        there = f"there are {_FEED}, {' and '.join(_ONCE)}"
        raise ScenarioFault([
            Fault(("correct", "ranges", key), f"is no lever of change: feed here; {there}") for key in sorted(unknown)
        ])  # fmt: skip
    spans = {key: said.ranges[key] for key in _ONCE if key in said.ranges}
    levers = levers_of(scenario, spans, "correct.ranges") if spans else ()
    for values in product(*(np.linspace(lever.low, lever.high, _VALUES).tolist() for lever in levers)):
        yield dict(zip((lever.key for lever in levers), values, strict=True))


def _answer(first: DeburringScenario, setting: Mapping[str, float], said: Correction) -> Answer:
    """The feed law with some settings, and what it leaves."""
    given = revisions(first)(setting) if setting else first
    assert isinstance(given, DeburringScenario)
    plan = _plan(given, said)
    aim, told = _aim(plan, said, plan.scenario.operation.tolerance)
    feeds = law(plan, aim)
    best = _with_feeds(given, plan, feeds)
    after = _run(_cell_of(best), best)
    found = _found(plan, said, feeds, after, after)
    return Answer(given, plan, feeds, aim, told, after, _kept(found, plan.scenario.operation.tolerance))


def _found(
    plan: Plan, said: Correction, feeds: FloatArray, before: Pass, after: Pass
) -> dict[str, tuple[float, str]]:  # fmt: skip
    """Measures of the correction."""
    found: dict[str, tuple[float, str]] = {}
    tolerance = plan.scenario.operation.tolerance
    for name, one in (("before", before), ("after", after)):
        low, high = one.judged(plan.begin, plan.end)
        found |= {
            f"time_{name}": (one.time, "time"),
            f"edge_error_min_{name}": (low, "small_length"),
            f"edge_error_max_{name}": (high, "small_length"),
            f"edge_ideal_{name}": (one.share(plan.begin, plan.end, tolerance), "dimensionless"),
        }
    found["time_saved"] = (1.0 - after.time / before.time, "dimensionless")
    found |= _scattered(_with_feeds(plan.scenario, plan, feeds), plan, said)
    return found


def _turned(first: DeburringScenario, setting: Mapping[str, float]) -> Iterator[Change]:
    """Settings that are not as they were."""
    for lever in levers_of(first, {key: first.levers[key] for key in setting}) if setting else ():
        if lever.now is None or abs(setting[lever.key] - lever.now) > 1e-9 * abs(lever.now):
            yield Change(
                lever.key,
                lever.shown(lever.now, 4),
                lever.shown(setting[lever.key], 4),
                "the least time within the tolerance",
            )


def _plan(given: DeburringScenario, said: Correction) -> Plan:
    scenario = deburring_part.on_part(given)
    faults = []
    if not isinstance(scenario.spindle, CompliantSpindle):
        faults.append("a rigid spindle takes what its path says: a feed changes the edge little; move the path")
    if scenario.numerics.mode == "still":
        faults.append("at rest (numerics.mode: still) a pass has no feed that could vary")
    if scenario.path is not None and scenario.path.arc is not None and not scenario.follows:
        faults.append("a tool that keeps its attitude on an arc is nowhere at rest against its pistons")
    if scenario.operation.limit_feed:
        faults.append("operation.limit_feed has the joints of the robot say the feed")
    if deburring_cell(scenario).feeding is not None:
        faults.append("feed drives run a line at one feed here")
    if faults:
        raise ScenarioFault([Fault(("correct", "change"), f"feed: {why}") for why in faults])
    length = scenario.operation.run_length
    spacing = said.station if "station" in said.model_fields_set else _NODES
    nodes = np.append(np.arange(0.0, length - 0.25 * spacing, spacing), length)
    cell = deburring_cell(scenario)._replace(paced=None)
    lead = scenario.operation.lead_in_time * scenario.operation.feed
    feeds = _range(scenario, said)
    begin = said.judge_from
    if begin is None:
        begin = 1.25 * lead + 2.0 * cell.cutter.mill.radius
    end = length - scenario.operation.lead_out_time * feeds[1]
    if begin >= end:
        raise ScenarioFault([Fault(("correct", "judge_from"), f"the edge is judged from {units.show(begin, 'length')} on, and the "
                                   f"run ends at {units.show(end, 'length')}")])  # fmt: skip
    ahead = said.look_ahead if said.look_ahead is not None else _ahead(cell)
    return Plan(scenario, cell, nodes, ahead, feeds, begin, end)


def _range(scenario: DeburringScenario, said: Correction) -> tuple[float, float]:
    """Lowest and highest feed [m/s]."""
    span = said.ranges.get(_FEED) or scenario.levers[_FEED]
    (lever,) = levers_of(scenario, {_FEED: span}, "correct.ranges")
    return lever.low, lever.high


def _ahead(cell: EdgeCell) -> float:
    """Way from the commanded axis to the middle between axis and entry of the deflected mill [m], of the mean burr."""
    height, width = (float(one.value.mean()) for one in cell.layers[:2])
    assert cell.ring is not None  # the spindle yields, or there is no plan
    radius, piston = cell.cutter.mill.radius, cell.ring.piston
    friction = 0.0 if piston.law == 0 else piston.friction_dynamic
    rest = equilibrium(cell, piston.pressure_force + friction, height, width, borders(cell.ring))
    arm = cell.reach - cell.layers.strips.burr_start - 0.5 * width
    moved = 0.0 if rest is None else arm * float(rest.tilt[0])
    depth = min(height, radius)
    return moved + 0.5 * math.sqrt(max(0.0, depth * (2.0 * radius - depth)))


def law(plan: Plan, aim: float) -> FloatArray:
    """Feed at the nodes for an edge error [m/s]; during the lead-in the least of its own, so that it keeps its time."""
    burr = plan.cell.layers
    known: dict[tuple[float, float], float] = {}
    feeds = np.empty(len(plan.nodes))
    for k, place in enumerate(plan.nodes):
        size = _at(burr.burr_height, place + plan.ahead), _at(burr.burr_width, place + plan.ahead)
        if size not in known:
            known[size] = feed_for(plan.cell, *size, aim, plan.feeds)
        feeds[k] = known[size]
    lead_in = plan.scenario.operation.lead_in_time
    count = 1
    while count < len(feeds) and plan.nodes[count - 1] < lead_in * float(feeds[:count].min()):
        count += 1
    feeds[:count] = feeds[:count].min()
    return feeds


def _at(profile: Polyline, place: float) -> float:
    return float(np.interp(place, profile.at, profile.value))


def _aim(plan: Plan, said: Correction, tolerance: float) -> tuple[float, list[str]]:
    """The edge error that is aimed at [m]: as far below zero as the scatter of the burr asks for."""
    if said.aim is not None:
        return said.aim, []
    show = lambda value: units.show(value, "small_length", 3)  # noqa: E731
    if said.burr_scatter is None:
        aim = -_UNKNOWN * tolerance
        return aim, [f"nothing says how the burr scatters (correct.burr_scatter): {show(aim)} is aimed at, {_UNKNOWN:g} of the "
                     "tolerance below zero"]  # fmt: skip
    high = 1.0 + _QUANTILE * said.burr_scatter

    def left(aim: float) -> float:
        return _run(_scaled(_cell_of(_with_feeds(plan.scenario, plan, law(plan, aim))), high), plan.scenario).judged(
            plan.begin, plan.end
        )[1]

    if left(0.0) <= tolerance:
        return 0.0, [
            f"a burr {high:.3g} times as high (95 %) is still taken off when nothing is left of the nominal one"
        ]
    if left(-tolerance) > tolerance:
        return -tolerance, [
            f"a burr {high:.3g} times as high (95 %) leaves more than {show(tolerance)} at any such feed"
        ]
    low, top = -tolerance, 0.0
    for _ in range(_LOOKS):
        middle = 0.5 * (low + top)
        if left(middle) <= tolerance:
            low = middle
        else:
            top = middle
    return low, [
        f"{show(low)} is aimed at: a burr {high:.3g} times as high (95 %) then leaves no more than {show(tolerance)}"
    ]


def _not_gained(
    first: DeburringScenario, plan: Plan, said: Correction, before: Pass, after: Pass
) -> list[str]:  # fmt: skip
    """Why a new feed is of no use: the pass as it was kept the tolerance too, and took no longer."""
    if before.time > after.time * (1.0 + _GAINS):
        return []
    tolerance = plan.scenario.operation.tolerance
    low, high = before.judged(plan.begin, plan.end)
    scattered = _scattered(first, plan, said)
    spread = [low, high, *(value for value, _ in scattered.values())]
    if min(spread) < -tolerance or max(spread) > tolerance:
        return []
    times = [units.show(one.time, "time", 4) for one in (before, after)]
    burr = " with the burr that scatters too" if scattered else ""
    return [
        f"nothing is gained: the pass as it was keeps the tolerance{burr}, in {times[0]}; this feed takes {times[1]}"
    ]


def _scattered(best: DeburringScenario, plan: Plan, said: Correction) -> dict[str, tuple[float, str]]:
    """Errors of a pass with a burr as low and as high as one in twenty is."""
    if said.burr_scatter is None:
        return {}
    share = _QUANTILE * said.burr_scatter
    low = _run(_scaled(_cell_of(best), 1.0 - share), best).judged(plan.begin, plan.end)[0]
    high = _run(_scaled(_cell_of(best), 1.0 + share), best).judged(plan.begin, plan.end)[1]
    return {"edge_error_min_p5": (low, "small_length"), "edge_error_max_p95": (high, "small_length")}


def _scaled(cell: EdgeCell, factor: float) -> EdgeCell:
    """The same edge with a burr so many times as high."""
    height = cell.layers.burr_height
    return cell._replace(
        layers=cell.layers._replace(burr_height=height._replace(value=max(0.0, factor) * height.value))
    )


def _cell_of(scenario: DeburringScenario) -> EdgeCell:
    return deburring_cell(deburring_part.on_part(scenario))


def _run(cell: EdgeCell, scenario: DeburringScenario) -> Pass:
    history = deburring.run_for(scenario, cell)(cell, scenario.numerics.time_step)
    run = deburring.evaluate(cell, history)
    place = programmed_time(cell, history) * cell.path.feed
    return Pass(float(history.motion.time[-1]), place, run.error_at_tool)


def _with_feeds(given: DeburringScenario, plan: Plan, feeds: FloatArray) -> DeburringScenario:
    """The scenario with a feed at each node."""
    document: dict[str, Any] = given.document()
    operation: dict[str, Any] = dict(document["operation"])
    operation.pop("duration", None)
    operation["feed"] = units.text(float(feeds[0]), "speed")
    operation["length"] = units.text(plan.scenario.operation.run_length, "length")
    operation["feed_profile"] = {"columns": profile(plan, feeds)}
    document["operation"] = operation
    found = read_document(document, given.name)
    assert isinstance(found, DeburringScenario)
    return found


def profile(plan: Plan, feeds: FloatArray) -> Mapping[str, list[float]]:
    """The columns of the feed table."""
    return {
        "w [mm]": [float(f"{1e3 * place:.9g}") for place in plan.nodes],
        "feed [mm/s]": [float(f"{1e3 * feed:.9g}") for feed in feeds],
    }


def _change(plan: Plan, feeds: FloatArray, before: Pass, after: Pass) -> Change:
    operation = plan.scenario.operation
    old = "as its table" if operation.feed_profile is not None else units.show(operation.feed, "speed", 4)
    new = f"{units.show(float(feeds.min()), 'speed', 4)} to {units.show(float(feeds.max()), 'speed', 4)}"
    worst = [units.show(max(map(abs, one.judged(plan.begin, plan.end))), "small_length", 3) for one in (before, after)]
    why = f"at each place as the burr ahead asks for: the edge is off by {worst[1]} at most, not {worst[0]}"
    return Change(_FEED, old, new, why)


def _limited(plan: Plan, feeds: FloatArray) -> list[str]:
    """Feeds that stand at an end of their range."""
    told = []
    for end, word in zip(plan.feeds, ("lowest", "highest"), strict=True):
        share = float(np.mean(np.isclose(feeds, end, rtol=1e-9)))
        if share > 0.0:
            told.append(
                f"the {word} feed ({units.show(end, 'speed')}, correct.ranges) binds at {100 * share:.3g} % of the places"
            )
    return told


def _kept(found: Mapping[str, tuple[float, str]], tolerance: float) -> list[str]:
    kept = []
    for names, words in (
        (("edge_error_min_after", "edge_error_max_after"), "with the nominal burr"),
        (("edge_error_min_p5", "edge_error_max_p95"), "with the burr that scatters"),
    ):
        if names[0] not in found:
            continue
        low, high = found[names[0]][0], found[names[1]][0]
        if low < -tolerance or high > tolerance:
            spread = f"{units.show(low, 'small_length', 3)} to {units.show(high, 'small_length', 3)}"
            allowed = f"± {units.show(tolerance, 'small_length', 3)} (operation.tolerance)"
            kept.append(f"{words} the edge error is {spread}, outside {allowed}")
    return kept


def _along(plan: Plan, feeds: FloatArray) -> Along:
    n, operation = len(feeds), plan.scenario.operation
    before = np.full(n, operation.feed)
    if operation.feed_profile is not None:
        before = np.interp(plan.nodes, *operation.feed_profile.points())
    binds = np.where(feeds >= plan.feeds[1] * (1 - 1e-9), 0, np.where(feeds <= plan.feeds[0] * (1 + 1e-9), 1, 2))
    return Along(
        plan.nodes, before, feeds, np.full(n, plan.feeds[1]), binds.astype(np.int64),
        ("highest feed", "lowest feed", "plateau of the spindle"), "speed", "Feed along the edge",
    )  # fmt: skip
