"""What the weight of a compliant spindle does where it hangs across its axis."""

import math
from collections.abc import Iterator

from cutwise.physics.structure.pistons import PistonRing
from cutwise.physics.structure.statics import characteristic
from cutwise.results import Finding, Place

_SLIGHT = 0.1  # of the force at which the spindle yields: a smaller weight is not mentioned


def weight_on(ring: PistonRing, reach: float, where: Place) -> Iterator[Finding]:
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
