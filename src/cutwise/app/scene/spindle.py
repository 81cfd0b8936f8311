"""The compliant spindle that ``cutwise spindle`` writes as a solid, as it is seen: it hangs from its joint and tilts about it."""

import math
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import FloatArray, Tool
from cutwise.io.spindle_body import Misfit, cylinders
from cutwise.spec.spindle_solid import SpindleSolid

if TYPE_CHECKING:
    from cutwise.spec.spindle import CompliantSpindle


def in_spindle(tool: Tool, spindle: "CompliantSpindle | object") -> Tool:
    """A tool with the spindle that holds it in place of a plain holder, where the sizes of one are known.

    Parameters
    ----------
    tool : Tool
        The tool as it cuts.
    spindle : CompliantSpindle or another
        The section of the scenario; one without ``solid``, or with a STEP file in its place, leaves the holder as it is.
    """
    solid = getattr(spindle, "solid", None)
    if not isinstance(solid, SpindleSolid):
        return tool
    reach = spindle.tool_reach  # type: ignore[union-attr]
    try:
        bodies = cylinders(solid, reach)
    except Misfit:
        return tool
    top = float(tool.cutter[:, 0].max())
    rows = sorted((reach - one.start - one.length, reach - one.start, one.radius) for one in bodies.values())
    above = [(max(low, top), high, wide) for low, high, wide in rows if high > max(low, top)]
    if not above:
        return tool
    corners = [(z, wide) for low, high, wide in above for z in (low, high)]
    return tool._replace(
        holder=np.array([(corners[0][0], 0.0), *corners, (corners[-1][0], 0.0)]),
        fixed=_housing(solid, reach), rods=_pistons(solid, spindle, reach), pivot=reach,
    )  # fmt: skip


def _housing(solid: SpindleSolid, reach: float) -> FloatArray:
    """Profile of the housing, a tube round the motor: heights above the tip and radii [m]."""
    inside = 0.5 * solid.motor_diameter + solid.housing_gap
    outside = inside + solid.housing_wall
    high = reach + solid.housing_wall
    low = high - solid.motor_length
    return np.array(
        [(low, inside), (low, outside), (high, outside), (high, 0.0), (reach, 0.0), (reach, inside), (low, inside)]
    )


def _pistons(solid: SpindleSolid, spindle: object, reach: float) -> FloatArray:
    """Ends and radius of each piston: x, y, z of both ends from the tip, radius [m]; shape (n, 7)."""
    found = []
    count, azimuth, arm = spindle.pistons, spindle.piston_azimuth, spindle.piston_arm  # type: ignore[attr-defined]
    near = 0.5 * solid.motor_diameter
    far = near + solid.housing_gap + solid.housing_wall
    for i in range(count):
        angle = azimuth + 2.0 * math.pi * i / count
        c, s = math.cos(angle), math.sin(angle)
        found.append((near * c, near * s, reach - arm, far * c, far * s, reach - arm, 0.5 * solid.piston_diameter))
    return np.array(found).reshape(-1, 7)
