"""Paths along the edges of a CAD part: where both faces allow a chamfer, and where the ball gouges nothing.

All selected edges are looked at together: what the ball takes off a neighbour that is chamfered too is no gouge, so
paths run up to the corners that they share. Where a path is trimmed, the reason is kept with the length.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames, arc_lengths, part_of
from cutwise.maths.surfaces import IntArray
from cutwise.paths import feed as feeds
from cutwise.paths.chamfer import fading, proof
from cutwise.paths.chamfer.ball_path import ChamferPath, NoPathError, chamfer_path, path_of, possible
from cutwise.paths.chamfer.plan import Candidate, EdgePath, candidate, plan_piece, sharpened
from cutwise.paths.chamfer.task import ChamferTask, EdgeWork
from cutwise.physics.surface.approach import cut_places

if TYPE_CHECKING:
    from scipy import spatial
else:
    spatial = later("scipy.spatial")

_SHORTEST = 4  # samples of a path worth having
_ROUNDS = 4  # of trimming where the ball cuts too much
_FADES = 8  # and where an edge fades
_PER_POINT = 3.0  # samples of an edge for each point of its path
_FINEST = 16.0  # more samples than at first, where a chord tolerance asks for them
_DRAFTED = 0.1  # share of the time that the drafts of all paths take
_SPACING = 0.1  # of gouges that are looked for, in ball radii

BENDS_AWAY = "the faces meet tangentially or end before the chamfer does"
TOO_SHORT = "the piece is too short for a path"


class Trim(NamedTuple):
    """A part of an edge that is left out."""

    start: float  # [m] along the edge
    end: float  # [m]; beyond the length of a closed edge where it runs past its start
    reason: str

    @property
    def length(self) -> float:
        """Length given up [m]."""
        return self.end - self.start


class EdgePlan(NamedTuple):
    """All paths along one edge, and what is left out."""

    work: EdgeWork
    paths: tuple[EdgePath, ...]
    trims: tuple[Trim, ...]

    @property
    def trimmed(self) -> float:
        """Length given up [m]."""
        return sum(trim.length for trim in self.trims)


class Draft(NamedTuple):
    """An edge with its path before anything is known about the rest of the part."""

    work: EdgeWork
    pieces: tuple[tuple[IntArray, ChamferPath], ...]  # samples of the edge, and the path over them
    reason: list[str]  # why a sample has no path; empty where it has one, shape (n,)


def runs(good: NDArray[np.bool_], *, closed: bool) -> list[IntArray]:
    """Samples of the pieces over which a condition holds, in their order; a closed edge may run past its start."""
    count = len(good)
    order = np.arange(count)
    if closed and not good.all() and good.any():
        order = np.roll(order, -int(np.flatnonzero(~good)[0]))
    held = good[order]
    ends = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    return [order[a:b] for a, b in ends.reshape(-1, 2)]


def piece_of(frames: EdgeFrames, samples: IntArray) -> EdgeFrames:
    """Some samples of an edge, in their order, as an open edge; all of them are the edge itself."""
    if len(samples) == len(frames.point) and samples[0] == 0:
        return frames
    turned = frames.parameter[samples] + np.where(samples < samples[0], frames.period, 0.0)
    return part_of(frames, samples)._replace(parameter=turned)


def draft(task: ChamferTask, work: EdgeWork) -> Draft:
    """Paths over all of an edge where its two faces allow the chamfer, on samples that are fine enough for its points."""
    found = _draft(task, work)
    if work.finer is None or not found.pieces:
        return found
    tolerance = task.chord_tolerance
    if tolerance is None:
        share = _PER_POINT * (task.points or 0) / len(work.nodes.point)
        return _draft(task, work.finer(share)) if share > 1.0 else found
    coarse = max(feeds.coarseness(path, fading.chord_tolerance(task, path)) for _, path in found.pieces)
    share = min(_FINEST, _PER_POINT * coarse)
    if share <= 1.0:
        return found
    fine = _draft(task, work.finer(share))
    left = max((feeds.coarseness(path, fading.chord_tolerance(task, path)) for _, path in fine.pieces), default=coarse)
    return fine if left < 0.7 * coarse else found  # a path that jumps is no smoother on more samples


def _draft(task: ChamferTask, work: EdgeWork) -> Draft:
    cut = task.cut._replace(tilt=task.tilt or 0.0)
    radius = task.tool.ball_radius
    good = possible(work.nodes, cut, radius)
    reason = ["" if fine else BENDS_AWAY for fine in good]
    shallow = fading.too_shallow(task, work.nodes)
    for run in runs(shallow, closed=work.nodes.closed):
        why = fading.shallow_reason(work.nodes, run)
        for i in run:
            reason[i] = why
    good = good & ~shallow
    pieces = []
    for samples in runs(good, closed=work.nodes.closed):
        why = TOO_SHORT
        if len(samples) >= _SHORTEST:
            try:
                pieces.append((samples, chamfer_path(piece_of(work.nodes, samples), cut, radius)))
                continue
            except NoPathError as fault:
                why = str(fault)
        for i in samples:
            reason[i] = why
    return Draft(work, tuple(pieces), reason)


class Surroundings:
    """What lies round an edge, to name what is in its way."""

    def __init__(
        self, names: Sequence[str], concave: Iterable[frozenset[int]], edges: Mapping[int, FloatArray]
    ) -> None:
        """``concave``: pairs of faces that meet in a concave corner; ``edges``: points of each sharp edge [m]."""
        self.names, self.concave = names, set(concave)
        self.number = np.concatenate([np.full(len(point), number) for number, point in edges.items()])
        self.tree = spatial.KDTree(np.vstack(list(edges.values())))
        self.selected: set[int] = set()

    def culprit(self, work: EdgeWork, point: FloatArray, face: int, reach: float) -> str:
        """Why a path stops short of a point that it would cut."""
        own = {int(f) for f in np.unique(work.owners)}
        others = sorted(self._edges_near(point, reach) - {work.number} - self.selected)
        if others:
            return f"corner with edge {others[0]}, which would be cut too: select it, or leave the corner as it is"
        if face in self.beside(work):
            return f"concave corner with {self.names[face]}"
        beside = sorted(self._edges_near(point, 4.0 * reach) - {work.number})
        if beside:
            return f"inner corner with edge {beside[0]}, into which the ball does not fit"
        if face in own:
            return f"the ball is too large: it would cut {self.names[face]} farther on as well"
        return f"the ball would cut {self.names[face]}"

    def beside(self, work: EdgeWork) -> set[int]:
        """Faces that meet one of the two faces of an edge in a concave corner."""
        own = {int(f) for f in np.unique(work.owners)}
        return {f for pair in self.concave if pair & own for f in pair - own}

    def _edges_near(self, point: FloatArray, reach: float) -> set[int]:
        return {int(self.number[i]) for i in self.tree.query_ball_point(point, reach)}


def plan_chains(
    task: ChamferTask, chosen: Sequence[EdgeWork], around: Surroundings, advance: Callable[[float], object]
) -> tuple[list[EdgePlan], list[proof.EdgeZone]]:
    """Plan all selected edges of a part together; with the zones in which the tool is meant to cut.

    ``advance`` is told the length of each edge that is done [m]: a part of it when it is drafted, before all others.
    """
    around.selected = {work.number for work in chosen}
    length = {work.number: float(edge_lengths(work.nodes).sum()) for work in chosen}
    drafts = []
    for work in chosen:
        drafts.append(draft(task, work))
        advance(_DRAFTED * length[work.number])
    width = task.cut.width
    members = [
        proof.edge_zone(d.work, max(float(path.leg.max()) for _, path in d.pieces), width) for d in drafts if d.pieces
    ]
    plans = []
    for d in drafts:
        plans.append(_plan(task, d, members, around))
        advance((1.0 - _DRAFTED) * length[d.work.number])
    lost = {plan.work.number for plan in plans if not plan.paths}
    if lost:  # what is not chamfered must not be cut by its neighbours
        around.selected -= lost
        gone = [m for m in members if m.number in lost]
        kept = [m for m in members if m.number not in lost]
        reach = task.tool.ball_radius
        for i, d in enumerate(drafts):
            if plans[i].paths and any(_touches(d, m, reach) for m in gone):
                plans[i] = _plan(task, d, kept, around)
        members = kept
    exact = iter(sharpened([path for plan in plans for path in plan.paths]))
    return [plan._replace(paths=tuple(next(exact) for _ in plan.paths)) for plan in plans], members


def edge_lengths(frames: EdgeFrames) -> FloatArray:
    """Lengths between the samples of an edge [m]."""
    return arc_lengths(frames.point, frames.tangent, closed=frames.closed)


def _touches(one: Draft, other: proof.EdgeZone, reach: float) -> bool:
    point = one.work.nodes.point
    return bool((other.low <= point.max(axis=0) + reach).all() and (other.high >= point.min(axis=0) - reach).all())


def _plan(task: ChamferTask, one: Draft, members: Sequence[proof.EdgeZone], around: Surroundings) -> EdgePlan:
    """The paths over the pieces of an edge that gouge nothing."""
    work, reason = one.work, list(one.reason)
    paths = []
    for samples, dense in one.pieces:
        good, why = _clean(task, work, dense, members, around)
        for i, text in why.items():
            reason[samples[i]] = text
        for part, found in good:
            try:
                path = plan_piece(task, work, found, members)
                text = "; ".join(map(str, path.failed))
                if not text:
                    paths.append(path)
            except NoPathError as fault:
                text = str(fault)
            if text:
                for i in part:
                    reason[samples[i]] = text
    return EdgePlan(work, tuple(paths), trims(work.nodes, reason))


def _clean(
    task: ChamferTask, work: EdgeWork, dense: ChamferPath, members: Sequence[proof.EdgeZone],
    around: Surroundings,
) -> tuple[list[tuple[IntArray, Candidate]], dict[int, str]]:  # fmt: skip
    """Pieces of a path that cut nothing but chamfers, as samples of it, and why other samples are left out.

    What is left after trimming is looked at again, since a shallow cut can hide behind a deep one.
    """
    waiting = [(np.arange(len(dense.centre)), 0, 0)]
    good: list[tuple[IntArray, Candidate]] = []
    why: dict[int, str] = {}
    while waiting:
        part, cuts, fades = waiting.pop(0)
        if cuts == _ROUNDS:
            why |= dict.fromkeys(part.tolist(), "the ball would cut the part beyond the chamfer")
            continue
        if len(part) < _SHORTEST:
            why |= dict.fromkeys(part.tolist(), TOO_SHORT)
            continue
        piece = path_of(dense, piece_of(dense.frames, part), part)
        try:
            found = candidate(task, work, piece, members, enough=proof.GOUGE_LIMIT + work.shape.mesh.error)
        except NoPathError as fault:
            why |= dict.fromkeys(part.tolist(), str(fault))
            continue
        if found.faded and fades < _FADES:
            bad, fades = found.faded, fades + 1
        elif found.gouge.value <= proof.GOUGE_LIMIT + work.shape.mesh.error:
            good.append((part, found))
            continue
        else:
            bad, cuts = _clear(task, work, piece, members, around, found), cuts + 1
        why |= {int(part[i]): text for i, text in bad.items()}
        fine = np.array([i not in bad for i in range(len(part))])
        waiting += [(part[kept], cuts, fades) for kept in runs(fine, closed=piece.frames.closed)]
    return good, why


def trims(frames: EdgeFrames, reason: Sequence[str]) -> tuple[Trim, ...]:
    """The parts of an edge without a path, each with its main reason; they end where the next path begins."""
    along = np.concatenate([[0.0], np.cumsum(arc_lengths(frames.point, frames.tangent, closed=frames.closed))])
    count, whole = len(reason), float(along[-1])
    bad = np.array([bool(why) for why in reason])
    found = []
    for run in runs(bad, closed=frames.closed):
        first, last = int(run[0]), int(run[-1])
        begin = along[first] if first == 0 and not frames.closed else along[first - 1]
        end = along[last + 1] if last + 1 < len(along) else along[last]
        if len(run) == count:
            begin, end = 0.0, whole
        elif first == 0 and frames.closed:
            begin -= whole
        said = [reason[i] for i in run]
        told = [why for why in said if why != TOO_SHORT] or said
        length = (end - begin) % whole or whole
        if length > 1e-9:
            found.append(Trim(float(begin), float(begin + length), max(dict.fromkeys(told), key=told.count)))
    return tuple(found)


def _clear(
    task: ChamferTask, work: EdgeWork, dense: ChamferPath, members: Sequence[proof.EdgeZone],
    around: Surroundings, seen: Candidate,
) -> dict[int, str]:  # fmt: skip
    """Samples of a path at which the ball cuts something else, with what that is; never none."""
    radius, limit = task.tool.ball_radius, 0.5 * proof.GOUGE_LIMIT + work.shape.mesh.error
    closed = dense.frames.closed
    mesh = proof.reachable(work.shape, dense.centre, radius)
    near = float(seen.found.beyond.max(initial=0.0)) <= proof.HINT
    table = proof.zones_near(members, work.number, dense.centre, radius, near=near)
    place, face = cut_places(mesh, proof.swept_path(dense, radius), table, limit, _SPACING * radius)
    if not len(place):  # too shallow for the spacing: the place that was found will do
        place, face = seen.gouge.place[None], np.array([seen.gouge.face])
    count = len(dense.centre)
    tree = spatial.KDTree(place)
    hit = tree.query_ball_point(dense.centre, radius - limit)
    walls = around.beside(work)
    order = np.argsort(~np.isin(face, list(walls)), kind="stable")  # a wall across a concave corner is the reason
    rank = np.argsort(order)
    found: dict[int, int] = {i: min(places, key=rank.__getitem__) for i, places in enumerate(hit) if places}
    nearest = spatial.KDTree(dense.centre).query(place)[1]
    for where, i in enumerate(nearest):
        for j in (i - 1, i, i + 1):
            if closed or 0 <= j < count:
                found.setdefault(int(j % count), where)
    leg = 1.5 * float(dense.leg.max())
    said: dict[int, str] = {}
    told: dict[tuple[int, int], str] = {}
    for i, where in found.items():
        key = (int(face[where]), int(where) // 50)
        if key not in told:
            told[key] = around.culprit(work, place[where], int(face[where]), leg)
        said[i] = told[key]
    return said
