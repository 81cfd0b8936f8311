"""``cutwise.correct``: from a scenario to the program that keeps its limits, proved by another simulation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from cutwise.io.program_setup import setup_of
from cutwise.io.scenario import revised
from cutwise.programs.cldata import is_apt
from cutwise.programs.unroll import as_rs274, unrolled
from cutwise.results import SOUNDNESS, Measure, Result
from cutwise.spec.correct import KEYS, Correction
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.program import StartPosition
from cutwise.spec.scenario import Scenario
from cutwise.study.band import simulate
from cutwise.study.correct.outcome import Corrected, Progress, Proposal, Task, measured
from cutwise.study.correct.table import CORRECTIONS, OBJECTIVES, READ, changes_of, found, refusals_of


def correct(
    scenario: Scenario, change: Sequence[str] = (), *, unroll: bool = False, progress: Progress | None = None
) -> Corrected:
    """What to change so that the limits of a scenario are kept and its objective is best.

    Parameters
    ----------
    scenario : Scenario
        What is corrected, with a section ``correct`` or without.
    change : sequence of str
        What may be changed, instead of ``correct.change``: feed, speed, ...
    unroll : bool
        Whether lines of a program that run several times are written out, where they should differ.
    progress : callable, optional
        Called with the finished share, 0 to 1, now and then.

    Returns
    -------
    Corrected
        The new program and scenario, the runs before and after, what was changed and why.

    Raises
    ------
    ScenarioFault
        Something is asked for that does not exist, or cannot be done with this scenario.
    """
    if change:
        scenario = revised(scenario, {"correct.change": list(change)})
    said = scenario.correct or Correction()
    faults = list(refused(scenario, said, unroll=unroll))
    if faults:
        raise ScenarioFault(faults)
    scenario, told = _as_gcode(scenario)
    before = simulate(scenario, None)
    if progress is not None:
        progress(0.2)
    proposals = [Proposal(scenario, told=told)]
    if unroll:
        scenario, told = _written_out(scenario)
        proposals.append(Proposal(scenario, told=told))
    task = Task(scenario, said, before, unroll, progress)
    for one in changes_of(scenario.process):
        if one in said.change:
            function = found(scenario.process, one)
            assert function is not None
            proposals.append(function(task))
            task = replace(task, scenario=proposals[-1].scenario)
    last = proposals[-1]
    after = last.after or simulate(last.scenario, None)
    return _judged(task, proposals, after)


def _as_gcode(scenario: Scenario) -> tuple[Scenario, tuple[str, ...]]:
    """The scenario with an APT program as the G-code of its moves; every other one as it is."""
    program = getattr(scenario, "program", None)
    if program is None or not is_apt(program.text, program.file):
        return scenario, ()
    text, begin = as_rs274(program.text, program.file, setup_of(program))
    start = None if begin is None else StartPosition.model_construct(x=begin[0], y=begin[1], z=begin[2])
    plain = program.model_copy(update={
        "text": text, "file": f"{program.file.rpartition('.')[0]}.nc", "dialect": "rs274", "offsets": None, "start": start,
    })  # fmt: skip
    told = f"{program.file} is APT: corrected by its moves and written anew; comments and words of its post-processor are not kept"
    return scenario.model_copy(update={"program": plain}), (told,)


def _written_out(scenario: Scenario) -> tuple[Scenario, tuple[str, ...]]:
    """The scenario with its program without loops and subprograms, and what became of it."""
    program = getattr(scenario, "program", None)
    assert program is not None
    found = unrolled(program.text, program.file, setup_of(program))
    if not found.repeated:
        return scenario, ("--unroll: no line runs several times; the program is written as it stands",)
    count = found.text.count("\n")
    told = f"--unroll: {found.repeated} lines that run several times are written out, {count} lines for {found.before}"
    return scenario.model_copy(update={"program": program.model_copy(update={"text": found.text})}), (told,)


def checked(scenario: Scenario) -> None:
    """Find what a correction of a scenario would be refused for, without running it.

    Raises
    ------
    ScenarioFault
        All of it.
    """
    faults = list(refused(scenario, scenario.correct or Correction()))
    if faults:
        raise ScenarioFault(faults)


def refused(scenario: Scenario, said: Correction, *, unroll: bool = False) -> Iterator[Fault]:
    """What is asked for and not there."""
    there = changes_of(scenario.process)
    for place, one in enumerate(said.change):
        if (scenario.process, one) not in CORRECTIONS:
            kinds = sorted({kind for kind, change in CORRECTIONS if change == one})
            known = f"of process: {scenario.process} there are {', '.join(there)}" if there else (
                f"nothing of process: {scenario.process} can be corrected yet" + (f", {one} of {', '.join(kinds)}" if kinds else "")
            )  # fmt: skip
            yield Fault(("correct", "change", place), f"{one} is not there yet; {known}")
    for key, users in _unread(scenario.process, said).items():
        if not users and there:
            names = sorted(frozenset[str]().union(*(_reads(scenario.process, one) for one in there)))
            yield Fault(("correct", key), f"is read by nothing that can be changed of process: {scenario.process} (change: "
                        f"{', '.join(there)}); it reads {', '.join(names)}")  # fmt: skip
    for one in said.change:
        known_here = OBJECTIVES.get((scenario.process, one), frozenset({"time"}))
        if (scenario.process, one) in CORRECTIONS and said.objective not in known_here:
            yield Fault(("correct", "objective"), f"{said.objective} is not there yet for change: {one} of process: "
                        f"{scenario.process}; there is {', '.join(sorted(known_here))}")  # fmt: skip
            break
    program = getattr(scenario, "program", None)
    if unroll and program is None:
        yield Fault((), "there is no program whose loops and subprograms could be written out", file="--unroll")
    seen: dict[Fault, None] = {}
    for one in said.change:
        if (scenario.process, one) in CORRECTIONS:
            seen |= dict.fromkeys(refusals_of(scenario.process, one, scenario, said, unroll))
    yield from seen


def _reads(process: str, change: str) -> frozenset[str]:
    """Keys of the section that a change of a process reads."""
    return READ.get((process, change), KEYS[change])


def _unread(process: str, said: Correction) -> dict[str, list[str]]:
    """Keys that are written and that none of the changes asked for reads, each with the changes of the process that do."""
    there = changes_of(process)
    read = frozenset[str]().union(*(_reads(process, one) for one in said.change if one in there))
    return {key: [one for one in there if key in _reads(process, one)] for key in sorted(said.model_fields_set - read)}


def _judged(task: Task, proposals: Sequence[Proposal], after: Result) -> Corrected:
    """The proposals of all corrections and the last simulation as one answer."""
    last, before = proposals[-1], task.before
    values: dict[str, tuple[float, str]] = {}
    for one in proposals:
        values.update(one.measures)
    for name in sorted(before.measures.keys() & after.measures.keys()):
        if f"{name}_before" not in values:
            dimension = before.measures[name].dimension
            values[f"{name}_before"] = before.measures[name].value, dimension
            values[f"{name}_after"] = after.measures[name].value, dimension
    reasons = [text for one in proposals for text in one.kept]
    reasons += [f"{check.measure} misses its requirement" for check in after.checks if not check.passed]
    reasons += [_unsound(finding.code, task.said) for finding in after.unsound]
    reasons += list(after.infeasible)
    program = getattr(last.scenario, "program", None)
    return Corrected(
        "" if program is None else program.text,
        last.scenario,
        before,
        after,
        tuple(change for one in proposals for change in one.changes),
        (*(_row(result) for result in (before, after)), *(row for one in proposals for row in one.front)),
        measured(values),
        tuple(
            dict.fromkeys(
                [
                    *(text for one in proposals for text in one.told),
                    *(
                        f"correct.{key} is not used: it belongs to change: {' or '.join(users)}"
                        for key, users in _unread(task.scenario.process, task.said).items()
                    ),
                ]
            )
        ),
        tuple(dict.fromkeys(reasons)),
        tuple(along for one in proposals for along in one.along),
    )


def _unsound(code: str, said: Correction) -> str:
    """Why the new program is nothing to go by."""
    helps = (
        "; change: [speed, feed] looks for a stable speed" if code == "unstable" and "speed" not in said.change else ""
    )
    return f"the new program is not sound ({code}): {SOUNDNESS[code]}{helps}"


def _row(result: Result) -> dict[str, float]:
    """A simulated proposal by its measures."""
    found: dict[str, Measure] = dict(result.measures)
    return {name: one.value for name, one in found.items()}
