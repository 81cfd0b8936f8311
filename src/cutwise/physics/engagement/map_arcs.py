"""Arcs of contact from a fan of heights along a rim of a tool: where they begin and end."""

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import inlined_stepping, stepping
from cutwise.maths.workpiece import Workpiece
from cutwise.physics.engagement.map_fan import FAN, Fan, exactly
from cutwise.physics.engagement.map_rim import Place, change_on_rim

FloatArray = npt.NDArray[np.float64]


@inlined_stepping
def settled(piece: Workpiece, place: Place, radius: float, level: float, fan: Fan) -> None:
    """Where the fan changes its sign, both sides are exact: what cells said wrongly moves the change on.

    Parameters
    ----------
    piece : Workpiece
        The material before the move on which the place is.
    place : Place
        Where the tool is.
    radius, level : float
        Radius of the rim, and its height [m].
    fan : Fan
        Heights by :func:`cutwise.physics.engagement.map_fan.by_cells`; changed.

    Notes
    -----
    Valid as :func:`cutwise.physics.engagement.map_fan.by_cells`.

    Examples
    --------
    A change that was said two directions too far on is found between the right two.

    >>> import math
    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.physics.engagement.map_fan import by_cells, fan_room, spread
    >>> from cutwise.maths.workpiece import alone
    >>> from cutwise.maths.solid import RECTANGLE, Outline, Solid
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> fan = fan_room()
    >>> spread(fan, 0.5 * math.pi)
    >>> by_cells(block, place, 5e-3, -2e-3, fan, False)
    >>> fan.above[44:48], fan.exact[44:48] = -1.0, False
    >>> settled(block, place, 5e-3, -2e-3, fan)
    >>> int(np.argmax(fan.above > 0.0))
    46

    References
    ----------
    Derived here.
    """
    changed = True
    while changed:
        changed = False
        for i in range(FAN + 1):
            here = fan.above[i] > 0.0
            ends = (i > 0 and (fan.above[i - 1] > 0.0) != here) or (i < FAN and (fan.above[i + 1] > 0.0) != here)
            fan.asked[i] = ends and not fan.exact[i]
            changed = changed or fan.asked[i]
        if changed:
            exactly(piece, place, radius, level, fan, False)


@stepping
def _refined(
    piece: Workpiece, place: Place, radius: float, level: float, fan: Fan, rows: FloatArray, count: int
) -> None:
    """Angles at which contact begins and ends in the last rows of an element, each between two directions, exactly."""
    n, inside = count, False
    for i in range(FAN + 1):
        now = fan.above[i] > 0.0
        if now and not inside:
            n += 1
        if now != inside and i > 0:
            between, over = (fan.angle[i - 1], fan.angle[i]), (fan.above[i - 1], fan.above[i])
            end = change_on_rim(piece, place, radius, level, between, over, fan.found)
            if n <= rows.shape[0]:
                rows[n - 1, 1 if now else 2] = end
        inside = now


@inlined_stepping
def arcs(
    piece: Workpiece, place: Place, radius: float, level: float, half: float, fan: Fan, rows: FloatArray, count: int,
    refine: bool,
) -> int:  # fmt: skip
    """Arcs of a settled fan into rows, columns 1 and 2; their number with those before.

    Parameters
    ----------
    piece : Workpiece
        The material before the move on which the place is.
    place : Place
        Where the tool is.
    radius, level : float
        Radius of the rim, and its height [m].
    half : float
        Half of the cutting range [rad].
    fan : Fan
        Heights over the rim.
    rows, count : array (m, 5), int
        Rows of contact, and how many there are.
    refine : bool
        Find ends to 1e-7 rad; otherwise half way between two directions.

    Returns
    -------
    int
        How many there are now; those beyond the last row are left out.

    Notes
    -----
    Valid as :func:`cutwise.physics.engagement.map_fan.by_cells`.

    Examples
    --------
    The block begins at 36.87 degrees.

    >>> import math
    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.physics.engagement.map_fan import by_cells, fan_room, spread
    >>> from cutwise.maths.workpiece import alone
    >>> from cutwise.maths.solid import RECTANGLE, Outline, Solid
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> fan, rows = fan_room(), np.zeros((4, 5))
    >>> spread(fan, 0.5 * math.pi)
    >>> by_cells(block, place, 5e-3, -2e-3, fan, True)
    >>> arcs(block, place, 5e-3, -2e-3, 0.5 * math.pi, fan, rows, 0, True), np.degrees(rows[0, 1:3]).round(4).tolist()
    (1, [36.8699, 90.0])

    References
    ----------
    Derived here.
    """
    first, low, inside = count, 0.0, False
    for i in range(FAN + 1):
        now = fan.above[i] > 0.0
        if now == inside:
            continue
        between = 0.5 * (fan.angle[i - 1] + fan.angle[i]) if i > 0 else -half
        if now:
            low = between
        elif count < rows.shape[0]:
            rows[count, 1], rows[count, 2] = low, between
            count += 1
        inside = now
    if inside and count < rows.shape[0]:
        rows[count, 1], rows[count, 2] = low, half
        count += 1
    if refine and count > first:
        _refined(piece, place, radius, level, fan, rows, first)
    return count
