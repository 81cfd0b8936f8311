"""What the weight of a compliant spindle does where it hangs across its axis."""

import math
from collections.abc import Iterator

from cutwise.physics.structure.pistons import PistonRing
from cutwise.physics.structure.statics import characteristic
from cutwise.process.chamfer import ChamferRun
from cutwise.process.chamfer_cut import mounted, ring_on
from cutwise.process.deburring import EdgeRun
from cutwise.results import Finding, Place
from cutwise.spec.chamfer import ChamferScenario

_SLIGHT = 0.1  # of the force at which the spindle yields: a smaller weight is not mentioned


def deburr(run: EdgeRun) -> Iterator[Finding]:
    """The weight of the motor at the tip, against what the pistons hold."""
    yield from _weight(run.cell.ring, run.cell.reach, Place())


def chamfer(scenario: ChamferScenario, run: ChamferRun) -> Iterator[Finding]:
    """The same for the first path; the direction of the weight in the part is said."""
    if not run.deflected or scenario.spindle is None or scenario.spindle.gravity == "off":
        return
    frame = mounted(run.paths[0], run.paths)
    down = ", ".join(f"{part:.3g}" for part in scenario.spindle.gravity @ frame + 0.0)
    yield from _weight(ring_on(scenario, frame), scenario.spindle.tool_reach, Place(f"along ({down}) of the part"))


def _weight(ring: PistonRing, reach: float, where: Place) -> Iterator[Finding]:
    """A weight that alone moves the tip, one that keeps it from coming back, or one that leans on it."""
    force = math.hypot(ring.moment_x, ring.moment_y) / reach
    statics = characteristic(ring, reach)
    out, back = statics.loading.breakaway, statics.unloading.breakaway
    if force > out:
        yield Finding("weight_moves", where, force, out, "force")
    elif force > back:
        yield Finding("weight_stays", where, force, back, "force")
    elif force > _SLIGHT * out:
        yield Finding("weight_leans", where, force, out, "force")
