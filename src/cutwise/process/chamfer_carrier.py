"""What carries a chamfering tool along its ball path, robot or machine: what it yields by there, and what that means."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import lengths
from cutwise.maths.frames import rotation_from_rpy
from cutwise.paths.carried import CarriedPath, placed
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.physics.structure.series_compliance import in_axes, translation_at
from cutwise.process import carriage, carried, yielding
from cutwise.process.carriage import Carriage, Terms
from cutwise.process.carriers import bodies_there, postures
from cutwise.process.chamfer_cell import PassForces, Yielding, process_axes
from cutwise.process.labels import labelled
from cutwise.spec.base import known
from cutwise.spec.carrier import Standing
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.milling_machine import bodies_of

STATIONS = 401  # of a path at most, at which the posture is looked at; compliances are straight between them


class Carrier(NamedTuple):
    """What carries a tool along a ball path, which keeps the attitude of its tool, and all that yields with it."""

    terms: Terms  # of the structure but for pistons, in the axes of chamfer_cell.process_axes
    sag: FloatArray  # [m] of the ball at the samples of the path, in these axes, shape (n, 3)
    time: FloatArray  # [s] at which the stations are passed, shape (m,)
    air: FloatArray  # normal of the chamfer at the stations in these axes, out of the material, shape (m, 3)
    at: FloatArray  # [m] of the path, the stations, shape (m,)
    carriage: Carriage = Carriage()  # of an arm the process axes of the stations are feed, off the work, rod
    whole: FloatArray | None = None  # compliance of joints and base of the robot in these axes, shape (m, 6, 6)
    tip: FloatArray | None = None  # [m] of the tool at the stations, in the frame of the carrier, shape (m, 3)


class _Stations(NamedTuple):
    """Places of a ball path at which its carrier is looked at."""

    path: CarriedPath  # of the tip, in the frame of the carrier; axes: feed, off the work, rod
    time: FloatArray  # [s], shape (m,)
    here: np.ndarray  # samples of the ball path, shape (m,)
    way: FloatArray  # [m] of all samples, shape (n,)


def carrier_on(scenario: ChamferScenario, path: EdgePath, forces: PassForces) -> Carrier:
    """A robot in the postures that the scenario chooses, a machine, or neither; with tool and part as they yield.

    Raises
    ------
    Infeasible
        The path is out of reach of the robot, or leads through a singular posture.
    ScenarioFault
        The path is beyond the travel of the machine, or its spindle does not point along the rod.
    """
    found = _stations(scenario, path)
    normal = path.path.air[found.here] @ process_axes(path.axis)
    tool, n, m = scenario.tool, len(path.path.centre), len(found.here)
    bare = Carrier((), np.zeros((n, 3)), found.time, normal, found.path.at, tip=found.path.point)
    if scenario.robot is not None:
        bare = _by_robot(scenario, path, forces, found, bare)
    elif (machine := bodies_of(scenario.machine)) is not None:
        turned = rotation_from_rpy(*(scenario.placement or Standing()).rotation) @ process_axes(path.axis)
        led = found.path._replace(axes=np.tile(turned, (m, 1, 1)))
        bare = bare._replace(
            carriage=carriage.by_machine(machine, None, led, ("placement", "origin"), ("tool", "axis"))
        )
    part = carriage.off_surface(scenario.part.stiffness, found.path.at, normal)
    return bare._replace(terms=carriage.in_series(tool, bare.carriage, part))


def _stations(scenario: ChamferScenario, path: EdgePath) -> _Stations:
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
    return _Stations(in_base, time[keep], here, at[:n])


def _by_robot(
    scenario: ChamferScenario, path: EdgePath, forces: PassForces, found: _Stations, bare: Carrier
) -> Carrier:  # fmt: skip
    robot, height = scenario.robot, scenario.tool.ball_radius
    assert robot is not None
    force = np.average(np.column_stack([forces.force[:, :2], forces.felt]), axis=0)
    wrench = yielding.wrench_at(force, height)
    along = carried.arm_along(
        robot, found.path, wrench, height, float(path.feeds.centre.max()), limited=scenario.operation.limit_feed
    )
    axes = np.stack(
        [path.local.feed[found.here], path.local.off[found.here], np.tile(path.axis, (len(found.here), 1))], axis=-1
    )
    led = np.swapaxes(axes, -1, -2) @ process_axes(path.axis)
    kept = along.path._replace(axes=along.path.axes @ led)
    seen = along._replace(path=kept, joints=in_axes(along.joints, led), base=in_axes(along.base, led))
    sag = np.einsum("nji,nj->ni", led, carried.sag_at(along, height))
    return bare._replace(
        carriage=Carriage(carried.terms_of(robot, seen, height), arm=along), whole=seen.joints + seen.base,
        sag=np.column_stack([np.interp(found.way, found.path.at, column) for column in sag.T]),
    )  # fmt: skip


def slowed(scenario: ChamferScenario, path: EdgePath, carrier: Carrier) -> EdgePath:
    """The path at feeds that the joints of the robot can follow."""
    arm, robot = known(carrier.carriage.arm), known(scenario.robot)
    step = lengths(path.path.centre, closed=path.path.frames.closed)
    at = np.concatenate([[0.0], np.cumsum(step)])
    possible = carried.feeds_along(arm, robot, float(path.feeds.centre.max()))
    allowed = np.interp(0.5 * (at[1:] + at[:-1]), carrier.at, possible)
    share = np.minimum(1.0, allowed / path.feeds.centre)
    centre = share * path.feeds.centre
    feeds = path.feeds._replace(centre=centre, contact=share * path.feeds.contact, time=float((step / centre).sum()))
    return path._replace(feeds=feeds)


def measures(
    scenario: ChamferScenario, paths: Sequence[EdgePath], moves: Sequence[Yielding], carriers: Sequence[Carrier]
) -> dict[str, float]:
    """What each term of the structure yields by, and what the postures mean; the worst of all paths."""
    found = _deflections(paths, moves)
    each = [_carried(scenario, one) for one in carriers]
    for name in dict.fromkeys(name for one in each for name in one):
        values = [one[name] for one in each if name in one]
        found[name] = max(values) if name.endswith("_max") else min(values)
    return found


def _carried(scenario: ChamferScenario, carrier: Carrier) -> dict[str, float]:
    """Measures of one path; speeds of the joints are those of the feed that the ball centre has at each place."""
    found: dict[str, float] = {}
    height = scenario.tool.ball_radius
    arm = carrier.carriage.arm
    if arm is None:
        whole = yielding.whole([term for _, term in carrier.terms], carrier.at)
    else:
        feed = scenario.operation.contact_feed or scenario.operation.centre_feed
        assert feed is not None
        assert scenario.robot is not None
        evenly = arm._replace(path=arm.path._replace(at=carrier.time * feed))
        found = carried.measures(evenly, scenario.robot, feed)
        whole = known(carrier.whole)
    at_ball = translation_at(whole, height)
    normal = np.einsum("ni,nij,nj->n", carrier.air, at_ball, carrier.air)
    return found | yielding.stiffness_of(normal) | yielding.lowest_frequency(term for _, term in carrier.terms)


def in_pass(path: EdgePath, vector: FloatArray) -> FloatArray:
    """Vectors of the part in the frame of the pass: feed, off the work, rod; shape (n, 3)."""
    local = path.local
    return np.column_stack(
        [np.einsum("ij,ij->i", vector, local.feed), np.einsum("ij,ij->i", vector, local.off), vector @ path.axis]
    )


def by_term(paths: Sequence[EdgePath], moves: Sequence[Yielding]) -> dict[str, FloatArray]:
    """Displacement of the ball by each term in the frame of the pass [m], all paths one after another, shape (n, 3)."""
    pairs = [(path, dict(one.terms)) for path, one in zip(paths, moves, strict=False)]
    names = dict(moves[0].terms) if moves else {}
    return {name: np.concatenate([in_pass(path, each[name]) for path, each in pairs]) for name in names}


def _deflections(paths: Sequence[EdgePath], moves: Sequence[Yielding]) -> dict[str, float]:
    """Displacement of the ball by each term, frame of the pass, and its part off the chamfer at the worst place."""
    pairs = [(path, dict(one.terms)) for path, one in zip(paths, moves, strict=True)]
    moved = by_term(paths, moves)
    off = {
        name: np.concatenate([np.einsum("ij,ij->i", each[name], path.path.air) for path, each in pairs])
        for name in moved
    }
    worst = int(np.argmax(np.abs(sum(off.values()))))
    time = np.concatenate([durations(path) for path in paths])
    return yielding.term_measures(moved, slice(None), worst, off=off, weights=time)


def durations(path: EdgePath) -> FloatArray:
    """Time that each point of a path stands for [s], shape (n,)."""
    time = lengths(path.path.centre, closed=path.path.frames.closed) / path.feeds.centre
    return time if path.path.frames.closed else np.append(time, time[-1])


def stations(scenario: ChamferScenario, carriers: Sequence[Carrier]) -> xr.Dataset:
    """Compliance station by station, all paths one after another; of a robot its postures too."""
    arms = [one.carriage.arm for one in carriers if one.carriage.arm is not None]
    if arms and scenario.robot is not None:
        return postures(scenario.robot, arms, "place along the ball paths")
    ends = np.concatenate([[0.0], np.cumsum([one.at[-1] for one in carriers])])
    at = ("s_station", np.concatenate([start + one.at for start, one in zip(ends[:-1], carriers, strict=True)]), "m",
          "place along the ball paths")  # fmt: skip
    matrix = np.concatenate([yielding.whole([term for _, term in one.terms], one.at) for one in carriers])
    normal = np.concatenate([one.air for one in carriers])
    off = np.einsum("ni,nij,nj->n", normal, translation_at(matrix, scenario.tool.ball_radius), normal)
    told = labelled(at, {
        "compliance_normal": (off, "m/N", "compliance off the chamfer"),
        "compliance_rod": (matrix[:, 2, 2], "m/N", "compliance along the rod"),
    })  # fmt: skip
    seen = [(one.carriage.bodies, known(one.tip)) for one in carriers if one.carriage.bodies is not None]
    return bodies_there(told, seen) if len(seen) == len(carriers) else told
