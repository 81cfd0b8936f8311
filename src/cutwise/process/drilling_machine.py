"""A machine that drills: how it stands at a hole, and what its bodies yield by there."""

import math
from collections.abc import Sequence

import numpy as np

from cutwise.maths.frames import FloatArray
from cutwise.paths.carried import CarriedPath
from cutwise.physics.structure.joint_compliance import holding_ratio
from cutwise.physics.structure.series_compliance import in_axes
from cutwise.process.chain_compliance import BodiesAlong, bodies_along
from cutwise.process.posture import Posture
from cutwise.process.posture_search import PoseTarget
from cutwise.process.postures import tool_axes
from cutwise.spec.chained import CarryingMachine
from cutwise.spec.part_block import PartBlock

_UPRIGHT = np.diag([1.0, -1.0, -1.0])  # drilling counts z along the feed, the process towards the motor


def on_machine(machine: CarryingMachine, block: PartBlock | None, target: PoseTarget) -> Posture:
    """How a machine stands at a hole: its compliance at the tip in tool axes; it has no angle and no joints to choose.

    Raises
    ------
    ScenarioFault
        The hole is beyond the travel of an axis, or does not point as the spindle does.
    """
    whole = _at(machine, block, [target]).total[0]
    compliance = in_axes(whole, _UPRIGHT)
    return Posture(0.0, np.zeros(0), compliance, holding_ratio(compliance), math.nan)


def body_origins(machine: CarryingMachine, block: PartBlock | None, targets: Sequence[PoseTarget]) -> FloatArray:
    """Origins of the frames of the bodies over each of these holes, in the part [m], shape (hole, body, 3)."""
    return _at(machine, block, targets).origins


def _at(machine: CarryingMachine, block: PartBlock | None, targets: Sequence[PoseTarget]) -> BodiesAlong:
    axes = np.array([tool_axes(target.axis, 0.0) @ _UPRIGHT for target in targets])
    path = CarriedPath(np.zeros(len(targets)), np.array([target.position for target in targets]), axes)
    return bodies_along(machine, block, np.array(machine.tip), path, ("hole", "position"), ("hole", "axis"))
