"""Sharp convex edges of a CAD part as chains with frames: what a chamfer path starts from."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.io.cad import CONVEX, SMOOTH_ANGLE, Edge, Topology
from cutwise.io.cad_faces import curve_points, face_normals, face_parameters
from cutwise.io.occ import occ
from cutwise.maths.edges import EdgeFrames, arc_lengths, edge_frames, lengths, swapped_sides
from cutwise.maths.nurbs import CHEBYSHEV, Splines, section_heights, spline_normals
from cutwise.maths.surfaces import CYLINDER, FREE_FORM, SECTION_TERMS

FloatArray = NDArray[np.float64]

_MEET = 2e-5  # [m] edge ends closer than this are one corner
_STRAIGHT_ON = math.cos(SMOOTH_ANGLE)  # a chain goes on where tangents agree this well
_COARSER = {"curved": 1.0, "free": 4.0, "straight": 5.0}  # spacing of samples by the kind of edge
_FEWEST, _MOST = 16, 1200


class EdgeChain(NamedTuple):
    """Sharp edges that follow one another smoothly."""

    number: int  # from 1, as the user counts
    edges: tuple[int, ...]
    closed: bool
    frames: EdgeFrames  # over the arc length [m]; the second surface is the hole's, if there is one
    holes: tuple[int, ...]  # numbers of the holes, from 1, whose wall the chain runs along
    where: str  # "outer": a hole meets the outside; "inner": it meets another hole; "" elsewhere
    sharp: NDArray[np.bool_]  # whether each sample is sharp, shape (n,)
    links: tuple[tuple[int, bool, int], ...] = ()  # of each edge: number, run forward, intervals between samples

    @property
    def middle(self) -> FloatArray:
        """Middle of the chain, of a closed one its centre of gravity [m], shape (3,)."""
        point = self.frames.point
        step = lengths(point, closed=self.closed)
        if self.closed:
            return np.asarray(0.5 * (step + np.roll(step, 1)) @ point / step.sum())
        way = np.concatenate([[0.0], np.cumsum(step)])
        return np.array([np.interp(0.5 * way[-1], way, column) for column in point.T])

    @property
    def length(self) -> float:
        """Length of the chain [m]."""
        return float(arc_lengths(self.frames.point, self.frames.tangent, closed=self.closed).sum())


class _Piece(NamedTuple):
    """One sampled edge in the direction of its curve."""

    edge: Edge
    at: FloatArray  # curve parameters, shape (n,)
    point: FloatArray
    tangent: FloatArray
    normal: FloatArray  # shape (n, 2, 3)


def sharp_chains(
    model: Topology, *, reach: float = 1.5e-3, spacing: float = 1e-4, done: Callable[[float], object] | None = None
) -> tuple[EdgeChain, ...]:
    """All convex sharp edges of a part, chained by position and tangent across seams and splits.

    Parameters
    ----------
    model : Topology
        The part.
    reach : float
        How far from the edge the sections of free-form surfaces must hold [m].
    spacing : float
        Distance of samples on curved edges [m]; straight and free-form ones are sampled more thinly.
    done : callable, optional
        Is told the share that is done, after every edge.
    """
    convex = [edge for edge in model.edges if edge.kind == CONVEX]
    owner, pieces, chains = _owners(model), [], []
    for edge in convex:
        pieces.append(_piece(model, edge, _intervals(model, edge, spacing)))
        if done is not None:
            done(0.5 * len(pieces) / len(convex))
    linked = _linked(pieces)
    for number, links in enumerate(linked, start=1):
        chains.append(_chain(model, owner, number, pieces, links, reach))
        if done is not None:
            done(0.5 + 0.5 * number / len(linked))
    return tuple(chains)


def finer_chain(model: Topology, chain: EdgeChain, share: float, *, reach: float) -> EdgeChain:
    """The same chain with more samples, by a share; see :func:`sharp_chains`."""
    pieces = [_piece(model, model.edges[i], math.ceil(share * count)) for i, _, count in chain.links]
    return _chain(
        model,
        _owners(model),
        chain.number,
        pieces,
        [(k, forward) for k, (_, forward, _) in enumerate(chain.links)],
        reach,
    )


def _intervals(model: Topology, edge: Edge, spacing: float) -> int:
    """Intervals into which an edge is divided by its samples."""
    rough, _ = curve_points(edge.shape, np.linspace(*edge.span, 9))
    types = occ("GeomAbs").GeomAbs_CurveType
    straight = occ("BRepAdaptor").BRepAdaptor_Curve(edge.shape).GetType() == types.GeomAbs_Line
    free = any(model.faces[i].kind == FREE_FORM for i in edge.faces)
    spacing *= _COARSER["free" if free else "straight" if straight else "curved"]
    return int(np.clip(lengths(rough, closed=False).sum() / spacing, _FEWEST, _MOST))


def _piece(model: Topology, edge: Edge, intervals: int) -> _Piece:
    """Samples of an edge; its points are moved to where both faces really are."""
    first, last = edge.span
    faces = [model.faces[i] for i in edge.faces]
    count = intervals + 1
    at = np.linspace(first, last, count)
    point, slope = curve_points(edge.shape, at)
    normal = np.empty((count, 2, 3))
    for _ in range(4):
        gap = np.empty((count, 2))
        for m, face in enumerate(faces):
            gap[:, m], normal[:, m] = face_normals(face, model.surfaces, model.splines, edge.shape, point, at)
        cosine = np.einsum("ij,ij->i", normal[:, 0], normal[:, 1])
        sharp = 1.0 - cosine**2 > math.sin(SMOOTH_ANGLE) ** 2
        spread = np.where(sharp, 1.0 - cosine**2, 1.0)
        move1 = (gap[:, 0] - cosine * gap[:, 1]) / spread
        move2 = (gap[:, 1] - cosine * gap[:, 0]) / spread
        step = np.where(sharp[:, None], move1[:, None] * normal[:, 0] + move2[:, None] * normal[:, 1], 0.0)
        point = point - step
        if np.abs(step).max() < 1e-13:
            break
    across = np.cross(normal[:, 0], normal[:, 1])
    size = np.linalg.norm(across, axis=1)
    forward = np.where(np.einsum("ij,ij->i", across, slope) < 0.0, -1.0, 1.0)
    length = np.linalg.norm(slope, axis=1)
    from_curve = slope / np.where(length > 0.0, length, 1.0)[:, None]
    exact = (forward / np.where(size > 0.0, size, 1.0))[:, None] * across
    return _Piece(edge, at, point, np.where((size > math.sin(SMOOTH_ANGLE))[:, None], exact, from_curve), normal)


def _linked(pieces: Sequence[_Piece]) -> list[list[tuple[int, bool]]]:
    """Chains of (piece, forward): each end goes on with the best aligned free end at its place."""
    count = len(pieces)
    ends = np.array([[p.point[0], p.point[-1]] for p in pieces]).reshape(-1, 3)
    outward = np.array([[-p.tangent[0], p.tangent[-1]] for p in pieces]).reshape(-1, 3)
    partner = np.full(2 * count, -1)
    pairs = []
    for i in range(2 * count):
        near = np.flatnonzero(np.linalg.norm(ends[i + 1 :] - ends[i], axis=1) < _MEET) + i + 1
        pairs += [(-float(outward[i] @ outward[j]), i, int(j)) for j in near]
    for alignment, i, j in sorted(pairs, reverse=True):
        if alignment >= _STRAIGHT_ON and partner[i] < 0 and partner[j] < 0:
            partner[i], partner[j] = j, i
    used = np.zeros(count, bool)
    chains = []
    for start in [e for e in range(2 * count) if partner[e] < 0] + list(range(0, 2 * count, 2)):
        if used[start // 2]:
            continue
        links = []
        end = start  # the end at which the next piece is entered
        while end >= 0 and not used[end // 2]:
            used[end // 2] = True
            links.append((end // 2, end % 2 == 0))
            end = int(partner[end ^ 1])
        chains.append(links)
    return chains


def _owners(model: Topology) -> dict[int, int]:
    """The hole that a wall face belongs to, counted from 1."""
    return {face: n for n, hole in enumerate(model.holes, start=1) for face in hole.faces}


def _chain(
    model: Topology, owner: Mapping[int, int], number: int, pieces: Sequence[_Piece],
    links: Sequence[tuple[int, bool]], reach: float,
) -> EdgeChain:  # fmt: skip
    first, last = links[0], links[-1]
    start = pieces[first[0]].point[0 if first[1] else -1]
    end = pieces[last[0]].point[-1 if last[1] else 0]
    closed = bool(np.linalg.norm(start - end) < _MEET) and (len(links) > 1 or _returns(pieces[first[0]]))
    columns: dict[str, list[FloatArray]] = {"point": [], "tangent": [], "normal": [], "face": [], "section": []}
    for place, (index, forward) in enumerate(links):
        piece = pieces[index]
        step = slice(None) if forward else slice(None, None, -1)
        keep = slice(0, None if place == len(links) - 1 and not closed else -1)
        tangent = (piece.tangent if forward else -piece.tangent)[step][keep]
        normal = piece.normal[step][keep]
        face = np.tile(np.array(piece.edge.faces), (len(tangent), 1))
        right = np.einsum("ij,ij->i", np.cross(normal[:, 0], normal[:, 1]), tangent).sum() < 0.0
        if right:  # the first surface is always the one on the same side of the direction of travel
            normal, face = normal[:, ::-1], face[:, ::-1]
        columns["point"].append(piece.point[step][keep])
        columns["tangent"].append(tangent)
        columns["normal"].append(normal)
        columns["face"].append(face)
        columns["section"].append(_sections(model, piece, reach)[step][keep][:, :: -1 if right else 1])
    parts = {name: np.concatenate(values) for name, values in columns.items()}
    step_lengths = lengths(parts["point"], closed=closed)
    at = np.concatenate([[0.0], np.cumsum(step_lengths)])
    frames = edge_frames(
        at[:-1] if closed else at, parts["point"], parts["tangent"], np.ascontiguousarray(parts["normal"]),
        surfaces=model.surfaces, face=parts["face"],  # type: ignore[arg-type]
        period=at[-1] if closed else 0.0,
        section=np.ascontiguousarray(parts["section"]),
    )  # fmt: skip
    frames, holes, where = _at_holes(model, owner, frames)
    edges = tuple(pieces[i].edge.index for i, _ in links)
    runs = tuple((pieces[i].edge.index, forward, len(pieces[i].at) - 1) for i, forward in links)
    return EdgeChain(number, edges, closed, frames, holes, where, frames.wedge < math.pi - SMOOTH_ANGLE, runs)


def _returns(piece: _Piece) -> bool:
    return bool(piece.tangent[0] @ piece.tangent[-1] > _STRAIGHT_ON)


def _at_holes(model: Topology, owner: Mapping[int, int], frames: EdgeFrames) -> tuple[EdgeFrames, tuple[int, ...], str]:
    """Put the wall of a hole second, and say which holes the chain belongs to and on which side of the part it is."""
    sides = [{owner[int(f)] for f in np.unique(frames.face[:, m]) if int(f) in owner} for m in range(2)]
    bore = [
        any(
            int(f) in owner or (model.faces[int(f)].kind == CYLINDER and model.faces[int(f)].sign < 0.0)
            for f in np.unique(frames.face[:, m])
        )
        for m in range(2)
    ]
    sizes = [min((model.holes[n - 1].radius for n in side), default=math.inf) for side in sides]
    if sizes[0] < sizes[1]:
        frames = swapped_sides(frames)
    holes = tuple(sorted(sides[0] | sides[1]))
    return frames, holes, ("inner" if all(bore) else "outer") if holes else ""


def _sections(model: Topology, piece: _Piece, reach: float) -> FloatArray:
    """Section polynomials at the samples of an edge; zero for elementary surfaces. Shape (n, 2, 8)."""
    found = np.zeros((len(piece.at), 2, SECTION_TERMS))
    for m in range(2):
        face = model.faces[piece.edge.faces[m]]
        if face.kind != FREE_FORM:
            continue
        along = np.cross(piece.normal[:, m], piece.tangent)
        along *= -np.sign(np.einsum("ij,ij->i", along, piece.normal[:, 1 - m]))[:, None]
        start = face_parameters(face, piece.edge.shape, piece.at)
        gap, normal = np.empty(len(start)), np.empty((len(start), 3))
        spline_normals(model.splines, face.spline, face.sign, piece.point, start, gap, normal)
        found[:, m, 2:] = _polynomials(model.splines, face.spline, start, piece.point, along, piece.normal[:, m], reach)
    return found


_POWERS = np.arange(2, SECTION_TERMS)
_FIT = np.linalg.inv(CHEBYSHEV[:, None] ** _POWERS)


def _polynomials(
    table: Splines, index: int, start: FloatArray, point: FloatArray, along: FloatArray, normal: FloatArray,
    reach: float,
) -> FloatArray:  # fmt: skip
    r"""Polynomials of sections of a free-form surface, :math:`S(u, v) = C + a\, u + g\, n`, through Chebyshev nodes."""
    height = section_heights(
        table, index, start, np.ascontiguousarray(point), np.ascontiguousarray(along), np.ascontiguousarray(normal),
        reach, CHEBYSHEV,
    )  # fmt: skip
    return np.asarray(height @ _FIT.T / reach**_POWERS)
