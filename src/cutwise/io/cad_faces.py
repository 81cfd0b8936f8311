"""Faces of a CAD part, and the curves of its edges: what OpenCascade knows of them as numbers in metres."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.io.occ import MM, occ
from cutwise.maths.nurbs import Splines, spline_normals
from cutwise.maths.surfaces import CONE, CYLINDER, FREE_FORM, PLANE, SPHERE, TORUS, Surfaces, outside_of

FloatArray = NDArray[np.float64]

_GUESSES = 33  # places of an edge at which its parameters in a face are asked for

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


Row = tuple[int, Sequence[float], Sequence[float], float, float]


def face_of(index: int, shape: Any) -> tuple[Face, Row]:
    evaluator = occ("BRepAdaptor").BRepAdaptor_Surface(shape)
    types = occ("GeomAbs").GeomAbs_SurfaceType
    kind = evaluator.GetType()
    row: Row = (FREE_FORM, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.0, 0.0)
    if kind == types.GeomAbs_Plane:
        row = (PLANE, *axis_of(evaluator.Plane()), 0.0, 0.0)
    elif kind == types.GeomAbs_Cylinder:
        row = (CYLINDER, *axis_of(evaluator.Cylinder()), evaluator.Cylinder().Radius() * MM, 0.0)
    elif kind == types.GeomAbs_Cone:
        cone = evaluator.Cone()
        row = (CONE, *axis_of(cone), cone.RefRadius() * MM, cone.SemiAngle())
    elif kind == types.GeomAbs_Sphere:
        row = (SPHERE, *axis_of(evaluator.Sphere()), evaluator.Sphere().Radius() * MM, 0.0)
    elif kind == types.GeomAbs_Torus:
        torus = evaluator.Torus()
        row = (TORUS, *axis_of(torus), torus.MajorRadius() * MM, torus.MinorRadius() * MM)
    turned = shape.Orientation() == occ("TopAbs").TopAbs_Orientation.TopAbs_REVERSED
    turn = (evaluator.FirstUParameter(), evaluator.LastUParameter())
    return Face(index, shape, evaluator, turned, row[0], 0.0, -1, turn), row


def axis_of(surface: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
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


def outward_sign(face: Face, table: Surfaces) -> float:
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
    curve = occ("BRepAdaptor").BRepAdaptor_Curve(edge)
    types = occ("GeomAbs").GeomAbs_CurveType
    if curve.GetType() == types.GeomAbs_Line:
        line = curve.Line()
        along = _vector(line.Direction())
        return (_vector(line.Location()) + at[:, None] * along) * MM, np.tile(along, (len(at), 1)) * MM
    if curve.GetType() == types.GeomAbs_Circle:
        circle = curve.Circle()
        frame, size = circle.Position(), circle.Radius()
        cosine, sine = size * np.cos(at)[:, None], size * np.sin(at)[:, None]
        x, y = _vector(frame.XDirection()), _vector(frame.YDirection())
        return (_vector(circle.Location()) + cosine * x + sine * y) * MM, (cosine * y - sine * x) * MM
    gp = occ("gp")
    point, slope = np.empty((len(at), 3)), np.empty((len(at), 3))
    p, d = gp.gp_Pnt(), gp.gp_Vec()
    for i, t in enumerate(at):
        curve.D1(t, p, d)
        point[i] = p.X(), p.Y(), p.Z()
        slope[i] = d.X(), d.Y(), d.Z()
    return point * MM, slope * MM


def _vector(of: Any) -> FloatArray:
    return np.array([of.X(), of.Y(), of.Z()])


def curve_range(edge: Any) -> tuple[float, float]:
    """First and last parameter of the curve of an edge."""
    curve = occ("BRepAdaptor").BRepAdaptor_Curve(edge)
    return curve.FirstParameter(), curve.LastParameter()
