"""Readings of a machine's data that exclude one another: a correction made for one may spoil the part on another."""

import math

from cutwise import units
from cutwise.io.revision import revisions
from cutwise.physics.motion.loop import loop_figures
from cutwise.process.assemble_mill import feed_drives
from cutwise.results import SolverFailure
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct.shift import Plant, seen
from cutwise.study.correct.written import Written, largest


def other_readings(best: Written, tolerance: float) -> tuple[str, ...]:
    """What other readings of the machine's tables would make of the corrected path.

    Raises
    ------
    ScenarioFault
        It matters, and the scenario does not say which reading is right.
    """
    machine, key = best.scenario.drives, best.scenario.drives_key
    others = [one for one in machine.readings if one != machine.reading]
    worse = []
    for other in others:
        try:
            one = _drawn_reading(best, other)
            size = largest(best.told, seen([one], best.told.order).worst, whole=best.walls is not None)
        except (ScenarioFault, SolverFailure):
            size = math.inf
        if abs(size - best.residual) > tolerance:
            left = "is unstable" if math.isinf(size) else f"leaves {units.show(size, 'small_length', 3)}"
            worse.append(f"read as {other} the same program {left}")
    if not worse:
        return ()
    figures = ", ".join(_bandwidth(best, one) for one in (machine.reading, *others))
    decides = f"the frequency response of the position loops decides (bandwidth of x {figures})"
    told = f"{key}.reading {machine.reading}: {'; '.join(worse)}; {decides}"
    origin = best.scenario.origins.get(f"{key}.reading")
    if origin is None or origin.status == "assumed":
        raise ScenarioFault([Fault((*key.split("."), "reading"), f"is assumed, and the correction stands or falls with it: {told}; "
                                   "measure it, then write the reading")])  # fmt: skip
    return (told,)


def _drawn_reading(best: Written, reading: str) -> Plant:
    one = revisions(best.scenario)({f"{best.scenario.drives_key}.reading": reading})
    assert isinstance(one, MillingScenario)
    return Plant(one, best.told._replace(drives=feed_drives(one.drives, one.drives_key)), best.walls)


def _bandwidth(best: Written, reading: str) -> str:
    try:
        drive = _drawn_reading(best, reading).told.drives[0]
    except ScenarioFault:
        return f"none as {reading}"
    return f"{units.show(loop_figures(*drive).sampled_bandwidth, 'frequency', 3)} as {reading}"
