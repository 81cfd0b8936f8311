"""Topology of a CAD part: its faces, the kind of every edge, and its holes."""

import itertools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from cutwise.io.cad_faces import Face, FloatArray, curve_points, curve_range, face_normals, face_of, outward_sign
from cutwise.io.cad_holes import Hole, holes
from cutwise.io.cad_splines import spline_surface
from cutwise.io.occ import explored, occ, shape_map
from cutwise.io.step import StepPart
from cutwise.maths.nurbs import Splines, SplineSurface, splines
from cutwise.maths.surfaces import FREE_FORM, PLANE, Surfaces, surfaces

_LOOKS = {"plane": 1, "elementary": 13, "free": 33}  # places at which the kind of an edge is looked at, by its faces
_HALVINGS = 40  # to the place where the kind of an edge changes

SMOOTH_ANGLE = math.radians(1.0)  # normals closer than this meet smoothly

FREE, SEAM, DEGENERATE, SMOOTH, CONVEX, CONCAVE, CROWDED = (
    "without face", "seam", "degenerate", "smooth", "convex", "concave", "more than two faces",
)  # fmt: skip


class Edge(NamedTuple):
    """An edge between two faces, or the piece of one over which its kind stays the same."""

    index: int  # type: ignore[assignment]
    shape: Any
    kind: str
    faces: tuple[int, ...]
    forward: bool  # whether the edge runs in the direction of its curve in the first face
    angle: float  # [rad] largest angle between the normals, at the samples looked at; 0 unless two faces
    span: tuple[float, float]  # parameters of the curve between which it runs
    whole: int  # number of the edge in the part, from 0: pieces of one edge have the same


class Topology(NamedTuple):
    """Faces and edges of a part."""

    part: StepPart
    faces: tuple[Face, ...]
    edges: tuple[Edge, ...]
    holes: tuple[Hole, ...]
    surfaces: Surfaces  # one row for each face
    splines: Splines  # one row for each free-form face

    @property
    def whole_edges(self) -> int:
        """How many edges the part has, pieces of one counted once."""
        return len({edge.whole for edge in self.edges})

    @property
    def split(self) -> tuple[tuple[Edge, ...], ...]:
        """The pieces of edges whose kind changes along them, in their order."""
        pieces: dict[int, list[Edge]] = {}
        for edge in self.edges:
            pieces.setdefault(edge.whole, []).append(edge)
        return tuple(tuple(some) for some in pieces.values() if len(some) > 1)

    @property
    def notices(self) -> tuple[str, ...]:
        """What the user should know about the part."""
        return (*self.part.notices, *(self._split_at(pieces) for pieces in self.split))

    def _split_at(self, pieces: Sequence[Edge]) -> str:
        first = pieces[0]
        names = " and ".join(self.faces[i].name for i in first.faces)
        ends = [piece.span[1] for piece in pieces[:-1]]
        places = [
            "(" + ", ".join(f"{1e3 * x + 0.0:.4g}" for x in point) + ") mm"
            for point in curve_points(first.shape, np.array(ends))[0]
        ]
        kinds = ", then ".join(piece.kind for piece in pieces)
        return f"the edge between {names} is {kinds}: it is split at {' and '.join(places)}"

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
        face, row = face_of(i, shape)
        if face.kind == FREE_FORM:
            face = face._replace(spline=len(free))
            row = (*row[:3], float(len(free)), 0.0)
            free.append(spline_surface(face.shape, face.evaluator))
        faces.append(face)
        rows.append(row)
    table = surfaces(rows)
    free_table = splines(free)
    faces = [face._replace(sign=outward_sign(face, table)) for face in faces]
    numbers = shape_map(part.shape, kinds.TopAbs_EDGE)
    places: dict[int, list[tuple[int, bool]]] = {}
    forward = occ("TopAbs").TopAbs_Orientation.TopAbs_FORWARD
    for face in faces:
        explorer = occ("TopExp").TopExp_Explorer(face.shape, kinds.TopAbs_EDGE)
        while explorer.More():
            current = explorer.Current()
            places.setdefault(numbers.FindIndex(current) - 1, []).append((face.index, current.Orientation() == forward))
            explorer.Next()
    edges: list[Edge] = []
    to_edge = occ("TopoDS").TopoDS.Edge
    shapes = [to_edge(shape.Oriented(forward)) for shape in explored(part.shape, kinds.TopAbs_EDGE)]
    for i, shape in enumerate(shapes):
        edges += _pieces(len(edges), i, shape, places.get(i, []), _Looked(faces, table, free_table, smooth))
    found = holes(faces, table, shapes, places, part.tolerance)
    return Topology(part, tuple(faces), tuple(edges), found, table, free_table)


def edge_lines(model: Topology, points: int = 24) -> list[FloatArray]:
    """All edges of a part that a drawing shows, as polylines [m]; seams and smooth edges are left out."""
    lines = []
    line_type = occ("GeomAbs").GeomAbs_CurveType.GeomAbs_Line
    for edge in model.edges:
        if edge.kind in (CONVEX, CONCAVE):
            straight = occ("BRepAdaptor").BRepAdaptor_Curve(edge.shape).GetType() == line_type
            lines.append(curve_points(edge.shape, np.linspace(*edge.span, 2 if straight else points))[0])
    return lines or [np.zeros((1, 3))]


class _Looked(NamedTuple):
    """What the kind of an edge is found with."""

    faces: Sequence[Face]
    table: Surfaces
    free: Splines
    smooth: float

    def bend(self, shape: Any, owners: Sequence[int], forward: bool, at: FloatArray) -> FloatArray:
        """Angle from the normal of the first face to that of the second, positive where the edge is convex [rad]."""
        point, slope = curve_points(shape, at)
        n1 = face_normals(self.faces[owners[0]], self.table, self.free, shape, point, at)[1]
        n2 = face_normals(self.faces[owners[1]], self.table, self.free, shape, point, at)[1]
        angle = np.arctan2(np.linalg.norm(np.cross(n1, n2), axis=1), np.einsum("ij,ij->i", n1, n2))
        into = np.cross(n1, slope) * (1.0 if forward else -1.0)
        return np.asarray(np.where(np.einsum("ij,ij->i", into, n2) < 0.0, angle, -angle))

    def places(self, owners: Sequence[int], span: tuple[float, float]) -> FloatArray:
        """Parameters of an edge at which to look: one will do between planes."""
        kinds = {self.faces[i].kind for i in owners}
        count = _LOOKS["plane" if kinds == {PLANE} else "free" if FREE_FORM in kinds else "elementary"]
        share = np.linspace(0.03, 0.97, count) if count > 1 else np.array([0.51])
        return np.asarray(span[0] + (span[1] - span[0]) * share)


def _pieces(
    first: int, whole: int, shape: Any, found: Sequence[tuple[int, bool]], looked: _Looked
) -> list[Edge]:  # fmt: skip
    """An edge by its kind, from its faces and the angle between their normals; split where the kind changes.

    An edge that is convex in one place and concave in another passes through tangency, where it is split. An edge that
    only fades into tangency stays whole.
    """
    owners = tuple(dict.fromkeys(face for face, _ in found))
    forward = found[0][1] if found else True
    if occ("BRep").BRep_Tool.Degenerated_s(shape):
        return [Edge(first, shape, DEGENERATE, owners, forward, 0.0, (0.0, 0.0), whole)]
    span = curve_range(shape)
    if len(owners) != 2:
        seam = len(owners) == 1 and len(found) == 2
        kind = SEAM if seam else FREE if len(owners) < 2 else CROWDED
        return [Edge(first, shape, kind, owners, forward, 0.0, span, whole)]
    at = looked.places(owners, span)
    bend = looked.bend(shape, owners, forward, at)
    sharp = np.flatnonzero(np.abs(bend) >= looked.smooth)
    if not sharp.size:
        return [Edge(first, shape, SMOOTH, owners, forward, float(np.abs(bend).max()), span, whole)]
    cuts, kinds = [span[0]], [bool(bend[sharp[0]] > 0.0)]
    for a, b in itertools.pairwise(sharp):
        if (bend[a] > 0.0) != (bend[b] > 0.0):
            cuts.append(_turns(looked, shape, owners, forward, float(at[a]), float(at[b])))
            kinds.append(bool(bend[b] > 0.0))
    pieces = []
    for k, (low, high) in enumerate(itertools.pairwise([*cuts, span[1]])):
        angle = float(np.abs(bend[(at >= low) & (at <= high)]).max())
        pieces.append(
            Edge(first + k, shape, CONVEX if kinds[k] else CONCAVE, owners, forward, angle, (low, high), whole)
        )
    return pieces


def _turns(looked: _Looked, shape: Any, owners: Sequence[int], forward: bool, low: float, high: float) -> float:
    """The parameter, between two at which an edge is of different kinds, at which its faces are tangent."""
    convex = looked.bend(shape, owners, forward, np.array([low]))[0] > 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (looked.bend(shape, owners, forward, np.array([middle]))[0] > 0.0) == convex:
            low = middle
        else:
            high = middle
    return low
