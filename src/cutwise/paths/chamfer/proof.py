"""The proof of a path: what the sweep leaves, how deep it cuts elsewhere, how near the rod comes. On the true part."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.lines import thinned_line
from cutwise.maths.surface_mesh import SurfaceMesh, within
from cutwise.paths.chamfer.ball_path import ChamferPath
from cutwise.paths.chamfer.task import ROD_LENGTH, SECTION_REACH, EdgeWork, Shape
from cutwise.paths.reach import BallCutter
from cutwise.physics.surface.approach import (
    Approach,
    MovingTool,
    Wanted,
    deepest_cut,
    moving_ball,
    moving_rod,
    rod_distance,
)
from cutwise.physics.surface.overhead import height_above
from cutwise.physics.surface.sweep import ZONE_SHARE, ZONE_SLACK
from cutwise.physics.surface.zones import Zone, Zones, zones

GOUGE_LIMIT = 2e-6  # [m]
_NEAR = 3.0  # zone on the two faces of an edge that is looked at in its normal planes, in legs
_SEEN = 0.025  # [m] of rods along CAD parts: what is farther away than this is not looked at
_SAG = 3e-7  # [m] by which zones and paths are straightened where nothing finer is asked for
_LOOKED = 12  # places of a path, and directions at each, in which the reach of the rod is looked at
_RINGS = (1.0, 2.0, 5.0, 10.0)  # radii of the rings there, in rod radii
HINT = 1e-7  # [m] of a cut seen in the normal planes: then the faces are searched up to the chamfer
ROUGH = Wanted(5e-5, 0.25, exact=False)  # of rods while axes and tilts are tried
CLOSE = Wanted(5e-6, 0.1, exact=False)  # of the rod of each path in the end: the bound says what may remain
EXACT = Wanted(5e-6, 0.02)  # where it decides


class EdgeZone(NamedTuple):
    """An edge that is to be chamfered, as others see it: where it may be cut, with a box round that."""

    number: int
    zone: Zone
    low: FloatArray  # [m]
    high: FloatArray


def leg_zone(longest: float, width: float) -> tuple[float, float]:
    """Radius of the zone that belongs to a chamfer, and of the zone looked at in normal planes [m]."""
    radius = ZONE_SHARE * longest + ZONE_SLACK
    return radius, max(radius, min(_NEAR * longest, SECTION_REACH * width))


def edge_zone(work: EdgeWork, longest: float, width: float) -> EdgeZone:
    """The zone of an edge with a chamfer of some longest leg."""
    radius, near = leg_zone(longest, width)
    point, owners, closed = work.nodes.point, np.asarray(work.owners, np.int64), work.nodes.closed
    change = np.flatnonzero((np.diff(owners, axis=0) != 0).any(axis=1)) + 1  # where a face ends
    keep = np.unique(np.concatenate([thinned_line(point, _SAG), change]))
    zone = Zone(point[keep], owners[keep], closed, radius, near)
    return EdgeZone(work.number, zone, point.min(axis=0) - near, point.max(axis=0) + near)


def zones_near(members: Sequence[EdgeZone], own: int, centre: FloatArray, radius: float, *, near: bool = True) -> Zones:
    """The zones that a ball along some centres can reach; only its own edge has the wider zone on its faces."""
    low, high = centre.min(axis=0) - radius, centre.max(axis=0) + radius
    lows, highs = np.array([member.low for member in members]), np.array([member.high for member in members])
    meets = ((lows <= high) & (highs >= low)).all(axis=1)
    found = []
    for member, met in zip(members, meets, strict=True):
        mine = member.number == own
        if mine or met:
            found.append(member.zone if mine and near else member.zone._replace(near=member.zone.radius))
    return zones(found)


def reachable(shape: Shape, centre: FloatArray, radius: float) -> SurfaceMesh:
    """The mesh that a ball along some centres can reach."""
    return within(shape.mesh, shape.boxes, centre.min(axis=0) - radius, centre.max(axis=0) + radius)[0]


def swept_path(path: ChamferPath, radius: float) -> MovingTool:
    """The ball along a fine path, straightened a little."""
    loop = np.vstack([path.centre, path.centre[:1]]) if path.frames.closed else path.centre
    return moving_ball(loop[thinned_line(loop, _SAG)], radius, closed=False)


def gouge_of(
    shape: Shape, path: ChamferPath, radius: float, members: Sequence[EdgeZone], own: int, beyond: float, *,
    enough: float = np.inf,
) -> Approach:  # fmt: skip
    """Deepest cut of a path outside of all chamfers.

    ``beyond``: cut seen in the normal planes beside the chamfer [m]; if there is any, both faces of the edge are
    searched right up to the chamfer. ``enough``: a cut that is deeper than this ends the search [m].
    """
    closed = path.frames.closed
    mesh = reachable(shape, path.centre, radius)
    table = zones_near(members, own, path.centre, radius, near=beyond <= HINT)
    return deepest_cut(mesh, moving_ball(path.centre, radius, closed=closed), table, enough=enough)


def rod_reach(shape: Shape, centre: FloatArray, axis: FloatArray, rod_radius: float) -> float:
    """How high above the ball the part stands beside the rod, within ten rod radii: the rod that has to stick out [m].

    Looked for along rays on rings round some places of the path.
    """
    first = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = first - (first @ axis) * axis
    first /= np.linalg.norm(first)
    plane = np.column_stack([first, np.cross(axis, first)])
    some = centre[np.unique(np.linspace(0, len(centre) - 1, _LOOKED).astype(int))]
    turn = 2.0 * np.pi * np.arange(_LOOKED) / _LOOKED
    ring = np.concatenate(
        [[[0.0, 0.0]], *(r * rod_radius * np.column_stack([np.cos(turn), np.sin(turn)]) for r in _RINGS)]
    )
    corners = shape.mesh.corner.reshape(-1, 3, 3)
    return float(height_above(corners @ plane, corners @ axis, some @ plane, some @ axis, ring))


def rod_of(
    shape: Shape, centre: FloatArray, axis: FloatArray, tool: BallCutter, wanted: Wanted, *, closed: bool,
    seen: float = _SEEN, enough: float = -np.inf,
) -> Approach | None:  # fmt: skip
    """Smallest distance of the part from the surface of the rod along ball centres; None where nothing is beside it.

    ``seen``: parts farther away across the rod are not looked at [m]; ``enough``: a rod that is in the part by more
    than this has failed, and it does not matter by how much [m].
    """
    ends = np.vstack([centre, centre + ROD_LENGTH * axis])
    mesh, around = within(shape.mesh, shape.boxes, ends.min(axis=0) - seen, ends.max(axis=0) + seen)
    rod = moving_rod(centre, axis, tool.ball_radius, ROD_LENGTH, closed=closed)
    wanted = wanted._replace(limit=tool.rod_radius, enough=enough + tool.rod_radius)
    found = rod_distance(mesh, around, rod, wanted)
    if not np.isfinite(found.value):
        return None
    return found._replace(value=found.value - tool.rod_radius, bound=found.bound - tool.rod_radius)
