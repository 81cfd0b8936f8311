r"""What a contact of any tool of revolution comes to at any feed: :math:`F(\theta) = A(\theta) + f B(\theta)` from its rows.

Of the positions of a tooth period only those are kept in which the force can be the largest, so that limits and values at all
feeds follow from a handful of rows (:mod:`cutwise.physics.cutting.affine_limits`), whatever is asked later.
"""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined, internal
from cutwise.maths.profiles import Meridian
from cutwise.physics.cutting.affine_limits import Sums, flutes_of
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.helix import helix_lag
from cutwise.physics.cutting.meridian import CYLINDER, Chip, disc_loads, meridian_force, thickest_chip

FloatArray = npt.NDArray[np.float64]

KEPT = 7
"""Most rows that are kept of a contact."""
ANGLES = 60
"""Positions of a tooth period that are looked at first, as the peak of a run has them."""
_FINER, _TWICE = 4, 2  # parts of a step round the largest, and how often it is parted
_FEEDS = (0.0, 0.5, 1.0, 2.0, 4.0)  # of the feed: where the force is largest moves with it, slowly
_CLOSER = (1.0, 4.0)  # of the feed, at which it is looked closer
_NOTHING = Chip(0.0, 0.0)


@internal
def _loads_at(
    rotation: float, rows: FloatArray, count: int, edge: Meridian, turning: tuple[int, float], way: Chip,
    k: EdgeCoefficients,
) -> tuple[float, float, float, float]:  # fmt: skip
    """A [N] and B [N/m] with the teeth at an angle; ``turning``: flutes, and their lag [rad/m]."""
    ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0
    own = EdgeCoefficients(0.0, 0.0, 0.0, k.K_te, k.K_re, 0.0)
    grows = EdgeCoefficients(k.K_tc, k.K_rc, 0.0, 0.0, 0.0, 0.0)
    for n in range(count):
        element = int(rows[n, 0])
        low, high = 0.5 * math.pi - rows[n, 2], 0.5 * math.pi - rows[n, 1]
        if element == CYLINDER:
            a, b, c, d = flutes_of(rotation, low, high, rows[n, 3], rows[n, 4], turning[0], turning[1], own, grows)
            c, d = way.across * c, way.across * d
        else:
            a, b, c, d = disc_loads(rotation, low, high, element, edge, turning, way, k)
        ax, ay, bx, by = ax + a, ay + b, bx + c, by + d
    return ax, ay, bx, by


@inlined
def _size(load: FloatArray, feed: float) -> float:
    """Square of a force at a feed [N^2]."""
    x, y = load[0] + feed * load[2], load[1] + feed * load[3]
    return x * x + y * y


@internal
def _largest(loads: FloatArray, rows: int, feed: float) -> int:
    """Which row is the largest force at a feed."""
    most, at = -1.0, 0
    for i in range(rows):
        size = _size(loads[i], feed)
        if size > most:
            most, at = size, i
    return at


@compiled
def meridian_loads(
    rows: FloatArray, count: int, edge: Meridian, mill: Mill, way: Chip, feed: float, k: EdgeCoefficients, work: FloatArray,
    out: FloatArray,
) -> int:  # fmt: skip
    r"""Forces in the plane as A + f B, in those positions of the teeth in which they are largest at some feed.

    .. math:: \max_\theta |A(\theta) + f B(\theta)|

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, as for :func:`cutwise.physics.cutting.meridian.meridian_force`.
    edge : Meridian
        Elements below the cylinder.
    mill : Mill
        Radius of the cylinder, teeth and helix.
    way : Chip
        Direction of the feed: what of it is horizontal, and what goes up [-].
    feed : float
        Feed per tooth round which it is looked closely [m].
    k : EdgeCoefficients
        Of material and tool.
    work : array (61, 4)
        Room.
    out : array (7, 4)
        Filled: A [N] and B [N/m].

    Returns
    -------
    int
        How many rows were filled; 0 without contact.

    Notes
    -----
    Valid as :func:`cutwise.physics.cutting.meridian.peak_force`, which the largest is at the feed that is given, to the distance
    of the positions that both look at. At others the largest of the kept positions is no more than that of all: below it by a few
    thousandths where the feed is far from the one that is given and from four times it.

    Examples
    --------
    The straight tooth of :func:`cutwise.physics.cutting.meridian.peak_force`: 500 N at 0.1 mm, and 5 MN per metre of feed.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> slot = np.array([[CYLINDER, -0.5 * math.pi, 0.5 * math.pi, 0.0, 1e-3]])
    >>> mill, k = Mill(5e-3, 2, 0.0), EdgeCoefficients(4e9, 3e9, 0.0, 0.0, 0.0, 0.0)
    >>> work, out = np.zeros((ANGLES + 1, 4)), np.zeros((KEPT, 4))
    >>> count = meridian_loads(slot, 1, meridian(flat(5e-3), 5e-3, 1), mill, Chip(1.0, 0.0), 1e-4, k, work, out)
    >>> round(1e-4 * float(np.hypot(out[:count, 2], out[:count, 3]).max()), 6)
    500.0

    References
    ----------
    Derived here.
    """
    if count == 0:
        return 0
    period, here = 2.0 * math.pi / (mill.flutes * ANGLES), work[ANGLES]
    turning = (mill.flutes, helix_lag(mill.helix, mill.radius))
    for i in range(ANGLES):
        work[i, 0], work[i, 1], work[i, 2], work[i, 3] = _loads_at(period * i, rows, count, edge, turning, way, k)
    kept, before = 0, -1
    for share in _FEEDS:
        at = _largest(work, ANGLES, share * feed)
        if at != before:
            out[kept] = work[at]
            kept, before = kept + 1, at
    before = -1
    for share in _CLOSER:
        at = _largest(work, ANGLES, share * feed)
        if at == before:
            continue
        before = at
        out[kept] = work[at]
        angle, step = float(at), 1.0
        for _ in range(_TWICE):
            step /= _FINER
            middle = angle
            for i in range(1 - _FINER, _FINER):
                if i != 0:
                    turned = period * (middle + i * step)
                    here[0], here[1], here[2], here[3] = _loads_at(turned, rows, count, edge, turning, way, k)
                    if _size(here, share * feed) > _size(out[kept], share * feed):
                        out[kept], angle = here, middle + i * step
        kept += 1
    return kept


@compiled
def meridian_sums(
    rows: FloatArray, count: int, edge: Meridian, mill: Mill, way: Chip, k: EdgeCoefficients, area: float
) -> Sums:
    """Means over a revolution, taken apart into what the edges do and what grows with the feed.

    Parameters
    ----------
    rows, count, edge, mill, way, k
        As for :func:`meridian_loads`.
    area : float
        Volume taken per length of feed [m^2].

    Returns
    -------
    Sums
        Of one tooth after another.

    Notes
    -----
    Valid as :func:`cutwise.physics.cutting.meridian.meridian_force`, which is affine in the feed.

    Examples
    --------
    The plunge of that function: 50 N at 0.01 mm a tooth.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> bottom, k = np.array([[0, -math.pi, math.pi, 0.0, 0.0]]), EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0)
    >>> sums = meridian_sums(bottom, 1, meridian(flat(5e-3), 0.0, 1), Mill(5e-3, 2, 0.5), Chip(0.0, -1.0), k, 0.0)
    >>> round(1e-5 * sums.shear_z, 6), round(1e-5 * sums.shear_torque, 6), round(sums.chip, 6)
    (50.0, 0.25, 1.0)

    References
    ----------
    As :func:`cutwise.physics.cutting.meridian.meridian_force`.
    """
    own = EdgeCoefficients(0.0, 0.0, 0.0, k.K_te, k.K_re, k.K_ae)
    grows = EdgeCoefficients(k.K_tc, k.K_rc, k.K_ac, 0.0, 0.0, 0.0)
    a = meridian_force(rows, count, edge, mill.radius, mill.flutes, _NOTHING, own)
    b = meridian_force(rows, count, edge, mill.radius, mill.flutes, way, grows)
    return Sums(a.x, a.y, b.x, b.y, a.torque, b.torque, thickest_chip(rows, count, edge, way), area, a.z, b.z)
