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

from cutwise.maths.compiled import compiled, inlined
from cutwise.maths.curves import FloatArray
from cutwise.records import UNSOLVED

NO_FRICTION = 0
SET_VALUED = 1
PRESLIDING = 2
REGULARISED = 3

_TOUCH = 1e-12  # [m] a face closer than this touches its piston
STUCK_SPEED = 1e-6  # [m/s] a piston slower than this counts as stuck
SWEEPS = UNSOLVED  # a step that takes them all has not found its forces
_HARMLESS = 1e-3  # [N] what is left over after them that moves nothing
_PATIENCE = 20  # sweeps after which the step is asked whether nothing moves at all


class Piston(NamedTuple):
    """One piston and its seal, at one pressure."""

    stroke: float  # [m] travel from the extended dead point to the other
    pressure_force: float  # [N]
    friction_static: float  # [N]
    friction_dynamic: float  # [N]
    law: int  # NO_FRICTION, SET_VALUED, PRESLIDING or REGULARISED
    breakaway_travel: float  # [m] elastic travel of the seal before it slips (presliding)
    stribeck_speed: float  # [m/s] of the fall from static to dynamic friction, or of the regularised law; 0: at once
    damping: float  # [N s/m] viscous, of the rubber


class PistonRing(NamedTuple):
    """Motor and pistons at one pressure."""

    direction: FloatArray  # unit vectors n_i from the axis to the pistons, shape (n, 2)
    piston: Piston
    arm: float  # [m] moment arm l_p of the pistons about the joint
    inertia: float  # [kg m^2] of motor, tool and spindle about the joint
    moment_x: float  # [N m] of gravity, as force times arm along x
    moment_y: float  # [N m]
    tolerance: float  # [N] of the contact forces


class RingState(NamedTuple):
    """State of the pistons, changed in place by a step."""

    travel: FloatArray  # [m] piston positions x_i, 0 at the extended dead point, shape (n,)
    seal: FloatArray  # [m] where the seal of each piston is anchored (presliding), shape (n,)
    speed: FloatArray  # [m/s] of the pistons in the last step; of their seals' slip (presliding), shape (n,)
    limit: FloatArray  # [N] friction limits of this step, shape (n,)
    force: FloatArray  # [N] contact forces on the motor, for the warm start; only their sum is unique, shape (n,)


def piston_directions(count: int, first_azimuth: float) -> FloatArray:
    """Unit vectors to equally spaced pistons, the first at an azimuth from +x [rad]; shape (count, 2).

    References
    ----------
    Berselli et al. 2016, sec. 1.1: seven pistons in a ring.
    """
    azimuth = first_azimuth + 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([np.cos(azimuth), np.sin(azimuth)])


def at_rest(ring: PistonRing) -> RingState:
    """All pistons at the extended dead point, seals relaxed, motor centred."""
    n = len(ring.direction)
    return RingState(*(np.zeros(n) for _ in range(5)))


@inlined
def friction_limit(piston: Piston, speed: float) -> float:
    r"""Friction limit of a seal that moved with a speed in the last step [N].

    .. math:: F = F_d + (F_s - F_d) e^{-(v/v_s)^2}

    With :math:`v_s = 0` the fall is at once, decided by the last step: static while stuck, dynamic when sliding. The
    step then is a convex program. With a Stribeck speed the limit follows the speed of the step itself, sweep by sweep.
    The regularised law is :math:`F_s \tanh(v / v_s)` and has no stick to fall from.

    Parameters
    ----------
    piston : Piston
        Seal with :math:`F_s, F_d` [N], :math:`v_s` [m/s] and its law.
    speed : float
        v [m/s], of either sign; slower than ``STUCK_SPEED`` counts as stuck where :math:`v_s = 0`.

    Returns
    -------
    float
        Limit [N], not negative.

    Notes
    -----
    Valid for :math:`F_d \le F_s` at one pressure, which is in both (:func:`friction_at`); no dwell time, no temperature.

    Examples
    --------
    Stuck, sliding, and at the Stribeck speed, where :math:`2.8 + 1.1/e` is left.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 0.0)
    >>> friction_limit(seal, 0.0), friction_limit(seal, 0.1)
    (3.9, 2.8)
    >>> round(friction_limit(seal._replace(stribeck_speed=0.01), 0.01), 6)
    3.204667

    References
    ----------
    Berselli et al. 2016, sec. 3.3 (two coefficients, no law between them); Armstrong-Hélouvry, Dupont and Canudas de
    Wit 1994, Automatica 30 (Gaussian fall).
    """
    if piston.law == NO_FRICTION:
        return 0.0
    if piston.law == REGULARISED:
        return piston.friction_static
    if piston.stribeck_speed > 0.0:
        ratio = speed / piston.stribeck_speed
        return piston.friction_dynamic + (piston.friction_static - piston.friction_dynamic) * math.exp(-ratio * ratio)
    return piston.friction_static if abs(speed) < STUCK_SPEED else piston.friction_dynamic


@inlined
def pushed_position(
    piston: Piston, limit: float, free: float, yielding: float, old: float, anchor: float, dt: float
) -> float:
    r"""Where the motor face comes to rest against one piston that it pushes, all other pistons held.

    Solves :math:`(s - s_f) / d + N(s) = 0` for a piston in contact (x = s), with :math:`N = F_p + F_f(s)`,
    :math:`d` the yielding of the face [m/N] and :math:`s_f` where it would go freely. N rises with s, so the root is
    unique; for the set-valued law and the seal spring it is in closed form.

    Parameters
    ----------
    piston : Piston
        The piston and the law of its seal.
    limit : float
        Friction limit of the step [N], from :func:`friction_limit`.
    free : float
        :math:`s_f` [m], without this piston.
    yielding : float
        :math:`d = \Delta t^2 l_p^2 / I` [m/N], positive.
    old, anchor : float
        Position of the piston and anchor of its seal before the step [m].
    dt : float
        Time step [s]; counts for the regularised law.

    Returns
    -------
    float
        s [m]; neither stops nor loss of contact are looked at, see :func:`contact_force`.

    Notes
    -----
    Valid for a piston without mass in touch with the face. The regularised law is met to :math:`d F_s / 2^{60}`, the
    others to rounding.

    Examples
    --------
    Pushed 2 mm, the face rests where 1.16 mm of yielding carry 7.7 N of pressure and 3.9 N of friction; pushed 1 mm, the
    seal holds it.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 0.0)
    >>> [round(1e3 * pushed_position(seal, 3.9, free, 1e-4, 0.0, 0.0, 1e-5), 9) for free in (0.002, 0.001)]
    [0.84, 0.0]

    References
    ----------
    Derived here: one row of Moreau's step with the forces of Berselli et al. 2016, sec. 3.3.
    """
    pressed = free - yielding * piston.pressure_force
    if piston.law == PRESLIDING:
        stiffness = piston.friction_static / piston.breakaway_travel
        s = (pressed + yielding * stiffness * anchor) / (1.0 + yielding * stiffness)
        if stiffness * (s - anchor) > limit:
            s = pressed - yielding * limit
        elif stiffness * (s - anchor) < -limit:
            s = pressed + yielding * limit
        return s
    if piston.law == REGULARISED:
        low = pressed - yielding * limit
        high = pressed + yielding * limit
        for _ in range(60):
            s = 0.5 * (low + high)
            if s - pressed + yielding * limit * math.tanh((s - old) / (dt * piston.stribeck_speed)) > 0.0:
                high = s
            else:
                low = s
        return 0.5 * (low + high)
    if pressed - yielding * limit > old:
        return pressed - yielding * limit
    if pressed + yielding * limit < old:
        return pressed + yielding * limit
    return old


@inlined
def free_return(piston: Piston, limit: float, old: float, anchor: float, dt: float) -> float:
    r"""Where a piston comes to rest that nothing touches: back at the dead point, or where friction holds it [m].

    .. math:: c\,(x_{old} - x) / \Delta t = F_p - F, \qquad x \ge 0

    Without damping c it is back at once if pressure is more than friction; less than friction, it stays (set-valued),
    relaxes its seal (presliding) or creeps at :math:`v_s \tanh^{-1}(F_p/F_s)` (regularised, damping left out).

    Parameters
    ----------
    piston : Piston
        Piston with pressure force :math:`F_p` [N] and damping c [N s/m].
    limit : float
        Friction limit F [N].
    old, anchor : float
        Position of the piston and anchor of its seal before the step [m].
    dt : float
        Time step [s].

    Returns
    -------
    float
        Position [m], from 0, the extended dead point, to ``old``.

    Notes
    -----
    Valid for pistons whose mass and air flow take no time; c is the only thing that does.

    Examples
    --------
    3.8 N against 10 N s/m drive it 0.38 mm in 1 ms; friction of 8 N holds it.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 10.0)
    >>> [round(1e3 * free_return(seal, limit, 0.001, 0.0, 0.001), 9) for limit in (3.9, 8.0)]
    [0.62, 1.0]

    References
    ----------
    Derived here from the forces of Berselli et al. 2016, sec. 3.3.
    """
    if piston.law == PRESLIDING:
        stiffness = piston.friction_static / piston.breakaway_travel
        if piston.pressure_force <= limit:
            return max(0.0, min(old, anchor - piston.pressure_force / stiffness))
    elif piston.law == REGULARISED and piston.pressure_force < limit:
        return max(0.0, old - dt * piston.stribeck_speed * math.atanh(piston.pressure_force / limit))
    if piston.pressure_force <= limit:
        return old
    if piston.damping == 0.0:
        return 0.0
    return max(0.0, old - dt * (piston.pressure_force - limit) / piston.damping)


@inlined
def contact_force(
    piston: Piston, limit: float, free: float, yielding: float, old: float, anchor: float, dt: float
) -> float:
    r"""Contact force of one piston on the motor, all others held: the prox of its convex potential [N].

    The face either stays clear of the piston (no force), rests on it at its own free position, pushes it, or drives
    it into the inner dead point.

    .. math:: N = (s_f - s) / d, \qquad x_r \le s \le s_{max}

    with :math:`x_r` of :func:`free_return` and s of :func:`pushed_position`; viscous damping c makes that step with
    :math:`s_f' = (s_f + d c\,x_{old}/\Delta t)/h` and :math:`d' = d/h`, :math:`h = 1 + d c/\Delta t`.

    Parameters
    ----------
    piston : Piston
        The piston and the law of its seal.
    limit : float
        Friction limit [N].
    free : float
        :math:`s_f`, position of the face without this piston [m].
    yielding : float
        d [m/N], positive.
    old, anchor : float
        Position of the piston and anchor of its seal before the step [m].
    dt : float
        Time step [s].

    Returns
    -------
    float
        N [N], never negative: the piston is not fastened to the motor.

    Notes
    -----
    Valid for inelastic stops; at the inner one the force is whatever stops the motor.

    Examples
    --------
    Clear, holding, pushed (pressure and friction: 11.6 N), and on the stop: 6 mm less 4 mm over the yielding.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 0.0)
    >>> [round(contact_force(seal, 3.9, free, 1e-4, 0.0, 0.0, 1e-5), 6) for free in (-0.001, 0.001, 0.002, 0.006)]
    [0.0, 10.0, 11.6, 20.0]

    References
    ----------
    Berselli et al. 2016, sec. 3.3 (the three contacts of a piston); Moreau 1965, Bull. Soc. Math. France 93 (prox).
    """
    rest = free_return(piston, limit, old, anchor, dt)
    if free <= rest:
        return 0.0
    if piston.damping == 0.0:
        s = pushed_position(piston, limit, free, yielding, old, anchor, dt)
    else:
        hold = 1.0 + yielding * piston.damping / dt  # viscous force (s - old) / dt folded into the free position
        damped = (free + (hold - 1.0) * old) / hold
        s = pushed_position(piston, limit, damped, yielding / hold, old, anchor, dt)
    s = min(max(s, rest), piston.stroke)
    return (free - s) / yielding


@inlined
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
        Gauss-Seidel sweeps used; ``SWEEPS`` means that the forces were not found to 1 mN.

    Notes
    -----
    Valid for tilts whose square may be left out (a tool tip that moves a small share of its distance from the joint); the
    spin of motor and tool has no gyroscopic moment here. First order in the step.

    Examples
    --------
    One piston at 80 mm holds 0.5 N m; of 1 N m it leaves 0.384 N m, which turn 0.001 kg m^2 at 384 rad/s^2.

    >>> free = Piston(0.004, 7.7, 0.0, 0.0, NO_FRICTION, 0.0, 0.0, 0.0)
    >>> ring = PistonRing(piston_directions(1, 0.0), free, 0.08, 0.001, 0.0, 0.0, 1e-6)
    >>> [round(step(ring, at_rest(ring), 0.0, 0.0, 0.0, 0.0, mx, 0.0, 1e-4)[2], 9) for mx in (0.5, 1.0)]
    [0.0, 0.0384]

    References
    ----------
    Moreau 1988, in Nonsmooth Mechanics and Applications (the step); Berselli et al. 2016, sec. 3.3 (joint, pistons and
    forces, which the paper leaves to a multibody program).
    """
    piston = ring.piston
    direction = ring.direction
    travel, seal, speed, limits, forces = state
    n = travel.size
    gain = dt * dt / ring.inertia
    new_x = qx + dt * vx + gain * (mx + ring.moment_x)
    new_y = qy + dt * vy + gain * (my + ring.moment_y)
    lever = gain * ring.arm
    yielding = lever * ring.arm
    for i in range(n):
        limits[i] = friction_limit(piston, speed[i])
        new_x -= lever * direction[i, 0] * forces[i]
        new_y -= lever * direction[i, 1] * forces[i]
    falling = piston.stribeck_speed > 0.0 and (piston.law == SET_VALUED or piston.law == PRESLIDING)
    sweeps = 0
    change = 2.0 * ring.tolerance
    while change > ring.tolerance and sweeps < SWEEPS:
        if sweeps == _PATIENCE and piston.law != PRESLIDING and piston.law != REGULARISED:
            rx = dt * vx + gain * (mx + ring.moment_x)
            ry = dt * vy + gain * (my + ring.moment_y)
            if stays(ring.arm, piston, direction, travel, limits, qx, qy, rx / lever, ry / lever):
                new_x, new_y = qx, qy
                break
        sweeps += 1
        change = 0.0
        for i in range(n):
            nx = direction[i, 0]
            ny = direction[i, 1]
            face = ring.arm * (nx * new_x + ny * new_y)
            free = face + yielding * forces[i]
            if falling:
                limits[i] = friction_limit(piston, (face - travel[i]) / dt)
            force = contact_force(piston, limits[i], free, yielding, travel[i], seal[i], dt)
            difference = force - forces[i]
            if difference != 0.0:
                forces[i] = force
                new_x -= lever * nx * difference
                new_y -= lever * ny * difference
                change = max(change, abs(difference))
    if sweeps == SWEEPS and change < _HARMLESS:
        sweeps -= 1
    for i in range(n):
        face = ring.arm * (direction[i, 0] * new_x + direction[i, 1] * new_y)
        old = travel[i]
        travel[i] = min(piston.stroke, max(free_return(piston, limits[i], old, seal[i], dt), face))
        anchor = seal[i]
        seal[i] = dragged_anchor(piston, limits[i], travel[i], anchor)
        speed[i] = ((seal[i] - anchor) if piston.law == PRESLIDING else (travel[i] - old)) / dt
    return new_x, new_y, (new_x - qx) / dt, (new_y - qy) / dt, sweeps


@compiled
def stays(
    arm: float, piston: Piston, direction: FloatArray, travel: FloatArray, limits: FloatArray,
    qx: float, qy: float, rx: float, ry: float,
) -> bool:  # fmt: skip
    r"""Whether the pistons can hold the motor where it is.

    All kinks of the convex program meet in the present tilt, where Gauss-Seidel may shift forces between the pistons
    for hundreds of sweeps. The forces needed, :math:`r = \sum_i n_i N_i`, are tested against the zonotope of
    :math:`N_i \in [N_{lo}, N_{hi}]` instead: its edges are parallel to the :math:`n_i`.

    .. math:: r \cdot u \le \sum_i \max(N_{lo}\, n_i \cdot u,\; N_{hi}\, n_i \cdot u) \quad \text{for all } u \perp n_k

    Parameters
    ----------
    arm : float
        Moment arm of the pistons [m].
    piston : Piston
        One piston.
    direction, travel, limits : array
        Directions, positions [m] and friction limits [N] of the pistons, shapes (n, 2), (n,) and (n,); not the tuples that
        hold them, whose references numba would count in every step.
    qx, qy : float
        Present tilt [rad].
    rx, ry : float
        Resultant that the pistons have to give [N].

    Returns
    -------
    bool
        True if they can.

    Notes
    -----
    Valid for friction that truly sticks (``NO_FRICTION``, ``SET_VALUED``); a piston on its inner stop says no, and the
    sweeps decide.

    Examples
    --------
    Along x the first of four pistons gives 7.7 N of pressure and 3.9 N of friction at most.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 0.0)
    >>> four, zero = piston_directions(4, 0.0), np.zeros(4)
    >>> [stays(0.08, seal, four, zero, np.full(4, 3.9), 0.0, 0.0, rx, 0.0) for rx in (11.5, 11.7)]
    [True, False]

    References
    ----------
    Derived here; a zonotope is cut out by the normals of its edges, e.g. Ziegler 1995, Lectures on Polytopes, sec. 7.3.
    """
    n = travel.size
    for k in range(n):
        for side in range(2):
            sign = 1.0 - 2.0 * side
            ux, uy = -sign * direction[k, 1], sign * direction[k, 0]
            reach = 0.0
            for i in range(n):
                nx, ny = direction[i, 0], direction[i, 1]
                face = arm * (nx * qx + ny * qy)
                at = travel[i]
                if face < at - _TOUCH:
                    continue
                high = piston.pressure_force + limits[i]
                low = 0.0 if at <= 0.0 else max(0.0, piston.pressure_force - limits[i])
                along = nx * ux + ny * uy
                if at >= piston.stroke and along > 0.0:
                    return False
                reach += along * (high if along > 0.0 else low)
            if rx * ux + ry * uy > reach:
                return False
    return True


@inlined
def dragged_anchor(piston: Piston, limit: float, x: float, anchor: float) -> float:
    r"""Where a seal is anchored after its piston came to x: it follows once the spring is at its limit [m].

    .. math:: |x - z| \le F\, x_b / F_s

    Parameters
    ----------
    piston : Piston
        Seal with static friction :math:`F_s` [N] and elastic travel :math:`x_b` [m].
    limit : float
        Friction limit F of the step [N].
    x : float
        Position of the piston after the step [m].
    anchor : float
        z before the step [m].

    Returns
    -------
    float
        z after it; the position itself where the seal has no spring.

    Notes
    -----
    Valid for one spring of even stiffness that slips at once (Jenkins element); rubber itself softens before it slips.

    Examples
    --------
    A seal that yields 0.1 mm before it slips is 0.1 mm behind its piston.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, PRESLIDING, 0.0001, 0.0, 0.0)
    >>> round(1e3 * dragged_anchor(seal, 3.9, 0.001, 0.0), 9)
    0.9

    References
    ----------
    Derived here: the Prandtl (Jenkins) element as a stop operator.
    """
    if piston.law != PRESLIDING:
        return x
    reach = limit * piston.breakaway_travel / piston.friction_static
    return min(max(anchor, x - reach), x + reach)


def friction_at(force_at_reference: float, pressure: float, reference: float, preload_fraction: float) -> float:
    r"""Seal friction at a pressure: :math:`F(p) = F(p_0) [f + (1 - f) p / p_0]`.

    The preload share f stays at zero pressure: the paper's :math:`\mu (A p + P)` with one unknown (sec. 3.3).

    Valid for pressures [Pa] not below zero; ``preload_fraction`` f is from 0 to 1.

    References
    ----------
    Berselli et al. 2016, sec. 3.3.
    """
    return force_at_reference * (preload_fraction + (1.0 - preload_fraction) * pressure / reference)
