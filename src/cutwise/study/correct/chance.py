"""What differs from part to part by chance is corrected only as far as its mean stands out of its scatter."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.spec import fields
from cutwise.spec.faults import split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.correct.shift import Plant, judged, seen
from cutwise.study.correct.uncertain import Draw

LEAST = 0.2
"""Weight below which nothing is corrected."""


def weight(mean: FloatArray, deviation: FloatArray) -> FloatArray:
    r"""Share of a mean error that is worth correcting, where parts scatter about it by chance.

    .. math:: w = \frac{\mu^2}{\mu^2 + \sigma^2}, \qquad 0 \text{ for } w < 0.2

    Parameters
    ----------
    mean : ndarray
        :math:`\mu` over the draws [m].
    deviation : ndarray
        :math:`\sigma` of what differs from part to part [m], the same shape.

    Returns
    -------
    ndarray
        w, 0 to 1; 0 where both are zero.

    Notes
    -----
    A correction by w times a mean of n draws leaves a part with :math:`E e^2 = \sigma^2 + (1 - w)^2 \mu^2 + w^2 \sigma^2/n`. For
    n = 1 this weight makes it least, :math:`\sigma^2 + (1 - w)\mu^2`; for any n it is no more than without correction,
    :math:`\sigma^2 + \mu^2`. Against the mean itself it costs no more than :math:`\sigma^2/4`, at :math:`\mu = \sigma`: the
    price of not copying into every part what few draws happen to have in common. With nine draws 0.2 is where the mean is 1.5
    times its own standard error.

    Examples
    --------
    >>> weight(np.array([1.0, 1.0, 1.0, 0.0]), np.array([0.0, 1.0, 2.1, 1.0])).tolist()
    [1.0, 0.5, 0.0, 0.0]

    References
    ----------
    Derived here: the least expected square of a linear estimate (Wiener) from one draw.
    """
    square = np.square(mean)
    both = square + np.square(deviation)
    found = np.divide(square, both, out=np.zeros_like(both), where=both > 0.0)
    return np.where(found < LEAST, 0.0, found)


def keys_of(scenario: Scenario, draws: Sequence[Draw]) -> tuple[str, ...]:
    """Keys of draws whose values are others for each part: those that the scenario says so of (``ByChance``)."""
    found = []
    for key in draws[0] if draws else ():
        info = fields.field_at(type(scenario), split_dotted(key))
        if info is not None and fields.by_chance(info):
            found.append(key)
    return tuple(found)


class Left(NamedTuple):
    """What of the mean error over the draws is left as it is."""

    error: FloatArray | float = 0.0  # (1 - w) mu at the servo instants [m]
    keys: tuple[str, ...] = ()  # that differ by chance
    weight: float = 1.0  # of the mean error as a whole

    def measures(self) -> dict[str, tuple[float, str]]:
        """The weight, where something differs by chance."""
        return {"chance_weight": (self.weight, "dimensionless")} if self.keys else {}

    def told(self) -> Iterator[str]:
        """What differs by chance, and how much of the mean error is worth correcting."""
        if self.keys:
            differ = "differs" if len(self.keys) == 1 else "differ"
            yield (
                f"{' and '.join(self.keys)} {differ} from part to part: {self.weight:.3g} of the mean error is corrected, place "
                f"by place mu^2/(mu^2 + sigma^2), nothing below {LEAST:g}"
            )


def left_alone(
    nominal: Plant, plants: Sequence[Plant], draws: Sequence[Draw], drawn: Callable[[Plant, Draw], Plant]
) -> Left:  # fmt: skip
    """What of the mean error of plants is left, since parts differ by chance.

    What is the same for all parts, known or not, is corrected by its mean; the scatter that counts is that of draws in which
    only what differs by chance is drawn.

    Parameters
    ----------
    nominal : Plant
        Before it is shifted.
    plants : sequence of Plant
        The draws that a shift is made for.
    draws : sequence
        What was drawn for each of them.
    drawn : callable
        The plant of a draw.
    """
    keys = keys_of(nominal.scenario, draws)
    if not keys:
        return Left()
    told = nominal.told
    error = seen(plants, told.order).error
    mean = error.mean(axis=0)
    if len(keys) < len(draws[0]):
        error = seen([drawn(nominal, {key: one[key] for key in keys}) for one in draws], told.order).error
    share = weight(mean, error.std(axis=0, ddof=1))
    counts = judged(told, whole=nominal.walls is not None)
    size = np.abs(mean[counts])
    whole = float((share[counts] * size).sum() / size.sum()) if size.any() else 0.0
    return Left((1.0 - share) * mean, keys, whole)
