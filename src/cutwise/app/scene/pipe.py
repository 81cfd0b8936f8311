"""The drilled half of a pipe as triangles: outside, bore and the wall of the hole, between the edges of the hole."""

import numpy as np

from cutwise.app.scene.scene import FloatArray, Surface
from cutwise.app.scene.shapes import band, welded

_ROWS = 16  # between the edge of the hole and the ends of the pipe
NAMES = {1: "the outside of the pipe", 2: "the bore of the pipe", 3: "the wall of the hole"}


def pipe(outer: FloatArray, inner: FloatArray, radius: float, wall: float, ends: tuple[float, float]) -> Surface:
    """A pipe along y with the middle of its hole on top.

    Parameters
    ----------
    outer, inner : array, shape (n, 3)
        Both edges of the hole, point by point at the same angle about the drill axis, closed [m].
    radius, wall : float
        Outer radius and wall thickness [m].
    ends : tuple
        y where the pipe is cut off [m].
    """
    pieces = [
        band(_unrolled(outer, radius, ends)),
        band(_unrolled(inner, radius - wall, ends)),
        band([outer, inner]),
    ]
    points, corners, faces, before = [], [], [], 0
    for number, (point, corner) in zip(NAMES, pieces, strict=True):
        points.append(point)
        corners.append(corner + before)
        faces.append(np.full(len(corner), number, np.int64))
        before += len(point)
    point, corner = welded(np.concatenate(points), np.concatenate(corners))
    return Surface("part", point, corner, "part", face=np.concatenate(faces), names=NAMES)


def _unrolled(edge: FloatArray, radius: float, ends: tuple[float, float]) -> list[FloatArray]:
    """Lines on a cylinder from the edge of the hole out to half way round and to both ends.

    Examples
    --------
    >>> turn = np.linspace(0.0, 2.0 * np.pi, 5)
    >>> edge = np.column_stack([np.sin(0.1 * np.cos(turn)), 0.1 * np.sin(turn), np.cos(0.1 * np.cos(turn))])
    >>> rows = _unrolled(edge, 1.0, (-2.0, 2.0))
    >>> np.allclose([np.hypot(row[:, 0], row[:, 2]) for row in rows], 1.0), np.allclose(rows[0], edge)
    (True, True)
    >>> rows[-1][1, 1].round(9), rows[-1][0].round(9).tolist()
    (np.float64(2.0), [1.0, 0.0, 0.0])
    """
    flat = np.column_stack([radius * np.arctan2(edge[:, 0], edge[:, 2]), edge[:, 1]])
    centre = 0.5 * (flat.min(axis=0) + flat.max(axis=0))
    away = flat - centre
    low, high = np.array([-0.5 * np.pi * radius, ends[0]]), np.array([0.5 * np.pi * radius, ends[1]])
    room = np.where(away > 0.0, high - centre, low - centre)
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.where(np.abs(away) > 1e-12, room / away, np.inf).min(axis=1)
    border = centre + times[:, None] * away
    rows = [flat + share * (border - flat) for share in np.linspace(0.0, 1.0, _ROWS)]
    return [
        np.column_stack([radius * np.sin(row[:, 0] / radius), row[:, 1], radius * np.cos(row[:, 0] / radius)])
        for row in rows
    ]
