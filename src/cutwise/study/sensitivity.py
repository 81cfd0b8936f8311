"""Which assumed value moves the result most."""

from collections.abc import Iterator, Mapping, Sequence

from cutwise.io.revision import Value, revisions
from cutwise.process.recipes import coarser
from cutwise.results import Check
from cutwise.spec import fields
from cutwise.spec.faults import dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.batch import batch
from cutwise.study.case import cases, faithful

STEP = 0.1  # relative change of a value

Amount = float | tuple[float, ...]
Variants = Mapping[str, Sequence[Mapping[str, float]]]


def assumed_sensitivity(scenario: Scenario, share: float = STEP) -> dict[str, float]:
    r"""Change of the focus measure when an assumed value is off by a tenth, largest first.

    The larger of :math:`|m(1.1 v) - m(v)|` and :math:`|m(0.9 v) - m(v)|`, with its sign, by running again; values that
    are zero, no numbers, or that the scenario refuses to change alone are left out. The runs take the coarse step of
    studies where that gives the focus measure of the run (:data:`cutwise.study.case.TOLERANCE`), its own elsewhere.

    Parameters
    ----------
    scenario : Scenario
        The scenario, with the origins of its values.
    share : float
        Relative change.

    Returns
    -------
    dict
        Dotted key: change of the focus measure [SI].
    """
    base, found = variants(scenario, share)
    return changes_of(scenario.focus, base, found)


def variants(scenario: Scenario, share: float = STEP, jobs: int = 1) -> tuple[Mapping[str, float], Variants]:
    """All measures as it stands, and with each assumed value off by a share, down and up, all with one step."""
    start, coarse = cases(scenario)({}), False
    if coarser(scenario):
        quick = cases(scenario, coarse=True)({})
        if faithful(scenario, quick.measures, start.measures, (*scenario.requirements, scenario.focus)):
            start, coarse = quick, True
    moved = [
        (key, _scaled(value, factor))
        for key, value, _ in assumed_quantities(scenario)
        for factor in (1.0 - share, 1.0 + share)
    ]
    found: dict[str, list[Mapping[str, float]]] = {key: [] for key, _ in moved}
    runs = batch(scenario, [{key: value} for key, value in moved], coarse=coarse, jobs=jobs)
    for (key, _), case in zip(moved, runs, strict=True):
        if case.failure is None:
            found[key].append(case.measures)
    return start.measures, found


def changes_of(measure: str, base: Mapping[str, float], found: Variants) -> dict[str, float]:
    """The larger change of a measure in the runs with each assumed value off, largest first [SI]."""
    if measure not in base:
        return {}
    changes = {key: [run[measure] - base[measure] for run in runs if measure in run] for key, runs in found.items()}
    largest = {key: max(one, key=abs) for key, one in changes.items() if one}
    return dict(sorted(largest.items(), key=lambda item: -abs(item[1])))


def worst_off(check: Check, found: Variants) -> tuple[str, float] | None:
    """The assumed value that, off by a share, carries a requirement's measure farthest towards another verdict."""
    ends = [(end, sign) for end, sign in ((check.maximum, 1.0), (check.minimum, -1.0)) if end is not None]
    runs = [(key, run[check.measure]) for key, some in found.items() for run in some if check.measure in run]
    if not runs or check.value is None:
        return None
    sense = 1.0 if check.keeps(check.value) else -1.0
    return max(runs, key=lambda run: sense * max(sign * (run[1] - end) for end, sign in ends))


def changed(scenario: Scenario, values: Mapping[str, Value]) -> Scenario:
    """The scenario with some values replaced, checked as a whole.

    Raises
    ------
    ScenarioFault
        The values do not fit the others.
    """
    return revisions(scenario)(values)


def assumed_quantities(scenario: Scenario) -> Iterator[tuple[str, Amount, str]]:
    """Assumed values that are quantities other than zero: dotted key, value in SI, dimension; or several as one."""
    for path, info, value in fields.leaves(scenario):
        key = dotted(path)
        origin = scenario.origins.get(key)
        dimension = fields.dimension(info)
        if origin is not None and origin.status == "assumed" and dimension and _is_amount(value):
            yield key, value, dimension


def _is_amount(value: object) -> bool:
    if isinstance(value, tuple):
        return bool(value) and all(isinstance(entry, float) for entry in value) and any(value)
    return isinstance(value, float) and value != 0.0


def _scaled(value: Amount, factor: float) -> Amount:
    return tuple(factor * entry for entry in value) if isinstance(value, tuple) else factor * value
