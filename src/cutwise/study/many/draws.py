r"""The numbers of a study: the same for any order of the cases, any number of workers and after any restart.

Every number is a word of a counter-based generator (Philox), found from seed, case and input alone; a quasi-random
point is a point of a Sobol net, shifted digitally by such words.
"""

import warnings

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.fields import shares

FloatArray = NDArray[np.float64]

NETS = 8
"""Independently shifted nets; their scatter tells how sure a mean over all of them is."""

_BITS = 30
_NETS_FROM = 2**32  # second key of the shifts; inputs have those below
_OTHERS_FROM = 2**34  # and of all other draws
BOOTSTRAP, MORRIS, HYPERCUBE, OPTIMISER = range(4)
LEVELS_FROM = 16  # of rare failures, one more for each level


def generator(seed: int, purpose: int) -> np.random.Generator:
    """Numbers for anything but the inputs of cases: ``BOOTSTRAP``, ``MORRIS``, ``HYPERCUBE``, ``OPTIMISER``, levels."""
    return np.random.Generator(np.random.Philox(key=[seed, _OTHERS_FROM + purpose]))


def uniforms(seed: int, inputs: int, first: int, count: int) -> FloatArray:
    r"""Independent numbers in (0, 1) of some cases, shape (count, inputs).

    Input j of case k is :math:`u = (\lfloor w / 2^{11} \rfloor + 1/2)\, 2^{-53}` with w the word j mod 4 of counter k
    under the key (seed, j div 4).

    >>> uniforms(1, 5, 0, 1)[0, [0, 1, 4]].round(15).tolist()
    [0.303568034306759, 0.848708749685777, 0.075151151095911]
    """
    found = np.empty((count, inputs))
    for group in range(0, inputs, 4):
        words = np.random.Philox(key=[seed, group // 4], counter=[first, 0, 0, 0]).random_raw(4 * count)
        found[:, group : group + 4] = shares(words).reshape(count, 4)[:, : inputs - group]
    return found


def shuffled(numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Whole numbers as if drawn at random, the same for the same ones (the mixing of SplitMix64, Steele et al. 2014)."""
    mixed = numbers.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return ((mixed ^ (mixed >> np.uint64(31))) >> np.uint64(1)).astype(np.int64)


def _shifts(seed: int, net: int, inputs: int) -> NDArray[np.int64]:
    groups = -(-inputs // 4)
    words = np.random.Philox(key=[seed, _NETS_FROM + net], counter=[0, 0, 0, 0]).random_raw(4 * groups)
    return (words >> np.uint64(34)).astype(np.int64)[:inputs]


def net_points(seed: int, inputs: int, net: int, first: int, count: int) -> FloatArray:
    """Some points of one shifted Sobol net, shape (count, inputs).

    >>> net_points(1, 3, 0, 0, 2).round(15).tolist()[0]
    [0.197059839498252, 0.488053425680846, 0.991465739440173]
    """
    from scipy.stats import qmc  # half of what a worker loads; independent draws do without

    plain = qmc.Sobol(inputs, scramble=False, bits=_BITS)
    with warnings.catch_warnings():  # that a part of a net is not balanced: the whole is
        warnings.simplefilter("ignore", UserWarning)
        if first:
            plain.fast_forward(first)
        found = plain.random(count)
    whole = np.rint(found * 2.0**_BITS).astype(np.int64)
    return np.asarray(((whole ^ _shifts(seed, net, inputs)) + 0.5) * 2.0**-_BITS)


def shifted_nets(seed: int, inputs: int, first: int, count: int) -> FloatArray:
    """Some points of the eight nets in turn: case k is point k div 8 of net k mod 8; shape (count, inputs)."""
    case = np.arange(first, first + count)
    low = first // NETS
    each = case[-1] // NETS - low + 1
    found = np.empty((count, inputs))
    for net in range(NETS):
        mine = case % NETS == net
        found[mine] = net_points(seed, inputs, net, low, each)[case[mine] // NETS - low]
    return found


def next_size(cases: int, step: int) -> int:
    """The least ``step`` times a power of two that holds so many cases."""
    size = step
    while size < cases:
        size *= 2
    return size
