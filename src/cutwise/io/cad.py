"""Topology of a CAD part: its faces, the kind of every edge, and its holes."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.io.cad_splines import spline_surface
from cutwise.io.occ import MM, explored, occ, shape_map
from cutwise.io.step import StepPart
from cutwise.maths.nurbs import Splines, SplineSurface, spline_normals, splines
from cutwise.maths.surfaces import CONE, CYLINDER, FREE_FORM, PLANE, SPHERE, TORUS, Surfaces, outside_of, surfaces

FloatArray = NDArray[np.float64]

_GUESSES = 33  # places of an edge at which its parameters in a face are asked for
SMOOTH_ANGLE = math.radians(1.0)  # normals closer than this meet smoothly

FREE, SEAM, DEGENERATE, SMOOTH, CONVEX, CONCAVE, CROWDED = (
    "without face", "seam", "degenerate", "smooth", "convex", "concave", "more than two faces",
)  # fmt: skip


_NAMES = {
    PLANE: "plane", CYLINDER: "cylinder", CONE: "cone", SPHERE: "sphere", TORUS: "torus", FREE_FORM: "free-form",
}  # fmt: skip


class Face(NamedTuple):
    """A face: its surface, and which side of it is air."""

    index: int  # type: ignore[assignment]
    shape: Any
    evaluator: Any  # adaptor of OpenCascade, in mm
    reversed: bool
    kind: int
    sign: float  # of the gradient of the signed distance along the outward normal; free-form: of the product S_u x S_v
    spline: int  # row of a free-form surface in its table, else -1
    turn: tuple[float, float]  # first and last parameter round the axis [rad]

    @property
    def name(self) -> str:
        """What to call it in messages."""
        return f"face {self.index + 1} ({_NAMES[self.kind]})"


class Edge(NamedTuple):
    """An edge between two faces."""

    index: int  # type: ignore[assignment]
    shape: Any
    kind: str
    faces: tuple[int, ...]
    forward: bool  # whether the edge runs in the direction of its curve in the first face
    angle: float  # [rad] largest angle between the normals, at the samples looked at; 0 unless two faces


class Hole(NamedTuple):
    """A full-turn concave cylinder."""

    faces: tuple[int, ...]
    radius: float  # [m]
    origin: tuple[float, float, float]  # [m] a point of the axis
    axis: tuple[float, float, float]
    middle: tuple[float, float, float]  # [m] of the axis between both ends of the wall
    depth: float  # [m] of the wall along the axis


class Topology(NamedTuple):
    """Faces and edges of a part."""

    part: StepPart
    faces: tuple[Face, ...]
    edges: tuple[Edge, ...]
    holes: tuple[Hole, ...]
    surfaces: Surfaces  # one row for each face
    splines: Splines  # one row for each free-form face

    def count(self, kind: str) -> int:
        """How many edges are of a kind."""
        return sum(edge.kind == kind for edge in self.edges)


def topology(part: StepPart, *, smooth: float = SMOOTH_ANGLE) -> Topology:
    """Look at every face and edge of a part.

    Parameters
    ----------
    part : StepPart
        The part.
    smooth : float
        Angle between the normals below which an edge counts as smooth [rad].
    """
    kinds = occ("TopAbs").TopAbs_ShapeEnum
    shapes = explored(part.shape, kinds.TopAbs_FACE)
    rows = []
    faces = []
    free: list[SplineSurface] = []
    for i, shape in enumerate(shapes):
        face, row = _face(i, shape)
        if face.kind == FREE_FORM:
            face = face._replace(spline=len(free))
            row = (*row[:3], float(len(free)), 0.0)
            free.append(spline_surface(face.shape, face.evaluator))
        faces.append(face)
        rows.append(row)
    table = surfaces(rows)
    free_table = splines(free)
    faces = [face._replace(sign=_sign(face, table)) for face in faces]
    numbers = shape_map(part.shape, kinds.TopAbs_EDGE)
    places: dict[int, list[tuple[int, bool]]] = {}
    forward = occ("TopAbs").TopAbs_Orientation.TopAbs_FORWARD
    for face in faces:
        explorer = occ("TopExp").TopExp_Explorer(face.shape, kinds.TopAbs_EDGE)
        while explorer.More():
            current = explorer.Current()
            places.setdefault(numbers.FindIndex(current) - 1, []).append((face.index, current.Orientation() == forward))
            explorer.Next()
    edges = []
    to_edge = occ("TopoDS").TopoDS.Edge
    for i, shape in enumerate(explored(part.shape, kinds.TopAbs_EDGE)):
        edges.append(_edge(i, to_edge(shape.Oriented(forward)), places.get(i, []), faces, table, free_table, smooth))
    return Topology(part, tuple(faces), tuple(edges), _holes(faces, table), table, free_table)


Row = tuple[int, Sequence[float], Sequence[float], float, float]


def _face(index: int, shape: Any) -> tuple[Face, Row]:
    evaluator = occ("BRepAdaptor").BRepAdaptor_Surface(shape)
    types = occ("GeomAbs").GeomAbs_SurfaceType
    kind = evaluator.GetType()
    row: Row = (FREE_FORM, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.0, 0.0)
    if kind == types.GeomAbs_Plane:
        row = (PLANE, *_axis(evaluator.Plane()), 0.0, 0.0)
    elif kind == types.GeomAbs_Cylinder:
        row = (CYLINDER, *_axis(evaluator.Cylinder()), evaluator.Cylinder().Radius() * MM, 0.0)
    elif kind == types.GeomAbs_Cone:
        cone = evaluator.Cone()
        row = (CONE, *_axis(cone), cone.RefRadius() * MM, cone.SemiAngle())
    elif kind == types.GeomAbs_Sphere:
        row = (SPHERE, *_axis(evaluator.Sphere()), evaluator.Sphere().Radius() * MM, 0.0)
    elif kind == types.GeomAbs_Torus:
        torus = evaluator.Torus()
        row = (TORUS, *_axis(torus), torus.MajorRadius() * MM, torus.MinorRadius() * MM)
    turned = shape.Orientation() == occ("TopAbs").TopAbs_Orientation.TopAbs_REVERSED
    turn = (evaluator.FirstUParameter(), evaluator.LastUParameter())
    return Face(index, shape, evaluator, turned, row[0], 0.0, -1, turn), row


def _axis(surface: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Origin [m] and axis of the frame of an elementary surface."""
    frame = surface.Position()
    origin, axis = frame.Location(), frame.Direction()
    return (origin.X() * MM, origin.Y() * MM, origin.Z() * MM), (axis.X(), axis.Y(), axis.Z())


def surface_point(face: Face, u: float, v: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Point [m], both derivatives [m per parameter] and the outward unit normal at parameters of a face."""
    gp = occ("gp")
    p, du, dv = gp.gp_Pnt(), gp.gp_Vec(), gp.gp_Vec()
    face.evaluator.D1(u, v, p, du, dv)
    su = np.array([du.X(), du.Y(), du.Z()]) * MM
    sv = np.array([dv.X(), dv.Y(), dv.Z()]) * MM
    normal = np.array([su[1] * sv[2] - su[2] * sv[1], su[2] * sv[0] - su[0] * sv[2], su[0] * sv[1] - su[1] * sv[0]])
    length = math.sqrt(normal @ normal)
    normal *= (-1.0 if face.reversed else 1.0) / length if length > 0.0 else 0.0
    return np.array([p.X(), p.Y(), p.Z()]) * MM, su, sv, normal


def _sign(face: Face, table: Surfaces) -> float:
    """Whether the gradient of the signed distance points out of the material, from one inner point of the face."""
    if face.kind == FREE_FORM:
        return -1.0 if face.reversed else 1.0
    e = face.evaluator

    def inside(first: float, last: float) -> float:
        return 0.437 * max(first, -1e4) + 0.563 * min(last, 1e4)

    u = inside(e.FirstUParameter(), e.LastUParameter())
    v = inside(e.FirstVParameter(), e.LastVParameter())
    point, _, _, normal = surface_point(face, u, v)
    return float(np.sign(outside_of(table, face.index, point[None])[1][0] @ normal))


def face_normals(
    face: Face, table: Surfaces, free: Splines, edge: Any, point: FloatArray, at: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Distance of edge points from a face [m], and its outward normals there.

    Parameters
    ----------
    face, table, free : Face, Surfaces, Splines
        The face, and the tables of surfaces.
    edge : shape
        The edge.
    point, at : array
        Points of the edge [m], shape (n, 3), and their curve parameters, shape (n,).
    """
    if face.kind != FREE_FORM:
        distance, gradient = outside_of(table, face.index, point)
        return face.sign * distance, face.sign * gradient
    gap, normal = np.empty(len(point)), np.empty((len(point), 3))
    guess = face_parameters(face, edge, at)
    spline_normals(free, face.spline, face.sign, np.ascontiguousarray(point), guess, gap, normal)
    return gap, normal


def face_parameters(face: Face, edge: Any, at: FloatArray) -> FloatArray:
    """Surface parameters of edge points in a face, straight between a few of them; shape (n, 2)."""
    curve = occ("BRepAdaptor").BRepAdaptor_Curve2d(edge, face.shape)
    some = at if len(at) <= _GUESSES else np.linspace(at[0], at[-1], _GUESSES)
    values = [curve.Value(t) for t in some]
    return np.column_stack([np.interp(at, some, [v.X() for v in values]), np.interp(at, some, [v.Y() for v in values])])


def curve_points(edge: Any, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points [m] and derivatives of the curve of an edge; shapes (n, 3)."""
    gp = occ("gp")
    curve = occ("BRepAdaptor").BRepAdaptor_Curve(edge)
    point, slope = np.empty((len(at), 3)), np.empty((len(at), 3))
    p, d = gp.gp_Pnt(), gp.gp_Vec()
    for i, t in enumerate(at):
        curve.D1(t, p, d)
        point[i] = p.X(), p.Y(), p.Z()
        slope[i] = d.X(), d.Y(), d.Z()
    return point * MM, slope * MM


def edge_lines(model: Topology, points: int = 24) -> list[FloatArray]:
    """All edges of a part that a drawing shows, as polylines [m]; seams and smooth edges are left out."""
    lines = []
    line_type = occ("GeomAbs").GeomAbs_CurveType.GeomAbs_Line
    for edge in model.edges:
        if edge.kind in (CONVEX, CONCAVE):
            straight = occ("BRepAdaptor").BRepAdaptor_Curve(edge.shape).GetType() == line_type
            lines.append(curve_points(edge.shape, np.linspace(*curve_range(edge.shape), 2 if straight else points))[0])
    return lines or [np.zeros((1, 3))]


def curve_range(edge: Any) -> tuple[float, float]:
    """First and last parameter of the curve of an edge."""
    curve = occ("BRepAdaptor").BRepAdaptor_Curve(edge)
    return curve.FirstParameter(), curve.LastParameter()


def _edge(
    index: int, shape: Any, found: list[tuple[int, bool]], faces: Sequence[Face], table: Surfaces, free: Splines,
    smooth: float,
) -> Edge:  # fmt: skip
    """The kind of an edge, from its faces and the angle between their normals at five places."""
    owners = tuple(dict.fromkeys(face for face, _ in found))
    forward = found[0][1] if found else True
    if occ("BRep").BRep_Tool.Degenerated_s(shape):
        return Edge(index, shape, DEGENERATE, owners, forward, 0.0)
    if len(owners) == 1 and len(found) == 2:
        return Edge(index, shape, SEAM, owners, forward, 0.0)
    if len(owners) < 2:
        return Edge(index, shape, FREE, owners, forward, 0.0)
    if len(owners) > 2:
        return Edge(index, shape, CROWDED, owners, forward, 0.0)
    first, last = curve_range(shape)
    at = first + (last - first) * np.array([0.03, 0.27, 0.51, 0.74, 0.97])
    point, slope = curve_points(shape, at)
    n1 = face_normals(faces[owners[0]], table, free, shape, point, at)[1]
    n2 = face_normals(faces[owners[1]], table, free, shape, point, at)[1]
    angle = np.arctan2(np.linalg.norm(np.cross(n1, n2), axis=1), np.einsum("ij,ij->i", n1, n2))
    widest = int(np.argmax(angle))
    if angle[widest] < smooth:
        return Edge(index, shape, SMOOTH, owners, forward, float(angle[widest]))
    into = np.cross(n1[widest], slope[widest]) * (1.0 if forward else -1.0)
    kind = CONVEX if into @ n2[widest] < 0.0 else CONCAVE
    return Edge(index, shape, kind, owners, forward, float(angle[widest]))


def _holes(faces: Sequence[Face], table: Surfaces) -> tuple[Hole, ...]:
    """Concave cylinders that close to a full turn, from one face or from several on the same axis."""
    groups: dict[tuple[float, ...], list[Face]] = {}
    for face in faces:
        if face.kind != CYLINDER or face.sign > 0.0:
            continue
        axis, origin = table.axis[face.index], table.origin[face.index]
        axis = axis * (np.sign(axis[np.argmax(np.abs(axis))]) or 1.0)
        foot = origin - (origin @ axis) * axis
        key = tuple(np.round(np.concatenate([axis, foot * 1e3, [table.size[face.index, 0] * 1e3]]), 3) + 0.0)
        groups.setdefault(key, []).append(face)
    found = []
    for members in groups.values():
        if sum(face.turn[1] - face.turn[0] for face in members) < 2.0 * math.pi - 1e-3:
            continue
        i = members[0].index
        origin, axis = table.origin[i], table.axis[i]
        ends = [
            float((table.origin[face.index] + v * MM * table.axis[face.index] - origin) @ axis)
            for face in members for v in (face.evaluator.FirstVParameter(), face.evaluator.LastVParameter())
        ]  # fmt: skip
        found.append(
            Hole(
                tuple(face.index for face in members), float(table.size[i, 0]), tuple(origin), tuple(axis),
                tuple(origin + 0.5 * (min(ends) + max(ends)) * axis), max(ends) - min(ends),
            )
        )  # fmt: skip
    return tuple(found)
