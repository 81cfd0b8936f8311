"""A study file: read as written, every fault at its line, all at once."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from cutwise.io.files import as_text, read_bytes
from cutwise.io.revision import Value, revisions
from cutwise.io.scenario import load, read_document
from cutwise.io.tree import Node, compose
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario
from cutwise.study.many import asked
from cutwise.study.many.aims import measures_of, search_of
from cutwise.study.many.consistency import goes_together, idle, moved_once, too_many
from cutwise.study.many.definition import (
    GRID,
    METHODS,
    OPTIMISE,
    RARE,
    SOBOL,
    Study,
    at_setting,
    in_the_middle,
    of_indices,
)  # fmt: skip
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
    method = asked.word(tree, "method", METHODS, SOBOL, faults)
    for key, least in (("cases", 1), ("seed", 0), ("levels", 2)):
        asked.count(tree, key, least, faults, least=least)
    asked.stop(tree, faults)
    asked.budget(tree, method, faults)


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
    method = asked.word(tree, "method", METHODS, SOBOL if random else GRID, faults)
    goes_together(tree, scenario, levers, method, bool(relations), faults)
    moved_once(tree, overrides, levers, faults)
    wanted = cases if cases is not None else asked.count(tree, "cases", 2000 if method == RARE else 1024, faults)
    wanted_too = asked.wants(tree, scenario, faults, method, levers)
    measures = wanted_too.measures
    chosen = seed if seed is not None else asked.count(tree, "seed", 0, faults, least=0)
    if chosen >= _SEEDS:
        faults.at(tree.value.get("seed", tree), ("seed",), f"{chosen} is too large: a seed has 64 bits")
    stop, budget = asked.stop(tree, faults), asked.budget(tree, method, faults)
    levels = asked.count(tree, "levels", 4, faults, least=2)
    draws = asked.rounded(method, wanted) if random else 1
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
        coarse, {} if search else levers.design, random, method, draws, chosen, measures, wanted_too.demanded, stop, levels,
        _source(tree, path, scenario), (*given, *overrides), relations, search, budget, wanted_too.indices,
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
    if study.indices:
        yield f"and {of_indices(study).cases:,} runs that tell what decides: {study.indices:,} rows"
    yield from cut_off(study.scenario, study.random)
    few = few_degrees(study.scenario, study.correlated)
    if few:
        yield few
