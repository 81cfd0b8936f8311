"""A study file: read as written, every fault at its line, all at once."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from cutwise import units
from cutwise.io.files import as_text, read_bytes
from cutwise.io.revision import Value, revisions
from cutwise.io.scenario import load, read_document
from cutwise.io.tree import Node, compose
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario
from cutwise.study.many.aims import measures_of, search_of
from cutwise.study.many.consistency import goes_together, idle, moved_once, too_many
from cutwise.study.many.definition import (
    GRID,
    INDICES,
    METHODS,
    MORRIS,
    OPTIMISE,
    RARE,
    SEARCHES,
    SOBOL,
    Budget,
    Stop,
    Study,
    at_setting,
    in_the_middle,
)  # fmt: skip
from cutwise.study.many.draws import NETS, next_size
from cutwise.study.many.levers import Faults, Levers, levers_of, share_beyond
from cutwise.study.many.rarely import size_of_level
from cutwise.study.many.relations import cut_off, few_degrees, relations_of

_KEYS = (
    "name", "scenario", "set", "vary", "correlated", "want", "method", "cases", "seed", "coarse", "stop", "budget", "levels",
    "minimise", "maximise", "robust", "points",
)  # fmt: skip
_SEEDS = 2**64
_BEYOND = 1e-9  # share of a distribution that may lie beyond what its key allows


def read_study(
    path: Path, overrides: Sequence[str] = (), *, cases: int | None = None, seed: int | None = None
) -> Study:  # fmt: skip
    """The study of a file; overrides are those of its scenario.

    Raises
    ------
    ScenarioFault
        Everything that is wrong with it.
    """
    tree, wrong = compose(as_text(read_bytes(path, str(path)), str(path)), str(path))
    return study_of(tree, wrong, path, overrides, cases=cases, seed=seed)


def study_of(
    tree: Node | None, wrong: Sequence[Fault], path: Path, overrides: Sequence[str] = (), *, cases: int | None = None,
    seed: int | None = None, of: Scenario | None = None,
) -> Study:  # fmt: skip
    """The study of a tree; files are named beside ``path``. ``of``: the scenario, where the tree names none."""
    if tree is None or not isinstance(tree.value, dict):
        raise ScenarioFault(
            list(wrong) or [Fault((), "holds no study: write scenario, vary and method", file=str(path))]
        )
    faults = Faults()
    faults.found += wrong
    for key, node in tree.value.items():
        if key in _KEYS:
            continue
        near = get_close_matches(key, _KEYS, n=1)
        hint = f"; did you mean {near[0]}?" if near else f"; a study has {', '.join(_KEYS)}"
        faults.at(node, (key,), f"unknown key{hint}", at_key=True)
    scenario = _scenario(tree, path, overrides, faults) if of is None else of
    if scenario is None:
        _alone(tree, faults)
        raise ScenarioFault(faults.found)
    study = _study(tree, scenario, path, overrides, faults, cases=cases, seed=seed)
    if faults.found or study is None:
        raise ScenarioFault(faults.found)
    return study


def _alone(tree: Node, faults: Faults) -> None:
    """Faults of what can be read without the scenario."""
    method = _word(tree, "method", METHODS, SOBOL, faults)
    for key, least in (("cases", 1), ("seed", 0), ("levels", 2)):
        _count(tree, key, least, faults, least=least)
    _stop(tree, faults)
    _budget(tree, method, faults)


def is_study(path: Path) -> bool:
    """Whether a file is a study and no scenario: it names one, and what varies."""
    try:
        tree, _ = compose(as_text(read_bytes(path, str(path)), str(path)), str(path))
    except ScenarioFault:
        return False
    return tree is not None and isinstance(tree.value, dict) and "scenario" in tree.value and "vary" in tree.value


def _scenario(tree: Node, path: Path, overrides: Sequence[str], faults: Faults) -> Scenario | None:
    node = tree.value.get("scenario")
    if node is None or not isinstance(node.value, str):
        faults.at(
            tree if node is None else node,
            ("scenario",),
            "missing; name the scenario file, for example scenario: deburr.yaml",
        )
        return None
    given = _plain_map(tree, "set", faults)
    try:
        return load(path.parent / node.value, [*(f"{key}={value}" for key, value in given.items()), *overrides])
    except ScenarioFault as why:
        faults.found += why.faults
        return None


def _plain_map(tree: Node, key: str, faults: Faults) -> dict[str, str]:
    node = tree.value.get(key)
    if node is None:
        return {}
    if not isinstance(node.value, dict):
        faults.at(node, (key,), "expected keys and values, for example {operation.feed: 80 mm/s}")
        return {}
    return {name: one.text or json.dumps(one.plain()) for name, one in node.value.items()}


def _study(
    tree: Node,
    scenario: Scenario,
    path: Path,
    overrides: Sequence[str],
    faults: Faults,
    *,
    cases: int | None,
    seed: int | None,
) -> Study | None:
    levers = levers_of(tree, scenario, path.parent, faults)
    relations = relations_of(tree, scenario, levers, faults)
    random = levers.random
    method = _word(tree, "method", METHODS, SOBOL if random else GRID, faults)
    goes_together(tree, scenario, levers, method, bool(relations), faults)
    moved_once(tree, overrides, levers, faults)
    wanted = cases if cases is not None else _count(tree, "cases", 2000 if method == RARE else 1024, faults)
    measures, demanded = _wants(tree, scenario, faults, method, scatters=bool(random))
    chosen = seed if seed is not None else _count(tree, "seed", 0, faults, least=0)
    if chosen >= _SEEDS:
        faults.at(tree.value.get("seed", tree), ("seed",), f"{chosen} is too large: a seed has 64 bits")
    stop, budget = _stop(tree, faults), _budget(tree, method, faults)
    levels = _count(tree, "levels", 4, faults, least=2)
    draws = _rounded(method, wanted) if random else 1
    search = None
    if method == OPTIMISE:
        runs = None if budget is None or budget.cases is None else max(1, budget.cases // draws)
        search = search_of(tree, scenario, levers, runs, faults)
        aimed = (name for aim in search.aims for name in measures_of(aim, type(scenario).measures))
        measures = tuple(dict.fromkeys((*measures, *aimed)))
    name = _name(tree, path, faults)
    given = tuple(f"{key}={value}" for key, value in _plain_map(tree, "set", faults).items())
    curved = _with_curves(scenario, levers, chosen, faults)
    coarse = _coarse(tree, curved, faults)
    if faults.found:
        return None
    found = Study(
        name, curved,
        coarse, {} if search else levers.design, random, method, draws, chosen, measures, demanded, stop, levels,
        _source(tree, path, scenario), (*given, *overrides), relations, search, budget,
    )  # fmt: skip
    too_many(found, tree, faults)
    _allowed(found, tree, faults)
    return found


def _name(tree: Node, path: Path, faults: Faults) -> str:
    """The name of a study, after which its folder is called."""
    node = tree.value.get("name")
    if node is None:
        return path.stem
    name = str(node.plain())
    if isinstance(node.value, dict | list) or node.value is None or not name.strip() or set(name) & set("/\\\n\0"):
        faults.at(node, ("name",), "expected a name without slashes: the folder of the study is called after it")
    return name


def _source(tree: Node, path: Path, scenario: Scenario) -> str:
    """Where the scenario of a study stands, as a command names it."""
    return str(path.parent / tree.value["scenario"].value) if "scenario" in tree.value else scenario.name


def _with_curves(scenario: Scenario, levers: Levers, seed: int, faults: Faults) -> Scenario:
    """The scenario with the random curves of the study, those of its case 0."""
    places = {key: place for place, key in enumerate(levers.random)}
    texts = {
        key: f"{{{text}, seed: {seed}, lever: {places[key]}, case: 0}}" for key, text in levers.curves.items()
    }  # fmt: skip
    if not texts:
        return scenario
    try:
        return read_document(scenario.document(), scenario.name, texts)
    except ScenarioFault as why:
        faults.found += why.faults
        return scenario


def _budget(tree: Node, method: str, faults: Faults) -> Budget | None:
    node = tree.value.get("budget")
    if node is None:
        return None
    given = node.plain() if isinstance(node.value, dict) else {}
    cases, seconds = given.get("cases"), None
    try:
        seconds = units.parse(given["time"], "time") if "time" in given else None
    except units.UnitFault as why:
        faults.at(node, ("budget", "time"), str(why))
    counted = cases is None or (isinstance(cases, int) and not isinstance(cases, bool) and cases > 0)
    if not given or given.keys() - {"cases", "time"} or not counted or (seconds is not None and seconds <= 0.0):
        faults.at(node, ("budget",), "expected for example {time: 30 min} or {cases: 20000}")
        return None
    if seconds is not None and method in SEARCHES:
        faults.at(node, ("budget", "time"), f"{method} is limited by cases, so that it ends the same on every machine")
    if cases is not None and method == RARE:
        faults.at(node, ("budget", "cases"), "rare takes cases at each level (cases), as many levels as it needs")
    return Budget(cases, seconds)


def _rounded(method: str, wanted: int) -> int:
    return (
        next_size(wanted, NETS)
        if method in (SOBOL, OPTIMISE)
        else next_size(wanted, 1)
        if method == INDICES
        else wanted
    )


def _count(tree: Node, key: str, usual: int, faults: Faults, *, least: int = 1) -> int:
    node = tree.value.get(key)
    if node is None:
        return usual
    if isinstance(node.value, bool) or not isinstance(node.value, int) or node.value < least:
        faults.at(node, (key,), f"{node.text or node.plain()} is no whole number from {least} on")
        return usual
    return int(node.value)


def _word(tree: Node, key: str, known: Sequence[str], usual: str, faults: Faults) -> str:
    node = tree.value.get(key)
    if node is None:
        return usual
    if node.value not in known:
        faults.at(node, (key,), f'"{node.text or node.plain()}" is not one of {", ".join(known)}')
        return usual
    return str(node.value)


def _stop(tree: Node, faults: Faults) -> Stop | None:
    node = tree.value.get("stop")
    if node is None:
        return None
    given = node.plain() if isinstance(node.value, dict) else {}
    unknown = given.keys() - {"half_width", "level", "at_least"}
    width, level, least = given.get("half_width"), given.get("level", 0.95), given.get("at_least", 1024)
    numbers = all(isinstance(x, int | float) and not isinstance(x, bool) for x in (width, level, least))
    if unknown or not numbers or not (0.0 < width < 0.5 and 0.5 < level < 1.0 and least >= 1):
        faults.at(node, ("stop",), "expected for example {half_width: 0.01, level: 0.95, at_least: 1024}; a study that "
                  "stops when its interval clears a limit would be wrong half of the time")  # fmt: skip
        return None
    return Stop(float(width), float(level), int(least))


def _wants(
    tree: Node, scenario: Scenario, faults: Faults, method: str, *, scatters: bool
) -> tuple[tuple[str, ...], float | None]:
    """Measures besides those of the requirements, and the share of good cases that is demanded."""
    node = tree.value.get("want")
    known, asked, demanded = type(scenario).measures, list(scenario.asked), None
    if node is None:
        return tuple(asked or ([scenario.focus] if scenario.focus else [])), None
    if not isinstance(node.value, dict):
        faults.at(node, ("want",), "expected for example {measures: [cutting_power_mean], probability: {min: 0.99}}")
        return tuple(asked), None
    for key, one in node.value.items():
        if key == "measures":
            names = one.plain() if isinstance(one.value, list) else [one.plain()]
            for name in known if names == ["all"] else names:
                if not isinstance(name, str) or name not in known:
                    near = get_close_matches(str(name), list(known), n=1)
                    faults.at(
                        one,
                        ("want", "measures"),
                        f"{name}: unknown measure{f'; did you mean {near[0]}?' if near else ''}",
                    )
                asked.append(str(name))
        elif key == "probability":
            given = one.plain()
            demanded = given.get("min") if isinstance(given, dict) else None
            alone = isinstance(given, dict) and given.keys() == {"min"}
            if not alone or not isinstance(demanded, float | int) or not 0.0 < demanded < 1.0:
                faults.at(one, ("want", "probability"), "expected a share between 0 and 1, for example {min: 0.99}")
            if method == OPTIMISE:
                faults.at(one, ("want", "probability"), "of an optimum it is asked for by robust: {probability: 0.99}")
            elif method == MORRIS:
                faults.at(
                    one,
                    ("want", "probability"),
                    "the points of morris are levels of a plan, no draws: take sobol or indices",
                )
            elif not scenario.asked:
                faults.at(one, ("want", "probability"), "there are no requirements, so no case is good or bad")
            elif not scatters:
                faults.at(one, ("want", "probability"), "nothing scatters (vary), so there is no share of anything")
        else:
            words = (
                "is not in this version: method: indices"
                if key == "indices"
                else "unknown; write measures or probability"
            )
            faults.at(one, ("want", key), words, at_key=True)
    return tuple(dict.fromkeys(asked or ([scenario.focus] if scenario.focus else []))), demanded


def _coarse(tree: Node, scenario: Scenario, faults: Faults) -> Scenario | None:
    """The scenario with the step of the bulk of the cases; None: none, or that of quick runs."""
    given = _plain_map(tree, "coarse", faults)
    others = [key for key in given if not key.startswith("numerics.")]
    for key in others:
        faults.at(
            tree.value["coarse"].value[key], ("coarse", key),
            "is no numerics: the bulk of the cases may have a larger step, but has to be of the same scenario (set)", at_key=True,
        )  # fmt: skip
    if not given or others:
        return None
    try:
        return read_document(scenario.document(), scenario.name, given)
    except ScenarioFault as why:
        faults.found += [
            fault._replace(file=f"coarse: {fault.file}") if hasattr(fault, "_replace") else fault
            for fault in why.faults
        ]
        return None


def _allowed(study: Study, tree: Node, faults: Faults) -> None:
    """Every distribution lies where its key may, and the ends of all levers make scenarios that can be run."""
    revised = revisions(study.scenario)
    middle = in_the_middle(study)
    of_entries = {key for key in study.random if key not in tree.value.get("vary", tree).value}
    for key, lever in middle.random.items():
        if lever.curve:
            continue
        node = tree.value["correlated"] if key in of_entries else tree.value["vary"].value[key]
        if not lever.words:
            share = share_beyond(study.scenario, key, lever)
            if share > _BEYOND:
                faults.at(
                    node,
                    ("vary", key),
                    f"{100 * share:.2g} % of it lies beyond what {key} may be: add for example within: [0 mm, null]",
                )
                continue
        if key not in of_entries:
            for value in lever.words or lever.of(np.array([1e-3, 0.5, 1 - 1e-3])):
                _tried(revised, key, value, node, faults)
    for key, design in study.design.items():
        for value in dict.fromkeys(design.values):
            _tried(revised, key, value, tree.value["vary"].value[key], faults)
    for key, one in study.search.between.items() if study.search else ():
        ends = one.words if one.words else (one.value(one.low), one.value(one.high))
        for value in dict.fromkeys(ends):
            _tried(revised, key, value, tree.value["vary"].value[key], faults)
        if not one.words and key in study.random:
            for value in ends:
                lever = at_setting(study, {key: value}).random[key]
                share = share_beyond(study.scenario, key, lever)
                if share > _BEYOND:
                    faults.at(
                        tree.value["vary"].value[key], ("vary", key),
                        f"at {value:g} (SI) {100 * share:.2g} % of its scatter lies beyond what {key} may be: move the ends in",
                    )  # fmt: skip


def _tried(
    revised: Callable[[Mapping[str, Value]], Scenario], key: str, value: Value, node: Node, faults: Faults
) -> None:
    try:
        revised({key: value})
    except ScenarioFault as why:
        said = {str(fault.message) for fault in faults.found}
        for fault in why.faults:
            if fault.message not in said:
                faults.at(node, ("vary", key), fault.message)


def told(study: Study) -> Iterator[str]:
    """What a study will do, in words."""
    if study.search is not None:
        tried = "at most " + f"{study.search.runs:,}" if study.search.runs is not None else "about a hundred or two"
        cases = f", {study.draws:,} cases at each (seed {study.seed})" if study.random else ""
        yield f"optimisation of {', '.join(study.search.between)}: {tried} settings{cases}"
    elif study.method == RARE:
        yield f"rare failures: {size_of_level(study.draws):,} cases at each level of subset simulation, seed {study.seed}"
    else:
        seed = f", seed {study.seed}" if study.random else ""
        yield f"{study.cases:,} cases: {study.rows:,} draws{seed}" + (
            f" at each of {study.combinations} combinations" if study.design else ""
        )
    yield from idle(in_the_middle(study))
    yield from cut_off(study.scenario, study.random)
    few = few_degrees(study.scenario, study.correlated)
    if few:
        yield few
