"""A shift of a path along its normal, learned against what the drives make of it."""

import math
import warnings
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import at_blocks
from cutwise.physics.motion.driven import SetPoints
from cutwise.physics.motion.learning import Rule, convergence, learned, rule_for
from cutwise.process.milling import Commanded, contour_error, followed, timed
from cutwise.process.program_path import ProgramPath
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct.bent import Bend, Walls, bend_of
from cutwise.study.correct.corners import OVER, meeting, sharp_corners
from cutwise.study.correct.level import BEFORE_CURVE, cut_level, first_bend, first_place, stops, stretches

BEFORE_END = 20e-3  # [s] before the end until which it may, and from a stop on either side
_AFTER_STOP = 0.1  # [s] behind a stop, in which an error comes from it
_SHORT = 0.25  # of the spacing: no chord is shorter, its direction would be that of rounding
GAINS = 0.02  # share by which a repetition has to lessen the error to be worth another
_GAINS_OF_WALLS = (0.5, 2.0)  # within which a secant is believed


class Plant(NamedTuple):
    """One machine with its cut, as it is or as it may be."""

    scenario: MillingScenario
    told: Commanded
    walls: Walls | None = None  # that its tool is pushed off from


class Seen(NamedTuple):
    """Errors of plants at the servo instants, positive to the right of the wanted path [m]."""

    error: FloatArray  # drives, and the middle of what the tool is bent by at walls that stay, shape (plants, n)
    half: FloatArray  # by which the heights of a wall, and both walls of a slot, are off on either side, (plants, n)
    bend: FloatArray  # the tool's part of the error, shape (plants, n)
    into: FloatArray  # least and greatest error of walls that stay, into the part, NaN: none, shape (plants, n, 2)

    @property
    def worst(self) -> FloatArray:
        """Largest error at any height, shape (plants, n)."""
        return np.asarray(np.abs(self.error) + self.half)


class Learned(NamedTuple):
    """A shift and how it came about."""

    along: FloatArray  # [m] of the wanted path, rising, shape (n,)
    shift: FloatArray  # [m] to the right of it, shape (n,)
    trail: tuple[float, ...]  # largest contour error before each repetition and after the last [m]
    rule: Rule
    whole: bool = False  # shifted from the first cut on: walls are, that a tool is bent off from
    kept: FloatArray | float = 0.0  # error that is not learned, of parts that differ by chance [m], shape (n,)

    def at(self, place: FloatArray) -> FloatArray:
        """Shift at places along the wanted path [m]."""
        return np.interp(place, self.along, self.shift)

    def kept_at(self, place: FloatArray) -> FloatArray:
        """Error that is left as it is, at places along the wanted path [m]."""
        return np.interp(place, self.along, np.broadcast_to(self.kept, self.along.shape))


def right_normal(direction: FloatArray) -> FloatArray:
    """Unit normals to the right of directions in the xy plane, shape (n, 2).

    >>> right_normal(np.array([[1.0, 0.0, 0.0]])).tolist()
    [[0.0, -1.0]]
    """
    flat = np.maximum(np.hypot(direction[:, 0], direction[:, 1]), 1e-300)
    return np.column_stack([direction[:, 1], -direction[:, 0]]) / flat[:, None] + 0.0


def window(told: Commanded, *, whole: bool = False) -> npt.NDArray[np.bool_]:
    """Servo instants at which the path may be shifted.

    From 3 mm before the first bend (without one, and where the ``whole`` path is looked at, from the first cut) to 20 ms before
    the end, in cuts that stay at one height;
    without the 20 ms before every place where such a cut stops: what a drive runs on beyond its end lies along the path, and
    no shift beside the path takes it away.
    """
    place, cut = told.place, cut_level(told.wanted)
    bend = None if whole else first_bend(told.wanted)
    first = float(told.wanted.curve.knots[:-1][cut][0]) if bend is None else bend - BEFORE_CURVE
    active = cut[place.block] & (place.travelled > first) & (place.time < place.end - BEFORE_END)
    return active & ~_near_stops(told, BEFORE_END, 0.0)


def judged(told: Commanded, *, whole: bool = False) -> npt.NDArray[np.bool_]:
    """Servo instants whose error a shift is judged by: those at which the path may be shifted, but for the 20 ms behind a stop.

    What a drive ran on beyond a corner is an error beside the path that goes on from there. A shift leads it back, but not in
    no time. Where walls are looked at on the whole path, a tool in air counts for nothing.
    """
    counts = window(told, whole=whole) & ~_near_stops(told, 0.0, BEFORE_END)
    return counts & (told.contact.immersion > 0.0) if whole else counts


def behind_stop(told: Commanded, error: FloatArray, *, whole: bool = False) -> bool:
    """Whether the largest error that is judged comes from a stop a little before."""
    worst = int(np.argmax(np.where(judged(told, whole=whole), np.abs(error), 0.0)))
    return bool(_near_stops(told, 0.0, _AFTER_STOP)[worst])


def _near_stops(told: Commanded, before: float, behind: float) -> npt.NDArray[np.bool_]:
    """Servo instants up to so long before and behind stops [s]."""
    place, near = told.place, np.zeros(len(told.place.time), np.bool_)
    sharp = np.zeros(0) if told.wanted is told.path else sharp_corners(told.wanted)
    for joint in np.flatnonzero(stops(told.wanted)):
        end = place.time[_stop(told, int(joint), beside=bool((sharp == joint).any()))]
        near[slice(*np.searchsorted(place.time, [end - before, end + behind], side="right"))] = True
    return near


def _stop(told: Commanded, joint: int, *, beside: bool) -> int:
    """Servo instant at which the tool stands at a joint: the last one before it.

    A path that is led to a corner ``beside`` the wanted one stops before the nearest place of the wanted path changes.
    """
    place = told.place
    last = int(np.searchsorted(place.block, joint, side="right")) - 1
    if not beside:
        return last
    near = np.abs(place.travelled - told.wanted.curve.knots[joint + 1]) < OVER
    return int(np.argmin(np.where(near, told.reference.speed, math.inf))) if near.any() else last


def frequency_of(told: Commanded, jerk: float) -> float:
    """Highest v/r along the path, the rate in Hz at which a shift has to follow its bends.

    Of a path without arcs: one over the time of a ramp from rest at the highest speed.
    """
    curve, block = told.wanted.curve, told.place.block
    bend = np.where(cut_level(told.wanted), np.abs(curve.curvature), 0.0)[block]
    highest = float((bend * told.reference.speed).max())
    if highest > 0.0:
        return highest
    speed = float(told.reference.speed.max())
    return math.inf if speed <= 0.0 else 0.5 * math.sqrt(jerk / speed)


def shifted(told: Commanded, shift: FloatArray) -> SetPoints:
    """Set points moved to the right of the wanted path at each servo instant [m], shape (n,).

    In sharp corners they go to where both shifted sides meet: what a drive runs on beyond the end of one side is an error beside
    the other, and a corner that is drawn back takes it away.
    """
    order, step, place = told.order, told.drives[0].law.sample_time, told.place
    point, off = order.point.copy(), shift[:, None] * right_normal(place.direction)
    for joint in sharp_corners(told.wanted):
        end = int(np.searchsorted(place.block, joint, side="right"))
        if not 0 < end < len(shift) or not (shift[end - 1] or shift[end]):
            continue
        corner = told.wanted.curve.knots[joint + 1]
        begin = int(np.searchsorted(place.travelled[:end], corner - OVER, side="right"))
        share = 1.0 - (corner - place.travelled[begin:end, None]) / OVER
        off[begin:end] += share * (meeting(told.wanted, int(joint), shift[end - 1], shift[end]) - off[begin:end])
    point[:, :2] += off
    return timed(np.ascontiguousarray(point), order.heading, order.along, step)


def seen(plants: Sequence[Plant], order: SetPoints) -> Seen:
    """What each plant makes of the path, when all are told the same set points."""
    count = len(order.along)
    error, half, bend = np.zeros((3, len(plants), count))
    found = Seen(error, half, bend, np.full((len(plants), count, 2), math.nan))
    for k, one in enumerate(plants):
        history = followed(one.scenario, one.told, order)
        off = contour_error(one.told, history.position)
        found.error[k] = np.nan_to_num(off, nan=0.0)
        if one.walls is not None:
            _bent(found, k, bend_of(one.scenario, one.told, one.walls, history, off))
    return found


def _bent(found: Seen, k: int, bend: Bend) -> None:
    """Add what the tool of a plant is bent by."""
    off = found.error[k]
    with warnings.catch_warnings():  # places without a wall
        warnings.simplefilter("ignore", RuntimeWarning)
        low, high = np.nanmin(bend.push[..., 0], axis=1), np.nanmax(bend.push[..., 1], axis=1)
        walls = np.where(bend.there[..., None], bend.push, math.nan)
        found.into[k, :, 0] = np.fmin(off + walls[:, 0, 0], -off - walls[:, 1, 1])
        found.into[k, :, 1] = np.fmax(off + walls[:, 0, 1], -off - walls[:, 1, 0])
    found.bend[k] = np.nan_to_num(0.5 * (low + high), nan=0.0)
    found.half[k] = np.nan_to_num(np.where(bend.there.any(axis=1), 0.5 * (high - low), 0.0), nan=0.0)
    found.error[k] = off + found.bend[k]


def errors(plants: Sequence[Plant], order: SetPoints) -> FloatArray:
    """Error of each plant that is told the same set points [m], shape (plants, n)."""
    return seen(plants, order).error


def learn(
    plants: Sequence[Plant], rule: Rule, most: int, largest: float = math.inf,
    progress: Callable[[float], None] | None = None, kept: FloatArray | float = 0.0,
) -> Learned:  # fmt: skip
    """Learn a shift against the mean error of plants, on the set points, with the time law of the wanted path.

    As long as a repetition lessens the largest mean error by 2 % or more; the best shift is kept. Where a tool bends, the step
    of all repetitions but the first is that of one secant: one over the gain that the first has had on the walls.

    Parameters
    ----------
    plants : sequence of Plant
        At least one; all have the same path.
    rule : Rule
        Of :func:`cutwise.physics.motion.learning.rule_for`.
    most : int
        The most repetitions.
    largest : float
        Largest shift [m]; what would be more stays there.
    progress : callable, optional
        Called with the share done.
    kept : ndarray or float
        Part of the error that is not learned [m], shape (n,).
    """
    told, whole = plants[0].told, plants[0].walls is not None
    active, counts = window(told, whole=whole), judged(told, whole=whole)
    shift = np.zeros(len(told.place.time))
    best, trail, used = shift, [math.inf], rule
    last: tuple[FloatArray, FloatArray] | None = None  # bend, and where the drives had the tool, one repetition ago
    for count in range(most + 1):
        found = seen(plants, shifted(told, shift))
        error = found.error.mean(axis=0) - kept
        size = float(np.abs(error)[counts].max(initial=0.0))  # of walls their middle: no shift takes the rest away
        trail.append(size)
        if size <= min(trail[:-1]):
            best = shift
        if size > (1.0 - GAINS) * min(trail[:-1]) or count == most:
            break
        bend = found.bend.mean(axis=0)
        if whole and last is not None and used is rule:
            used = _secant(told, rule, active & (bend != 0.0), bend - last[0], error - bend - last[1])
        last = bend, error - bend
        shift = np.clip(step_of(told, shift, error, bend, used, active), -largest, largest)
        if progress is not None:
            progress((count + 1) / most)
    along, first = np.unique(told.place.travelled, return_index=True)
    left = np.broadcast_to(kept, shift.shape)[first]
    return Learned(along, best[first], tuple(trail[1:]), used, whole, left)


def step_of(
    told: Commanded, shift: FloatArray, error: FloatArray, bend: FloatArray, rule: Rule, active: npt.NDArray[np.bool_]
) -> FloatArray:  # fmt: skip
    """The next shift: learned where it is active; next to stops, where drives cannot be learned from, against the bend alone."""
    new = learned(shift, held(error, active), rule, active)
    if not bend.any():
        return new
    beside = cut_level(told.wanted)[told.place.block] & ~active & (bend != 0.0)
    return np.where(beside, -bend, new)


def _secant(
    told: Commanded, rule: Rule, where: npt.NDArray[np.bool_], changed: FloatArray, moved: FloatArray
) -> Rule:  # fmt: skip
    """The rule with one over the gain of the walls: 1 plus how the bend has changed, over how far the tool was moved."""
    straight = told.wanted.curve.straight[told.place.block]
    size = np.abs(moved[where & straight]).max(initial=0.0)
    clear = where & straight & (np.abs(moved) > 0.5 * size) if size > 0.0 else np.zeros_like(where)
    if not clear.any():
        return rule
    gain = 1.0 / float(np.clip(1.0 + np.median(changed[clear] / moved[clear]), *_GAINS_OF_WALLS))
    each = tuple(convergence(one, rule.lead, rule.smoothing, gain)[0] for one in told.drives[:2])
    return rule._replace(gain=gain, convergence=each)


def held(error: FloatArray, active: npt.NDArray[np.bool_]) -> FloatArray:
    """Errors with the last one of a window in place of those behind it, which smoothing and lead would else bring into it.

    >>> held(np.array([1.0, 2.0, 9.0, 3.0]), np.array([True, True, False, True])).tolist()
    [1.0, 2.0, 2.0, 3.0]
    """
    last = np.maximum.accumulate(np.where(active, np.arange(len(error)), -1))
    return np.where(last >= 0, error[np.maximum(last, 0)], error)


def rule_of(told: Commanded, jerk: float, lead: float | None, smoothing: float | None) -> Rule:
    """The rule for a path: lead and smoothing [s] as given, else as they converge best."""
    step = told.drives[0].law.sample_time
    whole = [None if value is None else round(value / step) for value in (lead, smoothing)]
    return rule_for(told.drives[:2], frequency_of(told, jerk), lead=whole[0], smoothing=whole[1])


def chords(path: ProgramPath, learned_shift: Learned, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Vertices of the shifted path: places along the wanted path [m], shape (n,), and points [m], shape (n, 3).

    One at the start of each stretch of cuts at one height, then from where the shift may begin one every ``spacing`` and
    one at the end; a corner that does not run through begins a stretch.
    """
    curve = path.curve
    knots = curve.knots
    active = learned_shift.along[learned_shift.shift != 0.0]
    if not active.size:
        return np.zeros(0), np.zeros((0, 3))
    begin = 0.0 if learned_shift.whole else first_place(path)
    places = [_spaced(low, high, max(low, begin), spacing) for low, high in stretches(path)]
    at = np.concatenate(places)
    block = np.minimum(np.searchsorted(knots, at, side="right") - 1, curve.count - 1)
    ends = np.cumsum([len(some) for some in places]) - 1
    block[ends] = np.minimum(np.searchsorted(knots, at[ends], side="left") - 1, curve.count - 1)
    point, direction = at_blocks(curve, block, at - knots[block])
    point[:, :2] += learned_shift.at(at)[:, None] * right_normal(direction)
    for joint in sharp_corners(path):
        place = knots[joint + 1]
        behind = min(int(np.searchsorted(learned_shift.along, place, side="right")), len(learned_shift.along) - 1)
        here = np.flatnonzero(at == place)
        corner = np.asarray(curve.start[joint + 1])[:2]
        sides = learned_shift.shift[[max(behind - 1, 0), behind]]
        point[here, :2] = corner + meeting(path, int(joint), float(sides[0]), float(sides[1]))
    return at, point


def _spaced(low: float, high: float, begin: float, spacing: float) -> FloatArray:
    if begin >= high:
        return np.array([low, high])
    inside = begin + spacing * np.arange(math.ceil((high - begin) / spacing - 1e-6))
    inside = inside[(inside > low + _SHORT * spacing) & (inside < high - _SHORT * spacing)]
    return np.concatenate([[low], inside, [high]])
