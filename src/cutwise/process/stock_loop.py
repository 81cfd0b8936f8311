"""The loop over the moves of a program in a stock in 3D: contact and force at stations of a move, then its sweep."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, merged, stepping
from cutwise.maths.envelopes import LINE
from cutwise.maths.height_map import HeightMap
from cutwise.maths.map_levels import Room, room
from cutwise.maths.map_surface import surface_within
from cutwise.maths.map_sweep import cut_by, overlap_by
from cutwise.maths.profiles import Cutters
from cutwise.maths.solid import Solid
from cutwise.maths.workpiece import Workpiece
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.meridian import Chip, MeridianForce, meridian_force, peak_force, thickest_chip
from cutwise.physics.cutting.meridian_uneven import thickest_uneven_chip, uneven_meridian_force, uneven_peak_force
from cutwise.physics.cutting.uneven import Edges, even_and_linear
from cutwise.physics.engagement.contact_sums import angle_of_contact, removal
from cutwise.physics.engagement.map_contact import Edge, contact_rows
from cutwise.physics.engagement.map_fan import Fan, fan_room
from cutwise.physics.engagement.map_rim import Place
from cutwise.physics.engagement.map_turn import goes_on, turned_rows
from cutwise.process.loops_drives import STANDSTILL

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

STATION = (
    "share", "contact", "angle", "removal", "force_x", "force_y", "force_z", "torque", "end_force", "force_xy_peak",
    "chip_thickness", "over_centre", "push_x", "push_y", "push_z",
)  # fmt: skip
Progress = Callable[[float], None]

PIECES = 4096  # of contact at one place
_UPRIGHT = 1e-12
AHEAD = 1e-8  # [m] inside of a segment, its ends


def part_of(progress: Progress | None, low: float, high: float) -> Progress | None:
    """Progress of a part of the work, between two shares of all of it."""
    if progress is None:
        return None
    return lambda share: progress(low + share * (high - low))


class Teeth(NamedTuple):
    """A tool in a material."""

    edge: Edge
    mill: Mill  # radius, flutes and helix
    core: float  # radius inside which no edge of the bottom cuts [m]; negative where there is no bottom to speak of
    edges: Edges  # force law and run-out
    forces: bool  # whether coefficients and a spindle speed are known


class Run(NamedTuple):
    """A stretch of moves with one tool, and what is found of them."""

    start: FloatArray  # tip at the start of each segment [m], shape (n, 3)
    end: FloatArray
    way: FloatArray  # length of each segment [m], shape (n,)
    rapid: npt.NDArray[np.bool_]  # of each move
    feed: FloatArray  # [m/s]
    spindle: FloatArray  # [rad/s]
    speed: FloatArray  # at each station, as the machine plans it [m/s]: it sets what pushes the tool aside
    station: IntArray  # first station of each move, and their number at the end, shape (moves + 1,)
    found: FloatArray  # of each station, columns STATION
    segment: IntArray  # on which each station is
    taken: IntArray  # heights taken off by each move, units of 2**-40 m
    hit: FloatArray  # of each move: volume in cells [m], depth [m], place (3) of what shank and holder run into
    through: FloatArray  # the same of the cutter of rapid moves


@stepping
def place_on(solid: Solid, starts: FloatArray, ends: FloatArray, move: int, segment: int, share: float) -> Place:
    """Where the tool is on a segment; ``starts``, ``ends``: tip at both ends of all segments [m], shape (n, 3)."""
    row, start, end = solid.path.row[segment], starts[segment], ends[segment]
    first = solid.path.first[move]
    if row[0] != LINE:
        angle, side = row[13] + share * row[14], math.copysign(1.0, row[14])
        return Place(
            row[2] + row[7] * math.cos(angle), row[3] + row[7] * math.sin(angle), row[4],
            -side * math.sin(angle), side * math.cos(angle), 0.0, segment, first, share, move,
        )  # fmt: skip
    x, y = start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])
    z = start[2] + share * (end[2] - start[2])
    slope = row[8]
    if row[7] <= _UPRIGHT:
        slope = -math.inf if end[2] < start[2] else math.inf
    return Place(x, y, z, row[5], row[6], slope, segment, first, share, move)


@stepping
def _mean(rows: FloatArray, count: int, teeth: Teeth, chip: Chip) -> MeridianForce:
    """Mean force of rows of contact, in closed form where teeth are even and the law is linear."""
    mer = teeth.edge.meridian
    if even_and_linear(teeth.edges):
        return meridian_force(rows, count, mer, teeth.edge.radius, teeth.mill.flutes, chip, teeth.edges.linear)
    return uneven_meridian_force(rows, count, mer, teeth.mill, chip, teeth.edges)


@merged
def station_at(
    piece: Workpiece, teeth: Teeth, run: Run, move: int, place: Place, refine: bool, peak: bool, planned: float, fan: Fan,
    rows: FloatArray, out: FloatArray,
) -> int:  # fmt: skip
    """Contact and force at one place into a row of stations; ``planned``: the speed there by the machine [m/s].

    Returns the number of rows of contact.
    """
    count = contact_rows(piece, place, teeth.edge, fan, rows, refine)
    _station_of(piece, teeth, run, move, place, peak, planned, fan, rows, count, out)
    return count


@stepping
def _station_of(
    piece: Workpiece, teeth: Teeth, run: Run, move: int, place: Place, peak: bool, planned: float, fan: Fan,
    rows: FloatArray, count: int, out: FloatArray,
) -> None:  # fmt: skip
    """What rows of contact at a place come to, into a row of stations."""
    solid = piece.solid
    out[:] = 0.0
    out[0] = place.share
    level, climb = 1.0, 0.0
    if math.isinf(place.slope):
        level, climb = 0.0, math.copysign(1.0, place.slope)
    else:
        level = 1.0 / math.sqrt(1.0 + place.slope * place.slope)
        climb = place.slope * level
    out[1] = count
    speed = run.feed[move]
    if not math.isinf(place.slope):
        out[2] = angle_of_contact(rows, count, teeth.edge)
    out[3] = removal(rows, count, teeth.edge, place.slope) * (abs(climb) if level == 0.0 else level)
    if climb < 0.0 and teeth.core > 0.0:
        height, _ = surface_within(solid, move, place.x, place.y, fan.found)
        out[11] = 1.0 if height > place.z else 0.0
    if not teeth.forces or count == 0 or run.spindle[move] <= 0.0:
        return
    tooth = 2.0 * math.pi * speed / (run.spindle[move] * teeth.mill.flutes)
    chip = Chip(tooth * level, tooth * climb)
    mer = teeth.edge.meridian
    force = _mean(rows, count, teeth, chip)
    out[4], out[5], out[6], out[7], out[8] = force.x, force.y, force.z, force.torque, force.end
    if peak:
        if even_and_linear(teeth.edges):
            out[9] = peak_force(rows, count, mer, teeth.mill, chip, teeth.edges.linear)
        else:
            out[9] = uneven_peak_force(rows, count, mer, teeth.mill, chip, teeth.edges)
    out[10] = thickest_uneven_chip(thickest_chip(rows, count, mer, chip), teeth.edges.runout, teeth.mill.flutes)
    if planned <= STANDSTILL:
        return
    if planned != speed:  # the machine is slower there, and so is the chip
        slow = Chip(chip.across * planned / speed, chip.along * planned / speed)
        force = _mean(rows, count, teeth, slow)
    out[12], out[13], out[14] = force.x, force.y, force.z


@merged
def _stations(
    piece: Workpiece, teeth: Teeth, run: Run, move: int, refine: bool, fan: Fan, rows: FloatArray, other: FloatArray,
    met: int,
) -> int:  # fmt: skip
    """All stations of a move, evenly along it; how many rows of contact there are at its end.

    ``met``: how many rows there were at the end of the move before, -1 where nothing is known of it.
    """
    solid = piece.solid
    first, last = solid.path.first[move], solid.path.first[move + 1]
    begin, end = run.station[move], run.station[move + 1]
    if end == begin:
        return -1
    length = 0.0
    for segment in range(first, last):
        length += run.way[segment]
    segment, before = first, 0.0
    for n in range(begin, end):
        at = length * (n - begin) / max(end - begin - 1, 1)
        while segment < last - 1 and at > before + run.way[segment] * (1.0 + 1e-12):
            before += run.way[segment]
            segment += 1
        share = 1.0 if n == end - 1 else (at - before) / run.way[segment]
        inside = min(AHEAD / run.way[segment], 0.5)  # at its ends a rim may lie on what was swept before
        share = min(max(share, inside), 1.0 - inside)
        run.segment[n] = segment
        place = place_on(solid, run.start, run.end, move, segment, share)
        if n == begin and end - begin > 1 and met >= 0:
            ended = place_on(solid, run.start, run.end, move - 1, first - 1, 1.0)
            near = math.hypot(place.x - ended.x, place.y - ended.y) + abs(place.z - ended.z) < 2.0 * AHEAD
            if near and goes_on(teeth.edge, ended, place):
                met = turned_rows(rows, met, teeth.edge, ended, place, other)
                _station_of(piece, teeth, run, move, place, refine, run.speed[n], fan, other, met, run.found[n])
                continue
        met = station_at(piece, teeth, run, move, place, refine, refine, run.speed[n], fan, rows, run.found[n])
    return met


@stepping
def overlap_along(stock: HeightMap, solid: Solid, tools: Cutters, move: int, hit: FloatArray, work: Room) -> None:
    """What the pieces of a tool table overlap with material along a move."""
    for segment in range(solid.path.first[move], solid.path.first[move + 1]):
        overlap_by(stock, solid.path, tools, segment, hit, work)


@compiled
def run_moves(
    piece: Workpiece, shanks: Cutters, teeth: Teeth, run: Run, moves: tuple[int, int], look: bool, refine: bool
) -> None:
    """Run moves with one tool: stations, then what rapid moves hit, the sweep, and what shank and holder hit.

    Parameters
    ----------
    piece : Workpiece
        The stock, whose first map is cut.
    shanks : Cutters
        What is above the cutting edges of each tool; tools without have no pieces.
    teeth : Teeth
        The tool.
    run : Run
        Moves, and room for what is found.
    moves : tuple of int
        First move, and the one behind the last.
    look, refine : bool
        Whether stations are looked at, and how closely.
    """
    solid = piece.solid
    fan, rows, other, work = fan_room(), np.empty((PIECES, 5)), np.empty((PIECES, 5)), room(solid.map.layout)
    met = -1
    for move in range(moves[0], moves[1]):
        tool = int(solid.path.row[solid.path.first[move], 1])
        if look and not run.rapid[move]:
            met = _stations(piece, teeth, run, move, refine, fan, rows, other, met)
        else:
            met = -1
        if run.rapid[move]:
            overlap_along(solid.map, solid, solid.tools, move, run.through[move], work)
        run.taken[move] = cut_by(solid.map, solid.path, solid.tools, move, work)
        if shanks.first[tool + 1] > shanks.first[tool]:
            overlap_along(solid.map, solid, shanks, move, run.hit[move], work)


@compiled
def run_into(stock: HeightMap, solid: Solid, tools: Cutters, moves: tuple[int, int], hit: FloatArray) -> None:
    """What a table of tools overlaps with a solid that stays as it is, a fixture, move by move."""
    work = room(stock.layout)
    for move in range(moves[0], moves[1]):
        tool = int(solid.path.row[solid.path.first[move], 1])
        if tools.first[tool + 1] > tools.first[tool]:
            overlap_along(stock, solid, tools, move, hit[move], work)
