"""What an optimisation says: in a few lines, as JSON, as a table of everything that was tried."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.disk import write_text
from cutwise.study.many import aims as worth
from cutwise.study.many.answers import dimension_of, rerun, shown
from cutwise.study.many.best import FRESH
from cutwise.study.many.tables import NoWriter

if TYPE_CHECKING:
    from cutwise.study.many.best import Best
    from cutwise.study.many.tried import Setting

_REASONS = 5


def said(found: "Best") -> Iterator[str]:
    """The answer, what it was held against, and the front."""
    study, best = found.study, found.optimum
    assert study.search is not None
    if found.unfinished:
        yield f"stopped after {found.done:,} settings: the best so far; --resume goes on"
    if not best.met:
        yield f"no setting of {found.done:,} that were tried meets the requirements{_as_often(best)}"
        yield f"nearest comes {settings(found, best)}: {_missed(found, best)}"
    else:
        yield f"best: {settings(found, best)}: {_aims(found, best)} ({found.done:,} settings tried)"
    for k, one in enumerate(found.optima):
        if one.asked is not None and one.fresh is not None:
            yield from _held(found, one, again=k > 0)
    if found.run is not None:
        yield f"run in full: {found.run.verdict}; {_told(found)}"
    for one in found.front:
        share = f", run in full: {one.verdict}"
        if one.fresh is not None:
            share = f", P(good) = {one.fresh.value:.3f} ({one.fresh.low:.3f} to {one.fresh.high:.3f}) of fresh cases"
        elif one.asked is not None:
            share = f", P(good) at least {one.asked:g}"
        yield f"  front: {settings(found, one)}: {_aims(found, one)}{share}"
    if found.front and best.asked is not None and best.fresh is None:
        yield f"the shares of this front are those of its own {study.draws:,} cases; fresh ones tell for one of them (robust)"
    for text, count in list(found.failed.items())[:_REASONS]:
        yield f"  {count:,} failed: {text}"
    yield f"again: {rerun(study, best.levers, exact=True)}"
    if best.asked is not None:
        yield "A share is about the model and these distributions, not about what they leave out."


def settings(found: "Best", one: "Setting") -> str:
    """Levers as people read them."""
    return ", ".join(f"{key} {shown(found.study, key, value)}" for key, value in one.levers.items())


def _aims(found: "Best", one: "Setting") -> str:
    assert found.study.search is not None
    told = []
    for aim, value in zip(found.study.search.aims, one.aims, strict=True):
        dimension, unit = worth.unit_of(aim, found.study.scenario)
        text = units.show(value, dimension, 6) if dimension else f"{value:.6g} {unit}".strip()
        told.append(f"{aim.text.removeprefix('cost: ')} {text}")
    return ", ".join(told)


def _as_often(one: "Setting") -> str:
    return "" if one.asked is None else f" with a probability of {one.asked:g}"


def _missed(found: "Best", one: "Setting") -> str:
    if one.share is not None:
        value, low, high = one.share
        return f"P(good) = {value:.3f} ({low:.3f} to {high:.3f}) of its own {found.study.draws:,} cases"
    each = ", ".join(
        f"{name} {units.show(one.measures[name], found.study.scenario.measures[name].dimension, 4)}"
        for name in found.study.scenario.asked
        if name in one.measures
    )
    return each or f"{100 * one.margin:.3g} % of a limit beyond it"


def _held(found: "Best", one: "Setting", *, again: bool) -> Iterator[str]:
    """A setting against fresh cases."""
    search = found.study.search
    assert search is not None
    assert one.fresh is not None
    least = search.probability[0]
    low, high = one.fresh.low, one.fresh.high
    verdict = "proven" if low >= least else "not so" if high < least else "cannot be told"
    first = f"searched again for P >= {one.asked:.4g}: " if again else ""
    yield (
        f"{first}{settings(found, one)}: {FRESH:,} fresh cases (seed {found.study.seed + 1}): P(good) = {one.fresh.value:.4f} "
        f"({low:.4f} to {high:.4f}); that it reaches {least:g}: {verdict}"
    )


def _told(found: "Best") -> str:
    run = found.run
    assert run is not None
    return ", ".join(
        f"{name} {units.show(run.measures[name].value, run.measures[name].dimension, 4)}"
        for name in found.study.measures
        if name in run.measures
    )


def as_object(found: "Best", files: dict[str, str]) -> dict[str, object]:
    """The answer as one JSON object, in the form of a run."""
    study, best = found.study, found.optimum
    assert study.search is not None
    aims = {
        "optimum_value" if k == 0 else f"optimum_value_{k + 1}": worth.unit_of(aim, study.scenario)[1]
        for k, aim in enumerate(study.search.aims)
    }
    levers = {f"optimum_{key}": units.DIMENSIONS[d].si for key in best.levers if (d := dimension_of(study, key))}
    si = {**aims, **levers}
    told: dict[str, dict[str, object]] = {
        name: {"value": value, "unit": si.get(name, "")} for name, value in found.measures.items()
    }
    told |= {
        f"optimum_{key}": {"value": value, "unit": ""} for key, value in best.levers.items() if isinstance(value, str)
    }
    return {
        "scenario": study.name, "process": "study", "verdict": "pass" if found.proven else "fail", "measures": told,
        "front": [_point(found, one) for one in found.front], "attempts": [_point(found, one) for one in found.optima],
        "stopped": "--resume goes on" if found.unfinished else "",
        "requirements": [], "assumed": [], "warnings": [f"{count} failed: {text}" for text, count in found.failed.items()],
        "files": files,
    }  # fmt: skip


def _point(found: "Best", one: "Setting") -> dict[str, object]:
    assert found.study.search is not None
    names = [aim.text for aim in found.study.search.aims]
    shares = {"share": one.share, "fresh": one.fresh}
    return {
        "levers": dict(one.levers), "aims": dict(zip(names, one.aims, strict=True)), "asked": one.asked,
        **({"verdict": one.verdict} if one.verdict else {}),
        **{name: {"value": s.value, "low": s.low, "high": s.high} for name, s in shares.items() if s is not None},
    }  # fmt: skip


def write_tried(found: "Best", target: Path) -> Path:
    """Write everything that was tried, one setting a line; SI with units in the titles.

    Raises
    ------
    NoWriter
        The ending says another kind of file.
    """
    import pandas as pd

    if target.suffix.lower() != ".csv":
        raise NoWriter("settings that were tried are a table: write .csv")
    study = found.study
    assert study.search is not None
    columns: dict[str, list[object]] = {}
    for key in study.search.between:
        dimension = dimension_of(study, key)
        title = key if dimension is None else f"{key} [{units.DIMENSIONS[dimension].si}]"
        columns[title] = [one.levers[key] for one in found.tried]
    for k, aim in enumerate(study.search.aims):
        unit = worth.unit_of(aim, study.scenario)[1]
        columns[f"{aim.text} [{unit}]"] = [one.aims[k] for one in found.tried]
    columns["margin"] = [one.margin for one in found.tried]
    return write_text(target, pd.DataFrame(columns).to_csv(index=False, lineterminator="\n"))
