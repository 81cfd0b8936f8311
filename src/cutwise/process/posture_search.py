"""Choosing the posture for a hole, and the place of a part for many: fixed, stiffest, least skating, best."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion.coupled import is_direct
from cutwise.physics.structure.joint_compliance import worst_skating
from cutwise.process.posture import Posture, posture_at
from cutwise.process.postures import Arm, Candidates, candidates, tool_axes

if TYPE_CHECKING:
    from scipy import optimize
else:
    optimize = later("scipy.optimize")

Score = Callable[[Arm, Candidates, FloatArray], FloatArray]
"""Figure of merit of candidates at redundancy angles, shape (m, b); the smallest wins, infinite is no candidate."""

_TIE = 1e-9  # relative: the two wrist flips are equal but for rounding
_BETTER = 1e-5  # relative: postures mirrored in the plane of hole and axis 1 are equal too; the grid decides for one


class PoseTarget(NamedTuple):
    """A hole as the robot sees it, in its base frame."""

    position: FloatArray  # [m] of the entry point, shape (3,)
    axis: FloatArray  # feed direction, shape (3,)


def axial_compliance(arm: Arm, found: Candidates, angles: FloatArray) -> FloatArray:
    """Score of the stiffest posture: C_zz [m/N]."""
    del arm, angles
    return found.compliance


def skating(arm: Arm, found: Candidates, angles: FloatArray) -> FloatArray:
    """Score of the least skating posture: the skating ratio."""
    del arm, angles
    return found.skating


def skating_on_slope(side: FloatArray, direction: float) -> Score:
    """Score of the least skating posture on an inclined surface: side force over thrust (h, 2), direction [rad]."""

    def score(arm: Arm, found: Candidates, angles: FloatArray) -> FloatArray:
        del arm
        return worst_skating(found.holding, side, (direction - np.asarray(angles))[:, None])

    return score


def predicted(error: Callable[[Posture], float]) -> Score:
    """Score by a prediction for each posture; of the two wrist flips, which yield alike, only one is computed."""

    def score(arm: Arm, found: Candidates, angles: FloatArray) -> FloatArray:
        result = np.full(found.within.shape, math.inf)
        flips = arm.wrist is not None and is_direct(arm.drives) and found.within.shape[1] > 1
        for m, branch in np.argwhere(found.within):
            if branch % 2 and flips and found.within[m, branch - 1]:
                result[m, branch] = result[m, branch - 1]
            else:
                result[m, branch] = error(posture_at(arm, angles[m], found.q[m, branch]))
        return result

    return score


def scan(arm: Arm, target: PoseTarget, angles: FloatArray) -> Candidates:
    """All candidates of a hole over redundancy angles [rad], shape (m,)."""
    positions = np.broadcast_to(target.position, (len(angles), 3))
    return candidates(arm, positions, tool_axes(target.axis, angles))


def _scores(score: Score, arm: Arm, found: Candidates, angles: FloatArray, margin: float) -> FloatArray:
    allowed = found.within & (found.wrist_sine >= margin)
    return np.where(allowed, score(arm, found._replace(within=allowed), angles), math.inf)


def _least(values: FloatArray, q: FloatArray) -> int:
    """Index of the smallest value; equal ones are told apart by the smaller |q4| + |q6|."""
    best = np.nanmin(values)
    tied = np.flatnonzero(values <= best + _TIE * abs(best))
    return int(tied[np.argmin(np.abs(q[tied, 3]) + np.abs(q[tied, 5]))])


def search(
    arm: Arm, target: PoseTarget, score: Score, *, margin: float = 0.05, grid: float = math.radians(2.0)
) -> Posture | None:
    """The best posture for a hole over the whole turn of the redundancy angle, all branches.

    A grid finds the valleys, a bounded minimisation on the branch of each of the four deepest finds the bottom.

    Parameters
    ----------
    score : callable
        :func:`axial_compliance`, :func:`skating` or :func:`predicted` (...).
    margin : float
        Smallest |sin| of the wrist angle that counts as regular.
    grid : float
        Step of the grid [rad].

    Returns
    -------
    Posture or None
        None if no candidate is within limits and margin.
    """
    count = max(round(2.0 * math.pi / grid), 8)
    angles = np.linspace(-math.pi, math.pi, count + 1)
    found = scan(arm, target, angles)
    values = _scores(score, arm, found, angles, margin)
    if not np.any(np.isfinite(values)):
        return None
    best_value, best = math.inf, None
    for m, branch in _valleys(values)[:4]:
        angle, q, value = _bottom(arm, target, score, margin, angles, found, values, m, branch)
        if best is None or value < best_value * (1.0 - _BETTER):
            best_value, best = value, (angle, q)
    assert best is not None
    angle, q = best
    flips = scan(arm, target, np.array([angle]))
    row = _scores(score, arm, flips, np.array([angle]), margin)[0]
    row = np.where(np.isfinite(row), row, math.inf)
    if np.any(row <= best_value * (1.0 + _TIE)):
        q = flips.q[0, _least(row, flips.q[0])]
    return posture_at(arm, angle, q)


def _valleys(values: FloatArray) -> list[tuple[int, int]]:
    """Grid points no higher than their neighbours on the same branch, deepest first."""
    before, after = np.roll(values, 1, axis=0), np.roll(values, -1, axis=0)
    low = np.isfinite(values) & (values <= before) & (values <= after)
    places = np.argwhere(low)
    order = np.argsort(values[low], kind="stable")
    return [(int(m), int(b)) for m, b in places[order]]


def _bottom(
    arm: Arm,
    target: PoseTarget,
    score: Score,
    margin: float,
    angles: FloatArray,
    found: Candidates,
    values: FloatArray,
    m: int,
    branch: int,
) -> tuple[float, FloatArray, float]:
    """Bottom of a valley: redundancy angle, joint angles and score; the grid point if nothing lower is found."""
    home = found.q[m, branch]
    step = angles[1] - angles[0]

    def at(angle: float) -> tuple[float, FloatArray]:
        near = scan(arm, target, np.array([angle]))
        apart = np.abs((near.q[0] - home + math.pi) % (2.0 * math.pi) - math.pi).max(axis=1)
        if np.all(np.isnan(apart)):
            return math.inf, home
        nearest = int(np.nanargmin(apart))
        only = np.zeros_like(near.within)
        only[0, nearest] = near.within[0, nearest]
        value = _scores(score, arm, near._replace(within=only), np.array([angle]), margin)[0, nearest]
        return float(value), near.q[0, nearest]

    wall = 1e3 * abs(values[m, branch]) + 1e-30  # beyond a limit: high, but finite for the parabola
    centre = float(angles[m])
    result = optimize.minimize_scalar(
        lambda a: min(at(a)[0], wall), bounds=(centre - step, centre + step), method="bounded",
        options={"xatol": 1e-7},
    )  # fmt: skip
    bottom = _to_the_limit(lambda a: at(a)[0], float(result.x))
    value, q = at(bottom)
    if value < values[m, branch]:
        angle = (bottom + math.pi) % (2.0 * math.pi) - math.pi
        return angle, q, value
    return centre, home, float(values[m, branch])


def _to_the_limit(value: Callable[[float], float], angle: float, near: float = 1e-6) -> float:
    """The angle moved to a joint limit close by if that is better: a minimiser stops anywhere short of such a cliff."""
    best = angle
    for side in (near, -near):
        if math.isfinite(value(angle)) and not math.isfinite(value(angle + side)):
            inside, beyond = 0.0, 1.0
            for _ in range(40):
                middle = 0.5 * (inside + beyond)
                if math.isfinite(value(angle + middle * side)):
                    inside = middle
                else:
                    beyond = middle
            if value(angle + inside * side) < value(best):
                best = angle + inside * side
    return best


class Placement(NamedTuple):
    """A place of the part, and the postures that its holes get there."""

    place: int  # number of the place among those offered
    postures: tuple[Posture | None, ...]  # one per hole; None where the hole cannot be drilled
    worst: float  # score of the worst hole; infinite if one cannot be drilled


def place_part(
    arm: Arm,
    places: Sequence[Sequence[PoseTarget]],
    score: Score,
    *,
    margin: float = 0.05,
    grid: float = math.radians(4.0),
) -> list[Placement]:
    """Rate every place of a part: the outer loop around the choice of postures.

    Parameters
    ----------
    places : sequence of sequences
        For each place, the holes of the part as the robot then sees them.
    score : callable
        As for :func:`search`; the place with the smallest worst hole is the best.

    Returns
    -------
    list
        In the order of ``places``.
    """
    rated = []
    for index, holes in enumerate(places):
        postures, worst = [], 0.0
        for hole in holes:
            posture = search(arm, hole, score, margin=margin, grid=grid)
            postures.append(posture)
            worst = max(worst, math.inf if posture is None else score_of(arm, score, posture))
        rated.append(Placement(index, tuple(postures), worst))
    return rated


def score_of(arm: Arm, score: Score, posture: Posture) -> float:
    """Score of one posture."""
    single = Candidates(
        posture.q[None, None, :], np.ones((1, 1), dtype=np.bool_), posture.compliance[2:3, 2:3],
        posture.holding[None, None, :], np.array([[posture.wrist_sine]]),
    )  # fmt: skip
    return float(score(arm, single, np.array([posture.angle]))[0, 0])
