"""What a drilling run has to say beyond its numbers: why a hole cannot be drilled, what to mistrust."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cutwise import units
from cutwise.maths.chains import jacobian
from cutwise.maths.constants import GRAVITY
from cutwise.maths.frames import FloatArray
from cutwise.physics.cutting.drill_formulas import half_specific_force, shaw_oxford, tungaloy
from cutwise.physics.structure.joint_compliance import geometric_stiffness, holding_force
from cutwise.process import arm_geometry
from cutwise.process.chain_compliance import off_part
from cutwise.process.drilling import (
    NOT_LED,
    DrillCell,
    DrilledHole,
    DrillRun,
    dynamics,
    hole_ends,
    skating_of,
    slope_angle,
)
from cutwise.process.drilling_at_rest import quasi_static_hole
from cutwise.process.drilling_measures import nominal_shares
from cutwise.process.loops_drilling import HoleOutcome, step_limit
from cutwise.process.posture import (
    Posture,
    arm_compliance,
    joint_room,
    posture_frames,
    posture_jacobian,
)
from cutwise.process.postures import Arm
from cutwise.results import Finding, Place, Remedy, Said, named, warned
from cutwise.spec.drilling import DrillingScenario
from cutwise.spec.robot import Robot

_ABSURD_SAG = 5e-3  # [m] under the rated payload; arms that drill have one to three
_NEAR_LIMIT = math.radians(0.1)
_RESONANCE = (0.7, 1.4)  # spindle frequency over arm frequency

_OF_ARM = (
    "The arm is its joints: links, bearings and spindle are rigid; joint stiffness is constant, that of the output.",
    "Hole wall, wander length, friction, modal mass and damping have no published values; they are inputs, assumed.",
)
_OF_MACHINE = (
    "The bodies of the machine yield at once: no mass, no drives; their rate is a backward difference over a step.",
    "Hole wall, wander length and friction have no published values; they are inputs, assumed.",
)
_OF_ALL = (
    "Rotation of the tool under load is not coupled back; gravity is constant and taken as calibrated out.",
    "The plate leaves no burr, and bends only as part.stiffness or part.block say; at entry every point cuts at full chip "
    "thickness from its first turn.",
    "The estimate of circularity is an upper bound: the wall of the hole is taken to hold nothing.",
    "Zone factors of the chisel edge are calibrated to makers' thrust within 10 to 18 %; thrust of conventional points "
    "is up to 1.7 times larger, torque within 35 %.",
)


def limits(scenario: DrillingScenario) -> tuple[str, ...]:
    """What the model leaves out."""
    return (*(_OF_ARM if scenario.machine is None else _OF_MACHINE), *_OF_ALL)


def infeasible(scenario: DrillingScenario, run: DrillRun) -> tuple[Finding, ...]:
    """Every hole that cannot be drilled, with what is missing."""
    numbered = list(enumerate(run.holes, 1))
    unreached = [
        Finding("singular" if hole.singular else "unreachable", Place(f"hole {index}"), hole.reach.margin, 0.0,
                "length" if hole.reach.motor < 0 else "angle", words=_why(scenario, run, index, hole), cannot=True)
        for index, hole in numbered if hole.posture is None
    ]  # fmt: skip
    unfinished = [
        Finding("never_through", Place(f"hole {index}"), hole.outcome.axial_max, dimension="length", cannot=True, words=(
            f"{_named(index, hole)} is never through: what carries the drill yields by "
            f"{units.show(hole.outcome.axial_max, 'length', 3)} along it, and "
            f"{units.show(hole.outcome.extra, 'length', 3)} of further feed did not bring the corner of the drill out; choose a "
            "stiffer posture, or a smaller feed"))
        for index, hole in numbered if hole.outcome is not None and not hole.outcome.through
    ]  # fmt: skip
    return (*unreached, *unfinished)


def _named(index: int, hole: DrilledHole) -> str:
    return f"hole {index} at ({', '.join(f'{1e3 * x:.4g}' for x in hole.target.position)}) mm"


def _why(scenario: DrillingScenario, run: DrillRun, index: int, hole: DrilledHole) -> str:
    robot = scenario.robot
    assert robot is not None
    choice = robot.redundancy_angle
    where = "at any redundancy angle" if isinstance(choice, str) else f"at {units.show(choice, 'angle', 4)}"
    name = _named(index, hole)
    if hole.led != NOT_LED and hole.reach.reached:
        return f"{name} is reached {where}, but not where hole.corrections lead the tool"
    if hole.singular:
        return (
            f"{name} is reached {where} only in a singular posture: |sin| of the wrist angle stays below "
            f"{robot.singularity_margin:g}; turn the tool, or tilt it on the flange"
        )
    if hole.reach.motor < 0 and run.cell.not_spherical:
        return (
            f"{name} is out of reach {where}: no posture puts the tool there, whatever the limits; at the nearest one "
            f"it is {units.show(-hole.reach.margin, 'length', 4)} off"
        )
    if hole.reach.motor < 0:
        return f"{name} is out of reach {where}: the arm is {units.show(-hole.reach.margin, 'length', 4)} too short"
    if hole.reach.between:
        return f"{name} is not reached {where}: the angle between links of robot.linkages would leave its limits"
    number = robot.motors[hole.reach.motor]
    joint = robot.joints[number]
    low, high = (units.show(end, "angle", 4) for end in joint.limits)
    label = f" ({joint.name})" if joint.name else ""
    return (
        f"{name} is not reached {where}: joint {number + 1}{label} would have to go "
        f"{units.show(-hole.reach.margin, 'angle', 4)} beyond its limits ({low} to {high}), the least of all branches"
    )


def warnings(scenario: DrillingScenario, run: DrillRun) -> tuple[Said, ...]:
    """Everything that the engineer should know before he trusts the numbers."""
    carrier: list[Said] = list(_robot(scenario, run, scenario.robot) if scenario.robot is not None else ())
    if scenario.part.block is not None:
        carrier += off_part(
            scenario.part.block, np.stack([hole.target.position for hole in run.holes]), 0.5 * scenario.tool.diameter
        )
    return tuple(dict.fromkeys([*carrier, *_process(scenario, run)]))


def _robot(scenario: DrillingScenario, run: DrillRun, robot: Robot) -> Iterator[Finding]:
    arm = run.cell.arm
    assert arm is not None
    yield from _own_error(scenario, robot)
    there = [hole.posture.q for hole in run.holes if hole.posture is not None]
    if there:
        wrong = arm_geometry.misplaced(robot, arm, np.array(there))
        yield from arm_geometry.warnings(robot, wrong, scenario.measured.get("robot"))
    if arm.general is not None and not arm.general.proven:
        yield warned(
            "postures_missed", f"the arm has no spherical wrist ({run.cell.not_spherical}), and its axes are such that some of its "
            "postures may not be found",
        )  # fmt: skip
    elif arm.wrist is not None and abs(arm.wrist.plane[5]) > 1e-4:
        offset = units.show(abs(arm.wrist.plane[5]), "length", 3)
        yield warned(
            "wrist_beside_plane",
            f"the wrist centre lies {offset} beside the plane of the arm; offsets in public models often fail "
            "to cancel: check the joint origins", abs(arm.wrist.plane[5]), 1e-4, "length",
        )  # fmt: skip
    payload = robot.payload
    sags = [sag(run, hole, payload) for hole in run.holes if hole.posture is not None and payload is not None]
    if sags and max(sags) > _ABSURD_SAG:
        yield warned(
            "absurd_sag", f"with this joint stiffness the arm sags {units.show(max(sags), 'length', 3)} under its rated payload of "
            f"{units.show(payload or 0.0, 'mass')}: absurd, usual is 1 to 3 mm; the set is probably wrong by a factor", max(sags),
            _ABSURD_SAG, "length",
        )  # fmt: skip


def _own_error(scenario: DrillingScenario, robot: Robot) -> Iterator[Finding]:
    """What the position of a hole does not hold."""
    own = robot.accuracy
    if own is None and robot.errors is not None:
        return
    if own is None:
        yield warned(
            "left_out", "hole_position_error_entry and _exit are what the arm yields by under the cut, alone: where the arm stands "
            "without load is not in them. Arms off the shelf miss a programmed point by 0.2 to 2 mm and a taught one by "
            "0.05 to 0.15 mm; state it as robot.accuracy, which gives hole_position_error_total",
            where=Place("robot.accuracy"),
        )  # fmt: skip
        return
    tighter = [
        name
        for name, limit in scenario.requirements.items()
        if name in ("hole_position_error_entry", "hole_position_error_exit") and (limit.max or math.inf) < own
    ]
    if tighter:
        yield warned(
            "tighter_than_arm",
            f"{' and '.join(tighter)}: this limit holds what the arm yields by under the cut, alone; its own error, "
            f"robot.accuracy {units.show(own, 'small_length', 3)}, is larger and comes on top: require "
            "hole_position_error_total for the place of the hole", own, dimension="length",
        )  # fmt: skip


def sag(run: DrillRun, hole: DrilledHole, payload: float) -> float:
    """How far the tool sinks under the rated payload, in the posture of a hole [m]."""
    assert hole.posture is not None
    assert run.cell.arm is not None
    return float(arm_compliance(run.cell.arm, hole.posture.q)[2, 2]) * payload * GRAVITY


def _process(scenario: DrillingScenario, run: DrillRun) -> Iterator[Finding]:
    """What holds for several holes is said once, with their numbers."""
    said: dict[Finding, list[int]] = {}
    for index, hole in enumerate(run.holes, 1):
        if hole.posture is not None and hole.outcome is not None:
            for one in (*_posture(scenario, run, hole.posture), *_hole(scenario, hole, hole.outcome)):
                said.setdefault(one, []).append(index)
    for one, holes in said.items():
        where = f"hole{'s' if len(holes) > 1 else ''} {', '.join(map(str, holes))}"
        yield named(one, where, Place(where)) if len(run.holes) > 1 else replace(one, where=Place(where))
    if scenario.tool.lip_model == "oblique":
        words = (
            "oblique lips with coefficients of the simple ones underrate thrust (by 42 % in the reference case): use "
            "coefficients that were calibrated with oblique lips"
        )
        yield warned("beyond_data", words, where=Place("tool.lip_model"))


def _posture(scenario: DrillingScenario, run: DrillRun, posture: Posture) -> Iterator[Finding]:
    if scenario.robot is not None and run.cell.arm is not None:
        yield from _stance(scenario.robot, run.cell.arm, posture)
    friction, skates = scenario.contact.friction, skating_of(run.cell, posture)
    if skates > friction:
        number = f", {skates:.3g}," if len(run.holes) == 1 else ""
        other = "another redundancy angle (least_skating)" if scenario.robot is not None else "a stiffer setting-up"
        words = (
            f"the tip skates at entry: its skating ratio{number} is above the friction of {friction:.3g}; choose {other}, "
            f"{'a milled seat, ' if len(run.cell.side) else ''}or a pilot hole"
        )
        yield warned("skates", words, limit=friction, remedy=Remedy("robot.redundancy_angle", "least_skating"))


def _stance(robot: Robot, arm: Arm, posture: Posture) -> Iterator[Finding]:
    """Room of the joints, and under the foot."""
    room = joint_room(arm, posture.q)
    if room.min() < _NEAR_LIMIT:
        joint = f"joint {robot.motors[int(room.argmin())] + 1}"
        words = (
            f"{joint} stands within {units.show(_NEAR_LIMIT, 'angle', 2)} of its limit: the program will need some room to "
            "approach and retract"
        )
        yield warned("near_limit", words, limit=_NEAR_LIMIT, dimension="angle")
    heights = posture_frames(arm, posture.q).origins[1:, 2]
    if heights.min() < 0.0:
        words = f"joint {int(heights.argmin()) + 1} stands below the base: is there room under the foot of the robot?"
        yield warned("below_base", words)


def _hole(scenario: DrillingScenario, hole: DrilledHole, outcome: HoleOutcome) -> Iterator[Finding]:
    speed = scenario.operation.spindle_speed / (2.0 * math.pi)
    if any(_RESONANCE[0] < speed / f < _RESONANCE[1] for f in hole.frequencies):
        words = (
            f"the spindle turns at {speed:.3g} Hz, next to a mode of the arm: unequal lips shake the tool; change the "
            "speed by a third"
        )
        yield warned("resonance", words, speed, dimension="frequency")
    if outcome.extra > 0.0 and outcome.through:
        words = (
            f"the arm lags so far behind that the corner comes out only {units.show(outcome.extra, 'length', 3)} beyond "
            "the usual overrun of 1 mm: program the feed that much further"
        )
        yield warned("overrun", words, outcome.extra, dimension="length")
    if outcome.feed_max > 2.0 * scenario.operation.feed_per_rev:
        words = (
            "the drill is pulled in at breakthrough, at more than twice the feed: reduce the feed before the exit, or "
            "choose a stiffer posture"
        )
        twice = 2.0 * scenario.operation.feed_per_rev
        yield warned("pulled_in", words, limit=twice, dimension="feed_per_revolution")
    if outcome.thrust_mean == 0.0:
        yield warned("no_full_cut", "the plate is thinner than the drill point is high: there is no full cut")


def notes(scenario: DrillingScenario, run: DrillRun) -> dict[str, str]:
    """Plausibility of thrust and torque, stick or slip, the quasi-static cross-check, where the part went."""
    told = {"plausibility": _plausibility(scenario, run)}
    first = next((hole for hole in run.holes if hole.posture is not None), None)
    if first is not None:
        told["skating"] = _skating(scenario, run, first)
        told["cross_check"] = _cross_check(run, first)
    if len(run.holes) > 1:
        told["holes"] = "\n".join(_line(run.cell, i, hole) for i, hole in enumerate(run.holes, 1))
    if run.places:
        best = ", ".join(f"{1e3 * x:.4g}" for x in run.shift)
        told["placement"] = f"Of {len(run.places)} places of the part, the shift ({best}) mm has the best worst hole."
    return told


def _plausibility(scenario: DrillingScenario, run: DrillRun) -> str:
    tool, feed, material = scenario.tool, scenario.operation.feed_per_rev, scenario.material
    lips, chisel, torque_lips, torque_chisel = nominal_shares(scenario, run.cell)
    thrust, torque = lips + chisel, torque_lips + torque_chisel
    lines = [f"model {thrust:.4g} N, {torque:.4g} N m (chisel edge {chisel / thrust:.0%})"]
    rivals = {
        "half k_c (thinned point)": half_specific_force(
            run.cell.stress.specific, tool.diameter, feed, 0.5 * tool.point_angle
        )
    }
    if material.hardness is not None:
        rivals["Shaw-Oxford (conventional point)"] = shaw_oxford(material.hardness, tool.diameter, feed)
    if material.tungaloy_factor is not None:
        rivals["Tungaloy (conventional point)"] = tungaloy(material.tungaloy_factor, tool.diameter, feed)
    lines += [f"{name} {value.thrust:.4g} N, {value.torque:.4g} N m" for name, value in rivals.items()]
    return "Thrust and torque in full contact, for plausibility and not as validation: " + "; ".join(lines) + "."


def _heaviest(run: DrillRun) -> tuple[float, float]:
    """The largest thrust [N], and the torque that goes with it [N m]."""
    place = int(np.argmax(run.cell.profile.thrust))
    return float(run.cell.profile.thrust[place]), float(run.cell.profile.torque[place])


def _skating(scenario: DrillingScenario, run: DrillRun, hole: DrilledHole) -> str:
    assert hole.posture is not None
    mu = scenario.contact.friction
    ratio = skating_of(run.cell, hole.posture)
    holds = "holds" if ratio <= mu else "skates"
    if len(run.cell.side):
        return (
            f"Skating ratio {ratio:.4g} against friction {mu:g}: the tip {holds} at an entry on a slope; on a flat surface "
            f"the ratio would be {hole.posture.skating:.4g}, the rest is the side force of the lips."
        )
    thrust, torque = _heaviest(run)
    force = float(np.linalg.norm(holding_force(hole.posture.compliance, thrust, torque))) / thrust
    return (
        f"Skating ratio {ratio:.4g} against friction {mu:g}: the tip {holds} at a flat entry. With the "
        f"drill torque on the arm the ratio is {force:.4g}."
    )


def _cross_check(run: DrillRun, hole: DrilledHole) -> str:
    assert hole.posture is not None
    assert hole.outcome is not None
    if not hole.outcome.through:
        return "The hole is never through: there is no exit to compare."
    still = quasi_static_hole(
        run.cell.cycle,
        dynamics(run.cell, hole.posture),
        run.cell.profile,
        slope_angle=slope_angle(run.cell, hole.posture),
    )
    texts = [
        f"{name} {_um(still_one)} against {_um(moving)}"
        for name, still_one, moving in (("entry", still[0], hole.outcome.entry), ("exit", still[1], hole.outcome.exit))
    ]
    told = f"Position error without inertia and damping against the time stepping: {', '.join(texts)}."
    if run.cell.arm is None:
        return told
    return (
        f"{told}\n"
        f"The stiffening of the arm by the load itself, which is left out, would change its compliance by "
        f"{_stiffening(run, hole.posture):.2g} of it (Chen and Kao)."
    )


def _stiffening(run: DrillRun, posture: Posture) -> float:
    """Relative change of the compliance when the joints also carry the geometric stiffness of thrust and torque."""
    arm = run.cell.arm
    assert arm is not None
    jac = posture_jacobian(arm, posture.q)
    each = jacobian(arm.chain, arm.drives.joints(posture.q), arm.tool_tip)
    feed = posture_frames(arm, posture.q).rotations[-1] @ arm.tool_rotation[:, 2]
    thrust, torque = _heaviest(run)
    load = -np.concatenate([feed * thrust, feed * torque])
    plain = arm_compliance(arm, posture.q)
    own = len(arm.drives.elastic.T)
    turning = np.zeros((len(arm.stiffness), len(arm.stiffness)))
    turning[:own, :own] = arm.drives.elastic.T @ geometric_stiffness(each, load) @ arm.drives.elastic
    yielding = np.diag(1.0 / arm.stiffness)  # (K - K_C)^-1 without K, which may be infinite
    changed = jac @ (np.linalg.solve(np.eye(len(yielding)) - yielding @ turning, yielding) - yielding) @ jac.T
    return float(np.linalg.norm(changed) / np.linalg.norm(plain))


def _line(cell: DrillCell, index: int, hole: DrilledHole) -> str:
    if hole.posture is None or hole.outcome is None:
        return f"{index}: not drilled"
    stands = "" if math.isnan(hole.posture.wrist_sine) else f"{units.show(hole.posture.angle, 'angle', 4)}, "
    if not hole.outcome.through:
        return f"{index}: {stands}never through"
    at_entry, at_exit = hole_ends(cell, hole)
    return f"{index}: {stands}entry {_um(at_entry)}, exit {_um(at_exit)}"


def _um(position: FloatArray) -> str:
    return units.show(float(np.hypot(*position)), "small_length", 4)


def unsound(run: DrillRun, time_step: float) -> Iterator[Finding]:
    """A tip that is pushed out of the cut, a step too long for the arm."""
    for number, hole in enumerate(run.holes, 1):
        if hole.posture is None or hole.outcome is None:
            continue
        if hole.outcome.feed_min <= 0.0:
            yield Finding("contact_lost", Place(f"hole {number}"), hole.outcome.feed_min, 0.0, "feed_per_revolution")
        largest = step_limit(run.cell.cycle, dynamics(run.cell, hole.posture), float(run.cell.profile.thrust.max()))
        if time_step > largest:
            yield Finding("unsolved", Place(f"hole {number}"), time_step, largest, "time")
