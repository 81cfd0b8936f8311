"""What is asked of a chamfer, and the edges that it is asked of: what every step of planning and proof reads."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames
from cutwise.maths.surface_mesh import Boxes, SurfaceMesh, boxes
from cutwise.paths.chamfer.ball_path import Chamfer
from cutwise.paths.pipe import PipeHole
from cutwise.paths.reach import BallCutter

ROD_LENGTH = 0.06  # [m] of the rod above the ball that is looked at
SECTION_REACH = 4.0  # how far sections of free-form faces hold, in chamfer widths


class ChamferTask(NamedTuple):
    """A chamfer and the tool that is to leave it."""

    cut: Chamfer  # without tilt
    tilt: float | None  # [rad] asked for; None: as much as tool and part make necessary
    width_tolerance: float  # [m] by which the width may be off
    tool: BallCutter
    clearance: float  # [m] that the rod keeps from the part
    points: int | None  # of a path; None: as many as the chord tolerance asks for
    chord_tolerance: float | None  # [m]
    retract: float  # [m] that the tool goes away from the part between paths
    feed: float  # [m/s]
    at_contact: bool  # the feed is that of the contact, not that of the centre of the ball
    pipe: PipeHole | None  # the part, where it is a drilled pipe


class Shape(NamedTuple):
    """What the tool must not cut or touch."""

    mesh: SurfaceMesh
    boxes: Boxes
    names: tuple[str, ...]  # of the faces, for messages
    top: float  # [m] a tool higher than this along any axis is clear of the part, from the origin


class EdgeWork(NamedTuple):
    """One edge, and what a path along it is planned with."""

    name: str
    number: int
    nodes: EdgeFrames  # dense samples
    frames_at: Callable[[FloatArray], EdgeFrames] | None  # the exact edge at any parameter; None: only the samples
    axes: tuple[FloatArray, ...]  # directions of the rod to choose from, the preferred one first
    owners: NDArray[np.int64]  # faces of the mesh on both sides of each sample, shape (n, 2)
    shape: Shape
    foot: FloatArray | None  # [m] a point of the hole axis, if the edge is at a hole
    inner: bool = False  # of a pipe: whether it is the edge at the bore
    finer: "Callable[[float], EdgeWork] | None" = None  # the same edge with more samples, by a share


def shape_of(mesh: SurfaceMesh, names: tuple[str, ...]) -> Shape:
    """A mesh with what is looked up in it again and again."""
    top = float(np.linalg.norm(mesh.corner.reshape(-1, 3), axis=1).max()) if len(mesh.face) else 0.0
    return Shape(mesh, boxes(mesh), names, top)
