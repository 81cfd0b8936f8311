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

from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled, inlined
from cutwise.maths.curves import FloatArray
from cutwise.physics.structure.seals import (
    PRESLIDING,
    REGULARISED,
    SET_VALUED,
    TOUCH,
    Piston,
    contact_force,
    dragged_anchor,
    free_return,
    friction_limit,
)
from cutwise.records import UNSOLVED

SWEEPS = UNSOLVED  # a step that takes them all has not found its forces
_HARMLESS = 1e-3  # [N] what is left over after them that moves nothing
_PATIENCE = 20  # sweeps after which the step is asked whether nothing moves at all


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

    >>> from cutwise.physics.structure.seals import NO_FRICTION
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
                if face < at - TOUCH:
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
