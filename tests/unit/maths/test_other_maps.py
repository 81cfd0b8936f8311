"""Maps end to end are the maps: every array, of any number of them, bit for bit and of the same kind."""

import numpy as np
import pytest

from cutwise.maths.compiled import stepping
from cutwise.maths.other_maps import end_to_end, other_map
from cutwise.maths.profiles import ball, flat
from cutwise.maths.solid import CIRCLE, RECTANGLE, Outline, Solid
from cutwise.maths.workpiece import Frame, maps_of, under
from peers.maps import MM, block, lines, tool


def parts(value):
    """Arrays and numbers of a record, however deep."""
    return [leaf for part in value for leaf in parts(part)] if isinstance(value, tuple) else [value]


@pytest.mark.parametrize("count", [1, 2, 5])
def test_what_is_put_in_comes_out(count):
    solids = []
    for j in range(count):
        path = lines(*[[k, 0, -j] for k in range(j + 2)])
        outline = Outline(CIRCLE if j % 2 else RECTANGLE, j * MM, 2.0 * MM, 3.0 * MM)
        stock = block((0, 8 + j), (0, 4), (-5, 0), 1.0 + 0.5 * j)
        solids.append(Solid(stock, outline, path, tool(ball(2 * MM) if j % 2 else flat(MM))))
    first, frame = block((0, 8), (0, 4), (-5, 0), 1.0), Frame(np.eye(3), np.zeros(3))
    piece = under(
        [Solid(first, solids[0].outline, lines([0, 0, 0], [1, 0, 0]), tool(flat(MM))), *solids],
        [frame] * (count + 1),
        frame,
    )
    for j, (given, solid) in enumerate(zip(maps_of(piece)[1:], solids, strict=True)):
        for one, other in zip(parts(given), parts(solid), strict=True):
            if isinstance(other, np.ndarray):
                assert one.dtype == other.dtype
                assert one.flags.c_contiguous
            np.testing.assert_array_equal(one, other)
        assert sums(end_to_end(solids), j) == pytest.approx(
            [np.sum(a) for a in parts(solid) if isinstance(a, np.ndarray)], rel=1e-5
        )


@stepping
def sums(maps, j):
    """Of the arrays of a map, as a loop sees them."""
    left, _, path, tools = other_map(maps, j)
    held = left.held
    return (
        left.height.sum(), left.cutter.sum(), left.highest.sum(), left.share.sum(), left.bottom.sum(), left.top.sum(),
        held.first.sum(), held.low.sum(), held.high.sum(), path.row.sum(), path.first.sum(), tools.piece.sum(),
        tools.first.sum(), tools.radius.sum(),
    )  # fmt: skip
