r"""Statics of the piston ring: which moments it holds, and the force a tip displacement meets.

With every piston force in :math:`[0, F]` the ring holds any moment in the zonotope
:math:`Z = \{ l_p F \sum_i \lambda_i n_i,\ 0 \le \lambda_i \le 1 \}`. The motor stands away from its seat where the
cutting moment lies on the border of Z, tilted along the outward normal there. F is the pressure force with friction
added (loading), taken off (unloading), or left out.
"""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.physics.structure.pistons import PistonRing


class Branch(NamedTuple):
    """A branch of the static characteristic."""

    breakaway: float  # [N] at the tip, mean over all directions of displacement
    plateau: float  # [N] at the tip while sliding, mean over all directions


class Characteristic(NamedTuple):
    """Static tip force over tip displacement, mean over all directions."""

    loading: Branch
    unloading: Branch
    frictionless: float  # [N]
    stop: float  # [m] tip displacement at which the first piston meets its inner dead point, smallest over directions


def support(direction: FloatArray, unit: FloatArray) -> float:
    r"""Support function of the unit ring, :math:`\sum_i \max(0, n_i \cdot u)`.

    References
    ----------
    Derived here; e.g. Schneider 2014, Convex Bodies, sec. 1.7 (support functions).
    """
    return float(np.maximum(0.0, direction @ unit).sum())


def mean_support(direction: FloatArray) -> float:
    r"""Mean of the support function over all directions: :math:`n / \pi`, for any arrangement of n unit vectors.

    References
    ----------
    Derived here: the mean of :math:`\max(0, \cos)` is :math:`1/\pi`.
    """
    return len(direction) / np.pi


def characteristic(ring: PistonRing, reach: float) -> Characteristic:
    r"""Static characteristic at the tip: :math:`F = \frac{l_p}{L_t} \frac{n}{\pi} (F_p \pm F_f)`.

    No motion below breakaway, then constant force until the stop; the way back needs the force to fall to the
    unloading branch. A branch without force means that the pistons do not return.

    Parameters
    ----------
    ring : PistonRing
        The device at its pressure.
    reach : float
        Distance from the joint to the tip [m].

    References
    ----------
    Derived here from the forces of Berselli et al. 2016, sec. 3.3.
    """
    lever = ring.arm / reach * mean_support(ring.direction)
    p = ring.piston
    static, dynamic = (0.0, 0.0) if p.law == 0 else (p.friction_static, p.friction_dynamic)
    return Characteristic(
        Branch(lever * (p.pressure_force + static), lever * (p.pressure_force + dynamic)),
        Branch(lever * max(0.0, p.pressure_force - static), lever * max(0.0, p.pressure_force - dynamic)),
        lever * p.pressure_force,
        reach * p.stroke / ring.arm,
    )


class Borders(NamedTuple):
    """The normals of a ring's zonotope where its edges meet, and how far the unit ring reaches along them."""

    normal: FloatArray  # unit vectors, shape (2 n, 2)
    support: FloatArray  # shape (2 n,)


def borders(ring: PistonRing) -> Borders:
    """Both normals of every piston of a ring, with their support.

    References
    ----------
    Derived here; Ziegler 1995, Lectures on Polytopes, sec. 7.3 (zonotopes).
    """
    n = ring.direction
    across = np.stack([np.column_stack([-n[:, 1], n[:, 0]]), np.column_stack([n[:, 1], -n[:, 0]])], axis=1)
    normal = across.reshape(-1, 2)
    return Borders(normal, np.array([support(n, u) for u in normal]))


def gauge(ring: PistonRing, piston_force: float, moment: FloatArray, of: Borders) -> tuple[float, FloatArray]:
    r"""How much of the holding limit a moment uses, :math:`g = \max_u M \cdot u / h_Z(u)`, and the u of the maximum.

    :math:`g = 1` on the border of the zonotope. The maximum is met at a normal of one of its edges, which are parallel
    to the :math:`n_i`; so the motor yields at right angles to one piston, save where two edges meet.

    Parameters
    ----------
    ring : PistonRing
        The device.
    piston_force : float
        Largest force F of each piston [N], positive.
    moment : array
        Moment as force times arm, x and y [N m], shape (2,).
    of : Borders
        Of this ring; found once, asked many times.

    References
    ----------
    Derived here; gauge and support function: Schneider 2014, Convex Bodies, sec. 1.7.
    """
    part = (of.normal[:, 0] * moment[0] + of.normal[:, 1] * moment[1]) / (ring.arm * piston_force * of.support)
    best = int(part.argmax())
    return (float(part[best]), of.normal[best]) if part[best] > 0.0 else (0.0, np.array([0.0, 1.0]))
