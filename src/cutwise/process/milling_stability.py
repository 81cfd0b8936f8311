"""Whether the tool tip of a milling run chatters: growth in time, limiting depths, and the map over speed and depth."""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting import stability
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.stability import Milling, limit_depth
from cutwise.physics.cutting.uneven import tangent_coefficients
from cutwise.physics.structure.modes import Modes, free_motion
from cutwise.process.labels import labelled
from cutwise.process.loops_drives import Cut
from cutwise.process.loops_regenerative import Chatter, SteadyCut, run_regenerative
from cutwise.spec.milling import MillingScenario

_PERIODS = 150
_DEEPEST = 20.0  # of the axial depth: how far a limit is looked for


class SteadyStability(NamedTuple):
    """A steady cut of one immersion."""

    immersion: float  # [rad]
    chatter: Chatter
    stable_depth: float | None  # [m] least depth that is unstable at the spindle speed; None: none within 20 depths


class TipStability(NamedTuple):
    """The two immersions that matter on the path."""

    cut: Cut
    tip: Modes
    chip: float  # programmed feed per tooth [m]
    straight: SteadyStability
    corner: SteadyStability


MEASURES = frozenset(
    f"{name}_{where}" for name in ("chatter_growth", "stable_depth") for where in ("straight", "corner")
)


def measures(found: TipStability) -> dict[str, float]:
    """Growth and limiting depths in SI; a limit beyond 20 times the depth is left out."""
    values: dict[str, float] = {}
    for name, steady in (("straight", found.straight), ("corner", found.corner)):
        values[f"chatter_growth_{name}"] = steady.chatter.growth
        if steady.stable_depth is not None:
            values[f"stable_depth_{name}"] = steady.stable_depth
    return values


def tip_stability(
    scenario: MillingScenario, cut: Cut, tip: Modes, chip: float, straight: float, corner: float
) -> TipStability:
    """Steady cuts at the straight and the largest immersion [rad], at the programmed feed per tooth [m]."""
    return TipStability(cut, tip, chip, *(_steady(scenario, cut, tip, chip, arc) for arc in (straight, corner)))


def _steady(scenario: MillingScenario, cut: Cut, tip: Modes, chip: float, arc: float) -> SteadyStability:
    depth, lag = scenario.operation.axial_depth, math.tan(cut.mill.helix) / cut.mill.radius
    k = _coefficients(cut, chip, arc)
    case = SteadyCut(
        cut.mill.flutes, cut.spindle, math.pi - arc, math.pi, chip, depth, lag, cut.discs.count, k
    )  # fmt: skip
    limit = limit_depth(cut.spindle, _milling(cut, arc, k), stability.Tip(*tip), lambda t: free_motion(tip, t),
                        _DEEPEST * depth)  # fmt: skip
    return SteadyStability(arc, run_regenerative(case, tip, _PERIODS), limit if math.isfinite(limit) else None)


def _coefficients(cut: Cut, chip: float, arc: float) -> EdgeCoefficients:
    """Slopes of the force law at the mean chip thickness of the arc."""
    return tangent_coefficients(cut.edges, chip * (1.0 - math.cos(arc)) / arc)


def _milling(cut: Cut, arc: float, k: EdgeCoefficients) -> Milling:
    return Milling(cut.mill.flutes, math.pi - arc, math.pi, k.K_tc, k.K_rc)


def lobe_diagram(scenario: MillingScenario, found: TipStability) -> xr.Dataset:
    """Growth of tip vibration per tooth over spindle speed and axial depth, at both immersions; stable below 1."""
    given, cut, tip = scenario.lobes, found.cut, found.tip
    speeds = np.linspace(
        given.spindle_speed_min or 0.5 * cut.spindle, given.spindle_speed_max or 1.5 * cut.spindle, given.speeds
    )
    deepest = given.depth_max or 3.0 * scenario.operation.axial_depth
    depths = deepest * np.arange(1, given.depths + 1) / given.depths

    def growth(arc: float) -> FloatArray:
        case = _milling(cut, arc, _coefficients(cut, found.chip, arc))
        return stability.lobes(speeds, depths, case, stability.Tip(*tip), lambda t: free_motion(tip, t))

    arcs = [found.straight.immersion, found.corner.immersion]
    return xr.Dataset(
        {
            "growth": (("immersion", "spindle_speed", "depth"), np.array([growth(arc) for arc in arcs]),
                       {"units": "1", "long_name": "growth of tip vibration per tooth, stable below 1"}),
        },
        {
            "immersion": ("immersion", arcs, {"units": "rad", "long_name": "immersion angle"}),
            "spindle_speed": ("spindle_speed", speeds, {"units": "rad/s", "long_name": "spindle speed"}),
            "depth": ("depth", depths, {"units": "m", "long_name": "axial depth of cut"}),
        },
    )  # fmt: skip


def vibration(found: TipStability) -> xr.Dataset:
    """The tip in the steady cut at the largest immersion, from rest."""
    c = found.corner.chatter
    return labelled(("vibration_time", c.time, "s", "time"), {
        "tip_corner": (c.tip, "m", "vibration of the tool tip at the largest immersion"),
    }, axis=["x", "y"])  # fmt: skip
