"""What a tool meets where it turns from a move into the next: what it met at the end of the one, seen along the other."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import inlined_stepping
from cutwise.physics.engagement.map_contact import CYLINDER, FLAT, Edge, half_range
from cutwise.physics.engagement.map_fan import SHAVE
from cutwise.physics.engagement.map_rim import Place

FloatArray = npt.NDArray[np.float64]


@inlined_stepping
def goes_on(edge: Edge, before: Place, after: Place) -> bool:
    r"""Whether what a tool meets where it turns follows from what it met there at the end of its move before.

    Material touches the tool where it moved into it, :math:`n \cdot v > 0`, and nowhere that it moved away from,
    :math:`n \cdot v < 0`; of where it moved along its own side, :math:`n \cdot v = 0`, nothing follows. That is a line of no width,
    but for a cylinder that went straight down, and for the bottom of a tool that went level and goes down now.

    Parameters
    ----------
    edge : Edge
        Where the tool cuts.
    before, after : Place
        The end of a move and the start of the next, at one point.

    Returns
    -------
    bool
        Whether it follows.

    Notes
    -----
    Valid for moves that follow one another with one tool.

    Examples
    --------
    A flat mill that goes level, turns, and then goes down.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> edge = Edge(meridian(flat(5e-3), 0.0, 1), 5e-3, 0.0, 10e-3)
    >>> level = Place(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0, 0, 1.0, 0)
    >>> goes_on(edge, level, level._replace(ux=0.0, uy=1.0)), goes_on(edge, level, level._replace(slope=-0.1))
    (True, False)

    References
    ----------
    Derived here.
    """
    if math.isinf(before.slope) or math.isinf(after.slope):
        return False
    mer = edge.meridian
    flat = mer.sine.shape[0] > 0 and mer.sine[0] <= FLAT
    return not (flat and after.slope < 0.0 and before.slope == 0.0)


@inlined_stepping
def turned_rows(rows: FloatArray, count: int, edge: Edge, before: Place, after: Place, out: FloatArray) -> int:
    r"""Rows of contact at the start of a move from those at the end of the move before; their number.

    .. math:: \psi' = \psi + \alpha - \alpha', \qquad \cos\psi' > k' \cot\kappa

    with the directions :math:`\alpha` of the two moves in the plane and the slope k' of the second.

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact at the end of the move before.
    edge : Edge
        Where the tool cuts.
    before, after : Place
        The end of a move and the start of the next, at one point.
    out : array (m, 5)
        Rows of contact there.

    Returns
    -------
    int
        How many rows were written; those beyond the last row are left out.

    Notes
    -----
    Valid where :func:`goes_on` says so. The start of a move is where a rim lies on what the tool itself has just left: asked of the
    material, the answer there is rounding.

    Examples
    --------
    In a slot, all ahead in contact, the tool turns left by 60 degrees: of the arc that stays ahead 60 degrees are lost on the left.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> edge, out = Edge(meridian(flat(5e-3), 0.0, 1), 5e-3, 0.0, 10e-3), np.zeros((4, 5))
    >>> slot = np.array([[CYLINDER, -0.5 * math.pi, 0.5 * math.pi, 0.0, 1e-3]])
    >>> ahead = Place(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0, 0, 1.0, 0)
    >>> left = ahead._replace(ux=0.5, uy=math.sqrt(0.75))
    >>> turned_rows(slot, 1, edge, ahead, left, out), np.degrees(out[0, 1:3]).round(9).tolist()
    (1, [-90.0, 30.0])

    References
    ----------
    Derived here.
    """
    turn = math.atan2(after.ux * before.uy - after.uy * before.ux, after.ux * before.ux + after.uy * before.uy)
    mer, written = edge.meridian, 0
    for n in range(count):
        element = int(rows[n, 0])
        half = 0.5 * math.pi
        if element != CYLINDER:
            half = half_range(after.slope, mer.sine[element], mer.cosine[element])
        for k in range(-1, 2):
            low = max(rows[n, 1] + turn + 2.0 * math.pi * k, -half)
            high = min(rows[n, 2] + turn + 2.0 * math.pi * k, half)
            if high - low > 2.0 * SHAVE and written < out.shape[0]:
                out[written, 0], out[written, 1], out[written, 2] = rows[n, 0], low, high
                out[written, 3], out[written, 4] = rows[n, 3], rows[n, 4]
                written += 1
    return written
