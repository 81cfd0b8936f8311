"""Contact at any places along a program in a stock in 3D, as loads of any feed: what a correction of feeds stands on.

The stock is cut move by move as in a run; each place sees what all moves before its own, and its own up to there, have left.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, stepping
from cutwise.maths.map_levels import room
from cutwise.maths.map_sweep import cut_by
from cutwise.maths.workpiece import Workpiece
from cutwise.physics.cutting.affine_limits import SUMS
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.meridian import Chip
from cutwise.physics.cutting.meridian_loads import ANGLES, KEPT, meridian_loads, meridian_sums
from cutwise.physics.engagement.contact_sums import removal
from cutwise.physics.engagement.map_contact import Edge, contact_rows
from cutwise.physics.engagement.map_fan import fan_room
from cutwise.process.nominal_part import tolerance_of
from cutwise.process.stock_earlier import EarlierRun
from cutwise.process.stock_loop import PIECES, place_on
from cutwise.process.stock_material import material_of
from cutwise.process.stock_milling import Earlier, grid_of, stretches, workpiece
from cutwise.process.stock_path import Moves, moves_of
from cutwise.process.stock_plan import Planned
from cutwise.process.stock_setups import Job
from cutwise.results import SolverFailure
from cutwise.spec.milling import MillingScenario

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_SAME = 1e-7  # [rad], and [m]: contact that is the same


class Places(NamedTuple):
    """Places on feed moves in the order of the path, ``n`` of them, and what is found there."""

    first: IntArray  # first place of each move, and their number at the end, shape (moves + 1,)
    segment: IntArray  # on which each is, shape (n,)
    share: FloatArray  # of that segment
    feed: FloatArray  # per tooth, round which loads are looked at closely [m]
    met: IntArray  # rows of contact
    loads: FloatArray  # A [N] and B [N/m] of the largest forces, shape (n, 7, 4)
    rows: IntArray  # of them
    sums: FloatArray  # as :class:`cutwise.physics.cutting.affine_limits.Sums`, shape (n, 10)


@stepping
def _alike(places: Places, n: int, rows: FloatArray, count: int, last: FloatArray) -> bool:
    """Whether a place meets what the one before it met; what it meets is kept for the next."""
    same = n > 0 and places.met[n - 1] == count and places.feed[n] == places.feed[n - 1]
    for i in range(count):
        for k in range(5):
            same = same and abs(rows[i, k] - last[i, k]) <= _SAME
            last[i, k] = rows[i, k]
    return same


@compiled
def _look_along(
    piece: Workpiece, edge: Edge, mill: Mill, k: EdgeCoefficients, starts: FloatArray, ends: FloatArray, places: Places,
    moves: tuple[int, int],
) -> None:  # fmt: skip
    """Moves with one tool: its contact at the places on each, then the sweep."""
    solid = piece.solid
    fan, rows, work = fan_room(), np.empty((PIECES, 5)), room(solid.map.layout)
    angles, last, before = np.empty((ANGLES + 1, 4)), np.zeros((PIECES, 5)), Chip(0.0, 0.0)
    for move in range(moves[0], moves[1]):
        for n in range(places.first[move], places.first[move + 1]):
            place = place_on(solid, starts, ends, move, places.segment[n], places.share[n])
            count = contact_rows(piece, place, edge, fan, rows, True)
            places.met[n] = count
            if count == 0:
                continue
            if np.isinf(place.slope):
                way = Chip(0.0, 1.0 if place.slope > 0.0 else -1.0)
                area = removal(rows, count, edge, place.slope)
            else:
                level = 1.0 / np.sqrt(1.0 + place.slope * place.slope)
                way = Chip(level, place.slope * level)
                area = removal(rows, count, edge, place.slope) * level
            mer = edge.meridian
            if _alike(places, n, rows, count, last) and way == before:
                places.rows[n], places.loads[n], places.sums[n] = (
                    places.rows[n - 1],
                    places.loads[n - 1],
                    places.sums[n - 1],
                )
                continue
            before = way
            places.rows[n] = meridian_loads(rows, count, mer, mill, way, places.feed[n], k, angles, places.loads[n])
            sums = meridian_sums(rows, count, mer, mill, way, k, area)
            for i in range(SUMS):
                places.sums[n, i] = sums[i]
        cut_by(solid.map, solid.path, solid.tools, move, work)


def contact_at(
    scenario: MillingScenario, ready: Planned, job: Job, before: EarlierRun | None, along: FloatArray, feed: FloatArray,
    laws: Sequence[EdgeCoefficients],
) -> Places:  # fmt: skip
    """Contact and loads at places of feed moves.

    Parameters
    ----------
    scenario, ready, job, before
        The program and its set-up, and the run that left the stock, if one did.
    along : array (n,)
        Places on the path in their order, inside its blocks [m].
    feed : array (n,)
        Feed per tooth there [m].
    laws : sequence of EdgeCoefficients
        Linear law of each tool.

    Raises
    ------
    SolverFailure
        A contact in more pieces than there is room for.
    """
    grid, _ = grid_of(scenario, ready)
    left = material_of(ready.raw, grid)
    cell = max(left.map.layout.dx, left.map.layout.dy)
    moves = moves_of(ready.path, ready.tool, ready.feed, 0.1 * tolerance_of(scenario), cell)
    earlier: Sequence[Earlier] = before.swept(grid) if before is not None else ()
    piece = workpiece(left, moves.path, ready.tools.cutting, job.frame, earlier)
    places = _room(moves, along, feed)
    for first, last in stretches(moves.tool):
        tool = int(moves.tool[first])
        edge, mill = ready.tools.edges[tool], ready.tools.mills[tool]
        _look_along(piece, edge, mill, laws[tool], moves.start, moves.end, places, (first, last))
    if (places.met >= PIECES).any():
        raise SolverFailure(
            f"the contact is in more than {PIECES} pieces at some place: fewer numerics.stock.elements help"
        )
    return places


def _room(moves: Moves, along: FloatArray, feed: FloatArray) -> Places:
    """Places on the segments of moves, and room for what is found."""
    n = along.size
    segment = np.clip(np.searchsorted(moves.along[:, 0], along, side="right") - 1, 0, len(moves.way) - 1)
    begin, end = moves.along[segment].T
    share = np.clip((along - begin) / np.maximum(end - begin, 1e-30), 0.0, 1.0)
    first = np.searchsorted(segment, moves.path.first).astype(np.int64)
    return Places(
        first, segment.astype(np.int64), share, feed, np.zeros(n, np.int64), np.zeros((n, KEPT, 4)), np.zeros(n, np.int64),
        np.zeros((n, SUMS)),
    )  # fmt: skip
