"""A drilled hole without inertia and damping: the cross-check of the time stepping."""

import math

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.process.drill_profile import DepthProfile, profile_at
from cutwise.process.hole_balance import DrillCycle, held_at_most, held_by
from cutwise.process.loops_drilling import ArmDynamics


def quasi_static_hole(
    cycle: DrillCycle,
    arm: ArmDynamics,
    profile: DepthProfile,
    *,
    slope_angle: float = 0.0,
    advance: float = 1e-6,
) -> tuple[FloatArray, FloatArray]:
    """The same hole without inertia and damping: cross-check of the time stepping.

    Every advance [m] of the tip solves the balance of arm, wall and friction for the displacement; the actual feed is
    less than the commanded one while the arm gives way, and more while it springs back. Returns the hole positions at
    entry and exit [m], shape (2,) each.
    """
    turn = (math.cos(slope_angle), math.sin(slope_angle))
    compliance = np.ascontiguousarray(arm.compliance)
    turned = arm.soft.turn.copy()
    if math.isfinite(arm.mass):
        turned += np.linalg.solve(arm.stiffness, arm.torque_push)
    marks = _run_quasi_static(
        cycle, profile, compliance, np.asarray(np.linalg.solve(compliance, turned), dtype=float), turn, advance
    )
    return marks[0], marks[1]


@compiled
def _feed_share(advance: float, pushed: float, exponent: float, before: float, bias: float) -> float:
    r"""Actual over commanded feed while the tip advances by ``advance``.

    Root of :math:`r\,(\Delta z - u(r) + u_0) = \Delta z`, :math:`u(r) = b + u_F r^{1-m_c}` with the
    axial deflection :math:`u_F` under the forces at nominal feed; the left side rises where they push back.
    """
    low, high = 0.0, 50.0
    for _ in range(50):
        r = 0.5 * (low + high)
        yielded = bias + pushed * r ** (1.0 - exponent)
        if r * (advance - yielded + before) < advance:
            low = r
        else:
            high = r
    return 0.5 * (low + high)


@compiled
def _run_quasi_static(
    cycle: DrillCycle,
    profile: DepthProfile,
    compliance: FloatArray,
    torque_push: FloatArray,
    turn_slope: tuple[float, float],
    advance: float,
) -> FloatArray:
    hole, wall, marks = np.zeros(2), np.zeros(2), np.zeros((2, 2))
    force, u = np.zeros(3), np.zeros(3)
    cos_slope, sin_slope = turn_slope
    entered = False
    for k in range(1, math.ceil((cycle.thickness + cycle.cone) / advance) + 1):
        depth = k * advance
        thrust, torque, side_x, side_y = profile_at(profile, depth)
        bias = compliance[2, 0] * wall[0] + compliance[2, 1] * wall[1]
        force[0] = cos_slope * side_x - sin_slope * side_y - torque * torque_push[0]
        force[1] = sin_slope * side_x + cos_slope * side_y - torque * torque_push[1]
        force[2] = -thrust - torque * torque_push[2]
        pushed = compliance[2, 0] * force[0] + compliance[2, 1] * force[1] + compliance[2, 2] * force[2]
        share = _feed_share(advance, pushed, cycle.exponent, u[2], bias) ** (1.0 - cycle.exponent)
        thrust *= share
        u[:] = compliance @ force
        u *= share
        stiffness = cycle.wall_stiffness * min(1.0, depth / cycle.cone)
        gap_x, gap_y = u[0] - hole[0], u[1] - hole[1]
        slipping = False
        if depth < cycle.cone:
            slipping = held_at_most(compliance, stiffness, gap_x, gap_y, cycle.friction * thrust, wall)
        else:
            held_by(compliance, stiffness, gap_x, gap_y, wall)
        for i in range(3):
            u[i] += compliance[i, 0] * wall[0] + compliance[i, 1] * wall[1]
        if slipping:
            hole[0], hole[1] = u[0] + wall[0] / stiffness, u[1] + wall[1] / stiffness
        follow = min(1.0, advance / cycle.wander)
        hole[0] += (u[0] - hole[0]) * follow
        hole[1] += (u[1] - hole[1]) * follow
        if depth >= cycle.cone and not entered:
            entered = True
            marks[0, 0], marks[0, 1] = hole[0], hole[1]
    marks[1, 0], marks[1, 1] = hole[0], hole[1]
    return marks
