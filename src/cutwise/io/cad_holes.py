"""Holes of a CAD part: walls of concave cylinders that close a full turn, from one face or from several.

A cylinder may be written as one, or as a free-form surface: systems that export rational splines only mean it all the
same. Whether such a surface is a cylinder, OpenCascade's own recognition says.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cutwise.io.cad_faces import Face, FloatArray, axis_of, curve_points, curve_range, surface_point
from cutwise.io.occ import MM, occ
from cutwise.maths.surfaces import CYLINDER, FREE_FORM, Surfaces

_CLOSE = 1e-7  # [m] ends of edges nearer than this are one, whatever the file says
_MOST = 0.01  # share of its radius by which two pieces of one wall may differ at the very most
_ALIKE = 1e-7  # [m] by which a free-form surface may leave the cylinder that it is taken for
_LOOKS = 65  # places of an edge of a wall at which its height is looked at

Uses = Mapping[int, Sequence[tuple[int, bool]]]  # of each edge: the faces that it bounds, and whether it runs forward


class Hole(NamedTuple):
    """A full-turn concave cylinder."""

    faces: tuple[int, ...]
    radius: float  # [m]
    origin: tuple[float, float, float]  # [m] a point of the axis
    axis: tuple[float, float, float]
    middle: tuple[float, float, float]  # [m] of the axis between both ends of the wall
    depth: float  # [m] of the wall along the axis


class _Cylinder(NamedTuple):
    """The cylinder that a face lies on."""

    origin: FloatArray  # [m] a point of the axis
    axis: FloatArray
    radius: float  # [m]


class _Side(NamedTuple):
    """One use of an edge by a face."""

    edge: int
    face: int
    forward: bool


class _Walls:
    """The concave cylinders of a part, joined where they meet and are one surface within the tolerance."""

    def __init__(
        self, faces: Sequence[Face], table: Surfaces, edges: Sequence[Any], uses: Uses, tolerance: float
    ) -> None:
        self.faces, self.edges, self.tolerance = faces, edges, tolerance
        self.wall = {face.index: wall for face in faces if (wall := _wall(face, table, tolerance)) is not None}
        self.sides = {
            edge: [_Side(edge, face, forward) for face, forward in found]
            for edge, found in uses.items() if any(face in self.wall for face, _ in found)
        }  # fmt: skip
        self._owner = {face: face for face in self.wall}
        self.borders: dict[int, list[_Side]] = {}  # of each wall face
        for found in self.sides.values():
            for side in found:
                self.borders.setdefault(side.face, []).append(side)
        self.inner: set[int] = set()  # edges between two faces of one wall, and seams
        for edge, found in self.sides.items():
            self._join(edge, found)
        self._join_apart()

    def _join(self, edge: int, found: Sequence[_Side]) -> None:
        """Join the two faces of an edge; a seam joins a face with itself."""
        if len(found) != 2 or not {found[0].face, found[1].face} <= self.wall.keys():
            return
        reach = max(self.tolerance, occ("BRep").BRep_Tool.Tolerance_s(self.edges[edge]) * MM)
        if self._same(found[0].face, found[1].face, reach):
            self.inner.add(edge)
            self._owner[self.owner(found[0].face)] = self.owner(found[1].face)

    def _join_apart(self) -> None:
        """Join faces of surfaces that were never sewn: their free edges lie on one another within the tolerance."""
        free = [edge for edge, found in self.sides.items() if len(found) == 1]
        line = {
            edge: curve_points(self.edges[edge], np.linspace(*curve_range(self.edges[edge]), 3))[0] for edge in free
        }
        reach = max(self.tolerance, _CLOSE)
        for k, first in enumerate(free):
            for second in free[k + 1 :]:
                away = min(_farthest(line[first], line[second]), _farthest(line[first], line[second][::-1]))
                faces = self.sides[first][0].face, self.sides[second][0].face
                if away <= reach and self._same(*faces, reach):
                    self.inner |= {first, second}
                    self._owner[self.owner(faces[0])] = self.owner(faces[1])

    def owner(self, face: int) -> int:
        """The face that stands for the wall to which a face belongs."""
        while self._owner[face] != face:
            face = self._owner[face]
        return face

    def _same(self, first: int, second: int, reach: float) -> bool:
        """Whether two cylinders are one within a distance, over the length of both walls."""
        if first == second:
            return True
        radius = np.array([self.wall[first].radius, self.wall[second].radius])
        if abs(radius[0] - radius[1]) > 2.0 * reach or abs(radius[0] - radius[1]) > _MOST * radius.min():
            return False
        origin, axis, _ = self.wall[first]
        for low_high in (self.ends(first), self.ends(second)):
            for end in low_high:
                arm = end - origin
                beside = arm - (arm @ axis) * axis
                if np.linalg.norm(beside) > min(2.0 * reach, _MOST * radius.min()):
                    return False
        return True

    def ends(self, face: int) -> FloatArray:
        """Both ends of the axis of a wall face [m], shape (2, 3)."""
        origin, axis, _ = self.wall[face]
        border = [(self._points(side.edge) - origin) @ axis for side in self.borders[face]]
        height = np.array([-max(_highest(-along) for along in border), max(_highest(along) for along in border)])
        return np.asarray(origin + height[:, None] * axis)

    def _points(self, edge: int) -> FloatArray:
        """Points along an edge [m], shape (k, 3)."""
        return curve_points(self.edges[edge], np.linspace(*curve_range(self.edges[edge]), _LOOKS))[0]

    def closes(self, members: set[int]) -> bool:
        """Whether the border of a wall runs once round its axis, so that the wall does.

        The angle about the axis is followed along all border edges; where two ways to a corner give angles that
        differ by a turn, the border has gone round.
        """
        axis = self.wall[min(members)].axis
        corners = _Corners(max(self.tolerance, _CLOSE))
        steps: dict[int, list[tuple[int, float]]] = {}
        for side in (side for face in sorted(members) for side in self.borders.get(face, ())):
            if side.edge in self.inner:
                continue
            turn = self._turn(side) * math.copysign(1.0, float(axis @ self.wall[side.face].axis))
            ends = curve_points(self.edges[side.edge], np.array(curve_range(self.edges[side.edge])))[0]
            a, b = corners.number(ends[0]), corners.number(ends[1])
            if a == b and abs(turn) > math.pi:
                return True
            steps.setdefault(a, []).append((b, turn))
            steps.setdefault(b, []).append((a, -turn))
        return _goes_round(steps)

    def _turn(self, side: _Side) -> float:
        """Angle about the axis of its face through which an edge runs, along its curve [rad]."""
        if self.faces[side.face].kind == FREE_FORM:
            origin, axis, _ = self.wall[side.face]
            x = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
            arm = self._points(side.edge) - origin
            angle = np.unwrap(np.arctan2(arm @ np.cross(axis, x), arm @ x))
            return float(angle[-1] - angle[0])
        flat = occ("BRepAdaptor").BRepAdaptor_Curve2d(self.edges[side.edge], self.faces[side.face].shape)
        return float(flat.Value(flat.LastParameter()).X() - flat.Value(flat.FirstParameter()).X())


def _wall(face: Face, table: Surfaces, tolerance: float) -> _Cylinder | None:
    """The cylinder of a concave face, also of one that is written as a free-form surface; None if it is none."""
    if face.kind == CYLINDER:
        return (
            _Cylinder(table.origin[face.index], table.axis[face.index], float(table.size[face.index, 0]))
            if face.sign < 0.0
            else None
        )
    if face.kind != FREE_FORM:
        return None
    surface = occ("BRep").BRep_Tool.Surface_s(face.shape)
    near = max(_ALIKE, tolerance) / MM
    found = occ("ShapeCustom").ShapeCustom_Surface(surface).ConvertToAnalytical(near, False)
    if not isinstance(found, occ("Geom").Geom_CylindricalSurface):
        return None
    origin, axis = axis_of(found.Cylinder())
    wall = _Cylinder(np.array(origin), np.array(axis), found.Radius() * MM)
    e = face.evaluator
    point, _, _, normal = surface_point(
        face, 0.437 * e.FirstUParameter() + 0.563 * e.LastUParameter(),
        0.437 * e.FirstVParameter() + 0.563 * e.LastVParameter(),
    )  # fmt: skip
    return wall if (point - wall.origin) @ normal < 0.0 else None  # the air is inside


class _Corners:
    """Ends of edges by number; ends that are nearer than a tolerance are one."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance, self.points = tolerance, np.zeros((0, 3))

    def number(self, point: FloatArray) -> int:
        near = np.flatnonzero(np.linalg.norm(self.points - point, axis=1) <= self.tolerance)
        if near.size:
            return int(near[0])
        self.points = np.vstack([self.points, point])
        return len(self.points) - 1


def _highest(value: FloatArray) -> float:
    """The largest of values along a curve, between them by a parabola through the largest and its neighbours."""
    k = int(value.argmax())
    if k in (0, len(value) - 1):
        return float(value[k])
    before, top, after = value[k - 1 : k + 2]
    bend = before - 2.0 * top + after
    return float(top - (after - before) ** 2 / (8.0 * bend)) if bend < 0.0 else float(top)


def _farthest(first: FloatArray, second: FloatArray) -> float:
    return float(np.linalg.norm(first - second, axis=1).max())


def _goes_round(steps: Mapping[int, Sequence[tuple[int, float]]]) -> bool:
    """Whether angles that are followed from corner to corner come back with another turn."""
    angle: dict[int, float] = {}
    for start in steps:
        if start in angle:
            continue
        angle[start], waiting = 0.0, [start]
        while waiting:
            corner = waiting.pop()
            for other, turn in steps[corner]:
                if other not in angle:
                    angle[other] = angle[corner] + turn
                    waiting.append(other)
                elif abs(angle[corner] + turn - angle[other]) > math.pi:
                    return True
    return False


def holes(
    faces: Sequence[Face], table: Surfaces, edges: Sequence[Any], uses: Uses, tolerance: float
) -> tuple[Hole, ...]:  # fmt: skip
    """Holes of a part.

    A hole is a wall of concave cylinders on one axis with one radius that is in one piece and closed all round.
    Faces belong to one wall if they share an edge, or have free edges that lie on one another, and their axes and radii
    agree within the tolerance: that of the file, or that of the edge between them. Walls that are apart along the axis,
    such as both ears of a clevis, are holes of their own; a wall that does not close, such as a fillet or the end of a
    slot, is none.

    Parameters
    ----------
    faces, table : sequence of Face, Surfaces
        Faces, and their surfaces.
    edges : sequence of shape
        Edges.
    uses : mapping
        Of each edge the faces that it bounds.
    tolerance : float
        Of the file [m].
    """
    walls = _Walls(faces, table, edges, uses, tolerance)
    members: dict[int, set[int]] = {}
    for face in sorted(walls.wall):
        members.setdefault(walls.owner(face), set()).add(face)
    return tuple(_hole(walls, sorted(some)) for some in members.values() if walls.closes(some))


def _hole(walls: _Walls, members: Sequence[int]) -> Hole:
    origin, axis, radius = walls.wall[members[0]]
    ends = [float((end - origin) @ axis) for face in members for end in walls.ends(face)]
    middle = origin + 0.5 * (min(ends) + max(ends)) * axis
    return Hole(tuple(members), radius, tuple(origin), tuple(axis), tuple(middle), max(ends) - min(ends))
