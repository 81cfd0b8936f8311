"""Long histories with fewer samples: extremes and ends of each bucket stay exact."""

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
import numpy.typing as npt


def kept(histories: Iterable[npt.NDArray[np.float64]], buckets: int) -> npt.NDArray[np.int64]:
    """The samples that stay, in the order of time: of each bucket and history the first, least, greatest and last.

    Parameters
    ----------
    histories : iterable of array, shape (n,)
        All of one clock; what is missing (NaN) is neither least nor greatest.
    buckets : int
        Number B of buckets of equal count, with borders at floor(k n / B).

    Examples
    --------
    >>> kept([np.array([0.0, 3.0, -1.0, 2.0, 2.5, 7.0, 1.0, 1.0])], 2).tolist()
    [0, 1, 2, 3, 4, 5, 6, 7]
    >>> kept([np.array([0.0, 0.1, 3.0, 0.2, -1.0, 0.3, 2.0, 0.0])], 1).tolist()
    [0, 2, 4, 7]
    """
    found: set[int] = set()
    for values in histories:
        count = values.size
        borders = np.unique(np.arange(buckets + 1) * count // buckets)
        low, high = np.where(np.isnan(values), np.inf, values), np.where(np.isnan(values), -np.inf, values)
        for start, stop in pairwise(borders.tolist()):
            found |= {start, start + int(low[start:stop].argmin()), start + int(high[start:stop].argmax()), stop - 1}
    return np.array(sorted(found), np.int64)


def halved(values: npt.NDArray[np.float64], error: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """A map with half the rows and columns: a coarse cell takes the value where the error is greatest in magnitude.

    Where no cell has an error it takes the first one that has a value. ``values`` may be the error itself.

    Examples
    --------
    >>> e = np.array([[1.0, -3.0, np.nan], [2.0, 0.0, np.nan], [4.0, -4.0, 5.0]])
    >>> halved(e, e).tolist()
    [[-3.0, nan], [4.0, 5.0]]
    """
    rows, columns = -(-values.shape[0] // 2), -(-values.shape[1] // 2)
    padding = ((0, 2 * rows - values.shape[0]), (0, 2 * columns - values.shape[1]))

    def cells(array: npt.NDArray[np.float64], fill: float) -> npt.NDArray[np.float64]:
        wide = np.pad(array, padding, constant_values=fill)
        return wide.reshape(rows, 2, columns, 2).swapaxes(1, 2).reshape(rows, columns, 4)

    size = np.where(np.isnan(error), -1.0, np.abs(error))
    size = np.where(np.isnan(values) & (size < 0.0), -2.0, size)
    chosen = cells(size, -3.0).argmax(axis=2)
    return np.take_along_axis(cells(values, np.nan), chosen[:, :, None], axis=2)[:, :, 0]
