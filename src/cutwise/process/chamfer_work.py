"""Edges to be chamfered: from the part that the scenario names to frames, tool axes and the mesh of the part."""

import math
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cutwise.io import cad, cad_edges, cad_mesh, cad_parts, cad_select, step
from cutwise.io.occ import CadFault
from cutwise.maths.curves import FloatArray
from cutwise.paths.chamfer.chains import Surroundings
from cutwise.paths.chamfer.task import ROD_LENGTH, SECTION_REACH, EdgeWork, Shape, shape_of
from cutwise.paths.pipe import NoEdgeError, PipeHole, one_turn, pipe_edge
from cutwise.paths.pipe_mesh import own_faces, pipe_mesh
from cutwise.process.pace import TOLD, Pace
from cutwise.spec.chamfer import Block, ChamferScenario
from cutwise.spec.faults import Fault, ScenarioFault

_NODES = 512  # of the analytic edge, from which the envelope interpolates
_LONG = 10.0  # [m] of edges from which on it is said how many there are, before anything else is done
_AXES = {
    "+z": (0.0, 0.0, 1.0), "-z": (0.0, 0.0, -1.0), "+x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0), "+y": (0.0, 1.0, 0.0), "-y": (0.0, -1.0, 0.0),
}  # fmt: skip


def pipe_work(part: PipeHole, scenario: ChamferScenario, *, inner: bool) -> EdgeWork:
    """One edge of a drilled pipe.

    Raises
    ------
    NoEdgeError
        The edge does not close.
    """
    nodes = pipe_edge(part, one_turn(_NODES), inner=inner)
    wanted = scenario.tool.axis
    axis = part.drill_axis if wanted == "auto" else np.array(_AXES[wanted])
    names = ("the outside of the pipe", "the bore of the pipe", "the wall of the hole") + 2 * ("the far side",)
    shape = shape_of(pipe_mesh(part, ROD_LENGTH + 3.0 * scenario.tool.ball_radius), names)
    return EdgeWork(
        "inner edge" if inner else "outer edge", 1 + inner, nodes, lambda theta: pipe_edge(part, theta, inner=inner), (axis,),
        np.tile(np.array(own_faces(inner=inner)), (_NODES, 1)), shape, np.array([part.eccentricity, 0.0, 0.0]),
        inner,
    )  # fmt: skip


class Outline(NamedTuple):
    """Lines of a part for pictures."""

    point: FloatArray  # [m], shape (k, 3)
    number: FloatArray  # of the line that a point belongs to, rising, shape (k,)


def outline_of(lines: Sequence[FloatArray]) -> Outline:
    """Several lines as one table."""
    return Outline(np.vstack(lines), np.concatenate([np.full(len(line), float(i)) for i, line in enumerate(lines)]))


def pipe_outline(part: PipeHole) -> Outline:
    """Both edges of the hole, and the half of the pipe that is drilled, cut off on both sides of the hole."""
    theta = np.linspace(0.0, 2.0 * np.pi, 97)
    lines = []
    for inner in (False, True):
        with suppress(NoEdgeError):
            lines.append(pipe_edge(part, theta, inner=inner).point)
    middle = part.radius * math.tan(part.inclination)
    half = 1.6 * part.hole_radius / math.cos(part.inclination) + part.wall
    psi = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 49)[:, None]
    ends = (middle - half, middle + half)
    for radius in (part.radius, part.radius - part.wall):
        ring = radius * np.hstack([np.sin(psi), np.zeros_like(psi), np.cos(psi)])
        lines += [ring + np.array([0.0, y, 0.0]) for y in ends]
    bore = part.radius - part.wall
    for x in (part.radius, -part.radius, bore, -bore):
        lines.append(np.array([[x, ends[0], 0.0], [x, ends[1], 0.0]]))
    for side in (-1.0, 1.0):
        lines += [np.array([[side * part.radius, y, 0.0], [side * bore, y, 0.0]]) for y in ends]
    return outline_of([*lines, *_generators(part, ends)])


def _generators(part: PipeHole, ends: tuple[float, float]) -> list[FloatArray]:
    """Lines on the outside of the pipe along it, broken by the hole."""
    foot, axis = np.array([part.eccentricity, 0.0, 0.0]), part.drill_axis
    y = np.linspace(*ends, 161)
    lines = []
    for psi in np.radians(np.arange(-75.0, 76.0, 15.0)):
        point = np.column_stack(np.broadcast_arrays(part.radius * math.sin(psi), y, part.radius * math.cos(psi)))
        arm = point - foot
        outside = np.linalg.norm(arm - (arm @ axis)[:, None] * axis, axis=1) >= part.hole_radius
        pieces = np.split(np.arange(len(y)), np.flatnonzero(np.diff(outside.astype(int))) + 1)
        lines += [point[piece] for piece in pieces if outside[piece[0]] and len(piece) > 1]
    return lines


class CadWork(NamedTuple):
    """The edges of a CAD part."""

    model: cad.Topology
    chains: tuple[cad_edges.EdgeChain, ...]  # all of the part
    chosen: tuple[EdgeWork, ...]
    outline: Outline | None
    notices: tuple[str, ...]  # on what was selected


def read_part(scenario: ChamferScenario) -> step.StepPart:
    """The CAD part of the scenario: its STEP file, or the block it describes, written as STEP and read back.

    Raises
    ------
    ScenarioFault
        The file cannot be used; the message says why.
    """
    if scenario.part.step is not None:
        try:
            return step.read_step(scenario.part.step)
        except CadFault as fault:
            raise ScenarioFault([Fault(("part", "step"), str(fault))]) from None
    assert scenario.part.block is not None  # checked by the specification
    with tempfile.TemporaryDirectory() as folder:
        return step.read_step(step.write_step(block_shape(scenario.part.block), Path(folder) / "block.step"))


def block_shape(block: Block) -> object:
    """The solid of a drilled block."""
    holes = [(hole.x, hole.y, hole.radius, hole.inclination) for hole in block.holes]
    return cad_parts.drilled_block(block.length, block.width, block.height, holes, block.bore_radius)


def cad_work(scenario: ChamferScenario, part: step.StepPart, *, outline: bool = False) -> CadWork:
    """The selected edges of a CAD part.

    Raises
    ------
    ScenarioFault
        The selector finds nothing, or cannot be read.
    CadFault
        A surface of the part cannot be used.
    """
    model = cad.topology(part)
    radius = scenario.tool.ball_radius
    tolerance = scenario.path.chord_tolerance or 2e-6
    spacing = float(np.clip(0.25 * math.sqrt(8.0 * tolerance * radius), 2e-5, 2e-4))
    chains = cad_edges.sharp_chains(model, reach=_section_reach(scenario), spacing=spacing)
    try:
        chosen = cad_select.select(chains, scenario.part.edges)
    except CadFault as fault:
        raise ScenarioFault([Fault(("part", "edges"), str(fault))]) from None
    length = sum(chain.length for chain in chosen)
    if length > _LONG:
        TOLD.info(
            "%s of %.1f m in all are to be planned on a part of %d faces; how long that takes is said when the first of "
            "them are done", cad_select.counted(len(chosen), "edge"), length, part.faces,
        )  # fmt: skip
    pace = Pace(1.0, "A part with fewer holes and edges takes less: the surfaces of all of it are looked at.")
    shape = shape_of(cad_mesh.cad_mesh(model, meshed=pace.advance), tuple(face.name for face in model.faces))
    works = tuple(_chain_work(scenario, model, chain, shape) for chain in chosen)
    said = cad_select.left_out(chains, scenario.part.edges, chosen)
    lines = outline_of(cad.edge_lines(model)) if outline else None
    return CadWork(model, chains, works, lines, (said,) if said else ())


def surroundings(found: CadWork) -> Surroundings:
    """What lies round the edges of a CAD part."""
    return Surroundings(
        tuple(face.name for face in found.model.faces),
        (frozenset(edge.faces) for edge in found.model.edges if edge.kind == cad.CONCAVE),
        {chain.number: chain.frames.point for chain in found.chains},
    )


def _section_reach(scenario: ChamferScenario) -> float:
    return SECTION_REACH * scenario.chamfer.width


def _chain_work(scenario: ChamferScenario, model: cad.Topology, chain: cad_edges.EdgeChain, shape: Shape) -> EdgeWork:
    foot, wanted = None, scenario.tool.axis
    axes = [np.array(axis) for axis in _AXES.values()]
    if chain.holes:
        hole = min((model.holes[n - 1] for n in chain.holes), key=lambda hole: hole.radius)
        foot, along = np.array(hole.origin), np.array(hole.axis)
        axes = [along, -along, *(a for a in axes if abs(a @ along) < 1.0 - 1e-9)]
    if wanted != "auto":
        axes = [np.array(_AXES[wanted])]
    return EdgeWork(
        f"edge {chain.number}", chain.number, chain.frames, None, tuple(axes), chain.frames.face, shape, foot,
        finer=lambda share: _chain_work(
            scenario, model, cad_edges.finer_chain(model, chain, share, reach=_section_reach(scenario)), shape
        ),
    )  # fmt: skip
