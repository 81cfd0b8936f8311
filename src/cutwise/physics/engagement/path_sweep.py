"""Earlier moves of a flat end mill as pieces of lines, arcs and helices, with a tree that finds those near a place."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import LineArc, at_blocks

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_CHORD = 0.1e-6  # [m] by which lines may miss a curve that is neither line nor arc of the plane
_SAME = 2e-13  # [m] by which a block may miss the way of the block before it to be one piece with it
_UPRIGHT = 1e-12  # [m] in the plane: a block with less goes along z; also 1 less the part of an arc's axis along z
_HELIX = math.pi  # [rad] of a helix in one piece at most, so that it passes over no place twice
_SWEEP = math.pi / 4  # [rad] of an arc in one box at most
_SPARE_BOXES = 50_000  # boxes for long pieces beyond four a piece; with fewer they would only be longer


class Swept(NamedTuple):
    """Moves in their order as ``n`` pieces, cut into ``m`` stretches whose boxes make a tree in that order."""

    start: FloatArray  # [m], shape (n, 2)
    along: FloatArray  # unit tangent at the start, shape (n, 2)
    turn: FloatArray  # curvature, positive to the left, 0 on a line [1/m], shape (n,)
    length: FloatArray  # in the plane [m], shape (n,)
    height: FloatArray  # of the tip at the start [m], shape (n,)
    rise: FloatArray  # from there to the end, even along the length [m], shape (n,)
    way: FloatArray  # arc length of the whole path at its start [m], shape (n,)
    way_length: FloatArray  # of the piece along the path, rise included [m], shape (n,)
    radius: float  # of the mill [m]
    piece: IntArray  # that each stretch belongs to, shape (m,)
    first: IntArray  # first stretch of each piece, shape (n + 1,)
    tree: FloatArray  # x, y from, x, y to, lowest tip [m]; the children of row i are 2 i and 2 i + 1, stretches last


def swept_path(curve: LineArc, radius: float) -> Swept:
    """The pieces of a path and their tree; blocks that go along z only sweep their own place.

    Lines, arcs about z and helices are kept as they are, and blocks that go straight on are one piece. Other curves
    become lines that miss them by 0.1 µm at most.

    Parameters
    ----------
    curve : LineArc
        The path, rapid moves too [m].
    radius : float
        Of the mill [m].

    Examples
    --------
    >>> from cutwise.maths.linearc import join, line
    >>> swept = swept_path(join([line((0, 0, 0), (0.1, 0, 0)), line((0.1, 0, 0), (0.2, 0, 0))]), 5e-3)
    >>> len(swept.height), swept.way_length.round(9).tolist()  # one piece
    (1, [0.2])

    References
    ----------
    Derived here.
    """
    table = _joined(_pieces(curve))
    first, piece, boxes = _stretches(table, radius)
    columns = (np.ascontiguousarray(table[:, :2]), np.ascontiguousarray(table[:, 2:4]), *table.T[4:].copy())
    return Swept(*columns, radius, piece, first, _tree(boxes))  # type: ignore[call-arg]


def _pieces(curve: LineArc) -> FloatArray:
    """Rows (start, along, curvature, flat length, height, rise, way, way length) of all blocks, shape (n, 10)."""
    blocks = np.arange(curve.count)
    straight, length = curve.straight, curve.length
    axis_z = curve.along[:, 0] * curve.inward[:, 1] - curve.along[:, 1] * curve.inward[:, 0]
    arcs = ~straight & (curve.sharpness == 0.0) & (np.abs(axis_z) > 1.0 - _UPRIGHT)
    bend = np.where(straight | arcs, 0.0, np.abs(curve.curvature))
    count = np.maximum(1, np.ceil(length * np.sqrt(bend / (8.0 * _CHORD)))).astype(np.int64)
    rises = arcs & (np.abs(curve.climb[:, 2]) > 0.0)
    turned = np.where(rises, length * curve.share / np.where(rises, curve.radius, 1.0), 0.0)
    count = np.maximum(count, np.ceil(turned / (_HELIX * (1.0 + 1e-9))).astype(np.int64))
    block = np.repeat(blocks, count)
    share = (np.arange(block.size) - np.repeat(np.cumsum(count) - count, count)) / count[block]
    begin, end = share * length[block], (share + 1.0 / count[block]) * length[block]
    point, tangent = at_blocks(curve, block, begin)
    last, _ = at_blocks(curve, block, end)
    step, bent = last - point, arcs[block]
    flat = np.where(bent, curve.share[block] * (end - begin), np.hypot(step[:, 0], step[:, 1]))
    upright = flat < _UPRIGHT
    flat[upright] = 0.0
    along = np.where(bent[:, None], tangent[:, :2], step[:, :2])
    along = np.where(upright[:, None], [1.0, 0.0], along)
    along /= np.hypot(along[:, 0], along[:, 1])[:, None]
    turn = np.where(bent, np.sign(axis_z[block]) / curve.radius[block], 0.0)
    height = np.where(upright, np.minimum(point[:, 2], last[:, 2]), point[:, 2])  # a place is clear down to its lowest
    rise = np.where(upright, 0.0, step[:, 2])
    return np.column_stack(
        (point[:, :2], along, turn, flat, height, rise, curve.knots[block] + begin, end - begin)
    )  # fmt: skip


@compiled
def _reached(row: FloatArray, s: float) -> tuple[float, float, float, float]:
    """Point and tangent of a piece at a length in the plane [m]."""
    tx, ty, turn = row[2], row[3], row[4]
    a, b, c, d = s, 0.0, 1.0, 0.0
    if turn != 0.0:
        half = math.sin(0.5 * s * turn)
        a, b, c, d = math.sin(s * turn) / turn, 2.0 * half * half / turn, math.cos(s * turn), math.sin(s * turn)
    return row[0] + a * tx - b * ty, row[1] + a * ty + b * tx, c * tx - d * ty, c * ty + d * tx


@compiled
def _joined(table: FloatArray) -> FloatArray:
    """Pieces that go on along the same line, arc or helix (of half a turn at most) as one."""
    out = np.empty_like(table)
    n = 0
    for j in range(table.shape[0]):
        row, joins = table[j], False
        if n > 0 and row[5] > 0.0 and out[n - 1, 5] > 0.0 and abs(row[4] - out[n - 1, 4]) * row[5] ** 2 < _SAME:
            run = out[n - 1]
            x, y, tx, ty = _reached(run, run[5])
            slope = run[7] / run[5]
            apart = max(abs(x - row[0]), abs(y - row[1]), abs(run[6] + run[7] - row[6]))
            turned = max(abs(tx - row[2]), abs(ty - row[3])) * row[5]
            short = row[4] == 0.0 or row[7] == 0.0 or (run[5] + row[5]) * abs(row[4]) <= _HELIX * (1.0 + 1e-9)
            joins = short and apart < _SAME and turned < _SAME and abs(row[7] - slope * row[5]) < _SAME
        if joins:
            out[n - 1, 5] += row[5]
            out[n - 1, 7] += row[7]
            out[n - 1, 9] += row[9]
        else:
            out[n] = row
            n += 1
    return out[:n].copy()


def _stretches(table: FloatArray, radius: float) -> tuple[IntArray, IntArray, FloatArray]:
    """First stretch of each piece, the piece of each stretch, and boxes of their centres with the lowest tip."""
    turn, length = table[:, 4], table[:, 5]
    longest = max(radius, float(length.sum()) / (4 * len(table) + _SPARE_BOXES))
    count = np.maximum(1, np.ceil(np.maximum(length / longest, np.abs(length * turn) / _SWEEP))).astype(np.int64)
    first = np.concatenate(([0], np.cumsum(count)))
    piece = np.repeat(np.arange(len(table)), count)
    share = (np.arange(piece.size) - first[piece]) / count[piece]
    ends = np.array([_points(table[piece], s * length[piece]) for s in (share, share + 1.0 / count[piece])])
    bend = np.abs(turn[piece])
    sagitta = np.where(bend > 0.0, 1.0 - np.cos(0.5 * bend * length[piece] / count[piece]), 0.0)
    sagitta /= np.where(bend > 0.0, bend, 1.0)
    lowest = table[piece, 6] + np.minimum(table[piece, 7] * share, table[piece, 7] * (share + 1.0 / count[piece]))
    low, high = ends.min(axis=0) - sagitta[:, None], ends.max(axis=0) + sagitta[:, None]
    return first, piece, np.column_stack((low, high, lowest))


def _points(rows: FloatArray, s: FloatArray) -> FloatArray:
    """Points of pieces at lengths in the plane [m], shape (m, 2)."""
    tangent, turn = rows[:, 2:4], rows[:, 4]
    angle, safe = s * turn, np.where(turn == 0.0, 1.0, turn)
    a = np.where(turn == 0.0, s, np.sin(angle) / safe)
    b = np.where(turn == 0.0, 0.0, 2.0 * np.sin(0.5 * angle) ** 2 / safe)
    return rows[:, :2] + a[:, None] * tangent + b[:, None] * np.column_stack((-tangent[:, 1], tangent[:, 0]))


def _tree(boxes: FloatArray) -> FloatArray:
    """Boxes of all stretches below each node; places without a stretch are empty and infinitely far."""
    size = 1 << max(0, math.ceil(math.log2(len(boxes))))
    tree = np.full((2 * size, 5), np.inf)
    tree[:, 2:4] = -np.inf
    tree[size : size + len(boxes)] = boxes
    while size > 1:
        pairs = tree[size : 2 * size].reshape(-1, 2, 5)
        size //= 2
        tree[size : 2 * size] = pairs.min(axis=1)
        tree[size : 2 * size, 2:4] = pairs[:, :, 2:4].max(axis=1)
    return tree
