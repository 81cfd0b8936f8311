"""Drilled holes as a program of the robot that drills them."""

import math
from collections.abc import Sequence

import numpy as np

from cutwise.maths.frames import FloatArray
from cutwise.process.drilling import DrillCell, DrilledHole, drill_cell, led_axes, next_to
from cutwise.process.posture import posture_frames
from cutwise.process.postures import Arm
from cutwise.programs.robot_moves import Frame, RobotMove, RobotProgram, abc_of
from cutwise.spec.drilling import DrillingScenario
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.correct.drill import holes_of

CLEAR = 5e-3  # [m] of the tip before the surface where a hole is approached
BEYOND = 1e-3  # [m] that the corner of the drill goes beyond the exit surface
APPROACH = 0.05  # [m/s] to the surface and back
BLEND = 1e-3  # [m] where a corner may be cut
_MM = 1e3


def drilling(scenario: DrillingScenario, comments: Sequence[str] = ()) -> RobotProgram:
    """Every hole in the order of the scenario: approached by the joints, fed through, drawn back along its axis.

    Raises
    ------
    ScenarioFault
        A hole cannot be approached in its posture.
    """
    cell = drill_cell(scenario)
    assert cell.arm is not None
    moves: list[RobotMove] = []
    faults: list[Fault] = []
    for number, hole in enumerate(holes_of(scenario), 1):
        if hole.posture is None:
            faults.append(Fault(("hole",), f"hole {number} cannot be drilled: there is no pose to write"))
            continue
        try:
            moves += _hole(scenario, cell, hole)
        except ValueError as why:
            faults.append(Fault(("hole",), f"hole {number}: {why}"))
    if faults:
        raise ScenarioFault(faults)
    rpm = scenario.operation.spindle_speed * 30.0 / math.pi
    told = (
        f"cutwise: {scenario.name}",
        *comments,
        "poses of the tool tip in the base frame of the robot model, mm and degrees",
        "tool: seen from the flange as the model has it (axes of the last link, parallel to the base at zero); hold it "
        "against that of the control, whose flange may be turned",
        f"start the spindle before, {rpm:.0f} rpm to the right; approach {APPROACH * _MM:.0f} mm/s",
    )
    frame = Frame(np.asarray(cell.arm.tool_tip), np.asarray(cell.arm.tool_rotation))
    return RobotProgram(scenario.name, frame, Frame(np.zeros(3), np.eye(3)), moves, BLEND, told)


def _hole(scenario: DrillingScenario, cell: DrillCell, hole: DrilledHole) -> list[RobotMove]:
    arm, cycle = cell.arm, cell.cycle
    assert arm is not None
    assert scenario.robot is not None
    assert hole.posture is not None
    there, axes = led_axes(hole.target, hole.posture.angle, hole.led)
    depth = cycle.thickness + cycle.cone + BEYOND
    joints = []
    for place in (-CLEAR, 0.0, depth):
        at = there.position + place * there.axis
        posture = next_to(arm, at, axes, hole.posture, scenario.robot.singularity_margin)
        if posture is None:
            raise ValueError(
                f"the tool cannot stand {abs(place) * _MM:.3g} mm {'before' if place < 0 else 'in'} the surface"
            )
        joints.append((Frame(at, axes), posture.q))
    before, entry, bottom = joints
    feed = cycle.feed * cycle.turns

    def to(where: tuple[Frame, FloatArray], speed: float) -> RobotMove:
        return RobotMove(*where, speed, True, posture_number(arm, where[1]))

    return [to(before, 0.0), to(entry, APPROACH), to(bottom, feed), to(entry, APPROACH), to(before, APPROACH)]


def posture_number(arm: Arm, q: FloatArray) -> int:
    """Number of a posture among eight (cfx of ABB): 4 behind axis 1, 2 behind the lower arm, 1 axis 5 negative."""
    frames = posture_frames(arm, q)
    origins = np.asarray(frames.origins)[-6:]
    up = np.asarray(frames.rotations)[-6] @ np.asarray(arm.chain.axes)[-6]
    up = up * math.copysign(1.0, up[2])
    forward = origins[1] - origins[0] - ((origins[1] - origins[0]) @ up) * up
    wrist = origins[4]
    if np.linalg.norm(forward) < 1e-9:  # axis 2 crosses axis 1: its own direction tells
        forward = np.cross(np.asarray(frames.rotations)[-5] @ np.asarray(arm.chain.axes)[-5], up)
    behind = (wrist - origins[0]) @ forward < 0.0
    side = np.cross(up, forward)
    below = np.cross(wrist - origins[1], origins[2] - origins[1]) @ side > 0.0
    return 4 * bool(behind) + 2 * bool(below) + (1 if q[4] < 0.0 else 0)


def poses(program: RobotProgram) -> str:
    """Poses of a program as CSV, a row a move."""
    lines = [*(f"# {text}" for text in program.comments), "# A B C: R = Rz(A) Ry(B) Rx(C); speed 0: a move of the joints",
             "x [mm], y [mm], z [mm], A [deg], B [deg], C [deg], q1 [deg], q2 [deg], q3 [deg], q4 [deg], q5 [deg], q6 [deg], "
             "speed [mm/s]"]  # fmt: skip
    for move in program.moves:
        values = [*(move.pose.origin * _MM), *abc_of(move.pose.rotation), *np.degrees(move.joints)]
        lines.append(", ".join([*(f"{value + 0.0:.6f}" for value in values), f"{move.speed * _MM:.6g}"]))
    return "\n".join([*lines, ""])
