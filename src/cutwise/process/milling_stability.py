"""Whether the tool tip of a milling run chatters: growth in time, limiting depths, and the map over speed and depth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise import units
from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting import stability
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.stability import Milling, limit_depth
from cutwise.physics.cutting.uneven import tangent_coefficients
from cutwise.physics.structure.modes import Modes, free_motion
from cutwise.process.labels import labelled
from cutwise.process.loops_drives import Cut
from cutwise.process.loops_regenerative import Chatter, SteadyCut, run_regenerative
from cutwise.process.milling_contact import SteadyPatch
from cutwise.results import Remedy
from cutwise.spec.milling import MillingScenario

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

_PERIODS = 150
_TRIED = 4  # speeds that are run before the depth is looked at
_INSIDE = 0.95  # of the depth at which it becomes unstable
_DEEPEST = 20.0  # of the axial depth: how far a limit is looked for


class SteadyStability(NamedTuple):
    """A steady cut of one immersion."""

    patch: SteadyPatch
    chatter: Chatter
    stable_depth: float | None  # [m] least depth that is unstable at the spindle speed; None: none within 20 depths


class TipStability(NamedTuple):
    """The contacts that matter on the path."""

    cut: Cut
    tip: Modes
    cases: dict[str, SteadyStability]  # "straight", where there is one, and "corner", the heaviest


MEASURES = frozenset(
    f"{name}_{where}" for name in ("chatter_growth", "stable_depth") for where in ("straight", "corner")
)


def measures(found: TipStability) -> dict[str, float]:
    """Growth and limiting depths in SI; a limit beyond 20 times the depth is left out."""
    values: dict[str, float] = {}
    for name, steady in found.cases.items():
        values[f"chatter_growth_{name}"] = steady.chatter.growth
        if steady.stable_depth is not None:
            values[f"stable_depth_{name}"] = steady.stable_depth
    return values


def tip_stability(cut: Cut, tip: Modes, steady: Mapping[str, SteadyPatch]) -> TipStability:
    """Steady cuts of given contacts, each at its own feed per tooth."""
    return TipStability(cut, tip, {name: _steady(cut, tip, patch) for name, patch in steady.items()})


def steady_cut(cut: Cut, patch: SteadyPatch) -> SteadyCut:
    k, lag = coefficients_of(cut, patch), math.tan(cut.mill.helix) / cut.mill.radius
    entry, out = math.pi - patch.high, math.pi - patch.low
    return SteadyCut(cut.mill.flutes, cut.spindle, entry, out, patch.chip, patch.depth, lag, cut.discs.count, k)


def _steady(cut: Cut, tip: Modes, patch: SteadyPatch) -> SteadyStability:
    k, case = coefficients_of(cut, patch), steady_cut(cut, patch)
    limit = limit_depth(
        cut.spindle,
        milling_of(cut, patch, k),
        stability.Tip(*tip),
        lambda t: free_motion(tip, t),
        _DEEPEST * patch.depth,
    )
    return SteadyStability(patch, run_regenerative(case, tip, _PERIODS), limit if math.isfinite(limit) else None)


def stable_settings(scenario: MillingScenario, found: TipStability) -> Remedy | None:
    """The nearest drawn spindle speed at which all contacts are stable at their depths, else the depth that is.

    Both are run before they are said; None if neither holds.
    """
    cut, tip = found.cut, found.tip
    speeds = drawn_speeds(scenario, cut)
    growth = np.zeros(len(speeds))
    for case in found.cases.values():
        met = milling_of(cut, case.patch, coefficients_of(cut, case.patch))
        one = stability.lobes(
            speeds, np.array([case.patch.depth]), met, stability.Tip(*tip), lambda t: free_motion(tip, t)
        )
        growth = np.maximum(growth, one[:, 0])
    near = sorted(np.flatnonzero(growth < 1.0), key=lambda i: abs(speeds[i] - cut.spindle))[:_TRIED]
    for speed in (float(f"{speeds[i] * 30.0 / math.pi:.4g}") for i in near):
        if _stable(found, speed * math.pi / 30.0, 1.0):
            return Remedy("operation.spindle_speed", f"{speed:g} rpm", tried=True)
    limits = [case.stable_depth / case.patch.depth for case in found.cases.values() if case.stable_depth is not None]
    share = _INSIDE * min([*limits, 1.0])
    if not _stable(found, cut.spindle, share):
        return None
    depth = share * max(case.patch.depth for case in found.cases.values())
    key = "operation.axial_depth" if scenario.operation.axial_depth is not None else "axial depth of the program"
    return Remedy(key, units.show(depth, "length", 2), tried=True)


def _stable(found: TipStability, spindle: float, share: float) -> bool:
    """Whether all contacts die out in the run at a spindle speed [rad/s] and a share of their depths."""
    cut = found.cut._replace(spindle=spindle)
    slower = found.cut.spindle / spindle
    patches = [
        case.patch._replace(depth=share * case.patch.depth, chip=slower * case.patch.chip)
        for case in found.cases.values()
    ]
    return all(run_regenerative(steady_cut(cut, patch), found.tip, _PERIODS).stable for patch in patches)


def stays_stable(cut: Cut, tip: Modes, patch: SteadyPatch, spindle: float) -> bool:
    """Whether vibration dies out in the run of a contact at a spindle speed [rad/s], at the feed of its place."""
    slower = cut.spindle / spindle
    case = steady_cut(cut._replace(spindle=spindle), patch._replace(chip=slower * patch.chip))
    return run_regenerative(case, tip, _PERIODS).stable


def coefficients_of(cut: Cut, patch: SteadyPatch) -> EdgeCoefficients:
    """Slopes of the force law at the mean chip thickness of the arc."""
    mean = patch.chip * (math.cos(patch.low) - math.cos(patch.high)) / (patch.high - patch.low)
    return tangent_coefficients(cut.edges, mean)


def milling_of(cut: Cut, patch: SteadyPatch, k: EdgeCoefficients) -> Milling:
    return Milling(cut.mill.flutes, math.pi - patch.high, math.pi - patch.low, k.K_tc, k.K_rc)


def drawn_speeds(scenario: MillingScenario, cut: Cut) -> FloatArray:
    """Spindle speeds of the map [rad/s]."""
    given = scenario.lobes
    return np.linspace(
        given.spindle_speed_min or 0.5 * cut.spindle, given.spindle_speed_max or 1.5 * cut.spindle, given.speeds
    )


def lobe_diagram(scenario: MillingScenario, found: TipStability) -> xr.Dataset:
    """Growth of tip vibration per tooth over spindle speed and axial depth, for each contact; stable below 1."""
    given, cut, tip = scenario.lobes, found.cut, found.tip
    speeds = drawn_speeds(scenario, cut)
    deepest = given.depth_max or 3.0 * max(case.patch.depth for case in found.cases.values())
    depths = deepest * np.arange(1, given.depths + 1) / given.depths

    def growth(patch: SteadyPatch) -> FloatArray:
        case = milling_of(cut, patch, coefficients_of(cut, patch))
        return stability.lobes(speeds, depths, case, stability.Tip(*tip), lambda t: free_motion(tip, t))

    return xr.Dataset(
        {
            "growth": (("contact", "spindle_speed", "depth"), np.array([growth(c.patch) for c in found.cases.values()]),
                       {"units": "1", "long_name": "growth of tip vibration per tooth, stable below 1"}),
            "depth_met": ("contact", [c.patch.depth for c in found.cases.values()],
                          {"units": "m", "long_name": "axial depth of the contact"}),
            "speed_met": ((), cut.spindle, {"units": "rad/s", "long_name": "spindle speed of the run"}),
        },
        {
            "contact": list(found.cases),
            "spindle_speed": ("spindle_speed", speeds, {"units": "rad/s", "long_name": "spindle speed"}),
            "depth": ("depth", depths, {"units": "m", "long_name": "axial depth of cut"}),
        },
    )  # fmt: skip


def vibration(found: TipStability) -> xr.Dataset:
    """The tip in a steady cut of the heaviest contact, from rest until it swings by more than the radius of the mill."""
    c = (found.cases.get("corner") or found.cases["straight"]).chatter
    within = np.logical_and.accumulate(np.abs(c.tip).max(axis=1) <= found.cut.mill.radius)
    return labelled(("vibration_time", c.time[within], "s", "time"), {
        "tip_corner": (c.tip[within], "m", "vibration of the tool tip in the heaviest contact"),
    }, axis=["x", "y"])  # fmt: skip
