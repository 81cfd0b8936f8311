"""Which assumed value moves the result most."""

from collections.abc import Iterator, Mapping

from cutwise.io.revision import Value, revisions
from cutwise.process.recipes import coarser
from cutwise.spec import fields
from cutwise.spec.faults import dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.case import cases, faithful

STEP = 0.1  # relative change of a value

Amount = float | tuple[float, ...]


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
    focus = scenario.focus
    evaluate = cases(scenario)
    start = evaluate({})
    if coarser(scenario):
        quick = cases(scenario, coarse=True)
        coarse = quick({})
        if faithful(scenario, coarse.measures, start.measures, (focus,)):
            evaluate, start = quick, coarse
    base = start.measures.get(focus)
    if base is None:
        return {}
    found: dict[str, float] = {}
    for key, value, _ in assumed_quantities(scenario):
        moved = (evaluate({key: _scaled(value, factor)}).measures.get(focus) for factor in (1.0 - share, 1.0 + share))
        changes = [other - base for other in moved if other is not None]
        if changes:
            found[key] = max(changes, key=abs)
    return dict(sorted(found.items(), key=lambda item: -abs(item[1])))


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
