r"""What a ball leaves of an edge: measured on the true surfaces by taking away the sweep of its path.

Nothing here knows how the path was constructed. A point is gone if it is closer than the ball radius to the centre
polyline; the borders of the chamfer are where that distance equals the radius, found by bisection along the section
of each surface with the normal plane of the edge. Gouges and rod contacts are looked for on clouds of surface points.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames
from cutwise.maths.surfaces import section_height

_BISECTIONS = 45
_SCAN = 24  # steps in which the border is bracketed
GOUGE_BAND = 1.02  # gouges are looked for beyond this multiple of the longest leg
GOUGE_MARGIN = 3e-6  # [m] added to that


class SweptChamfer(NamedTuple):
    """The chamfer found at each sample of an edge; NaN where a border was not found."""

    width: FloatArray  # [m] chord between the borders, shape (n,)
    leg: FloatArray  # [m] distance of the borders from the edge, shape (n, 2)
    border: FloatArray  # [m], shape (n, 2, 3)


def swept_chamfer(
    frames: EdgeFrames, centre: FloatArray, ball_radius: float, reach: float, *, closed: bool
) -> SweptChamfer:
    """Measure the chamfer that a ball leaves.

    Parameters
    ----------
    frames : EdgeFrames
        Where to measure: use samples between the path points.
    centre : array
        Centre path [m], shape (m, 3); straight between its points.
    ball_radius : float
        Ball radius [m].
    reach : float
        Farthest distance from the edge at which a border is looked for [m].
    closed : bool
        Whether the path runs back to its first point.
    """
    loop = np.vstack([centre, centre[:1]]) if closed else centre
    loop = np.ascontiguousarray(loop)
    longest = float(np.linalg.norm(np.diff(loop, axis=0), axis=1).max()) if len(loop) > 1 else 0.0
    starts = KDTree(loop[:-1]).query_ball_point(frames.point, ball_radius + reach + longest)
    near = np.concatenate([np.asarray(s, np.int64) for s in starts]) if len(starts) else np.zeros(0, np.int64)
    ends = np.cumsum([0, *map(len, starts)])
    border = np.full((len(frames.point), 2, 3), np.nan)
    _find_borders(frames, loop, near, ends, ball_radius, reach, border)
    width = np.linalg.norm(border[:, 0] - border[:, 1], axis=1)
    leg = np.linalg.norm(border - frames.point[:, None, :], axis=2)
    return SweptChamfer(width, leg, border)


@compiled
def segment_distance_squared(loop: FloatArray, j: int, x: float, y: float, z: float) -> float:
    """Squared distance of a point from segment j of a polyline."""
    ax, ay, az = loop[j, 0], loop[j, 1], loop[j, 2]
    dx, dy, dz = loop[j + 1, 0] - ax, loop[j + 1, 1] - ay, loop[j + 1, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    length = dx * dx + dy * dy + dz * dz
    s = 0.0
    if length > 0.0:
        s = min(1.0, max(0.0, (px * dx + py * dy + pz * dz) / length))
    px, py, pz = px - s * dx, py - s * dy, pz - s * dz
    return px * px + py * py + pz * pz


@compiled
def _distance(loop: FloatArray, near: FloatArray, start: int, end: int, x: float, y: float, z: float) -> float:
    best = math.inf
    for k in range(start, end):
        d = segment_distance_squared(loop, near[k], x, y, z)
        if d < best:
            best = d
    return math.sqrt(best)


@compiled
def _find_borders(
    frames: EdgeFrames, loop: FloatArray, near: FloatArray, ends: FloatArray, ball_radius: float, reach: float,
    border: FloatArray,
) -> None:  # fmt: skip
    """Bisection for the border of the removed part on both section curves of every sample."""
    for i in range(frames.point.shape[0]):
        point = frames.point[i]
        if _distance(loop, near, ends[i], ends[i + 1], point[0], point[1], point[2]) >= ball_radius:
            continue  # the edge itself still stands
        for m in range(2):
            u, n = frames.into[i, m], frames.normal[i, m]
            low = 0.0
            high = math.nan
            g = 0.0
            for k in range(1, _SCAN + 1):
                a = reach * k / _SCAN
                g, _ = section_height(frames.surfaces, frames.face[i, m], frames.section[i, m], point, u, n, a, g)
                if not math.isfinite(g):
                    break
                x, y, z = point[0] + a * u[0] + g * n[0], point[1] + a * u[1] + g * n[1], point[2] + a * u[2] + g * n[2]
                if _distance(loop, near, ends[i], ends[i + 1], x, y, z) >= ball_radius:
                    high = a
                    break
                low = a
            if not math.isfinite(high):
                continue
            for _ in range(_BISECTIONS):
                a = 0.5 * (low + high)
                g, _ = section_height(frames.surfaces, frames.face[i, m], frames.section[i, m], point, u, n, a, g)
                x, y, z = point[0] + a * u[0] + g * n[0], point[1] + a * u[1] + g * n[1], point[2] + a * u[2] + g * n[2]
                if _distance(loop, near, ends[i], ends[i + 1], x, y, z) >= ball_radius:
                    high = a
                else:
                    low = a
            border[i, m, 0], border[i, m, 1], border[i, m, 2] = x, y, z


class Gouge(NamedTuple):
    """Deepest cut into the part beyond the chamfer."""

    depth: float  # [m], negative: the closest that the ball comes
    place: FloatArray  # [m] the surface point, shape (3,)


def gouge(
    cloud: FloatArray, edge: FloatArray, centre: FloatArray, ball_radius: float, longest_leg: float, *,
    closed: bool, band: float = GOUGE_MARGIN,
) -> Gouge:  # fmt: skip
    r"""Deepest gouge on a cloud of surface points, :math:`\max(R_B - \operatorname{dist}(p, path))` [m].

    Points nearer to the edge than 1.02 times the longest leg plus ``band`` belong to the chamfer and are left out.

    Parameters
    ----------
    cloud : array
        Points on the surfaces of the part [m], shape (p, 3).
    edge, centre : array
        Edge polyline and centre path [m], shapes (n, 3) and (m, 3).
    ball_radius, longest_leg : float
        [m].
    closed : bool
        Whether edge and path run back to their first points.
    band : float
        Added to the band of the chamfer [m]: the error of the cloud.
    """
    if not len(cloud):
        return Gouge(-math.inf, np.full(3, np.nan))
    path = np.ascontiguousarray(np.vstack([centre, centre[:1]]) if closed else centre)
    step = float(np.linalg.norm(np.diff(path, axis=0), axis=1).max()) if len(path) > 1 else 0.0
    rough, _ = KDTree(path).query(cloud)
    near = cloud[rough < min(rough.min() + 2.0 * step, 2.0 * ball_radius) + ball_radius * 0.1]
    line = np.vstack([edge, edge[:1]]) if closed else edge
    apart, _ = KDTree(_refined(line, 0.05 * longest_leg)).query(near)
    near = np.ascontiguousarray(near[apart > GOUGE_BAND * longest_leg + band])
    if not len(near):
        return Gouge(-math.inf, np.full(3, np.nan))
    distance = distances_to(path, near)
    worst = int(np.argmin(distance))
    return Gouge(float(ball_radius - distance[worst]), near[worst])


def _refined(line: FloatArray, spacing: float) -> FloatArray:
    """A polyline with points no farther apart than a spacing."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0.0, length[-1], min(200_000, max(2, int(length[-1] / spacing) + 2)))
    return np.column_stack([np.interp(at, length, line[:, k]) for k in range(3)])


def distances_to(path: FloatArray, point: FloatArray) -> FloatArray:
    """Distances of points from an open polyline, its segments included [m]."""
    count = min(8, len(path))
    _, index = KDTree(path).query(point, k=count)
    best = np.empty(len(point))
    _nearest_segments(np.ascontiguousarray(path), np.ascontiguousarray(index.reshape(len(point), count)), point, best)
    return best


@compiled
def _nearest_segments(path: FloatArray, index: FloatArray, point: FloatArray, best: FloatArray) -> None:
    for i in range(point.shape[0]):
        low = math.inf
        for k in range(index.shape[1]):
            for j in (index[i, k] - 1, index[i, k]):
                if 0 <= j < path.shape[0] - 1:
                    low = min(low, segment_distance_squared(path, j, point[i, 0], point[i, 1], point[i, 2]))
        best[i] = math.sqrt(low)


def rod_clearance(
    cloud: FloatArray, centre: FloatArray, axis: FloatArray, ball_radius: float, rod_radius: float,
    rod_length: float = 0.06,
) -> float | None:  # fmt: skip
    r"""Smallest distance between the rod and a cloud of surface points [m]; None where no point is beside the rod.

    The rod is a cylinder from each ball centre along the tool axis; points inside the ball belong to the chamfer and
    are left out. Negative: the rod is inside the part.

    Parameters
    ----------
    cloud, centre : array
        Surface points and ball centres [m].
    axis : array
        Unit vector from the ball along the rod, shape (3,).
    ball_radius, rod_radius, rod_length : float
        [m].
    """
    least = _least_rod_distance(
        np.ascontiguousarray(cloud), np.ascontiguousarray(centre), np.ascontiguousarray(axis), ball_radius, rod_length
    )
    return None if math.isinf(least) else float(least - rod_radius)


@compiled
def _least_rod_distance(
    cloud: FloatArray, centre: FloatArray, axis: FloatArray, ball_radius: float, rod_length: float
) -> float:
    best = math.inf
    for j in range(centre.shape[0]):
        for i in range(cloud.shape[0]):
            qx, qy, qz = cloud[i, 0] - centre[j, 0], cloud[i, 1] - centre[j, 1], cloud[i, 2] - centre[j, 2]
            h = qx * axis[0] + qy * axis[1] + qz * axis[2]
            if h <= 0.0 or h > rod_length:
                continue
            square = qx * qx + qy * qy + qz * qz
            across = square - h * h
            if across < best and square > ball_radius * ball_radius:
                best = across
    return math.sqrt(max(0.0, best))
