r"""Sweeps of a height map: moves in their order, each over the blocks that it reaches.

What a move takes off a block is summed in double, in an order that is always the same, and rounded to a whole number, so that
sums do not depend on theirs: heights, ids and volumes are the same to the last bit for any bands of blocks, in any threads.
"""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping, stepping, unlocked
from cutwise.maths.envelopes import LINE, Segments
from cutwise.maths.height_map import BLOCK, RINGS, SIDE, HeightMap
from cutwise.maths.map_levels import Room, largest, level_of, room
from cutwise.maths.profiles import Cutters, profile_height

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]

_GRAIN = 2.0**40
_HALF_DIAGONAL = 0.5 * math.sqrt(2.0) * (SIDE - 1)


@stepping
def _held_off(stock: HeightMap, cell: int, height: Float32Array, level: Float32Array) -> float:
    """What a row of cells loses of the intervals that other set-ups have left [m]."""
    held, off = stock.held, 0.0
    for j in range(SIDE):
        if not level[j] < height[j]:
            continue
        share = np.float64(stock.share[cell + j])
        for n in range(held.first[cell + j], held.first[cell + j + 1]):
            gone = min(held.high[n], np.float64(height[j])) - max(held.low[n], np.float64(level[j]))
            off += max(gone, 0.0) * share
    return off


@stepping
def _taken_off(stock: HeightMap, block: int, height: Float32Array, level: Float32Array, lanes: FloatArray) -> float:
    """What a block loses down to the heights of a move, summed [m]: each column of cells first, so that lanes are added."""
    base, floor = block * BLOCK, stock.bottom[0]
    share = stock.share[base : base + BLOCK]
    for j in range(SIDE):
        lanes[j] = 0.0
    if stock.held.first.size > 1:
        for i in range(SIDE):
            row = SIDE * i
            lanes[i] = _held_off(stock, base + row, height[row : row + SIDE], level[row : row + SIDE])
    elif stock.bottom.size > 1:
        bottom = stock.bottom[base : base + BLOCK]
        for i in range(SIDE):
            for j in range(SIDE):
                k = SIDE * i + j
                old, new = np.float64(height[k]), np.float64(level[k])
                new = new if new < old else old
                new = new if new > bottom[k] else bottom[k]
                old = old if old > bottom[k] else bottom[k]
                lanes[j] += (old - new) * np.float64(share[k])
    else:
        for i in range(SIDE):
            for j in range(SIDE):
                k = SIDE * i + j
                old, new = np.float64(height[k]), np.float64(level[k])
                new = new if new < old else old
                new = new if new > floor else floor
                old = old if old > floor else floor
                lanes[j] += (old - new) * np.float64(share[k])
    off = 0.0
    for j in range(SIDE):
        off += lanes[j]
    return off


@stepping
def _lowered(stock: HeightMap, block: int, move: int, work: Room) -> int:
    """Take a block down to the heights of a move; returns what was taken off, in units of 2**-40 m."""
    base = block * BLOCK  # views, because an index that may be negative keeps loops out of vector lanes
    height, cutter = stock.height[base : base + BLOCK], stock.cutter[base : base + BLOCK]
    level, spare = work.level, work.other
    for k in range(BLOCK):
        spare[k] = height[k] - level[k]
    if not largest(spare) > np.float32(0.0):
        return 0
    off = _taken_off(stock, block, height, level, work.lanes)
    name = np.int32(move)
    for k in range(BLOCK):
        less = level[k] < height[k]
        cutter[k] = name if less else cutter[k]
        height[k] = level[k] if less else height[k]
        spare[k] = height[k]
    stock.highest[block] = largest(spare)
    return np.int64(math.floor(off * _GRAIN + 0.5))  # type: ignore[return-value]


@inlined_stepping
def _extent(row: FloatArray) -> tuple[float, float, float, float, float]:
    """Least and greatest x and y of the tip on a segment, and its lowest z [m]."""
    if row[0] == LINE:
        ex, ey = row[2] + row[7] * row[5], row[3] + row[7] * row[6]
        return min(row[2], ex), max(row[2], ex), min(row[3], ey), max(row[3], ey), row[4] + min(0.0, row[7] * row[8])
    return row[2] - row[7], row[2] + row[7], row[3] - row[7], row[3] + row[7], row[4]


@inlined_stepping
def _apart(row: FloatArray, x: float, y: float) -> float:
    """Distance of a point from the path of the tip, at least [m]."""
    dx, dy = x - row[2], y - row[3]
    if row[0] == LINE:
        q = min(max(dx * row[5] + dy * row[6], 0.0), row[7])
        return math.hypot(dx - q * row[5], dy - q * row[6])
    return abs(math.hypot(dx, dy) - row[7])


@inlined_stepping
def _reach_in_row(
    row: FloatArray, radius: float, low: float, high: float, ends: tuple[float, float]
) -> tuple[float, float]:
    """Least and greatest x that a segment reaches between two y [m]; ends of the whole where it is an arc or level in y."""
    left, right = ends[0] - radius, ends[1] + radius
    if row[0] == LINE and abs(row[6]) * row[7] > radius:
        a = (low - radius - row[3]) / row[6]
        b = (high + radius - row[3]) / row[6]
        first, last = max(0.0, min(a, b)), min(row[7], max(a, b))
        xa, xb = row[2] + first * row[5], row[2] + last * row[5]
        left, right = min(xa, xb) - radius, max(xa, xb) + radius
    return left, right


@stepping
def lower_by(
    stock: HeightMap, path: Segments, tools: Cutters, segment: int, move: int, bands: tuple[int, int], work: Room
) -> int:
    r"""Sweep one segment over the rows of blocks of a band; returns what was taken off, summed, in units of 2**-40 m.

    .. math:: \sum_\text{blocks} \left\lfloor 2^{40} \sum_\text{cells} a \,(h - \max(z, b))_+ + \tfrac12 \right\rfloor

    with the share a of a cell that is stock, its height h before, the height z that the segment leaves, and its underside b.

    Parameters
    ----------
    stock : HeightMap
        The material; heights, ids and highest values are changed in place.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    segment, move : int
        Which segment, and the id that cells lowered by it are given.
    bands : tuple of int
        First row of blocks, and the one after the last.
    work : Room
        Room, from :func:`room`.

    Returns
    -------
    int
        Heights taken off, summed [2**-40 m]; :func:`volume_of` makes a volume of it.

    Notes
    -----
    Valid for cells by their middles: a wall stands to half a cell. Heights are float32, to 1e-8 of a metre in a stock 0.1 m high.
    A cell of equal height keeps its id.

    Examples
    --------
    A slot of 2 mm, 1 mm deep, through cells of 1 mm: 2 rows of 8 cells are lowered by 1 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import UNIT, height_map, in_rows, layout, volume_of
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = lower_by(stock, path, cutters([flat(1e-3)]), 0, 0, (0, grid.rows), room(grid))
    >>> round(taken * UNIT, 8), in_rows(grid, stock.cutter)[:, 0].tolist()
    (0.016, [-1, 0, 0, -1])

    References
    ----------
    Derived here: the closed forms of :mod:`cutwise.maths.envelopes` at the middles of cells.
    """
    grid, row = stock.layout, path.row[segment]
    tool = int(row[1])
    radius = tools.radius[tool]
    x0, x1, y0, y1, lowest = _extent(row)
    first_x, first_y = grid.x + grid.dx * (0.5 - RINGS), grid.y + grid.dy * (0.5 - RINGS)
    wide, tall = grid.dx * SIDE, grid.dy * SIDE
    first = max(bands[0], math.floor((y0 - radius - first_y - grid.dy * (SIDE - 1)) / tall))
    last = min(bands[1] - 1, math.floor((y1 + radius - first_y) / tall))
    far = radius + _HALF_DIAGONAL * max(grid.dx, grid.dy)
    reach = 2.0 * (radius + max(wide, tall) * 2.0)
    taken = 0
    for r in range(first, last + 1):
        y = first_y + r * tall
        left, right = _reach_in_row(row, radius, y, y + grid.dy * (SIDE - 1), (x0, x1))
        begin = max(0, math.floor((left - first_x - grid.dx * (SIDE - 1)) / wide))
        end = min(grid.columns - 1, math.floor((right - first_x) / wide))
        for c in range(begin, end + 1):
            block = r * grid.columns + c
            if stock.highest[block] <= lowest:
                continue
            x = first_x + c * wide
            away = _apart(row, x + 0.5 * grid.dx * (SIDE - 1), y + 0.5 * grid.dy * (SIDE - 1))
            if away > far:
                continue
            rises = away > far - radius and stock.highest[block] <= lowest + profile_height(
                tools, tool, away + radius - far
            )
            if rises:  # the tool is higher than the block there
                continue
            level_of(row, tools, tool, x, y, reach, work)
            taken += _lowered(stock, block, move, work)
    return taken


@compiled
def cut_by(stock: HeightMap, path: Segments, tools: Cutters, move: int, work: Room) -> int:
    """Sweep all segments of one move over the whole map; what was taken off as :func:`lower_by`.

    Parameters
    ----------
    stock : HeightMap
        The material, changed in place.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    move : int
        Which move.
    work : Room
        Room, from :func:`room`.

    Returns
    -------
    int
        Heights taken off, summed [2**-40 m].

    Notes
    -----
    Valid as :func:`lower_by`.

    Examples
    --------
    The slot of :func:`lower_by` takes 8 x 2 x 1 mm^3; run again it takes nothing.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import UNIT, height_map, in_rows, layout, volume_of
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = [cut_by(stock, path, cutters([flat(1e-3)]), 0, room(grid)) for _ in range(2)]
    >>> (1e9 * volume_of(stock, taken)).round(5).tolist()
    [16.0, 0.0]

    References
    ----------
    As :func:`lower_by`.
    """
    taken = 0
    for segment in range(path.first[move], path.first[move + 1]):
        taken += lower_by(stock, path, tools, segment, move, (0, stock.layout.rows), work)
    return taken


@unlocked
def swept_band(stock: HeightMap, path: Segments, tools: Cutters, bands: tuple[int, int], taken: IntArray) -> None:
    """Sweep all moves over a band of rows of blocks; what each takes off is added to ``taken``, shape (moves,).

    Parameters
    ----------
    stock : HeightMap
        The material, changed in place within the band alone.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    bands : tuple of int
        First row of blocks, and the one after the last.
    taken : array (moves,)
        Heights taken off, summed [2**-40 m], integers.

    Notes
    -----
    Valid as :func:`lower_by`. Bands that do not overlap may be swept side by side, each with a ``taken`` of its own.

    Examples
    --------
    Along a slot 8 mm long and 2 mm wide, first 1 mm deep and then 3 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import UNIT, height_map, in_rows, layout, volume_of
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> rows = [line_row(0, np.array([-2e-3, 2e-3, z]), np.array([10e-3, 2e-3, z])) for z in (-1e-3, -3e-3)]
    >>> taken = np.zeros(2, np.int64)
    >>> swept_band(stock, segments(rows, [1, 1]), cutters([flat(1e-3)]), (0, grid.rows), taken)
    >>> (1e9 * volume_of(stock, taken)).round(5).tolist()
    [16.0, 32.0]

    References
    ----------
    As :func:`lower_by`.
    """
    work = room(stock.layout)
    for move in range(path.first.size - 1):
        for segment in range(path.first[move], path.first[move + 1]):
            taken[move] += lower_by(stock, path, tools, segment, move, bands, work)


@stepping
def overlap_by(stock: HeightMap, path: Segments, tools: Cutters, segment: int, found: FloatArray, work: Room) -> None:
    """What a segment would take off, without taking it: volume [m^3], depth [m] and its place are added to a row of five.

    Parameters
    ----------
    stock : HeightMap
        The material, left as it is.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    segment : int
        Which segment.
    found : array (5,)
        Volume, to which is added [m^3]; largest depth so far, and x, y of its cell and the height of the tool there [m].
    work : Room
        Room, from :func:`room`.

    Notes
    -----
    Valid as :func:`lower_by`: a wall counts by the middles of cells. Of several segments the volume counts twice where they
    overlap.

    Examples
    --------
    The slot of :func:`lower_by`: 16 mm^3, 1 mm deep, first met in the middle of the cell at (0.5, 1.5) mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import UNIT, height_map, in_rows, layout, volume_of
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> found = np.zeros(5)
    >>> overlap_by(stock, path, cutters([flat(1e-3)]), 0, found, room(grid))
    >>> round(float(1e9 * found[0]), 5), (1e3 * found[1:]).round(6).tolist()
    (16.0, [1.0, 0.5, 1.5, -1.0])

    References
    ----------
    As :func:`lower_by`.
    """
    grid, row = stock.layout, path.row[segment]
    tool = int(row[1])
    lift = 1e30
    for i in range(tools.first[tool], tools.first[tool + 1]):
        lift = min(lift, tools.piece[i, 3])
    radius = tools.radius[tool]
    x0, x1, y0, y1, lowest = _extent(row)
    first_x, first_y = grid.x + grid.dx * (0.5 - RINGS), grid.y + grid.dy * (0.5 - RINGS)
    wide, tall = grid.dx * SIDE, grid.dy * SIDE
    first = max(0, math.floor((y0 - radius - first_y - grid.dy * (SIDE - 1)) / tall))
    last = min(grid.rows - 1, math.floor((y1 + radius - first_y) / tall))
    far = radius + _HALF_DIAGONAL * max(grid.dx, grid.dy)
    reach = 2.0 * (radius + max(wide, tall) * 2.0)
    one_bottom = stock.bottom.size == 1
    for r in range(first, last + 1):
        y = first_y + r * tall
        left, right = _reach_in_row(row, radius, y, y + grid.dy * (SIDE - 1), (x0, x1))
        begin = max(0, math.floor((left - first_x - grid.dx * (SIDE - 1)) / wide))
        end = min(grid.columns - 1, math.floor((right - first_x) / wide))
        for c in range(begin, end + 1):
            block = r * grid.columns + c
            if stock.highest[block] <= lowest + lift:
                continue
            x = first_x + c * wide
            if _apart(row, x + 0.5 * grid.dx * (SIDE - 1), y + 0.5 * grid.dy * (SIDE - 1)) > far:
                continue
            level_of(row, tools, tool, x, y, reach, work)
            for k in range(BLOCK):
                at = block * BLOCK + k
                share = np.float64(stock.share[at])
                if share <= 0.0 or not work.level[k] < stock.height[at]:
                    continue
                floor = stock.bottom[0] if one_bottom else stock.bottom[at]
                depth = max(np.float64(stock.height[at]), floor) - max(np.float64(work.level[k]), floor)
                found[0] += depth * share * grid.dx * grid.dy
                if depth > found[1]:
                    found[1] = depth
                    found[2], found[3] = x + grid.dx * (k % SIDE), y + grid.dy * (k // SIDE)
                    found[4] = max(np.float64(work.level[k]), floor)
