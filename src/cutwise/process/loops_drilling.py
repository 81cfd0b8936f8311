r"""The coupled drilling cycle: feed in, yield, skate, be guided by the own hole, break through.

Displacements are those of the drill tip in tool axes (x, y across, z along the feed). The arm is its translational
compliance with rotations free and one mass in every direction; the hole holds the drill by a wall spring that grows in
while the point enters, and Coulomb friction at the tip lets the hole be displaced until the corner has entered. Hole
stiffness, wander length, friction, modal mass and damping have no published value: they are inputs, assumed.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.physics.structure.swings import swinging
from cutwise.process.drill_profile import DepthProfile
from cutwise.process.hole_balance import (
    AtOnce,
    DrillCycle,
    Instant,
    cut_at,
    nothing_at_once,
    settle,
)

_APPROACH = 0.5e-3  # m above the surface where the feed starts
_OVERRUN = 1e-3  # m beyond the point where the corner is through
_FARTHEST = 0.5  # m that is drilled on at most
_DWELL = 0.4  # s of rest at the end
_FULL_CUT_MARGIN = 0.3e-3  # m left out at both ends of the full cut
_TOUCH = 0.2e-3  # m of contact transient left out of the feed minimum

HISTORY = ("time", "depth", "x", "y", "z", "hole_x", "hole_y", "wall_x", "wall_y", "thrust", "torque", "feed")


class ArmDynamics(NamedTuple):
    """What carries the drill at its tip, in tool axes; an infinite mass stands still."""

    stiffness: FloatArray  # K [N/m], shape (3, 3)
    damping: FloatArray  # D [N s/m], shape (3, 3)
    mass: float  # m [kg], the same in every direction
    torque_push: FloatArray  # [N per N m] force that moves the tip as the drill torque does, shape (3,)
    soft: AtOnce  # what yields at once besides

    @property
    def compliance(self) -> FloatArray:
        """At rest, of all that yields, shape (3, 3)."""
        of_mass = np.linalg.inv(self.stiffness) if math.isfinite(self.mass) else np.zeros((3, 3))
        return np.asarray(of_mass + self.soft.compliance)


class HoleOutcome(NamedTuple):
    """What is left of the hole, and the extremes over the cycle."""

    entry: FloatArray  # [m] lateral position of the hole at the entry surface, shape (2,)
    exit_tip: FloatArray  # [m] when the tip reaches the exit surface, shape (2,)
    exit: FloatArray  # [m] when the corner reaches it, shape (2,)
    entered: bool  # the corner has passed the entry surface; without that there is no entry error
    through: bool  # the corner has passed the exit surface; without that there is no hole
    extra: float  # [m] commanded beyond the usual overrun until it was
    thrust_mean: float  # [N] over the full cut
    axial_mean: float  # [m] mean u_z over the full cut
    lateral_mean: float  # [m] mean |u_l| over the full cut
    thrust_max: float  # [N]
    torque_max: float  # [N m]
    lateral_force_max: float  # [N] largest wall force
    axial_max: float  # [m] largest |u_z|
    lateral_max: float  # [m] largest |u_l|
    feed_min: float  # [m] per revolution while the point enters
    feed_max: float  # [m] per revolution while the point breaks through; 0 if it does not
    rest: float  # [m] u_z at the end of the dwell
    time: float  # [s]


def arm_dynamics(compliance: FloatArray, mass: float, damping_ratio: float, *, with_torque: bool) -> ArmDynamics:
    r"""Translational stiffness with rotations free, one mass, and modal damping.

    .. math::
        K = (C_{[xyz;\,xyz]})^{-1}, \quad M = m I_3, \quad
        D = \sum_k v_k\, 2\zeta\sqrt{\lambda_k m}\; v_k^T \quad (\lambda_k, v_k \text{ eigenpairs of } K)

    Parameters
    ----------
    compliance : array (6, 6)
        In tool axes.
    mass, damping_ratio : float
        Modal mass [kg] and damping ratio [1] of the arm.
    with_torque : bool
        Let the drill torque, which acts about z, move the tip through :math:`C_{[xyz;\,\psi]}`.
    """
    swings = swinging(np.zeros(1), compliance[None, :3, :3], mass, damping_ratio)
    stiffness, damping = swings.stiffness[0], swings.damping[0]
    push = stiffness @ compliance[:3, 5] if with_torque else np.zeros(3)
    return ArmDynamics(np.ascontiguousarray(stiffness), np.ascontiguousarray(damping), mass, push, nothing_at_once())


def bodies_at_once(compliance: FloatArray, *, with_torque: bool) -> ArmDynamics:
    """What carries the drill by its compliance (6, 6) alone, in tool axes, without mass: the bodies of a machine."""
    turn = compliance[:3, 5].copy() if with_torque else np.zeros(3)
    soft = AtOnce(np.ascontiguousarray(compliance[:3, :3]), turn)
    return ArmDynamics(np.zeros((3, 3)), np.zeros((3, 3)), math.inf, np.zeros(3), soft)


def on_part(arm: ArmDynamics, stiffness: float) -> ArmDynamics:
    """The same, drilling into a part that yields along the drill axis [N/m]."""
    compliance = arm.soft.compliance.copy()
    compliance[2, 2] += 1.0 / stiffness
    return arm._replace(soft=arm.soft._replace(compliance=compliance))


def modes(arm: ArmDynamics) -> FloatArray:
    r"""Frequencies of the arm, :math:`\sqrt{\lambda_k/m}/2\pi` [Hz], rising, shape (3,); none without mass."""
    if not math.isfinite(arm.mass):
        return np.zeros(0)
    return np.sqrt(np.linalg.eigvalsh(arm.stiffness) / arm.mass) / (2.0 * math.pi)


def cycle_time(cycle: DrillCycle) -> float:
    """Feed in, overrun and dwell, without retract [s]."""
    travel = cycle.thickness + cycle.cone + _OVERRUN + _APPROACH
    return travel / (cycle.feed * cycle.turns) + _DWELL


@compiled
def _wall_force(
    cycle: DrillCycle, depth: float, thrust: float, ux: float, uy: float, hole: FloatArray
) -> tuple[float, float]:
    """Force of the hole on the drill; moves the hole where friction lets the tip slip."""
    if depth <= 0.0:
        return 0.0, 0.0
    stiffness = cycle.wall_stiffness * min(1.0, depth / cycle.cone)
    fx, fy = -stiffness * (ux - hole[0]), -stiffness * (uy - hole[1])
    if depth < cycle.cone and stiffness > 0.0:
        size, held = math.hypot(fx, fy), cycle.friction * thrust
        if thrust <= 0.0:
            hole[0], hole[1] = ux, uy
            return 0.0, 0.0
        if size > held:
            fx, fy = fx * held / size, fy * held / size
            hole[0], hole[1] = ux + fx / stiffness, uy + fy / stiffness
    return fx, fy


@compiled
def _tally(
    cycle: DrillCycle, depth: float, feed: float, force: FloatArray, wall: float, u: FloatArray, lateral: float,
    sums: FloatArray, most: FloatArray,
) -> None:  # fmt: skip
    """Sums over the full cut, and extremes over all time."""
    if cycle.cone + _FULL_CUT_MARGIN < depth < cycle.thickness - _FULL_CUT_MARGIN:
        sums[0] += 1.0
        sums[1] += force[0]
        sums[2] += u[2]
        sums[3] += lateral
    if _TOUCH < depth < cycle.cone:
        most[5] = min(most[5], feed)
    if cycle.thickness < depth < cycle.thickness + cycle.cone:
        most[6] = max(most[6], feed)
    most[0], most[1], most[2] = max(most[0], force[0]), max(most[1], force[1]), max(most[2], wall)
    most[3], most[4] = max(most[3], abs(u[2])), max(most[4], lateral)


@compiled
def _wander(cycle: DrillCycle, depth: float, deepest: float, u: FloatArray, hole: FloatArray) -> float:
    """The hole follows the tip while it goes deeper; returns how deep it is."""
    if depth <= deepest:
        return deepest
    follow = min(1.0, (depth - deepest) / cycle.wander)
    hole[0] += (u[0] - hole[0]) * follow
    hole[1] += (u[1] - hole[1]) * follow
    return depth


@compiled
def _mark(cycle: DrillCycle, depth: float, hole: FloatArray, marks: FloatArray, reached: np.ndarray) -> None:
    """Keep where the hole is when corner, tip and corner again pass a surface."""
    levels = (cycle.cone, cycle.thickness, cycle.thickness + cycle.cone)
    for level in range(3):
        if not reached[level] and depth >= levels[level]:
            reached[level] = True
            marks[level, 0], marks[level, 1] = hole[0], hole[1]


@compiled
def _note(
    row: FloatArray, time: float, depth: float, feed: float, u: FloatArray, hole: FloatArray, wall: FloatArray,
    cut: FloatArray,
) -> None:  # fmt: skip
    """A row of the history."""
    row[0], row[1], row[2], row[3], row[4] = time, depth, u[0], u[1], u[2]
    row[5], row[6], row[7], row[8] = hole[0], hole[1], wall[0], wall[1]
    row[9], row[10], row[11] = cut[0], cut[1], feed


@compiled
def _swing(
    arm: ArmDynamics, step: float, cos_slope: float, sin_slope: float, wall: FloatArray, cut: FloatArray,
    swung: FloatArray, rate: FloatArray, force: FloatArray,
) -> None:  # fmt: skip
    """One step of what has mass, semi-implicit Euler; a force along x and y of the slope, and the wall's."""
    thrust, torque, side_x, side_y = cut[0], cut[1], cut[2], cut[3]
    force[0] = wall[0] + cos_slope * side_x - sin_slope * side_y - torque * arm.torque_push[0]
    force[1] = wall[1] + sin_slope * side_x + cos_slope * side_y - torque * arm.torque_push[1]
    force[2] = -thrust - torque * arm.torque_push[2]
    for i in range(3):
        for j in range(3):
            force[i] -= arm.stiffness[i, j] * swung[j] + arm.damping[i, j] * rate[j]
    for i in range(3):
        rate[i] += step * force[i] / arm.mass
        swung[i] += step * rate[i]


@compiled
def _run(
    cycle: DrillCycle, arm: ArmDynamics, profile: DepthProfile, turn_slope: tuple[float, float], step: float, steps: int,
    farthest: float, every: int, history: FloatArray,
) -> tuple[FloatArray, np.ndarray, FloatArray]:  # fmt: skip
    """Positions of the hole at its three levels, whether they were reached, and the numbers of a :class:`HoleOutcome`.

    Plain arrays: numba makes a named tuple by running Python code, and a signal (Ctrl-C, the end of a time limit) that
    arrives in the loop is then raised in there, where it ends in a crash.
    """
    v_feed, bottom = cycle.feed * cycle.turns, cycle.thickness + cycle.cone + _OVERRUN
    cos_slope, sin_slope = turn_slope
    swung, rate, moved, u = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    hole, wall, cut, force = np.zeros(2), np.zeros(2), np.zeros(4), np.zeros(3)
    marks, reached = np.zeros((3, 2)), np.zeros(3, dtype=np.bool_)
    sums, most = np.zeros(4), np.array([0.0, 0.0, 0.0, 0.0, 0.0, math.inf, 0.0])
    soft = np.abs(arm.soft.compliance).max() > 0.0
    deepest, before = 0.0, 0.0
    usual, steps_in_all, k = bottom, steps, -1
    while k + 1 < steps_in_all:
        k += 1
        t = k * step
        told = -_APPROACH + v_feed * t
        if told >= bottom and not reached[2] and bottom < farthest:  # the arm lags: drill on until it is through
            bottom = min(told + v_feed * step, farthest)
            steps_in_all = steps + math.ceil((bottom - usual) / (v_feed * step))
        commanded = min(told, bottom)
        moving = v_feed if commanded < bottom else 0.0
        before = moved[2]
        if soft:
            now = Instant(commanded, moving, step, deepest, cos_slope, sin_slope)
            settle(cycle, arm.soft, profile, now, swung, rate, moved, hole, cut, wall)
        for i in range(3):
            u[i] = swung[i] + moved[i]
        depth = commanded + u[2]
        feed = max((moving + rate[2] + (moved[2] - before) / step) / cycle.turns, 0.0)
        if not soft:
            cut_at(cycle, profile, depth, deepest, feed, cut)
            wall[0], wall[1] = _wall_force(cycle, depth, cut[0], u[0], u[1], hole)
        deepest = _wander(cycle, depth, deepest, u, hole)
        _mark(cycle, depth, hole, marks, reached)
        _tally(
            cycle, depth, feed, cut, math.hypot(wall[0], wall[1]), u, math.hypot(u[0], u[1]), sums, most
        )  # fmt: skip
        if every > 0 and k % every == 0:
            _note(history[k // every], t, depth, feed, u, hole, wall, cut)
        _swing(arm, step, cos_slope, sin_slope, wall, cut, swung, rate, force)
    count = max(sums[0], 1.0)
    for i in range(3):
        u[i] = swung[i] + moved[i]
    return (
        marks,
        reached,
        np.array([
            bottom - usual, sums[1] / count, sums[2] / count, sums[3] / count,
            most[0], most[1], most[2], most[3], most[4], most[5], most[6], u[2], steps_in_all * step,
        ]),
    )  # fmt: skip


def drill_hole(
    cycle: DrillCycle,
    arm: ArmDynamics,
    profile: DepthProfile,
    *,
    slope_angle: float = 0.0,
    step: float = 1e-4,
    every: int = 0,
    dwell: bool = True,
) -> tuple[HoleOutcome, FloatArray]:
    r"""One hole in time: semi-implicit Euler over tip displacement and hole position.

    .. math::
        \dot u_{k+1} = \dot u_k + \frac{\Delta t}{m}\bigl(F(u_k) - K u_k - D \dot u_k\bigr), \qquad
        u_{k+1} = u_k + \Delta t\,\dot u_{k+1}

    The feed ends 1 mm beyond the place where the corner of an arm that does not yield would be through; while the corner
    is not, it goes on, as far as :func:`farthest`.

    With :math:`F = (F_l, -T)` and, on an inclined surface, the lateral cutting force. Thrust and torque go with
    :math:`(f_a/f)^{1-m_c}`, :math:`f_a = \max((v + \dot u_z)/n, 0)`.

    Parameters
    ----------
    slope_angle : float
        Angle from x of the tool axes to the direction in which the surface lies deeper along the feed [rad].
    step : float
        :math:`\Delta t` [s]; :math:`\Delta t\sqrt{k_w/m}` should stay below 0.1.
    every : int
        Keep every so many steps as history; 0 keeps none.
    dwell : bool
        Rest at the end; needed for the depth error only.

    Returns
    -------
    tuple
        :class:`HoleOutcome`, and the history, shape (rows, 12), columns :data:`HISTORY`, SI.
    """
    end = cycle_time(cycle) - (0.0 if dwell else _DWELL)
    steps = max(1, round(end / step))
    last = farthest(cycle, arm, profile)
    most = steps + math.ceil((last - bottom(cycle)) / (cycle.feed * cycle.turns * step)) + 1
    history = np.zeros((-(-most // every) if every else 0, len(HISTORY)))
    turn = (math.cos(slope_angle), math.sin(slope_angle))
    marks, reached, numbers = _run(cycle, arm, profile, turn, step, steps, last, every, history)
    entry, tip, corner = marks
    outcome = HoleOutcome(entry, tip, corner, bool(reached[0]), bool(reached[2]), *map(float, numbers))
    return outcome, history[: -(-round(outcome.time / step) // every) if every else 0]


def bottom(cycle: DrillCycle) -> float:
    """Commanded depth at which the feed usually ends [m]."""
    return cycle.thickness + cycle.cone + _OVERRUN


def farthest(cycle: DrillCycle, arm: ArmDynamics, profile: DepthProfile) -> float:
    """Commanded depth beyond which a hole that is not through counts as one that never will be [m].

    The tip lags by the compliance times the force; three times that, and the overrun, is enough for every hole that
    comes to an end.
    """
    force = np.hypot(profile.thrust.max(), np.hypot(profile.lateral[:, 0], profile.lateral[:, 1]).max())
    lag = force * float(np.linalg.eigvalsh(arm.compliance)[-1])
    return float(bottom(cycle) + min(3.0 * lag, _FARTHEST))


def step_limit(cycle: DrillCycle, arm: ArmDynamics, thrust: float) -> float:
    r"""Largest time step at which the stepping is trusted [s].

    :math:`\Delta t\,\omega < 0.2` and :math:`\Delta t\,c/m < 0.5` with
    :math:`\omega = \sqrt{(k_w + \lambda_\max)/m}`; thrust that grows with the feed damps the axial motion with
    :math:`c = (1 - m_c)\,T/(f n)`, which is stiff at low speeds.
    """
    if not math.isfinite(arm.mass):
        return math.inf  # what has no mass is solved for, whatever the step
    omega = math.sqrt((cycle.wall_stiffness + float(np.linalg.eigvalsh(arm.stiffness)[-1])) / arm.mass)
    rate = (1.0 - cycle.exponent) * thrust / (cycle.feed * cycle.turns * arm.mass)
    return min(0.2 / omega, 0.5 / rate if rate > 0.0 else math.inf)


def hole_error(outcome: HoleOutcome) -> float:
    """The larger of the position errors at entry and exit [m]: what the posture `best` makes small.

    A hole that is never through has no error, it is infinitely bad.
    """
    if not outcome.through:
        return math.inf
    return float(max(np.hypot(*outcome.entry), np.hypot(*outcome.exit)))
