"""Elementary surfaces and their sections: what a kernel needs to walk on a plane, cylinder, cone, sphere or torus.

A surface is a row of :class:`Surfaces`. Its signed distance is in closed form, so the curve in which a plane cuts it
follows by Newton's method without surface parameters, seams or trimming. A free-form surface has no row of numbers;
each point of an edge then carries the section curve itself, as a polynomial.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray

IntArray = NDArray[np.int64]

PLANE = 0
CYLINDER = 1
CONE = 2
SPHERE = 3
TORUS = 4
FREE_FORM = 5

SECTION_TERMS = 8  # a section polynomial has the powers 0 to 7; the first two are zero at an edge point


class Surfaces(NamedTuple):
    """A table of elementary surfaces: kind, origin, axis, two sizes; one array, because kernels hand it on and on."""

    row: FloatArray  # shape (m, 9)

    @property
    def kind(self) -> IntArray:
        """PLANE ... FREE_FORM, shape (m,)."""
        return self.row[:, 0].astype(np.int64)

    @property
    def origin(self) -> FloatArray:
        """A point of the plane, or of the axis, or the centre [m], shape (m, 3)."""
        return self.row[:, 1:4]

    @property
    def axis(self) -> FloatArray:
        """Normal of the plane, or unit vector of the axis, shape (m, 3)."""
        return self.row[:, 4:7]

    @property
    def size(self) -> FloatArray:
        """Radius [m] and, cone: half angle [rad], torus: radius of the tube [m]; free-form: its number; (m, 2)."""
        return self.row[:, 7:9]


def surfaces(rows: Sequence[tuple[int, Sequence[float], Sequence[float], float, float]]) -> Surfaces:
    """The table from rows (kind, origin, axis, first size, second size); axes are made unit vectors."""
    table = np.array([(row[0], *row[1], *row[2], *row[3:5]) for row in rows], float).reshape(-1, 9)
    length = np.linalg.norm(table[:, 4:7], axis=1, keepdims=True)
    table[:, 4:7] /= np.where(length > 0.0, length, 1.0)
    return Surfaces(table)


def outside_of(table: Surfaces, index: int, point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Signed distance [m] and its gradient at points of shape (n, 3), for one surface of the table."""
    distance = np.empty(len(point))
    gradient = np.empty((len(point), 3))
    _signed_distances(table, index, np.ascontiguousarray(point, float), distance, gradient)
    return distance, gradient


@compiled
def signed_distance(table: Surfaces, index: int, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    r"""Signed distance of a point from an elementary surface, and its gradient (a unit vector).

    With the axial height :math:`h` and the distance :math:`\rho` from the axis: plane :math:`h`; cylinder
    :math:`\rho - R`; cone :math:`(\rho - R) \cos\sigma - h \sin\sigma`; sphere :math:`|q| - R`; torus
    :math:`\sqrt{(\rho - R)^2 + h^2} - r`. Positive along the normal of a plane and away from the axis or the centre.

    Parameters
    ----------
    table, index : Surfaces, int
        The surface.
    x, y, z : float
        The point [m]; not on the axis.

    Returns
    -------
    tuple
        Distance [m] and x, y, z of the gradient [1].

    Notes
    -----
    Valid off the axis, the centre of a sphere and the centre line of a torus, where there is no gradient; of a cone, on
    that side of its tip where it is.

    Examples
    --------
    3 m from the axis of a cylinder of 2 m:

    >>> signed_distance(surfaces([(CYLINDER, (0, 0, 0), (0, 0, 1), 2.0, 0.0)]), 0, 3.0, 0.0, 5.0)
    (1.0, 1.0, 0.0, 0.0)

    References
    ----------
    Derived here: elementary geometry.
    """
    row = table.row
    kind = row[index, 0]
    qx, qy, qz = x - row[index, 1], y - row[index, 2], z - row[index, 3]
    ax, ay, az = row[index, 4], row[index, 5], row[index, 6]
    h = qx * ax + qy * ay + qz * az
    if kind == PLANE:
        return h, ax, ay, az
    radius = row[index, 7]
    if kind == SPHERE:
        length = math.sqrt(qx * qx + qy * qy + qz * qz)
        return length - radius, qx / length, qy / length, qz / length
    px, py, pz = qx - h * ax, qy - h * ay, qz - h * az
    rho = math.sqrt(px * px + py * py + pz * pz)
    ex, ey, ez = px / rho, py / rho, pz / rho
    if kind == CYLINDER:
        return rho - radius, ex, ey, ez
    second = row[index, 8]
    if kind == CONE:
        c, s = math.cos(second), math.sin(second)
        return (rho - radius) * c - h * s, c * ex - s * ax, c * ey - s * ay, c * ez - s * az
    away = rho - radius
    tube = math.sqrt(away * away + h * h)
    c, s = away / tube, h / tube
    return tube - second, c * ex + s * ax, c * ey + s * ay, c * ez + s * az


@compiled
def _signed_distances(
    table: Surfaces, index: int, point: FloatArray, distance: FloatArray, gradient: FloatArray
) -> None:
    for i in range(point.shape[0]):
        d, gx, gy, gz = signed_distance(table, index, point[i, 0], point[i, 1], point[i, 2])
        distance[i] = d
        gradient[i, 0], gradient[i, 1], gradient[i, 2] = gx, gy, gz


@compiled
def section_height(
    table: Surfaces, index: int, polynomial: FloatArray, point: FloatArray, along: FloatArray, normal: FloatArray,
    a: float, start: float,
) -> tuple[float, float]:  # fmt: skip
    r"""Section of a surface with the plane of two directions: height g over the distance a, and the slope.

    The point :math:`C + a u + g n` lies on the surface; :math:`g' = -(\nabla f \cdot u) / (\nabla f \cdot n)`.

    Parameters
    ----------
    table, index : Surfaces, int
        The surface through the edge point.
    polynomial : array
        Coefficients of g(a), lowest power first, shape (8,); used for a free-form surface only.
    point, along, normal : array
        Edge point C [m], unit tangent u of the surface, unit normal n, shape (3,) each.
    a : float
        Distance along u [m].
    start : float
        First guess of g [m].

    Returns
    -------
    tuple of float
        g [m] and slope; NaN where the section does not reach.

    Notes
    -----
    Valid up to 0.06 degrees short of where the surface runs along n and the section turns back; g to 1e-12 m.

    Examples
    --------
    A cylinder of 5 m, 3 m from the top of its arc: 1 m lower, at a slope of -3/4.

    >>> rod, c = surfaces([(CYLINDER, (0, 0, 0), (0, 0, 1), 5.0, 0.0)]), np.array([5.0, 0.0, 0.0])
    >>> x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    >>> [round(part, 9) for part in section_height(rod, 0, np.zeros(8), c, y, x, 3.0, 0.0)]
    [-1.0, -0.75]

    References
    ----------
    Derived here: Newton's method and the implicit function theorem.
    """
    if table.row[index, 0] == FREE_FORM:
        g = 0.0
        slope = 0.0
        for k in range(polynomial.size - 1, -1, -1):
            slope = slope * a + g
            g = g * a + polynomial[k]
        return g, slope
    g = start
    slope = math.nan
    for _ in range(30):
        d, gx, gy, gz = signed_distance(
            table, index, point[0] + a * along[0] + g * normal[0], point[1] + a * along[1] + g * normal[1],
            point[2] + a * along[2] + g * normal[2],
        )  # fmt: skip
        rise = gx * normal[0] + gy * normal[1] + gz * normal[2]
        if abs(rise) < 1e-3:
            return math.nan, math.nan
        slope = -(gx * along[0] + gy * along[1] + gz * along[2]) / rise
        g -= d / rise
        if abs(d) < 1e-15:
            return g, slope
    return (g, slope) if abs(d) < 1e-12 else (math.nan, math.nan)
