"""What the scenario asks of a chamfer, as the record that planning reads."""

from cutwise.paths.chamfer.ball_path import TIERS, Chamfer
from cutwise.paths.chamfer.task import ChamferTask
from cutwise.paths.pipe import PipeHole
from cutwise.paths.reach import BallCutter
from cutwise.spec.chamfer import ChamferScenario

_SHARE = 0.05  # of the width: what it may be off where no requirement says how much


def task_of(scenario: ChamferScenario) -> ChamferTask:
    """Chamfer, tool, resolution and feed of a scenario."""
    wanted, tool, path, operation = scenario.chamfer, scenario.tool, scenario.path, scenario.operation
    feed = operation.contact_feed or operation.centre_feed
    assert feed is not None  # checked by the specification
    return ChamferTask(
        Chamfer(wanted.width, wanted.definition == "leg", 0.0, TIERS[wanted.tier]),
        None if wanted.tilt == "auto" else float(wanted.tilt),
        width_tolerance(scenario),
        BallCutter(tool.ball_radius, tool.rod_radius, tool.knife_limit_angle, tool.pole_limit_angle),
        wanted.clearance, path.points, path.chord_tolerance, operation.retract, feed, operation.contact_feed is not None,
        pipe_hole(scenario),
    )  # fmt: skip


def pipe_hole(scenario: ChamferScenario) -> PipeHole | None:
    """The drilled pipe as a record."""
    pipe = scenario.part.pipe
    if pipe is None:
        return None
    return PipeHole(pipe.radius, pipe.wall, pipe.hole_radius, pipe.eccentricity, pipe.inclination)


def width_tolerance(scenario: ChamferScenario) -> float:
    """How much the width may be off [m]: what the requirements leave, at the nearer side, or a twentieth of it."""
    width, limits = scenario.chamfer.width, scenario.requirements
    room = [
        sign * (getattr(limits[name], side) - width)
        for name, side, sign in (("width_min", "min", -1.0), ("width_max", "max", 1.0))
        if name in limits and getattr(limits[name], side) is not None
    ]  # fmt: skip
    return min((r for r in [*room, _SHARE * width] if r > 0.0), default=_SHARE * width)
