"""The nominal part of a scenario: its tolerance, and samples of its faces in the coordinates of the program."""

from cutwise.io.occ import CadFault
from cutwise.io.part_samples import Samples, moved, part_samples
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import MillingScenario

TOLERANCE = 10e-6  # [m] where the part has none
_CHORD = 0.02  # of the tolerance: the strip that triangles leave out beside the rim of a round face


def tolerance_of(scenario: MillingScenario) -> float:
    """Tolerance of the part, or what stands for it [m]."""
    nominal = scenario.nominal
    return TOLERANCE if nominal is None or nominal.tolerance is None else nominal.tolerance


def nominal_samples(scenario: MillingScenario, count: int | None = None) -> Samples:
    """Samples of the nominal part in the coordinates of the program.

    Raises
    ------
    ScenarioFault
        The file or its solid cannot be used.
    """
    part = scenario.nominal
    assert part is not None
    try:
        found = part_samples(part.model, part.solid, count or part.samples, _CHORD * tolerance_of(scenario))
    except CadFault as fault:
        key = "file" if part.file is not None else "step"
        raise ScenarioFault([Fault(("part", key), str(fault))]) from None
    return moved(found, part.origin, part.rotation)
