"""Where vertical rays through the middles of cells go into and out of a closed surface of triangles."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]

_ASIDE = 1.37e-7  # of a cell: rays do not run along the edges of triangles


class Columns(NamedTuple):
    """Material over each cell, rows of y; cells without have a thickness of 0."""

    top: FloatArray  # [m], shape (along, across)
    bottom: FloatArray
    thickness: FloatArray  # of the material itself: less than top minus bottom where a column has several pieces


@compiled
def _pierce(
    corner: FloatArray,
    x0: float,
    y0: float,
    dx: float,
    dy: float,
    top: FloatArray,
    bottom: FloatArray,
    thick: FloatArray,
) -> None:
    along, across = top.shape
    for t in range(corner.shape[0]):
        ax, ay, az = corner[t, 0, 0], corner[t, 0, 1], corner[t, 0, 2]
        bx, by, bz = corner[t, 1, 0] - ax, corner[t, 1, 1] - ay, corner[t, 1, 2] - az
        cx, cy, cz = corner[t, 2, 0] - ax, corner[t, 2, 1] - ay, corner[t, 2, 2] - az
        area = bx * cy - by * cx
        if area == 0.0:
            continue
        low_x, high_x = ax + min(0.0, bx, cx), ax + max(0.0, bx, cx)
        low_y, high_y = ay + min(0.0, by, cy), ay + max(0.0, by, cy)
        for j in range(max(0, int((low_y - y0) / dy) - 1), min(along - 1, int((high_y - y0) / dy) + 1) + 1):
            y = y0 + dy * j - ay
            for i in range(max(0, int((low_x - x0) / dx) - 1), min(across - 1, int((high_x - x0) / dx) + 1) + 1):
                x = x0 + dx * i - ax
                u, v = (x * cy - y * cx) / area, (bx * y - by * x) / area
                if u < 0.0 or v < 0.0 or u + v >= 1.0:
                    continue
                z = az + u * bz + v * cz
                top[j, i] = max(top[j, i], z)
                bottom[j, i] = min(bottom[j, i], z)
                thick[j, i] += z if area > 0.0 else -z


def columns(corner: FloatArray, x: FloatArray, y: FloatArray) -> Columns:
    """Material of a closed surface over cells.

    Parameters
    ----------
    corner : array (n, 3, 3)
        Corners of triangles whose normals point out of the material [m].
    x, y : array
        Middles of the cells, evenly spaced [m].
    """
    shape = len(y), len(x)
    dx = x[1] - x[0] if len(x) > 1 else 1.0
    dy = y[1] - y[0] if len(y) > 1 else 1.0
    top, bottom, thick = np.full(shape, -np.inf), np.full(shape, np.inf), np.zeros(shape)
    _pierce(
        np.ascontiguousarray(corner, float), x[0] + _ASIDE * dx, y[0] + 0.61 * _ASIDE * dy, dx, dy, top, bottom, thick
    )
    none = ~(top > bottom)
    top[none], bottom[none], thick[none] = 0.0, 0.0, 0.0
    return Columns(top, bottom, thick)
