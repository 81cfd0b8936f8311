"""The surface that an end mill leaves when its point is off by Δ and its axis is turned by ε."""

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.frames import FloatArray


def wall_error(deviation: ArrayLike, rotation: ArrayLike, offsets: ArrayLike, normal: ArrayLike) -> FloatArray:
    r"""Error of a generated surface along its normal, over the pass and over the cutting length.

    .. math:: e(t, h) = n \cdot (\Delta(t) + \varepsilon(t) \times h)

    Each point of a wall is left by the generator of the tool's envelope that passes it; h is that point against the
    tool point. A positive error leaves material when n points into the tool.

    Parameters
    ----------
    deviation : array (t, 3)
        Error of the tool point [m].
    rotation : array (t, 3)
        Error of the tool's direction, :math:`\sum_i R_{0i}\varepsilon_i` [rad].
    offsets : array (h, 3) or (t, h, 3)
        Points of the generator against the tool point [m]; for a peripheral wall along the axis up to the depth of cut.
    normal : array (3,) or (t, 3)
        Unit normal n of the wall.

    Returns
    -------
    array (t, h)
        [m].

    Notes
    -----
    Valid for small errors (first order) that change little while a point of the wall is passed.

    Examples
    --------
    1 µm off, and turned by 10 µrad: a fifth of it is left 80 mm up.

    >>> heights = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.05], [0.0, 0.0, 0.08]])
    >>> (1e6 * wall_error([[0.0, 1e-6, 0.0]], [[1e-5, 0.0, 0.0]], heights, [0.0, 1.0, 0.0])).round(6).tolist()
    [[1.0, 0.5, 0.2]]

    References
    ----------
    Demeč and Madáč, Eqs. (4) and (9); the generator along the axis is derived here.
    """
    moved = np.asarray(deviation, dtype=float)[:, None, :] + np.cross(
        np.asarray(rotation, dtype=float)[:, None, :], np.asarray(offsets, dtype=float)
    )
    n = np.broadcast_to(np.asarray(normal, dtype=float), (len(moved), 3))
    return np.einsum("thi,ti->th", moved, n)


def flatness(error: ArrayLike, at: ArrayLike, across: ArrayLike) -> float:
    """Peak to valley of a surface error after its least-squares plane is taken off [m].

    Parameters
    ----------
    error : array (t, h)
        [m].
    at, across : arrays (t,) and (h,)
        Coordinates in the surface [m].

    Notes
    -----
    The least-squares plane, not the narrowest zone of ISO 1101: an upper bound of that.

    Examples
    --------
    One corner of four 1 µm up: a quarter of it stays at every corner, up or down.

    >>> round(1e6 * flatness([[0.0, 0.0], [0.0, 1e-6]], [0.0, 1.0], [0.0, 1.0]), 6)
    0.5
    """
    values = np.asarray(error, dtype=float)
    u, v = np.meshgrid(np.asarray(at, dtype=float), np.asarray(across, dtype=float), indexing="ij")
    plane = np.stack([np.ones(u.size), u.ravel(), v.ravel()], axis=1)
    left = values.ravel() - plane @ np.linalg.lstsq(plane, values.ravel(), rcond=None)[0]
    return float(np.ptp(left))
