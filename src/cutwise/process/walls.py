"""A straight wall that is milled: its engagement, its measures, and where it is off most; however the tool is carried."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.shoulder import Shoulder, Slot
from cutwise.process import carriers, spindles, yielding
from cutwise.results import Finding
from cutwise.spec.base import known
from cutwise.spec.milled_path import MilledPath
from cutwise.spec.milling import MillingScenario


class WallCut(NamedTuple):
    """The cut along a wall, all of which its scenario has to say."""

    feed: float  # [m/s]
    spindle_speed: float  # [rad/s]
    axial_depth: float  # [m]
    radial_depth: float  # [m]
    begins: float  # [m] of the path, where the cut begins


def cut_of(scenario: MillingScenario) -> WallCut:
    """The cut along the wall of a scenario."""
    of, path = scenario.operation, path_of(scenario)
    return WallCut(
        known(of.feed), known(of.spindle_speed), known(of.axial_depth), known(of.radial_depth), path.cut_from or 0.0
    )


def path_of(scenario: MillingScenario) -> MilledPath:
    """What the scenario says of the wall."""
    assert isinstance(scenario.path, MilledPath)
    return scenario.path


def is_slot(scenario: MillingScenario) -> bool:
    """Whether both sides of the cut are walls."""
    return known(scenario.operation.radial_depth) >= scenario.tool.diameter * (1.0 - 1e-12)


def mill_of(scenario: MillingScenario) -> Mill:
    """The mill of a scenario."""
    tool = scenario.tool
    return Mill(0.5 * tool.diameter, tool.flutes, tool.helix)


def round_of(scenario: MillingScenario) -> Round:
    """The turning mill."""
    mill = mill_of(scenario)
    return Round(mill.radius, mill.flutes, known(scenario.operation.spindle_speed))


def engagement_of(
    scenario: MillingScenario, begins: float, ends: float = math.inf, standstill: float = 0.0
) -> Shoulder | Slot:
    """What the mill meets from a place of the path to another [m]; slower than ``standstill`` [m/s] it cuts nothing."""
    depth = known(scenario.operation.axial_depth)
    return (Slot if is_slot(scenario) else Shoulder)(round_of(scenario), depth, begins, ends, standstill)


def measures(wall: FloatArray, floor: FloatArray, *, slot: bool, deeper: float = 0.0) -> dict[str, float]:
    """Least and greatest error of wall and floor [m], positive into the part, at the places that count.

    What the tool yields by moves one wall of a slot into the part and the other out of it; ``deeper``: how far both are
    cut into it all the same [m].
    """
    low, high = float(wall.min()), float(wall.max())
    if slot:
        shift = float(np.abs(wall - deeper).max())
        low, high = deeper - shift, deeper + shift
    return {"wall_error_min": low, "wall_error_max": high, **yielding.extremes("floor_error", floor)}


def overload(scenario: MillingScenario, tangential: FloatArray) -> Iterator[Finding]:
    r"""A motor on pistons that is too weak for the cut: mean tangential force F [N] in the cut, :math:`P = F R \Omega`."""
    mill = round_of(scenario)
    power = float(tangential.mean()) * mill.radius * mill.spindle_speed if tangential.size else 0.0
    yield from spindles.overload(scenario.compliant, power)


def note(place: float, error: float, moved: Mapping[str, FloatArray], row: int, when: str = "") -> str:
    """Where the wall is off most, and what each term has of it there."""
    shares = carriers.shares(moved, row, into=True)
    return (
        f"The wall is off most at {units.show(float(place), 'length')} of the path{when}: "
        f"{units.show(float(error), 'small_length', 4)} ({shares or 'nothing yields'}; positive is into the part)."
    )
