"""How high a surface of triangles stands above places, seen along an axis."""

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]

_UPRIGHT = 1e-15  # [m^2] twice the area of a triangle seen along the axis that is none


@compiled
def height_above(flat: FloatArray, height: FloatArray, place: FloatArray, floor: FloatArray, ring: FloatArray) -> float:
    r"""Greatest height of triangles above the floors of places, along rays round each place [m]; 0 if none is hit.

    .. math:: \max\,[\, z_0 + u (z_1 - z_0) + v (z_2 - z_0) - f \,], \qquad u, v \ge 0,\; u + v \le 1

    Parameters
    ----------
    flat : array (t, 3, 2)
        Corners of the triangles across the axis [m].
    height : array (t, 3)
        Their heights along the axis [m].
    place : array (n, 2)
        Places across the axis [m].
    floor : array (n,)
        Their heights f [m].
    ring : array (k, 2)
        Rays round each place, about it [m].

    Notes
    -----
    Valid to the spacing of the rays: what stands between two of them is not hit, nor a triangle that is upright.

    Examples
    --------
    A quarter of the way along both legs of a triangle whose one corner is 4 mm high, over a floor at 0.4 mm:

    >>> flat = 1e-3 * np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])
    >>> place, floor, ring = np.full((1, 2), 2.5e-4), np.array([4e-4]), np.zeros((1, 2))
    >>> round(1e3 * height_above(flat, 1e-3 * np.array([[0.0, 4.0, 0.0]]), place, floor, ring), 9)
    0.6

    References
    ----------
    Derived here.
    """
    most = 0.0
    wide = 0.0
    for r in range(ring.shape[0]):
        wide = max(wide, abs(ring[r, 0]), abs(ring[r, 1]))
    for t in range(flat.shape[0]):
        ax, ay = flat[t, 0, 0], flat[t, 0, 1]
        bx, by, cx, cy = flat[t, 1, 0] - ax, flat[t, 1, 1] - ay, flat[t, 2, 0] - ax, flat[t, 2, 1] - ay
        area = bx * cy - by * cx
        if abs(area) < _UPRIGHT:
            continue
        top = max(height[t, 0], height[t, 1], height[t, 2])
        left, right = ax + min(0.0, bx, cx) - wide, ax + max(0.0, bx, cx) + wide
        front, back = ay + min(0.0, by, cy) - wide, ay + max(0.0, by, cy) + wide
        for n in range(place.shape[0]):
            x, y = place[n, 0], place[n, 1]
            if top - floor[n] <= most or x < left or x > right or y < front or y > back:
                continue
            for r in range(ring.shape[0]):
                px, py = x + ring[r, 0] - ax, y + ring[r, 1] - ay
                u, v = (px * cy - py * cx) / area, (bx * py - by * px) / area
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    z = height[t, 0] + u * (height[t, 1] - height[t, 0]) + v * (height[t, 2] - height[t, 0])
                    most = max(most, z - floor[n])
    return most
