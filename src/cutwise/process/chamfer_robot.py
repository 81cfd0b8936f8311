"""A chamfer carried by a robot: its postures along the ball path, what it yields by there, and what that means."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import lengths
from cutwise.maths.frames import rotation_from_rpy
from cutwise.paths.carried import CarriedPath, placed
from cutwise.physics.structure.series_compliance import in_axes, translation_at
from cutwise.physics.structure.terms import Swinging, natural_frequencies
from cutwise.process import arm_geometry, carried
from cutwise.process.chamfer_cell import PassForces, Yielding, process_axes
from cutwise.process.chamfer_plan import EdgePath
from cutwise.process.labels import labelled
from cutwise.spec.carrier import CarryingRobot, Standing
from cutwise.spec.chamfer import ChamferScenario

STATIONS = 401  # of a path at most, at which the posture is looked at; compliances are straight between them


class ArmOnPath(NamedTuple):
    """A robot along a ball path that keeps the attitude of its tool, unless its angle turns."""

    along: carried.ArmAlong  # process axes of the stations: feed, off the work, rod
    terms: tuple[tuple[str, NamedTuple], ...]  # of the structure, in the axes of chamfer_cell.process_axes
    sag: FloatArray  # [m] of the ball at the samples of the path, in these axes, shape (n, 3)
    time: FloatArray  # [s] at which the stations are passed, shape (m,)
    air: FloatArray  # normal of the chamfer at the stations in their axes, out of the material, shape (m, 3)


def arm_on(scenario: ChamferScenario, path: EdgePath, forces: PassForces) -> ArmOnPath:
    """The postures of the robot along a path, as the scenario chooses them.

    Raises
    ------
    Infeasible
        The path is out of reach, or leads through a singular posture.
    """
    robot = scenario.robot
    assert robot is not None
    frames, height = path.path.frames, scenario.tool.ball_radius
    n, closed = len(path.path.centre), frames.closed
    step = lengths(path.path.centre, closed=closed)
    at = np.concatenate([[0.0], np.cumsum(step)])
    time = np.concatenate([[0.0], np.cumsum(step / path.feeds.centre)])
    keep = np.unique(np.linspace(0, len(at) - 1, min(len(at), STATIONS)).round().astype(int))
    here = keep % n
    axes = np.stack([path.local.feed[here], path.local.off[here], np.tile(path.axis, (len(keep), 1))], axis=-1)
    nominal = CarriedPath(at[keep], path.path.centre[here] - height * path.axis, axes)
    standing = scenario.placement or Standing()
    in_base = placed(nominal, rotation_from_rpy(*standing.rotation), np.array(standing.origin))
    force = np.average(np.column_stack([forces.force[:, :2], forces.felt]), axis=0)
    wrench = np.array([*force, -height * force[1], height * force[0], 0.0])
    along = carried.arm_along(robot, in_base, wrench, height, float(path.feeds.centre.max()))
    led = np.swapaxes(axes, -1, -2) @ process_axes(path.axis)
    seen = along._replace(joints=in_axes(along.joints, led), base=in_axes(along.base, led))
    ball = along.sag[:, :3] + np.cross(along.sag[:, 3:], [0.0, 0.0, height])
    sag = np.einsum("nji,nj->ni", led, ball)
    air = np.einsum("nji,nj->ni", axes, path.path.air[here])
    return ArmOnPath(
        along, carried.terms_of(robot, seen, height),
        np.column_stack([np.interp(at[:n], at[keep], column) for column in sag.T]), time[keep], air,
    )  # fmt: skip


def measures(
    scenario: ChamferScenario, paths: Sequence[EdgePath], moves: Sequence[Yielding], arms: Sequence[ArmOnPath]
) -> dict[str, float]:
    """What each term of the structure yields by, and what the postures mean; the worst of all paths."""
    found = _deflections(paths, moves)
    robot, feed = scenario.robot, scenario.operation.contact_feed or scenario.operation.centre_feed
    assert robot is not None
    assert feed is not None
    each = [_postures(robot, arm, feed, scenario.tool.ball_radius) for arm in arms]
    for name in dict.fromkeys(name for one in each for name in one):
        values = [one[name] for one in each if name in one]
        found[name] = max(values) if name.endswith("_max") else min(values)
    return found


def _postures(robot: CarryingRobot, arm: ArmOnPath, feed: float, height: float) -> dict[str, float]:
    """Measures of one path; speeds of the joints are those of the feed that the ball centre has at each place."""
    evenly = arm.along._replace(path=arm.along.path._replace(at=arm.time * feed))
    found = carried.measures(evenly, robot, feed)
    at_ball = translation_at(arm.along.joints + arm.along.base, height)
    normal = np.einsum("ni,nij,nj->n", arm.air, at_ball, arm.air)
    found["stiffness_normal_min"], found["stiffness_normal_max"] = float(1 / normal.max()), float(1 / normal.min())
    swings = [natural_frequencies(term) for _, term in arm.terms if isinstance(term, Swinging)]
    if swings:
        found["natural_frequency_min"] = float(swings[0].min())
    return found


def in_pass(path: EdgePath, vector: FloatArray) -> FloatArray:
    """Vectors of the part in the frame of the pass: feed, off the work, rod; shape (n, 3)."""
    local = path.local
    return np.column_stack(
        [np.einsum("ij,ij->i", vector, local.feed), np.einsum("ij,ij->i", vector, local.off), vector @ path.axis]
    )


def _deflections(paths: Sequence[EdgePath], moves: Sequence[Yielding]) -> dict[str, float]:
    """Displacement of the ball by each term, frame of the pass, and its part off the chamfer at the worst place."""
    time = np.concatenate([_durations(path) for path in paths])
    off = {}
    found = {}
    for k, (name, _) in enumerate(moves[0].terms):
        here = [one.terms[k][1] for one in moves]
        value = np.concatenate([in_pass(path, one) for path, one in zip(paths, here, strict=True)])
        off[name] = np.concatenate(
            [np.einsum("ij,ij->i", one, path.path.air) for path, one in zip(paths, here, strict=True)]
        )
        for axis, letter in enumerate("xy" if name == "pistons" else "xyz"):
            part = value[:, axis]
            found[f"deflection_{name}_mean_{letter}"] = float(np.average(part, weights=time))
            found[f"deflection_{name}_max_{letter}"] = float(part[int(np.argmax(np.abs(part)))])
    worst = int(np.argmax(np.abs(sum(off.values()))))
    return found | {f"share_{name}": float(value[worst]) for name, value in off.items()}


def _durations(path: EdgePath) -> FloatArray:
    time = lengths(path.path.centre, closed=path.path.frames.closed) / path.feeds.centre
    return time if path.path.frames.closed else np.append(time, time[-1])


def infeasible(scenario: ChamferScenario, found: Mapping[str, float]) -> tuple[str, ...]:
    """Why the robot cannot do it."""
    feed = scenario.operation.contact_feed or scenario.operation.centre_feed
    if feed is None or found.get("joint_speed_margin", 1.0) >= 0.0:
        return ()
    possible = units.show(found["feed_possible_min"], "speed")
    return (
        f"joint_speed: the joints follow {possible} at most, the feed is {units.show(feed, 'speed')}; reduce it, or move "
        "the part (placement)",
    )


def warnings(scenario: ChamferScenario, arms: Sequence[ArmOnPath]) -> tuple[str, ...]:
    """What was not looked at."""
    robot, said = scenario.robot, []
    if robot is None:
        return ()
    if not robot.joint_speed:
        said.append("robot.joint_speed is not given: whether the joints can follow the feed was not looked at")
    if robot.sag != "ignored" and not carried.weights(robot):
        said.append(
            "robot.sag: no weight of tool or links is given (robot.tool_mass, robot.links): the sag is left out"
        )
    return (
        *said,
        *(
            text
            for arm in arms
            for text in arm_geometry.warnings(robot, arm.along.wrong, scenario.measured.get("robot"))
        ),
    )


def notes(arms: Sequence[ArmOnPath]) -> dict[str, str]:
    """What another angle of the tool would bring."""
    known = [arm.along for arm in arms if math.isfinite(arm.along.constant) and math.isfinite(arm.along.turned)]
    constant, turned = (sum(getattr(one, name) for one in known) for name in ("constant", "turned"))
    if not known or turned >= constant * (1 - 1e-6):
        return {}
    return {
        "redundancy": (
            f"With robot.redundancy_angle: along_path the arm would yield by {turned / len(known) * 1e6:.4g} µm on average "
            f"under the rigid cut, with the best single angle by {constant / len(known) * 1e6:.4g} µm."
        )
    }


def postures(scenario: ChamferScenario, arms: Sequence[ArmOnPath]) -> xr.Dataset:
    """Postures and compliance station by station, all paths one after another."""
    ends = np.concatenate([[0.0], np.cumsum([arm.along.path.at[-1] for arm in arms])])
    at = np.concatenate([start + arm.along.path.at for start, arm in zip(ends[:-1], arms, strict=True)])
    assert scenario.robot is not None
    joints = [joint.name or str(n) for n, joint in enumerate(scenario.robot.joints, 1)]
    matrix = np.concatenate([arm.along.joints + arm.along.base for arm in arms])
    return labelled(("s_station", at, "m", "place along the ball paths"), {
        "joint_angles": (np.concatenate([arm.along.postures.q for arm in arms]), "rad", "angles of the joints"),
        "redundancy_angle": (
            np.concatenate([arm.along.postures.angle for arm in arms]), "rad", "angle of the tool about its axis"
        ),
        "compliance_off_work": (matrix[:, 1, 1], "m/N", "compliance off the work, across the rod"),
        "compliance_rod": (matrix[:, 2, 2], "m/N", "compliance along the rod"),
    }, joint=joints)  # fmt: skip
