r"""Tools of revolution by the profile of their lower side: pieces whose swept heights are known in closed form.

A profile :math:`f(r)` is the height of the tool above its tip at the distance r from its axis, 0 at the tip, never falling.
It is kept as pieces, each prolonged inward as a constant: their least is the profile, so what the tool sweeps is the least
of what its pieces sweep, steps of shank and holder included.
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import inlined_stepping, stepping

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

DISC, CONE, TUBE = 0.0, 1.0, 2.0  # kinds of a piece
COLUMNS = (
    5  # kind, inner radius, outer radius, height at the inner one [m], slope of a cone [-] or radius of a tube [m]
)


class Cutters(NamedTuple):
    """Profiles of several tools."""

    piece: FloatArray  # one row a piece: kind, r0, r1, height at r0 [m], slope [-] or tube radius [m]; shape (k, 5)
    first: IntArray  # first piece of each tool, and the number of pieces at the end, shape (tools + 1,)
    radius: FloatArray  # outermost radius of each tool [m], shape (tools,)


Piece = tuple[float, float, float, float, float]


def flat(radius: float) -> list[Piece]:
    """A flat end of a radius [m]."""
    return [(DISC, radius, radius, 0.0, 0.0)]


def bull_nose(radius: float, corner: float) -> list[Piece]:
    """A flat end with a rounded corner [m]; the ball where the corner is the radius, the flat where it is nothing."""
    return [(TUBE, radius - corner, radius, 0.0, corner)] if corner > 0.0 else flat(radius)


def ball(radius: float) -> list[Piece]:
    """A ball end [m]."""
    return bull_nose(radius, radius)


def taper(radius: float, tip: float, half_angle: float) -> list[Piece]:
    """A cone from the radius of its flat tip out to a radius [m]; the half angle [rad] is between axis and side."""
    return [(CONE, tip, radius, 0.0, 1.0 / math.tan(half_angle))] if radius > tip else flat(radius)


def ball_taper(radius: float, ball_radius: float, half_angle: float) -> list[Piece]:
    """A ball that a cone touches, out to a radius [m]; the half angle [rad] is between axis and side."""
    touch = ball_radius * math.cos(half_angle)
    if radius <= touch:
        return [(TUBE, 0.0, radius, 0.0, ball_radius)]
    height = ball_radius * (1.0 - math.sin(half_angle))
    return [(TUBE, 0.0, touch, 0.0, ball_radius), (CONE, touch, radius, height, 1.0 / math.tan(half_angle))]


def revolved(outline: Sequence[tuple[float, float]]) -> list[Piece]:
    """Pieces of a revolved polyline of (height above the tip, radius) [m], from below.

    Only what stands out beyond everything below it counts: seen from below, the rest is hidden.
    """
    pieces: list[Piece] = []
    height, reach = outline[0]
    pieces.append((DISC, reach, reach, height, 0.0))
    for (z0, r0), (z1, r1) in itertools.pairwise(outline):
        if r1 <= reach:
            continue
        slope = (z1 - z0) / (r1 - r0)
        foot = max(r0, reach)
        start = z0 + slope * (foot - r0)
        pieces.append((CONE, foot, r1, start, slope) if slope > 0.0 else (DISC, r1, r1, z1, 0.0))
        reach = r1
    return pieces


def cutters(tools: Sequence[Sequence[Piece]]) -> Cutters:
    """The table of several tools, each a list of pieces."""
    rows = np.array([row for pieces in tools for row in pieces], float).reshape(-1, COLUMNS)
    first = np.concatenate(([0], np.cumsum([len(pieces) for pieces in tools]))).astype(np.int64)
    return Cutters(rows, first, np.array([max(row[2] for row in pieces) for pieces in tools], float))


@inlined_stepping
def piece_height(kind: float, inner: float, foot: float, shape: float, r: float) -> float:
    r"""Height of a piece at a distance from the axis, within its outer radius [m]; inside it is prolonged as a constant.

    .. math:: z_0, \qquad z_0 + m (r - r_0), \qquad z_0 + r_c - \sqrt{r_c^2 - (r - r_0)^2}

    of a disc, a cone and a tube.

    Parameters
    ----------
    kind : float
        ``DISC``, ``CONE`` or ``TUBE``.
    inner, foot : float
        Inner radius :math:`r_0` and the height :math:`z_0` there [m].
    shape : float
        Slope :math:`m` of a cone [-], or radius :math:`r_c` of a tube [m].
    r : float
        Distance from the axis [m].

    Returns
    -------
    float
        Height above the tip [m].

    Notes
    -----
    Valid up to the outer radius of the piece, which the caller knows; a tube is held at its full radius beyond.

    Examples
    --------
    A ball of 5 mm is 1 mm high at 3 mm; a cone of slope 2 from 1 mm out is 4 mm high there, and 0 within its tip.

    >>> cases = ((TUBE, 0.0, 5e-3, 3e-3), (CONE, 1e-3, 2.0, 3e-3), (CONE, 1e-3, 2.0, 0.5e-3))
    >>> [round(1e3 * piece_height(kind, inner, 0.0, shape, r), 9) for kind, inner, shape, r in cases]
    [1.0, 4.0, 0.0]

    References
    ----------
    Derived here.
    """
    if kind == DISC or r <= inner:
        return foot
    if kind == CONE:
        return foot + shape * (r - inner)
    x = r - inner
    return foot + shape - math.sqrt(max(shape * shape - x * x, 0.0))


@stepping
def profile_height(tools: Cutters, tool: int, r: float) -> float:
    r"""Height :math:`f(r)` of a tool above its tip at a distance from its axis [m]; infinite beyond its radius.

    Parameters
    ----------
    tools : Cutters
        Profiles.
    tool : int
        Which of them.
    r : float
        Distance from the axis [m].

    Returns
    -------
    float
        Least of :func:`piece_height` over the pieces that reach so far out [m].

    Notes
    -----
    Valid for profiles that never fall outward.

    Examples
    --------
    A holder whose radius grows from 10 to 20 mm between 45 and 70 mm above the tip.

    >>> tools = cutters([revolved([(45e-3, 10e-3), (70e-3, 20e-3)])])
    >>> [round(1e3 * profile_height(tools, 0, 1e-3 * r), 9) for r in (5.0, 15.0, 20.0, 21.0)]
    [45.0, 57.5, 70.0, inf]

    References
    ----------
    Derived here.
    """
    height = math.inf
    for i in range(tools.first[tool], tools.first[tool + 1]):
        row = tools.piece[i]
        if r <= row[2]:
            height = min(height, piece_height(row[0], row[1], row[3], row[4], r))
    return height


class Meridian(NamedTuple):
    """Elements of the cutting edges below the cylinder, ``e`` of them, from the axis outward."""

    height: FloatArray  # of the middle above the tip [m], shape (e,)
    radius: FloatArray  # [m], shape (e,)
    sine: FloatArray  # of the angle kappa between the outward normal and down, shape (e,)
    cosine: FloatArray  # shape (e,)
    length: FloatArray  # along the meridian [m], shape (e,)


def cylinder_foot(pieces: Sequence[Piece]) -> float:
    """Height above the tip at which the cylinder begins [m]."""
    last = max(pieces, key=lambda row: row[2])
    return piece_height.py_func(last[0], last[1], last[3], last[4], last[2])  # type: ignore[attr-defined]


def meridian(pieces: Sequence[Piece], core: float, elements: int) -> Meridian:
    """The edges below the cylinder in about equal lengths; bottom edges from the core out to where the profile rises.

    Parameters
    ----------
    pieces : sequence of tuple
        The cutter, without shank and holder.
    core : float
        Radius inside which no edge of a flat bottom cuts [m]; not less than that of the bottom: no bottom edges.
    elements : int
        How many; every part of the meridian has at least one.
    """
    parts: list[tuple[float, float, float, float, float, float]] = []  # kind, from, to, inner, foot, shape
    bottom = pieces[0][1]
    if bottom > core:
        parts.append((DISC, core, bottom, bottom, pieces[0][3], 0.0))
    for kind, inner, outer, foot, shape in pieces:
        if kind == CONE:
            parts.append((kind, inner, outer, inner, foot, shape))
        elif kind == TUBE:
            parts.append((kind, 0.0, math.asin(min(1.0, (outer - inner) / shape)), inner, foot, shape))
    lengths = [_length(*part) for part in parts]
    whole = sum(lengths)
    rows = []
    for part, length in zip(parts, lengths, strict=True):
        count = max(1, round(elements * length / whole))
        rows += [_element(part, length, i, count) for i in range(count)]
    table = np.array(rows, float).reshape(-1, 5)
    return Meridian(*(np.ascontiguousarray(table[:, k]) for k in range(5)))


def _length(kind: float, start: float, end: float, _inner: float, _foot: float, shape: float) -> float:
    if kind == TUBE:
        return shape * (end - start)
    return (end - start) * (math.hypot(1.0, shape) if kind == CONE else 1.0)


def _element(
    part: tuple[float, float, float, float, float, float], length: float, i: int, count: int
) -> tuple[float, float, float, float, float]:
    """Middle of the i-th of ``count`` equal elements: height, radius, sine and cosine of kappa, length."""
    kind, start, end, inner, foot, shape = part
    at = start + (end - start) * (i + 0.5) / count
    if kind == DISC:
        return foot, at, 0.0, 1.0, length / count
    if kind == CONE:
        slant = math.hypot(1.0, shape)
        return foot + shape * (at - inner), at, shape / slant, 1.0 / slant, length / count
    s, c = math.sin(at), math.cos(at)
    return foot + shape * (1.0 - c), inner + shape * s, s, c, length / count
