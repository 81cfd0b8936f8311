"""Cutting along a chamfer path: the burr on the edge, forces with a rigid tool, and a spindle that yields to them."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import lengths
from cutwise.maths.frames import rotation_from_rpy
from cutwise.paths.chamfer import proof
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.physics.engagement.ball import PassFrames
from cutwise.physics.structure.pistons import PistonRing
from cutwise.physics.structure.swings import Linked, Swinging
from cutwise.physics.structure.terms import Pistons
from cutwise.physics.surface.sweep import swept_chamfer
from cutwise.process.assemble import edge_profile
from cutwise.process.chamfer_carrier import Carrier
from cutwise.process.chamfer_cell import (
    SLICES,
    BallEnd,
    EdgeBurr,
    Pass,
    PassForces,
    Section,
    Yielding,
    across_rod,
    pass_forces,
    process_axes,
    sections,
    yielding_at_rest,
    yielding_pass,
)
from cutwise.process.chamfer_led import preset_along, way_along
from cutwise.process.edges import edges_alike
from cutwise.process.following import Feeding, ramped
from cutwise.process.spindles import piston_ring, pistons_of, weight
from cutwise.spec.carrier import Standing
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling_machine import drives_key, drives_of
from cutwise.spec.tables import Table

TIME_STEP = 20e-6  # [s] of the compliant pass
FAR_ROUND = 1.0  # [rad] dragged so far round the bends of a path, planes say nothing about the material
_STOP = 1e-9  # share of the stroke
_COARSER = 5.0  # times longer steps, where no term of the structure has mass or memory
_SUBSTEPS = 10  # of drives in a sample of their controllers, at least


class Deflected(NamedTuple):
    """A path with spindle and robot yielding."""

    moves: Yielding
    width: FloatArray  # [m] at the measured places
    rod: float | None  # [m] clearance of the rod as it is carried aside; None: nothing beside it
    travel: float  # [m] of the piston that gives way most
    stopped: bool  # whether that is all that it has
    round_bend: float  # [rad] how far round the path the ball is dragged along the feed at most

    @property
    def believed(self) -> bool:
        """Whether what is left of the chamfer can be said: not at the stop, nor dragged far round the bends."""
        return not self.stopped and self.round_bend <= FAR_ROUND


def ball_end(scenario: ChamferScenario) -> BallEnd:
    """The turning cutter in its material; unknown axial coefficients count as zero."""
    material, tool = scenario.material, scenario.tool
    assert material is not None
    assert tool.flutes is not None
    assert scenario.operation.spindle_speed is not None
    return BallEnd(tool.ball_radius, tool.flutes, scenario.operation.spindle_speed, edges_alike(material))


def mounted(path: EdgePath, paths: Sequence[EdgePath]) -> FloatArray:
    """Axes of the process frame in which the spindle hangs: x feed, y off the work, z along the rod; shape (3, 3).

    The frame at the start of the first path with this rod: the spindle does not turn with the path.
    """
    first = next((other for other in paths if np.allclose(other.axis, path.axis)), path)
    return np.array([first.local.feed[0], first.local.off[0], first.axis])


def ring_on(scenario: ChamferScenario, frame: FloatArray) -> PistonRing:
    """The compliance device with its axis along the rod; gravity has its direction in the process frame given."""
    spindle = scenario.compliant
    assert spindle is not None
    moment = np.linalg.norm(weight(spindle)) * down(scenario, frame)
    ex, ey = across_rod(frame[2])
    return piston_ring(spindle)._replace(moment_x=float(moment @ ex), moment_y=float(moment @ ey))


def down(scenario: ChamferScenario, frame: FloatArray) -> FloatArray:
    """Direction of gravity on the spindle, in the part: that of its process frame; on a robot the base says it, unless
    the spindle does."""
    spindle = scenario.compliant
    assert spindle is not None
    if spindle.gravity == "off":
        return np.zeros(3)
    if scenario.robot is not None and "gravity" not in spindle.model_fields_set:
        standing = scenario.placement or Standing()
        return np.asarray(rotation_from_rpy(*standing.rotation).T @ np.array(scenario.robot.down))
    return np.asarray(np.array(spindle.gravity) @ frame)


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
    way = way_along(path)
    whole, way = float(way[-1]), way[: len(path.path.centre)]
    size = []
    for name in ("height", "width"):
        given = getattr(burr, name)
        if isinstance(given, Table) and given.points()[0][-1] < way[-1] * (1.0 - 1e-9):
            message = f"the table ends at {given.points()[0][-1] * 1e3:.4g} mm, the edge at {way[-1] * 1e3:.4g} mm"
            raise ScenarioFault([Fault(("part", "burr", name), f"{message}; nothing is extrapolated")])
        profile = edge_profile(given, whole)
        size.append(np.interp(way, profile.at, profile.value))
    return EdgeBurr(size[0], size[1], 1 if burr.on == "wall" else 0)


def rigid(scenario: ChamferScenario, path: EdgePath, ball: BallEnd, slices: int = SLICES) -> PassForces:
    """Forces along a path with a rigid tool."""
    return pass_forces(material_along(scenario, path), ball, slices)


def deflected(
    scenario: ChamferScenario, path: EdgePath, ball: BallEnd, frame: FloatArray, carrier: Carrier | None = None, *,
    time_step: float = TIME_STEP, every: int = 1,
) -> Deflected:  # fmt: skip
    """A path with spindle and robot yielding, the spindle mounted in a process frame, and the chamfer that it leaves.

    With ``every`` above 1 the path is led through every second, third ... of its samples only, to see what they matter;
    the rod is not looked at then.
    """
    closed, centre = path.path.frames.closed, path.path.centre[::every]
    approach = (preset_along(scenario, path) + scenario.operation.part_error)[::every]
    sag = np.zeros((len(centre), 3)) if carrier is None else carrier.sag[::every]
    terms = () if carrier is None else carrier.terms
    if scenario.compliant is not None:
        ring = ring_on(scenario, frame)
        terms = (*pistons_of(scenario.compliant, ring=ring), *terms)
    remembers = any(isinstance(term, Pistons | Swinging | Linked) for _, term in terms)
    feeding = feeding_of(scenario, path)
    if not remembers:
        time_step *= _COARSER  # nothing but the drives has a time of its own
    run = Pass(path.feeds.centre[::every], approach, time_step, sag, feeding)
    run = run._replace(centre_speed=run.centre_speed[: len(centre) - (not closed)])
    section = _every(material_along(scenario, path), every)
    local = path.local._replace(
        feed=path.local.feed[::every], off=path.local.off[::every], plunge=path.local.plunge[::every]
    )
    led = path.path._replace(centre=centre)
    stepped = remembers or feeding is not None
    moves = (yielding_pass if stepped else yielding_at_rest)(section, led, local, path.axis, ball, terms, run, SLICES)
    aside = led._replace(centre=centre + moves.offset)
    span = 2.0 * float(path.path.leg.max()) + 2.0 * float(np.linalg.norm(moves.offset, axis=1).max())
    width = swept_chamfer(path.at, aside.centre, ball.ball_radius, span, closed=closed).width
    rod = path.rod_at(aside, proof.CLOSE) if every == 1 else None
    travel, stopped = 0.0, False
    if scenario.compliant is not None:
        travel = ring.arm * float((moves.tilt @ ring.direction.T).max())
        stopped = travel >= ring.piston.stroke * (1.0 - _STOP)
    bend = _round_bend(local, centre, moves, closed=closed)
    return Deflected(moves, width, None if rod is None else rod.value, travel, stopped, bend)


def feeding_of(scenario: ChamferScenario, path: EdgePath) -> Callable[[float, float], Feeding] | None:
    """The feed drives that lead the ball, as soon as duration and start of its motion are known [s]; None without any."""
    drives = drives_of(scenario.machine)
    if drives is None:
        return None
    turn = rotation_from_rpy(*(scenario.placement or Standing()).rotation) @ process_axes(path.axis)
    key, speed = drives_key(scenario.machine), float(path.feeds.centre.max())

    def feeding(duration: float, begins: float) -> Feeding:
        return ramped(drives, key, speed, duration, begins, turn, _SUBSTEPS)

    return feeding


def _every(section: Section, every: int) -> Section:
    """Every second, third ... sample of the material."""
    return section._replace(
        edge=section.edge[::every], wedge=section.wedge[::every], burr=section.burr[::every],
        speed=section.speed[::every], rise=section.rise[::every],
    )  # fmt: skip


def _round_bend(local: PassFrames, centre: FloatArray, moves: Yielding, *, closed: bool) -> float:
    """Largest angle between the feed of the nominal place and that of the place to which the ball is dragged."""
    feed = local.feed
    turn = np.linalg.norm(np.diff(np.vstack([feed, feed[:1]]) if closed else feed, axis=0), axis=1)
    step = lengths(centre, closed=closed)
    bend = turn / np.maximum(step, 1e-12)
    return float((np.abs(moves.tip[: len(bend), 0]) * bend).max())
