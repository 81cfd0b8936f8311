"""Points and outward normals of the exact faces of a STEP part, evenly over their area."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.io.cad_faces import Face, face_of
from cutwise.io.occ import MM, CadFault, explored, occ
from cutwise.io.solid_mesh import face_triangles, meshed, solid_of
from cutwise.io.step import read_step
from cutwise.maths.rays import lattice
from cutwise.maths.surfaces import CONE, CYLINDER, FREE_FORM, PLANE, SPHERE, TORUS

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_GOLDEN = (0.7548776662466927, 0.5698402909980532)  # of the R2 sequence: even points in a square


class Samples(NamedTuple):
    """Points of a part's surface."""

    point: FloatArray  # [m], shape (n, 3)
    normal: FloatArray  # outward, shape (n, 3)
    weight: FloatArray  # area that each stands for [m^2], shape (n,)
    face: IntArray  # from 0, shape (n,)
    names: tuple[str, ...]  # of the faces
    area: FloatArray  # of each face [m^2]
    step: float  # distance of the points, about [m]
    notices: tuple[str, ...]  # what the file says that one should know


def part_samples(file: str | Path, solid: int | None, count: int, chord: float) -> Samples:
    """About ``count`` points of the faces of a solid.

    Parameters
    ----------
    file : str or Path
        STEP file.
    solid : int or None
        Which solid, from 1.
    count : int
        Points.
    chord : float
        Distance of the triangles that follow the outlines of faces [m].

    Raises
    ------
    CadFault
        The file or its solid cannot be used.
    """
    part = read_step(file)
    shape = solid_of(part, solid)
    meshed(shape, chord)
    found = []
    for i, face_shape in enumerate(explored(shape, occ("TopAbs").TopAbs_ShapeEnum.TopAbs_FACE)):
        found.append((face_of(i, face_shape)[0], *face_triangles(face_shape), _area(face_shape)))
    areas = np.array([one[4] for one in found])
    if not areas.sum() > 0.0:
        raise CadFault(f"{part.name}: its faces have no area")
    step = math.sqrt(float(areas.sum()) / count)
    parts = [_face_points(*one[:4], step) for one in found]
    weights = []
    for (_, _, raw), area in zip(parts, areas, strict=True):
        total = raw.sum()
        weights.append(raw * (area / total) if total > 0.0 else raw)
    return Samples(
        np.concatenate([p for p, _, _ in parts]), np.concatenate([n for _, n, _ in parts]), np.concatenate(weights),
        np.repeat(np.arange(len(parts)), [len(p) for p, _, _ in parts]), tuple(one[0].name for one in found), areas, step,
        part.notices,
    )  # fmt: skip


def moved(samples: Samples, origin: Sequence[float], rotation: Sequence[float]) -> Samples:
    """Samples with the CAD model turned by roll, pitch and yaw about fixed axes, then shifted [m, rad]."""
    ca, sa = np.cos(rotation), np.sin(rotation)
    roll = np.array([[1, 0, 0], [0, ca[0], -sa[0]], [0, sa[0], ca[0]]])
    pitch = np.array([[ca[1], 0, sa[1]], [0, 1, 0], [-sa[1], 0, ca[1]]])
    yaw = np.array([[ca[2], -sa[2], 0], [sa[2], ca[2], 0], [0, 0, 1]])
    turn = yaw @ pitch @ roll
    if not np.any(rotation):
        return samples._replace(point=samples.point + np.asarray(origin))
    return samples._replace(point=samples.point @ turn.T + np.asarray(origin), normal=samples.normal @ turn.T)


def _area(face: Any) -> float:
    """Exact area of a face [m^2]."""
    found = occ("GProp").GProp_GProps()
    occ("BRepGProp").BRepGProp.SurfaceProperties_s(face, found)
    return float(found.Mass()) * MM**2


def _face_points(
    face: Face, node: FloatArray, index: IntArray, parameter: FloatArray | None, step: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points, outward normals and weights of a face; at least one point of every triangle that is not tiny."""
    if not len(index):
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    if parameter is not None and face.kind != FREE_FORM:
        even = _even_points(face, parameter[index], step)
        if len(even[2]):
            return even
    corner = node[index]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    share = 0.5 * np.linalg.norm(cross, axis=1) / step**2
    ends = np.floor(np.cumsum(share) + 0.5).astype(np.int64)
    if ends[-1] == 0:
        ends[int(np.argmax(share)) :] = 1
    count = np.diff(ends, prepend=0)
    which = np.repeat(np.arange(len(index)), count)
    number = np.arange(which.size) + 1
    u, v = (number * _GOLDEN[0]) % 1.0, (number * _GOLDEN[1]) % 1.0
    beyond = u + v > 1.0
    u, v = np.where(beyond, 1.0 - u, u), np.where(beyond, 1.0 - v, v)
    mix = np.column_stack([1.0 - u - v, u, v])
    if parameter is None:
        length = np.linalg.norm(cross, axis=1, keepdims=True)
        flat = np.einsum("ni,nij->nj", mix, corner[which])
        return flat, (cross / np.where(length > 0.0, length, 1.0))[which], np.ones(which.size)
    spot = parameter[index]
    at = np.einsum("ni,nij->nj", mix, spot[which])
    sides = spot[:, 1] - spot[:, 0], spot[:, 2] - spot[:, 0]
    flat_area = 0.5 * np.abs(sides[0][:, 0] * sides[1][:, 1] - sides[0][:, 1] * sides[1][:, 0])
    point, along, across = _surface(face, at)
    normal = np.cross(along, across)
    length = np.linalg.norm(normal, axis=1)
    weight = length * (flat_area / np.maximum(count, 1))[which]
    sound = length > 0.0
    unit = normal[sound] / length[sound, None] * (-1.0 if face.reversed else 1.0)
    return point[sound], unit, weight[sound]


def _even_points(face: Face, corner: FloatArray, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points of an elementary face on a lattice of its parameters: a rim gets its share, however thin the triangles."""
    _, along, across = _surface(face, corner.mean(axis=1))
    du, dv = (step / max(MM * float(np.linalg.norm(d, axis=1).mean()), 1e-12) for d in (along, across))
    point, along, across = _surface(face, lattice(corner, du, dv))
    normal = np.cross(along, across)
    length = np.linalg.norm(normal, axis=1)
    sound = length > 0.0
    return point[sound], normal[sound] / length[sound, None] * (-1.0 if face.reversed else 1.0), length[sound]


def _surface(face: Face, at: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points [m] and both derivatives of a face at parameters: elementary ones in closed form, others by OpenCascade."""
    e = face.evaluator
    u, v = at[:, :1], at[:, 1:]
    if face.kind == PLANE:
        o, x, y, _ = _frame(e.Plane())
        return o + MM * (u * x + v * y), np.broadcast_to(x, (len(at), 3)), np.broadcast_to(y, (len(at), 3))
    if face.kind in (CYLINDER, CONE):
        body = e.Cylinder() if face.kind == CYLINDER else e.Cone()
        o, x, y, z = _frame(body)
        radius, lean = (body.Radius(), 0.0) if face.kind == CYLINDER else (body.RefRadius(), body.SemiAngle())
        out, round_ = np.cos(u) * x + np.sin(u) * y, np.cos(u) * y - np.sin(u) * x
        r = radius + v * math.sin(lean)
        return (
            o + MM * (r * out + v * math.cos(lean) * z), r * round_,
            math.sin(lean) * out + math.cos(lean) * np.broadcast_to(z, out.shape),
        )  # fmt: skip
    if face.kind == SPHERE:
        o, x, y, z = _frame(e.Sphere())
        r = e.Sphere().Radius()
        out, round_ = np.cos(u) * x + np.sin(u) * y, np.cos(u) * y - np.sin(u) * x
        return (
            o + MM * r * (np.cos(v) * out + np.sin(v) * z),
            r * np.cos(v) * round_,
            r * (np.cos(v) * z - np.sin(v) * out),
        )
    if face.kind == TORUS:
        o, x, y, z = _frame(e.Torus())
        major, minor = e.Torus().MajorRadius(), e.Torus().MinorRadius()
        out, round_ = np.cos(u) * x + np.sin(u) * y, np.cos(u) * y - np.sin(u) * x
        r = major + minor * np.cos(v)
        return o + MM * (r * out + minor * np.sin(v) * z), r * round_, minor * (np.cos(v) * z - np.sin(v) * out)
    point, along, across = np.empty((len(at), 3)), np.empty((len(at), 3)), np.empty((len(at), 3))
    gp = occ("gp")
    p, du, dv = gp.gp_Pnt(), gp.gp_Vec(), gp.gp_Vec()
    ask = e.D1
    for i, (a, b) in enumerate(at.tolist()):
        ask(a, b, p, du, dv)
        point[i] = p.X(), p.Y(), p.Z()
        along[i] = du.X(), du.Y(), du.Z()
        across[i] = dv.X(), dv.Y(), dv.Z()
    return point * MM, along, across


def _frame(body: Any) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Origin [m] and axes of an elementary surface."""
    frame = body.Position()
    axes = [np.array([d.X(), d.Y(), d.Z()]) for d in (frame.XDirection(), frame.YDirection(), frame.Direction())]
    origin = frame.Location()
    return np.array([origin.X(), origin.Y(), origin.Z()]) * MM, axes[0], axes[1], axes[2]
