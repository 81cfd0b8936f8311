"""All surfaces of a drilled pipe as a mesh: what a tool must not cut or touch.

The faces end where others begin, in closed form: the wall of the hole between both cylinders, the cylinders where
there is no hole. The pipe has no ends, and the drill stops at the axis of the pipe.
"""

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.nurbs import splines
from cutwise.maths.surface_mesh import Faces, SurfaceMesh
from cutwise.maths.surfaces import CYLINDER, PLANE, surfaces
from cutwise.paths.pipe import PipeHole

OUTSIDE, BORE, HOLE_WALL, FAR_OUTSIDE, FAR_BORE = range(5)  # faces; the far ones are beyond the axis of the pipe
_HALF_WAY = 5  # the plane through the pipe axis, square to the drill
_ROUND = 24  # pieces round a cylinder


def own_faces(*, inner: bool) -> tuple[int, int]:
    """The two faces that meet in an edge, in the order of its frames.

    Examples
    --------
    >>> own_faces(inner=True) == (BORE, HOLE_WALL)
    True
    """
    return (BORE if inner else OUTSIDE), HOLE_WALL


def pipe_mesh(part: PipeHole, reach: float) -> SurfaceMesh:
    """SurfaceMesh of a drilled pipe up to a distance from the hole along the pipe [m]."""
    axis, foot = part.drill_axis, np.array([part.eccentricity, 0.0, 0.0])
    along_pipe = (0.0, 1.0, 0.0)
    bore = part.radius - part.wall
    table = surfaces([
        (CYLINDER, (0.0, 0.0, 0.0), along_pipe, part.radius, 0.0), (CYLINDER, (0.0, 0.0, 0.0), along_pipe, bore, 0.0),
        (CYLINDER, tuple(foot), tuple(axis), part.hole_radius, 0.0),
        (CYLINDER, (0.0, 0.0, 0.0), along_pipe, part.radius, 0.0), (CYLINDER, (0.0, 0.0, 0.0), along_pipe, bore, 0.0),
        (PLANE, (0.0, 0.0, 0.0), tuple(axis), 0.0, 0.0),
    ])  # fmt: skip
    limit = np.array([
        (OUTSIDE, HOLE_WALL, 1.0), (OUTSIDE, _HALF_WAY, 1.0), (BORE, HOLE_WALL, 1.0), (BORE, _HALF_WAY, 1.0),
        (HOLE_WALL, OUTSIDE, -1.0), (HOLE_WALL, BORE, 1.0), (HOLE_WALL, _HALF_WAY, 1.0),
        (FAR_OUTSIDE, _HALF_WAY, -1.0), (FAR_BORE, _HALF_WAY, -1.0),
    ])  # fmt: skip
    limit = np.column_stack([limit, np.full(len(limit), np.inf)])
    middle = part.radius * np.array([0.0, np.tan(part.inclination), 1.0])  # about where the drill enters
    half = part.hole_radius / np.cos(part.inclination) + part.radius * abs(np.tan(part.inclination)) + reach
    steps = np.linspace(middle[1] - half, middle[1] + half, 33)
    pieces, faces = [], []
    for radius, near, far in ((part.radius, OUTSIDE, FAR_OUTSIDE), (bore, BORE, FAR_BORE)):
        psi = np.linspace(0.0, 2.0 * np.pi, _ROUND + 1)[:, None]
        grid = np.stack(np.broadcast_arrays(radius * np.sin(psi), steps, radius * np.cos(psi)), axis=-1)
        for face in (near, far):
            pieces.append(_triangles(grid))
            faces.append(np.full(len(pieces[-1]), face))
    theta = np.linspace(0.0, 2.0 * np.pi, _ROUND + 1)[:, None, None]
    e2 = np.array([0.0, axis[2], -axis[1]])
    depth = np.linspace(0.0, 1.0, 9)[None, :, None] * (part.radius + half) / axis[2]
    wall = foot + part.hole_radius * (np.cos(theta) * np.eye(3)[0] + np.sin(theta) * e2) + depth * axis
    pieces.append(_triangles(wall))
    faces.append(np.full(len(pieces[-1]), HOLE_WALL))
    corner = np.concatenate(pieces)
    return SurfaceMesh(
        np.ascontiguousarray(np.hstack([corner, np.zeros((len(corner), 6))])), np.concatenate(faces).astype(np.int64),
        Faces(table, splines([]), limit), 0.0,
    )  # fmt: skip


def _triangles(grid: FloatArray) -> FloatArray:
    """Two triangles for each mesh of a grid of points (m, n, 3); shape (k, 9)."""
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    both = [np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)]
    return np.concatenate([one.reshape(-1, 9) for one in both])
