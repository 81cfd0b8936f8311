"""A mill that goes as programmed along a wall, carried by a robot, a machine whose bodies yield, or something firm.

At rest, place by place, or stepped under the mean force; and the depth at which it chatters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from cutwise.loop import Cell
from cutwise.maths.curves import FloatArray, no_cubic
from cutwise.paths.carried import CarriedPath
from cutwise.physics.cutting.flutes import TurnFlutes
from cutwise.physics.cutting.regeneration import (
    DepthLimit,
    Receptance,
    depth_limit,
    linked_receptance,
    mean_directions,
    swinging_receptance,
)
from cutwise.physics.cutting.uneven import largest_radius, tangent_coefficients
from cutwise.physics.engagement.shoulder import SEEN
from cutwise.physics.motion.edge import EdgePass
from cutwise.physics.motion.paced import Paced
from cutwise.physics.motion.shifted import Shifted
from cutwise.physics.structure.swings import Swinging
from cutwise.physics.structure.terms import Compliance, Rigid
from cutwise.process import (
    carriage,
    carried,
    carriers,
    chatter,
    milling_wall,
    spindles,
    walls,
    yielding,
)
from cutwise.process.convergence import divided
from cutwise.process.edges import edges
from cutwise.process.labels import Column, Coordinate, Group, Groups, Over
from cutwise.process.passes import at_rest, on_path, stepped, structure_of, too_soft, unsolved
from cutwise.results import Finding, Said
from cutwise.spec.base import known
from cutwise.spec.milling import MillingScenario

_SHALLOWER = "reduce operation.axial_depth"
HIGHEST = 800.0  # [Hz] up to which the limit of chatter is looked for
_MODES_HIGHEST = 1.3  # of the highest tip mode, where the tool has modes

AT_REST = "at rest: the mean force of the cut displaces what carries the tool; ripple of the teeth is left out"
STEPPED = "the mean force of the cut acts on spindle and carrier; ripple and regeneration of the chip are left out"
LIMITS = (
    "links and bodies are rigid, joints and guides linear; backlash, drives and their control are left out",
    "the limit of chatter takes the mean directions of the cut, and of a robot one swinging mass or its links",
)


class Milled(NamedTuple):
    """A finished pass of a mill that goes as programmed, at n places of its path; process axes."""

    path: CarriedPath  # stations, in the frame of the carrier
    carriage: carriage.Carriage
    terms: carriage.Terms
    at: FloatArray  # [m] of the path, shape (n,)
    time: FloatArray  # [s], shape (n,)
    seen: FloatArray  # radial depth, axial depth [m], immersion [rad], shape (n, 3)
    state: FloatArray  # columns of the terms, shape (n, k)
    force: FloatArray  # mean force on the tool [N], shape (n, 3)
    tangential: FloatArray  # mean tangential force [N], shape (n,)
    sag: FloatArray  # of the axis where the wall is read [m], shape (n, 3)
    counted: np.ndarray  # in the cut, after the lead-in, shape (n,)
    height: float  # [m] over the tip, where the wall is read
    limits: tuple[DepthLimit, ...]  # of chatter, at some stations
    limit_at: FloatArray  # [m] of the path, where these are
    unsolved: int  # steps in which the forces of pistons were not found

    @property
    def moved(self) -> dict[str, FloatArray]:
        """Displacement by each term where the wall is read [m], shape (n, 3)."""
        return yielding.by_term(self.terms, self.state, self.height)

    @property
    def turned(self) -> FloatArray:
        """Tilt of the tool about the feed, which is the slope of the wall [rad], shape (n,)."""
        return yielding.turned(self.terms, self.state)


def _flutes(scenario: MillingScenario) -> TurnFlutes:
    up = scenario.operation.milling == "up"
    return TurnFlutes(walls.mill_of(scenario), edges(scenario.material, scenario.tool), up)


def _cell(scenario: MillingScenario, structure: NamedTuple, motion: Any = ()) -> Cell:
    engagement = walls.engagement_of(scenario, walls.cut_of(scenario).begins)
    return Cell(motion, engagement, (), _flutes(scenario), structure)


def _poses(scenario: MillingScenario, at: FloatArray, sag: FloatArray, feeds: FloatArray | float) -> FloatArray:
    """The programmed tool at places of the path, moved by the sag of the arm (n, 3) [m], at its feeds there [m/s]."""
    poses = np.zeros((len(at), 8))
    poses[:, 1] = poses[:, 2] = at
    poses[:, 3] = -walls.cut_of(scenario).radial_depth + sag[:, 1]
    poses[:, 4] = sag[:, 2]
    poses[:, 5] = feeds
    return poses


def path_of(scenario: MillingScenario) -> CarriedPath:
    """The stations of the path: in the base frame of a robot, or in the part on a machine."""
    if scenario.robot is None:
        return milling_wall.stations_of(scenario)
    return carriage.stations_of(scenario, walls.path_of(scenario))


def prepare(scenario: MillingScenario) -> tuple[CarriedPath, carriage.Carriage]:
    """What carries the tool along the path: what a check finds out without the cut."""
    path, of = path_of(scenario), walls.cut_of(scenario)
    height, firm = 0.5 * of.axial_depth, Rigid(0.0)

    def rigid() -> FloatArray:
        poses = _poses(scenario, path.at[:1], np.zeros((1, 3)), of.feed)
        return yielding.wrench_at(at_rest(_cell(scenario, firm), poses, seen=SEEN).total[0, :3], height)

    return path, carriage.carrying(scenario, path, rigid, height, of.feed)


def run(
    scenario: MillingScenario, *, limits: bool = True, finer: int = 1, progress: Callable[[float], None] | None = None
) -> Milled:
    """The pass, at rest or in time steps; with the limits of chatter, which take longer.

    ``finer``: by which stations (at rest) or time steps are divided.
    """
    if scenario.numerics.mode == "still" and finer > 1:
        scenario = divided(scenario, "station", finer)
    path, carrying = prepare(scenario)
    terms = (
        *spindles.pistons_of(scenario.compliant, scenario.robot, path.axes[0]),
        *carriage.in_series(scenario.tool, carrying, carriage.off_surface(scenario.part_stiffness)),
    )
    bare = Milled(
        path, carrying, terms, path.at, path.at / walls.cut_of(scenario).feed, np.zeros((0, 3)), np.zeros((0, 0)),
        np.zeros((0, 3)), np.zeros(0), sag_of(path, carrying, 0.5 * walls.cut_of(scenario).axial_depth),
        path.at >= (walls.cut_of(scenario).begins), 0.5 * walls.cut_of(scenario).axial_depth, (), np.zeros(0), 0,
    )  # fmt: skip
    done = _at_rest(scenario, bare) if scenario.numerics.mode == "still" else _stepped(scenario, bare, finer, progress)
    if not limits:
        return done
    rows = np.unique(np.linspace(0, len(path.at) - 1, min(9, len(path.at))).round().astype(int))
    each = tuple(_limit(scenario, carrying, int(k), done.height) for k in rows)
    return done._replace(limits=each, limit_at=path.at[rows])


def feeds_of(scenario: MillingScenario, carrying: carriage.Carriage, at: FloatArray) -> FloatArray:
    """The feed at the stations [m/s], lowered where the joints of a robot cannot follow it and that is asked for."""
    feed = walls.cut_of(scenario).feed
    if carrying.arm is None or not scenario.operation.limit_feed:
        return np.full(len(at), feed)
    return carried.feeds_along(carrying.arm, known(scenario.robot), feed)


def sag_of(path: CarriedPath, carrying: carriage.Carriage, height: float) -> FloatArray:
    """Sag of the axis at a height over the tip, at the stations [m], shape (n, 3)."""
    return (
        np.zeros((len(path.at), 3)) if carrying.arm is None else carried.sag_at(carrying.arm, height) * [0.0, 1.0, 1.0]
    )


def _at_rest(scenario: MillingScenario, bare: Milled) -> Milled:
    poses = _poses(scenario, bare.at, bare.sag, feeds_of(scenario, bare.carriage, bare.at))
    cell = _cell(scenario, structure_of(bare.terms))
    found = at_rest(cell, poses, lambda k: too_soft(on_path(bare.at[k]), _SHALLOWER), seen=SEEN)
    return bare._replace(seen=found.seen, state=found.state, force=found.total[:, :3], tangential=found.total[:, 3])


def _stepped(
    scenario: MillingScenario, bare: Milled, finer: int, progress: Callable[[float], None] | None
) -> Milled:  # fmt: skip
    """In time steps, the mean force acting on pistons and a swinging arm; from the uncut surface on in the lead-in."""
    of, lead = walls.cut_of(scenario), scenario.operation.lead_in_time
    way = EdgePass(of.feed, bare.path.at[-1] / of.feed, lead, 0.0, 0.0, of.radial_depth, 0.0, 0.0, no_cubic())
    motion: NamedTuple = Shifted(way, bare.path.at, bare.sag)
    duration = way.duration
    if scenario.operation.limit_feed:
        pace = carried.slowed(known(bare.carriage.arm), known(scenario.robot), of.feed)
        motion, duration = Paced(motion, *pace), float(pace.at[-1])
    history = stepped(
        _cell(scenario, structure_of(bare.terms), motion), lambda row: too_soft(on_path(row[1]), _SHALLOWER),
        duration=duration, time_step=scenario.time_step / finer, seen=SEEN, layers=1, contacts=1, progress=progress,
    )  # fmt: skip
    table, at = history.table, history.table[:, 1]
    force = history.force[:, 0] * np.array([1.0, 1.0, -1.0])  # as a structure feels it
    sag = np.column_stack([np.interp(at, bare.path.at, one) for one in bare.sag.T])
    counted = (at >= of.begins) & (at >= lead * of.feed * (1.0 - 1e-12))
    return bare._replace(
        at=at, time=table[:, 0], seen=history.shown, state=history.columns, force=force, tangential=history.tangential,
        sag=sag,
        counted=counted if counted.any() else np.arange(len(at)) == len(at) - 1,
        unsolved=len(unsolved(history, bare.terms)),
    )  # fmt: skip


def _limit(scenario: MillingScenario, carrying: carriage.Carriage, k: int, height: float) -> DepthLimit:
    """Limit of chatter at a station: the receptances of everything with mass together, of arm and tip modes."""
    mill, flutes = walls.round_of(scenario), _flutes(scenario)
    up = scenario.operation.milling == "up"
    angle = math.pi if walls.is_slot(scenario) else math.acos(1.0 - walls.cut_of(scenario).radial_depth / mill.radius)
    lo, hi = (0.0, angle) if up else (math.pi - angle, math.pi)
    chip = 2.0 * math.pi * walls.cut_of(scenario).feed / (mill.flutes * mill.spindle_speed)
    mean_chip = chip * (math.cos(lo) - math.cos(hi)) / (hi - lo)
    directions = mean_directions(lo, hi, mill.flutes, tangent_coefficients(flutes.edges, mean_chip), up=up)
    receptance = _receptance(scenario, carrying, k, height)
    if receptance is None:
        return DepthLimit(math.inf, math.nan)
    highest = max([HIGHEST, *(_MODES_HIGHEST * mode.frequency for mode in scenario.tool.modes)])
    period = 2.0 * math.pi / (mill.flutes * mill.spindle_speed)
    return depth_limit(receptance, directions, period, highest)


def _receptance(scenario: MillingScenario, carrying: carriage.Carriage, k: int, height: float) -> Receptance | None:
    """Displacement at the tip for a force there, of arm and tip modes together; None where nothing has mass."""
    of_arm: Receptance | None = None
    if carrying.arm is not None:
        swing = carried.swings_of(known(scenario.robot), carrying.arm, height)
        if isinstance(swing, Swinging):
            of_arm = swinging_receptance(swing.stiffness[k], swing.damping[k], swing.mass)
        else:
            station = (swing.spring[k], swing.damper[k], swing.gain[k], swing.jacobian[k])
            of_arm = linked_receptance(*station, height, carrying.arm.base[k])
    turn = np.eye(3) if carrying.path is None else carrying.path.axes[k]
    return chatter.together(scenario.tool.modes, of_arm, turn)


def outermost(scenario: MillingScenario) -> float:
    """How far run-out carries the outermost flute [m]."""
    tool = scenario.tool
    return largest_radius(tool.runout, tool.runout_angle, tool.flutes) if tool.runout else 0.0


def wall_and_floor(scenario: MillingScenario, done: Milled) -> tuple[FloatArray, FloatArray]:
    """Error of wall and floor along the path [m], positive into the part: what the tool yields by and sags.

    The wall is cut by the flute that run-out carries outermost; of a slot, this is the wall on the side of the work.
    """
    total = sum(done.moved.values(), np.zeros((len(done.at), 3)))
    return outermost(scenario) - (total[:, 1] + done.sag[:, 1]), -(total[:, 2] + done.sag[:, 2])


def cycle_time(scenario: MillingScenario, done: Milled) -> float:
    """From the first to the last place of the path [s]."""
    feed = walls.cut_of(scenario).feed
    if done.carriage.arm is None or not scenario.operation.limit_feed:
        return float(done.path.at[-1] / feed)
    return float(carried.slowed(done.carriage.arm, known(scenario.robot), feed).at[-1])


def _worst(scenario: MillingScenario, done: Milled) -> int:
    """The place of the cut at which the wall is off most."""
    off = np.abs(wall_and_floor(scenario, done)[0] - outermost(scenario))
    return int(np.argmax(np.where(done.counted, off, -1.0)))


def measures(scenario: MillingScenario, done: Milled) -> dict[str, float]:
    """Measures in SI."""
    wall, floor = (one[done.counted] for one in wall_and_floor(scenario, done))
    of, worst = walls.cut_of(scenario), _worst(scenario, done)
    found = {
        **walls.measures(wall, floor, slot=walls.is_slot(scenario), deeper=outermost(scenario)),
        "wall_tilt_max": float(np.abs(done.turned[done.counted]).max()),
        "cycle_time": cycle_time(scenario, done),
        "path_length": float(done.path.at[-1]),
        "force_xy_mean_straight": float(np.hypot(done.force[:, 0], done.force[:, 1]).max()),
        "engagement_angle_max": float(done.seen[:, 2].max()),
    }
    found |= yielding.term_measures(done.moved, done.counted, worst)
    each = [term for _, term in done.terms]
    if each and all(isinstance(term, Compliance) for term in each) and scenario.numerics.mode == "still":
        found |= yielding.energy_at_rest(each, done.at, yielding.wrench_at(done.force, done.height), done.state)
    if done.limits:
        least = min(limit.depth for limit in done.limits)
        found |= chatter.measures(of.axial_depth, least) if math.isfinite(least) else {}
    found |= spindles.stroke_left(scenario.compliant, done.state)
    found |= carriers.measures(scenario, done.carriage, done.terms, of.feed, limited=scenario.operation.limit_feed)
    if done.carriage.arm is None:
        return found
    return found | yielding.lowest_frequency([carried.swings_of(known(scenario.robot), done.carriage.arm, done.height)])


def warnings(scenario: MillingScenario, done: Milled) -> Iterator[Said]:
    """What is known of the carrier, and a cut that is more than the motor of a spindle on pistons has."""
    yield from carriers.warnings(scenario, [done.carriage], scenario.block)
    yield from walls.overload(scenario, done.tangential[done.counted])


def findings(scenario: MillingScenario, done: Milled) -> Iterator[Finding]:
    """At the stop, pistons or a displacement that were not found, a spindle that still moves, a mill that cuts nothing."""
    if not done.seen[:, 2].any():
        yield Finding("untouched")
    if done.unsolved:
        yield Finding("unsolved", value=float(done.unsolved), limit=0.0)
    if scenario.compliant is not None:
        off = done.moved["pistons"][:, 1]
        yield from spindles.findings(scenario.compliant, done.time, done.state, off, done.counted)


def _limits(done: Milled, name: str) -> FloatArray | None:
    """Depth or frequency at the stations where chatter was looked for, if it is limited anywhere."""
    if not any(math.isfinite(one.depth) for one in done.limits):
        return None
    return np.array([getattr(one, name) for one in done.limits])


_OVER: Over = {
    "s": Coordinate(lambda done: done.at, "m", "place along the path"),
    "s_limit": Coordinate(lambda done: done.limit_at, "m", "place along the path"),
    "axis": "xyz",
}
GROUPS = {
    "engagement": Group({
        "radial_depth": Column("s", lambda done: done.seen[:, 0], "m", "radial depth of cut, the tool displaced"),
        "axial_depth": Column("s", lambda done: done.seen[:, 1], "m", "axial depth of cut, the tool displaced"),
        "immersion": Column("s", lambda done: done.seen[:, 2], "rad", "immersion angle"),
    }, _OVER),
    "cutting": Group({"force": Column("s axis", lambda done: done.force, "N", "mean force on the tool")}, _OVER),
    "stability": Group({
        "stable_depth": Column("s_limit", lambda done: _limits(done, "depth"), "m", "depth at which it chatters"),
        "frequency": Column("s_limit", lambda done: _limits(done, "frequency"), "Hz", "frequency of that vibration"),
    }, _OVER),
}  # fmt: skip


def stages(scenario: MillingScenario, done: Milled) -> Groups:
    """Histories along the path."""
    wall, floor = wall_and_floor(scenario, done)
    surface = {
        "wall_error": Column("s", lambda _: wall, "m", "error of the wall, positive into the part"),
        "floor_error": Column("s", lambda _: floor, "m", "error of the floor, positive into the part"),
    }
    moved = carriers.deflections(done.moved, "the wall", "s", _OVER)
    carrier = carriers.of_carrier(done.carriage, scenario.robot, done.height, done.at, done.moved)
    return {**GROUPS, "structure": moved, "surface": Group(surface, _OVER), **carrier}


def limits_of(scenario: MillingScenario) -> tuple[str, ...]:
    """What the run leaves out."""
    return (AT_REST if scenario.numerics.mode == "still" else STEPPED, *LIMITS)


def notes(scenario: MillingScenario, done: Milled) -> dict[str, str]:
    """Where the wall is off most and whose fault it is; what another angle of the tool would bring."""
    wall, worst = wall_and_floor(scenario, done)[0], _worst(scenario, done)
    return {
        "wall": walls.note(done.at[worst], wall[worst], done.moved, worst),
        **carriers.notes(done.carriage, done.height, float(done.at[worst]), done.moved, worst),
    }
