r"""Forces of edges along the meridian of a tool: bottom, corner, ball, cone and cylinder through the one flute kernel.

An element whose outward normal stands at kappa from down is a disc with turned coefficients, as on a ball; at 90 degrees it is
the helical flute, at 0 the bottom edge. Forces are on the tool, in the frame (feed, left, up). In the angle psi from the feed to
the left a flute's own angle is :math:`\phi = \pi/2 - \psi`.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined, internal
from cutwise.maths.profiles import Meridian
from cutwise.physics.cutting.ball import disc_coefficients
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, lagging_force, mean_force
from cutwise.physics.cutting.helix import helix_lag

FloatArray = npt.NDArray[np.float64]

CYLINDER = -1  # element of a row on the cylinder
_ANGLES = 60  # of the tool in a tooth period, at which the peak is looked for
_FINER = 16


class Chip(NamedTuple):
    """Feed of one tooth."""

    across: float  # horizontal [m]
    along: float  # up, negative where the tool goes down [m]


class MeridianForce(NamedTuple):
    """Mean force of all teeth on the tool."""

    x: float  # along the feed [N]
    y: float  # to its left [N]
    z: float  # up [N]
    torque: float  # about the axis, against the turning [N m]
    end: float  # up, of the bottom edges alone [N]


@inlined
def _pulling(k: EdgeCoefficients, thick: float) -> EdgeCoefficients:
    """Coefficients of an element with a chip that is the same all round added to its edge force; the axial ones turned.

    The flute kernel counts axial coefficients upward; a right-hand helix pulls the tool down.
    """
    return EdgeCoefficients(
        k.K_tc, k.K_rc, -k.K_ac, k.K_te + k.K_tc * thick, k.K_re + k.K_rc * thick, -(k.K_ae + k.K_ac * thick)
    )


@compiled
def meridian_force(
    rows: FloatArray, count: int, edge: Meridian, radius: float, flutes: int, chip: Chip, k: EdgeCoefficients
) -> MeridianForce:
    r"""Force averaged over a revolution, from rows of contact.

    .. math:: dF_t = (K_{tc} h + K_{te})\,ds,\quad dF_n = (K_{rc} h + K_{re})\,ds,\quad dF_a = (K_{ac} h + K_{ae})\,ds

    against the motion of the tooth, along -n and along -e, with :math:`h = c \cdot n`,
    :math:`n = (\sin\kappa\cos\psi, \sin\kappa\sin\psi, -\cos\kappa)` and
    :math:`e = (\cos\kappa\cos\psi, \cos\kappa\sin\psi, \sin\kappa)`.

    Parameters
    ----------
    rows, count : array (m, 5), int
        Element (-1: the cylinder), arc from, to [rad], heights from, to [m].
    edge : Meridian
        Elements below the cylinder.
    radius : float
        Of the cylinder [m].
    flutes : int
        Teeth N.
    chip : Chip
        Feed of a tooth.
    k : EdgeCoefficients
        Of material and tool; for bottom edges the same, the radial ones along the axis.

    Returns
    -------
    MeridianForce
        On the tool [N], and torque [N m].

    Notes
    -----
    Valid for evenly spaced teeth without run-out, feeds per tooth small against the radius, and rows in which h is not negative,
    as those of contact are. Bottom edges with the coefficients of the flutes are an assumption.

    Examples
    --------
    A slot 1 mm deep with two teeth and 0.1 mm a tooth: :math:`N b c / 4` of :math:`-K_{rc}` and :math:`K_{tc}`,
    :math:`N b c / \pi` of :math:`-K_{ac}` and, on 5 mm, of :math:`K_{tc}`.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> k = EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0)
    >>> slot = np.array([[CYLINDER, -0.5 * math.pi, 0.5 * math.pi, 0.0, 1e-3]])
    >>> force = meridian_force(slot, 1, meridian(flat(5e-3), 5e-3, 1), 5e-3, 2, Chip(1e-4, 0.0), k)
    >>> [round(f, 4) for f in force]
    [-25.0, 50.0, -12.7324, 0.3183, 0.0]

    A plunge of 0.01 mm a tooth, edges to the middle: :math:`N K_{rc} f R` up, and :math:`N K_{tc} f R^2 / 2` about the axis.

    >>> bottom = np.array([[0, -math.pi, math.pi, 0.0, 0.0]])
    >>> force = meridian_force(bottom, 1, meridian(flat(5e-3), 0.0, 1), 5e-3, 2, Chip(0.0, -1e-5), k)
    >>> round(force.z, 6), round(force.end, 6), round(force.torque, 6)
    (50.0, 50.0, 0.25)

    References
    ----------
    Engin and Altintas 2001; Gradisek, Kalveram and Weinert 2004 (the general end mill).
    """
    x = y = z = torque = end = 0.0
    for n in range(count):
        element = int(rows[n, 0])
        low, high = 0.5 * math.pi - rows[n, 2], 0.5 * math.pi - rows[n, 1]
        if element == CYLINDER:
            f = mean_force(low, high, chip.across, 0.0, rows[n, 4] - rows[n, 3], flutes, _pulling(k, 0.0))
            torque += radius * f.tangential
        else:
            sine, cosine = edge.sine[element], edge.cosine[element]
            turned = disc_coefficients(math.atan2(sine, -cosine), _pulling(k, -chip.along * cosine))
            f = mean_force(low, high, chip.across * sine, 0.0, edge.length[element], flutes, turned)
            torque += edge.radius[element] * f.tangential
            if sine == 0.0:
                end += f.z
        x, y, z = x + f.x, y + f.y, z + f.z
    return MeridianForce(x, y, z, torque, end)


@inlined
def disc_loads(
    rotation: float, low: float, high: float, element: int, edge: Meridian, turning: tuple[int, float], chip: Chip,
    k: EdgeCoefficients,
) -> tuple[float, float, float, float]:  # fmt: skip
    r"""Forces in the plane of the teeth of an element below the cylinder, taken apart into edges and shearing [N].

    Parameters
    ----------
    rotation : float
        Angle of tooth 0 at the tip [rad].
    low, high : float
        Arc of contact, :math:`\phi = \pi/2 - \psi` [rad].
    element, edge : int, Meridian
        Which element.
    turning : tuple
        Flutes, and their lag [rad/m].
    chip, k
        As for :func:`peak_force`.

    Returns
    -------
    tuple
        Of the edges along the feed and to its left, of the shearing along the feed and to its left.

    Notes
    -----
    Valid as :func:`meridian_force`; a tooth counts from behind ``low`` up to ``high``.

    Examples
    --------
    A tooth straight ahead on the equator of a ball, 1 mm of edge with 100 N/mm and 50 N/mm back: along the feed the latter.

    >>> from cutwise.maths.profiles import Meridian
    >>> one = np.ones(1)
    >>> ball = Meridian(0.0 * one, 5e-3 * one, one, 0.0 * one, 1e-3 * one)
    >>> k = EdgeCoefficients(0.0, 0.0, 0.0, 1e5, 5e4, 0.0)
    >>> found = disc_loads(0.5 * math.pi, 0.0, math.pi, 0, ball, (1, 0.0), Chip(0.0, 0.0), k)
    >>> [round(f, 9) + 0.0 for f in found]
    [-50.0, 100.0, 0.0, 0.0]

    References
    ----------
    As :func:`meridian_force`.
    """
    ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0
    sine, cosine, ds = edge.sine[element], edge.cosine[element], edge.length[element]
    start, pitch = rotation - turning[1] * edge.height[element], 2.0 * math.pi / turning[0]
    for tooth in range(math.floor((low - start) / pitch) + 1, math.floor((high - start) / pitch) + 1):
        phi = start + tooth * pitch
        s, c = math.sin(phi), math.cos(phi)
        h = chip.across * sine * s - chip.along * cosine
        own, grows = k.K_re * sine + k.K_ae * cosine, h * (k.K_rc * sine + k.K_ac * cosine)
        ax, ay = ax + ds * (-k.K_te * c - own * s), ay + ds * (k.K_te * s - own * c)
        bx, by = bx + ds * (-k.K_tc * h * c - grows * s), by + ds * (k.K_tc * h * s - grows * c)
    return ax, ay, bx, by


@internal
def _force_at(
    rotation: float, rows: FloatArray, count: int, edge: Meridian, turning: tuple[int, float], chip: Chip,
    k: EdgeCoefficients,
) -> float:  # fmt: skip
    """Force in the plane with the teeth at an angle [N]; ``turning``: flutes, and their lag [rad/m]."""
    x = y = 0.0
    flutes, lag = turning
    side = _pulling(k, 0.0)
    for n in range(count):
        element = int(rows[n, 0])
        low, high = 0.5 * math.pi - rows[n, 2], 0.5 * math.pi - rows[n, 1]
        if element == CYLINDER:
            f = lagging_force(rotation, low, high, chip.across, 0.0, rows[n, 3], rows[n, 4], flutes, lag, side)
            x, y = x + f.x, y + f.y
            continue
        ax, ay, bx, by = disc_loads(rotation, low, high, element, edge, turning, chip, k)
        x, y = x + ax + bx, y + ay + by
    return math.hypot(x, y)


@compiled
def peak_force(rows: FloatArray, count: int, edge: Meridian, mill: Mill, chip: Chip, k: EdgeCoefficients) -> float:
    r"""Largest force in the plane over a tooth period [N]; teeth are looked at in 60 places and closer round the largest.

    .. math:: \max_\phi \sqrt{F_x^2 + F_y^2}

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, as for :func:`meridian_force`.
    edge : Meridian
        Elements below the cylinder.
    mill : Mill
        Radius of the cylinder, teeth and helix.
    chip, k
        As there.

    Returns
    -------
    float
        Force across the axis [N]; 0 without contact.

    Notes
    -----
    Valid as :func:`meridian_force`. The lag of the helix is that of the cylinder, :math:`z \tan\beta / R`, on all elements. The
    places are a 960th of a tooth period apart round the largest of 60, so a second peak as high as that may be missed.

    Examples
    --------
    A straight tooth in the slot of :func:`meridian_force` has its whole chip ahead: :math:`b c \sqrt{K_{tc}^2 + K_{rc}^2}`.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> slot = np.array([[CYLINDER, -0.5 * math.pi, 0.5 * math.pi, 0.0, 1e-3]])
    >>> mill, k = Mill(5e-3, 2, 0.0), EdgeCoefficients(4e9, 3e9, 0.0, 0.0, 0.0, 0.0)
    >>> round(peak_force(slot, 1, meridian(flat(5e-3), 5e-3, 1), mill, Chip(1e-4, 0.0), k), 6)
    500.0

    References
    ----------
    As :func:`meridian_force`.
    """
    if count == 0:
        return 0.0
    step = 2.0 * math.pi / (mill.flutes * _ANGLES)
    best, at, turning = 0.0, 0, (mill.flutes, helix_lag(mill.helix, mill.radius))
    for i in range(_ANGLES):
        force = _force_at(step * i, rows, count, edge, turning, chip, k)
        if force > best:
            best, at = force, i
    for i in range(-_FINER + 1, _FINER):
        best = max(best, _force_at(step * (at + i / _FINER), rows, count, edge, turning, chip, k))
    return best


@compiled
def thickest_chip(rows: FloatArray, count: int, edge: Meridian, chip: Chip) -> float:
    r"""Largest chip thickness :math:`h = c \cdot n` in contact [m].

    .. math:: h = c_x \sin\kappa \max_\psi \cos\psi - c_z \cos\kappa

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, as for :func:`meridian_force`.
    edge : Meridian
        Elements below the cylinder.
    chip : Chip
        Feed of a tooth.

    Returns
    -------
    float
        Thickness [m]; 0 without contact.

    Notes
    -----
    Valid for evenly spaced teeth without run-out, and feeds per tooth small against the radius.

    Examples
    --------
    0.1 mm a tooth, from the right side to :math:`\cos\psi = 0.8` short of ahead; and a plunge of 0.01 mm on the bottom.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> rows = np.array([[CYLINDER, -0.5 * math.pi, -math.acos(0.8), 0.0, 1e-3], [0, -math.pi, math.pi, 0.0, 0.0]])
    >>> edge = meridian(flat(5e-3), 0.0, 1)
    >>> [round(1e3 * thickest_chip(r, 1, edge, c), 9) for r, c in ((rows, Chip(1e-4, 0.0)), (rows[1:], Chip(0.0, -1e-5)))]
    [0.08, 0.01]

    References
    ----------
    As :func:`meridian_force`.
    """
    thickest = 0.0
    for n in range(count):
        element, low, high = int(rows[n, 0]), rows[n, 1], rows[n, 2]
        ahead = 1.0 if low <= 0.0 <= high else max(math.cos(low), math.cos(high))
        if element == CYLINDER:
            thickest = max(thickest, chip.across * ahead)
        else:
            thickest = max(thickest, chip.across * edge.sine[element] * ahead - chip.along * edge.cosine[element])
    return thickest
