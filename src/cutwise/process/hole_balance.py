r"""Balance of a drill in its hole: what the wall holds, and what yields at once, place by place.

What yields at once (bodies of a machine, the part) has no inertia: its displacement is solved for together with the
force, which depends on depth and actual feed. The rate of that displacement is its backward difference, so that the
drill still surges when the thrust falls at breakthrough.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.process.drill_profile import DepthProfile, profile_at

CLOSE = 1e-14  # [m] of a displacement that is solved for with the force
TRIALS = 200  # halvings at most
FORCES = 6  # thrust [N], torque [N m], side force x, y [N], force of the wall x, y [N]


class DrillCycle(NamedTuple):
    """What a cycle needs besides forces and structure."""

    feed: float  # f [m] per revolution
    turns: float  # n [1/s]
    thickness: float  # [m] along the drill axis
    cone: float  # h_t [m], height of the drill point
    exponent: float  # m_c [1]: thrust and torque go with (f_a / f)^(1 - m_c)
    friction: float  # mu [1] at the tip
    wall_stiffness: float  # k_w [N/m]
    wander: float  # L_w [m], depth over which the hole follows the drill


class AtOnce(NamedTuple):
    """What yields at once, in tool axes."""

    compliance: FloatArray  # C [m/N], shape (3, 3)
    turn: FloatArray  # displacement by the drill torque about z [m per N m], shape (3,)


@compiled
def cut_at(
    cycle: DrillCycle, profile: DepthProfile, depth: float, deepest: float, feed: float, force: FloatArray
) -> None:
    r"""Thrust, torque and side force at a depth and an actual feed, into ``force``; nothing where nothing is cut.

    .. math:: T = T_0(z)\,(f_a/f)^{1-m_c}
    """
    for i in range(4):
        force[i] = 0.0
    if depth > 0.0 and depth >= deepest - 1e-12:
        thrust, torque, side_x, side_y = profile_at(profile, depth)
        share = (feed / cycle.feed) ** (1.0 - cycle.exponent)
        force[0], force[1], force[2], force[3] = thrust * share, torque * share, side_x * share, side_y * share


@compiled
def held_by(compliance: FloatArray, stiffness: float, gap_x: float, gap_y: float, force: FloatArray) -> float:
    r"""Force of a spring across the gap of what yields, :math:`(I + k C_l) F = -k\,g`; its size is returned [N]."""
    xx, yy = 1.0 + stiffness * compliance[0, 0], 1.0 + stiffness * compliance[1, 1]
    xy = stiffness * compliance[0, 1]
    determinant = xx * yy - xy * xy
    force[0] = -stiffness * (yy * gap_x - xy * gap_y) / determinant
    force[1] = -stiffness * (xx * gap_y - xy * gap_x) / determinant
    return math.hypot(force[0], force[1])


@compiled
def held_at_most(
    compliance: FloatArray, stiffness: float, gap_x: float, gap_y: float, most: float, force: FloatArray
) -> bool:
    """As :func:`held_by`, with a force that friction can hold; whether the tip slips.

    The force that friction holds, against the gap that remains, is that of a softer spring.
    """
    if held_by(compliance, stiffness, gap_x, gap_y, force) <= most:
        return False
    low, high = 0.0, stiffness
    for _ in range(60):
        softer = 0.5 * (low + high)
        if held_by(compliance, softer, gap_x, gap_y, force) > most:
            high = softer
        else:
            low = softer
    return True


class Instant(NamedTuple):
    """One step of a cycle, in which what yields at once is solved for."""

    commanded: float  # [m] depth that is told
    moving: float  # [m/s] feed that is told
    step: float  # [s]
    deepest: float  # [m] so far
    cos_slope: float
    sin_slope: float


@compiled
def wanted(
    cycle: DrillCycle, soft: AtOnce, profile: DepthProfile, now: Instant, u: FloatArray, rate: FloatArray,
    before: float, hole: FloatArray, z: float, force: FloatArray, moved: FloatArray, wall: FloatArray,
) -> bool:  # fmt: skip
    """Displacement that the forces at an axial displacement z [m] ask for, into ``moved``; whether the tip slips.

    ``u``, ``rate``: displacement and rate of what has mass; ``before``: z a step ago.
    """
    c = soft.compliance
    depth = now.commanded + u[2] + z
    feed = max((now.moving + rate[2] + (z - before) / now.step) / cycle.turns, 0.0)
    cut_at(cycle, profile, depth, now.deepest, feed, force)
    thrust, torque = force[0], force[1]
    fx = now.cos_slope * force[2] - now.sin_slope * force[3]
    fy = now.sin_slope * force[2] + now.cos_slope * force[3]
    for i in range(3):
        moved[i] = c[i, 0] * fx + c[i, 1] * fy - c[i, 2] * thrust - soft.turn[i] * torque
    wall[0], wall[1] = 0.0, 0.0
    stiffness = cycle.wall_stiffness * min(1.0, depth / cycle.cone) if depth > 0.0 else 0.0
    slips = False
    if stiffness > 0.0:
        gap_x, gap_y = u[0] + moved[0] - hole[0], u[1] + moved[1] - hole[1]
        if depth < cycle.cone:
            slips = held_at_most(c, stiffness, gap_x, gap_y, cycle.friction * thrust, wall)
        else:
            held_by(c, stiffness, gap_x, gap_y, wall)
        for i in range(3):
            moved[i] += c[i, 0] * wall[0] + c[i, 1] * wall[1]
    return slips


@compiled
def settle(
    cycle: DrillCycle, soft: AtOnce, profile: DepthProfile, now: Instant, u: FloatArray, rate: FloatArray,
    moved: FloatArray, hole: FloatArray, force: FloatArray, wall: FloatArray,
) -> None:  # fmt: skip
    r"""Solve :math:`z = [C\,F(z, \dot z)]_z` for what yields at once; ``moved`` goes from the last step to this one.

    Thrust rises with depth and feed, so that :math:`z - [C F]_z` rises too and has one root; it is bracketed and
    halved, with a secant where that is quicker. The hole moves where the tip slips.
    """
    before = moved[2]
    span = max(1e-9, now.moving * now.step)
    low = before - span
    wanted(cycle, soft, profile, now, u, rate, before, hole, low, force, moved, wall)
    g_low = low - moved[2]
    while g_low > 0.0:
        low -= span
        span *= 2.0
        wanted(cycle, soft, profile, now, u, rate, before, hole, low, force, moved, wall)
        g_low = low - moved[2]
    high, g_high = low, g_low
    while g_high < 0.0:
        low, g_low = high, g_high
        high += span
        span *= 2.0
        wanted(cycle, soft, profile, now, u, rate, before, hole, high, force, moved, wall)
        g_high = high - moved[2]
    z, slips = high, False
    for trial in range(TRIALS):
        z = high - g_high * (high - low) / (g_high - g_low) if g_high > g_low else high
        if trial % 3 == 2 or not low < z < high:
            z = 0.5 * (low + high)
        slips = wanted(cycle, soft, profile, now, u, rate, before, hole, z, force, moved, wall)
        g = z - moved[2]
        if abs(g) < CLOSE or high - low < CLOSE:
            break
        if g > 0.0:
            high, g_high = z, g
        else:
            low, g_low = z, g
    depth = now.commanded + u[2] + z
    if slips:
        stiffness = cycle.wall_stiffness * min(1.0, depth / cycle.cone)
        hole[0] = u[0] + moved[0] + wall[0] / stiffness
        hole[1] = u[1] + moved[1] + wall[1] / stiffness
    moved[2] = z


def nothing_at_once() -> AtOnce:
    """All that yields has mass."""
    return AtOnce(np.zeros((3, 3)), np.zeros(3))
