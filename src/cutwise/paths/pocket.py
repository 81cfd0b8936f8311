"""Centre paths of pocket corners, and the rounding of corners within a tolerance."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import Block, arc, clothoid, clothoid_point, line

_CORNER = 1e-4  # [rad] joints that turn less are smooth


class Rounding(NamedTuple):
    """What takes the place of a corner."""

    blocks: list[Block]
    reach: float  # [m] that it takes of either line
    wanted: float  # [m] that it would take if the lines were longer


class Blended(NamedTuple):
    """A path with its corners rounded."""

    blocks: list[Block]
    origin: list[int]  # for each of them the number of the block that it came from
    cut_short: int  # roundings that are smaller than their tolerance allows, because the lines are short


def corner(lead: float, turn: float, fillet: float) -> list[Block]:
    """Along +x to the corner point (0, 0), left by ``turn`` [rad] about an arc of radius ``fillet`` [m], and on.

    Both legs reach ``lead`` [m] from the corner point; a fillet of zero is a sharp corner.
    """
    dx, dy = math.cos(turn), math.sin(turn)
    start, end = (-lead, 0.0), (lead * dx, lead * dy)
    if fillet == 0.0:
        return [line(start, (0.0, 0.0)), line((0.0, 0.0), end)]
    cut = fillet * math.tan(0.5 * turn)
    return [
        line(start, (-cut, 0.0)),
        arc((-cut, 0.0), (-cut, fillet), turn),
        line((cut * dx, cut * dy), end),
    ]


def blend_radius(tolerance: float, turn: float) -> float:
    r"""Radius of the arc that leaves a corner by no more than a tolerance.

    .. math:: r = \epsilon \frac{\cos(\theta/2)}{1 - \cos(\theta/2)}

    ``tolerance`` :math:`\epsilon` [m], ``turn`` :math:`\theta` between the directions [rad], above 0 and below pi.
    """
    half = math.cos(0.5 * turn)
    return tolerance * half / (1.0 - half)


def _round_arc(corner: FloatArray, d0: FloatArray, d1: FloatArray, allowed: float, room: float) -> Rounding:
    """Arc within a tolerance of a corner, taking no more than ``room`` of either line [m]."""
    turn, axis = _turn(d0, d1)
    wanted = blend_radius(allowed, turn) * math.tan(0.5 * turn)
    reach = min(wanted, room)
    radius = reach / math.tan(0.5 * turn)
    begin = corner - reach * d0
    return Rounding([arc(begin, begin + radius * np.cross(axis, d0), turn, axis)], reach, wanted)


def _round_clothoids(corner: FloatArray, d0: FloatArray, d1: FloatArray, allowed: float, room: float) -> Rounding:
    r"""Two equal clothoids, the curvature rising evenly to the middle and falling again, so that it nowhere jumps.

    With :math:`(x, y) = \int_0^1 (\cos, \sin)(\theta u^2/2)\,du` a pair of length L each leaves the corner by
    :math:`\epsilon = L\,y / \cos(\theta/2)` and takes :math:`L\,(x + y \tan(\theta/2))` of either line.
    """
    turn, axis = _turn(d0, d1)
    x, y = clothoid_point(0.0, turn, 1.0)
    taken = x + y * math.tan(0.5 * turn)
    wanted = allowed * math.cos(0.5 * turn) / y
    length = min(wanted, room / taken)
    begin, peak = corner - length * taken * d0, turn / length
    inward = np.cross(axis, d0)
    middle = begin + length * (x * d0 + y * inward)
    c, s = math.cos(0.5 * turn), math.sin(0.5 * turn)
    halves = [
        clothoid(begin, d0, inward, length, 0.0, peak),
        clothoid(middle, c * d0 + s * inward, c * inward - s * d0, length, peak, 0.0),
    ]
    return Rounding(halves, length * taken, wanted * taken)


def _turn(d0: FloatArray, d1: FloatArray) -> tuple[float, FloatArray]:
    """Angle between two directions [rad], and the unit axis of the turn."""
    normal = np.cross(d0, d1)
    size = float(np.linalg.norm(normal))
    return math.atan2(size, float(d0 @ d1)), normal / max(size, 1e-300)


_ROUND = {"arc": _round_arc, "clothoid": _round_clothoids}


def blended(blocks: Sequence[Block], tolerance: Sequence[float], shape: str = "arc") -> Blended:
    """Corners between straight blocks rounded within a tolerance (G64 P).

    The rounding takes at most half of either block. Corners that touch an arc stay as they are.

    Parameters
    ----------
    blocks : sequence of Block
        The path.
    tolerance : sequence of float
        For each inner joint [m]; 0 leaves the corner.
    shape : str
        ``arc``, whose curvature jumps at its ends, or ``clothoid``, a pair of them, whose curvature does not.
    """
    starts = [np.array(block.start) for block in blocks]
    lines = [block.straight for block in blocks]
    ends = [s + b.length * np.array(b.along) for s, b in zip(starts, blocks, strict=True)]
    rounds: list[list[Block]] = [[] for _ in blocks]
    trim = [[0.0, 0.0] for _ in blocks]
    cut_short = 0
    for i, allowed in enumerate(tolerance):
        if allowed <= 0.0 or not (lines[i] and lines[i + 1]):
            continue
        d0, d1 = np.array(blocks[i].along), np.array(blocks[i + 1].along)
        if not _CORNER <= _turn(d0, d1)[0] <= math.pi - 1e-3:
            continue
        room = 0.5 * min(blocks[i].length, blocks[i + 1].length)
        rounds[i], reach, wanted = _ROUND[shape](ends[i], d0, d1, allowed, room)
        trim[i][1], trim[i + 1][0] = reach, reach
        cut_short += reach < wanted * (1.0 - 1e-9)
    path: list[Block] = []
    origin: list[int] = []
    for i, block in enumerate(blocks):
        kept = block
        if lines[i] and any(trim[i]):
            d = np.array(block.along)
            a, b = starts[i] + trim[i][0] * d, ends[i] - trim[i][1] * d
            kept = line(a, b) if float((b - a) @ d) > 1e-9 else None  # type: ignore[assignment]
        parts = [*([kept] if kept is not None else []), *rounds[i]]
        path += parts
        origin += [i] * len(parts)
    return Blended(path, origin, cut_short)
