"""What carries a mill along a wall, and what yields with it: which goes with which, and what to write instead."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.spec.base import Notice
from cutwise.spec.cell import ONE_CARRIER
from cutwise.spec.chained import tip_faults
from cutwise.spec.milled_path import MilledPath, machine_faults, robot_faults
from cutwise.spec.milling_machine import MillingMachine

if TYPE_CHECKING:
    from cutwise.spec.milling import MillingScenario

_WALL = "path: {line: {from: [1900 mm, -150 mm, 800 mm], to: [1900 mm, 150 mm, 800 mm]}, tool_axis: [0, 0, -1]}"


def carrier_faults(scenario: "MillingScenario") -> Iterator[Notice]:
    """One carrier, and a path that fits it."""
    robot, machine = scenario.robot, scenario.machine
    if robot is not None and machine is not None:
        yield Notice(("robot",), ONE_CARRIER)
    if robot is None and machine is None and not _yields(scenario):
        yield Notice(("machine",), "missing; write machine.library (or robot.library for a robot that mills)")
    if isinstance(machine, MillingMachine):
        yield from _bodies_faults(scenario, machine)
    if robot is None and scenario.placement is not None:
        yield Notice(("placement",), "places a part before a robot; there is none")
    if not scenario.programmed and scenario.operation.milling == "up" and scenario.line is None:
        yield Notice(("operation", "milling"), "up is for a line; a corner or program on a machine is milled down")
    if not scenario.programmed and scenario.numerics.mode == "still":
        yield Notice(("numerics", "mode"), "drives need time stepping: write mode: step, or leave the drives out (still is "
                     "for a robot, or a machine whose bodies yield)")  # fmt: skip


def _yields(scenario: "MillingScenario") -> bool:
    """Whether a spindle, a tool or a part yields, so that a programmed tool without a carrier is something to look at."""
    given = (scenario.compliant, scenario.tool.stiffness, scenario.part_stiffness)
    return isinstance(scenario.path, MilledPath) and (
        any(one is not None for one in given) or bool(scenario.tool.modes)
    )


def _bodies_faults(scenario: "MillingScenario", machine: MillingMachine) -> Iterator[Notice]:
    """What a machine with bodies that yield cannot do."""
    yield from tip_faults(machine)
    if scenario.path is not None and not isinstance(scenario.path, MilledPath):
        yield Notice(("path",), "bodies of a machine yield along a straight wall (path.line); a corner is run with "
                     "drives alone: machine: {library: fadal2216}")  # fmt: skip
    if scenario.program is not None:
        yield Notice(("program",), "bodies of a machine yield along a straight wall (path.line) and in a stock in 3D: write the "
                     "mill under tools; or drives alone (machine: {library: fadal2216}), or process: machine")  # fmt: skip
    if scenario.numerics.force == "tooth_resolved" and scenario.tool.modes and not scenario.programmed:
        yield Notice(("numerics", "force"), "tooth_resolved steps the modes of the tool with drives alone; beside "
                     "bodies of a machine write averaged: the modes then yield by F/k")  # fmt: skip


def yielding_faults(scenario: "MillingScenario") -> Iterator[Notice]:
    """Parts, pistons and tools that yield where nothing is modelled of it."""
    wall = isinstance(scenario.path, MilledPath)
    bodies = isinstance(scenario.machine, MillingMachine)
    if scenario.block is not None and scenario.robot is not None:
        yield Notice(("part",), "as a block stands on the table of a machine; before a robot write part.stiffness")
    elif scenario.block is not None and not bodies:
        yield Notice(("part",), "yields with the bodies of a machine; there are none (machine.library: demec_mill), or write "
                     "part.stiffness")  # fmt: skip
    for key, there in (
        ("part.stiffness", scenario.part_stiffness is not None),
        ("spindle", scenario.compliant is not None),
        ("tool.stiffness", scenario.tool.stiffness is not None),
    ):
        corrected = scenario.program is not None or scenario.correct is not None
        if there and not wall and not (key == "tool.stiffness" and corrected):
            instead = ", or write correct: {change: [path]}" if key == "tool.stiffness" else ""
            yield Notice(tuple(key.split(".")), "yields along a straight wall (path.line); along a corner or a program it is "
                         f"not modelled: leave it out{instead}")  # fmt: skip
    if scenario.compliant is None:
        return
    if scenario.numerics.mode == "still":
        yield Notice(("numerics", "mode"), "pistons remember how they were loaded, still has no time: write mode: step and "
                     "force: averaged, or spindle: rigid")  # fmt: skip
    elif scenario.numerics.force != "averaged":
        yield Notice(("numerics", "force"), "pistons in milling answer to the mean force: write averaged")


def side_faults(scenario: "MillingScenario") -> Iterator[Notice]:
    """A side of the work that contradicts the sense of milling."""
    path, milling = scenario.path, scenario.operation.milling
    side = "right" if milling == "down" else "left"
    if isinstance(path, MilledPath) and path.work not in (None, side):
        yield Notice(
            ("path", "work"),
            f"{path.work} contradicts operation.milling: a right-hand tool mills {milling} with the work on the {side} of "
            "the feed",
        )


def programmed_faults(scenario: "MillingScenario") -> Iterator[Notice]:
    """What a mill that goes as programmed needs, and what it cannot do."""
    operation, path, robot = scenario.operation, scenario.path, scenario.robot is not None
    who = "a robot" if robot else "a machine without drives"
    if isinstance(path, MilledPath):
        yield from robot_faults(path) if robot else machine_faults(path)
        yield from side_faults(scenario)
    elif robot:
        yield Notice(("path",), f"a robot needs to know where the wall is, for example {_WALL}")
    elif path is None and scenario.program is None:
        yield Notice(("path",), "missing; without drives a mill goes along a straight wall, for example path: {line: {from: "
                     "[-100 mm, -40 mm], angle: 30 deg, length: 100 mm}}")  # fmt: skip
    if robot and scenario.program is not None:
        yield Notice(
            ("program",), "a robot follows path.line; to mill by a program write the mill under tools (a stock in 3D)"
        )
    if scenario.stock is not None:
        yield Notice(("stock",), f"belongs to a program; {who} has its depths (operation.radial_depth, .axial_depth)")
    if scenario.numerics.mode == "step" and scenario.numerics.force != "averaged":
        yield Notice(("numerics", "mode"), f"{who} is computed at rest, or stepped under the mean force: write mode: still, or "
                     "force: averaged")  # fmt: skip
    for key, sample in (("feed", "40 mm/s"), ("spindle_speed", "8000 rpm"), ("axial_depth", "5 mm"),
                        ("radial_depth", "4 mm")):  # fmt: skip
        if getattr(operation, key) is None:
            yield Notice(("operation", key), f"missing; write it as text with a unit, for example {sample}")
    radial = operation.radial_depth
    if radial is not None and radial > scenario.tool.diameter * (1 + 1e-9):
        shown = units.show(scenario.tool.diameter, "length")
        yield Notice(("operation", "radial_depth"), f"is more than the diameter of the mill ({shown})")
    length, depth = scenario.tool.flute_length, operation.axial_depth
    if length is not None and depth is not None and depth > length * (1 + 1e-9):
        shown = units.show(length, "length")
        yield Notice(("operation", "axial_depth"), f"is more than the flute length ({shown}, tool.flute_length)")


def unused(scenario: "MillingScenario") -> Iterator[Notice]:
    """What belongs to drives, to time stepping or to teeth."""
    still = scenario.numerics.mode == "still"
    rest = "each place is at rest, under the mean force of the cut (numerics.mode)"
    for key in ("substeps", "discs", "settling_time"):
        yield Notice(("numerics", key), "there are no drives (machine.drives)")
    for key in ("force", "time_step") if still else ():
        yield Notice(("numerics", key), rest)
    if still:
        yield Notice(("operation", "lead_in_time"), rest)
    for key in ("runout", "runout_angle"):
        yield Notice(("tool", key), "the mean force over a turn counts, without drives")
    yield Notice(("path_mode",), "a line has no corners; those between blocks are of a program")
    yield Notice(("lobes",), "the depth at which it chatters is told along its path, not over the speed")
    if scenario.robot is not None and still and scenario.robot.dynamics != "links":
        yield Notice(("robot", "dynamics"), "the cut is computed at rest, and chatter with the swinging mass")
    if scenario.robot is not None and not scenario.operation.limit_feed:
        yield Notice(("robot", "joint_acceleration"), "it counts with operation.limit_feed")
    if scenario.robot is None and isinstance(scenario.path, MilledPath):
        for key in ("tool_axis", "orientation"):
            yield Notice(("path", key), "it is for a robot; the tool of a machine stands as its chain says")
