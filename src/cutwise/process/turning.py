"""Turning a shaft: pass by pass and place by place at rest, with the shaft as it stands there, half turned."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.loop import Cell
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.insert import InsertEdge, chip_slopes
from cutwise.physics.cutting.regeneration import depth_limit
from cutwise.physics.engagement.insert import ELEMENTS, SEEN, Bar, Insert, edge_rows, ridge
from cutwise.physics.structure.shaft import Shaft, Support, modes, shaft, yields
from cutwise.physics.structure.terms import Compliance, in_series
from cutwise.process import chatter, yielding
from cutwise.process.convergence import divided
from cutwise.process.edges import edges_alike
from cutwise.process.labels import Column, Coordinate, Group, Over
from cutwise.process.passes import at_rest, too_soft, wrenches
from cutwise.process.recipes import Method, Recipe, halved
from cutwise.records import CONTACT
from cutwise.results import Finding, Place, SolverFailure, warned
from cutwise.spec.base import known
from cutwise.spec.turning import TurningScenario
from cutwise.still import Rest

LIMITS = (
    "Every place is at rest under the mean force of the cut: run-in, ripple and built-up edge are left out.",
    "The shaft bends in proportion to the force: no buckling by the centre, no weight, no heat; jaws alike all round.",
    "The edge is sharp, without inclination and wear, and cuts the thinnest chip; a real one rubs below some micrometres.",
    "Roughness is that of the geometry; the real one is higher, above all at small feeds.",
    "Chatter is looked for where a pass meets most yielding, with its directions of force; the flank damps nothing.",
)
_PARABOLA = 4.0 / (9.0 * math.sqrt(3.0))  # mean deviation of a parabola over its height
_MODES, _MESH, _HIGHEST = 8, 16, 1.6  # modes; stations they are found from; times the lowest frequency looked at
_NONE = np.zeros((1, 6, 6))


class Setup(NamedTuple):
    """A shaft in its lathe; places are distances from the headstock end [m]."""

    scenario: TurningScenario
    ends: FloatArray  # of the sections, shape (sections,)
    marks: FloatArray  # both ends, those of the sections, the steady rest
    z: FloatArray  # stations in the order of the feed, shape (n,)
    supports: Mapping[str, Support]

    def section(self, z: FloatArray) -> np.ndarray:
        """Section at some places; where two meet, the far one."""
        return np.minimum(np.searchsorted(self.ends, z + 1e-9, side="right"), len(self.ends) - 1)

    def speed(self, radius: FloatArray) -> FloatArray:
        """Spindle speed at some radii [rad/s]."""
        operation = self.scenario.operation
        speed = operation.spindle_speed or known(operation.cutting_speed) / radius
        return np.broadcast_to(speed, np.shape(radius))


class Pass(NamedTuple):
    """What a pass does with each section, shape (sections,)."""

    before: FloatArray  # nominal radius [m]
    goal: FloatArray  # radius at which the tool is led [m]
    feed: FloatArray  # [m/rev]
    turned: np.ndarray  # whether it is turned


class Turned(NamedTuple):
    """A finished pass at the m stations that it turns."""

    plan: Pass
    z: FloatArray  # [m], shape (m,)
    goal: FloatArray  # radius at which the tool was led [m], shape (m,)
    feed: FloatArray  # [m/rev], shape (m,)
    parts: Mapping[str, FloatArray]  # compliance of each thing that yields, shape (m, 6, 6)
    terms: tuple[Compliance, Compliance]  # the tool, and the shaft on its supports
    rest: Rest
    error: FloatArray  # of the diameter [m], shape (m,)

    def moved(self) -> dict[str, FloatArray]:
        """Displacement by each thing that yields [m], shape (m, 3)."""
        return {k: np.einsum("nij,nj->ni", c[:, :3, :3], self.rest.total[:, :3]) for k, c in self.parts.items()}


def setup(scenario: TurningScenario) -> Setup:
    """Stations at the ends of sections, at a steady rest and between; what holds the shaft."""
    lathe, rigid, step = scenario.lathe, math.inf, scenario.numerics.station
    ends = np.cumsum([section.length for section in scenario.part.sections])
    marks = np.unique(np.round([0.0, *ends, lathe.steady_position or 0.0], 9))
    steps = [np.linspace(a, b, math.ceil((b - a) / step - 1e-9), endpoint=False) for a, b in pairwise(marks)]
    z = np.append(np.concatenate(steps), marks[-1])
    clamped = (lathe.headstock_angular_stiffness or rigid) if lathe.headstock == "chuck" else 0.0
    supports = {"headstock": Support(0.0, lathe.headstock_stiffness or rigid, clamped)}
    if lathe.tailstock == "centre":
        supports["tailstock"] = Support(marks[-1], lathe.tailstock_stiffness or rigid, 0.0)
    if lathe.steady_position is not None:
        supports["steady"] = Support(lathe.steady_position, lathe.steady_stiffness or rigid, 0.0)
    return Setup(scenario, ends, marks, z[::-1] if scenario.operation.towards == "headstock" else z, supports)


def passes(scenario: TurningScenario) -> Iterator[Pass]:
    """Equal levels down to the allowance of the last pass, the last pass, spring passes."""
    operation, sections = scenario.operation, scenario.part.sections
    final = np.array([0.5 * section.diameter for section in sections])
    bar = now = np.full(len(final), 0.5 * scenario.part.stock_diameter)
    allowance = operation.finish_depth or (bar - final).max() / operation.passes
    for k in range(1, operation.passes):
        level = bar - k / (operation.passes - 1) * ((bar - final).max() - allowance)
        goal = np.minimum(now, np.maximum(level, final + allowance))
        yield Pass(now, goal, np.full(len(final), operation.feed), goal < now)
        now = goal
    slow = np.array([section.feed or operation.finish_feed or operation.feed for section in sections])
    for _ in range(1 + operation.spring_passes):
        yield Pass(now, final, slow, final < bar)
        now = final


def half_turned(held: Setup, plan: Pass, z: float, goal: float, at: FloatArray) -> tuple[Shaft, float, float]:
    """The shaft over some places when the tool has come to z; that place, and the lever of the feed force there."""
    part, home = held.scenario.part, held.scenario.operation.towards == "headstock"
    at = np.unique(np.round([*at, z], 9))
    middle = 0.5 * (at[1:] + at[:-1])
    diameter = 2.0 * np.where((middle > z) == home, plan.goal[here := held.section(middle)], plan.before[here])
    material = (part.youngs_modulus, part.poisson_ratio, part.density or 0.0)
    return shaft(at, diameter, *material, tuple(held.supports.values())), z, goal if home else -goal


def parts_of(held: Setup, plan: Pass, z: FloatArray, goal: FloatArray) -> dict[str, FloatArray]:
    """Compliance under the tool of each thing that yields, at some places, shape (m, 6, 6); none of what is rigid."""
    tool = held.scenario.tool
    found = {name: np.zeros((len(z), 6, 6)) for name in ("work", *held.supports, "tool")}
    stiff = yielding.spring({1: tool.stiffness}) if tool.stiffness else yielding.modes_at_rest(tool.modes)
    found["tool"] += stiff.matrix
    for k in range(len(z)):
        for name, part in zip(found, yields(*half_turned(held, plan, z[k], goal[k], held.marks)), strict=False):
            found[name][k, :2, :2], found[name][k, 2, 2] = part, part[1, 1]
    return {name: matrix for name, matrix in found.items() if matrix.any()}


def run(held: Setup, off: float = 0.0, like: list[Turned] | None = None) -> list[Turned]:
    """All passes, on a bar whose radius is off by a little [m]; ``like``: the run on the nominal bar, which yields alike."""
    scenario, z, done = held.scenario, held.z, []
    at, section = np.abs(z - z[0]), held.section(z)
    bar = Bar(at, np.full(len(z), 0.5 * scenario.part.stock_diameter + off))
    for count, plan in enumerate(passes(scenario)):
        here = np.flatnonzero(plan.turned[section])
        goal, feed = plan.goal[section[here]], plan.feed[section]
        parts = like[count].parts if like else parts_of(held, plan, z[here], goal)
        tool = Compliance(np.zeros(1), parts.get("tool", _NONE)[:1])
        terms = (tool, Compliance(at[here], sum(parts.values(), _NONE) - tool.matrix))
        insert = Insert(scenario.tool.nose_radius, scenario.tool.lead_angle, feed)
        cell = Cell((), insert, bar, InsertEdge(edges_alike(scenario.material)), in_series(list(terms)))
        poses = np.zeros((len(here), 8))
        poses[:, 1], poses[:, 3] = at[here], goal
        soft = partial(_too_soft, z[here])
        found = at_rest(cell, poses, soft, seen=SEEN, contacts=ELEMENTS)
        error = 2.0 * (bar.radius[here] - goal)
        done.append(Turned(plan, z[here], goal, feed[here], parts, terms, found, error))
    return done


def _too_soft(z: FloatArray, k: int) -> SolverFailure:
    where = f"{units.show(float(z[k]), 'length')} from the headstock"
    return too_soft(where, "reduce operation.feed, or support it (lathe.steady_position)", "the shaft")


def limit_of(held: Setup, done: Turned) -> tuple[float, float]:
    """Depth of cut of a pass where most yields, and the one at which that cut chatters there [m]."""
    part, tool = held.scenario.part, held.scenario.tool
    k = int(np.argmax(sum(c[:, 1, 1] for c in done.parts.values()) * (done.rest.seen[:, 0] > 0.0)))
    mesh = np.append(held.marks, held.z[:: math.ceil(len(held.z) / _MESH)])
    omega, shape = modes(*half_turned(held, done.plan, done.z[k], done.goal[k], mesh), _MODES)

    def of_shaft(at: FloatArray) -> np.ndarray:
        total = np.zeros((len(at), 3, 3), dtype=complex)
        each = 1.0 / (omega**2 - at[:, None] ** 2 + 2j * known(part.damping) * omega * at[:, None])
        total[:, :2, :2] += np.einsum("wm,mi,mj->wij", each, shape, shape)
        total[:, 2, 2] += each @ shape[:, 1] ** 2
        return total

    depth, rows = float(done.rest.seen[k, 0]), np.zeros((ELEMENTS, CONTACT))
    edge_rows(rows, Insert(tool.nose_radius, tool.lead_angle, done.feed), done.feed[k], depth)
    slopes = chip_slopes(rows, edges_alike(held.scenario.material)) / depth
    highest = _HIGHEST * max([omega[0] / (2.0 * math.pi), *(mode.frequency for mode in tool.modes)])
    receptance = known(chatter.together(tool.modes, of_shaft))
    return depth, depth_limit(receptance, slopes, 2.0 * math.pi / float(held.speed(done.goal[k])), highest).depth


def measures(held: Setup, done: list[Turned]) -> dict[str, float]:
    """Measures in SI: form and shares after the last pass, forces and time of all."""
    last, part, tool = done[-1], held.scenario.part, held.scenario.tool
    along = np.argsort(last.z)
    start, end = last.z[along[[0, -1]]].tolist()
    near, middle, far = np.interp(np.linspace(start, end, 3), last.z[along], last.error[along]).tolist()
    force = np.concatenate([one.rest.total[:, :3] for one in done])
    speed = np.concatenate([one.goal * held.speed(one.goal) for one in done])
    lengths, plans = np.diff([0.0, *held.ends]), [one.plan for one in done]
    times = ((lengths / plan.feed / held.speed(plan.goal))[plan.turned].sum() for plan in plans)
    rough = max(ridge(feed, tool.nose_radius, tool.trail_angle) for feed in last.feed)
    found = {
        **yielding.extremes("diameter_error", last.error, mean=True),
        "cylindricity_error": 0.5 * float(np.ptp(last.error)),
        "barrel": float(middle - 0.5 * (near + far)), "taper": float(far - near),
        "roughness_rt": rough, "roughness_ra": _PARABOLA * rough,
        "force_cutting_max": float(force[:, 2].max()), "force_passive_max": float(force[:, 1].max()),
        "force_feed_max": float(-force[:, 0].min()), "cutting_power_max": float((force[:, 2] * speed).max()),
        "cycle_time": 2.0 * math.pi * float(sum(times)),
        **yielding.term_measures(last.moved(), slice(None), int(np.argmax(np.abs(last.error)))),
        **yielding.normal_stiffness(last.terms),
        **yielding.energy_at_rest(last.terms, np.abs(last.z - held.z[0]), wrenches(last.rest.total), last.rest.state),
    }  # fmt: skip
    if part.runout is not None:
        high, low = (run(held, 0.5 * side * part.runout, done)[-1].error for side in (1.0, -1.0))
        found["roundness_error_max"] = 0.5 * float(np.abs(high - low).max())
    if part.damping is not None:
        pairs = [limit_of(held, one) for one in done[: held.scenario.operation.passes] if one.rest.seen[:, 0].any()]
        for depth, limit in sorted(pairs, key=lambda pair: pair[0] / pair[1])[-1:]:
            found |= chatter.measures(depth, limit)
    return found


def _of_passes(held: Setup, done: list[Turned], read: Callable[[Turned], FloatArray]) -> FloatArray:
    """Something of every pass over the distance from the headstock end, zero where one turns nothing; shape (z, cut)."""
    z = np.sort(held.z)
    table = np.zeros((len(z), len(done)))
    for k, one in enumerate(done):
        table[np.searchsorted(z, one.z), k] = read(one)
    return table


def _each(read: Callable[[Turned], FloatArray]) -> Callable[[tuple[Setup, list[Turned]]], FloatArray]:
    return lambda run: _of_passes(*run, read)


_OVER: Over = {
    "z": Coordinate(lambda run: np.sort(run[0].z), "m", "distance from the headstock end"),
    "cut": lambda run: range(1, len(run[1]) + 1),
}
GROUPS = {
    "engagement": Group({
        "depth": Column("z cut", _each(lambda one: one.rest.seen[:, 0]), "m", "depth of cut, shaft and tool bent"),
        "chip": Column("z cut", _each(lambda one: one.rest.seen[:, 1]), "m", "mean chip thickness"),
    }, _OVER),
    "cutting": Group({
        "force_cutting": Column("z cut", _each(lambda one: one.rest.total[:, 2]), "N", "force along the cutting speed"),
        "force_passive": Column("z cut", _each(lambda one: one.rest.total[:, 1]), "N", "force on the tool, off the shaft"),
        "force_feed": Column("z cut", _each(lambda one: -one.rest.total[:, 0]), "N", "force on the tool against the feed"),
    }, _OVER),
    "surface": Group({
        "diameter_error": Column("z cut", _each(lambda one: one.error), "m", "diameter error; positive: too thick"),
    }, _OVER),
}  # fmt: skip


def _off_shaft(name: str, one: Turned) -> FloatArray:
    return one.moved()[name][:, 1]


def stages(done: list[Turned]) -> Mapping[str, Group]:
    """What the passes did, and the displacement by each thing that yields."""
    moved = {
        f"deflection_{name}": Column("z cut", _each(partial(_off_shaft, name)), "m", f"off the shaft: {name}")
        for name in done[-1].parts
    }  # fmt: skip
    return {**GROUPS, "structure": Group(moved, _OVER)}


def warnings(scenario: TurningScenario, done: list[Turned]) -> Iterator[Finding]:
    """Chips for which the coefficients do not hold."""
    chips = (one.rest.seen[one.rest.seen[:, 0] > 0.0, 1].min(initial=math.inf) for one in done)
    beyond = (scenario.material.beyond(chip, "mean chip") for chip in chips if chip < math.inf)
    yield from (warned("beyond_data", f"material: {text}", where=Place("material")) for text in beyond if text)


def notes(done: list[Turned]) -> dict[str, str]:
    """Where the diameter is off most, and what yields there."""
    last, worst = done[-1], int(np.argmax(np.abs(done[-1].error)))
    shares = ", ".join(f"{k} {units.show(float(v[worst, 1]), 'small_length', 3)}" for k, v in last.moved().items())
    place, off = units.show(float(last.z[worst]), "length"), units.show(float(last.error[worst]), "small_length", 3)
    return {
        "worst": f"The diameter is off most {place} from the headstock, by {off}; radius: {shares or 'nothing yields'}."
    }


def _finer(scenario: TurningScenario) -> dict[str, float]:
    """The measures with half the distance of stations; what the shaft yields by along its axis is none that converges."""
    held = setup(divided(scenario, "station"))
    return {name: value for name, value in measures(held, run(held)).items() if name[-2:] != "_x"}


def _whole(scenario: TurningScenario, *_: object) -> tuple[Setup, list[Turned]]:
    held = setup(scenario)
    return held, run(held)


PASSES: Method[TurningScenario, tuple[Setup, list[Turned]]] = Method(
    run=_whole,
    measures=lambda _, done: measures(*done),
    stages=lambda _, done, __: stages(done[1]),
    findings=lambda _, __, found: chatter.findings(found, "shaft"),
    limits=lambda *_: LIMITS,
    references=lambda *_: ("altintas2012",),
    warnings=lambda scenario, done, _: warnings(scenario, done[1]),
    notes=lambda _, done, __: notes(done[1]),
    change=halved(lambda scenario, *_: _finer(scenario), shares=False),
)

RECIPE = Recipe(lambda _: PASSES, setup)
