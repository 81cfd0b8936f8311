"""How high a surface of triangles stands above places, seen along an axis."""

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]

_UPRIGHT = 1e-15  # [m^2] twice the area of a triangle seen along the axis that is none


@compiled
def height_above(flat: FloatArray, height: FloatArray, place: FloatArray, floor: FloatArray, ring: FloatArray) -> float:
    """Greatest height of triangles above the floors of places, along rays on a ring round each place [m]; 0 if none is hit.

    Parameters
    ----------
    flat : array (t, 3, 2)
        Corners of the triangles across the axis [m].
    height : array (t, 3)
        Their heights along the axis [m].
    place : array (n, 2)
        Places across the axis [m].
    floor : array (n,)
        Their heights [m].
    ring : array (k, 2)
        Rays round each place, about it [m].
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
