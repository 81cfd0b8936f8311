"""The stock and the fixtures of a scenario as height maps."""

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.io import stl
from cutwise.io.occ import CadFault
from cutwise.io.solid_mesh import solid_triangles
from cutwise.maths.curves import FloatArray
from cutwise.maths.height_map import HeightMap, cell_middles, height_map, layout
from cutwise.maths.rays import columns
from cutwise.maths.solid import CELLS, CIRCLE, RECTANGLE, Outline
from cutwise.maths.workpiece import Frame
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.program import StockBlock
from cutwise.spec.stock import StockCylinder, StockFile

_FINE = 16  # parts of a cell's side with which the share of a round bar is told
_SQUARE = 1e-9  # of the axes of a set-up: quarter turns
_CHORD = 1e-5  # [m] of the triangles of a STEP model
_CELL_BYTES = 12  # heights, ids and shares
_FILE_CELL_BYTES = 36  # and tops and bottoms
_MOVE_BYTES, _SAMPLE_BYTES = 400, 40  # a move with its first stations

Box = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


class Raw(NamedTuple):
    """Stock or a fixture before it is a map."""

    box: Box  # least and greatest x, y, z [m]
    kind: int  # of the outline
    circle: tuple[float, float, float]  # middle and radius [m]
    triangles: FloatArray | None  # of one from a file [m]


class Material(NamedTuple):
    """Stock or a fixture as a map."""

    map: HeightMap
    outline: Outline
    filled: float  # volume of hollows in columns, which the map fills up [m^3]


def raw_of(given: StockBlock | StockCylinder | StockFile, key: tuple[str | int, ...]) -> Raw:
    """Stock as it is said; a file is read.

    Raises
    ------
    ScenarioFault
        The file cannot be used.
    """
    if isinstance(given, StockBlock):
        return Raw((given.x, given.y, given.z), RECTANGLE, (0.0, 0.0, 0.0), None)
    if isinstance(given, StockCylinder):
        c = given.cylinder
        (x, y), r = c.axis, 0.5 * c.diameter
        return Raw(((x - r, x + r), (y - r, y + r), c.z), CIRCLE, (x, y, r), None)
    try:
        read = stl.read_stl if Path(given.file).suffix.lower() == ".stl" else _step_triangles
        triangles = read(given.file)
    except CadFault as fault:
        raise ScenarioFault([Fault((*key, "file"), str(fault))]) from None
    return Raw(_around(triangles.reshape(-1, 3)), CELLS, (0.0, 0.0, 0.0), triangles)


def _step_triangles(file: str) -> FloatArray:
    return solid_triangles(file, None, _CHORD)


def raw_seen(raw: Raw, frame: Frame) -> Raw:
    """Stock of part coordinates in those of a set-up; a block or bar that stands askew there as triangles."""
    axes = frame.axes
    if raw.triangles is None and raw.kind == CIRCLE and abs(abs(axes[2, 2]) - 1.0) > _SQUARE:
        return raw_seen(raw._replace(triangles=_bar(raw), kind=CELLS), frame)
    if (
        raw.triangles is None
        and raw.kind == RECTANGLE
        and not (np.abs(np.abs(axes).max(axis=0) - 1.0) <= _SQUARE).all()
    ):
        return raw_seen(raw._replace(triangles=_box(raw.box), kind=CELLS), frame)
    if raw.triangles is not None:
        points = (raw.triangles.reshape(-1, 3) - frame.zero) @ axes
        return Raw(_around(points), CELLS, (0.0, 0.0, 0.0), np.ascontiguousarray(points.reshape(raw.triangles.shape)))
    corners = np.array(list(itertools.product(*raw.box)))
    square = np.where(np.abs(axes) <= _SQUARE, 0.0, axes)
    box = _around((corners - frame.zero) @ (np.round(square) if raw.kind == RECTANGLE else square))
    if raw.kind == RECTANGLE:
        return Raw(box, RECTANGLE, raw.circle, None)
    middle = (np.array([raw.circle[0], raw.circle[1], 0.0]) - frame.zero) @ square
    (x, y), r = (float(v) for v in middle[:2]), raw.circle[2]
    return Raw(((x - r, x + r), (y - r, y + r), box[2]), CIRCLE, (x, y, r), None)


def box_of(ends: FloatArray) -> Box:
    """A box of its least and greatest x, y, z, shape (3, 2)."""
    x, y, z = ((float(low), float(high)) for low, high in ends)
    return x, y, z


def _around(points: FloatArray) -> Box:
    return box_of(np.column_stack([points.min(axis=0), points.max(axis=0)]))


def _box(box: Box) -> FloatArray:
    """Triangles of a box [m], shape (12, 3, 3)."""
    corner = np.array(list(itertools.product(*box)))
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array([corner[[a, b, c]] for i, j, k, n in sides for a, b, c in ((i, j, k), (i, k, n))])


def _bar(raw: Raw) -> FloatArray:
    """Triangles of a round bar, within a chord of the round [m], shape (n, 3, 3)."""
    x, y, r = raw.circle
    low, high = raw.box[2]
    count = max(12, math.ceil(math.pi / math.acos(max(1.0 - _CHORD / r, 0.0))))
    turn = 2.0 * math.pi * np.arange(count + 1) / count
    rim = np.column_stack([x + r * np.cos(turn), y + r * np.sin(turn)])
    found = []
    for a, b in itertools.pairwise(rim.tolist()):
        found += [[(*a, low), (*b, low), (*b, high)], [(*a, low), (*b, high), (*a, high)]]
        found += [[(x, y, high), (*a, high), (*b, high)], [(x, y, low), (*b, low), (*a, low)]]
    return np.array(found)


def automatic_grid(raw: Raw, radii: Sequence[float]) -> float:
    """A quarter of the smallest tool radius, or a hundredth of the shorter side, whichever is less [m]."""
    sides = [high - low for low, high in raw.box[:2]]
    return min(min(radii) / 4.0, min(sides) / 100.0)


def room_for(raw: Raw, grid: float, moves: int, samples: int) -> float:
    """Memory that map, moves and samples take [bytes]."""
    cells = math.prod(math.ceil((high - low) / grid) + 20 for low, high in raw.box[:2])
    return (
        cells * (_FILE_CELL_BYTES if raw.kind == CELLS else _CELL_BYTES) + moves * _MOVE_BYTES + samples * _SAMPLE_BYTES
    )


def grid_within(raw: Raw, limit: float, moves: int, samples: int) -> float:
    """The finest grid that stays inside a limit of memory [m]; infinite if none does."""
    if room_for(raw, max(high - low for low, high in raw.box[:2]), moves, samples) > limit:
        return math.inf
    fine, coarse = 1e-7, max(high - low for low, high in raw.box[:2])
    for _ in range(60):
        middle = math.sqrt(fine * coarse)
        if room_for(raw, middle, moves, samples) > limit:
            fine = middle
        else:
            coarse = middle
    return coarse


def chosen_grid(
    raw: Raw, asked: float | str, radii: Sequence[float], limit_mb: int, moves: int, samples: int
) -> tuple[float, bool]:
    """The grid [m], and whether it is wider than it should be because of memory.

    Raises
    ------
    ScenarioFault
        A given grid, or any, needs more memory than allowed; the message names the grid that fits.
    """
    limit = 1e6 * limit_mb
    fits = grid_within(raw, limit, moves, samples)
    key = ("numerics", "stock", "memory_limit")
    if math.isinf(fits):
        raise ScenarioFault(
            [Fault(key, f"{limit_mb} MB do not hold the {moves} moves and {samples} samples; raise it")]
        )
    if isinstance(asked, str):
        wanted = automatic_grid(raw, radii)
        return max(wanted, fits), fits > wanted
    if room_for(raw, asked, moves, samples) > limit:
        needed = math.ceil(room_for(raw, asked, moves, samples) / 1e6)
        raise ScenarioFault([Fault(("numerics", "stock", "grid"), (
            f"{units.show(asked, 'length')} takes {needed} MB, more than memory_limit ({limit_mb} MB); "
            f"{units.show(1.01 * fits, 'length', 3)} "
            f"fits, or write memory_limit: {needed}"
        ))])  # fmt: skip
    return asked, False


def material_of(raw: Raw, grid: float) -> Material:
    """Stock as a map of a grid."""
    cells = layout(raw.box[0], raw.box[1], grid)
    outline = Outline(raw.kind, *raw.circle)
    bottom, top = raw.box[2]
    if raw.triangles is None:
        share = np.ones((cells.along, cells.across))
        if raw.kind == CIRCLE:
            share = _round_share(cells.x, cells.y, cells.dx, cells.dy, share.shape, raw.circle)
        return Material(height_map(cells, share, bottom, top), outline, 0.0)
    x, y = cell_middles(cells)
    found = columns(raw.triangles, x[2 : 2 + cells.across], y[2 : 2 + cells.along])
    there = found.thickness > 0.0
    hollow = np.where(there, found.top - found.bottom - found.thickness, 0.0)
    filled = float(hollow.clip(0.0).sum() * cells.dx * cells.dy)
    return Material(height_map(cells, there.astype(float), found.bottom, found.top), outline, filled)


def _round_share(
    x: float, y: float, dx: float, dy: float, shape: tuple[int, int], circle: tuple[float, float, float]
) -> FloatArray:
    """Share of each cell that is inside a circle; those on its rim by parts of a cell."""
    rows, columns_ = np.indices(shape)
    u, v = x + dx * (columns_ + 0.5) - circle[0], y + dy * (rows + 0.5) - circle[1]
    away = np.hypot(u, v)
    share = (away <= circle[2]).astype(float)
    rim = np.abs(away - circle[2]) <= 0.7072 * max(dx, dy)
    part = (np.arange(_FINE) + 0.5) / _FINE - 0.5
    a, b = u[rim][:, None, None] + dx * part[:, None], v[rim][:, None, None] + dy * part[None, :]
    share[rim] = (a * a + b * b <= circle[2] ** 2).mean(axis=(1, 2))
    return np.asarray(share)
