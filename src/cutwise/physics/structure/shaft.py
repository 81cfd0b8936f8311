r"""A turned shaft as a stepped beam on supports: what it and each support yield by under the tool, and its modes.

Timoshenko elements, exact at their ends where diameters step there. A shaft turns: it is as stiff along the cut as off
the work. A feed force :math:`F_x` at the radius r of the cut bends it with :math:`r F_x`.
"""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray


class Support(NamedTuple):
    """A support of a shaft; infinite is rigid, zero is none."""

    z: float  # [m] along the shaft
    radial: float  # [N/m]
    angular: float  # [N m/rad]


class Shaft(NamedTuple):
    """Stiffness and mass over displacement [m] and slope at each of n places, shape (2n, 2n), and the supports."""

    z: FloatArray  # [m], rising, shape (n,)
    stiffness: FloatArray
    mass: FloatArray
    supports: tuple[Support, ...]


def shaft(
    z: FloatArray, diameter: FloatArray, young: float, poisson: float, density: float, supports: tuple[Support, ...]
) -> Shaft:
    r"""A shaft of diameters d between places z [m]; E [Pa], :math:`\nu`, :math:`\rho` [kg/m^3].

    .. math:: \Phi = \frac{12 EI}{k_s G A \ell^2}, \quad k_s = 0.9, \quad G = \frac{E}{2(1 + \nu)}

    Przemieniecki, Theory of Matrix Structural Analysis, 1968, sec. 5.6 and 11.6; the mass is that of slender elements.
    """
    n, w = np.diff(z), np.ones(len(z) - 1)
    inertia, area = np.pi * diameter**4 / 64.0, 0.25 * np.pi * diameter**2
    phi = 24.0 * (1.0 + poisson) * inertia / (0.9 * area * n**2)
    a, b, c, d = 12.0 * w, 6.0 * n, (4.0 + phi) * n**2, (2.0 - phi) * n**2
    bent = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]])
    a, b, c, d, e, f = 156.0 * w, 22.0 * n, 54.0 * w, 13.0 * n, 4.0 * n**2, 3.0 * n**2
    carried = np.array([[a, b, c, -d], [b, e, d, -f], [c, d, a, -b], [-d, -f, -b, e]])
    whole = np.zeros((2, 2 * len(z), 2 * len(z)))
    for k in range(len(n)):
        whole[0, 2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += (young * inertia / (n**3 * (1.0 + phi)) * bent)[..., k]
        whole[1, 2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += (density * area * n / 420.0 * carried)[..., k]
    return Shaft(z, *whole, supports)  # type: ignore[call-arg]


def _held(beam: Shaft) -> tuple[FloatArray, list[tuple[int, int, float]], FloatArray]:
    """Stiffness with the springs of the supports; support, coordinate and stiffness of each; what is free to move."""
    at = [2 * int(np.abs(beam.z - one.z).argmin()) for one in beam.supports]
    springs = [(i, at[i] + k, one[1 + k]) for i, one in enumerate(beam.supports) for k in range(2)]
    rigid = [place for _, place, stiffness in springs if np.isinf(stiffness)]
    whole = beam.stiffness.copy()
    springs = [(i, place, k) for i, place, k in springs if 0.0 < k < np.inf]
    for _, place, k in springs:
        whole[place, place] += k
    return whole, springs, np.setdiff1d(np.arange(len(whole)), rigid)


def _pushed(beam: Shaft, z: float, lever: float) -> FloatArray:
    """Coordinates in which a force along x and one along y at the tool work, shape (2n, 2)."""
    out, place = np.zeros((2 * len(beam.z), 2)), 2 * int(np.abs(beam.z - z).argmin())
    out[place + 1, 0], out[place, 1] = lever, 1.0
    return out


def yields(beam: Shaft, z: float, lever: float) -> FloatArray:
    r"""Compliance of the shaft and of each support under a tool at z, shape (1 + supports, 2, 2) along x and y [m/N].

    .. math:: C = E^T K^{-1} E = C_{shaft} + \sum_i k_i u_i u_i^T

    The work of the force is the energy of all that yields: on more supports than it needs, too, a shaft is a sum in
    series. ``lever``: radius of the cut [m], positive where a slope lets the surface move with the feed.
    """
    whole, springs, free = _held(beam)
    load, u = _pushed(beam, z, lever), np.zeros((len(whole), 2))
    u[free] = np.linalg.solve(whole[np.ix_(free, free)], load[free])
    out = np.zeros((1 + len(beam.supports), 2, 2))
    for i, place, k in springs:
        out[1 + i] += k * np.outer(u[place], u[place])
    out[0] = load.T @ u - out.sum(axis=0)
    return out


def modes(beam: Shaft, z: float, lever: float, count: int) -> tuple[FloatArray, FloatArray]:
    """Lowest natural frequencies [rad/s], (count,), and what these modes of unit mass move at a tool, (count, 2)."""
    whole, _, free = _held(beam)
    keep = np.ix_(free, free)
    lower = np.linalg.inv(np.linalg.cholesky(beam.mass[keep]))
    square, shape = np.linalg.eigh(lower @ whole[keep] @ lower.T)
    return np.sqrt(square[:count]), (lower.T @ shape[:, :count]).T @ _pushed(beam, z, lever)[free]
