"""Whether the parts of a study file fit each other: its method, what varies, and the keys that then count for nothing."""

from collections.abc import Iterator, Mapping, Sequence

from cutwise.io.tree import Node
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.notices import NOT_USED, notices
from cutwise.spec.scenario import Scenario
from cutwise.study.many.cases import case_of
from cutwise.study.many.definition import (
    GRID,
    HYPERCUBE,
    INDICES,
    MONTE_CARLO,
    MORRIS,
    OPTIMISE,
    RARE,
    SEARCHES,
    SOBOL,
    Study,
    of_indices,
)
from cutwise.study.many.levers import Faults, Levers

_MOST_CASES = 10**9
_MOST_AT_ONCE = 10**7  # of a plan whose points are made as a whole
_OF_OPTIMISE = ("minimise", "maximise", "robust", "points")


def goes_together(
    tree: Node, scenario: Scenario, levers: Levers, method: str, related: bool, faults: Faults
) -> None:  # fmt: skip
    """Faults of a method with what varies, and of keys that it does not use."""
    random = levers.random
    if method == GRID and random:
        faults.at(
            tree.value.get("method", tree), ("method",),
            f"grid takes values alone; {next(iter(random))} scatters: take sobol",
        )  # fmt: skip
    if method not in (GRID, SOBOL, MONTE_CARLO, OPTIMISE) and not random and "method" in tree.value:
        faults.at(tree.value["method"], ("method",), f"{method} needs something that scatters (vary)")
    if method != OPTIMISE:
        for key in levers.between:
            faults.at(tree.value["vary"].value[key], ("vary", key), "between belongs to method: optimise")
    curves = [key for key, lever in random.items() if lever.curve]
    if method == MORRIS and (related or curves):
        what = "inputs that are correlated" if related else "curves"
        faults.at(tree.value["method"], ("method",), f"morris moves one number at a time; of {what}, take indices")
    if method in (INDICES, MORRIS) and levers.design:
        faults.at(
            tree.value["method"], ("method",),
            f"{method} asks what decides at one setting; {next(iter(levers.design))} has several values: set one of them",
        )  # fmt: skip
    levels = tree.value.get("levels")
    if method == MORRIS and levels is not None and isinstance(levels.value, int) and levels.value % 2:
        faults.at(
            levels,
            ("levels",),
            f"{levels.value} is odd: a step of morris leads from one half of the levels to the other",
        )
    if method == RARE and levers.design:
        faults.at(
            tree.value["method"], ("method",),
            f"rare asks for one probability; {next(iter(levers.design))} has several values: set one of them",
        )  # fmt: skip
    if method == RARE and curves:
        faults.at(
            tree.value["method"],
            ("method",),
            f"rare moves single numbers: {curves[0]} is a curve of many; take a number",
        )
    if method == RARE and not scenario.asked:
        faults.at(tree.value["method"], ("method",), "there are no requirements, so no case fails them")
    _judged(tree, scenario, faults)
    _unused(tree, scenario, random, method, faults)


def _judged(tree: Node, scenario: Scenario, faults: Faults) -> None:
    """Limits that a single case cannot be held against."""
    for name, limit in scenario.requirements.items():
        if limit.whole_band:
            faults.at(
                tree.value.get("scenario", tree), ("scenario",),
                f"requirements.{name}.whole_band: a study judges the history of each case, not its whole band; set it false",
            )  # fmt: skip
        if limit.probability is not None:
            faults.at(
                tree.value.get("scenario", tree), ("scenario",),
                f"requirements.{name}.probability: a study counts its good cases, and a case keeps a limit or misses it; ask for "
                "want: {probability: {min: 0.99}}, and set it null",
            )  # fmt: skip


def _unused(tree: Node, scenario: Scenario, random: Mapping[str, object], method: str, faults: Faults) -> None:
    """Keys of a study that count for nothing beside the others."""
    unused = {
        "cases": "nothing scatters" if not random else "",
        "seed": "nothing scatters" if not random and method != OPTIMISE else "",
        "stop": "nothing scatters"
        if not random
        else f"{method} ends by itself"
        if method in (*SEARCHES, MORRIS)
        else "there are no requirements, so no case is good or bad"
        if not scenario.asked
        else "",
        "levels": "only morris has levels" if method != MORRIS and random else "nothing scatters" if not random else "",
        **dict.fromkeys(_OF_OPTIMISE, "only optimise looks for something" if method != OPTIMISE else ""),
    }
    told = bool(faults.found) and not random  # what would have scattered has a fault of its own
    for key, why in unused.items():
        if key in tree.value and why and not (told and why == "nothing scatters"):
            faults.at(tree.value[key], (key,), f"is not used: {why}", at_key=True)


def too_many(study: Study, tree: Node, faults: Faults) -> None:
    """Counts for which no time, room or points of a net are enough."""
    most = _MOST_AT_ONCE if study.method in (HYPERCUBE, MORRIS) else _MOST_CASES
    if study.cases > most:
        faults.at(
            tree.value.get("cases", tree), ("cases",),
            f"{study.cases:,} cases are too many: {study.method} takes {most:,} at most in one study",
        )  # fmt: skip
    if study.indices and of_indices(study).cases > _MOST_CASES:
        faults.at(
            tree.value["want"], ("want", "indices"),
            f"{of_indices(study).cases:,} runs are too many: a study takes {_MOST_CASES:,} at most",
        )  # fmt: skip


def moved_once(tree: Node, overrides: Sequence[str], levers: Levers, faults: Faults) -> None:
    """A value that is set, too, would be replaced in every case; one that scatters about it is not."""
    written = tree.value.get("vary")
    about = {
        key for key in levers.random.keys() - levers.between.keys()
        if written is not None and key in written.value and "offset" in written.value[key].value
    }  # fmt: skip
    varied = {*levers.design, *levers.between, *levers.random} - about
    words = "is set, and varies in every case: the value that is set would not be used; write one of the two"
    given = tree.value.get("set")
    for key in varied & set(given.value if given is not None and isinstance(given.value, dict) else ()):
        faults.at(given.value[key], ("set", key), words, at_key=True)
    for key in varied & {text.partition("=")[0].strip() for text in overrides}:
        faults.found.append(Fault((), words, file=f"--set {key}"))


def idle(study: Study) -> Iterator[str]:
    """Levers that change nothing, as the first case has them: a run says so of a key that it does not use."""
    try:
        first = case_of(study, 0)
    except ScenarioFault:  # that case fails, and says so among the others
        return
    for said in notices(first):
        key, _, why = said.partition(": ")
        if key in study.keys and why.startswith(NOT_USED):
            yield f"{key} varies, and {why}"
