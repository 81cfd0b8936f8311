"""Rational B-spline surfaces as one flat table, evaluated by kernels: what free-form faces of a CAD part become."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.maths.surfaces import IntArray

_NEAR_STEPS = 20
_ASTRAY = 3e-5  # [m] a foot farther away than this was not the nearest one, or the point is not near the surface
_GRID = 5
_NODES = 6  # of a section polynomial

Nine = tuple[float, float, float, float, float, float, float, float, float]


class SplineSurface(NamedTuple):
    """One surface."""

    u_knots: FloatArray  # knot sequence with repetitions, shape (nu + degree_u + 1,)
    v_knots: FloatArray
    poles: FloatArray  # [m], shape (nu, nv, 3)
    weights: FloatArray  # shape (nu, nv)
    degree_u: int
    degree_v: int


class Splines(NamedTuple):
    """A table of surfaces, all numbers one after another."""

    knots: FloatArray
    poles: FloatArray  # homogeneous: [m] times weight, and the weight, shape (k, 4)
    layout: IntArray  # first u knot, poles and degree in u; the same in v; first pole; shape (m, 7)


def splines(members: Sequence[SplineSurface]) -> Splines:
    """The table of some surfaces; a member is known by its number from then on."""
    knots: list[FloatArray] = [np.zeros(0)]
    poles: list[FloatArray] = [np.zeros((0, 4))]
    layout = []
    knot = pole = 0
    for one in members:
        nu, nv = one.weights.shape
        layout.append((knot, nu, one.degree_u, knot + one.u_knots.size, nv, one.degree_v, pole))
        knots += [one.u_knots, one.v_knots]
        poles.append(np.dstack([one.poles * one.weights[:, :, None], one.weights]).reshape(-1, 4))
        knot += one.u_knots.size + one.v_knots.size
        pole += nu * nv
    return Splines(
        np.ascontiguousarray(np.concatenate(knots)), np.ascontiguousarray(np.concatenate(poles)),
        np.array(layout, np.int64).reshape(-1, 7),
    )  # fmt: skip


@compiled
def _basis(knots: FloatArray, first: int, count: int, degree: int, t: float, out: FloatArray) -> int:
    """Values (row 0) and slopes (row 1) of the basis functions that live at t; the number of the first one.

    Piegl and Tiller, The NURBS Book, algorithms A2.1 and A2.3 for one derivative.
    """
    low, high = first + degree, first + count
    a, b = low, high
    while b - a > 1:
        middle = (a + b) // 2
        if knots[middle] <= t:
            a = middle
        else:
            b = middle
    span = a
    while span > low and knots[span] == knots[span + 1]:
        span -= 1
    out[0, 0] = 1.0
    for j in range(1, degree + 1):
        if j == degree:  # the slopes come from the functions of one degree less
            for r in range(j):
                out[1, r] = out[0, r]
        saved = 0.0
        for r in range(j):
            right, left = knots[span + r + 1] - t, t - knots[span + 1 - j + r]
            share = out[0, r] / (right + left)
            out[0, r] = saved + right * share
            saved = left * share
        out[0, j] = saved
    before = 0.0
    for r in range(degree + 1):
        after = 0.0
        if r < degree:
            width = knots[span + r + 1] - knots[span + 1 - degree + r]
            after = degree * out[1, r] / width
        out[1, r] = before - after
        before = after
    return span - first - degree


@compiled
def spline_point(table: Splines, index: int, u: float, v: float, work: FloatArray) -> Nine:
    r"""Point [m] and both derivatives [m per parameter] of a surface; beyond its range the last piece goes on.

    .. math:: S = A / w, \quad S_u = (A_u - w_u S) / w, \qquad
              (A, w) = \sum_{ij} N_i(u) N_j(v)\,(w_{ij} P_{ij},\; w_{ij})

    Parameters
    ----------
    table, index : Splines, int
        The surface.
    u, v : float
        Parameters.
    work : array
        Room for the basis functions, shape (4, degree + 1) or more.

    Returns
    -------
    tuple
        S, :math:`S_u`, :math:`S_v`, nine numbers.

    Notes
    -----
    Valid for positive weights and knots that are repeated no more than the degree inside.

    Examples
    --------
    A quarter of a cylinder of 1 m, in its middle: :math:`\sqrt{1/2}` twice, and half its height.

    >>> ring, root = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), math.sqrt(0.5)
    >>> poles = np.stack([np.column_stack([ring, np.full(3, z)]) for z in (0.0, 2.0)], axis=1)
    >>> weights = np.array([[1.0, 1.0], [root, root], [1.0, 1.0]])
    >>> knots = np.array([0.0, 0, 0, 1, 1, 1]), np.array([0.0, 0, 1, 1])
    >>> table = splines([SplineSurface(*knots, poles, weights, 2, 1)])
    >>> [round(part, 9) for part in spline_point(table, 0, 0.5, 0.5, workspace(table))[:3]]
    [0.707106781, 0.707106781, 1.0]

    References
    ----------
    Piegl and Tiller 1997, The NURBS Book, secs. 4.4 (the surface) and 4.5 (its derivatives).
    """
    lay = table.layout[index]
    nu, du, nv, dv = lay[1], lay[2], lay[4], lay[5]
    i0 = _basis(table.knots, lay[0], nu, du, u, work[0:2])
    j0 = _basis(table.knots, lay[3], nv, dv, v, work[2:4])
    x = y = z = w = ux = uy = uz = uw = vx = vy = vz = vw = 0.0
    for i in range(du + 1):
        row = lay[6] + (i0 + i) * nv + j0
        px = py = pz = pw = qx = qy = qz = qw = 0.0
        for j in range(dv + 1):
            pole = table.poles[row + j]
            b, d = work[2, j], work[3, j]
            px += b * pole[0]
            py += b * pole[1]
            pz += b * pole[2]
            pw += b * pole[3]
            qx += d * pole[0]
            qy += d * pole[1]
            qz += d * pole[2]
            qw += d * pole[3]
        b, d = work[0, i], work[1, i]
        x += b * px
        y += b * py
        z += b * pz
        w += b * pw
        ux += d * px
        uy += d * py
        uz += d * pz
        uw += d * pw
        vx += b * qx
        vy += b * qy
        vz += b * qz
        vw += b * qw
    x /= w
    y /= w
    z /= w
    return (
        x, y, z, (ux - uw * x) / w, (uy - uw * y) / w, (uz - uw * z) / w,
        (vx - vw * x) / w, (vy - vw * y) / w, (vz - vw * z) / w,
    )  # fmt: skip


@compiled
def workspace(table: Splines) -> FloatArray:
    """Room that :func:`spline_point` needs for any surface of a table.

    Parameters
    ----------
    table : Splines
        The surfaces.

    Returns
    -------
    array (4, largest degree + 2)
        Zeros; valid for one thread.

    Examples
    --------
    >>> straight, square = np.array([0.0, 0, 1, 1]), np.array([[[0.0, 0, 0], [0, 4, 0]], [[2, 0, 0], [2, 4, 0]]])
    >>> workspace(splines([SplineSurface(straight, straight, square, np.ones((2, 2)), 1, 1)])).shape
    (4, 3)
    """
    most = 1
    for k in range(table.layout.shape[0]):
        most = max(most, table.layout[k, 2], table.layout[k, 5])
    return np.zeros((4, most + 2))


@compiled
def _foot_from(
    table: Splines, index: int, x: float, y: float, z: float, u: float, v: float, work: FloatArray
) -> tuple[float, float, float]:
    """Parameters of the foot of a point on a surface by Gauss and Newton from a guess, and its squared distance."""
    lay = table.layout[index]
    u0, u1 = table.knots[lay[0] + lay[2]], table.knots[lay[0] + lay[1]]
    v0, v1 = table.knots[lay[3] + lay[5]], table.knots[lay[3] + lay[4]]
    square = math.inf
    for _ in range(_NEAR_STEPS):
        px, py, pz, ux, uy, uz, vx, vy, vz = spline_point(table, index, u, v, work)
        rx, ry, rz = x - px, y - py, z - pz
        square = rx * rx + ry * ry + rz * rz
        a, b, c = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
        f, g = rx * ux + ry * uy + rz * uz, rx * vx + ry * vy + rz * vz
        det = a * c - b * b
        if det <= 1e-14 * a * c:
            break
        du, dv = (f * c - g * b) / det, (g * a - f * b) / det
        u, v = min(max(u + du, u0), u1), min(max(v + dv, v0), v1)
        if du * du * a + dv * dv * c < 1e-30:
            break
    return u, v, square


@compiled
def nearest_parameters(
    table: Splines, index: int, x: float, y: float, z: float, u: float, v: float, work: FloatArray
) -> tuple[float, float]:
    r"""Parameters of the foot of a point near a surface from a guess, or from a grid where the guess leads astray.

    .. math:: (q - S) \cdot S_u = 0, \qquad (q - S) \cdot S_v = 0

    by Gauss and Newton, kept within the range of the surface.

    Parameters
    ----------
    table, index : Splines, int
        The surface.
    x, y, z : float
        The point q [m].
    u, v : float
        Guess.
    work : array
        From :func:`workspace`.

    Returns
    -------
    tuple
        u and v.

    Notes
    -----
    Valid for points much nearer to the surface than its radii of curvature: the second derivatives are left out, which
    slows the search down farther away. A foot more than 0.03 mm off is looked for again from 25 places.

    Examples
    --------
    >>> straight, square = np.array([0.0, 0, 1, 1]), np.array([[[0.0, 0, 0], [0, 4, 0]], [[2, 0, 0], [2, 4, 0]]])
    >>> flat = splines([SplineSurface(straight, straight, square, np.ones((2, 2)), 1, 1)])
    >>> [round(part, 9) for part in nearest_parameters(flat, 0, 0.5, 3.0, 1e-6, 0.5, 0.5, workspace(flat))]
    [0.25, 0.75]

    References
    ----------
    Piegl and Tiller 1997, The NURBS Book, sec. 6.1 (point inversion), without the second derivatives.
    """
    best_u, best_v, least = _foot_from(table, index, x, y, z, u, v, work)
    if least < _ASTRAY * _ASTRAY:
        return best_u, best_v
    lay = table.layout[index]
    u0, u1 = table.knots[lay[0] + lay[2]], table.knots[lay[0] + lay[1]]
    v0, v1 = table.knots[lay[3] + lay[5]], table.knots[lay[3] + lay[4]]
    for i in range(_GRID):
        for j in range(_GRID):
            share_u, share_v = (i + 0.5) / _GRID, (j + 0.5) / _GRID
            u, v, square = _foot_from(
                table, index, x, y, z, u0 + share_u * (u1 - u0), v0 + share_v * (v1 - v0), work
            )  # fmt: skip
            if square < least:
                best_u, best_v, least = u, v, square
    return best_u, best_v


@compiled
def spline_normals(
    table: Splines, index: int, side: float, point: FloatArray, uv: FloatArray, gap: FloatArray, normal: FloatArray
) -> None:
    r"""Distance of points from a surface along its normal, and that normal; ``uv`` comes in as a guess.

    .. math:: n = \sigma\,S_u \times S_v / |S_u \times S_v|, \qquad g = (q - S) \cdot n

    Parameters
    ----------
    table, index : Splines, int
        The surface.
    side : float
        :math:`\sigma`: 1 if the outward normal is :math:`S_u \times S_v`, -1 if it is opposite.
    point : array
        Points q close to the surface [m], shape (n, 3).
    uv : array
        Parameters of their feet: guess in, result out, shape (n, 2).
    gap, normal : array
        Results: signed distance g [m], shape (n,), and unit normals, shape (n, 3).

    Notes
    -----
    Valid where :func:`nearest_parameters` is; where the surface has a pole the normal is zero, and with it the gap.

    Examples
    --------
    >>> straight, square = np.array([0.0, 0, 1, 1]), np.array([[[0.0, 0, 0], [0, 4, 0]], [[2, 0, 0], [2, 4, 0]]])
    >>> flat = splines([SplineSurface(straight, straight, square, np.ones((2, 2)), 1, 1)])
    >>> gap, normal = np.empty(1), np.empty((1, 3))
    >>> spline_normals(flat, 0, 1.0, np.array([[0.5, 3.0, 0.25]]), np.array([[0.5, 0.5]]), gap, normal)
    >>> gap.round(9).tolist(), normal.round(9).tolist()
    ([0.25], [[0.0, 0.0, 1.0]])

    References
    ----------
    Derived here from :func:`spline_point`.
    """
    work = workspace(table)
    for i in range(point.shape[0]):
        u, v = nearest_parameters(table, index, point[i, 0], point[i, 1], point[i, 2], uv[i, 0], uv[i, 1], work)
        px, py, pz, ux, uy, uz, vx, vy, vz = spline_point(table, index, u, v, work)
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        scale = side / length if length > 0.0 else 0.0
        normal[i, 0], normal[i, 1], normal[i, 2] = scale * nx, scale * ny, scale * nz
        gap[i] = (
            (point[i, 0] - px) * normal[i, 0] + (point[i, 1] - py) * normal[i, 1] + (point[i, 2] - pz) * normal[i, 2]
        )
        uv[i, 0], uv[i, 1] = u, v


CHEBYSHEV = 0.5 * (1.0 - np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES))  # nodes of a section, parts of its reach


@compiled
def section_heights(
    table: Splines, index: int, start: FloatArray, point: FloatArray, along: FloatArray, normal: FloatArray,
    reach: float, node: FloatArray,
) -> FloatArray:  # fmt: skip
    r"""Sections of a surface with planes, :math:`S(u, v) = C + a\, u + g\, n`: g at some distances a from each C.

    Parameters
    ----------
    table, index : Splines, int
        The surface.
    start : array
        Parameters of the points C, shape (n, 2).
    point, along, normal : array
        Points C on the surface [m], tangents u of the surface and its normals n there, shape (n, 3).
    reach : float
        Longest distance a [m].
    node : array
        Distances, rising, in parts of it, shape (k,).

    Returns
    -------
    array
        Heights g [m], shape (n, k).

    Notes
    -----
    Valid where the section goes on as far as the reach; eight steps of Newton from the node before it, and the last of them
    is taken as it is.

    Examples
    --------
    :math:`z = x^2` cut along x: 0.25 and 1 at 0.5 and 1 m.

    >>> poles = np.array([[[0.0, 0, 0], [0, 1, 0]], [[0.5, 0, 0], [0.5, 1, 0]], [[1, 0, 1], [1, 1, 1]]])
    >>> knots = np.array([0.0, 0, 0, 1, 1, 1]), np.array([0.0, 0, 1, 1])
    >>> bowl = splines([SplineSurface(*knots, poles, np.ones((3, 2)), 2, 1)])
    >>> at, x, z = np.array([[0.0, 0.5, 0.0]]), np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    >>> section_heights(bowl, 0, np.array([[0.0, 0.5]]), at, x, z, 1.0, np.array([0.5, 1.0])).round(9).tolist()
    [[0.25, 1.0]]

    References
    ----------
    Derived here: Newton's method on the two parameters.
    """
    work = workspace(table)
    height = np.zeros((point.shape[0], node.size))
    for i in range(point.shape[0]):
        u, v = start[i]
        ax, ay, az = along[i]
        nx, ny, nz = normal[i]
        bx, by, bz = ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax
        px, py, pz, ux, uy, uz, vx, vy, vz = spline_point(table, index, u, v, work)
        for k in range(node.size):
            for _ in range(8):
                rx, ry, rz = point[i, 0] - px, point[i, 1] - py, point[i, 2] - pz
                f = rx * ax + ry * ay + rz * az + node[k] * reach
                g = rx * bx + ry * by + rz * bz
                if abs(f) + abs(g) < 1e-13:
                    break
                a, b = ux * ax + uy * ay + uz * az, vx * ax + vy * ay + vz * az
                c, d = ux * bx + uy * by + uz * bz, vx * bx + vy * by + vz * bz
                det = a * d - b * c
                if det == 0.0:
                    break
                u, v = u + (d * f - b * g) / det, v + (a * g - c * f) / det
                px, py, pz, ux, uy, uz, vx, vy, vz = spline_point(table, index, u, v, work)
            height[i, k] = (px - point[i, 0]) * nx + (py - point[i, 1]) * ny + (pz - point[i, 2]) * nz
    return height
