"""The mesh of a CAD part: triangles whose corners lie on its true faces."""

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cutwise.io.cad import CONCAVE, CONVEX, Topology
from cutwise.io.cad_faces import Face
from cutwise.io.occ import MM, occ
from cutwise.maths.curves import FloatArray
from cutwise.maths.nurbs import spline_normals
from cutwise.maths.surface_mesh import Faces, SurfaceMesh, no_limits
from cutwise.maths.surfaces import FREE_FORM, PLANE

OUTLINE = 5e-6  # [m] distance between the outlines of faces and those of their triangles
_INSIDE = 1e-4  # [m] inside of faces, where corners are put on the surface anyway
_TURN = 0.5  # [rad] largest angle between neighbouring triangles
_MANY = 500  # edges of a part from which on a mesher is taken whose time grows with their number, not with power 1.5


def cad_mesh(
    model: Topology, outline: float = OUTLINE, *, meshed: Callable[[float], object] | None = None
) -> SurfaceMesh:
    """Triangles on all faces of a part; outlines of free-form faces are followed within a distance [m].

    Meshed face by face, so that a signal is heard in between and ``meshed`` is told the share of the edges that each
    was: the edge between two faces keeps the points that the first of them gave it.
    """
    wanted = occ("IMeshTools").IMeshTools_Parameters()
    wanted.Deflection, wanted.DeflectionInterior = outline / MM, _INSIDE / MM
    wanted.Angle = wanted.AngleInterior = _TURN
    if len(model.edges) > _MANY:  # 1,296 holes in a plate take the usual one 170 CPU s, it 4; no face over 1.5
        wanted.MeshAlgo = occ("IMeshTools").IMeshTools_MeshAlgoType.IMeshTools_MeshAlgoType_Delabella
    bounds = Counter(face for edge in model.edges for face in edge.faces)
    for face in model.faces:
        occ("BRepMesh").BRepMesh_IncrementalMesh(face.shape, wanted)
        if meshed is not None:
            meshed(bounds[face.index] / max(1, bounds.total()))
    pieces = [np.zeros((0, 15))]
    owners = [np.zeros(0, np.int64)]
    for face in model.faces:
        found = _triangles(model, face)
        if found is not None:
            pieces.append(found)
            owners.append(np.full(len(found), face.index, np.int64))
    faces = Faces(model.surfaces, model.splines, _limits(model, outline))
    free = any(face.kind == FREE_FORM for face in model.faces)
    return SurfaceMesh(
        np.ascontiguousarray(np.concatenate(pieces)), np.concatenate(owners), faces, outline if free else 0.0
    )  # fmt: skip


def _limits(model: Topology, outline: float) -> FloatArray:
    """Where a face ends at a curved one, so that the chords of its triangles do not run into the air beyond.

    Beside a convex edge a face is on the inner side of its neighbour, beside a concave one on the outer side; beside
    an edge that is both it is on either.
    """
    rows = []
    both = {piece.index for pieces in model.split for piece in pieces}
    for edge in model.edges:
        if edge.kind not in (CONVEX, CONCAVE) or edge.index in both:
            continue
        for f, g in (edge.faces, edge.faces[::-1]):
            other = model.faces[g]
            if other.kind not in (PLANE, FREE_FORM):
                rows.append((f, g, other.sign * (-1.0 if edge.kind == CONVEX else 1.0), 2.0 * outline))
    return np.array(sorted(rows), float).reshape(-1, 4) if rows else no_limits()


def _triangles(model: Topology, face: Face) -> FloatArray | None:
    """Corners and parameters of the triangles of a face, shape (m, 15)."""
    place = occ("TopLoc").TopLoc_Location()
    mesh = occ("BRep").BRep_Tool.Triangulation_s(face.shape, place)
    if mesh is None:
        return None
    node = _nodes(mesh, None if place.IsIdentity() else place.Transformation())
    index = _corners(mesh)
    parameter = np.zeros((len(node), 2))
    if face.spline >= 0:
        if mesh.HasUVNodes():
            parameter = np.array([(p.X(), p.Y()) for p in map(mesh.UVNode, range(1, len(node) + 1))])
        gap, normal = np.empty(len(node)), np.empty((len(node), 3))
        spline_normals(model.splines, face.spline, face.sign, node, parameter, gap, normal)
    return np.hstack([node[index].reshape(-1, 9), parameter[index].reshape(-1, 6)])


def _nodes(mesh: Any, moved: Any) -> FloatArray:
    """Nodes of a triangulation [m], shape (n, 3)."""
    points = [mesh.Node(i) for i in range(1, mesh.NbNodes() + 1)]
    if moved is not None:
        points = [p.Transformed(moved) for p in points]
    return np.array([(p.X(), p.Y(), p.Z()) for p in points]).reshape(-1, 3) * MM


def _corners(mesh: Any) -> NDArray[np.int64]:
    triangles = map(mesh.Triangle, range(1, mesh.NbTriangles() + 1))
    return np.array([t.Get() for t in triangles], np.int64).reshape(-1, 3) - 1
