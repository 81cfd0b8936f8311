"""Ways of the tool to a path and away from it, proved like the path itself: nothing is cut but chamfers."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.paths.chamfer import proof
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.paths.chamfer.task import ChamferTask
from cutwise.paths.feed import Leads, leads
from cutwise.physics.surface.approach import deepest_cut, moving_ball

_SHARES = (1.0, 0.3, 0.1)  # of the retract, along the bisector of the edge, before the tool goes up


class ApproachPath(NamedTuple):
    """From a height at which the tool is clear of the part to a path point."""

    point: FloatArray  # [m] ball centres, the path point left out, shape (k, 3)
    proven: bool  # whether the tool cuts and touches nothing on it


def level(task: ChamferTask, path: EdgePath) -> float:
    """Height along the tool axis at which the ball is clear of the whole part [m]."""
    top = float((path.work.shape.mesh.corner.reshape(-1, 3) @ path.axis).max())
    if task.pipe is not None:  # its mesh goes on along the pipe; the rim of the hole is what counts
        rim = path.path.frames.point @ path.axis
        top = float(rim.max()) + task.pipe.radius * float(np.abs(path.axis[1])) + task.pipe.wall
    return top + task.tool.ball_radius + task.retract


def way_to(
    task: ChamferTask, path: EdgePath, at: int, members: Sequence[proof.EdgeZone]
) -> ApproachPath:  # fmt: skip
    """The way to a point of an open path: down along the tool axis, then along the bisector of the edge.

    The longest move along the bisector that is clear is taken; where none is, the longest, and it is said so.
    """
    ways = list(_ways(task, path, at))
    for way in ways:
        if clear(task, path, np.vstack([way, path.path.centre[[at]]]), members):
            return ApproachPath(way, True)
    return ApproachPath(ways[0], False)


def _ways(task: ChamferTask, path: EdgePath, at: int) -> Iterator[FloatArray]:
    centre, air, axis = path.path.centre[at], path.path.air[at], path.axis
    height = level(task, path)
    for share in _SHARES:
        off = centre + share * task.retract * air
        yield np.array([off + max(0.0, height - float(off @ axis)) * axis, off])
    yield (centre + max(0.0, height - float(centre @ axis)) * axis)[None]


def clear(task: ChamferTask, path: EdgePath, centre: FloatArray, members: Sequence[proof.EdgeZone]) -> bool:
    """Whether the ball cuts nothing but chamfers along some centres, and the rod touches nothing."""
    tool, shape = task.tool, path.work.shape
    table = proof.zones_near(members, path.work.number, centre, tool.ball_radius)
    limit = proof.GOUGE_LIMIT + shape.mesh.error
    ball = moving_ball(centre, tool.ball_radius, closed=False)
    if deepest_cut(proof.reachable(shape, centre, tool.ball_radius), ball, table, enough=limit).value > limit:
        return False
    rod = proof.rod_of(shape, centre, path.axis, tool, proof.ROUGH, closed=False, seen=2.0 * tool.rod_radius)
    return rod is None or rod.value >= 0.0


def ways_in_hole(task: ChamferTask, path: EdgePath, members: Sequence[proof.EdgeZone]) -> tuple[Leads, bool] | None:
    """The ways into and out of a closed path round a hole from its axis, and whether they are clear.

    None where the ball does not stand inside the hole along whose axis the rod lies.
    """
    foot, centre = path.work.foot, path.path.centre
    if foot is None or not _inside_hole(path, foot):
        return None
    retract = level(task, path) - float((centre @ path.axis).max())
    ways = leads(path.path, path.axis, foot, retract)
    end = ways.overlap[-1:] if len(ways.overlap) else centre[:1]
    fine = all(
        clear(task, path, way, members) for way in (np.vstack([ways.entry, centre[:1]]), np.vstack([end, ways.exit]))
    )
    return ways, fine


def _inside_hole(path: EdgePath, foot: FloatArray) -> bool:
    arm = path.path.centre - foot
    across = arm - (arm @ path.axis)[:, None] * path.axis
    return bool((np.einsum("ij,ij->i", across, path.path.frames.normal[:, 1]) < 0.0).all())
