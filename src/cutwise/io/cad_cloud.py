"""Points on the surfaces of a CAD part: what gouges and rod contacts are looked for on."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from cutwise.io.cad import Topology
from cutwise.io.step import MM, occ
from cutwise.maths.surfaces import FREE_FORM, outside_of

FloatArray = NDArray[np.float64]


class Cloud(NamedTuple):
    """Surface points."""

    point: FloatArray  # [m], shape (n, 3)
    error: float  # [m] how far points of free-form surfaces are off; 0 without such


class Mesh(NamedTuple):
    """Triangles of a part."""

    corner: FloatArray  # [m], shape (m, 3, 3)
    face: NDArray[np.int64]  # shape (m,)
    deflection: float  # [m] largest distance of triangle and surface


def mesh(model: Topology, deflection: float = 1e-5) -> Mesh:
    """Triangles on all faces of a part."""
    occ("BRepMesh").BRepMesh_IncrementalMesh(model.part.shape, deflection / MM, False, 0.4, False)
    tool = occ("BRep").BRep_Tool
    location = occ("TopLoc").TopLoc_Location
    corners, faces = [], []
    for face in model.faces:
        place = location()
        triangles = tool.Triangulation_s(face.shape, place)
        if triangles is None:
            continue
        moved = place.Transformation()
        nodes = np.empty((triangles.NbNodes(), 3))
        for i in range(len(nodes)):
            p = triangles.Node(i + 1).Transformed(moved)
            nodes[i] = p.X(), p.Y(), p.Z()
        index = np.array([triangles.Triangle(i + 1).Get() for i in range(triangles.NbTriangles())], np.int64) - 1
        corners.append(nodes[index] * MM)
        faces.append(np.full(len(index), face.index))
    if not corners:
        return Mesh(np.zeros((0, 3, 3)), np.zeros(0, np.int64), deflection)
    return Mesh(np.concatenate(corners), np.concatenate(faces), deflection)


def cloud(model: Topology, net: Mesh, near: FloatArray, radius: float, fine: float, coarse: float) -> Cloud:
    """Points on a part: dense around given points, thin elsewhere.

    Points of elementary surfaces are put exactly on them; those of free-form surfaces are as good as the mesh.

    Parameters
    ----------
    model, net : Topology, Mesh
        The part and its triangles.
    near : array
        Points around which the cloud is dense [m], shape (k, 3).
    radius : float
        How far around them [m].
    fine, coarse : float
        Spacing there, and elsewhere [m].
    """
    corner, owner = net.corner, net.face
    tree = KDTree(near[:: max(1, len(near) // 4000)]) if len(near) else None
    done, owners = [], []
    while len(corner):
        side = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2)
        longest = side.max(axis=1)
        middle = corner.mean(axis=1)
        apart = np.full(len(corner), np.inf)
        large = longest > fine
        if tree and large.any():
            bound = radius + float(longest.max())
            apart[large] = tree.query(middle[large], distance_upper_bound=bound)[0] - longest[large]
        small = longest <= np.where(apart < radius, fine, coarse)
        done.append(middle[small])
        owners.append(owner[small])
        corner, owner = _halved(corner[~small], side[~small]), np.tile(owner[~small], 2)
    point, owner = np.concatenate([np.zeros((0, 3)), *done]), np.concatenate([np.zeros(0, np.int64), *owners])
    free = False
    for face in model.faces:
        mine = owner == face.index
        if not mine.any():
            continue
        if face.kind == FREE_FORM:
            free = True
            continue
        for _ in range(2):
            distance, gradient = outside_of(model.surfaces, face.index, point[mine])
            point[mine] -= distance[:, None] * gradient
    return Cloud(point, net.deflection if free else 0.0)


def _halved(corner: FloatArray, side: FloatArray) -> FloatArray:
    """Triangles cut in two across their longest side; first all first halves, then all second halves."""
    row = np.arange(len(corner))
    first = np.argmax(side, axis=1)
    a, b, c = corner[row, first], corner[row, (first + 1) % 3], corner[row, (first + 2) % 3]
    middle = 0.5 * (a + b)
    return np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
