"""Which assumed value moves the result most."""

from collections.abc import Iterator, Mapping

from cutwise import units
from cutwise.io.scenario import revised
from cutwise.process.recipes import quick_measures
from cutwise.results import SolverFailure
from cutwise.spec import fields
from cutwise.spec.faults import ScenarioFault, dotted
from cutwise.spec.scenario import Scenario

STEP = 0.1  # relative change of a value

Amount = float | tuple[float, ...]


def assumed_sensitivity(scenario: Scenario, share: float = STEP) -> dict[str, float]:
    r"""Change of the focus measure when an assumed value is off by a tenth, largest first.

    The larger of :math:`|m(1.1 v) - m(v)|` and :math:`|m(0.9 v) - m(v)|`, with its sign, by running again; values that
    are zero, no numbers, or that the scenario refuses to change alone are left out.

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
    base = _focus_with(scenario, {})
    if base is None:
        return {}
    found: dict[str, float] = {}
    for key, value, dimension in assumed_quantities(scenario):
        changes = []
        for factor in (1.0 - share, 1.0 + share):
            other = _focus_with(scenario, {key: _scaled(value, factor, dimension)})
            if other is not None:
                changes.append(other - base)
        if changes:
            found[key] = max(changes, key=abs)
    return dict(sorted(found.items(), key=lambda item: -abs(item[1])))


def _focus_with(scenario: Scenario, values: Mapping[str, str]) -> float | None:
    try:
        return quick_measures(changed(scenario, values) if values else scenario).get(scenario.focus)
    except (ScenarioFault, SolverFailure):
        return None


def changed(scenario: Scenario, values: Mapping[str, str]) -> Scenario:
    """The scenario with some values replaced, checked as a whole.

    Raises
    ------
    ScenarioFault
        The values do not fit the others.
    """
    return revised(scenario, [f"{key}={value}" for key, value in values.items()])


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


def _scaled(value: Amount, factor: float, dimension: str) -> str:
    """A value, or each of several, times a factor, as it is written in a scenario."""
    if isinstance(value, tuple):
        return f"[{', '.join(units.text(factor * entry, dimension) for entry in value)}]"
    return units.text(factor * value, dimension)
