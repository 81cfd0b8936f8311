"""Helical-flute forces as a sum over axial discs, all discs of a flute at once.

The discs of one flute lie at equal angular steps, so that the sums of sines and cosines over the discs in cut are
differences of tabulated partial sums turned by the angle of the flute: the cost of a flute does not grow with the
number of discs. The closed form over continuous flutes (``physics/cutting/flute.py``) is the limit of many discs.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.flute import EdgeCoefficients

FloatArray = npt.NDArray[np.float64]


class Discs(NamedTuple):
    """A mill cut into axial discs, with partial sums over the first d discs of cos, sin, cos 2, sin 2 of their lag."""

    teeth: int
    count: int  # type: ignore[assignment] # discs
    thickness: float  # of a disc [m]
    step: float  # lag between neighbouring discs [rad]
    sums: FloatArray  # partial sums, shape (count + 1, 4)


def discs(mill_radius: float, helix: float, axial_depth: float, teeth: int, count: int) -> Discs:
    r"""Discs of a mill: radius [m], helix angle [rad], axial depth [m]; the lag of disc d is (d + 1/2) steps.

    .. math:: \Delta = \frac{a_p}{n} \frac{\tan\beta}{R}

    ``teeth``: number of flutes N, evenly spaced; ``count``: n. Valid for a cylinder with one helix angle.

    Examples
    --------
    45 degrees, four discs over 10 mm, R = 5 mm:

    >>> mill = discs(5e-3, 0.25 * math.pi, 1e-2, 2, 4)
    >>> round(mill.step, 9), round(mill.thickness, 9)
    (0.5, 0.0025)

    References
    ----------
    Berselli et al. 2016, Eq. (2), by discs.
    """
    thickness = axial_depth / count
    step = thickness * math.tan(helix) / mill_radius
    lag = (np.arange(count) + 0.5) * step
    terms = np.column_stack((np.cos(lag), np.sin(lag), np.cos(2.0 * lag), np.sin(2.0 * lag)))
    return Discs(teeth, count, thickness, step, np.vstack((np.zeros((1, 4)), np.cumsum(terms, axis=0))))


@compiled
def first_disc(angle: float, step: float, lowest: int, highest: int) -> int:
    r"""First disc of ``lowest`` to ``highest`` whose lag, (d + 1/2) steps, is not below the angle.

    .. math:: d = \lceil a / \Delta - 1/2 \rceil

    Parameters
    ----------
    angle : float
        Angle a [rad].
    step : float
        Lag :math:`\Delta` between neighbouring discs [rad]; not positive: all discs stand at the angle zero.
    lowest, highest : int
        Range of the answer; ``highest`` says that there is none.

    Returns
    -------
    int
        Number of the disc.

    Notes
    -----
    Valid for any angle; one within rounding of a disc may fall to either side of it.

    Examples
    --------
    Discs lag by 0.1, 0.3, 0.5 ...

    >>> first_disc(0.35, 0.2, 0, 10)
    2

    References
    ----------
    Derived here.
    """
    if step <= 0.0:
        return lowest if angle <= 0.0 else highest
    return min(max(math.ceil(angle / step - 0.5), lowest), highest)


@compiled
def disc_forces(
    angle: float, wall: float, arc: float, feed_x: float, feed_y: float, lowest: int, highest: int, mill: Discs,
    k: EdgeCoefficients,
) -> tuple[float, float, float]:  # fmt: skip
    r"""Force on a climb-milling tool that turns clockwise, seen against the spindle axis.

    .. math::
        dF_t = (K_{tc} h + K_{te})\,dz, \qquad h = f \cdot n(\vartheta), \qquad
        F_{xy} = -F_t(\sin\vartheta, -\cos\vartheta) - F_r(\cos\vartheta, \sin\vartheta), \qquad F_z = -\sum F_a

    summed over the discs with :math:`(\vartheta - \vartheta_w) \bmod 2\pi < \alpha` and :math:`h > 0`.

    Parameters
    ----------
    angle : float
        Angle of flute 0 at the tip [rad]; flute i is :math:`2\pi i/N` behind in the sense of rotation (greater
        :math:`\vartheta` cuts later, a helix lags likewise).
    wall, arc : float
        Angle :math:`\vartheta_w` at which the cut leaves the wall side [rad], and the immersion angle :math:`\alpha`.
    feed_x, feed_y : float
        Displacement of the tool centre per tooth :math:`f` [m].
    lowest, highest : int
        Discs that take part, from ``lowest`` to below ``highest``.
    mill : Discs
        The mill.
    k : EdgeCoefficients
        Force coefficients.

    Returns
    -------
    tuple
        Force on the tool x, y, z [N].

    Notes
    -----
    Valid for :math:`0 \le \alpha \le 2\pi`, feeds small against the mill radius and flutes that cut alike. Nothing cuts
    without a feed.

    Examples
    --------
    A straight tooth across the feed, 1 mm deep, chip 0.1 mm:

    >>> k = EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0)
    >>> mill = discs(5e-3, 0.0, 1e-3, 1, 1)
    >>> [round(f, 6) for f in disc_forces(0.0, -0.5 * math.pi, math.pi, 1e-4, 0.0, 0, 1, mill, k)]
    [-50.0, 100.0, -20.0]

    References
    ----------
    Berselli et al. 2016, Eqs. (3) and (4), in machine axes; the sums by partial sums are derived here.
    """
    feed = math.hypot(feed_x, feed_y)
    if feed <= 0.0 or arc <= 0.0:
        return 0.0, 0.0, 0.0
    turn = 2.0 * math.pi
    heading = math.atan2(feed_y, feed_x)
    fx, fy, fz = 0.0, 0.0, 0.0
    # the chip is positive within 90 degrees of the feed: cut the immersion arc there; wall + [low, high]
    behind = (heading - 0.5 * math.pi - wall) % turn
    low, high = 0.0, arc
    if behind < math.pi:
        low, high = min(behind, arc), min(arc, behind + math.pi)
    else:
        high = min(arc, behind - math.pi)
    second_low = behind if behind >= math.pi and behind < arc else arc
    for tooth in range(mill.teeth):
        base = angle - turn * tooth / mill.teeth
        for low_, high_ in ((low, high), (second_low, arc)):
            if high_ <= low_:
                continue
            first = (base - wall - low_) % turn  # angle of the tip past the low end
            span = high_ - low_
            x, y, z = _flute(base, -first, span, feed_x, feed_y, lowest, highest, mill, k)
            fx, fy, fz = fx + x, fy + y, fz + z
            x, y, z = _flute(base, turn - first, span, feed_x, feed_y, lowest, highest, mill, k)
            fx, fy, fz = fx + x, fy + y, fz + z
    return fx, fy, fz


@compiled
def _flute(
    base: float, start: float, span: float, feed_x: float, feed_y: float, lowest: int, highest: int, mill: Discs,
    k: EdgeCoefficients,
) -> tuple[float, float, float]:  # fmt: skip
    """Force of the discs of one flute whose lag is in [start, start + span) [rad]."""
    if start + span <= 0.0:
        return 0.0, 0.0, 0.0
    first = first_disc(start, mill.step, lowest, highest)
    last = first_disc(start + span, mill.step, lowest, highest)
    if last <= first:
        return 0.0, 0.0, 0.0
    c0, s0 = math.cos(base), math.sin(base)
    c20, s20 = c0 * c0 - s0 * s0, 2.0 * s0 * c0
    c = mill.sums[last, 0] - mill.sums[first, 0]
    s = mill.sums[last, 1] - mill.sums[first, 1]
    c2 = mill.sums[last, 2] - mill.sums[first, 2]
    s2 = mill.sums[last, 3] - mill.sums[first, 3]
    c, s = c * c0 - s * s0, c * s0 + s * c0  # sums of cos and sin of the disc angles
    c2, s2 = c2 * c20 - s2 * s20, c2 * s20 + s2 * c20
    n = float(last - first)
    cc, ss, cs = 0.5 * (n + c2), 0.5 * (n - c2), 0.5 * s2
    # sums of h cos, h sin, h
    hc, hs, h = feed_x * cc + feed_y * cs, feed_x * cs + feed_y * ss, feed_x * c + feed_y * s
    fx = -(k.K_tc * hs + k.K_te * s) - (k.K_rc * hc + k.K_re * c)
    fy = (k.K_tc * hc + k.K_te * c) - (k.K_rc * hs + k.K_re * s)
    fz = -(k.K_ac * h + k.K_ae * n)
    return fx * mill.thickness, fy * mill.thickness, fz * mill.thickness
