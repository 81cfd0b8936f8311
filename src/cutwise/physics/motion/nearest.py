"""Where along one path a tool is that is told another, which differs from it by little."""

import math

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import LineArc, block_bend, block_point, block_tangent

_LOOKS = 4  # Newton steps at each instant; they start where the last instant ended
_STRIDE = 2e-3  # [m] the farthest that one of them goes


@compiled
def nearest_along(curve: LineArc, points: FloatArray, travelled: FloatArray) -> tuple[FloatArray, FloatArray]:
    r"""Arc length of the nearest place on a path at each of a row of points that follow it, and how far away it is.

    The place goes on from the last one, by as much as the way along the other path, and from there to where the way to
    the point is normal to the path; so a later pass beside this one is not mistaken for it.

    .. math:: s \leftarrow s + \frac{(p - c(s)) \cdot c'(s)}{1 - (p - c(s)) \cdot c''(s)}

    Parameters
    ----------
    curve : LineArc
        The path c(s) [m].
    points : ndarray
        Points p [m], shape (n, 3).
    travelled : ndarray
        Way along the other path at each of them [m], rising, shape (n,).

    Returns
    -------
    tuple
        Arc lengths [m], never falling, and distances [m], shape (n,).

    Notes
    -----
    Valid for points that are nearer to the path than its radii of curvature. A place stays at a corner as long as the
    points pass round it.

    Examples
    --------
    3 mm beside a line at 50 mm:

    >>> from cutwise.maths.linearc import lines
    >>> way = lines(np.zeros((1, 3)), np.array([[0.1, 0.0, 0.0]]))
    >>> s, off = nearest_along(way, np.array([[0.05, 0.003, 0.0]]), np.array([0.05]))
    >>> round(1e3 * float(s[0]), 9), round(1e3 * float(off[0]), 9)
    (50.0, 3.0)

    References
    ----------
    Derived here.
    """
    knots = np.zeros(curve.length.shape[0] + 1)
    for i in range(curve.length.shape[0]):
        knots[i + 1] = knots[i] + curve.length[i]
    last = curve.length.shape[0] - 1
    places, away = np.empty(points.shape[0]), np.empty(points.shape[0])
    s, block, before = 0.0, 0, 0.0
    for k in range(points.shape[0]):
        least = s
        s, before = min(s + travelled[k] - before, knots[-1]), travelled[k]
        for _ in range(_LOOKS):
            while block < last and s >= knots[block + 1]:
                block += 1
            while block > 0 and s < knots[block]:
                block -= 1
            px, py, pz = block_point(curve, block, s - knots[block])
            tx, ty, tz = block_tangent(curve, block, s - knots[block])
            bx, by, bz = block_bend(curve, block, s - knots[block])
            dx, dy, dz = points[k, 0] - px, points[k, 1] - py, points[k, 2] - pz
            step = (dx * tx + dy * ty + dz * tz) / max(1.0 - dx * bx - dy * by - dz * bz, 0.1)
            s = min(max(s + min(max(step, -_STRIDE), _STRIDE), least), knots[-1])
        while block < last and s >= knots[block + 1]:
            block += 1
        while block > 0 and s < knots[block]:
            block -= 1
        px, py, pz = block_point(curve, block, s - knots[block])
        places[k] = s
        away[k] = math.sqrt((points[k, 0] - px) ** 2 + (points[k, 1] - py) ** 2 + (points[k, 2] - pz) ** 2)
    return places, away
