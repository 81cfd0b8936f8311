"""The histories of a drilling run as labelled arrays, one group per stage."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cutwise.later import later
from cutwise.maths.frames import FloatArray
from cutwise.physics.cutting.drill import lip_force, margin_torque
from cutwise.physics.cutting.drill_elements import elements_force
from cutwise.physics.engagement.lip import lip_contact
from cutwise.physics.structure.joint_compliance import worst_skating
from cutwise.process.drilling import DrillCell, DrilledHole, DrillRun, hole_measures
from cutwise.process.loops_drilling import HISTORY
from cutwise.process.posture_search import scan
from cutwise.process.postures import posture_frames
from cutwise.results import judge_values
from cutwise.spec.drilling import DrillingScenario

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

_DEPTHS = 400
_ANGLES = 181


def _variable(dims: tuple[str, ...] | str, values: Any, unit: str, text: str) -> tuple[Any, Any, dict[str, str]]:
    return dims, values, {"units": unit, "long_name": text}


def stages(scenario: DrillingScenario, run: DrillRun) -> xr.DataTree:
    """All groups."""
    drilled = [hole for hole in run.holes if hole.outcome is not None]
    groups = {"engagement": _engagement(scenario, run.cell), "cutting": _shares(scenario, run.cell)}
    groups["holes"] = _holes(scenario, run)
    if run.cell.arm is not None:
        groups["map"] = _map(run)
    if drilled:
        history = _of_one_length([hole.history for hole in drilled])
        index = [k + 1 for k, hole in enumerate(run.holes) if hole.outcome is not None]
        groups["motion"] = _motion(run, drilled, history, index)
        groups["cutting"] = groups["cutting"].merge(_forces(history, index))
        groups["structure"] = _structure(drilled, history, index)
        groups["surface"] = _surface(history, index)
    return xr.DataTree.from_dict(groups)


def _of_one_length(histories: list[FloatArray]) -> FloatArray:
    """Histories of all holes over the time of the longest, shape (hole, time, column); a shorter one stays at its end."""
    longest = max(histories, key=len)
    same = []
    for history in histories:
        rest = np.repeat(history[-1:], len(longest) - len(history), axis=0)
        rest[:, 0] = longest[len(history) :, 0]
        same.append(np.concatenate([history, rest]))
    return np.stack(same)


def _column(history: FloatArray, *names: str) -> FloatArray:
    """Columns of the histories, shape (hole, time) or (hole, time, n)."""
    places = [HISTORY.index(name) for name in names]
    return history[:, :, places[0]] if len(places) == 1 else history[:, :, places]


def _over_time(history: FloatArray, index: list[int]) -> dict[str, Any]:
    return {
        "hole": _variable("hole", index, "1", "number of the hole"),
        "time": _variable("time", history[0, :, 0], "s", "time"),
    }


def _engagement(scenario: DrillingScenario, cell: DrillCell) -> xr.Dataset:
    """Radii between which a lip cuts, at four azimuths, over the depth of the tip."""
    depth = np.linspace(0.0, scenario.part.thickness + 1.5 * cell.cycle.cone, _DEPTHS)
    azimuth = np.array([0.0, 0.5, 1.0, 1.5]) * math.pi
    contact = np.array([
        [lip_contact(h, scenario.part.thickness, cell.point.radius, cell.point.half_point_angle,
                     scenario.part.inclination, a) for a in azimuth] for h in depth
    ])  # fmt: skip
    return xr.Dataset(
        {
            "inner_radius": _variable(("depth", "azimuth"), contact[..., 0], "m", "inner radius of contact"),
            "outer_radius": _variable(("depth", "azimuth"), contact[..., 1], "m", "outer radius of contact"),
        },
        {"depth": _variable("depth", depth, "m", "depth of the tip"),
         "azimuth": _variable("azimuth", azimuth, "rad", "azimuth of the lip")},
    )  # fmt: skip


def _shares(scenario: DrillingScenario, cell: DrillCell) -> xr.Dataset:
    """Thrust and torque over depth at nominal feed, with the shares of chisel edge, lips and margins."""
    depth = np.linspace(0.0, scenario.part.thickness + 1.2 * cell.cycle.cone, _DEPTHS)
    profile, feed, thickness = cell.profile, scenario.operation.feed_per_rev, scenario.part.thickness
    chisel_radius = cell.point.chisel_radius
    azimuths = 2.0 * math.pi * (np.arange(24) + 0.5) / 24 if scenario.part.inclination else np.zeros(1)
    chisel = np.zeros((len(depth), 2))
    for k, h in enumerate(depth):
        for azimuth in azimuths:
            inner, outer = lip_contact(
                h, thickness, cell.point.radius, cell.point.half_point_angle, scenario.part.inclination, azimuth
            )
            inner, outer = min(inner, chisel_radius), min(outer, chisel_radius)
            if len(cell.elements.thrust):
                force = elements_force(cell.elements, feed, inner, outer)
            else:
                force = lip_force(cell.point, cell.stress, feed, inner, outer)
            chisel[k] += 2.0 * np.array([force.thrust, force.torque]) / len(azimuths)
    thrust, torque = (np.interp(depth, profile.depth, values) for values in (profile.thrust, profile.torque))
    margin = np.array([margin_torque(cell.point, cell.law.margin_stress, h, thickness) for h in depth])
    lateral = np.stack([np.interp(depth, profile.depth, profile.lateral[:, k]) for k in (0, 1)], axis=1)
    return xr.Dataset(
        {
            "thrust_nominal": _variable("depth", thrust, "N", "thrust at nominal feed"),
            "thrust_chisel": _variable("depth", chisel[:, 0], "N", "thrust of the chisel edge"),
            "thrust_lips": _variable("depth", thrust - chisel[:, 0], "N", "thrust of the lips"),
            "torque_nominal": _variable("depth", torque, "N*m", "torque at nominal feed"),
            "torque_chisel": _variable("depth", chisel[:, 1], "N*m", "torque of the chisel edge"),
            "torque_margin": _variable("depth", margin, "N*m", "torque of the margins"),
            "torque_lips": _variable("depth", torque - chisel[:, 1] - margin, "N*m", "torque of the lips"),
            "lateral_nominal": _variable(("depth", "across"), lateral, "N", "mean lateral force, axes of the slope"),
        },
        {"depth": _variable("depth", depth, "m", "depth of the tip"), "across": ["x", "y"]},
    )


def _forces(history: FloatArray, index: list[int]) -> xr.Dataset:
    return xr.Dataset(
        {
            "thrust": _variable(("hole", "time"), _column(history, "thrust"), "N", "thrust"),
            "torque": _variable(("hole", "time"), _column(history, "torque"), "N*m", "drill torque"),
        },
        _over_time(history, index),
    )


def _motion(run: DrillRun, drilled: list[DrilledHole], history: FloatArray, index: list[int]) -> xr.Dataset:
    """Depth and feed over time; the arm in its posture."""
    told = {
        "depth": _variable(("hole", "time"), _column(history, "depth"), "m", "depth of the tip"),
        "feed_per_rev": _variable(("hole", "time"), _column(history, "feed"), "m", "actual feed per revolution"),
    }
    arm = run.cell.arm
    if arm is None:
        return xr.Dataset(told, _over_time(history, index))
    postures = np.stack([hole.posture.q for hole in drilled if hole.posture is not None])
    at = posture_frames(arm, postures)
    tip = at.origins[:, -1] + np.einsum("kij,j->ki", at.rotations[:, -1], arm.tool_tip)
    points = np.concatenate([at.origins, tip[:, None]], axis=1)
    names = ["base", *(f"joint {k}" for k in range(1, len(arm.chain.kinds) + 1)), "drill tip"]
    return xr.Dataset(
        {
            **told,
            "joint_angle": _variable(("hole", "joint"), postures, "rad", "joint angles"),
            "arm": _variable(("hole", "point", "axis"), points, "m", "joints and drill tip in the base frame"),
        },
        {**_over_time(history, index), "joint": np.arange(1, 7), "point": names, "axis": ["x", "y", "z"]},
    )


def _structure(drilled: list[DrilledHole], history: FloatArray, index: list[int]) -> xr.Dataset:
    compliance = np.stack([hole.posture.compliance for hole in drilled if hole.posture is not None])
    frequencies = np.stack([hole.frequencies for hole in drilled])
    twist = ["x", "y", "z", "rx", "ry", "rz"]
    modes = {"mode": np.arange(1, frequencies.shape[1] + 1)}
    return xr.Dataset(
        {
            "tip_deflection": _variable(
                ("hole", "time", "axis"), _column(history, "x", "y", "z"), "m", "deflection of the tool tip, tool axes"
            ),
            "wall_force": _variable(
                ("hole", "time", "across"), _column(history, "wall_x", "wall_y"), "N", "force of the hole on the drill"
            ),
            "compliance": _variable(
                ("hole", "twist", "wrench"), compliance, "m/N", "compliance in tool axes (rotations 1/N, 1/(N m))"
            ),
            "natural_frequency": _variable(("hole", "mode"), frequencies, "Hz", "frequencies of the arm at the tool"),
        },
        {
            **_over_time(history, index), "axis": ["x", "y", "z"], "across": ["x", "y"], "twist": twist,
            "wrench": twist, **modes,
        },
    )  # fmt: skip


def _surface(history: FloatArray, index: list[int]) -> xr.Dataset:
    return xr.Dataset(
        {
            "hole_position": _variable(
                ("hole", "time", "across"), _column(history, "hole_x", "hole_y"), "m",
                "lateral position of the hole, tool axes",
            ),
        },
        {**_over_time(history, index), "across": ["x", "y"]},
    )  # fmt: skip


def _map(run: DrillRun) -> xr.Dataset:
    """Axial compliance and skating ratio of all branches over the redundancy angle, for the first hole."""
    angles = np.linspace(-math.pi, math.pi, _ANGLES)
    found = scan(run.cell.arm, run.holes[0].target, angles)
    both = ("redundancy_angle", "branch")
    skating = worst_skating(found.holding, run.cell.side, (run.cell.slope_direction - angles)[:, None])
    return xr.Dataset(
        {
            "compliance_axial": _variable(both, found.compliance, "m/N", "compliance along the drill axis"),
            "skating_ratio": _variable(both, skating, "1", "skating ratio"),
            "wrist_sine": _variable(both, found.wrist_sine, "1", "|sin| of the wrist angle"),
            "within_limits": _variable(both, found.within, "1", "within the joint limits"),
        },
        {
            "redundancy_angle": _variable("redundancy_angle", angles, "rad", "redundancy angle"),
            "branch": np.arange(found.q.shape[1]),
        },
    )


_TABLE = (
    ("redundancy_angle", "rad"), ("compliance_axial", "m/N"), ("skating_ratio", "1"),
    ("hole_position_error_entry", "m"), ("hole_position_error_exit", "m"), ("perpendicularity_error", "rad"),
    ("circularity_estimate", "m"), ("feed_per_rev_max", "m"), ("thrust_max", "N"),
)  # fmt: skip


def _holes(scenario: DrillingScenario, run: DrillRun) -> xr.Dataset:
    """The table of the holes: where, how good, pass or fail."""
    each = [hole_measures(scenario, run.cell, hole) if hole.outcome else None for hole in run.holes]
    columns = {
        name: _variable("hole", np.array([math.nan if one is None else one.get(name, math.nan) for one in each]), unit,
                        type(scenario).measures[name].description)
        for name, unit in _TABLE
        if run.cell.arm is not None or name != "redundancy_angle"
    }  # fmt: skip
    passed = [one is not None and judge_values(scenario, one) for one in each]
    return xr.Dataset(
        {
            "position": _variable(
                ("hole", "axis"), np.stack([h.target.position for h in run.holes]), "m", "entry point"
            ),
            "drilled": _variable("hole", np.array([one is not None for one in each]), "1", "can be drilled"),
            "passed": _variable("hole", np.array(passed), "1", "meets every requirement"),
            **columns,
        },
        {"hole": np.arange(1, len(run.holes) + 1), "axis": ["x", "y", "z"]},
    )
