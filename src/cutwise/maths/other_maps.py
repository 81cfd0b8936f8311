"""Maps of the set-ups before, end to end in a few arrays: one loop for any number of them.

A tuple of maps makes the compiler write every loop anew for each length, and hands some hundred numbers a map from call to call:
runs on four maps took six times as long as on two.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import inlined_stepping
from cutwise.maths.envelopes import COLUMNS, Segments
from cutwise.maths.height_map import Float32Array, HeightMap, Held, Int32Array, Layout
from cutwise.maths.profiles import Cutters
from cutwise.maths.solid import Outline, Solid

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class OtherMaps(NamedTuple):
    """Numbers of ``k`` maps, and their arrays end to end."""

    real: FloatArray  # x, y, dx, dy of the layout; x, y, radius of the outline [m], shape (k, 7)
    whole: IntArray  # cells across and along, blocks across and along; kind of the outline, shape (k, 5)
    end: IntArray  # ends of the arrays of map j, in the order in which they are named below, shape (k + 1, 14)
    height: Float32Array  # as :class:`cutwise.maths.height_map.HeightMap`, of all maps
    cutter: Int32Array
    highest: Float32Array
    share: Float32Array
    bottom: FloatArray
    top: Float32Array
    held_first: IntArray
    held_low: FloatArray
    held_high: FloatArray
    row: FloatArray  # as :class:`cutwise.maths.envelopes.Segments`
    first: IntArray
    piece: FloatArray  # as :class:`cutwise.maths.profiles.Cutters`
    tool: IntArray
    radius: FloatArray


def _numbers(one: Solid) -> tuple[list[float], list[int]]:
    grid, outline = one.map.layout, one.outline
    return [*grid[:4], outline.x, outline.y, outline.radius], [*grid[4:], outline.kind]


def _arrays(one: Solid) -> list[npt.NDArray[np.generic]]:
    left, held = one.map, one.map.held
    return [
        left.height, left.cutter, left.highest, left.share, left.bottom, left.top, held.first, held.low, held.high,
        one.path.row, one.path.first, one.tools.piece, one.tools.first, one.tools.radius,
    ]  # fmt: skip


_KINDS = ("f4", "i4", "f4", "f4", "f8", "f4", "i8", "f8", "f8", "f8", "i8", "f8", "i8", "f8")
_WIDE = {9: COLUMNS, 11: 5}  # arrays of rows


def end_to_end(solids: Sequence[Solid]) -> OtherMaps:
    """Maps behind one another; none are valid, too."""
    arrays = [_arrays(one) for one in solids]
    sizes = np.array([[len(array) for array in one] for one in arrays], np.int64).reshape(-1, len(_KINDS))
    ends = np.concatenate((np.zeros((1, len(_KINDS)), np.int64), np.cumsum(sizes, axis=0)))
    told = [_numbers(one) for one in solids]
    none = [np.zeros((0, _WIDE[k]) if k in _WIDE else 0, kind) for k, kind in enumerate(_KINDS)]
    return OtherMaps(
        np.array([real for real, _ in told], float).reshape(-1, 7),
        np.array([whole for _, whole in told], np.int64).reshape(-1, 5),
        ends,
        *(
            np.concatenate([none[k], *(one[k] for one in arrays)]).astype(kind, copy=False)
            for k, kind in enumerate(_KINDS)
        ),
    )


@inlined_stepping
def other_map(maps: OtherMaps, j: int) -> Solid:
    """One of the maps of :func:`end_to_end`, a view: nothing is copied.

    Parameters
    ----------
    maps : OtherMaps
        All of them.
    j : int
        Which.

    Returns
    -------
    Solid
        As it was put in.

    Notes
    -----
    Valid for 0 <= j < k, in kernels that count no references either (:func:`cutwise.maths.compiled.stepping`): any other would let
    go of what it never took hold of. Python takes ``other_map.py_func``, for the same reason. Nothing is checked.

    Examples
    --------
    Of two blocks, 4 and 2 mm wide, the second.

    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.solid import RECTANGLE
    >>> stocks = [height_map(layout((0.0, 8e-3), (0.0, w), 1e-3), np.ones((round(w / 1e-3), 8)), -5e-3, 0.0) for w in (4e-3, 2e-3)]
    >>> none, mill = segments([], []), cutters([flat(1e-3)])
    >>> maps = end_to_end([Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), none, mill) for stock in stocks])
    >>> other_map(maps, 1).map.layout.along, other_map.py_func(maps, 1).map.height.size
    (2, 256)

    References
    ----------
    Derived here.
    """
    r, n, a, b = maps.real[j], maps.whole[j], maps.end[j], maps.end[j + 1]
    held = Held(maps.held_first[a[6] : b[6]], maps.held_low[a[7] : b[7]], maps.held_high[a[8] : b[8]])
    left = HeightMap(
        Layout(r[0], r[1], r[2], r[3], n[0], n[1], n[2], n[3]), maps.height[a[0] : b[0]], maps.cutter[a[1] : b[1]],
        maps.highest[a[2] : b[2]], maps.share[a[3] : b[3]], maps.bottom[a[4] : b[4]], maps.top[a[5] : b[5]], held,
    )  # fmt: skip
    path = Segments(maps.row[a[9] : b[9]], maps.first[a[10] : b[10]])
    tools = Cutters(maps.piece[a[11] : b[11]], maps.tool[a[12] : b[12]], maps.radius[a[13] : b[13]])
    return Solid(left, Outline(n[4], r[4], r[5], r[6]), path, tools)
