"""From a machine scenario to the bare records of a pass and of the working space."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cutwise.later import later
from cutwise.maths import chains
from cutwise.maths.chains import FIXED, PRISMATIC, REVOLUTE
from cutwise.maths.frames import FloatArray, rotation_from_rpy
from cutwise.paths.carried import across
from cutwise.physics.motion import geometry
from cutwise.physics.motion.geometry import AxisErrors, ErrorFunction
from cutwise.physics.motion.volumetric import Axes
from cutwise.physics.structure.beams import Section, block_section, box_section, cantilever, round_section
from cutwise.physics.structure.pads import ContactPads, pad_compliance
from cutwise.physics.surface import probability
from cutwise.process import machine_robot
from cutwise.process.machine_force import cut_force
from cutwise.process.machine_pass import ElasticElement, FlexiblePart, MachineCell, SpringPart, Weight
from cutwise.process.machine_path import ToolPath, points_tool_path, wall_normal
from cutwise.process.yielding import tip_of
from cutwise.spec.base import known
from cutwise.spec.carrier import CarryingRobot, Standing
from cutwise.spec.geometry_errors import COMPONENTS, LINEAR_AXES, SQUARENESS
from cutwise.spec.machine import Beam, ContactGroup, Drive, Joint, Machine
from cutwise.spec.machine import ElasticElement as ElementSpec
from cutwise.spec.machine_scenario import MachineScenario, MachineTool
from cutwise.spec.part_block import PartBlock, PartSpring
from cutwise.spec.tables import Table

if TYPE_CHECKING:
    from cutwise.process import machine_program
else:
    machine_program = later("cutwise.process.machine_program")

_PLUNGE = 1e-6  # sine of the angle between feed and tool axis
_KINDS = {"fixed": FIXED, "prismatic": PRISMATIC, "revolute": REVOLUTE}
_LAWS = {"normal": probability.NORMAL, "uniform": probability.UNIFORM, "triangular": probability.TRIANGULAR}


def machine_cell(scenario: MachineScenario, *, samples: int | None = None) -> MachineCell:
    """Everything that takes part in a pass; ``samples`` replaces the number of places along it.

    Raises
    ------
    ScenarioFault
        The program cannot be run on this machine, or its cut is not covered.
    """
    if scenario.robot is not None:
        return _robot_cell(scenario, scenario.robot, samples)
    bodies = scenario.carrying.ordered
    axes = machine_axes(scenario)
    way = _way(scenario, axes, samples)
    at = chains.frames(axes.chain, way.commands * axes.sense)
    if scenario.program is not None:  # along its own axis the tool plunges
        across = np.linalg.norm(np.cross(way.direction, at.rotations[:, -1, :, 2]), axis=1)
        way = way._replace(cuts=way.cuts & (across > _PLUNGE))
    cut = cut_force(scenario, way, at)
    if cut.immersion is not None:
        way = way._replace(cuts=way.cuts & (cut.immersion > 0.0))
    return MachineCell(
        tuple(body.name for body in bodies),
        axes,
        scenario.carrying.ground,
        np.array(scenario.tool.tip),
        _elements(scenario),
        _weights(scenario),
        _part(scenario, way, at),
        way,
        cut,
        scenario.convention == "paper_literal",
        scenario.load.feed_moment,
    )


def _robot_cell(scenario: MachineScenario, robot: CarryingRobot, samples: int | None) -> MachineCell:
    """The same with a robot: the way of its tool point first, by three axes along those of the part, then its joints."""
    standing = scenario.placement or Standing()
    tool = scenario.tool.model_copy(update={"tip": (0.0, 0.0, 0.0)})
    led = scenario.model_copy(update={"tool": tool})
    axes = axes_of(scenario.carrying, {})
    way = _way(led, axes, samples)
    axis = np.array(scenario.path.tool_axis if scenario.path is not None else (0.0, 0.0, -1.0))
    up = -axis / np.linalg.norm(axis)
    steady = np.tile(np.column_stack([*across(up), up]), (len(way.travel), len(axes.errors) + 1, 1, 1))
    if scenario.program is not None:
        far = np.linalg.norm(np.cross(way.direction, up), axis=1)
        way = way._replace(cuts=way.cuts & (far > _PLUNGE))
    upright = chains.Frames(steady, np.zeros((*steady.shape[:2], 3)))
    cut = cut_force(led, way, upright)
    if cut.immersion is not None:
        way = way._replace(cuts=way.cuts & (cut.immersion > 0.0))
    along = machine_robot.joints_along(robot, standing, way, cut, up)
    elements = machine_robot.elements_of(robot, along.arm, scenario.bodies[2:-1])
    last = len(scenario.bodies) - 1
    elements += _tool_elements(scenario.tool, last, np.zeros(3))
    weights = machine_robot.weights_of(robot, standing) if scenario.load.weights else ()
    return MachineCell(
        scenario.bodies, machine_robot.axes_of(along.arm, standing), 0, np.zeros(3), tuple(elements), weights,
        _part(scenario, way, upright), way._replace(commands=machine_robot.commands_of(along, way)), cut, False,
        scenario.load.feed_moment, along,
    )  # fmt: skip


def _way(scenario: MachineScenario, axes: Axes, samples: int | None) -> ToolPath:
    if scenario.program is not None:
        return machine_program.program_tool_path(scenario, scenario.program, axes, samples=samples)
    assert scenario.path is not None
    return points_tool_path(scenario, scenario.path, axes, samples=samples)


def machine_axes(scenario: MachineScenario) -> Axes:
    """The chain, the sense of its commands, and the geometric errors of its axes."""
    return axes_of(scenario.carrying, scenario.errors())


def axes_of(machine: Machine, given: dict[str, Any]) -> Axes:
    """The axes of a machine with given geometric errors, by name."""
    joints = [body.joint for body in machine.ordered[1:] if body.joint is not None]
    side = np.array([-1 if joint.side == "part" else 1 for joint in joints])
    rotations = [rotation_from_rpy(*(joint.rotation or (0.0, 0.0, 0.0))) for joint in joints]
    chain = chains.chain(
        [_KINDS[joint.kind] for joint in joints],
        [joint.axis or (0.0, 0.0, 0.0) for joint in joints],
        [joint.offset for joint in joints],
        rotations=rotations,
        sides=side,
    )
    of_table = np.array([joint.positive != "tool" for joint in joints])
    limits = np.array([joint.limits or (0.0, 0.0) for joint in joints])
    errors = tuple(
        _axis_errors(given, joint, chain.axes[i]) if joint.command else None for i, joint in enumerate(joints)
    )
    sense = np.where((side < 0) & of_table, -1.0, 1.0)
    return Axes(chain, sense, of_table, errors, limits[:, 0], limits[:, 1])


def _axis_errors(given: dict[str, Any], joint: Joint, direction: FloatArray) -> AxisErrors | None:
    axis = str(joint.command)
    motion = [_error_function(given[name], name) if (name := f"E{c}{axis}") in given else None for c in COMPONENTS]
    squareness = np.zeros(3)
    for name, (turned, about) in SQUARENESS.items():
        if turned == axis and name in given:
            squareness[about] = given[name]
    location = np.array([given.get(f"{component}O{axis}", 0.0) for component in COMPONENTS])
    if not (any(motion) or squareness.any() or location.any()):
        return None
    return AxisErrors(motion, direction, squareness, location, axis in LINEAR_AXES, joint.errors_act == "before")


def _error_function(spec: Any, name: str) -> ErrorFunction:
    if isinstance(spec, Table):
        at, value = spec.points()
        return geometry.Table(np.array(at), np.array(value))
    if hasattr(spec, "polynomial"):
        powers = np.arange(len(spec.polynomial))
        return geometry.Polynomial(np.array(spec.polynomial) / spec.over**powers)
    if hasattr(spec, "deviation"):
        generator = np.random.default_rng([spec.seed, *name.encode()])  # one seed for many functions, all different
        return geometry.random_sines(spec.deviation, wavelength=spec.over, orders=spec.orders, generator=generator)
    return geometry.Sines(np.array(spec.amplitudes), np.array(spec.phases), spec.over)


def _elements(scenario: MachineScenario) -> tuple[ElasticElement, ...]:
    last = len(scenario.carrying.ordered) - 1
    return tuple(elements_of(scenario.carrying) + _tool_elements(scenario.tool, last, np.array(scenario.tool.tip)))


def _tool_elements(tool: MachineTool, last: int, tip: FloatArray) -> list[ElasticElement]:
    """What the tool bends by, at its tip in the frame of the last body."""
    if tool.flexible:
        return [ElasticElement("tool", last, last, tip, _tool_beam(tool), None)]
    bent = tip_of(tool)
    return [] if bent is None else [ElasticElement("tip", last, last, tip, bent.matrix[0], None)]


def elements_of(machine: Machine) -> list[ElasticElement]:
    """The elastic elements of a machine."""
    found = []
    for joint, body in enumerate(machine.ordered[1:], 1):
        for element in body.elements:
            frame = joint - 1 if element.travels_with == body.parent else joint
            compliance, contact = _compliance(element)
            found.append(ElasticElement(element.name, joint, frame, np.array(element.at), compliance, contact))
    return found


def _compliance(element: ElementSpec) -> tuple[FloatArray, ContactPads | None]:
    if element.pads is not None:
        pads = element.pads
        return pad_compliance(pads.points, _with_drive(pads.stiffness, pads.drive, len(pads.points))), None
    if element.springs is not None:
        springs = element.springs
        return np.diag([1.0 / k for k in (*springs.stiffness, *springs.angular_stiffness)]), None
    if element.beam is not None:
        beam = element.beam
        shear_modulus = beam.youngs_modulus / (2.0 * (1.0 + beam.poisson_ratio))
        return cantilever(_section(beam), beam.length, beam.youngs_modulus, shear_modulus, downward=beam.hangs), None
    if element.contact is not None:
        return np.eye(6), _contact(element.contact)
    return np.array(element.compliance), None


def _with_drive(stiffness: tuple[float, ...], drive: Drive | None, count: int) -> FloatArray:
    springs = np.array(stiffness)
    if drive is not None:
        springs["xyz".index(drive.direction)] += drive.stiffness / count
    return springs


def _contact(group: ContactGroup) -> ContactPads:
    normal = np.zeros(3)
    normal["xyz".index(group.normal[1])] = -1.0 if group.normal[0] == "-" else 1.0
    points = np.array(group.points)
    springs = np.tile(_with_drive(group.tangential, group.drive, len(points)), (len(points), 1))
    coefficient = group.coefficient / 1e6**group.exponent  # given at a pressure of 1 MPa
    return ContactPads(
        points, normal, springs, group.area, coefficient, group.exponent, group.preload, group.closed_guide
    )


def _section(beam: Beam) -> Section:
    if beam.section == "box":
        return box_section(known(beam.width_x), known(beam.width_y), known(beam.wall), shear_factor=beam.shear_factor)
    if beam.section == "block":
        return block_section(known(beam.width_x), known(beam.width_y), shear_factor=beam.shear_factor)
    return round_section(known(beam.diameter), shear_factor=beam.shear_factor)


def _tool_beam(tool: MachineTool) -> FloatArray:
    section = round_section(tool.diameter, filling=known(tool.filling), shear_factor=known(tool.shear_factor))
    modulus = known(tool.youngs_modulus)
    shear_modulus = modulus / (2.0 * (1.0 + known(tool.poisson_ratio)))
    return cantilever(section, known(tool.overhang), modulus, shear_modulus, downward=True)


def _weights(scenario: MachineScenario) -> tuple[Weight, ...]:
    if not scenario.load.weights:
        return ()
    machine = scenario.carrying
    down = np.array(machine.gravity) / math.hypot(*machine.gravity)
    found = []
    block = scenario.block
    if block is not None:
        found.append(Weight(0, block.weight * down, np.array([0.0, 0.0, 0.5 * block.height])))
    for place, body in enumerate(machine.ordered):
        if body.weight is not None:
            found.append(Weight(place, body.weight * down, np.array(body.weight_at)))
    return tuple(found)


def _part(scenario: MachineScenario, way: ToolPath, at: chains.Frames) -> FlexiblePart | SpringPart | None:
    """The part as it yields: as a block, or by one stiffness off the wall."""
    if not isinstance(scenario.part, PartSpring):
        return part_block(scenario.block)
    assert scenario.surface is not None
    return SpringPart(wall_normal(scenario.surface, way.direction, at.rotations[:, -1, :, 2]), scenario.part.stiffness)


def part_block(part: PartBlock | None) -> FlexiblePart | None:
    """The part as it bends; None for a rigid one."""
    if part is None or not part.flexible:
        return None
    section = block_section(part.width_x, part.width_y, shear_factor=known(part.shear_factor))
    modulus = known(part.youngs_modulus)
    return FlexiblePart(section, modulus, modulus / (2.0 * (1.0 + known(part.poisson_ratio))))


def scatter(scenario: MachineScenario) -> tuple[FloatArray, np.ndarray]:
    """Standard deviations (n + 1, 6) [m, rad] and laws (n + 1,) of the random errors of the bodies."""
    names = list(scenario.bodies)
    deviation, laws = np.zeros((len(names), 6)), np.zeros(len(names), dtype=np.int64)
    for given in scenario.uncertainty.bodies if scenario.uncertainty else ():
        for name in given.bodies:
            deviation[names.index(name)] = [given.displacement] * 3 + [given.rotation] * 3
            laws[names.index(name)] = _LAWS[given.distribution]
    return deviation, laws
