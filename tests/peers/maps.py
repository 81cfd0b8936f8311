"""Blocks, paths and tools in mm for tests of the stock in 3D."""

import itertools

import numpy as np

from cutwise.maths.envelopes import Segments, arc_row, line_row, segments
from cutwise.maths.height_map import HeightMap, height_map, layout, volume_of
from cutwise.maths.map_levels import room
from cutwise.maths.map_surface import surfaces
from cutwise.maths.map_sweep import cut_by, swept_band
from cutwise.maths.profiles import Cutters, cutters, profile_height
from cutwise.maths.solid import RECTANGLE, Outline, Solid

MM = 1e-3
OUTLINE = Outline(RECTANGLE, 0.0, 0.0, 0.0)


def block(x, y, z, grid) -> HeightMap:
    """A block from its sides in mm."""
    cells = layout(tuple(MM * v for v in x), tuple(MM * v for v in y), MM * grid)
    return height_map(cells, np.ones((cells.along, cells.across)), MM * z[0], MM * z[1])


def tool(pieces) -> Cutters:
    """One tool, its pieces in m."""
    return cutters([pieces])


def lines(*points, tool: int = 0) -> Segments:
    """A path through points in mm, a move from each to the next."""
    rows = [line_row(tool, MM * np.array(a, float), MM * np.array(b, float)) for a, b in itertools.pairwise(points)]
    return segments(rows, [1] * len(rows))


def separate(*ends) -> Segments:
    """Lines from pairs of points in mm."""
    return segments([line_row(0, MM * np.array(a, float), MM * np.array(b, float)) for a, b in ends], [1] * len(ends))


def arc(centre, height, radius, start, sweep) -> list[float]:
    """A level arc in mm and rad."""
    return arc_row(0, MM * np.array(centre, float), MM * height, MM * radius, start, sweep)


def swept(stock: HeightMap, path: Segments, tools: Cutters, bands: int = 1) -> tuple[Solid, np.ndarray]:
    """The block after all moves, and the volume of each in mm^3."""
    taken = np.zeros(path.first.size - 1, np.int64)
    ends = np.linspace(0, stock.layout.rows, bands + 1).astype(int)
    for low, high in itertools.pairwise(ends):
        swept_band(stock, path, tools, (int(low), int(high)), taken)
    return Solid(stock, OUTLINE, path, tools), 1e9 * volume_of(stock, taken)


def before(stock: HeightMap, path: Segments, tools: Cutters, move: int) -> Solid:
    """The block before a move."""
    work = room(stock.layout)
    for k in range(move):
        cut_by(stock, path, tools, k, work)
    return Solid(stock, OUTLINE, path, tools)


def heights(solid: Solid, *points) -> np.ndarray:
    """Heights in mm of the surface at points in mm."""
    at = MM * np.array(points, float)
    out, owner = np.empty(len(at)), np.empty(len(at), np.int64)
    surfaces(solid, np.ascontiguousarray(at[:, 0]), np.ascontiguousarray(at[:, 1]), out, owner)
    return 1e3 * out


def stamped(tools: Cutters, start, end, x, y, poses: int = 1500) -> np.ndarray:
    """Heights that many poses of a tool along a line leave at points [m]."""
    least = np.full(len(x), np.inf)
    for share in np.linspace(0.0, 1.0, poses):
        px, py, pz = np.array(start) + share * (np.array(end) - np.array(start))
        away = np.hypot(x - px, y - py)
        least = np.minimum(least, [profile_height(tools, 0, r) + pz for r in away])
    return least
