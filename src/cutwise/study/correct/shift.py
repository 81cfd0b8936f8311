"""A shift of a path along its normal, learned against what the drives make of it."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import at_blocks, turn_angles
from cutwise.physics.motion.driven import SetPoints
from cutwise.physics.motion.learning import Rule, learned, rule_for
from cutwise.process.milling import Commanded, contour_error, followed, timed
from cutwise.process.program_path import ProgramPath
from cutwise.spec.milling import MillingScenario

BEFORE_CURVE = 3e-3  # [m] before the first bend from which on the path may be shifted
BEFORE_END = 20e-3  # [s] before the end until which it may, and from a stop on either side
_AFTER_STOP = 0.1  # [s] behind a stop, in which an error comes from it
_KINK = 1e-4  # [rad] at a joint: what is less runs through
_LEVEL = 1e-9  # vertical part of a direction: what is less is a move in the plane
_SHORT = 0.25  # of the spacing: no chord is shorter, its direction would be that of rounding
GAINS = 0.02  # share by which a repetition has to lessen the error to be worth another


class Plant(NamedTuple):
    """One machine with its cut, as it is or as it may be."""

    scenario: MillingScenario
    told: Commanded


class Learned(NamedTuple):
    """A shift and how it came about."""

    along: FloatArray  # [m] of the wanted path, rising, shape (n,)
    shift: FloatArray  # [m] to the right of it, shape (n,)
    trail: tuple[float, ...]  # largest contour error before each repetition and after the last [m]
    rule: Rule

    def at(self, place: FloatArray) -> FloatArray:
        """Shift at places along the wanted path [m]."""
        return np.interp(place, self.along, self.shift)


def right_normal(direction: FloatArray) -> FloatArray:
    """Unit normals to the right of directions in the xy plane, shape (n, 2).

    >>> right_normal(np.array([[1.0, 0.0, 0.0]])).tolist()
    [[0.0, -1.0]]
    """
    flat = np.maximum(np.hypot(direction[:, 0], direction[:, 1]), 1e-300)
    return np.column_stack([direction[:, 1], -direction[:, 0]]) / flat[:, None] + 0.0


def cut_level(path: ProgramPath) -> npt.NDArray[np.bool_]:
    """Blocks that cut at one height: those whose path may be shifted."""
    curve = path.curve
    return path.cuts & (np.abs(curve.along[:, 2]) < _LEVEL) & (np.abs(curve.climb[:, 2]) < _LEVEL)


def first_bend(path: ProgramPath) -> float | None:
    """Where the first cut block bends, or the first corner between two is [m]; None: nowhere."""
    curve, cut = path.curve, cut_level(path)
    places = curve.knots[:-1][cut & ~curve.straight]
    corners = np.flatnonzero((turn_angles(curve) > _KINK) & cut[:-1] & cut[1:])
    found = [*places[:1], *curve.knots[1:-1][corners[:1]]]
    return float(min(found)) if found else None


def window(told: Commanded) -> npt.NDArray[np.bool_]:
    """Servo instants at which the path may be shifted.

    From 3 mm before the first bend (without one, the first cut) to 20 ms before the end, in cuts that stay at one height;
    without the 20 ms before every place where such a cut stops: what a drive runs on beyond its end lies along the path, and
    no shift beside the path takes it away.
    """
    place, cut = told.place, cut_level(told.wanted)
    bend = first_bend(told.wanted)
    first = float(told.wanted.curve.knots[:-1][cut][0]) if bend is None else bend - BEFORE_CURVE
    active = cut[place.block] & (place.travelled > first) & (place.time < place.end - BEFORE_END)
    return active & ~_near_stops(told, BEFORE_END, 0.0)


def judged(told: Commanded) -> npt.NDArray[np.bool_]:
    """Servo instants whose error a shift is judged by: those at which the path may be shifted, but for the 20 ms behind a stop.

    What a drive ran on beyond a corner is an error beside the path that goes on from there. A shift leads it back, but not in
    no time.
    """
    return window(told) & ~_near_stops(told, 0.0, BEFORE_END)


def behind_stop(told: Commanded, error: FloatArray) -> bool:
    """Whether the largest error that is judged comes from a stop a little before."""
    worst = int(np.argmax(np.where(judged(told), np.abs(error), 0.0)))
    return bool(_near_stops(told, 0.0, _AFTER_STOP)[worst])


def _near_stops(told: Commanded, before: float, behind: float) -> npt.NDArray[np.bool_]:
    """Servo instants up to so long before and behind stops [s]."""
    place, near = told.place, np.zeros(len(told.place.time), np.bool_)
    for end in place.time[np.searchsorted(place.block, np.flatnonzero(stops(told.wanted)), side="right") - 1]:
        near[slice(*np.searchsorted(place.time, [end - before, end + behind], side="right"))] = True
    return near


def stops(path: ProgramPath) -> npt.NDArray[np.bool_]:
    """Joints at which a cut at one height begins or ends: in a corner, a stop or another move, shape (n - 1,)."""
    cut = cut_level(path)
    parted = (turn_angles(path.curve) > _KINK) | path.stop_at
    return (cut[:-1] != cut[1:]) | (cut[:-1] & cut[1:] & parted)


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
    """Set points moved to the right of the wanted path at each servo instant [m], shape (n,)."""
    order, step = told.order, told.drives[0].law.sample_time
    point = order.point.copy()
    point[:, :2] += shift[:, None] * right_normal(told.place.direction)
    return timed(np.ascontiguousarray(point), order.heading, order.along, step)


def errors(plants: Sequence[Plant], order: SetPoints) -> FloatArray:
    """Contour error of each plant that is told the same set points [m], shape (plants, n)."""
    found = [contour_error(one.told, followed(one.scenario, one.told, order).position) for one in plants]
    return np.nan_to_num(np.array(found), nan=0.0)


def learn(
    plants: Sequence[Plant], rule: Rule, most: int, largest: float = math.inf,
    progress: Callable[[float], None] | None = None,
) -> Learned:  # fmt: skip
    """Learn a shift against the mean error of plants, on the set points, with the time law of the wanted path.

    As long as a repetition lessens the largest mean error by 2 % or more; the best shift is kept.

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
    """
    told = plants[0].told
    active, counts = window(told), judged(told)
    shift = np.zeros(len(told.place.time))
    best, trail = shift, [math.inf]
    for count in range(most + 1):
        error = errors(plants, shifted(told, shift)).mean(axis=0)
        size = float(np.abs(error[counts]).max(initial=0.0))
        trail.append(size)
        if size <= min(trail[:-1]):
            best = shift
        if size > (1.0 - GAINS) * min(trail[:-1]) or count == most:
            break
        shift = np.clip(learned(shift, held(error, active), rule, active), -largest, largest)
        if progress is not None:
            progress((count + 1) / most)
    along, first = np.unique(told.place.travelled, return_index=True)
    return Learned(along, best[first], tuple(trail[1:]), rule)


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
    places = [_spaced(low, high, max(low, first_place(path)), spacing) for low, high in stretches(path)]
    at = np.concatenate(places)
    block = np.minimum(np.searchsorted(knots, at, side="right") - 1, curve.count - 1)
    ends = np.cumsum([len(some) for some in places]) - 1
    block[ends] = np.minimum(np.searchsorted(knots, at[ends], side="left") - 1, curve.count - 1)
    point, direction = at_blocks(curve, block, at - knots[block])
    point[:, :2] += learned_shift.at(at)[:, None] * right_normal(direction)
    return at, point


def first_place(path: ProgramPath) -> float:
    """Where the shift may begin [m]."""
    bend = first_bend(path)
    return 0.0 if bend is None else max(bend - BEFORE_CURVE, 0.0)


def stretches(path: ProgramPath) -> list[tuple[float, float]]:
    """From where to where cuts at one height run through [m]: not beyond a corner, a pause or a change of feed."""
    curve, cut = path.curve, cut_level(path)
    parted = stops(path) | (path.feed[:-1] != path.feed[1:])
    found: list[tuple[float, float]] = []
    for i in np.flatnonzero(cut):
        low, high = float(curve.knots[i]), float(curve.knots[i + 1])
        if found and i > 0 and cut[i - 1] and not parted[i - 1]:
            found[-1] = (found[-1][0], high)
        else:
            found.append((low, high))
    return found


def _spaced(low: float, high: float, begin: float, spacing: float) -> FloatArray:
    if begin >= high:
        return np.array([low, high])
    inside = begin + spacing * np.arange(math.ceil((high - begin) / spacing - 1e-6))
    inside = inside[(inside > low + _SHORT * spacing) & (inside < high - _SHORT * spacing)]
    return np.concatenate([[low], inside, [high]])
