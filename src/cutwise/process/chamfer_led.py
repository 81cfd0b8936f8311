"""A planned path as it is run: deeper by the preset, on a part that stands nearer than nominal."""

from collections.abc import Sequence

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import arc_lengths
from cutwise.paths.chamfer import proof
from cutwise.paths.chamfer.plan import EdgePath, swept
from cutwise.process.chamfer_task import task_of
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.faults import Fault, ScenarioFault


def programmed(scenario: ChamferScenario, path: EdgePath) -> EdgePath:
    """The path that is written out: the planned one, led into the work by the preset across the tool axis."""
    return _nearer(path, preset_along(scenario, path))


def way_along(path: EdgePath) -> FloatArray:
    """Way along the edge from the first point of a path to each of its points, and to its end [m], shape (n + closed,)."""
    frames = path.path.frames
    return np.concatenate([[0.0], np.cumsum(arc_lengths(frames.point, frames.tangent, closed=frames.closed))])


def preset_along(scenario: ChamferScenario, path: EdgePath) -> FloatArray:
    """How much deeper than planned a path is led, at its points [m], shape (n,).

    Raises
    ------
    ScenarioFault
        A table ends before the edge does.
    """
    preset = np.full(len(path.path.centre), scenario.operation.preset)
    profile = scenario.operation.preset_profile
    if profile is None:
        return preset
    (at, value), way = profile.points(), way_along(path)
    if at[0] > 1e-9 * way[-1] or at[-1] < way[-1] * (1.0 - 1e-9):
        message = (
            f"the table covers {at[0] * 1e3:.4g} to {at[-1] * 1e3:.4g} mm, the edge needs 0 to {way[-1] * 1e3:.4g} mm"
        )
        raise ScenarioFault([Fault(("operation", "preset_profile"), f"{message}; nothing is extrapolated")])
    return preset + np.interp(way[: len(preset)], at, value)


def as_run(scenario: ChamferScenario, path: EdgePath, members: Sequence[proof.EdgeZone]) -> EdgePath:
    """The path of a rigid tool, seen from the part, with what it leaves and cuts there.

    The ball is led into the work by preset and part error together, across the tool axis and at right angles to the feed.
    Everything else (where it cuts beside the chamfer, how near its rod comes, its forces) is that of the moved path for
    a rigid tool only: a tool that yields goes elsewhere, and keeps the planned path to be compared with.

    Parameters
    ----------
    scenario : ChamferScenario
        What says preset, part error and whether anything yields.
    path : EdgePath
        The planned path.
    members : sequence of EdgeZone
        Where the tool is meant to cut.
    """
    approach = preset_along(scenario, path) + scenario.operation.part_error
    if not approach.any():
        return path
    moved = _nearer(path, approach)
    left = swept(task_of(scenario), moved.path, path.at, further=float(np.abs(approach).max()))
    if scenario.yields:
        return path._replace(found=left)
    moved = moved._replace(found=left)
    radius = scenario.tool.ball_radius
    gouge = proof.gouge_of(
        path.work.shape, moved.path, radius, members, path.work.number, float(left.beyond.max(initial=0.0))
    )
    return moved._replace(gouge=gouge, rod=path.rod_at(moved.path, proof.EXACT))


def _nearer(path: EdgePath, approach: FloatArray) -> EdgePath:
    """The path, moved into the work [m] at each of its points."""
    if not approach.any():
        return path
    return path._replace(path=path.path._replace(centre=path.path.centre - approach[:, None] * path.local.off))
