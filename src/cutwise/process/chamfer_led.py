"""A planned path as it is run: deeper by the preset, on a part that stands nearer than nominal."""

from collections.abc import Sequence

from cutwise.paths.chamfer import proof
from cutwise.paths.chamfer.plan import EdgePath, swept
from cutwise.process.chamfer_task import task_of
from cutwise.spec.chamfer import ChamferScenario


def programmed(scenario: ChamferScenario, path: EdgePath) -> EdgePath:
    """The path that is written out: the planned one, led into the work by the preset across the tool axis."""
    return _nearer(path, scenario.operation.preset)


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
    approach = scenario.operation.preset + scenario.operation.part_error
    if approach == 0.0:
        return path
    moved = _nearer(path, approach)
    left = swept(task_of(scenario), moved.path, path.at, further=abs(approach))
    if scenario.yields:
        return path._replace(found=left)
    moved = moved._replace(found=left)
    radius = scenario.tool.ball_radius
    gouge = proof.gouge_of(
        path.work.shape, moved.path, radius, members, path.work.number, float(left.beyond.max(initial=0.0))
    )
    return moved._replace(gouge=gouge, rod=path.rod_at(moved.path, proof.EXACT))


def _nearer(path: EdgePath, approach: float) -> EdgePath:
    """The path, moved into the work [m]."""
    if approach == 0.0:
        return path
    return path._replace(path=path.path._replace(centre=path.path.centre - approach * path.local.off))
