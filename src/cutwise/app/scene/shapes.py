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
