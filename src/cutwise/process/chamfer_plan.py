"""Planning the path along one edge: tilt, trimming, tool axis, points, feed, margins; then the proof by sweep."""

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames, lengths, part_of, reversed_edge, swapped_sides
from cutwise.paths import feed as feeds
from cutwise.paths import reach
from cutwise.paths.chamfer import TIERS, Chamfer, ChamferPath, NoPathError, chamfer_path, possible
from cutwise.paths.pipe import PipeHole, one_turn
from cutwise.physics.engagement.ball import PassFrames, pass_frames
from cutwise.physics.surface import sweep
from cutwise.process.chamfer_work import MEASURED, EdgeWork, cutter
from cutwise.spec.chamfer import ChamferScenario

GOUGE_LIMIT = 2e-6  # [m]
_AXIS_SAMPLES = 24  # of a path, for the choice of the tool axis
_SHORTEST = 4  # samples of a path worth having
_ROD_LENGTH = 0.06  # [m] of the rod above the ball that is looked at
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
    found: sweep.SweptChamfer  # what the sweep left there
    gouge: sweep.Gouge
    rod: float | None  # [m] clearance; None: nothing beside the rod
    margins: tuple[reach.Margin, ...]
    chord_error: float  # [m]
    sensitivity: float  # width change per unit shift along the axis, where it is largest


class EdgePlan(NamedTuple):
    """All paths along one edge, or why there are none."""

    work: EdgeWork
    paths: tuple[EdgePath, ...]
    trimmed: float  # [m] of edge length given up
    remark: str  # why it was trimmed or refused; empty if not


def chamfer_of(scenario: ChamferScenario, tilt: float = 0.0) -> Chamfer:
    """The wanted chamfer as a record."""
    wanted = scenario.chamfer
    return Chamfer(wanted.width, wanted.definition == "leg", tilt, TIERS[wanted.tier])


def plan_pipe(scenario: ChamferScenario, work: EdgeWork, part: PipeHole) -> EdgePath:
    """The path round the hole of a pipe.

    Raises
    ------
    NoPathError
        No ball position leaves this chamfer.
    """
    tool, inner = cutter(scenario), scenario.part.edges == "inner"
    clearance, axis = scenario.chamfer.clearance, work.axes[0]
    assert work.frames_at is not None

    def margins(cut: Chamfer) -> list[reach.Margin]:
        path = chamfer_path(work.nodes, cut, tool.ball_radius)
        return reach.path_margins(path, part, tool, clearance, inner=inner)

    cut = chamfer_of(scenario)
    wanted = scenario.chamfer.tilt
    if wanted == "auto":
        tilt = 0.0 if cut.leg else _least_tilt(cut, margins, work.nodes)
    else:
        tilt = float(wanted)
    cut = cut._replace(tilt=tilt)
    fine = chamfer_path(work.nodes, cut, tool.ball_radius)
    count = scenario.path.points or feeds.points_for(fine, scenario.path.chord_tolerance or 2e-6)
    path = chamfer_path(work.frames_at(one_turn(count)), cut, tool.ball_radius, nodes=work.nodes)
    at = work.frames_at(2.0 * np.pi * (np.arange(MEASURED) + 0.37) / MEASURED)
    found = [*reach.tool_margins(tool)]
    if inner:
        found.append(reach.entry_margin(part, tool, clearance))
    found += reach.path_margins(path, part, tool, clearance, inner=inner)
    rod = reach.rod_wall_clearance(path, part, tool) if inner else None
    return _proven(scenario, work, path, axis, tilt, at, found, rod)


def _least_tilt(cut: Chamfer, margins: "object", nodes: EdgeFrames) -> float:
    """The smallest tilt that meets rod and knife; 0 if there is none, and the margins then tell why."""

    def shortest(tilted: Chamfer) -> float:
        return min(m.value for m in margins(tilted) if m.code in (reach.ROD_WALL, reach.KNIFE))  # type: ignore[operator]

    return reach.least_tilt(cut, shortest, float(nodes.wedge.max())) or 0.0


def plan_chain(scenario: ChamferScenario, work: EdgeWork) -> EdgePlan:
    """All paths along one edge of a CAD part: where both faces allow it, and where the ball gouges nothing."""
    tool = cutter(scenario)
    wanted = scenario.chamfer.tilt
    cut = chamfer_of(scenario, 0.0 if wanted == "auto" else float(wanted))
    whole = float(lengths(work.nodes.point, closed=work.nodes.closed).sum())
    reasons: dict[str, float] = {}
    paths = []
    kept = 0.0
    for frames in runs(work.nodes, possible(work.nodes, cut, tool.ball_radius)):
        try:
            dense = chamfer_path(frames, cut, tool.ball_radius)
        except NoPathError as fault:
            reasons[str(fault)] = 0.0
            continue
        clear = _clear_samples(work, dense, tool.ball_radius)
        if not clear.all():
            reasons["the ball would gouge a neighbouring face (corner, concave neighbour or too large a ball)"] = 0.0
        for part in runs(frames, clear):
            try:
                found = _plan_run(scenario, work, part, cut)
            except NoPathError as fault:
                reasons[str(fault)] = 0.0
                continue
            paths.append(found)
            kept += float(lengths(part.point, closed=part.closed).sum())
    if not possible(work.nodes, cut, tool.ball_radius).all():
        reasons.setdefault("the faces meet tangentially or end before the chamfer does", 0.0)
    trimmed = max(0.0, whole - kept)
    return EdgePlan(work, tuple(paths), trimmed, "; ".join(reasons) if trimmed > 1e-9 else "")


def runs(frames: EdgeFrames, good: FloatArray) -> list[EdgeFrames]:
    """The pieces of an edge over which a condition holds; the whole edge stays closed."""
    if good.all():
        return [frames]
    count = len(good)
    if frames.closed and good.any():  # begin the turn where it is cut open
        start = int(np.flatnonzero(~good)[0])
        order = (np.arange(count) + start) % count
        good = good[order]
        turned = frames.parameter[order] + np.where(np.arange(count) + start >= count, frames.period, 0.0)
        frames = part_of(frames, order)._replace(parameter=turned)  # type: ignore[arg-type]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [part_of(frames, slice(a, b)) for a, b in edges.reshape(-1, 2) if b - a >= _SHORTEST]


def _clear_samples(work: EdgeWork, path: ChamferPath, ball_radius: float) -> FloatArray:
    """At which samples of a path the ball cuts nothing beyond the chamfer; both ends of a gouging segment count."""
    clear = np.ones(len(path.centre), bool)
    near = _within(work, path.centre, ball_radius)
    if not len(near):
        return clear
    band = sweep.GOUGE_BAND * float(path.leg.max()) + sweep.GOUGE_MARGIN + work.cloud_error
    near = near[sweep.distances_to(_line(path.frames), near) > band]
    line = np.vstack([path.centre, path.centre[:1]]) if path.frames.closed else path.centre
    if not len(near):
        return clear
    deep = near[sweep.distances_to(line, near) < ball_radius - 0.5 * GOUGE_LIMIT - work.cloud_error]
    if len(deep):
        nearest = KDTree(path.centre).query(deep)[1]
        steps = nearest[:, None] + np.array([-1, 0, 1])
        clear[steps % len(clear) if path.frames.closed else np.clip(steps, 0, len(clear) - 1)] = False
    return clear


def _line(frames: EdgeFrames) -> FloatArray:
    return np.vstack([frames.point, frames.point[:1]]) if frames.closed else frames.point


def _plan_run(scenario: ChamferScenario, work: EdgeWork, frames: EdgeFrames, cut: Chamfer) -> EdgePath:
    """The path over a piece of an edge that the ball can follow: the tool axis that suits, tilted if need be."""
    tool = cutter(scenario)
    clearance = scenario.chamfer.clearance
    best: tuple[float, EdgeFrames, FloatArray, Chamfer, tuple[reach.Margin, ...], float | None] | None = None
    for axis in work.axes:
        try:
            oriented = towards(frames, axis)
            path = chamfer_path(oriented, cut, tool.ball_radius)
        except (NoPathError, ValueError):
            continue
        margins, rod = _cad_margins(work, path, axis, tool, clearance)
        worst = min(m.value / (1.0 if m.angle else tool.ball_radius) for m in margins)
        if best is None or worst > best[0]:
            best = (worst, oriented, axis, cut, margins, rod)
        if all(m.met for m in margins):
            break
    if best is None:
        raise NoPathError("the edge runs along every tool axis that was tried")
    _, oriented, axis, cut, margins, rod = best
    if not all(m.met for m in margins) and scenario.chamfer.tilt == "auto" and not cut.leg:
        tilt = reach.least_tilt(
            cut,
            lambda tilted: min(
                m.value
                for m in _cad_margins(work, chamfer_path(oriented, tilted, tool.ball_radius), axis, tool, clearance)[0]
            ),
            float(oriented.wedge.max()), step=math.radians(5.0),
        )  # fmt: skip
        if tilt:
            cut = cut._replace(tilt=tilt)
            margins, rod = _cad_margins(work, chamfer_path(oriented, cut, tool.ball_radius), axis, tool, clearance)
    dense = chamfer_path(oriented, cut, tool.ball_radius)
    keep = _kept(scenario, dense)
    if len(keep) < (8 if oriented.closed else 3):
        raise NoPathError("a piece too short for a path")
    kept = _at(dense, keep)
    between = np.setdiff1d(np.arange(len(dense.centre)), keep)
    inside = between if oriented.closed else between[(between > 0) & (between < len(dense.centre) - 1)]
    if len(inside) > 2 * MEASURED:
        inside = inside[np.unique(np.linspace(0, len(inside) - 1, 2 * MEASURED).astype(int))]
    at = part_of(oriented, inside)  # type: ignore[arg-type]
    return _proven(scenario, work, kept, axis, cut.tilt, at, [*reach.tool_margins(tool), *margins], rod)


def _kept(scenario: ChamferScenario, dense: ChamferPath) -> FloatArray:
    closed = dense.frames.closed
    if scenario.path.chord_tolerance is not None:
        return feeds.samples_for(dense, scenario.path.chord_tolerance)
    total = len(dense.centre)
    wanted = np.linspace(0, total if closed else total - 1, (scenario.path.points or 2) + closed)
    return feeds.thinned(total, wanted[:-1] if closed else wanted, closed=closed)


def _at(path: ChamferPath, keep: FloatArray) -> ChamferPath:
    frames = part_of(path.frames, keep)._replace(period=path.frames.period)  # type: ignore[arg-type]
    return ChamferPath(frames, *(np.ascontiguousarray(a[keep]) for a in path[1:]))


def towards(frames: EdgeFrames, axis: FloatArray) -> EdgeFrames:
    """The edge run so that the tool mills down, and with the face that stands along the rod second."""
    slopes = np.abs(frames.normal @ axis).mean(axis=0)
    if slopes[0] < slopes[1] - 1e-9:
        frames = swapped_sides(frames)
    local = pass_frames(frames.tangent, axis)
    down = float(np.einsum("ij,ij->i", local.off, frames.air).mean()) >= 0.0
    return frames if down else reversed_edge(frames)


def _cad_margins(
    work: EdgeWork, path: ChamferPath, axis: FloatArray, tool: reach.BallCutter, clearance: float
) -> tuple[tuple[reach.Margin, ...], float | None]:
    """Knife and rod margins of a path along a CAD edge; the rod is not looked at where the knife does not cut."""
    knife = reach.Margin(
        reach.KNIFE, reach.knife_margin(path, tool, axis), True, "the contact must lie on the knife, off neck and pole"
    )
    some = np.unique(np.linspace(0, len(path.centre) - 1, _AXIS_SAMPLES).astype(int))
    if not knife.met and knife.value < -math.radians(30.0):
        return (knife,), None
    middle = path.centre.mean(axis=0)
    extent = float(np.linalg.norm(path.centre - middle, axis=1).max()) + _ROD_LENGTH
    beside = np.asarray(work.thin.data)[work.thin.query_ball_point(middle, extent)]
    rod = sweep.rod_clearance(
        beside, path.centre[some], axis, tool.ball_radius, tool.rod_radius, rod_length=_ROD_LENGTH
    )
    if rod is None:
        return (knife,), None
    room = reach.Margin(reach.ROD_PART, rod - clearance - work.cloud_error, False, "the rod must clear the part")
    return (knife, room), rod


def _proven(
    scenario: ChamferScenario, work: EdgeWork, path: ChamferPath, axis: FloatArray, tilt: float, at: EdgeFrames,
    margins: list[reach.Margin], rod: float | None,
) -> EdgePath:  # fmt: skip
    """Everything that follows from a path: feeds, the chamfer left by the sweep, gouge, sensitivity."""
    operation, radius = scenario.operation, scenario.tool.ball_radius
    closed = path.frames.closed
    span = 2.0 * float(path.leg.max())
    found = sweep.swept_chamfer(at, path.centre, radius, span, closed=closed)
    gouge = sweep.gouge(
        _within(work, path.centre, radius), _line(work.nodes), path.centre, radius, float(path.leg.max()),
        closed=closed, band=sweep.GOUGE_MARGIN + work.cloud_error,
    )  # fmt: skip
    limit = GOUGE_LIMIT + work.cloud_error
    margins.append(
        reach.Margin(reach.GOUGE, limit - max(0.0, gouge.depth), False, "the ball must not cut beyond the chamfer")
    )
    up, down = (
        sweep.swept_chamfer(at, path.centre + s * _STEP_Z * axis, radius, span, closed=closed).width
        for s in (1.0, -1.0)
    )
    slope = (up - down) / (2.0 * _STEP_Z)
    slope = slope[np.isfinite(slope)]
    feed = operation.contact_feed or operation.centre_feed
    assert feed is not None  # checked by the specification
    return EdgePath(
        work, path, axis, pass_frames(path.frames.tangent, axis), tilt,
        feeds.contact_feeds(path, feed, at_contact=operation.contact_feed is not None),
        at, found, gouge, rod, tuple(margins), feeds.chord_error(path),
        float(slope[np.argmax(np.abs(slope))]) if slope.size else math.nan,
    )  # fmt: skip


def _within(work: EdgeWork, centre: FloatArray, radius: float) -> FloatArray:
    """The points on the part that the ball may reach."""
    gap = float(np.linalg.norm(np.diff(centre, axis=0), axis=1).max()) if len(centre) > 1 else 0.0
    skip = max(1, int(0.3 * radius / gap)) if gap > 0.0 else 1
    found = work.tree.query_ball_point(centre[::skip], 1.05 * radius + skip * gap)
    index = np.unique(np.concatenate([np.asarray(one, np.int64) for one in found]))
    return np.asarray(work.tree.data)[index]
