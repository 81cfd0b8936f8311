"""The worst places of a history, and how far a deflection is magnified so that it can be seen."""

import math

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
MOST = 8


def badness(values: FloatArray, low: float | None, high: float | None) -> FloatArray:
    """Amount beyond the limit, v - high or low - v, negative within; without limits the magnitude. NaN where missing."""
    if low is None and high is None:
        return np.abs(values)
    over = values - high if high is not None else np.full(values.shape, -np.inf)
    under = low - values if low is not None else np.full(values.shape, -np.inf)
    return np.asarray(np.maximum(over, under))


def worst(
    bad: FloatArray, place: FloatArray, line: npt.NDArray[np.int64] | None, apart: float, most: int = MOST
) -> list[int]:
    """Samples of the worst places: the greatest badness first, of equal ones the earliest.

    A sample nearer than ``apart`` to a place that is kept already, or on its line of the program, is left out.

    Parameters
    ----------
    bad : array, shape (n,)
        From :func:`badness`; NaN is passed over.
    place : array, shape (n, 3)
        Where the samples are [m].
    line : array, shape (n,), optional
        Line of the program, 0 where there is none.
    apart : float
        One diameter of the tool [m].

    Examples
    --------
    >>> worst(np.array([1.0, 3.0, 3.0, 2.0]), np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0], [5, 0, 0]]), None, 2.0)
    [1, 3]
    """
    left = np.where(np.isnan(bad), -np.inf, bad)
    found: list[int] = []
    while len(found) < most and left.size:
        best = int(left.argmax())
        if left[best] == -np.inf:
            break
        found.append(best)
        near = np.linalg.norm(place - place[best], axis=1) < apart
        near[best] = True
        if line is not None and line[best] > 0:
            near |= line == line[best]
        left = np.where(near, -np.inf, left)
    return found


def magnification(radius: float, largest: float) -> float:
    """Times that a deflection is drawn: of 1, 2, 5, 10 ... the one not above a quarter of the tool's radius over it.

    Parameters
    ----------
    radius : float
        Radius of the tool, in the unit of ``largest``.
    largest : float
        Largest deflection of the run; nothing is drawn once.

    Examples
    --------
    >>> [magnification(*given) for given in ((10.0, 0.0306), (10.0, 0.125), (6.0, 2.554))]
    [50.0, 20.0, 1.0]
    """
    if not largest > 0.0:
        return 1.0
    most = 0.25 * radius / largest * (1.0 + 1e-9)
    if most < 1.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(most))
    return max(1.0, *(step * power for step in (1.0, 2.0, 5.0) if step * power <= most))
