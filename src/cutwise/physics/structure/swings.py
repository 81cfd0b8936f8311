"""Arms with mass, as terms of a structure: one swinging mass, or the links of the arm on its joints."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray, station
from cutwise.records import Tip
from cutwise.stages import displaced, noted, stepped


class Swinging(NamedTuple):
    r"""An arm as three translations of one mass at the height where the surface is read.

    .. math:: m \ddot u + D \dot u + K u = F, \quad K = C_{3\times3}^{-1}, \quad
              D = \sum_k v_k\, 2 \zeta \sqrt{\lambda_k m}\, v_k^T

    with the eigenpairs :math:`\lambda_k, v_k` of K.
    """

    at: FloatArray  # [m] of the path, rising, shape (n,)
    stiffness: FloatArray  # K at the stations [N/m], shape (n, 3, 3)
    damping: FloatArray  # D at the stations [N s/m], shape (n, 3, 3)
    mass: float  # [kg]


class SwingState(NamedTuple):
    """Displacement and velocity of a swinging arm."""

    u: FloatArray  # [m], shape (3,)
    v: FloatArray  # [m/s], shape (3,)


class Linked(NamedTuple):
    r"""An arm as links with masses on elastic joints, k of them.

    .. math:: M \ddot q + D \dot q + K_\theta q = J^T W, \quad D = M V \,\mathrm{diag}(2\zeta\omega)\, V^T M,
              \qquad \xi = J q

    with the modes :math:`K_\theta v = \omega^2 M v`, V normalised to :math:`V^T M V = 1`; everything multiplied by
    :math:`M^{-1}`. The twist of the tip is in process axes.
    """

    at: FloatArray  # [m] of the path, rising, shape (n,)
    spring: FloatArray  # M^-1 K [1/s^2], shape (n, k, k)
    damper: FloatArray  # M^-1 D [1/s], shape (n, k, k)
    gain: FloatArray  # M^-1 J^T [rad/s^2 per N, N m], shape (n, k, 6)
    jacobian: FloatArray  # J [m/rad; -], shape (n, 6, k)
    frequency: FloatArray  # natural frequencies, undamped, rising [rad/s], shape (n, k)
    pivot: float = 0.0  # [m] over the tip, about which the load of the structure has its moments


class LinkedState(NamedTuple):
    """Joints that give way, and what the tip does by them."""

    q: FloatArray  # [rad], shape (k,)
    v: FloatArray  # [rad/s], shape (k,)
    pull: FloatArray  # [rad/s^2] scratch, shape (k,)
    twist: FloatArray  # of the tip, process axes [m, rad], shape (6,)
    rate: FloatArray  # of that [m/s, rad/s], shape (6,)


@displaced.of(Swinging)
def _(structure, flexed, foot, above):
    u, v = flexed.u, flexed.v
    return Tip(u[0], u[1], u[2], v[0], v[1], v[2])


@stepped.of(Swinging)
def _(structure, flexed, pose, load, dt):
    """Semi-implicit Euler; stiffness and damping straight between their stations."""
    u, v, total = flexed.u, flexed.v, load.total
    at, share = station(structure.at, pose.along)
    after = min(at + 1, structure.at.size - 1)
    u0, u1, u2, v0, v1, v2 = u[0], u[1], u[2], v[0], v[1], v[2]
    for i in range(3):
        k0, k1 = structure.stiffness[at, i], structure.stiffness[after, i]
        d0, d1 = structure.damping[at, i], structure.damping[after, i]
        low = k0[0] * u0 + k0[1] * u1 + k0[2] * u2 + d0[0] * v0 + d0[1] * v1 + d0[2] * v2
        high = k1[0] * u0 + k1[1] * u1 + k1[2] * u2 + d1[0] * v0 + d1[1] * v1 + d1[2] * v2
        v[i] += dt * (total[i] - (low + share * (high - low))) / structure.mass
    for i in range(3):
        u[i] += dt * v[i]
    return 0


@noted.of(Swinging)
def _(structure, flexed, table, row, at):
    for i in range(3):
        table[row, at + i] = flexed.u[i]
    return at + 3


@stepped.of(Linked)
def _(structure, flexed, pose, load, dt):
    """Semi-implicit Euler; everything straight between its stations. Moments about the tip from those about the pivot."""
    q, v, total, count = flexed.q, flexed.v, load.total, flexed.q.size
    fx, fy, fz = total[0], total[1], total[2]
    mx, my = -(structure.pivot * fy - total[5]), structure.pivot * fx - total[4]
    at, share = station(structure.at, pose.along)
    after = min(at + 1, structure.at.size - 1)
    for i in range(count):
        here, there = structure.gain[at, i], structure.gain[after, i]
        low = here[0] * fx + here[1] * fy + here[2] * fz + here[3] * mx + here[4] * my
        high = there[0] * fx + there[1] * fy + there[2] * fz + there[3] * mx + there[4] * my
        gained = low + share * (high - low)
        for j in range(count):
            k0, d0 = structure.spring[at, i, j], structure.damper[at, i, j]
            gained -= (k0 + share * (structure.spring[after, i, j] - k0)) * q[j]
            gained -= (d0 + share * (structure.damper[after, i, j] - d0)) * v[j]
        flexed.pull[i] = gained
    for i in range(count):
        v[i] += dt * flexed.pull[i]
        q[i] += dt * v[i]
    for i in range(6):
        here, there = structure.jacobian[at, i], structure.jacobian[after, i]
        place, rate = 0.0, 0.0
        for j in range(count):
            slope = here[j] + share * (there[j] - here[j])
            place += slope * q[j]
            rate += slope * v[j]
        flexed.twist[i], flexed.rate[i] = place, rate
    return 0


@displaced.of(Linked)
def _(structure, flexed, foot, above):
    twist, rate, z = flexed.twist, flexed.rate, foot + above
    return Tip(
        twist[0] + twist[4] * z,
        twist[1] - twist[3] * z,
        twist[2],
        rate[0] + rate[4] * z,
        rate[1] - rate[3] * z,
        rate[2],
    )


@noted.of(Linked)
def _(structure, flexed, table, row, at):
    for i in range(6):
        table[row, at + i] = flexed.twist[i]
    return at + 6


def swinging(at: FloatArray, compliance: FloatArray, mass: float, damping: float) -> Swinging:
    """A swinging arm from its translational compliance at the stations [m/N], shape (n, 3, 3), and damping ratio.

    ``mass`` in kg, ``damping`` from 0. Valid for an arm whose modes of interest move the tool more than they turn it.

    References
    ----------
    Derived here: modal damping of one mass on the joints' springs; Caughey 1960, J. Appl. Mech. 27 (when it is diagonal).
    """
    stiffness = np.linalg.inv(compliance)
    value, vector = np.linalg.eigh(0.5 * (stiffness + np.swapaxes(stiffness, -1, -2)))
    strength = 2.0 * damping * np.sqrt(value * mass)
    resistance = np.einsum("kij,kj,klj->kil", vector, strength, vector)
    return Swinging(at, stiffness, resistance, mass)  # type: ignore[arg-type]


def linked(
    at: FloatArray, mass: FloatArray, stiffness: FloatArray, damping: float, jacobian: FloatArray
) -> Linked:  # fmt: skip
    """An arm with masses from M at the stations (n, k, k), joint stiffness (k,), damping ratio and J (n, 6, k).

    Raises
    ------
    ValueError
        A joint moves no mass.

    References
    ----------
    Derived here; modal damping as in Caughey 1960, J. Appl. Mech. 27.
    """
    inverse_root = np.linalg.inv(np.linalg.cholesky(_definite(mass)))
    value, vector = np.linalg.eigh(inverse_root * stiffness @ np.swapaxes(inverse_root, -1, -2))
    modes = np.swapaxes(inverse_root, -1, -2) @ vector  # V
    frequency = np.sqrt(value)
    inverse = modes @ np.swapaxes(modes, -1, -2)  # M^-1
    damper = (modes * (2.0 * damping * frequency)[:, None, :]) @ np.swapaxes(modes, -1, -2) @ mass
    arms = np.ascontiguousarray(jacobian)
    return Linked(
        at, inverse * stiffness, np.ascontiguousarray(damper),
        np.ascontiguousarray(inverse @ np.swapaxes(arms, -1, -2)), arms, frequency,
    )  # fmt: skip


def _definite(mass: FloatArray) -> FloatArray:
    least = np.linalg.eigvalsh(mass)[..., 0].min()
    if not least > 1e-9 * np.abs(mass).max():
        raise ValueError("a joint moves no mass")
    return mass


def natural_frequencies(term: Swinging | Linked) -> FloatArray:
    r"""Natural frequencies of an arm with mass at its stations, :math:`\sqrt{\lambda_k/m}/2\pi` [Hz], rising, (n, k).

    References
    ----------
    Derived here.
    """
    if isinstance(term, Linked):
        return np.asarray(term.frequency / (2.0 * math.pi))
    return np.sqrt(np.linalg.eigvalsh(term.stiffness) / term.mass) / (2.0 * math.pi)
