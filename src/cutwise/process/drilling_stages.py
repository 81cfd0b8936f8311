"""The histories of a drilling run as labelled arrays, one group per stage."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths.frames import FloatArray
from cutwise.physics.cutting.drill import lip_force, margin_torque
from cutwise.physics.cutting.drill_elements import elements_force
from cutwise.physics.engagement.lip import lip_contact
from cutwise.physics.structure.joint_compliance import worst_skating
from cutwise.process import carriers
from cutwise.process.drilling import DrillCell, DrilledHole, DrillRun
from cutwise.process.drilling_measures import hole_measures
from cutwise.process.labels import Column, Coordinate, Group, Over, Read
from cutwise.process.loops_drilling import HISTORY
from cutwise.process.posture_search import scan
from cutwise.process.postures import Candidates
from cutwise.results import judge_values
from cutwise.spec.drilling import DrillingScenario

if TYPE_CHECKING:
    from cutwise.process import drilling_machine
else:
    drilling_machine = later("cutwise.process.drilling_machine")

_DEPTHS = 400
_AZIMUTHS = np.array([0.0, 0.5, 1.0, 1.5]) * math.pi
_TURNS = np.linspace(-math.pi, math.pi, 181)  # redundancy angles [rad] of the map
_TABLE = (
    ("compliance_axial", "m/N"), ("skating_ratio", "1"), ("hole_position_error_entry", "m"),
    ("hole_position_error_exit", "m"), ("perpendicularity_error", "rad"), ("circularity_estimate", "m"),
    ("feed_per_rev_max", "m"), ("thrust_max", "N"),
)  # fmt: skip
"""Measures of every hole in the table of the holes."""


class Told(NamedTuple):
    """A run, and what several columns are read from."""

    scenario: DrillingScenario
    run: DrillRun
    each: list[dict[str, float] | None]  # measures of every hole, None for one that was not drilled
    drilled: list[DrilledHole]
    history: FloatArray  # of the drilled holes, shape (hole, time, column)
    nominal: FloatArray  # thrust and torque of the chisel edge over depth, shape (depth, 2)
    found: Candidates | None  # all postures of the first hole over the redundancy angle


def told(scenario: DrillingScenario, run: DrillRun) -> Told:
    """What the tables of a run are read from."""
    each = [hole_measures(scenario, run.cell, hole) if hole.outcome else None for hole in run.holes]
    drilled = [hole for hole in run.holes if hole.outcome is not None]
    history = _of_one_length([hole.history for hole in drilled]) if drilled else np.zeros((0, 0, len(HISTORY)))
    arm = run.cell.arm
    found = None if arm is None else scan(arm, run.holes[0].target, _TURNS)
    return Told(scenario, run, each, drilled, history, _chisel(scenario, run.cell), found)


def _of_one_length(histories: list[FloatArray]) -> FloatArray:
    """Histories of all holes over the time of the longest, shape (hole, time, column); a shorter one stays at its end."""
    longest = max(histories, key=len)
    same = []
    for history in histories:
        rest = np.repeat(history[-1:], len(longest) - len(history), axis=0)
        rest[:, 0] = longest[len(history) :, 0]
        same.append(np.concatenate([history, rest]))
    return np.stack(same)


def _depth(told: Told, beyond: float) -> FloatArray:
    """Depths of the tip [m], on to so many heights of the point behind the plate."""
    return np.linspace(0.0, told.scenario.part.thickness + beyond * told.run.cell.cycle.cone, _DEPTHS)


def _contact(told: Told) -> FloatArray:
    """Radii between which a lip cuts, at four azimuths, over the depth of the tip; shape (depth, azimuth, 2)."""
    part, point = told.scenario.part, told.run.cell.point
    return np.array([
        [lip_contact(h, part.thickness, point.radius, point.half_point_angle, part.inclination, a) for a in _AZIMUTHS]
        for h in _depth(told, 1.5)
    ])  # fmt: skip


def _chisel(scenario: DrillingScenario, cell: DrillCell) -> FloatArray:
    """Thrust and torque of the chisel edge at nominal feed over depth [N, N m], shape (depth, 2)."""
    depth = np.linspace(0.0, scenario.part.thickness + 1.2 * cell.cycle.cone, _DEPTHS)
    feed, thickness, chisel_radius = scenario.operation.feed_per_rev, scenario.part.thickness, cell.point.chisel_radius
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
    return chisel


def _nominal(told: Told, name: str) -> FloatArray:
    """Thrust or torque over depth at nominal feed."""
    profile = told.run.cell.profile
    return np.interp(_depth(told, 1.2), profile.depth, getattr(profile, name))


def _margin(told: Told) -> FloatArray:
    """Torque of the margins over depth [N m]."""
    cell, thickness = told.run.cell, told.scenario.part.thickness
    return np.array([margin_torque(cell.point, cell.law.margin_stress, h, thickness) for h in _depth(told, 1.2)])


def _lateral(told: Told) -> FloatArray:
    profile, depth = told.run.cell.profile, _depth(told, 1.2)
    return np.stack([np.interp(depth, profile.depth, profile.lateral[:, k]) for k in (0, 1)], axis=1)


def _of_history(*names: str) -> Read:
    """Columns of the histories, shape (hole, time) or (hole, time, n)."""
    places = [HISTORY.index(name) for name in names]
    return lambda told: told.history[:, :, places[0] if len(places) == 1 else places]


def _postures(told: Told) -> FloatArray:
    return np.stack([hole.posture.q for hole in told.drilled if hole.posture is not None])


def _points(told: Told) -> FloatArray:
    """Joints and tip of the arm in its postures [m], shape (hole, point, 3)."""
    arm = told.run.cell.arm
    assert arm is not None
    return carriers.points_of(arm, _postures(told))


def _bodies(told: Told) -> FloatArray | None:
    machine = told.scenario.machine
    if machine is None:
        return None
    return drilling_machine.body_origins(machine, told.scenario.part.block, [hole.target for hole in told.drilled])


def _skating(told: Told) -> FloatArray:
    assert told.found is not None
    slope = (told.run.cell.slope_direction - _TURNS)[:, None]
    return worst_skating(told.found.holding, told.run.cell.side, slope)


def _measured(name: str, unit: str) -> Column:
    """A measure of every hole, NaN where it has none; its meaning is that of the measure."""
    return Column(
        "hole", lambda told: np.array([math.nan if one is None else one.get(name, math.nan) for one in told.each]), unit,
        lambda told: type(told.scenario).measures[name].description,
    )  # fmt: skip


def _of_arm(read: Read) -> Read:
    return lambda told: None if told.run.cell.arm is None else read(told)


def _any(told: Told) -> bool:
    return bool(told.drilled)


_TWIST = ["x", "y", "z", "rx", "ry", "rz"]
_OVER: Over = {
    "hole": Coordinate(lambda told: [k + 1 for k, hole in enumerate(told.run.holes) if hole.outcome is not None], "1",
                       "number of the hole"),
    "time": Coordinate(lambda told: told.history[0, :, 0], "s", "time"),
    "axis": _TWIST[:3], "across": _TWIST[:2], "twist": _TWIST, "wrench": _TWIST,
    "joint": range(1, 7),
    "point": lambda told: ["base", *(f"joint {k}" for k in range(1, len(told.run.cell.arm.chain.kinds) + 1)), "drill tip"],
    "mode": lambda told: np.arange(1, len(told.drilled[0].frequencies) + 1),
}  # fmt: skip
_HOLES: Over = {"hole": lambda told: np.arange(1, len(told.run.holes) + 1), "axis": _TWIST[:3]}
GROUPS = {
    "engagement": Group({
        "inner_radius": Column("depth azimuth", lambda told: _contact(told)[..., 0], "m", "inner radius of contact"),
        "outer_radius": Column("depth azimuth", lambda told: _contact(told)[..., 1], "m", "outer radius of contact"),
    }, {"depth": Coordinate(lambda told: _depth(told, 1.5), "m", "depth of the tip"),
        "azimuth": Coordinate(lambda _: _AZIMUTHS, "rad", "azimuth of the lip")}),
    "cutting": Group({
        "thrust_nominal": Column("depth", lambda told: _nominal(told, "thrust"), "N", "thrust at nominal feed"),
        "thrust_chisel": Column("depth", lambda told: told.nominal[:, 0], "N", "thrust of the chisel edge"),
        "thrust_lips": Column("depth", lambda told: _nominal(told, "thrust") - told.nominal[:, 0], "N", "thrust of the lips"),
        "torque_nominal": Column("depth", lambda told: _nominal(told, "torque"), "N*m", "torque at nominal feed"),
        "torque_chisel": Column("depth", lambda told: told.nominal[:, 1], "N*m", "torque of the chisel edge"),
        "torque_margin": Column("depth", _margin, "N*m", "torque of the margins"),
        "torque_lips": Column("depth", lambda told: _nominal(told, "torque") - told.nominal[:, 1] - _margin(told), "N*m",
                              "torque of the lips"),
        "lateral_nominal": Column("depth across", _lateral, "N", "mean lateral force, axes of the slope"),
        "thrust": Column("hole time", lambda told: _of_history("thrust")(told) if told.drilled else None, "N", "thrust"),
        "torque": Column("hole time", lambda told: _of_history("torque")(told) if told.drilled else None, "N*m", "drill torque"),
    }, {**_OVER, "depth": Coordinate(lambda told: _depth(told, 1.2), "m", "depth of the tip")}),
    "holes": Group({
        "position": Column("hole axis", lambda told: np.stack([h.target.position for h in told.run.holes]), "m", "entry point"),
        "drilled": Column("hole", lambda told: np.array([one is not None for one in told.each]), "1", "can be drilled"),
        "passed": Column("hole", lambda told: np.array([
            one is not None and judge_values(told.scenario, one) for one in told.each
        ]), "1", "meets every requirement"),
        "redundancy_angle": _measured("redundancy_angle", "rad")._replace(
            read=_of_arm(_measured("redundancy_angle", "rad").read)
        ),
        **{name: _measured(name, unit) for name, unit in _TABLE},
    }, _HOLES),
    "map": Group({
        "compliance_axial": Column("redundancy_angle branch", lambda told: told.found.compliance, "m/N",
                                   "compliance along the drill axis"),
        "skating_ratio": Column("redundancy_angle branch", _skating, "1", "skating ratio"),
        "wrist_sine": Column("redundancy_angle branch", lambda told: told.found.wrist_sine, "1", "|sin| of the wrist angle"),
        "within_limits": Column("redundancy_angle branch", lambda told: told.found.within, "1", "within the joint limits"),
    }, {"redundancy_angle": Coordinate(lambda _: _TURNS, "rad", "redundancy angle"),
        "branch": lambda told: np.arange(told.found.q.shape[1])}, lambda told: told.found is not None),
    "motion": Group({
        "depth": Column("hole time", _of_history("depth"), "m", "depth of the tip"),
        "feed_per_rev": Column("hole time", _of_history("feed"), "m", "actual feed per revolution"),
        "joint_angle": Column("hole joint", _of_arm(_postures), "rad", "joint angles"),
        "arm": Column("hole point axis", _of_arm(_points), "m", "joints and drill tip in the base frame"),
        "body_origin": Column("hole body axis", _bodies, "m", "origins of the bodies in the part"),
    }, _OVER, _any),
    "structure": Group({
        "tip_deflection": Column("hole time axis", _of_history("x", "y", "z"), "m", "deflection of the tool tip, tool axes"),
        "wall_force": Column("hole time across", _of_history("wall_x", "wall_y"), "N", "force of the hole on the drill"),
        "compliance": Column("hole twist wrench", lambda told: np.stack([
            hole.posture.compliance for hole in told.drilled if hole.posture is not None
        ]), "m/N", "compliance in tool axes (rotations 1/N, 1/(N m))"),
        "natural_frequency": Column("hole mode", lambda told: np.stack([hole.frequencies for hole in told.drilled]), "Hz",
                                    "frequencies of the arm at the tool"),
    }, _OVER, _any),
    "surface": Group({
        "hole_position": Column("hole time across", _of_history("hole_x", "hole_y"), "m",
                                "lateral position of the hole, tool axes"),
    }, _OVER, _any),
}  # fmt: skip
"""All groups; ``cutting`` holds thrust and torque over depth at nominal feed with the shares of chisel edge, lips and margins."""
