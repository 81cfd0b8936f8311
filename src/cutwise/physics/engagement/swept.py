"""A swept surface with memory: what stands along the edge as columns of height, cut down by every position of the mill.

The arcs of :mod:`cutwise.physics.engagement.arc` know the present position and direction of the mill only. Where the
mill returns to what it cut half a diameter ago, as under run-out or a fast path error, the surface itself has to be
kept. Removed area is then exact to the column: what a pass removes is what the surface loses.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled, inlined_stepping
from cutwise.maths.curves import FloatArray, Polyline, polyline_value
from cutwise.physics.engagement.burred_edge import Layers, Round, immersion_at, show
from cutwise.stages import displaced, left, met, probed, spatial


class Columns(NamedTuple):
    """Strips of material along the edge; one row for each strip over the height of the mill."""

    height: FloatArray  # [m] above the nominal edge, shape (strips, columns); cut down in place
    floor: FloatArray  # [m] lowest height that a strip has anything at (0 for burr), shape (strips,)
    start: float  # [m] position of column 0
    pitch: float  # [m] between columns


class ColumnEdge(NamedTuple):
    """An edge with a burr whose surface is kept, so that a mill with run-out meets what its other teeth left."""

    layers: Layers
    mill: Round
    runout: float  # [m] of the axis
    runout_angle: float  # [rad]
    up_milling: bool
    top: float  # [m] above which nothing stands
    step: float  # [s] in which the columns lose what a step takes


def stand(burr: Polyline, start: float, end: float, pitch: float, burr_strips: int, work_strips: int) -> Columns:
    """Uncut burr strips, then work strips, over a stretch of the edge.

    ``start``, ``end``, ``pitch``: along the edge [m]; the burr [m] is that at the columns, linear between its points.

    Examples
    --------
    >>> stand(Polyline(np.array([0.0, 1.0]), np.array([0.0, 1e-3])), 0.0, 1.0, 0.5, 1, 1).height[:, 1].tolist()
    [0.0005, 0.0]
    """
    position = np.arange(start, end + pitch, pitch)
    height = np.zeros((burr_strips + work_strips, position.size))
    height[:burr_strips] = np.interp(position, burr.at, burr.value)
    floor = np.where(np.arange(burr_strips + work_strips) < burr_strips, 0.0, -np.inf)
    return Columns(height, floor, start, pitch)


def most_columns(radius: float, columns: Columns) -> int:
    """Rows of contact that a mill can have at most [shape of the scratch of the loop].

    ``radius`` of the mill [m].

    Examples
    --------
    >>> most_columns(5e-3, Columns(np.zeros((2, 9)), np.zeros(2), 0.0, 3e-3))  # 2 strips of 4 + 2 columns
    12
    """
    return len(columns.height) * (math.ceil(2.0 * radius / columns.pitch) + 2)


@compiled
def columns_in_reach(
    x: float, bottom: float, radius: float, top: float, start: float, pitch: float, count: int
) -> tuple[int, int]:
    r"""First and last column (exclusive) below which the mill circle may reach under a height ``top``.

    .. math:: |w - x| \le \sqrt{d (2R - d)}, \qquad d = top - bottom, \quad \text{R where } d \ge R

    Parameters
    ----------
    x : float
        Axis of the mill along the edge [m].
    bottom : float
        Height of its lowest point above the nominal edge [m].
    radius : float
        Mill radius R [m].
    top : float
        Height above which nothing stands [m].
    start, pitch : float
        Position of column 0, and distance between columns [m].
    count : int
        Number of columns; those beyond are not there.

    Notes
    -----
    Valid for columns that stand evenly.

    Examples
    --------
    1 mm deep, a mill of 5 mm reaches 3 mm to either side: columns at -2, 0 and 2 mm.

    >>> columns_in_reach(0.0, -1e-3, 5e-3, 0.0, -1e-2, 2e-3, 11)
    (4, 7)

    References
    ----------
    Derived here.
    """
    depth = top - bottom
    if depth <= 0.0:
        return 0, 0
    reach = radius if depth >= radius else math.sqrt(depth * (2.0 * radius - depth))
    first = max(0, math.ceil((x - reach - start) / pitch))
    last = min(count, math.floor((x + reach - start) / pitch) + 1)
    return first, last


@inlined_stepping
def meet_strip(
    mill: Round, columns: Columns, strip: int, layer: int, x: float, y: float, foot: float, width: float, dt: float,
    top: float, rows: FloatArray, count: int,
) -> int:  # fmt: skip
    r"""Rows of contact of one strip with the mill circle.

    A column that loses the area :math:`\Delta A` at the angle :math:`\phi` within a step has the chip thickness
    :math:`h = 2\pi \Delta A / (N \Omega R\, \Delta\phi\, \Delta t)`. Run-out moves the circle, not its radius.

    Parameters
    ----------
    mill : Round
        Radius R [m], flutes N, spindle speed :math:`\Omega` [rad/s].
    columns : Columns
        What stands along the edge; read only.
    strip, layer : int
        Row of the columns, and the layer that it belongs to (0 burr, 1 work).
    x, y : float
        Centre of the mill circle along and above the nominal edge [m].
    foot, width : float
        Lower end of the strip over the tip, and its width [m].
    dt : float
        Time step [s].
    top : float
        Height above which nothing stands [m].
    rows : array
        Layer, foot, width, sine and cosine of the angle, angle of the column [rad], chip [m], strip, column, new height [m].
    count : int
        Rows that are filled already.

    Returns
    -------
    int
        Their new number.

    Notes
    -----
    Valid for columns narrow against the radius and the lower half of the mill; the removed area is exact to the column.

    Examples
    --------
    1 mm of work below a mill of 5 mm at once, three columns 2 mm apart; the middle one loses 2 mm² over 0.4 rad.

    >>> mill, columns = Round(5e-3, 2, 100 * math.pi), Columns(np.zeros((1, 3)), np.array([-1.0]), -2e-3, 2e-3)
    >>> rows = np.zeros((3, 10))
    >>> meet_strip(mill, columns, 0, 1, 0.0, 4e-3, 0.0, 1e-3, 0.1, 0.0, rows, 0)
    3
    >>> (1e3 * rows[1, [6, 9]]).round(9).tolist()  # chip 2 pi A / (N Omega R 0.4 dt), new height [mm]
    [0.1, -1.0]

    References
    ----------
    Derived here.
    """
    radius, height, floor = mill.radius, columns.height, columns.floor[strip]
    first, last = columns_in_reach(x, y - radius, radius, top, columns.start, columns.pitch, height.shape[1])
    rate = 2.0 * math.pi / (mill.flutes * mill.spindle_speed * radius * dt)
    for i in range(first, last):
        d = columns.start + i * columns.pitch - x
        drop = math.sqrt(max(0.0, radius * radius - d * d))
        lowest = max(floor, y - drop)
        if lowest >= height[strip, i]:
            continue
        area = (height[strip, i] - lowest) * columns.pitch
        angle = columns.pitch / max(drop, columns.pitch)
        rows[count, 0] = layer
        rows[count, 1] = foot
        rows[count, 2] = width
        rows[count, 3] = d / radius
        rows[count, 4] = -drop / radius
        rows[count, 5] = angle
        rows[count, 6] = rate * area / angle
        rows[count, 7] = strip
        rows[count, 8] = i
        rows[count, 9] = lowest
        count += 1
    return count


@spatial.of(ColumnEdge)
def _(engagement):
    return False


@probed.of(ColumnEdge)
def _(engagement, pose):
    layers = engagement.layers
    return layers.strips.burr_start, 0.5 * polyline_value(layers.burr_width, pose.along)


@met.of(ColumnEdge)
def _(engagement, stock, pose, structure, flexed, contact):
    burr_height, burr_width, strips = engagement.layers
    mill = engagement.mill
    width = polyline_value(burr_width, pose.along)
    around = (mill.spindle_speed * pose.time) % (2.0 * math.pi) + engagement.runout_angle
    off_x, off_y = engagement.runout * math.sin(around), engagement.runout * math.cos(around)
    if engagement.up_milling:
        off_y = -off_y
    tip = displaced(structure, flexed, strips.burr_start, 0.5 * width)
    at_a = immersion_at(mill, burr_height, pose.x + tip.x, pose.y + tip.y, pose.vx + tip.vx, pose.vy + tip.vy)
    show(at_a, contact.seen)
    count = 0
    for strip in range(2 * strips.slices):
        layer = 0 if strip < strips.slices else 1
        thickness = (width if layer == 0 else strips.work_width) / strips.slices
        start = strips.burr_start if layer == 0 else strips.work_start
        foot = start + (strip - layer * strips.slices) * thickness
        if strips.slices > 1:
            tip = displaced(structure, flexed, foot, 0.5 * thickness)
        count = meet_strip(
            mill, stock, strip, layer, pose.x + tip.x + off_x, pose.y + tip.y + mill.radius + off_y,
            foot, thickness, engagement.step, engagement.top, contact.rows, count,
        )  # fmt: skip
    return count


@left.of(ColumnEdge)
def _(engagement, stock, contact, count):
    """Each column that was met comes down to the mill circle."""
    rows, height = contact.rows, stock.height
    for k in range(count):
        height[int(rows[k, 7]), int(rows[k, 8])] = rows[k, 9]
    return 0
