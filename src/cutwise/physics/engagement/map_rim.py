"""Material over a rim of a tool on its way: how high it stands there exactly, and where along the rim it begins or ends."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import inlined_stepping, stepping
from cutwise.maths.envelopes import ARC, begun_height, segment_height
from cutwise.maths.solid import Solid, bottom_at
from cutwise.maths.workpiece import Workpiece, depth_under, height_under

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

FAR = 1.0  # [m] that stands for an infinite height
_ANGLE = 1e-7  # [rad] to which ends of arcs are found
_STEPS = 90
_FLAT = 1e-5  # of the larger height: the smaller one is no slope to go by
_HALVINGS = 3  # of a bracket after a false position that came no closer
_OWN = 1e-8  # [m] of a tool's own way, short of where it is


class Place(NamedTuple):
    """A tool on its way."""

    x: float  # tip [m]
    y: float
    z: float
    ux: float  # horizontal direction of the feed; program x where it goes straight up or down
    uy: float
    slope: float  # rise per horizontal length [-]; infinite straight up, minus infinity straight down
    segment: int  # of the path, on which it is
    first: int  # first segment of the same move
    share: float  # of the segment that it has run
    move: int  # that it is on


@inlined_stepping
def bounded(value: float) -> float:
    """A height that may be infinite, within 1 m either way [m].

    Parameters
    ----------
    value : float
        Height [m].

    Returns
    -------
    float
        Height [m].

    Notes
    -----
    Valid for any number but NaN.

    Examples
    --------
    >>> bounded(-math.inf), bounded(2e-3)
    (-1.0, 0.002)

    References
    ----------
    Derived here.
    """
    return min(max(value, -FAR), FAR)


@inlined_stepping
def _stands(piece: Workpiece, place: Place, x: float, y: float, level: float, found: IntArray) -> float:
    """Height of the material at a point before the move that is run, and cut by what of it has been run [m].

    One that is not above the level may be told too high, but not above it.

    On a line a tool's own sweep never comes where it cuts.
    """
    solid = piece.solid
    height = height_under(piece, place.move, x, y, level, found)
    if height > level:
        for segment in range(place.first, place.segment - 1):
            height = min(height, segment_height(solid.path, solid.tools, segment, x, y))
        if place.segment > place.first:
            height = min(height, _behind(solid, place.segment - 1, 1.0, x, y))
        if solid.path.row[place.segment, 0] == ARC and place.share > 0.0:
            height = min(height, _behind(solid, place.segment, place.share, x, y))
    return height


@stepping
def _behind(solid: Solid, segment: int, share: float, x: float, y: float) -> float:
    """What has been run of a segment, but for the last of it: its end is the tool itself, whose rim is on its own border."""
    row = solid.path.row[segment]
    length = row[7] * abs(row[14]) if row[0] == ARC else row[7]
    if length > 0.0:
        share = max(share - _OWN / length, 0.0)
    return begun_height(solid.path, solid.tools, segment, share, x, y)


@inlined_stepping
def on_rim(place: Place, radius: float, angle: float) -> tuple[float, float]:
    r"""A point of a rim in plan, :math:`P + r\,(u \cos\psi + u_\perp \sin\psi)` [m].

    Parameters
    ----------
    place : Place
        Where the tool is.
    radius : float
        Radius of the rim [m].
    angle : float
        Angle from the feed, to the left [rad].

    Returns
    -------
    tuple
        x and y [m].

    Notes
    -----
    Valid for any angle.

    Examples
    --------
    A quarter turn to the left of a feed along y is backward along x.

    >>> place = Place(20e-3, 0.0, 0.0, 0.0, 1.0, 0.0, 0, 0, 0.5, 0)
    >>> [round(1e3 * v, 9) for v in on_rim(place, 5e-3, 0.5 * math.pi)]
    [15.0, 0.0]

    References
    ----------
    Derived here.
    """
    c, s = math.cos(angle), math.sin(angle)
    return place.x + radius * (place.ux * c - place.uy * s), place.y + radius * (place.uy * c + place.ux * s)


@inlined_stepping
def over_at(piece: Workpiece, place: Place, x: float, y: float, level: float, upper: bool, found: IntArray) -> float:
    """Height of the material over a level at a point in plan [m]; where others cut across, no more than the depth there.

    Parameters
    ----------
    piece : Workpiece
        The material before the move on which the place is.
    place : Place
        Where the tool is.
    x, y : float
        The point [m].
    level : float
        Height of the rim [m].
    upper : bool
        Height of the upper side alone, hollow below or not.
    found : array (16,)
        Room for ids, integers.

    Returns
    -------
    float
        Height, no more than 1 m either way [m].

    Notes
    -----
    Valid as :func:`cutwise.maths.map_surface.surface_above`: what does not stand above the level may be told too high. Not positive
    below the underside of a stock from a file.

    Examples
    --------
    A rim of 5 mm, 3 mm outside of a block and 2 mm deep: 1 mm into the block, and 1 mm beside it.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.workpiece import alone
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> [over_at(block, place, 20e-3, y, -2e-3, False, np.empty(16, np.int64)) for y in (1e-3, -1e-3)]
    [0.002, -1.0]

    References
    ----------
    Derived here.
    """
    over = bounded(_stands(piece, place, x, y, level, found) - level)
    if over > 0.0 and not upper:
        if piece.solid.map.bottom.size > 1:
            over = min(over, bounded(level - bottom_at(piece.solid, x, y)))
        if piece.crossing:
            over = min(over, depth_under(piece, x, y, level, found))
    return over


@inlined_stepping
def over_rim(piece: Workpiece, place: Place, radius: float, level: float, angle: float, found: IntArray) -> float:
    """:func:`over_at` at a point of the rim [m].

    Parameters
    ----------
    piece, place, level, found
        As for :func:`over_at`.
    radius : float
        Radius of the rim [m].
    angle : float
        Angle from the feed, to the left [rad].

    Returns
    -------
    float
        Height, no more than 1 m either way [m].

    Notes
    -----
    Valid as :func:`over_at`.

    Examples
    --------
    The rim of :func:`over_at`, at 30 degrees beside the block, at 60 in it.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.workpiece import alone
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> [over_rim(block, place, 5e-3, -2e-3, math.radians(a), np.empty(16, np.int64)) for a in (30, 60)]
    [-1.0, 0.002]

    References
    ----------
    Derived here.
    """
    x, y = on_rim(place, radius, angle)
    return over_at(piece, place, x, y, level, False, found)


@inlined_stepping
def change_on_rim(
    piece: Workpiece, place: Place, radius: float, level: float, between: tuple[float, float], over: tuple[float, float],
    found: IntArray,
) -> float:  # fmt: skip
    """Angle between two at which contact begins or ends: false position, halvings where that does not come closer.

    A rim that runs along what the tool itself has left stands hardly above it: there false position would creep.

    Parameters
    ----------
    piece, place, radius, level, found
        As for :func:`over_rim`.
    between, over : tuple of float
        Two angles [rad], and the heights of the material over the rim there [m], one positive and one not.

    Returns
    -------
    float
        The angle, to 1e-7 rad.

    Notes
    -----
    Valid for one change between the two; of several, one is found.

    Examples
    --------
    The block of :func:`over_at` begins at :math:`\\sin\\psi = 3/5`.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.workpiece import alone
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> round(change_on_rim(block, place, 5e-3, -2e-3, (0.5, 1.0), (-1.0, 2e-3), np.empty(16, np.int64)), 6)
    0.643501

    References
    ----------
    Derived here.
    """
    (a, b), (ga, gb) = between, over
    wa, wb, side, halve = ga, gb, 0, 0  # heights, those of an end that stays halved (Illinois)
    beside, looks_beside = 0.0, False
    for _ in range(_STEPS):
        if b - a <= _ANGLE:
            break
        middle = beside if looks_beside else 0.5 * (a + b)
        straight = not looks_beside and halve == 0 and min(abs(ga), abs(gb)) > _FLAT * max(abs(ga), abs(gb))
        if straight:
            middle = min(max(a - wa * (b - a) / (wb - wa), a + 0.01 * (b - a)), b - 0.01 * (b - a))
        g = over_rim(piece, place, radius, level, middle, found)  # asked in one place, into which it is compiled
        low = (g > 0.0) == (ga > 0.0)
        if looks_beside:
            if low:
                a, ga, wa = middle, g, g
            else:
                b, gb, wb = middle, g, g
            halve, looks_beside = _HALVINGS, False
            continue
        halve = max(halve - 1, 0)
        if straight and abs(g) > 0.5 * abs(ga if low else gb):
            halve = _HALVINGS
        slope = (gb - ga) / (b - a)
        if low:
            a, ga, wa, wb = middle, g, g, 0.5 * wb if side == 1 else gb
            side = 1
        else:
            b, gb, wb, wa = middle, g, g, 0.5 * wa if side == -1 else ga
            side = -1
        if straight and abs(g) <= 0.5 * _ANGLE * abs(slope) and b - a > _ANGLE:  # likely there: look on its other side
            beside, looks_beside = middle + _ANGLE if low else middle - _ANGLE, True
    return 0.5 * (a + b)
