"""From what the engineer says to what the kernels read: specifications become records."""

import math

import numpy as np

from cutwise.maths.curves import Cubic, FloatArray, Polyline, constant, cubic_value_slope, no_cubic, smooth
from cutwise.maths.fields import random_field, sum_of_sines
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import KIENZLE, LINEAR, Edges, Kienzle
from cutwise.physics.motion.edge import EdgePass
from cutwise.physics.structure.pistons import (
    NO_FRICTION,
    PRESLIDING,
    REGULARISED,
    SET_VALUED,
    Piston,
    PistonRing,
    friction_at,
    piston_directions,
)
from cutwise.process.carried import GRAVITY, ArmAlong, arm_along, path_in_base, terms_of
from cutwise.process.loops import AVERAGED, TOOTH_RESOLVED, Arc, Cutter, EdgeCell, Layers, Strips, cell_of, loads_at
from cutwise.spec.carrier import Standing
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.material import KIENZLE as KIENZLE_KEYS
from cutwise.spec.material import LINEAR as LINEAR_KEYS
from cutwise.spec.material import Material
from cutwise.spec.operation import DeburringOperation, PathErrorSpectrum, SinePathError
from cutwise.spec.part import RandomField
from cutwise.spec.spindle import CompliantSpindle
from cutwise.spec.tables import Table
from cutwise.spec.tool import HelicalMill

_FRICTION = {"none": NO_FRICTION, "set_valued": SET_VALUED, "presliding": PRESLIDING, "regularised": REGULARISED}
_FORCE_LAW = {"linear": LINEAR, "kienzle": KIENZLE}
_FORCE = {"averaged": AVERAGED, "tooth_resolved": TOOTH_RESOLVED}
_SOLVER_TOLERANCE = 1e-6  # [N] of the piston forces: tighter costs hundreds of sweeps and changes nothing


def deburring_cell(scenario: DeburringScenario) -> EdgeCell:
    """Everything that takes part in a deburring pass, as bare SI records."""
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
    top = float(layers.burr_height.value.max())
    alone = EdgeCell(
        edge_pass(operation, top), layers, cutter, piston_ring(scenario.spindle), scenario.spindle.tool_reach
    )
    if scenario.path is not None and scenario.path.arc is not None:
        follow = scenario.path.orientation == "follow" or (
            scenario.robot is not None and scenario.path.orientation is None
        )
        alone = alone._replace(arc=Arc(scenario.path.arc.radius, follow))
    if scenario.robot is None:
        return alone
    along, height = robot_along(scenario, alone), surface_height(alone)
    sag = along.sag[:, 1] - along.sag[:, 3] * height
    path = alone.path._replace(error_curve=added(alone.path.error_curve, along.path.at, sag))
    return alone._replace(path=path, behind=terms_of(scenario.robot, along, height))


def added(curve: Cubic, at: FloatArray, value: FloatArray) -> Cubic:
    """A curve with the smooth one through some places [m] added, exact at the places of both."""
    if not np.any(value):
        return curve
    extra = smooth(at, value)
    inside = curve.at[(curve.at > at[0]) & (curve.at < at[-1])]
    places = np.unique(np.concatenate([at, inside]))
    total = [cubic_value_slope(curve, s)[0] + cubic_value_slope(extra, s)[0] for s in places]
    return smooth(places, np.array(total))


def surface_height(cell: EdgeCell) -> float:
    """Height over the tip at which the edge is read: the middle of the burr [m]."""
    return cell.layers.strips.burr_start + 0.5 * float(cell.layers.burr_width.value.mean())


def rigid_wrench(cell: EdgeCell) -> FloatArray:
    """Force and moment about the tip [N, N m] of a mill that stands at the nominal edge and does not yield, (6,)."""
    still = cell._replace(
        path=cell.path._replace(preset=0.0, lead_in=0.0, lead_out=0.0, error_amplitude=0.0, error_curve=no_cubic()),
        cutter=cell.cutter._replace(force_law=AVERAGED), behind=(),
    )  # fmt: skip
    load = loads_at(cell_of(still), np.zeros(1), np.zeros((1, 4)), cell.layers.strips.slices)[0]
    x, y, z = load[:3] + load[3:6]
    return np.array([x, y, -z, load[7] - cell.reach * y, cell.reach * x - load[6], 0.0])


def robot_along(scenario: DeburringScenario, cell: EdgeCell) -> ArmAlong:
    """The robot of a pass, along the path of the scenario."""
    assert scenario.path is not None
    assert scenario.robot is not None
    path = path_in_base(
        scenario.path, scenario.placement or Standing(), scenario.numerics.station,
        work_on_left=scenario.operation.milling == "up",
    )  # fmt: skip
    return arm_along(scenario.robot, path, rigid_wrench(cell), surface_height(cell), scenario.operation.feed)


def edge_profile(size: float | Table | RandomField, length: float) -> Polyline:
    """A size along the edge: constant, from a table, or a seeded random field cut off at zero."""
    if isinstance(size, Table):
        at, value = size.points()
        return Polyline(np.array(at), np.array(value))
    if isinstance(size, RandomField):
        at, value = random_field(length, size.mean, size.deviation, size.correlation_length, size.seed)
        return Polyline(at, np.maximum(0.0, value))
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
            (part.amplitude, part.wavelength if part.wavelength else operation.feed / part.frequency)
            for part in error.spectrum
        ]
        return sum_of_sines(operation.run_length, lines, error.seed)
    if isinstance(error, Table):
        at, value = error.points()
        scale = operation.feed if error.variable == "t" else 1.0
        return smooth(scale * np.array(at), np.array(value))
    return no_cubic()


def linear_coefficients(material: Material) -> EdgeCoefficients:
    """The straight-line law; an unknown axial pair counts as zero, and no axial force is reported then."""
    return EdgeCoefficients(*(getattr(material, key) or 0.0 for key in LINEAR_KEYS))


def edges(material: Material, tool: HelicalMill) -> Edges:
    """How the edges cut; an unknown axial pair counts as zero, and no axial force is reported then."""
    return edges_alike(material)._replace(runout=tool.runout, runout_angle=tool.runout_angle)


def edges_alike(material: Material) -> Edges:
    """The edges of a tool without run-out."""
    kienzle = Kienzle(*(getattr(material, key) or 0.0 for key in KIENZLE_KEYS))
    return Edges(_FORCE_LAW[material.law], linear_coefficients(material), kienzle, 0.0, 0.0)


def piston_ring(spindle: CompliantSpindle) -> PistonRing:
    """The compliance device at its pressure: piston force in proportion, seal friction with its preload share."""

    def friction(force: float) -> float:
        return friction_at(force, spindle.pressure, spindle.reference_pressure, spindle.friction_preload_fraction)

    moment = weight(spindle)
    return PistonRing(
        piston_directions(spindle.pistons, spindle.piston_azimuth),
        Piston(
            spindle.stroke,
            spindle.piston_force * spindle.pressure / spindle.reference_pressure,
            friction(spindle.friction_static),
            friction(spindle.friction_dynamic),
            _FRICTION[spindle.friction] if spindle.friction_static > 0.0 else NO_FRICTION,
            spindle.breakaway_travel or math.inf,
            spindle.stribeck_velocity or 0.0,
            spindle.seal_damping or 0.0,
        ),
        spindle.piston_arm,
        spindle.inertia,
        float(moment[0]),
        float(moment[1]),
        _SOLVER_TOLERANCE,
    )


def weight(spindle: CompliantSpindle) -> FloatArray:
    """Weight of the motor times the distance of its centre from the joint, along the direction of gravity [N m]."""
    if spindle.gravity == "off" or spindle.mass is None or spindle.centre_of_mass is None:
        return np.zeros(3)
    return spindle.mass * GRAVITY * spindle.centre_of_mass * np.array(spindle.gravity)
