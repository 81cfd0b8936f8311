"""Planning the path along one edge: tilt, tool axis, points, feed, margins; with the proof of each path."""

import math
from collections.abc import Callable, Sequence
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames, part_of
from cutwise.paths import feed as feeds
from cutwise.paths import reach
from cutwise.paths.chamfer import fading, proof
from cutwise.paths.chamfer.ball_path import (
    Chamfer,
    ChamferPath,
    NoPathError,
    chamfer_path,
    path_of,
    reversed_path,
    swapped_path,
)
from cutwise.paths.chamfer.task import ChamferTask, EdgeWork
from cutwise.paths.pipe import PipeHole, one_turn
from cutwise.physics.engagement.ball import PassFrames, pass_frames
from cutwise.physics.surface.approach import Approach, Wanted
from cutwise.physics.surface.sweep import SweptChamfer, swept_chamfer

if TYPE_CHECKING:
    from scipy import optimize
else:
    optimize = later("scipy.optimize")

MEASURED = 73  # places at which an edge is measured, off the path points
_PLUNGE = 0.99  # an edge that runs along a tool axis everywhere, within 8 degrees, is not run on that axis
_TRIES = 8  # of spreading points more closely until the chord tolerance is kept
_FEW = 25  # samples of a path while axes and tilts are tried
_NEAR_TILT = math.radians(0.2)  # within which a tilt found with a rough rod is sought again
_HOPELESS = 0.2  # of its radius: a rod that is in the part by more is on the wrong axis
_STEP_Z = 1e-7  # [m] of the set-up sensitivity


class EdgePath(NamedTuple):
    """A planned and proven path."""

    work: EdgeWork
    path: ChamferPath  # at its points
    axis: FloatArray  # rod direction, shape (3,)
    local: PassFrames
    tilt: float  # [rad]
    feeds: feeds.Feeds
    at: EdgeFrames  # where the chamfer is measured
    found: SweptChamfer  # what the sweep left there
    gouge: Approach  # deepest cut outside of the chamfers
    rod: Approach | None  # distance of the part from the surface of the rod; None: nothing beside the rod
    margins: tuple[reach.Margin, ...]
    chord_error: float  # [m]
    slope: FloatArray  # width change per unit shift along the axis, at the measured places
    ball_radius: float  # [m]
    rod_at: Callable[[ChamferPath, Wanted], Approach | None]  # the same for another path of the ball
    stick_out: float  # [m] of rod beside which the part stands; NaN: along a pipe, whose length is not known
    rod_each: FloatArray | None = None  # [m] clearance of the rod at each point, where it is known in closed form

    @property
    def sensitivity(self) -> float:
        """Width change per unit shift along the axis, where it is largest; NaN if it is not known anywhere."""
        known = self.slope[np.isfinite(self.slope)]
        return float(known[np.argmax(np.abs(known))]) if known.size else math.nan

    @property
    def failed(self) -> tuple[reach.Margin, ...]:
        """The inequalities that do not hold."""
        return tuple(margin for margin in self.margins if not margin.met)


def plan_pipe(task: ChamferTask, work: EdgeWork, part: PipeHole) -> EdgePath:
    """The path round the hole of a pipe.

    Raises
    ------
    NoPathError
        No ball position leaves this chamfer.
    """
    tool, axis = task.tool, work.axes[0]
    assert work.frames_at is not None
    cut = task.cut
    count = task.points or feeds.points_for(
        chamfer_path(work.nodes, cut, tool.ball_radius), task.chord_tolerance or 2e-6
    )
    frames = work.frames_at(one_turn(count))

    def path_at(tilt: float) -> ChamferPath:
        return chamfer_path(frames, cut._replace(tilt=tilt), tool.ball_radius, nodes=work.nodes)

    tilt = task.tilt
    if tilt is None:
        tilt = 0.0 if cut.leg else needed_tilt(task, work, part, path_at) or 0.0
    path = path_at(tilt)
    at = work.frames_at(2.0 * np.pi * (np.arange(MEASURED) + 0.37) / MEASURED)
    margins = [*reach.tool_margins(tool)]
    if work.inner and np.allclose(axis, part.drill_axis):
        margins.append(reach.entry_margin(part, tool, task.clearance))
    elif work.inner:
        margins.append(reach.bore_margin(part, tool, task.clearance))
    found, rod = pipe_margins(task, work, part, path, proof.EXACT)
    zone = proof.edge_zone(work, float(path.leg.max()), task.cut.width)
    left = swept(task, path, at)
    gouge = proof.gouge_of(work.shape, path, tool.ball_radius, [zone], work.number, float(left.beyond.max()))
    done = finished(
        task, work, path, axis, tilt, at, left, gouge, rod, [*margins, *found],
        lambda other, wanted: pipe_margins(task, work, part, other, wanted)[1],
    )  # fmt: skip
    if work.inner and np.allclose(axis, part.drill_axis):
        done = done._replace(rod_each=reach.rod_wall_clearances(path, part, tool))
    return done


def pipe_margins(
    task: ChamferTask, work: EdgeWork, part: PipeHole, path: ChamferPath, wanted: Wanted
) -> tuple[list[reach.Margin], Approach | None]:
    """Rod, knife and wall margins of a path round the hole of a pipe, and how near the rod comes."""
    tool, axis, clearance = task.tool, work.axes[0], task.clearance
    rod: Approach | None
    if work.inner and np.allclose(axis, part.drill_axis):
        room = reach.rod_wall_clearance(path, part, tool)
        rod = Approach(room, room, np.full(3, np.nan), -1)
        code, meaning = reach.ROD_WALL, "the rod must clear the wall of the hole"
    else:
        rod = proof.rod_of(
            work.shape, path.centre, axis, tool, wanted, closed=path.frames.closed, seen=np.inf
        )  # fmt: skip
        code, meaning = reach.ROD_PART, "the rod must clear the part"
    found = [reach.knife_margin_of(path, tool, axis), reach.leg_margin(path, part, inner=work.inner)]
    if rod is not None:
        found.insert(0, reach.Margin(code, rod.value - clearance, False, meaning))
    return found, rod


def needed_tilt(
    task: ChamferTask, work: EdgeWork, part: PipeHole, path_at: Callable[[float], ChamferPath]
) -> float | None:
    """The smallest tilt that meets rod and knife on a pipe; None if there is none."""

    def shortest(cut: Chamfer) -> float:
        margins, _ = pipe_margins(task, work, part, path_at(cut.tilt), proof.CLOSE)
        return min(m.value for m in margins if m.code != reach.WALL)

    return reach.least_tilt(task.cut, shortest, float(work.nodes.wedge.max()))


class Candidate(NamedTuple):
    """A path over a piece of a CAD edge, with what is known of it whatever the tool axis."""

    dense: ChamferPath  # at all samples of the edge
    kept: ChamferPath  # at the points of the path
    at: EdgeFrames  # between them
    found: SweptChamfer
    gouge: Approach
    faded: dict[int, str]  # samples where the wedge is too blunt for the width, and why that is said


def candidate(
    task: ChamferTask, work: EdgeWork, dense: ChamferPath, members: Sequence[proof.EdgeZone], *,
    enough: float = math.inf,
) -> Candidate:  # fmt: skip
    """The points of a path, what the sweep of it leaves, and how deep it cuts elsewhere.

    ``enough``: a cut that is deeper than this has failed, and it does not matter by how much [m].

    Raises
    ------
    NoPathError
        The piece is too short.
    """
    keep, closed = _kept(task, work, dense), dense.frames.closed
    if len(keep) < (8 if closed else 3):
        raise NoPathError("a piece too short for a path")
    kept = _some(dense, keep)
    between = np.setdiff1d(np.arange(len(dense.centre)), keep)
    inside = between if closed else between[(between > 0) & (between < len(dense.centre) - 1)]
    if len(inside) > MEASURED:
        inside = inside[np.unique(np.linspace(0, len(inside) - 1, MEASURED).astype(int))]
    at = part_of(dense.frames, inside)
    found = swept(task, kept, at)
    gouge = proof.gouge_of(
        work.shape, kept, task.tool.ball_radius, members, work.number, float(found.beyond.max(initial=0.0)),
        enough=enough,
    )  # fmt: skip
    return Candidate(dense, kept, at, found, gouge, fading.faded(task, dense, keep, inside, found))


def plan_piece(task: ChamferTask, work: EdgeWork, one: Candidate, members: Sequence[proof.EdgeZone]) -> EdgePath:
    """The path over a piece of a CAD edge: the tool axis that suits, tilted if need be.

    Raises
    ------
    NoPathError
        The tilted piece is too short.
    """
    tool, cut = task.tool, task.cut
    tilt = task.tilt or 0.0
    axis, turn, margins = _best_axis(task, work, one.dense)
    if any(not m.met for m in margins) and task.tilt is None and not cut.leg:
        frames = turn(one.dense).frames

        def shortest(tried: Chamfer) -> float:
            path = chamfer_path(frames, tried, tool.ball_radius)
            return min(m.value for m in _cad_margins(task, work, path, axis)[0])

        needed = reach.least_tilt(cut, shortest, float(frames.wedge.max()), step=math.radians(5.0), exact=1e-5)
        if needed:
            needed = _sharper_tilt(task, work, frames, axis, cut, needed)
            tilt = needed
            tilted = chamfer_path(frames, cut._replace(tilt=tilt), tool.ball_radius)
            one, turn = candidate(task, work, tilted, members), _same
    path = turn(one.kept)
    margins, rod = _cad_margins(task, work, path, axis, proof.CLOSE)
    return finished(
        task, work, path, axis, tilt, one.at, one.found, one.gouge, rod, [*reach.tool_margins(tool), *margins],
        lambda other, exact: proof.rod_of(work.shape, other.centre, axis, tool, exact, closed=other.frames.closed),
    )  # fmt: skip


def _sharper_tilt(
    task: ChamferTask, work: EdgeWork, frames: EdgeFrames, axis: FloatArray, cut: Chamfer, rough: float
) -> float:
    """The tilt that is needed, from one found with a rough rod, with the margins that count in the end."""

    def shortest(tilt: float) -> float:
        path = chamfer_path(frames, cut._replace(tilt=max(0.0, tilt)), task.tool.ball_radius)
        return min(m.value for m in _cad_margins(task, work, path, axis, proof.EXACT)[0])

    low, high = max(0.0, rough - _NEAR_TILT), rough + _NEAR_TILT
    try:
        if shortest(low) >= 0.0 or shortest(high) < 0.0:
            return rough
        return float(optimize.brentq(shortest, low, high, xtol=1e-7)) + 2e-7
    except NoPathError:
        return rough


Turn = Callable[[ChamferPath], ChamferPath]


def _same(path: ChamferPath) -> ChamferPath:
    return path


def _best_axis(task: ChamferTask, work: EdgeWork, dense: ChamferPath) -> tuple[FloatArray, Turn, list[reach.Margin]]:
    """The first tool axis on which knife and rod clear, or the one that lacks least; how the path is run on it."""
    radius = task.tool.ball_radius
    best: tuple[float, FloatArray, Turn, list[reach.Margin]] | None = None
    for axis in _axes_for(task, work, dense):
        turn = towards(dense, axis)
        margins, _ = _cad_margins(task, work, turn(dense), axis, enough=-_HOPELESS * task.tool.rod_radius)
        worst = min(m.value / (1.0 if m.angle else radius) for m in margins)
        if best is None or worst > best[0]:
            best = (worst, axis, turn, margins)
        if all(m.met for m in margins):
            break
    assert best is not None
    return best[1:]


def _axes_for(task: ChamferTask, work: EdgeWork, dense: ChamferPath) -> list[FloatArray]:
    """Tool axes in the order in which to try them: that of a hole, from the side on which less rod sticks out, then
    those that look most into the edge.

    Axes along which the whole edge runs are left out, unless there are no others.
    """
    air = dense.frames.air.mean(axis=0)
    holes = 2 if work.foot is not None and len(work.axes) > 1 else 0
    others = sorted(work.axes[holes:], key=lambda axis: -round(float(axis @ air), 6))
    rod = task.tool.rod_radius
    hole = sorted(work.axes[:holes], key=lambda axis: round(proof.rod_reach(work.shape, dense.centre, axis, rod), 6))
    ordered = [*hole, *others]
    return [axis for axis in ordered if np.abs(dense.frames.tangent @ axis).min() < _PLUNGE] or ordered


def towards(path: ChamferPath, axis: FloatArray) -> Turn:
    """How to run a path so that the tool mills down, and with the face that stands along the rod second."""
    slopes = np.abs(path.frames.normal @ axis).mean(axis=0)
    swap = slopes[0] < slopes[1] - 1e-9
    local = pass_frames(path.frames.tangent, axis)
    down = float(np.einsum("ij,ij->i", local.off, path.frames.air).mean()) >= 0.0

    def turn(one: ChamferPath) -> ChamferPath:
        one = swapped_path(one) if swap else one
        return one if down else reversed_path(one)

    return turn


def _cad_margins(
    task: ChamferTask, work: EdgeWork, path: ChamferPath, axis: FloatArray, wanted: Wanted = proof.ROUGH, *,
    enough: float = -math.inf,
) -> tuple[list[reach.Margin], Approach | None]:  # fmt: skip
    """Knife and rod margins of a path along a CAD edge; the rod is not looked at where the knife does not cut."""
    tool = task.tool
    knife = reach.knife_margin_of(path, tool, axis)
    if not knife.met and knife.value < -math.radians(30.0):
        return [knife], None
    some = path
    if wanted == proof.ROUGH:
        few = np.unique(np.linspace(0, len(path.centre) - 1, _FEW).astype(int))
        some = _some(path, few)
    rod = proof.rod_of(work.shape, some.centre, axis, tool, wanted, closed=some.frames.closed, enough=enough)
    if rod is None:
        return [knife], None
    kept = task.clearance + work.shape.mesh.error
    if wanted != proof.ROUGH and rod.bound < kept <= rod.value:
        rod = proof.rod_of(work.shape, some.centre, axis, tool, proof.EXACT, closed=some.frames.closed) or rod
    return [knife, reach.Margin(reach.ROD_PART, rod.value - kept, False, "the rod must clear the part")], rod


def sharpened(paths: Sequence[EdgePath]) -> list[EdgePath]:
    """The paths with the rod clearance made exact where it is smallest."""
    found = list(paths)
    rods = [i for i, path in enumerate(found) if path.rod is not None]
    done: set[int] = set()
    while rods:
        nearest = min(rods, key=lambda i: found[i].rod.bound if i not in done else found[i].rod.value)  # type: ignore[union-attr]
        if nearest in done:
            break
        done.add(nearest)
        path = found[nearest]
        exact = path.rod_at(path.path, proof.EXACT)
        if exact is not None and path.rod is not None:
            found[nearest] = path._replace(rod=exact, margins=_with_rod(path.margins, exact.value - path.rod.value))
    return found


def _with_rod(margins: Sequence[reach.Margin], more: float) -> tuple[reach.Margin, ...]:
    """Margins with a rod that is farther away than was thought."""
    return tuple(m._replace(value=m.value + more) if m.code == reach.ROD_PART else m for m in margins)


def _some(path: ChamferPath, keep: NDArray[np.int64]) -> ChamferPath:
    return path_of(path, part_of(path.frames, keep)._replace(period=path.frames.period), keep)


def _kept(task: ChamferTask, work: EdgeWork, dense: ChamferPath) -> NDArray[np.int64]:
    """Samples that are the points of a path: within the chord tolerance, or this piece's share of the points."""
    closed, total = dense.frames.closed, len(dense.centre)
    if task.chord_tolerance is not None:
        tolerance = fading.chord_tolerance(task, dense)
        first = feeds.samples_for(dense, tolerance)
        finer = (feeds.samples_for(dense, tolerance * 0.7**k) for k in range(1, _TRIES))
        tries = chain([first], finer)
        return next((k for k in tries if len(k) < 4 or feeds.chord_share(_some(dense, k), tolerance[k]) <= 1.0), first)
    points = round((task.points or 2) * total / len(work.nodes.point))
    wanted = np.linspace(0, total if closed else total - 1, max(2, points) + closed)
    return feeds.thinned(total, wanted[:-1] if closed else wanted, closed=closed)


def swept(
    task: ChamferTask, path: ChamferPath, at: EdgeFrames, *, further: float = 0.0
) -> SweptChamfer:  # fmt: skip
    """What the sweep of a path leaves of an edge, and what it cuts beside the chamfer.

    ``further``: how far the ball may be from where it was planned [m].
    """
    longest = float(path.leg.max())
    zone = proof.leg_zone(longest, task.cut.width)
    radius, closed = task.tool.ball_radius, path.frames.closed
    return swept_chamfer(at, path.centre, radius, 2.0 * (longest + further), closed=closed, zone=zone)


def finished(
    task: ChamferTask, work: EdgeWork, path: ChamferPath, axis: FloatArray, tilt: float, at: EdgeFrames,
    found: SweptChamfer, gouge: Approach, rod: Approach | None, margins: list[reach.Margin],
    rod_at: Callable[[ChamferPath, Wanted], Approach | None],
) -> EdgePath:  # fmt: skip
    """Everything else that follows from a path: feeds, the gouge as an inequality, sensitivity."""
    radius = task.tool.ball_radius
    room = proof.GOUGE_LIMIT + work.shape.mesh.error - max(0.0, gouge.value)
    margins = [*margins, reach.Margin(reach.GOUGE, room, False, "the ball must not cut beyond the chamfer")]
    up, down = (
        swept_chamfer(
            at, path.centre + s * _STEP_Z * axis, radius, 2.0 * float(path.leg.max()), closed=path.frames.closed
        ).width
        for s in (1.0, -1.0)
    )
    no_end = task.pipe is not None and abs(axis[1]) > 0.5  # a pipe has no length
    stick_out = math.nan if no_end else proof.rod_reach(work.shape, path.centre, axis, task.tool.rod_radius)
    return EdgePath(
        work, path, axis, pass_frames(path.frames.tangent, axis), tilt,
        feeds.contact_feeds(path, task.feed, at_contact=task.at_contact),
        at, found, gouge, rod, tuple(margins), feeds.chord_error(path), (up - down) / (2.0 * _STEP_Z), radius,
        rod_at, stick_out,
    )  # fmt: skip
