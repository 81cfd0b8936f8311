"""The mesh of a part: triangles that lie on its true surfaces and can be halved without leaving them.

A triangle of a mesh is a piece of a face. Its corners are put on the true surface, in closed form for an elementary
one and by its parameters for a free-form one, and so is every middle that halving makes. What is looked for on a mesh
is therefore looked for on the part itself; only the outlines of faces are those of the mesh.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import inlined, internal
from cutwise.maths.curves import FloatArray
from cutwise.maths.nurbs import Splines, spline_point
from cutwise.maths.surfaces import FREE_FORM, PLANE, IntArray, Surfaces, signed_distance

PIECE = 15  # numbers of a piece: three corners [m] and their surface parameters


class Faces(NamedTuple):
    """The surfaces of a part; few arrays, because kernels hand them on and on."""

    surfaces: Surfaces  # one row for each face; the first size of a free-form one is its number in the next table
    splines: Splines
    limit: FloatArray  # face, other surface, sign, reach [m]: points of the face whose sign * distance from the other
    # surface is negative, but not by more than the reach, are none of it; sorted by face, shape (k, 4)


class SurfaceMesh(NamedTuple):
    """Triangles on the faces of a part."""

    piece: FloatArray  # corners [m], then surface parameters (free-form faces only), shape (m, 15)
    face: IntArray  # shape (m,)
    faces: Faces
    error: float  # [m] by how much outlines of faces may be off

    @property
    def corner(self) -> FloatArray:
        """Corners of the triangles [m], shape (m, 3, 3)."""
        return self.piece[:, :9].reshape(-1, 3, 3)


class Boxes(NamedTuple):
    """Boxes and balls round the triangles of a mesh, to leave out what is far away."""

    low: FloatArray  # [m], shape (m, 3)
    high: FloatArray
    middle: FloatArray  # [m], shape (m, 3)
    size: FloatArray  # [m] from the middle to the farthest point, shape (m,)


def boxes(mesh: SurfaceMesh) -> Boxes:
    """Boxes of all triangles; a curved one may bulge, so they are a little larger than the corners ask for."""
    corner = mesh.corner
    low, high, middle = corner.min(axis=1), corner.max(axis=1), corner.mean(axis=1)
    slack = 0.3 * np.linalg.norm(high - low, axis=1, keepdims=True)
    size = 1.3 * np.sqrt(((corner - middle[:, None, :]) ** 2).sum(axis=2).max(axis=1))
    return Boxes(low - slack, high + slack, middle, size)


def within(mesh: SurfaceMesh, around: Boxes, low: FloatArray, high: FloatArray) -> tuple[SurfaceMesh, Boxes]:
    """The triangles that may reach into a box."""
    inside = np.flatnonzero(((around.low <= high) & (around.high >= low)).all(axis=1))
    return picked(mesh, inside), Boxes(*(one[inside] for one in around))


def picked(mesh: SurfaceMesh, which: IntArray) -> SurfaceMesh:
    """Some triangles of a mesh, in this order."""
    return mesh._replace(piece=np.ascontiguousarray(mesh.piece[which]), face=mesh.face[which])


class Middle(NamedTuple):
    """The middle of a piece, on the surface."""

    x: float
    y: float
    z: float
    reach: float  # [m] no point of the piece is farther away
    bulge: float  # [m] how far the middle was moved onto the surface


@inlined
def put_on(faces: Faces, face: int, x: float, y: float, z: float, u: float, v: float, work: FloatArray) -> Middle:
    r"""The point of a face at a point close to it (elementary faces) or at its parameters (free-form ones).

    .. math:: p = q - f(q)\,\nabla f(q)

    Parameters
    ----------
    faces, face : Faces, int
        Where it lies.
    x, y, z : float
        The point q [m].
    u, v : float
        Parameters; count on free-form faces only.
    work : array
        Room for spline evaluation.

    Returns
    -------
    Middle
        The point, and by how much it was moved, twice [m]; a point of a plane is left where it is.

    Notes
    -----
    Valid for corners of a mesh and middles between them, off the axes of their surfaces.

    Examples
    --------
    3 m from the axis, put on a cylinder of 2 m:

    >>> from cutwise.maths.nurbs import splines
    >>> from cutwise.maths.surfaces import CYLINDER, surfaces
    >>> faces = Faces(surfaces([(CYLINDER, (0, 0, 0), (0, 0, 1), 2.0, 0.0)]), splines([]), no_limits())
    >>> tuple(put_on(faces, 0, 3.0, 0.0, 5.0, 0.0, 0.0, np.zeros((4, 2))))
    (2.0, 0.0, 5.0, 1.0, 1.0)

    References
    ----------
    Derived here from :func:`~cutwise.maths.surfaces.signed_distance`.
    """
    kind = faces.surfaces.row[face, 0]
    if kind == PLANE:
        return Middle(x, y, z, 0.0, 0.0)
    if kind == FREE_FORM:
        p = spline_point(faces.splines, int(faces.surfaces.row[face, 7]), u, v, work)
        px, py, pz = p[0], p[1], p[2]
    else:
        d, gx, gy, gz = signed_distance(faces.surfaces, face, x, y, z)
        px, py, pz = x - d * gx, y - d * gy, z - d * gz
    moved = math.sqrt((px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2)
    return Middle(px, py, pz, moved, moved)


@internal
def middle_of(faces: Faces, face: int, piece: FloatArray, work: FloatArray) -> Middle:
    r"""Middle of a piece and how far the piece reaches from it, its bulge included.

    .. math:: \max_k |c_k - m| + 1.5\,b

    Parameters
    ----------
    faces, face : Faces, int
        Where it lies.
    piece : array (15,)
        Corners :math:`c_k` [m] and their parameters.
    work : array
        Room for spline evaluation.

    Returns
    -------
    Middle
        m on the surface, the reach, and the bulge b, by which the centroid was moved [m].

    Notes
    -----
    Valid for pieces whose bulge is largest in the middle, to the factor of 1.5. Only other kernels call it; ``py_func`` is
    the same in Python.

    Examples
    --------
    A right triangle of 3 and 6 m in a plane; its far corner is at :math:`\sqrt{1 + 16}`.

    >>> from cutwise.maths.nurbs import splines
    >>> from cutwise.maths.surfaces import surfaces
    >>> faces = Faces(surfaces([(PLANE, (0, 0, 0), (0, 0, 1), 0.0, 0.0)]), splines([]), no_limits())
    >>> piece = np.array([0.0, 0, 0, 3, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0])
    >>> middle = middle_of.py_func(faces, 0, piece, np.zeros((4, 2)))
    >>> round(middle.x, 9), round(middle.y, 9), round(middle.reach**2, 9)
    (1.0, 2.0, 17.0)

    References
    ----------
    Derived here.
    """
    third = 1.0 / 3.0
    x, y, z = (
        third * (piece[0] + piece[3] + piece[6]), third * (piece[1] + piece[4] + piece[7]),
        third * (piece[2] + piece[5] + piece[8]),
    )  # fmt: skip
    u, v = third * (piece[9] + piece[11] + piece[13]), third * (piece[10] + piece[12] + piece[14])
    m = put_on(faces, face, x, y, z, u, v, work)
    far = 0.0
    for k in range(3):
        far = max(far, (piece[3 * k] - m.x) ** 2 + (piece[3 * k + 1] - m.y) ** 2 + (piece[3 * k + 2] - m.z) ** 2)
    return Middle(m.x, m.y, m.z, math.sqrt(far) + 1.5 * m.bulge, m.bulge)


@internal
def halve(
    faces: Faces, face: int, pieces: FloatArray, place: int, axis: FloatArray, stretch: float, halves: FloatArray,
    first: int, second: int, work: FloatArray,
) -> None:  # fmt: skip
    """Cut a piece in two across its longest side.

    Parameters
    ----------
    faces, face : Faces, int
        Where it lies.
    pieces, place : array, int
        A table of pieces, shape (m, 15), and the row of the one to be cut.
    axis, stretch : array, float
        Lengths along this unit vector count less, a hundredth where ``stretch`` is 1 and in full where it is 0.
    halves, first, second : array, int, int
        The table and its rows for the halves; they may be those of the piece.
    work : array
        Room for spline evaluation.

    Notes
    -----
    Valid for sides much shorter than the radii of the surface: the new corner is the middle of the side, put on
    the surface. Only other kernels call it; ``py_func`` is the same in Python.

    Examples
    --------
    A side of 6 m is longer than the other two, and cut at 3 m.

    >>> from cutwise.maths.nurbs import splines
    >>> from cutwise.maths.surfaces import surfaces
    >>> faces = Faces(surfaces([(PLANE, (0, 0, 0), (0, 0, 1), 0.0, 0.0)]), splines([]), no_limits())
    >>> piece, two = np.array([[0.0, 0, 0, 6, 0, 0, 3, 3, 0, 0, 0, 0, 0, 0, 0]]), np.empty((2, 15))
    >>> halve.py_func(faces, 0, piece, 0, np.array([0.0, 0.0, 1.0]), 0.0, two, 0, 1, np.zeros((4, 2)))
    >>> two[:, :9].tolist()
    [[0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 3.0, 3.0, 0.0], [3.0, 0.0, 0.0, 6.0, 0.0, 0.0, 3.0, 3.0, 0.0]]

    References
    ----------
    Rivara 1984, Int. J. Numer. Meth. Eng. 20 (bisection of the longest side).
    """
    longest = -1.0
    a = 0
    piece = pieces[place]
    for k in range(3):
        n = 3 * ((k + 1) % 3)
        dx, dy, dz = piece[n] - piece[3 * k], piece[n + 1] - piece[3 * k + 1], piece[n + 2] - piece[3 * k + 2]
        along = dx * axis[0] + dy * axis[1] + dz * axis[2]
        size = dx * dx + dy * dy + dz * dz - 0.9999 * stretch * along * along
        if size > longest:
            longest, a = size, k
    b = (a + 1) % 3
    x, y, z = (
        0.5 * (piece[3 * a] + piece[3 * b]), 0.5 * (piece[3 * a + 1] + piece[3 * b + 1]),
        0.5 * (piece[3 * a + 2] + piece[3 * b + 2]),
    )  # fmt: skip
    u, v = 0.5 * (piece[9 + 2 * a] + piece[9 + 2 * b]), 0.5 * (piece[10 + 2 * a] + piece[10 + 2 * b])
    m = put_on(faces, face, x, y, z, u, v, work)
    for k in range(PIECE):
        value = piece[k]
        halves[first, k] = value
        halves[second, k] = value
    halves[first, 3 * b], halves[first, 3 * b + 1], halves[first, 3 * b + 2] = m.x, m.y, m.z
    halves[first, 9 + 2 * b], halves[first, 10 + 2 * b] = u, v
    halves[second, 3 * a], halves[second, 3 * a + 1], halves[second, 3 * a + 2] = m.x, m.y, m.z
    halves[second, 9 + 2 * a], halves[second, 10 + 2 * a] = u, v


@inlined
def outside_limits(faces: Faces, face: int, x: float, y: float, z: float) -> float:
    r"""How far a point of a face lies outside of what its limits leave of it [m]; not positive: inside.

    .. math:: \max_k (-\sigma_k d_k), \qquad -\sigma_k d_k \le r_k

    Parameters
    ----------
    faces, face : Faces, int
        The face; rows of ``limit`` are face, other surface, :math:`\sigma` and reach r [m].
    x, y, z : float
        A point of it [m].

    Returns
    -------
    float
        [m], over the limits that reach as far; minus infinity where there is none.

    Notes
    -----
    Valid for limits sorted by their faces, and points off the axes of the other surfaces.

    Examples
    --------
    A plane with a round hole of 2 m: 1 m and 3 m from its centre.

    >>> from cutwise.maths.nurbs import splines
    >>> from cutwise.maths.surfaces import CYLINDER, surfaces
    >>> both = surfaces([(PLANE, (0, 0, 0), (0, 0, 1), 0.0, 0.0), (CYLINDER, (0, 0, 0), (0, 0, 1), 2.0, 0.0)])
    >>> faces = Faces(both, splines([]), np.array([[0.0, 1.0, 1.0, 5.0]]))
    >>> outside_limits(faces, 0, 1.0, 0.0, 0.0), outside_limits(faces, 0, 3.0, 0.0, 0.0)
    (1.0, -1.0)

    References
    ----------
    Derived here.
    """
    worst = -math.inf
    low, high = 0, faces.limit.shape[0]
    while low < high:  # the rows are sorted by their faces
        middle = (low + high) // 2
        if faces.limit[middle, 0] < face:
            low = middle + 1
        else:
            high = middle
    for k in range(low, faces.limit.shape[0]):
        if faces.limit[k, 0] != face:
            break
        d, _, _, _ = signed_distance(faces.surfaces, int(faces.limit[k, 1]), x, y, z)
        past = -faces.limit[k, 2] * d
        if past <= faces.limit[k, 3]:
            worst = max(worst, past)
    return worst


def no_limits() -> FloatArray:
    """The table of limits of a mesh whose triangles end where the faces do."""
    return np.zeros((0, 4))
