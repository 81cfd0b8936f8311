"""Simple bodies as triangles: boxes, bands along a line, profiles of tools."""

import numpy as np

from cutwise.app.scene.scene import FloatArray, IntArray, Surface, Tool

_BOX = np.array([
    (0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4),
    (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5),
])  # fmt: skip


def box(title: str, low: FloatArray, high: FloatArray, tint: str = "work") -> Surface:
    """A block between two corners [m].

    Examples
    --------
    >>> box("", np.zeros(3), np.ones(3)).triangles.shape
    (12, 3)
    """
    ends = np.stack([np.asarray(low, float), np.asarray(high, float)])
    corner = np.array([[ends[x, 0], ends[y, 1], ends[z, 2]] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    return Surface(title, corner, _BOX.astype(np.int64), tint)


def band(rows: list[FloatArray]) -> tuple[FloatArray, IntArray]:
    """Triangles between lines of equally many points, one beside the other: points (rows * n, 3) and corners.

    Examples
    --------
    >>> points, corners = band([np.zeros((3, 3)), np.ones((3, 3))])
    >>> points.shape, corners.shape
    ((6, 3), (4, 3))
    """
    count, n = len(rows), len(rows[0])
    at = np.arange(count * n).reshape(count, n)
    a, b, c, d = (part.reshape(-1) for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    return np.concatenate(rows), np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)]).astype(
        np.int64
    )


def strip(rows: list[FloatArray]) -> tuple[FloatArray, IntArray]:
    """A body of three faces between four lines, with its ends; the face between the last line and the first is open.

    Examples
    --------
    >>> lines = [np.array([[0.0, y, z], [1.0, y, z]]) for y, z in ((0, 0), (1, 0), (1, 1), (0, 1))]
    >>> len(strip(lines)[1])
    10
    """
    points, corners = band(rows)
    n = len(rows[0])
    ends = [np.array([[k, n + k, 2 * n + k], [k, 2 * n + k, 3 * n + k]]) for k in (0, n - 1)]
    return points, np.concatenate([corners, *ends]).astype(np.int64)


def plate(outline: FloatArray, low: float, high: float) -> tuple[FloatArray, IntArray]:
    """A plate of an outline in x and z, seen whole from its first point, shape (n, 2), from y = low to high [m].

    Examples
    --------
    >>> plate(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), 0.0, 0.1)[1].shape
    (8, 3)
    """
    n = len(outline)
    points = np.concatenate([np.insert(outline, 1, y, axis=1) for y in (low, high)])
    k = np.arange(n)
    after = (k + 1) % n
    sides = np.concatenate([np.stack([k, after, n + k], axis=1), np.stack([after, n + after, n + k], axis=1)])
    fan = np.stack([np.zeros(n - 2, int), k[1:-1], k[2:]], axis=1)
    return points, np.concatenate([sides, fan, n + fan]).astype(np.int64)


def revolved(at: FloatArray, radius: FloatArray, sides: int = 72) -> tuple[FloatArray, IntArray]:
    """A body turned about x through places along it and radii there [m]; ``sides + 1`` points to a place.

    Examples
    --------
    >>> revolved(np.array([0.0, 1.0]), np.ones(2), 4)[0].shape
    (10, 3)
    """
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    c, s = np.cos(angle), np.sin(angle)
    return band([np.column_stack([np.full(c.size, a), r * c, r * s]) for a, r in zip(at, radius, strict=True)])


def welded(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Points that are the same to a nanometre taken for one, so that neighbouring triangles share their corners.

    Examples
    --------
    >>> welded(np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 0]]), np.array([[0, 1, 2]]))[1].tolist()
    [[0, 1, 0]]
    """
    kept, index = np.unique(np.round(points, 9), axis=0, return_inverse=True)
    return kept, index.reshape(-1)[triangles].astype(np.int64)


def cylinder(radius: float, length: float, neck: float = 0.0) -> Tool:
    """A mill of a length, and a holder above it that is wider.

    Parameters
    ----------
    radius, length : float
        Of the mill [m].
    neck : float
        Radius of what holds it [m]; 1.6 times that of the mill if left out.
    """
    wide = neck or 1.6 * radius
    return Tool(
        np.array([[0.0, 0.0], [0.0, radius], [length, radius], [length, 0.0]]),
        np.array([[length, 0.0], [length, wide], [length + 3.0 * wide, wide], [length + 3.0 * wide, 0.0]]),
    )


def ball_ended(radius: float, length: float, shaft: float) -> Tool:
    """A ball on a shaft; heights are counted from the centre of the ball [m]."""
    angle = np.linspace(-0.5 * np.pi, np.arccos(min(1.0, shaft / radius)), 25)
    ball = np.column_stack([radius * np.sin(angle), radius * np.cos(angle)])
    top = np.array([[length, shaft], [length, 0.0]])
    wide = 2.5 * shaft
    return Tool(
        np.concatenate([ball, top]),
        np.array([[length, 0.0], [length, wide], [length + 4.0 * wide, wide], [length + 4.0 * wide, 0.0]]),
    )


def drill(radius: float, length: float, half_point: float) -> Tool:
    """A twist drill with the half of its point angle [rad]."""
    tip = radius / np.tan(half_point)
    wide = 2.5 * radius
    return Tool(
        np.array([[0.0, 0.0], [tip, radius], [length, radius], [length, 0.0]]),
        np.array([[length, 0.0], [length, wide], [length + 3.0 * wide, wide], [length + 3.0 * wide, 0.0]]),
    )
