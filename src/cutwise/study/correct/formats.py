"""Languages of a corrected program: what each of them is made of, by process."""

from collections.abc import Sequence

from cutwise.process.assemble_mill import read_program
from cutwise.process.chamfer_program import program_of
from cutwise.programs import post, robot_moves, written_moves
from cutwise.programs.rewrite import with_first_comment
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.drilling import DrillingScenario
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.machine_scenario import MachineScenario
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct import error_map, robot_program
from cutwise.study.correct.outcome import Corrected

_FINE = 6  # decimals of a corrected path: its shifts are less than a micrometre


def rs274(found: Corrected) -> str:
    """The new program in its own language; of a chamfer its G-code."""
    chamfered = _chamfered(found, "gcode")
    text = found.program if chamfered is None else chamfered
    if not text:
        raise _refused("rs274", found, "this scenario has no program; take the changed settings over with --set")
    return text if found.good else with_first_comment(text, f"cutwise: not good enough: {'; '.join(found.reasons)}")


def fanuc(found: Corrected) -> str:
    """The new program for Fanuc-compatible controls."""
    scenario = _milled(found, "fanuc")
    return _written(lambda moves: written_moves.fanuc(scenario.name, moves, comments=_misses(found)), scenario, "fanuc")


def apt(found: Corrected) -> str:
    """The new program as APT."""
    chamfered = _chamfered(found, "apt")
    if chamfered is not None:
        return "\n".join([*(f"$$ {written_moves.plain(text)}" for text in _misses(found)), chamfered])
    scenario = _milled(found, "apt")
    diameter = None if scenario.tool is None else scenario.tool.diameter
    return _written(
        lambda moves: written_moves.apt(scenario.name, moves, diameter=diameter, comments=_misses(found)),
        scenario,
        "apt",
    )


def krl(found: Corrected) -> str:
    """Corrected poses in the KUKA robot language."""
    return robot_moves.krl(robot_program.drilling(_drilled(found, "krl"), _misses(found)))


def rapid(found: Corrected) -> str:
    """Corrected poses in RAPID."""
    return robot_moves.rapid(robot_program.drilling(_drilled(found, "rapid"), _misses(found)))


def poses(found: Corrected) -> str:
    """Corrected poses as CSV: place, angles A B C, angles of the motors, speed; of a chamfer its frames."""
    chamfered = _chamfered(found, "poses_csv")
    if chamfered is not None:
        return "\n".join([*(f"# {text}" for text in _misses(found)), chamfered])
    return robot_program.poses(robot_program.drilling(_drilled(found, "poses"), _misses(found)))


def table(found: Corrected) -> str:
    """What a control or a scenario takes as a table: feed over an edge, errors over the working space."""
    scenario, told = found.scenario, [f"# {text}" for text in _misses(found)]
    if isinstance(scenario, DeburringScenario) and scenario.operation.feed_profile is not None:
        columns = scenario.operation.feed_profile.columns
        rows = zip(*columns.values(), strict=True)
        return "\n".join([*told, ", ".join(columns), *(", ".join(f"{value:.9g}" for value in row) for row in rows), ""])
    if isinstance(scenario, MachineScenario):
        return "\n".join([*told, error_map.text(scenario)])
    raise _refused("table", found, "a feed along an edge (deburr) and an error map (machine) are tables")


def _misses(found: Corrected) -> tuple[str, ...]:
    """What the first comment says of a program that is not good enough."""
    return () if found.good else (f"cutwise: misses {'; '.join(found.reasons)}",)


def _chamfered(found: Corrected, writer: str) -> str | None:
    """The program of a chamfer as it was run again; None of another process."""
    if not isinstance(found.scenario, ChamferScenario):
        return None
    try:
        program = program_of(found.after)
        return post.gcode(program, decimals=_FINE) if writer == "gcode" else str(getattr(post, writer)(program))
    except post.SetupFault as why:
        raise ScenarioFault([Fault((), str(why), file=f"--format {writer}")]) from None


def _milled(found: Corrected, form: str) -> MillingScenario:
    if not isinstance(found.scenario, MillingScenario) or found.scenario.program is None:
        raise _refused(form, found, "it writes NC programs (mill)")
    return found.scenario


def _drilled(found: Corrected, form: str) -> DrillingScenario:
    if not isinstance(found.scenario, DrillingScenario) or found.scenario.robot is None:
        raise _refused(form, found, "it writes programs of robots (drill, with robot)")
    return found.scenario


def _written(write, scenario: MillingScenario, form: str) -> str:  # type: ignore[no-untyped-def]
    read = read_program(scenario)
    assert read is not None
    moves: Sequence[object] = read.moves
    try:
        return str(write(moves))
    except written_moves.Unwritten as why:
        raise ScenarioFault([Fault((), str(why), file=f"--format {form}")]) from None


def _refused(form: str, found: Corrected, why: str) -> ScenarioFault:
    return ScenarioFault(
        [Fault((), f"does not go with process: {found.scenario.process}; {why}", file=f"--format {form}")]
    )
