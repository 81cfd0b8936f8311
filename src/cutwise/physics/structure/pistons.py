r"""The compliance device: a rigid motor on a spherical joint, held by a ring of pneumatic pistons with seal friction.

The state is the tilt :math:`q = (q_x, q_y)` of the motor; a point at distance L from the joint moves :math:`L q`, and
the motor face moves :math:`s_i = l_p \, n_i \cdot q` towards piston i. Axial and radial pistons give the same
first-order model: only the moment arm :math:`l_p` counts.

Pistons have no mass. A piston that the motor pushes (s > x) follows it; one that the motor leaves comes out as far as
pressure and friction let it, or stays back. Its position x is a state of its own. In one time step the whole law is
the slope of a convex function of s,

.. math:: \varphi(s) = \min_{x \ge s,\; 0 \le x \le s_{max}} F_p x + W_f(x - x_{old}),

with the friction work :math:`W_f` of the law in use, and the step is the minimiser of
:math:`\tfrac12 I |q - q_f|^2 / \Delta t^2 + \sum_i \varphi_i(l_p n_i \cdot q)`.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray

NO_FRICTION = 0
SET_VALUED = 1
PRESLIDING = 2
REGULARISED = 3

STUCK_SPEED = 1e-6  # [m/s] a piston slower than this counts as stuck
_SWEEPS = 2000


class PistonRing(NamedTuple):
    """Motor and pistons at one pressure."""

    direction: FloatArray  # unit vectors n_i from the axis to the pistons, shape (n, 2)
    arm: float  # [m] moment arm l_p of the pistons about the joint
    inertia: float  # [kg m^2] of motor, tool and spindle about the joint
    stroke: float  # [m] piston travel from the extended dead point to the other
    pressure_force: float  # [N] per piston
    friction_static: float  # [N] per piston
    friction_dynamic: float  # [N] per piston
    law: int  # NO_FRICTION, SET_VALUED, PRESLIDING or REGULARISED
    breakaway_travel: float  # [m] elastic travel of a seal before it slips (presliding)
    stribeck_speed: float  # [m/s] of the fall from static to dynamic friction, or of the regularised law; 0: at once
    moment_x: float  # [N m] of gravity, as force times arm along x
    moment_y: float  # [N m]
    tolerance: float  # [N] of the contact forces


class RingState(NamedTuple):
    """State of the pistons, changed in place by a step."""

    travel: FloatArray  # [m] piston positions x_i, 0 at the extended dead point, shape (n,)
    seal: FloatArray  # [m] where the seal of each piston is anchored (presliding), shape (n,)
    speed: FloatArray  # [m/s] of the pistons in the last step, shape (n,)
    force: FloatArray  # [N] contact forces on the motor, for the warm start; only their sum is unique, shape (n,)


def piston_directions(count: int, first_azimuth: float) -> FloatArray:
    """Unit vectors to equally spaced pistons, the first at an azimuth from +x [rad]; shape (count, 2)."""
    azimuth = first_azimuth + 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(azimuth), np.sin(azimuth)])


def at_rest(ring: PistonRing) -> RingState:
    """All pistons at the extended dead point, seals relaxed, motor centred."""
    n = len(ring.direction)
    return RingState(np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))


@compiled
def friction_limit(ring: PistonRing, speed: float) -> float:
    r"""Friction limit of a seal that moved with a speed in the last step [N].

    .. math:: F = F_d + (F_s - F_d) e^{-(v/v_s)^2}

    With :math:`v_s = 0` the fall is at once: static while stuck, dynamic when sliding. The limit is frozen over a
    step, so that the step stays a convex program.
    """
    if ring.law == NO_FRICTION:
        return 0.0
    if ring.stribeck_speed > 0.0 and ring.law == PRESLIDING:
        ratio = speed / ring.stribeck_speed
        return ring.friction_dynamic + (ring.friction_static - ring.friction_dynamic) * math.exp(-ratio * ratio)
    if ring.law == REGULARISED:
        return ring.friction_dynamic
    return ring.friction_static if abs(speed) < STUCK_SPEED else ring.friction_dynamic


@compiled
def seal_force(ring: PistonRing, limit: float, x: float, old: float, anchor: float, dt: float) -> float:
    """Friction on a piston that moves from ``old`` to x within a step; for a set-valued law at rest, zero [N]."""
    if ring.law == PRESLIDING:
        stiffness = ring.friction_static / ring.breakaway_travel
        return min(limit, max(-limit, stiffness * (x - anchor)))
    if ring.law == REGULARISED:
        return limit * math.tanh((x - old) / (dt * ring.stribeck_speed))
    if x > old:
        return limit
    if x < old:
        return -limit
    return 0.0


@compiled
def pushed_position(
    ring: PistonRing, limit: float, free: float, yielding: float, old: float, anchor: float, dt: float
) -> float:
    r"""Where the motor face comes to rest against one piston that it pushes, all other pistons held.

    Solves :math:`(s - s_f) / d + N(s) = 0` for a piston in contact (x = s), with :math:`N = F_p + F_f(s)`,
    :math:`d` the yielding of the face [m/N] and :math:`s_f` where it would go freely. N rises with s, so the root is
    unique; for the set-valued law and the seal spring it is in closed form.
    """
    pressed = free - yielding * ring.pressure_force
    if ring.law == PRESLIDING:
        stiffness = ring.friction_static / ring.breakaway_travel
        s = (pressed + yielding * stiffness * anchor) / (1.0 + yielding * stiffness)
        if stiffness * (s - anchor) > limit:
            s = pressed - yielding * limit
        elif stiffness * (s - anchor) < -limit:
            s = pressed + yielding * limit
        return s
    if ring.law == REGULARISED:
        low = pressed - yielding * limit
        high = pressed + yielding * limit
        for _ in range(60):
            s = 0.5 * (low + high)
            if s - pressed + yielding * limit * math.tanh((s - old) / (dt * ring.stribeck_speed)) > 0.0:
                high = s
            else:
                low = s
        return 0.5 * (low + high)
    if pressed - yielding * limit > old:
        return pressed - yielding * limit
    if pressed + yielding * limit < old:
        return pressed + yielding * limit
    return old


@compiled
def free_return(ring: PistonRing, limit: float, old: float, anchor: float, dt: float) -> float:
    """Where a piston comes to rest that nothing touches: back at the dead point, or where friction holds it [m]."""
    if ring.law == PRESLIDING:
        stiffness = ring.friction_static / ring.breakaway_travel
        if ring.pressure_force > limit:
            return 0.0
        return max(0.0, min(old, anchor - ring.pressure_force / stiffness))
    if ring.law == REGULARISED:
        if ring.pressure_force >= limit:
            return 0.0
        return max(0.0, old - dt * ring.stribeck_speed * math.atanh(ring.pressure_force / limit))
    return 0.0 if ring.pressure_force > limit else old


@compiled
def contact_force(
    ring: PistonRing, limit: float, free: float, yielding: float, old: float, anchor: float, dt: float
) -> float:
    """Contact force of one piston on the motor, all others held: the prox of its convex potential [N].

    The face either stays clear of the piston (no force), rests on it at its own free position, pushes it, or drives
    it into the inner dead point.
    """
    rest = free_return(ring, limit, old, anchor, dt)
    if free <= rest:
        return 0.0
    s = pushed_position(ring, limit, free, yielding, old, anchor, dt)
    s = min(max(s, rest), ring.stroke)
    return (free - s) / yielding


@compiled
def step(
    ring: PistonRing, state: RingState, qx: float, qy: float, vx: float, vy: float, mx: float, my: float, dt: float
) -> tuple[float, float, float, float, int]:
    r"""One time step of motor and pistons: backward Euler in displacement increments (Moreau).

    .. math:: q_f = q + \Delta t\, \dot q + \Delta t^2 M / I, \qquad
              q^+ = q_f - \frac{\Delta t^2 l_p}{I} \sum_i n_i N_i, \qquad \dot q^+ = (q^+ - q) / \Delta t

    solved by Gauss-Seidel over the pistons from the forces of the last step. Stops are inelastic.

    Parameters
    ----------
    ring, state : PistonRing, RingState
        The device, and its state, which is changed in place.
    qx, qy : float
        Tilt [rad].
    vx, vy : float
        Rate of tilt [rad/s].
    mx, my : float
        Moment of the cutting forces as force times distance from the joint, along x and y [N m].
    dt : float
        Time step [s].

    Returns
    -------
    qx, qy, vx, vy : float
        Tilt and its rate after the step.
    sweeps : int
        Gauss-Seidel sweeps used; the largest number means that the tolerance was not reached.
    """
    n = state.travel.size
    gain = dt * dt / ring.inertia
    new_x = qx + dt * vx + gain * (mx + ring.moment_x)
    new_y = qy + dt * vy + gain * (my + ring.moment_y)
    lever = gain * ring.arm
    yielding = lever * ring.arm
    for i in range(n):
        new_x -= lever * ring.direction[i, 0] * state.force[i]
        new_y -= lever * ring.direction[i, 1] * state.force[i]
    sweeps = 0
    change = 2.0 * ring.tolerance
    while change > ring.tolerance and sweeps < _SWEEPS:
        sweeps += 1
        change = 0.0
        for i in range(n):
            nx = ring.direction[i, 0]
            ny = ring.direction[i, 1]
            old_force = state.force[i]
            free = ring.arm * (nx * new_x + ny * new_y) + yielding * old_force
            limit = friction_limit(ring, state.speed[i])
            force = contact_force(ring, limit, free, yielding, state.travel[i], state.seal[i], dt)
            difference = force - old_force
            if difference != 0.0:
                state.force[i] = force
                new_x -= lever * nx * difference
                new_y -= lever * ny * difference
                change = max(change, abs(difference))
    for i in range(n):
        face = ring.arm * (ring.direction[i, 0] * new_x + ring.direction[i, 1] * new_y)
        move_piston(ring, state, i, face, dt)
    return new_x, new_y, (new_x - qx) / dt, (new_y - qy) / dt, sweeps


@compiled
def move_piston(ring: PistonRing, state: RingState, i: int, face: float, dt: float) -> None:
    """Bring piston i to where the motor face or its own friction leaves it, and its seal along."""
    old = state.travel[i]
    limit = friction_limit(ring, state.speed[i])
    x = min(ring.stroke, max(free_return(ring, limit, old, state.seal[i], dt), face))
    state.speed[i] = (x - old) / dt
    state.travel[i] = x
    if ring.law == PRESLIDING:
        reach = limit * ring.breakaway_travel / ring.friction_static
        state.seal[i] = min(max(state.seal[i], x - reach), x + reach)


def friction_at(force_at_reference: float, pressure: float, reference: float, preload_fraction: float) -> float:
    r"""Seal friction at a pressure: :math:`F(p) = F(p_0) [f + (1 - f) p / p_0]`.

    The preload share f stays at zero pressure: the paper's :math:`\mu (A p + P)` with one unknown (sec. 3.3).
    """
    return force_at_reference * (preload_fraction + (1.0 - preload_fraction) * pressure / reference)
