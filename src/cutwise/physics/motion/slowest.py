"""The slowest of neighbouring stretches, found in a tree of winners."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class Search(NamedTuple):
    """Finds the slowest of neighbouring stretches: a tree of winners."""

    tree: IntArray  # the slowest below each node; the leaves are the stretches
    key: FloatArray  # speed, infinite once a stretch is put aside [m/s]
    done: npt.NDArray[np.bool_]  # whether its level is run, so that it is put aside for good


@compiled
def lowest(search: Search, low: int, high: int) -> int:
    r"""Which of the stretches from ``low`` to ``high`` is slowest.

    Parameters
    ----------
    search : Search
        The tree.
    low, high : int
        First and last stretch, both asked.

    Returns
    -------
    int
        Number of the stretch, after :math:`2 \log_2 n` comparisons at most. Valid for :math:`0 \le low \le high < n`.

    Examples
    --------
    >>> search = search_of(np.array([3.0, 1.0, 2.0]))
    >>> lowest(search, 0, 2), lowest(search, 2, 2)
    (1, 2)

    References
    ----------
    Tournament tree: Knuth 1998, The Art of Computer Programming 3, sec. 5.2.3.
    """
    tree, key = search.tree, search.key
    size = tree.shape[0] // 2
    best = low
    a, b = low + size, high + size + 1
    while a < b:
        if a & 1:
            if key[tree[a]] < key[best]:
                best = tree[a]
            a += 1
        if b & 1:
            b -= 1
            if key[tree[b]] < key[best]:
                best = tree[b]
        a //= 2
        b //= 2
    return best


@compiled
def rekey(search: Search, i: int, value: float) -> None:
    """Give a stretch another speed in the search for the slowest.

    Parameters
    ----------
    search : Search
        Changed in place.
    i : int
        The stretch.
    value : float
        Its speed [m/s]; infinite puts it aside. Valid for any number but NaN.

    Examples
    --------
    >>> search = search_of(np.array([3.0, 1.0, 2.0]))
    >>> rekey(search, 1, math.inf)
    >>> lowest(search, 0, 2)
    2

    References
    ----------
    Knuth 1998, The Art of Computer Programming 3, sec. 5.2.3.
    """
    tree, key = search.tree, search.key
    key[i] = value
    node = (i + tree.shape[0] // 2) // 2
    while node >= 1:
        a, b = tree[2 * node], tree[2 * node + 1]
        tree[node] = a if key[a] <= key[b] else b
        node //= 2


@compiled
def search_of(speed: FloatArray) -> Search:
    """The search for the slowest stretch, with all of them in it.

    Parameters
    ----------
    speed : array (n,)
        Of the stretches [m/s]; valid for any number but NaN.

    Returns
    -------
    Search
        Tree over the next power of two; the stretches that fill it up are infinitely fast.

    Examples
    --------
    The root of the tree is the slowest of all.

    >>> search = search_of(np.array([3.0, 1.0, 2.0]))
    >>> int(search.tree[1]), search.key.tolist()
    (1, [3.0, 1.0, 2.0, inf])

    References
    ----------
    Knuth 1998, The Art of Computer Programming 3, sec. 5.2.3.
    """
    size = 1
    while size < speed.shape[0]:
        size *= 2
    key = np.full(size, math.inf)
    key[: speed.shape[0]] = speed
    tree = np.zeros(2 * size, np.int64)
    tree[size:] = np.arange(size)
    for node in range(size - 1, 0, -1):
        a, b = tree[2 * node], tree[2 * node + 1]
        tree[node] = a if key[a] <= key[b] else b
    return Search(tree, key, np.zeros(size, np.bool_))
