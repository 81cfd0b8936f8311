"""From what the engineer says to what the kernels read: specifications become records."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import Cubic, FloatArray, Polyline, constant, cubic_value_slope, no_cubic, smooth
from cutwise.maths.fields import random_field, sum_of_sines
from cutwise.paths.carried import CarriedPath
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.wall import AVERAGED
from cutwise.physics.motion.edge import EdgePass
from cutwise.physics.motion.paced import Paced
from cutwise.physics.structure.terms import Compliance, Rigid
from cutwise.process import carriage
from cutwise.process.edges import edges
from cutwise.process.loops import (
    TOOTH_RESOLVED,
    Arc,
    Cutter,
    EdgeCell,
    EdgeCut,
    Layers,
    Strips,
    still_edge,
)
from cutwise.process.passes import wrenches
from cutwise.process.spindles import piston_ring
from cutwise.spec.base import known
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.milling_machine import drives_key, drives_of
from cutwise.spec.operation import DeburringOperation, PathErrorSpectrum, SinePathError
from cutwise.spec.part import RandomField
from cutwise.spec.spindle import CompliantSpindle
from cutwise.spec.tables import Table

if TYPE_CHECKING:
    from cutwise.process import carried, following
    from cutwise.process.following import Feeding
else:
    following = later("cutwise.process.following")
    carried = later("cutwise.process.carried")

_FORCE = {"averaged": AVERAGED, "tooth_resolved": TOOTH_RESOLVED}
_NORMALS = 0.02  # [rad] between two normals of an arc at which the part is looked at


def deburring_cell(scenario: DeburringScenario) -> EdgeCell:
    """Everything that takes part in a deburring pass that is stepped, as bare SI records."""
    cut, spindle = edge_cut(scenario), scenario.spindle
    ring, reach = None, 0.0
    if isinstance(spindle, CompliantSpindle):
        axes = None if scenario.robot is None else path_of(scenario).axes[0]
        ring, reach = piston_ring(spindle, scenario.robot, axes), spindle.tool_reach
    return EdgeCell(
        cut.path,
        cut.layers,
        cut.cutter,
        ring,
        reach,
        cut.arc,
        cut.behind,
        cut.paced,
        feeding_of(scenario),
        cut.carriage,
    )


def feeding_of(scenario: DeburringScenario) -> Feeding | None:
    """The drives of the machine that follows the edge, from rest to rest; of an arc at the pace of a line as long."""
    drives = drives_of(scenario.machine)
    if drives is None:
        return None
    path = path_of(scenario)
    start, end = path.point[0], path.point[-1]
    if scenario.path is not None and scenario.path.arc is not None:
        end = start + path.at[-1] * path.axes[0, :, 0]
    share = min(1.0, scenario.operation.run_length / float(path.at[-1]))
    return following.along_a_line(
        drives, drives_key(scenario.machine), start, start + share * (end - start), scenario.operation.feed, path.axes[0],
        scenario.numerics.substeps,
    )  # fmt: skip


def edge_cut(scenario: DeburringScenario) -> EdgeCut:
    """The mill along the edge, with all that yields behind the spindle."""
    operation, part, tool = scenario.operation, scenario.part, scenario.tool
    length = operation.run_length
    layers = Layers(
        edge_profile(part.burr.height, length),
        edge_profile(part.burr.width, length),
        Strips(part.burr.axial_start, part.axial_start, part.contact_length, part.slices),
    )
    cutter = Cutter(
        Mill(0.5 * tool.diameter, tool.flutes, tool.helix),
        edges(scenario.material, tool),
        operation.spindle_speed,
        operation.milling == "up",
        _FORCE[scenario.numerics.force],
    )
    alone = EdgeCut(edge_pass(operation, float(layers.burr_height.value.max())), layers, cutter)
    if scenario.path is not None and scenario.path.arc is not None:
        alone = alone._replace(arc=Arc(scenario.path.arc.radius, scenario.follows))
    profile = operation.feed_profile
    if profile is not None:
        at, feeds = (np.array(values) for values in profile.points())
        alone = alone._replace(paced=Paced((), *carried.pace_of(at, feeds, operation.feed)))
    height, told = surface_height(alone), None if scenario.path is None else path_of(scenario)
    held = carriage.carrying(scenario, told, lambda: rigid_wrench(alone), height, operation.feed)
    alone = alone._replace(behind=carriage.in_series(tool, held, _part(scenario, alone)), carriage=held)
    if held.arm is None:
        return alone
    turn, moved = turned_from_start(alone, held.arm.path.at), carried.sag_at(held.arm, height)
    sag = np.sin(turn) * moved[:, 0] + np.cos(turn) * moved[:, 1]
    path = alone.path._replace(error_curve=added(alone.path.error_curve, held.arm.path.at, sag))
    if operation.limit_feed:
        alone = alone._replace(paced=Paced((), *carried.slowed(held.arm, known(scenario.robot), operation.feed)))
    return alone._replace(path=path)


def turned_from_start(cut: EdgeCut | EdgeCell, along: FloatArray) -> FloatArray:
    """How far the normal of the edge has turned away from y of the process axes, clockwise, at places of it [rad]."""
    if cut.arc is None or cut.arc.follow:
        return np.zeros(len(along))
    return np.asarray(along / cut.arc.radius)


def turned_by(turn: FloatArray, moved: FloatArray) -> FloatArray:
    """Displacements (n, 3) of process axes, seen from the normal of an edge that has turned away from y [rad], (n,)."""
    if not turn.any():
        return moved
    c, s = np.cos(turn), np.sin(turn)
    x, y, z = moved.T
    return np.column_stack([c * x - s * y, s * x + c * y, z])


def _part(scenario: DeburringScenario, cut: EdgeCut) -> Compliance | None:
    """The part as it yields off its edge, wherever its normal points."""
    if cut.arc is None or cut.arc.follow:
        return carriage.off_surface(scenario.part.stiffness)
    sweep = scenario.operation.run_length / cut.arc.radius
    turn = np.linspace(0.0, sweep, math.ceil(sweep / _NORMALS) + 1)
    normal = np.column_stack([np.sin(turn), np.cos(turn), np.zeros(len(turn))])
    return carriage.off_surface(scenario.part.stiffness, turn * cut.arc.radius, normal)


def added(curve: Cubic, at: FloatArray, value: FloatArray) -> Cubic:
    """A curve with the smooth one through some places [m] added, exact at the places of both."""
    if not np.any(value):
        return curve
    extra = smooth(at, value)
    inside = curve.at[(curve.at > at[0]) & (curve.at < at[-1])]
    places = np.unique(np.concatenate([at, inside]))
    total = [cubic_value_slope(curve, s)[0] + cubic_value_slope(extra, s)[0] for s in places]
    return smooth(places, np.array(total))


def surface_height(cell: EdgeCut | EdgeCell) -> float:
    """Height over the tip at which the edge is read: the middle of the burr [m]."""
    return cell.layers.strips.burr_start + 0.5 * float(cell.layers.burr_width.value.mean())


def rigid_wrench(cut: EdgeCut) -> FloatArray:
    """Force and moment about the tip [N, N m] of a mill that stands at the nominal edge and does not yield, (6,)."""
    path = cut.path._replace(preset=0.0, error_amplitude=0.0, error_curve=no_cubic())
    total = still_edge(cut._replace(path=path, arc=None), Rigid(0.0), np.zeros(1)).total[0]
    return np.asarray(wrenches(total[None])[0])


def path_of(scenario: DeburringScenario) -> CarriedPath:
    """The stations of the path in the frame of the carrier."""
    assert scenario.path is not None
    told = scenario.path
    if told.arc is not None and not scenario.follows:
        told = told.model_copy(update={"orientation": "fixed"})
    return carriage.stations_of(scenario, told)


def edge_profile(size: float | Table | RandomField, length: float) -> Polyline:
    """A size along the edge: constant, from a table, or a seeded random field cut off at zero."""
    if isinstance(size, Table):
        at, value = size.points()
        return Polyline(np.array(at), np.array(value))
    if isinstance(size, RandomField):
        place, drawn = random_field(length, size.mean, size.deviation, size.correlation_length, size.seed, size.curve)
        return Polyline(place, np.maximum(0.0, drawn))
    return constant(size)


def edge_pass(operation: DeburringOperation, burr_top: float) -> EdgePass:
    """The programmed pass; the lead-in starts at the clearance above the highest burr."""
    error = operation.path_error
    sine = error if isinstance(error, SinePathError) else None
    return EdgePass(
        operation.feed,
        operation.run_time,
        operation.lead_in_time,
        operation.lead_out_time,
        burr_top + operation.clearance,
        operation.preset,
        sine.amplitude if sine else 0.0,
        sine.frequency if sine else 0.0,
        path_error_curve(operation),
    )


def path_error_curve(operation: DeburringOperation) -> Cubic:
    """Path error over the programmed position, from a table or a spectrum; zero for none and for a sine."""
    error = operation.path_error
    if isinstance(error, PathErrorSpectrum):
        lines = [
            (part.amplitude, part.wavelength if part.wavelength else operation.feed / known(part.frequency))
            for part in error.spectrum
        ]
        return sum_of_sines(operation.run_length, lines, error.seed)
    if isinstance(error, Table):
        at, value = error.points()
        scale = operation.feed if error.variable == "t" else 1.0
        return smooth(scale * np.array(at), np.array(value))
    return no_cubic()
