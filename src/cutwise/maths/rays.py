"""Triangles looked at along straight lines: where vertical rays go through a closed surface, and lattices of points on one."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]

_GOLDEN = 0.6180339887498949
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


@compiled
def _lattice(corner: FloatArray, out: FloatArray) -> int:
    """Points (i + 1/2, j + 1/2) inside of triangles into ``out``, as many as it holds; how many there are."""
    count = 0
    for t in range(corner.shape[0]):
        au, av = corner[t, 0, 0], corner[t, 0, 1]
        bu, bv = corner[t, 1, 0] - au, corner[t, 1, 1] - av
        cu, cv = corner[t, 2, 0] - au, corner[t, 2, 1] - av
        area = bu * cv - bv * cu
        if area == 0.0:
            continue
        first_u, last_u = int(np.floor(au + min(0.0, bu, cu) - 0.5)), int(np.ceil(au + max(0.0, bu, cu) - 0.5))
        first_v, last_v = int(np.floor(av + min(0.0, bv, cv) - 0.5)), int(np.ceil(av + max(0.0, bv, cv) - 0.5))
        for i in range(first_u, last_u + 1):
            for j in range(first_v, last_v + 1):
                x, y = i + 0.5 - au, j + 0.5 - av
                s, w = (x * cv - y * cu) / area, (bu * y - bv * x) / area
                if s < 0.0 or w < 0.0 or s + w >= 1.0:
                    continue
                if count < out.shape[0]:
                    out[count, 0], out[count, 1] = i + 0.5, j + 0.5
                count += 1
    return count


def lattice(corner: FloatArray, du: float, dv: float) -> FloatArray:
    """Points of a square lattice that lie in triangles of a plane, shape (n, 2): evenly over all of them, whatever their shape.

    The lattice is turned by the arc tangent of the golden ratio, the angle that is hardest to meet by whole numbers: lines of
    passes or holes on a face do not fall in step with it. ``corner`` has the shape (m, 3, 2); ``du`` and ``dv`` are its meshes.
    """
    turn = np.array([[1.0, -_GOLDEN], [_GOLDEN, 1.0]]) / np.hypot(1.0, _GOLDEN)
    scale = np.array([du, dv])
    triangles = np.ascontiguousarray((np.asarray(corner, float) / scale) @ turn)
    out = np.empty((_lattice(triangles, np.empty((0, 2))), 2))
    _lattice(triangles, out)
    return np.asarray((out @ turn.T) * scale)
