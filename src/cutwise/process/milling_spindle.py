"""The compliant spindle that mills: what its pistons do, and when nothing can be said about the wall it leaves."""

from collections.abc import Iterator

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.physics.structure.terms import Pistons
from cutwise.process.assemble import piston_ring
from cutwise.process.carriage import Terms
from cutwise.process.passes import at_stop, drifting
from cutwise.results import Finding
from cutwise.spec.milling import MillingScenario


def pistons_of(scenario: MillingScenario, axes: FloatArray | None = None) -> Terms:
    """The compliant spindle as the first term of a structure, if there is one; process axes in the base of a robot, (3, 3)."""
    spindle = scenario.compliant
    if spindle is None:
        return ()
    return (("pistons", Pistons(piston_ring(spindle, scenario.robot, axes), spindle.tool_reach)),)


def travel(scenario: MillingScenario, columns: FloatArray) -> FloatArray:
    """Travel of the piston that has gone farthest [m], shape (n,), from the columns of a structure with the spindle first."""
    assert scenario.compliant is not None
    return np.asarray(columns[:, 4 : 4 + scenario.compliant.pistons].max(axis=1))


def measures(scenario: MillingScenario, columns: FloatArray) -> dict[str, float]:
    """What is left of the stroke."""
    if scenario.compliant is None:
        return {}
    return {"stroke_margin": scenario.compliant.stroke - float(travel(scenario, columns).max())}


def findings(
    scenario: MillingScenario, time: FloatArray, columns: FloatArray, off: FloatArray, cut: np.ndarray
) -> Iterator[Finding]:
    """At the stop, or still moving off the work over the last quarter of the cut.

    Parameters
    ----------
    time, off : array (n,)
        [s], and displacement off the work by the spindle [m].
    columns : array (n, k)
        Of the structure, the spindle first.
    cut : array (n,)
        Where the tool is in the cut.
    """
    if scenario.compliant is None:
        return
    yield from at_stop(time, travel(scenario, columns), scenario.compliant.stroke)
    rows = np.flatnonzero(cut)
    last = rows[int(0.75 * len(rows)) :]
    if len(last):
        yield from drifting(float(time[last[0]]), off[last])
