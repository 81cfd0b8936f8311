r"""Regenerative limit of a mill on any structure: the receptances of all terms with mass add up.

.. math:: M \ddot u + D \dot u + K u = a_p B\,[u_{xy}(t) - u_{xy}(t - T)]

with the mean of the directional force coefficients over the arc (zeroth order: Altintas and Budak 1995).
"""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.flute import EdgeCoefficients

if TYPE_CHECKING:
    from scipy import optimize
else:
    optimize = later("scipy.optimize")

Receptance = Callable[[FloatArray], np.ndarray]  # angular frequency (m,) [rad/s] to (m, 3, 3) [m/N]

_POINTS = 4000  # of the search over frequency
_LOWEST = 0.5  # [Hz]
_BETWEEN = 1.5  # by which 1 / a_p between two points of the search may exceed that at both


class DepthLimit(NamedTuple):
    """The least axial depth at which a vibration does not die out."""

    depth: float  # [m]; infinite where nothing can chatter
    frequency: float  # [Hz] of the vibration


def mean_directions(lo: float, hi: float, flutes: int, k: EdgeCoefficients, *, up: bool = False) -> FloatArray:
    r"""Mean change of force for each displacement of the tool in the plane and each depth, shape (3, 2).

    .. math:: B = \frac{N}{2\pi} \int_{lo}^{hi} (-K_{tc}\cos\phi - K_{rc}\sin\phi,\; K_{tc}\sin\phi - K_{rc}\cos\phi,\;
              -K_{ac})^T (\sin\phi, \cos\phi)\, d\phi

    Parameters
    ----------
    lo, hi : float
        Arc [rad], clockwise from the normal off the work.
    flutes : int
        N.
    k : EdgeCoefficients
        Shearing coefficients [Pa].
    up : bool
        Up milling: the process frame is the mirror image, signs of y are reversed on rows and columns.

    Returns
    -------
    array (3, 2)
        [N/m^2]

    Notes
    -----
    Valid for small vibrations of a cut that is not interrupted for long: in a narrow arc the higher orders count.

    Examples
    --------
    A slot in a material with tangential force alone pushes across the feed when displaced along it:

    >>> b = mean_directions(0.0, math.pi, 2, EdgeCoefficients(1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    >>> [round(float(value), 9) + 0.0 for value in b.ravel()]
    [0.0, -0.5, 0.5, 0.0, 0.0, 0.0]

    References
    ----------
    Altintas and Budak 1995, zeroth order; the rows of the axial force are derived here.
    """
    ss = 0.5 * (hi - lo) - 0.25 * (math.sin(2.0 * hi) - math.sin(2.0 * lo))
    cc = 0.5 * (hi - lo) + 0.25 * (math.sin(2.0 * hi) - math.sin(2.0 * lo))
    sc = 0.5 * (math.sin(hi) ** 2 - math.sin(lo) ** 2)
    s, c = math.cos(lo) - math.cos(hi), math.sin(hi) - math.sin(lo)
    b = flutes / (2.0 * math.pi) * np.array([
        [-k.K_tc * sc - k.K_rc * ss, -k.K_tc * cc - k.K_rc * sc],
        [k.K_tc * ss - k.K_rc * sc, k.K_tc * sc - k.K_rc * cc],
        [-k.K_ac * s, -k.K_ac * c],
    ])  # fmt: skip
    return b * np.array([[1.0, -1.0], [-1.0, 1.0], [1.0, -1.0]]) if up else b


def depth_limit(receptance: Receptance, directions: FloatArray, tooth_period: float, highest: float) -> DepthLimit:
    r"""Least depth at which a vibration neither grows nor dies out.

    .. math:: a_p = \frac{1}{\lambda(\omega)\,(1 - e^{-i\omega T})} \text{ real and positive}

    for an eigenvalue :math:`\lambda` of :math:`[G(\omega) B]_{xy}`. Every crossing up to the highest frequency is
    bracketed and found; limits need not lie near the first mode.

    Parameters
    ----------
    receptance : callable
        G: displacement of the tool for a force there, of all terms with mass together.
    directions : array (3, 2)
        B, from :func:`mean_directions`.
    tooth_period : float
        T [s].
    highest : float
        Highest frequency looked at [Hz].

    Returns
    -------
    DepthLimit
        Depth [m] and frequency [Hz]; infinite and NaN where nothing can chatter up to the highest frequency.

    Notes
    -----
    Valid for small vibrations about a steady cut, and arcs wide enough for their mean directions (zeroth order); for
    interrupted cuts see :func:`cutwise.physics.cutting.stability.limit_depth`.

    Examples
    --------
    One direction at the speed that is worst for it: the least depth of all, :math:`2 k \zeta (1 + \zeta) / K`, with a
    vibration at :math:`\sqrt{1 + 2\zeta}` times the eigenfrequency (k = 1 N/µm, 5 %, K = 1 GPa).

    >>> g, b = swinging_receptance(1e6 * np.eye(3), 100.0 * np.eye(3), 1.0), np.zeros((3, 2))
    >>> b[1, 1], r = -1e9, math.sqrt(1.1)
    >>> worst = depth_limit(g, b, (7.0 * math.pi + 2.0 * math.atan(r)) / (1000.0 * r), 1000.0)
    >>> round(1e3 * worst.depth, 6), round(2.0 * math.pi * worst.frequency / 1000.0 - r, 4) + 0.0
    (0.105, 0.0)

    References
    ----------
    Altintas and Budak 1995, zeroth order; the search over frequency is derived here.
    """
    # the delay turns once in 1/T: enough points in every turn, whatever the speed
    count = max(_POINTS, math.ceil(64.0 * highest * tooth_period))
    omega = 2.0 * math.pi * np.linspace(_LOWEST, highest, count)

    def inverse(at: FloatArray) -> np.ndarray:
        """1 / a_p as the two eigenvalues give it, shape (m, 2)."""
        oriented = (receptance(at) @ directions)[:, :2, :]
        trace, det = np.trace(oriented, axis1=1, axis2=2), np.linalg.det(oriented)
        root = np.sqrt(0.25 * trace * trace - det + 0j)
        pair = np.stack([0.5 * trace + root, 0.5 * trace - root], axis=1)
        return np.asarray(pair * (1.0 - np.exp(-1j * at * tooth_period))[:, None])

    values = inverse(omega)
    straight, across = (np.abs(one[1:] - values[:-1]).sum(axis=1) for one in (values, values[:, ::-1]))
    crossed = np.cumsum(np.append(False, straight > across)) % 2 == 1
    values[crossed] = values[crossed, ::-1]  # each eigenvalue stays on its own branch
    best = DepthLimit(math.inf, math.nan)
    for branch in range(2):
        imaginary, real = values[:, branch].imag, values[:, branch].real
        high_end = np.maximum(real[1:], real[:-1])
        crossings = np.flatnonzero((np.sign(imaginary[1:]) != np.sign(imaginary[:-1])) & (high_end > 0))
        for k in crossings[np.argsort(-high_end[crossings], kind="stable")]:
            if _BETWEEN * high_end[k] * best.depth < 1.0:
                break  # nor does any later one come below the least depth so far
            near = values[k, branch]

            def part(w: float, near: complex = near) -> complex:
                pair = inverse(np.array([w]))[0]
                return complex(pair[int(np.argmin(np.abs(pair - near)))])

            low, high = part(omega[k]).imag, part(omega[k + 1]).imag
            if low * high > 0.0:
                continue
            w = optimize.brentq(lambda w: part(w).imag, omega[k], omega[k + 1], xtol=1e-12, rtol=1e-14)
            found = part(w).real
            if found > 0.0 and 1.0 / found < best.depth:
                best = DepthLimit(1.0 / found, w / (2.0 * math.pi))
    return best


def swinging_receptance(stiffness: FloatArray, damping: FloatArray, mass: float) -> Receptance:
    r"""Receptance of a mass on springs, :math:`(K + i\omega D - \omega^2 m)^{-1}`, from K and D of shape (3, 3).

    Valid for linear springs and dampers [N/m], [N s/m] and one mass [kg] in all directions.

    Examples
    --------
    At rest the compliance, at resonance that over :math:`2\zeta` (here a tenth):

    >>> g = swinging_receptance(1e6 * np.eye(3), 100.0 * np.eye(3), 1.0)(np.array([0.0, 1e3]))
    >>> (1e6 * abs(g[:, 0, 0])).round(9).tolist()
    [1.0, 10.0]

    References
    ----------
    Derived here.
    """

    def receptance(omega: FloatArray) -> np.ndarray:
        return np.linalg.inv(
            stiffness + 1j * omega[:, None, None] * damping - (omega * omega * mass)[:, None, None] * np.eye(3)
        )

    return receptance


def linked_receptance(
    spring: FloatArray, damper: FloatArray, gain: FloatArray, jacobian: FloatArray, height: float, behind: FloatArray
) -> Receptance:
    r"""Receptance of an arm of links at a height z over the tip, and of what it stands on.

    .. math:: G = T J\,(K + i\omega D - \omega^2 M)^{-1} J^T T^T + T C_b T^T, \qquad T = [I,\; -S(z e_z)]

    Parameters
    ----------
    spring, damper, gain, jacobian : array
        :math:`M^{-1} K` and :math:`M^{-1} D` (k, k), :math:`M^{-1} J^T` (k, 6), J (6, k): a station of
        :class:`~cutwise.physics.structure.swings.Linked`.
    height : float
        z [m].
    behind : array (6, 6)
        :math:`C_b`, compliance without mass of what the arm stands on, at the tip.
    """
    across = np.eye(3, 6)
    across[0, 4], across[1, 3] = height, -height
    still = across @ behind @ across.T

    def receptance(omega: FloatArray) -> np.ndarray:
        w = omega[:, None, None]
        inner = np.linalg.solve(spring + 1j * w * damper - w * w * np.eye(len(spring)), gain @ across.T)
        return np.asarray(across @ jacobian @ inner + still)

    return receptance
