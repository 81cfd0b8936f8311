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
    """
    values = np.asarray(error, dtype=float)
    u, v = np.meshgrid(np.asarray(at, dtype=float), np.asarray(across, dtype=float), indexing="ij")
    plane = np.stack([np.ones(u.size), u.ravel(), v.ravel()], axis=1)
    left = values.ravel() - plane @ np.linalg.lstsq(plane, values.ravel(), rcond=None)[0]
    return float(np.ptp(left))
