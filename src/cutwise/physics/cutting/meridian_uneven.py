r"""Forces of edges along the meridian by Kienzle's law and under run-out: the chip of each tooth by itself, by quadrature.

The tool axis stands off the spindle axis by :math:`\rho`, so that a tooth at the angle a from that direction stands out by
:math:`\rho \sin\kappa \cos a` along the outward normal of its element. It removes what the teeth before it have left.
"""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, internal
from cutwise.maths.profiles import Meridian
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.meridian import CYLINDER, Chip, MeridianForce
from cutwise.physics.cutting.uneven import (
    GAUSS,
    LINEAR,
    PANEL,
    Edges,
    chip_thickness,
    force_per_length,
    uneven_tooth_force,
)

FloatArray = npt.NDArray[np.float64]

_TURN = 60  # rotations in the mean over a turn
_ANGLES = 60  # of the tool in a tooth period, at which the peak is looked for
_FINER = 16


@internal
def _part(
    psi: float, sine: float, cosine: float, chip: Chip, around: float, flutes: int, edges: Edges
) -> tuple[float, float, float, float]:
    """Force of one tooth a length of edge at an angle from the feed to the left [N/m]: x, y, up, and against the turning."""
    c, s = math.cos(psi), math.sin(psi)
    nominal = chip.across * sine * c - chip.along * cosine
    h = nominal
    if edges.runout != 0.0:
        h = chip_thickness(nominal, 1.0, around, edges.runout * sine, flutes)
    ft, fn, fa = force_per_length(edges, h)
    inward = fn * sine + fa * cosine
    return -ft * s - inward * c, ft * c - inward * s, fn * cosine - fa * sine, ft


@compiled
def uneven_meridian_force(
    rows: FloatArray, count: int, edge: Meridian, mill: Mill, chip: Chip, edges: Edges
) -> MeridianForce:
    r"""Force averaged over a revolution, from rows of contact, for any force law and run-out.

    .. math:: \bar F = \frac{1}{2\pi} \sum \int \sum_\text{teeth} f(h)\,ds\,d\psi

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, as for :func:`cutwise.physics.cutting.meridian.meridian_force`.
    edge : Meridian
        Elements below the cylinder.
    mill : Mill
        Radius of the cylinder, teeth and helix.
    chip : Chip
        Feed of a tooth.
    edges : Edges
        Force law, and run-out.

    Returns
    -------
    MeridianForce
        On the tool [N], and torque [N m].

    Notes
    -----
    Valid for evenly spaced teeth and feeds per tooth small against the radius; a tooth that finds nothing left has no force.
    Three-point Gauss rule; the kinks that run-out puts into the chip leave about 1e-3 of the force.

    Examples
    --------
    The slot of :func:`cutwise.physics.cutting.meridian.meridian_force` by the linear law, and by Kienzle's with an exponent of 0,
    which is the same without edge forces.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> from cutwise.physics.cutting.uneven import Kienzle, even_edges, kienzle_edges
    >>> slot = np.array([[CYLINDER, -0.5 * math.pi, 0.5 * math.pi, 0.0, 1e-3]])
    >>> laws = even_edges(EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0)), kienzle_edges(Kienzle(1e9, 0.0, 5e8, 0.0, 2e8, 0.0))
    >>> mill, steps = Mill(5e-3, 2, 0.5), meridian(flat(5e-3), 5e-3, 1)
    >>> [[round(f, 4) for f in uneven_meridian_force(slot, 1, steps, mill, Chip(1e-4, 0.0), law)] for law in laws]
    [[-25.0, 50.0, -12.7324, 0.3183, 0.0], [-25.0, 50.0, -12.7324, 0.3183, 0.0]]

    References
    ----------
    Kienzle 1952; run-out as in :mod:`cutwise.physics.cutting.uneven`.
    """
    x = y = z = torque = end = 0.0
    turns = _TURN if edges.runout != 0.0 else 1
    for n in range(count):
        element, low, high = int(rows[n, 0]), rows[n, 1], rows[n, 2]
        sine, cosine, ds, radius = 1.0, 0.0, rows[n, 4] - rows[n, 3], mill.radius
        if element != CYLINDER:
            sine, cosine = edge.sine[element], edge.cosine[element]
            ds, radius = edge.length[element], edge.radius[element]
        panels = max(1, math.ceil((high - low) / PANEL))
        width = (high - low) / panels
        for panel in range(panels):
            for i in range(3):
                psi = low + (panel + 0.5 * (1.0 + GAUSS[i][0])) * width
                weight = width * GAUSS[i][1] * ds * mill.flutes / (2.0 * math.pi * turns)
                for k in range(turns):
                    fx, fy, fz, ft = _part(
                        psi, sine, cosine, chip, 2.0 * math.pi * (k + 0.5) / turns, mill.flutes, edges
                    )
                    x, y, z = x + weight * fx, y + weight * fy, z + weight * fz
                    torque += weight * ft * radius
                    if sine == 0.0:
                        end += weight * fz
    return MeridianForce(x, y, z, torque, end)


@internal
def _force_at(
    rotation: float, rows: FloatArray, count: int, edge: Meridian, mill: Mill, chip: Chip, edges: Edges
) -> float:
    """Force in the plane with the teeth at an angle [N]."""
    x = y = 0.0
    pitch = 2.0 * math.pi / mill.flutes
    pulling = edges
    if edges.law == LINEAR:  # the flute kernel counts axial coefficients upward
        k = edges.linear
        linear = EdgeCoefficients(k.K_tc, k.K_rc, -k.K_ac, k.K_te, k.K_re, -k.K_ae)
        pulling = Edges(edges.law, linear, edges.kienzle, edges.runout, edges.runout_angle)
    for n in range(count):
        element = int(rows[n, 0])
        low, high = 0.5 * math.pi - rows[n, 2], 0.5 * math.pi - rows[n, 1]
        if element == CYLINDER:
            f = uneven_tooth_force(rotation, low, high, chip.across, 0.0, rows[n, 3], rows[n, 4], mill, pulling)
            x, y = x + f.x, y + f.y
            continue
        start = rotation - math.tan(mill.helix) * edge.height[element] / mill.radius
        for tooth in range(math.floor((low - start) / pitch) + 1, math.floor((high - start) / pitch) + 1):
            phi = start + tooth * pitch
            around = phi - rotation - edges.runout_angle
            fx, fy, _, _ = _part(
                0.5 * math.pi - phi, edge.sine[element], edge.cosine[element], chip, around, mill.flutes, edges
            )
            x, y = x + edge.length[element] * fx, y + edge.length[element] * fy
    return math.hypot(x, y)


@compiled
def uneven_peak_force(rows: FloatArray, count: int, edge: Meridian, mill: Mill, chip: Chip, edges: Edges) -> float:
    r"""Largest force in the plane over a tooth period, under run-out over a turn [N].

    .. math:: \max_\phi \sqrt{F_x^2 + F_y^2}

    Parameters
    ----------
    rows, count, edge, mill, chip, edges
        As for :func:`uneven_meridian_force`.

    Returns
    -------
    float
        Force across the axis [N]; 0 without contact.

    Notes
    -----
    Valid as :func:`cutwise.physics.cutting.meridian.peak_force`.

    Examples
    --------
    A straight tooth in a slot under 20 um of run-out takes 0.14 mm instead of 0.1 mm.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> from cutwise.physics.cutting.uneven import even_edges
    >>> slot = np.array([[CYLINDER, -0.5 * math.pi, 0.5 * math.pi, 0.0, 1e-3]])
    >>> edges = even_edges(EdgeCoefficients(4e9, 3e9, 0.0, 0.0, 0.0, 0.0))._replace(runout=2e-5)
    >>> round(uneven_peak_force(slot, 1, meridian(flat(5e-3), 5e-3, 1), Mill(5e-3, 2, 0.0), Chip(1e-4, 0.0), edges), 3)
    700.0

    References
    ----------
    As :func:`uneven_meridian_force`.
    """
    if count == 0:
        return 0.0
    teeth = mill.flutes if edges.runout != 0.0 else 1
    step = 2.0 * math.pi / (mill.flutes * _ANGLES)
    best, at = 0.0, 0
    for i in range(_ANGLES * teeth):
        force = _force_at(step * i, rows, count, edge, mill, chip, edges)
        if force > best:
            best, at = force, i
    for i in range(-_FINER + 1, _FINER):
        best = max(best, _force_at(step * (at + i / _FINER), rows, count, edge, mill, chip, edges))
    return best


@compiled
def thickest_uneven_chip(thickest: float, runout: float, flutes: int) -> float:
    r"""Thickest chip of the tooth that run-out carries out most, where even teeth take a thickness [m].

    .. math:: \max_a \min_m [\, m h + \rho (\cos a - \cos(a + 2\pi m / N)) ]

    Parameters
    ----------
    thickest : float
        Thickest chip of even teeth [m].
    runout : float
        Run-out :math:`\rho` [m].
    flutes : int
        Teeth N.

    Returns
    -------
    float
        Thickness [m]; 0 without a chip.

    Notes
    -----
    Valid on the cylinder; on a corner or a cone run-out counts less.

    Examples
    --------
    >>> round(1e6 * thickest_uneven_chip(1e-4, 2e-5, 2), 3)
    140.0

    References
    ----------
    Kline and DeVor 1983.
    """
    if runout == 0.0:
        return thickest
    largest = 0.0
    for k in range(_TURN):
        largest = max(largest, chip_thickness(thickest, 1.0, 2.0 * math.pi * k / _TURN, runout, flutes))
    return largest
