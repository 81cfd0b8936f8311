"""Cutting along a chamfer path: the burr on the edge, forces with a rigid tool, and a spindle that yields to them."""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import arc_lengths, lengths
from cutwise.physics.structure.pistons import PistonRing
from cutwise.physics.surface.sweep import swept_chamfer
from cutwise.process import chamfer_proof as proof
from cutwise.process.assemble import edge_profile, edges_alike, piston_ring, weight
from cutwise.process.chamfer_loop import (
    SLICES,
    BallEnd,
    EdgeBurr,
    Pass,
    PassForces,
    Section,
    Yielding,
    across_rod,
    pass_forces,
    sections,
    yielding_pass,
)
from cutwise.process.chamfer_plan import EdgePath
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.tables import Table

TIME_STEP = 20e-6  # [s] of the compliant pass


class Deflected(NamedTuple):
    """A path with the spindle yielding."""

    moves: Yielding
    width: FloatArray  # [m] at the measured places
    rod: float | None  # [m] clearance of the rod as it is carried aside; None: nothing beside it
    travel: float  # [m] of the piston that gives way most
    round_bend: float  # [rad] how far round the path the ball is dragged along the feed at most


def ball_end(scenario: ChamferScenario) -> BallEnd:
    """The turning cutter in its material; unknown axial coefficients count as zero."""
    material, tool = scenario.material, scenario.tool
    assert material is not None
    assert tool.flutes is not None
    assert scenario.operation.spindle_speed is not None
    return BallEnd(tool.ball_radius, tool.flutes, scenario.operation.spindle_speed, edges_alike(material))


def ring_on(scenario: ChamferScenario, axis: FloatArray) -> PistonRing:
    """The compliance device with its axis along the rod; gravity has its direction in the frame of the part here."""
    spindle = scenario.spindle
    assert spindle is not None
    moment = weight(spindle)
    ex, ey = across_rod(axis)
    return piston_ring(spindle)._replace(moment_x=float(moment @ ex), moment_y=float(moment @ ey))


def material_along(scenario: ChamferScenario, path: EdgePath) -> Section:
    """Wedge, burr and feed along a path."""
    speed = path.feeds.contact
    at_points = speed if path.path.frames.closed else np.append(speed, speed[-1])
    return sections(path.path, path.local, path.axis, at_points, burr_along(scenario, path))


def burr_along(scenario: ChamferScenario, path: EdgePath) -> EdgeBurr | None:
    """The burr at the points of a path, over the way along the edge from the first of them.

    Raises
    ------
    ScenarioFault
        A table ends before the edge does.
    """
    burr = scenario.part.burr
    if burr is None:
        return None
    frames = path.path.frames
    steps = arc_lengths(frames.point, frames.tangent, closed=frames.closed)
    way = np.concatenate([[0.0], np.cumsum(steps)])[: len(frames.point)]
    size = []
    for name in ("height", "width"):
        given = getattr(burr, name)
        if isinstance(given, Table) and given.points()[0][-1] < way[-1] * (1.0 - 1e-9):
            message = f"the table ends at {given.points()[0][-1] * 1e3:.4g} mm, the edge at {way[-1] * 1e3:.4g} mm"
            raise ScenarioFault([Fault(("part", "burr", name), f"{message}; nothing is extrapolated")])
        profile = edge_profile(given, float(steps.sum()))
        size.append(np.interp(way, profile.at, profile.value))
    return EdgeBurr(size[0], size[1], 1 if burr.on == "wall" else 0)


def rigid(scenario: ChamferScenario, path: EdgePath, ball: BallEnd, slices: int = SLICES) -> PassForces:
    """Forces along a path with a rigid tool."""
    return pass_forces(material_along(scenario, path), ball, slices)


def deflected(
    scenario: ChamferScenario, path: EdgePath, ball: BallEnd, *, time_step: float = TIME_STEP, slices: int = SLICES
) -> Deflected:
    """A path with the spindle yielding, and the chamfer that it leaves."""
    assert scenario.spindle is not None
    closed = path.path.frames.closed
    run = Pass(path.feeds.centre, scenario.operation.preset + scenario.operation.part_error, time_step)
    moves = yielding_pass(
        material_along(scenario, path), path.path, path.local, path.axis, ball, ring_on(scenario, path.axis),
        scenario.spindle.tool_reach, run, slices,
    )  # fmt: skip
    centre = path.path.centre + moves.offset
    span = 2.0 * float(path.path.leg.max()) + 2.0 * float(np.linalg.norm(moves.offset, axis=1).max())
    width = swept_chamfer(path.at, centre, ball.ball_radius, span, closed=closed).width
    aside = path.path._replace(centre=centre)
    rod = path.rod_at(aside, proof.CLOSE)
    ring = ring_on(scenario, path.axis)
    travel = ring.arm * float((moves.tilt @ ring.direction.T).max())
    return Deflected(moves, width, None if rod is None else rod.value, travel, _round_bend(path, moves))


def _round_bend(path: EdgePath, moves: Yielding) -> float:
    """Largest angle between the feed of the nominal place and that of the place to which the ball is dragged."""
    feed, closed = path.local.feed, path.path.frames.closed
    turn = np.linalg.norm(np.diff(np.vstack([feed, feed[:1]]) if closed else feed, axis=0), axis=1)
    step = lengths(path.path.centre, closed=closed)
    bend = turn / np.maximum(step, 1e-12)
    return float((np.abs(moves.tip[: len(bend), 0]) * bend).max())
