"""Centre paths of pocket corners, and the rounding of corners within a tolerance."""

import math
from collections.abc import Sequence

import numpy as np

from cutwise.maths.linearc import Block, arc, line

_CORNER = 1e-4  # [rad] joints that turn less are smooth


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


def blended(blocks: Sequence[Block], tolerance: Sequence[float]) -> tuple[list[Block], list[int]]:
    """Corners between straight blocks rounded within a tolerance (G64 P).

    The arc takes at most half of either block. Corners that touch an arc stay as they are.

    Parameters
    ----------
    blocks : sequence of Block
        The path.
    tolerance : sequence of float
        For each inner joint [m]; 0 leaves the corner.

    Returns
    -------
    tuple
        The path, and for each of its blocks the number of the block that it came from.
    """
    starts = [np.array(block.start) for block in blocks]
    lines = [math.isinf(block.radius) for block in blocks]
    ends = [s + b.length * np.array(b.along) for s, b in zip(starts, blocks, strict=True)]
    rounds: list[Block | None] = [None] * len(blocks)
    trim = [[0.0, 0.0] for _ in blocks]
    for i, allowed in enumerate(tolerance):
        if allowed <= 0.0 or not (lines[i] and lines[i + 1]):
            continue
        d0, d1 = np.array(blocks[i].along), np.array(blocks[i + 1].along)
        normal = np.cross(d0, d1)
        turn = math.atan2(float(np.linalg.norm(normal)), float(d0 @ d1))
        if turn < _CORNER or turn > math.pi - 1e-3:
            continue
        reach = blend_radius(allowed, turn) * math.tan(0.5 * turn)
        reach = min(reach, 0.5 * blocks[i].length, 0.5 * blocks[i + 1].length)
        radius = reach / math.tan(0.5 * turn)
        axis = normal / np.linalg.norm(normal)
        begin = ends[i] - reach * d0
        rounds[i] = arc(begin, begin + radius * np.cross(axis, d0), turn, axis)
        trim[i][1], trim[i + 1][0] = reach, reach
    path: list[Block] = []
    origin: list[int] = []
    for i, block in enumerate(blocks):
        if lines[i]:
            d = np.array(block.along)
            a, b = starts[i] + trim[i][0] * d, ends[i] - trim[i][1] * d
            if float((b - a) @ d) > 1e-9:
                path.append(line(a, b) if any(trim[i]) else block)
                origin.append(i)
        else:
            path.append(block)
            origin.append(i)
        if rounds[i] is not None:
            path.append(rounds[i])  # type: ignore[arg-type]
            origin.append(i)
    return path, origin
