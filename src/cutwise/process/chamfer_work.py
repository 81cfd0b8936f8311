"""Edges to be chamfered: from the part that the scenario names to frames, tool axes and surface points."""

import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from cutwise.io import cad, cad_cloud, cad_edges, cad_parts, step
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames
from cutwise.paths.pipe import PipeHole, one_turn, pipe_cloud, pipe_edge
from cutwise.paths.reach import BallCutter
from cutwise.spec.chamfer import Block, ChamferScenario

_NODES = 512  # of the analytic edge, from which the envelope interpolates
MEASURED = 73  # places at which a pipe edge is measured, off the path points
_FINE = 0.3  # spacing of the cloud near an edge, in ball radii
_AXES = {
    "+x": (1.0, 0.0, 0.0), "-x": (-1.0, 0.0, 0.0), "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0), "+z": (0.0, 0.0, 1.0), "-z": (0.0, 0.0, -1.0),
}  # fmt: skip


class EdgeWork(NamedTuple):
    """One edge, and what a path along it is planned with."""

    name: str
    number: int
    nodes: EdgeFrames  # dense samples
    frames_at: Callable[[FloatArray], EdgeFrames] | None  # the exact edge at any parameter; None: only the samples
    axes: tuple[FloatArray, ...]  # directions of the rod to choose from, the preferred one first
    tree: KDTree  # points on the part [m]
    thin: KDTree  # fewer of them, for the rod [m]
    cloud_error: float  # [m]
    foot: FloatArray | None  # [m] a point of the hole axis, if the edge is at a hole


def cutter(scenario: ChamferScenario) -> BallCutter:
    """The tool as a record."""
    tool = scenario.tool
    return BallCutter(tool.ball_radius, tool.rod_radius, tool.knife_limit_angle, tool.pole_limit_angle)


def pipe_hole(scenario: ChamferScenario) -> PipeHole | None:
    """The drilled pipe as a record."""
    pipe = scenario.part.pipe
    if pipe is None:
        return None
    return PipeHole(pipe.radius, pipe.wall, pipe.hole_radius, pipe.eccentricity, pipe.inclination)


def pipe_work(part: PipeHole, scenario: ChamferScenario) -> EdgeWork:
    """The edge of a drilled pipe.

    Raises
    ------
    NoEdgeError
        The edge does not close.
    """
    inner = scenario.part.edges == "inner"
    radius = scenario.tool.ball_radius
    nodes = pipe_edge(part, one_turn(_NODES), inner=inner)
    wanted = scenario.tool.axis
    axis = part.drill_axis if wanted == "auto" else np.array(_AXES[wanted])
    cloud = pipe_cloud(part, 2.5 * radius, max(0.1 * radius, part.radius / 400.0))
    return EdgeWork(
        f"{scenario.part.edges} edge", 1, nodes, lambda theta: pipe_edge(part, theta, inner=inner), (axis,),
        KDTree(cloud), KDTree(cloud), 0.0,
        np.array([part.eccentricity, 0.0, 0.0]),
    )  # fmt: skip


class CadWork(NamedTuple):
    """The edges of a CAD part."""

    model: cad.Topology
    chains: tuple[cad_edges.EdgeChain, ...]  # all of the part
    chosen: tuple[EdgeWork, ...]


def read_part(scenario: ChamferScenario) -> step.StepPart:
    """The CAD part of the scenario: its STEP file, or the block it describes, written as STEP and read back."""
    if scenario.part.step is not None:
        return step.read_step(scenario.part.step)
    assert scenario.part.block is not None  # checked by the specification
    with tempfile.TemporaryDirectory() as folder:
        return step.read_step(step.write_step(block_shape(scenario.part.block), Path(folder) / "block.step"))


def block_shape(block: Block) -> object:
    """The solid of a drilled block."""
    holes = [(hole.x, hole.y, hole.radius, hole.inclination) for hole in block.holes]
    return cad_parts.drilled_block(block.length, block.width, block.height, holes, block.bore_radius)


def cad_work(scenario: ChamferScenario) -> CadWork:
    """The selected edges of a CAD part.

    Raises
    ------
    CadFault
        The file cannot be used, or the selector finds nothing.
    """
    model = cad.topology(read_part(scenario))
    radius = scenario.tool.ball_radius
    tolerance = scenario.path.chord_tolerance or 2e-6
    spacing = float(np.clip(0.25 * math.sqrt(8.0 * tolerance * radius), 2e-5, 2e-4))
    chains = cad_edges.sharp_chains(model, reach=2.5 * scenario.chamfer.width, spacing=spacing)
    chosen = cad_edges.select(chains, scenario.part.edges)
    net = cad_cloud.mesh(model)
    near = np.vstack([chain.frames.point for chain in chosen])
    size = float(np.ptp(net.corner.reshape(-1, 3), axis=0).max())
    points = cad_cloud.cloud(model, net, near, 1.15 * radius, _FINE * radius, max(size / 80.0, radius))
    tree = KDTree(points.point)
    thin = KDTree(_spread(points.point, 0.5 * scenario.tool.rod_radius))
    works = [_chain_work(model, chain, tree, thin, points.error, scenario.tool.axis) for chain in chosen]
    return CadWork(model, chains, tuple(works))


def _spread(point: FloatArray, spacing: float) -> FloatArray:
    """One point of each cube of a grid."""
    cell = np.floor((point - point.min(axis=0)) / spacing).astype(np.int64)
    size = cell.max(axis=0) + 1
    return point[np.unique((cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2], return_index=True)[1]]


def _chain_work(
    model: cad.Topology, chain: cad_edges.EdgeChain, tree: KDTree, thin: KDTree, error: float, wanted: str
) -> EdgeWork:  # fmt: skip
    foot = None
    axes = [np.array(axis) for axis in _AXES.values()]
    if chain.holes:
        hole = min((model.holes[n - 1] for n in chain.holes), key=lambda hole: hole.radius)
        foot, along = np.array(hole.origin), np.array(hole.axis)
        axes = [along, -along, *(a for a in axes if abs(a @ along) < 1.0 - 1e-9)]
    if wanted != "auto":
        axes = [np.array(_AXES[wanted])]
    return EdgeWork(f"edge {chain.number}", chain.number, chain.frames, None, tuple(axes), tree, thin, error, foot)
