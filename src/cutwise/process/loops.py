"""A pass along an edge as a cell of the loop: its records, its run, its history."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise import loop
from cutwise.later import later
from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.flutes import ChipFlutes, MeanFlutes, ToothFlutes
from cutwise.physics.cutting.uneven import Edges
from cutwise.physics.cutting.wall import AVERAGED, FLUTES
from cutwise.physics.engagement.burred_arc import BurredArc
from cutwise.physics.engagement.burred_edge import PIECES, SEEN, BurredEdge, Layers, Round, Strips
from cutwise.physics.engagement.swept import ColumnEdge, most_columns, stand
from cutwise.physics.motion.arc_edge import ArcFixed, ArcFollowed
from cutwise.physics.motion.edge import EdgePass, programmed_motion
from cutwise.physics.motion.paced import Paced
from cutwise.physics.structure.pistons import PistonRing
from cutwise.physics.structure.pistons import at_rest as ring_at_rest
from cutwise.physics.structure.terms import Pistons, PistonsState
from cutwise.process.carriage import Carriage
from cutwise.process.passes import at_rest, on_path, stepped, structure_of, too_soft
from cutwise.records import CONTACT, Contact, EdgeHistory, Load, edge_history
from cutwise.results import SolverFailure
from cutwise.stages import cut, met, moved
from cutwise.still import Rest

if TYPE_CHECKING:
    from cutwise.process import following
else:
    following = later("cutwise.process.following")

__all__ = ["Layers", "Strips"]

TOOTH_RESOLVED = FLUTES
"""Tooth by tooth; else AVERAGED, both as milling with drives names them."""

_COLUMN = 10e-6  # [m] pitch of the columns


class Cutter(NamedTuple):
    """A turning mill in a material, and how its force is taken."""

    mill: Mill
    edges: Edges  # force law, coefficients and run-out
    spindle_speed: float  # [rad/s]
    up_milling: bool
    force_law: int  # AVERAGED or TOOTH_RESOLVED


class Arc(NamedTuple):
    """A convex edge of constant radius."""

    radius: float  # [m]
    follow: bool  # the tool turns with the edge; else it keeps its attitude


class EdgeCut(NamedTuple):
    """A mill along an edge, whatever holds it."""

    path: EdgePass
    layers: Layers
    cutter: Cutter
    arc: Arc | None = None  # the edge is an arc
    behind: tuple[tuple[str, NamedTuple], ...] = ()  # terms of the structure behind the spindle, by name
    paced: Paced | None = None  # instants and pace, where the feed is lowered; its motion is not looked at
    carriage: Carriage = Carriage()  # what carries the spindle, whose terms are among those behind it


class EdgeCell(NamedTuple):
    """Everything that takes part in a pass along an edge that is stepped."""

    path: EdgePass
    layers: Layers
    cutter: Cutter
    ring: PistonRing | None  # of a compliant spindle
    reach: float  # [m] from the joint to the tool tip; 0 for a rigid spindle
    arc: Arc | None = None  # the edge is an arc
    behind: tuple[tuple[str, NamedTuple], ...] = ()  # terms of the structure behind the spindle, by name
    paced: Paced | None = None  # instants and pace, where the feed is lowered; its motion is not looked at
    feeding: following.Feeding | None = None  # feed drives that follow the path
    carriage: Carriage = Carriage()


def round_tool(cutter: Cutter) -> Round:
    """The turning mill as the edge meets it."""
    return Round(cutter.mill.radius, cutter.mill.flutes, cutter.spindle_speed)


def cell_with(cell: EdgeCut | EdgeCell, structure: NamedTuple) -> loop.Cell:
    """The records of the loop, for a surface that need not be kept, with some structure."""
    cutter = cell.cutter
    law = ToothFlutes if cutter.force_law == TOOTH_RESOLVED else MeanFlutes
    motion: NamedTuple = cell.path
    engagement: NamedTuple = BurredEdge(cell.layers, round_tool(cutter))
    if cell.arc is not None:
        carried = ArcFollowed if cell.arc.follow else ArcFixed
        motion = carried(cell.path, cell.arc.radius, cutter.mill.radius)
        engagement = BurredArc(cell.layers, round_tool(cutter), cell.arc.radius, not cell.arc.follow)
    if cell.paced is not None:
        motion = cell.paced._replace(motion=motion)
    return loop.Cell(
        motion,
        engagement,
        (),
        law(cutter.mill, cutter.edges, cutter.spindle_speed, cutter.up_milling),
        structure,
    )


def cell_of(cell: EdgeCell) -> loop.Cell:
    """The records of the loop with the spindle, and what is behind it."""
    spindle = () if cell.ring is None else (("pistons", Pistons(cell.ring, cell.reach)),)
    return cell_with(cell, structure_of((*spindle, *cell.behind)))


def still_edge(cut: EdgeCut, structure: NamedTuple, at: FloatArray) -> Rest:
    """The mill at rest at places of the edge [m], where the lead-in has ended, with a structure that yields at once.

    Raises
    ------
    SolverFailure
        Force and displacement do not meet at a place.
    """
    path = cut.path._replace(lead_in=0.0, lead_out=0.0)
    averaged = cut.cutter._replace(force_law=AVERAGED)
    cell = cell_with(cut._replace(path=path, cutter=averaged), structure)
    poses = np.array([moved(cell.motion, time) for time in run_time(cut, at / path.feed).tolist()])
    return at_rest(
        cell, poses, lambda k: too_soft(on_path(at[k], "edge"), "reduce operation.preset or operation.feed"),
        seen=SEEN, layers=2, contacts=PIECES * cut.layers.strips.slices,
    )  # fmt: skip


def run_cell(
    cell: loop.Cell, of: EdgeCell, time_step: float, contacts: int,
    progress: Callable[[float], None] | None = None,
) -> EdgeHistory:  # fmt: skip
    """Time stepping of a pass along an edge, from rest."""
    duration, fed = float(run_time(of, np.array(of.path.duration))), None
    if of.feeding is not None:
        fed, time_step = of.feeding.stepped(cell.motion, time_step)
        cell, duration = cell._replace(motion=fed), of.feeding.duration
    history = stepped(
        cell, lambda row: SolverFailure(
            f"no finite state from {row[0]:.4g} s on: a structure is too soft for this cut; reduce operation.feed or "
            "part.burr.height, or take a smaller numerics.time_step"
        ), duration=duration, time_step=time_step, seen=SEEN, layers=2, contacts=contacts, progress=progress,
    )  # fmt: skip
    found = edge_history(history, None if of.ring is None else len(of.ring.direction))
    return found if fed is None else found._replace(fed=following.off_path(fed, found.motion.time))


def run_compliant_edge(
    cell: EdgeCell, time_step: float, progress: Callable[[float], None] | None = None
) -> EdgeHistory:
    """Time stepping of a whole pass (Berselli et al. 2016, Fig. 8)."""
    return run_cell(cell_of(cell), cell, time_step, PIECES * cell.layers.strips.slices, progress)


def programmed_time(cell: EdgeCell, history: EdgeHistory) -> FloatArray:
    """Time of the programmed motion [s]: another than that of the run where drives start from rest, or joints are slow."""
    stretched = cell.feeding is not None or cell.paced is not None
    return history.motion.position / cell.path.feed if stretched else history.motion.time


def run_time(cell: EdgeCut | EdgeCell, pace: FloatArray) -> FloatArray:
    """When a programmed motion is at times of its own [s]: later, where the feed is lowered."""
    return pace if cell.paced is None else np.interp(pace, cell.paced.pace, cell.paced.at)


def _yield(cell: EdgeCell) -> float:
    """Farthest that the tool tip can be pushed [m]."""
    return 0.0 if cell.ring is None else cell.ring.piston.stroke * cell.reach / cell.ring.arm


def columns_carry(cell: EdgeCell) -> bool:
    """Whether all that the mill can meet ends below its axis, as columns of height need."""
    top = float(cell.layers.burr_height.value.max())
    return max(0.0, top) + cell.path.preset < cell.cutter.mill.radius + _yield(cell)


def run_swept_edge(
    cell: EdgeCell, time_step: float, progress: Callable[[float], None] | None = None, column: float = _COLUMN
) -> EdgeHistory:
    """Time stepping of a whole pass over a surface with memory.

    Raises
    ------
    ValueError
        The mill is immersed beyond its axis, which columns cannot carry.
    """
    if cell.arc is not None:
        raise ValueError("a surface with memory is for straight edges")
    if not columns_carry(cell):
        raise ValueError("a swept surface needs the burr to end below the axis of the mill")
    burr, cutter, slices = cell.layers.burr_height, cell.cutter, cell.layers.strips.slices
    top = max(0.0, float(burr.value.max()))
    spread = cutter.mill.radius + _yield(cell)
    columns = stand(burr, -spread, cell.path.feed * cell.path.duration + spread, column, slices, slices)
    edges = cutter.edges
    engagement = ColumnEdge(
        cell.layers, round_tool(cutter), edges.runout, edges.runout_angle, cutter.up_milling, top, time_step
    )
    flutes = ChipFlutes(cutter.mill, edges, cutter.up_milling)
    kept = cell_of(cell)._replace(engagement=engagement, stock=columns, cutting=flutes)
    return run_cell(kept, cell, time_step, most_columns(cutter.mill.radius, columns), progress)


@compiled
def forces_at(cell, tilt, flexed, time, contact, load, out):  # type: ignore[no-untyped-def]
    """Loads for given tilts and rates (n, 4) of the motor at given times [s]; layers and moments into ``out`` (n, 8)."""
    motion, engagement, stock, cutting, structure = cell
    state = flexed.tilt
    for k in range(time.size):
        pose = moved(motion, time[k])
        state[:] = tilt[k]
        load.layer[:] = 0.0
        load.total[:] = 0.0
        count = met(engagement, stock, pose, structure, flexed, contact)
        cut(cutting, contact, count, time[k], structure.reach, load)
        out[k, :6] = load.layer.ravel()
        out[k, 6:] = load.total[4:]


def loads_at(cell: loop.Cell, time: FloatArray, tilt: FloatArray, slices: int) -> FloatArray:
    """Burr force, work force [N] and moment about the joint [N m] for given times and tilts, shape (n, 8)."""
    out = np.zeros((len(time), 8))
    spindle = cell.structure
    flexed = PistonsState(np.zeros(4), np.zeros(4), ring_at_rest(spindle.ring))
    contact = Contact(np.zeros((PIECES * slices, CONTACT)), np.zeros(SEEN))
    forces_at(cell, np.ascontiguousarray(tilt), flexed, time, contact, Load(np.zeros((2, 3)), np.zeros(6)), out)
    return out


def tooth_resolved_forces(cell: EdgeCell, time: FloatArray, tilt: FloatArray) -> FloatArray:
    """Forces tooth by tooth for given tilts and rates (n, 4) at given times [s]: burr x, y, z, work x, y, z; (n, 6).

    The tilt of an averaged run serves: tooth passing moves the tip by nanometres only.
    """
    resolved = cell._replace(cutter=cell.cutter._replace(force_law=TOOTH_RESOLVED), behind=())
    return loads_at(cell_of(resolved), time, tilt, cell.layers.strips.slices)[:, :6]


@compiled
def heights_over(path: EdgePass, time: FloatArray) -> FloatArray:
    """Height of the undeflected mill above the nominal edge over time [m]; one call of a kernel, not one a row."""
    height = np.empty(time.size)
    for k in range(time.size):
        height[k] = programmed_motion(path, time[k]).height
    return height


def programmed_heights(cell: EdgeCut | EdgeCell, time: FloatArray) -> FloatArray:
    """Height of the undeflected mill above the nominal edge over time [m]."""
    return heights_over(cell.path, np.ascontiguousarray(time))


def axis_over_edge(
    cell: EdgeCut | EdgeCell, time: FloatArray, moved_x: FloatArray, moved_y: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Where the deflected mill stands: place along the edge and height of its lowest point above it [m].

    ``moved_x``, ``moved_y``: displacement in process axes [m], shape (n,).
    """
    position, height = cell.path.feed * time, programmed_heights(cell, time)
    if cell.arc is None:
        return position + moved_x, height + moved_y
    radius, mill = cell.arc.radius, cell.cutter.mill.radius
    turn = position / radius
    distance = radius + mill + height
    if cell.arc.follow:
        x, y = moved_x, distance + moved_y
        angle = turn + np.arctan2(x, y)
    else:
        x, y = distance * np.sin(turn) + moved_x, distance * np.cos(turn) + moved_y
        angle = np.unwrap(np.arctan2(x, y))
    return radius * angle, np.hypot(x, y) - radius - mill
