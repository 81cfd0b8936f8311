"""A straight wall that is milled: its engagement, its measures, and where it is off most; however the tool is carried."""

import math
from collections.abc import Mapping

import numpy as np

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.shoulder import Shoulder, Slot
from cutwise.process import carriers
from cutwise.spec.milling import MillingScenario


def is_slot(scenario: MillingScenario) -> bool:
    """Whether both sides of the cut are walls."""
    radial = scenario.operation.radial_depth
    assert radial is not None
    return radial >= scenario.tool.diameter * (1.0 - 1e-12)


def mill_of(scenario: MillingScenario) -> Mill:
    """The mill of a scenario."""
    tool = scenario.tool
    return Mill(0.5 * tool.diameter, tool.flutes, tool.helix)


def round_of(scenario: MillingScenario) -> Round:
    """The turning mill."""
    mill, speed = mill_of(scenario), scenario.operation.spindle_speed
    assert speed is not None
    return Round(mill.radius, mill.flutes, speed)


def engagement_of(
    scenario: MillingScenario, begins: float, ends: float = math.inf, standstill: float = 0.0
) -> Shoulder | Slot:
    """What the mill meets from a place of the path to another [m]; slower than ``standstill`` [m/s] it cuts nothing."""
    depth = scenario.operation.axial_depth
    assert depth is not None
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
    ends = {"floor_error_min": float(floor.min()), "floor_error_max": float(floor.max())}
    return {"wall_error_min": low, "wall_error_max": high, **ends}


def note(place: float, error: float, moved: Mapping[str, FloatArray], row: int, when: str = "") -> str:
    """Where the wall is off most, and what each term has of it there."""
    shares = carriers.shares(moved, row, into=True)
    return (
        f"The wall is off most at {units.show(float(place), 'length')} of the path{when}: "
        f"{units.show(float(error), 'small_length', 4)} ({shares or 'nothing yields'}; positive is into the part)."
    )
