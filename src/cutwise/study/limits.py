"""Limits that a run has to keep, and how far beyond them its numbers are: what advice, studies and optima go by."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from cutwise.process.recipes import Outcome
from cutwise.results import SOUNDNESS
from cutwise.spec.scenario import Scenario

BEYOND = 1.0
"""Least margin of a case that cannot be judged: infeasible, unsound, or without a number that a limit asks for."""

_CHATTER = "unstable"


class Bound(NamedTuple):
    """One end of what a measure may be."""

    measure: str
    value: float  # [SI]
    sign: float  # 1: the largest value, -1: the smallest
    implied: bool = False  # comes with the process, and counts where the run has the measure


def bounds(scenario: Scenario) -> Iterator[Bound]:
    """All ends of the requirements, of what follows from other keys, and of what every run has to keep."""
    for name, limit in scenario.asked.items():
        for end, sign in ((limit.max, 1.0), (limit.min, -1.0)):
            if end is not None:
                yield Bound(name, float(end), sign)
    if not scenario.set_aside:
        for name, most in scenario.implied.items():
            yield Bound(name, most, 1.0, implied=True)


def scaled(bound: Bound, scales: Mapping[str, float]) -> float:
    """What a distance from a bound is counted in: the bound itself; where it is zero, what is given, else 1 in SI."""
    return abs(bound.value) or scales.get(bound.measure, 0.0) or 1.0


def margins(
    scenario: Scenario, outcome: Outcome, scales: Mapping[str, float] | None = None
) -> tuple[tuple[float, ...], bool]:
    r"""How far beyond each bound a run is, and whether it can be judged at all.

    .. math:: \pm (m - m_\mathrm{lim}) / |m_\mathrm{lim}|

    Above 0 the bound is not kept. One whose measure is lacking counts :data:`BEYOND`, an implied one 0 below.

    Parameters
    ----------
    scenario, outcome
        The limits, and the run.
    scales : mapping, optional
        What distances from limits of zero are counted in, by measure [SI].
    """
    found, sound = [], not outcome.infeasible and bool(outcome.measures)
    beyond = False
    for bound in bounds(scenario):
        value = outcome.measures.get(bound.measure)
        if value is None:
            found.append(-BEYOND if bound.implied else BEYOND)
            sound = sound and bound.implied
            continue
        far = bound.sign * (value - bound.value) / scaled(bound, scales or {})
        if bound.implied and far >= 0.0:
            beyond, far = True, max(far, np.finfo(float).tiny)  # the border itself is not kept
        found.append(float(far))
    codes = {one.code for one in outcome.findings if one.code in SOUNDNESS and one.code not in scenario.set_aside}
    if beyond:
        codes.discard(_CHATTER)  # its measure says it, and by how much
    lost = any(name in outcome.measures and outcome.measures[name] <= least for name, least in scenario.sound.items())
    return tuple(found), sound and not codes and not lost


def margin(scenario: Scenario, outcome: Outcome, scales: Mapping[str, float] | None = None) -> float:
    """The largest margin over all bounds; :data:`BEYOND` at least where the run cannot be judged."""
    found, sound = margins(scenario, outcome, scales)
    most = max(found, default=-np.inf)
    return float(most) if sound else max(BEYOND, float(most))


def slack(scenario: Scenario, found: Outcome) -> float:
    """Smallest distance of a measure from its limit, relative to the limit (to 1 where the limit is zero).

    Minus infinity where a measure is lacking, the operation cannot be done, or the run is not sound: a tool at its stop
    meets no requirement that an engineer would trust.
    """
    each, sound = margins(scenario, found)
    return -max(each, default=-np.inf) if sound else -np.inf
