"""Where a tool goes down on its end: what of that has a force that feeds can be held to, and what has none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from cutwise import units
from cutwise.maths.linearc import LineArc, at_blocks
from cutwise.programs.block_text import block_named
from cutwise.study.correct.cells import BoolArray, FloatArray
from cutwise.study.correct.loads import PLUNGE
from cutwise.study.correct.meridians import Turning

if TYPE_CHECKING:
    from cutwise.study.correct.feed import Ready

_SLACK = 2e-3  # of a limit, by which cells of shorter blocks may differ
_RISES = 1.01  # times the force before, from which it is told


def not_quicker(ready: Ready) -> BoolArray:
    """Cells in the cut that go down on an end without a force: no feed is known to be safe but the one they have, shape (n,)."""
    sinks = ready.cells.cuts & (
        down_of(ready.path.curve, ready.cells.block, ready.cells.begin + 0.5 * ready.cells.length)
    )
    return sinks & ready.cutting.endless if isinstance(ready.cutting, Turning) else sinks


def missed(ready: Ready, speed: FloatArray, limits: Mapping[str, float]) -> Iterator[str]:
    """Ramps that push harder than a plunge may, at speeds along the path [m/s]."""
    cutting, limit = ready.cutting, limits.get(PLUNGE)
    if not isinstance(cutting, Turning) or limit is None:
        return
    force = np.where(cutting.sinks, cutting.plunge_forces(speed), -np.inf)
    worst = int(np.argmax(force))
    if force[worst] > limit * (1.0 + _SLACK):
        shown = [units.show(float(one), "force", 4) for one in (force[worst], limit)]
        line = block_named(ready.program.text, int(ready.bed.line[worst]))
        yield f"{PLUNGE} is {shown[0]} at {line}, beyond its limit of {shown[1]}"


def told(ready: Ready, before: FloatArray, after: FloatArray, limits: Mapping[str, float]) -> Iterator[str]:
    """What nothing holds: a force up that rises, and ends of tools that have none; speeds along the path [m/s]."""
    cutting = ready.cutting
    if isinstance(cutting, Turning) and PLUNGE not in limits and cutting.sinks.any():
        old, new = (float(cutting.plunge_forces(speed)[cutting.sinks].max()) for speed in (before, after))
        if new > max(old, 0.0) * _RISES:
            shown = [units.show(one, "force", 4) for one in (old, new)]
            yield f"the force up where a tool goes down rises from {shown[0]} to {shown[1]}; correct.limits.{PLUNGE} holds it"
    if not_quicker(ready).any():
        why = "write its end_core" if isinstance(cutting, Turning) else "it has one in a stock in 3D (tools)"
        yield f"the end of a tool has no force here, so that its ramps are not quicker than programmed: {why}"


def down_of(curve: LineArc, block: np.ndarray, s: FloatArray) -> BoolArray:
    """Whether the path goes down at places on its blocks [m]."""
    return np.asarray(at_blocks(curve, block, s)[1][:, 2] < -1e-9)
