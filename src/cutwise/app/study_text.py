"""What a study says: in a few lines, as JSON."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.study.many.answers import command, demanded, good_bands, measures, shown, worst
from cutwise.study.many.columns import row
from cutwise.study.many.statements import Indices

if TYPE_CHECKING:
    from cutwise.study.many.answers import Answers
    from cutwise.study.many.definition import Study
    from cutwise.study.many.held import Against

_SHOWN = 3  # worst cases
_QUANTILE = len("quantile_05_")
_REASONS = 5  # of failures


def said(found: "Answers") -> Iterator[str]:
    """What a study says, in a few lines."""
    planned, failed = found.study, found.count_failed
    good, finer = found.good, found.finer
    for values, share in found.shares:
        at = ", ".join(f"{key} {shown(planned, key, value)}" for key, value in values.items())
        ended = found.done - failed
        of = f" of the {ended:,} cases that came to an end" if failed else ""
        yield (
            f"{f'{at}: ' if at else ''}P(good) = {share.value:.3f} ({share.low:.3f} to {share.high:.3f} with "
            f"{100 * (planned.stop.level if planned.stop else 0.95):g} %){of}"
        )
    if planned.scenario.requirements and not found.shares:  # nothing scatters: no share of anything
        what = "runs" if planned.random else "combinations"
        yield f"{good:,} of {found.done:,} {what} meet the requirements, {failed or 'none'} failed"
    if found.shares:
        again = f", {finer} borderline cases run finer" if finer else ""
        yield f"{good:,} of {found.done:,} cases are good, {failed or 'none'} failed{again}"
        for (values, _), (bad, best) in zip(found.shares, found.if_failed, strict=bool(found.if_failed)):
            at = ", ".join(f"{key} {shown(planned, key, value)}" for key, value in values.items())
            yield (
                f"{f'{at}: ' if at else ''}P(good) is {bad.value:.3f} if all that failed are bad, {best.value:.3f} if all are "
                "good"
            )
    wrong = [f"{100 * count / found.done:.1f} % {text}" for text, count in found.wrong.items() if count]
    if wrong:
        yield f"  {', '.join(wrong)}"
    for reasons, word in ((found.failed, "failed"), (found.infeasible, "infeasible"), (found.unsound, "unsound")):
        for text, count in list(reasons.items())[:_REASONS]:
            where = f"; case {found.first[text]}: {command(found, found.first[text])}" if text in found.first else ""
            yield f"  {count:,} {word}: {text}{where}"
    for name, one in found.indices.items():
        each = zip(
            planned.factor_names,
            *((one.total, one.first) if isinstance(one, Indices) else (one.strength, one.mean)),
            strict=True,
        )
        words = ("total {:.2f}, alone {:.2f}") if isinstance(one, Indices) else "effect {:.3g}, mean {:.3g}"
        yield f"  what decides {name}: " + "; ".join(
            f"{key} {words.format(a, b)}" for key, a, b in sorted(each, key=lambda x: -abs(x[1]))
        )
    if found.indices:
        if failed:
            yield "  of what decides good, cases that failed count as bad"
        for name in planned.measures:
            if name not in found.indices:
                yield f"  what decides {name} is not told: there are cases that have no such number"
    asked = demanded(found)
    if asked is not None:
        yield asked[1]
    for band in good_bands(found):
        ends = [
            f"{shown(planned, band.key, end, 4)}{' (the last one studied)' if at_end else ''}"
            for end, at_end in ((band.low, band.open_low), (band.high, band.open_high))
        ]
        yield f"  it is reached with {band.key} from {ends[0]} to {ends[1]}, by the estimates, linear between settings"
    for case in worst(found, _SHOWN if planned.scenario.requirements else 1):
        values = row(found.table, case)
        measures = ", ".join(_measure(planned, name, float(values[f"measure {name}"])) for name in planned.measures[:3])
        yield f"  worst: case {case}, {measures}: {command(found, case)}"
    if found.shares:
        yield "A share is about the model and these distributions, not about what they leave out."


def held(found: "Answers", against: "Against") -> Iterator[str]:
    """What full runs of some cases say of the numbers of a study."""
    measures = found.study.scenario.measures
    changes = ", ".join(
        f"{name} {units.show(value, measures[name].dimension, 2)}" for name, value in against.changes.items()
    )
    if changes:
        yield f"cases {', '.join(map(str, against.cases))} run in full differ by at most {changes}"
    yield from (f"  run in full, it comes to no end: {text}" for text in against.lost)
    if against.too_coarse:
        yield from _coarse(against)


def _coarse(against: "Against") -> Iterator[str]:
    yield f"step too coarse: a full run differs by {100 * against.share:.2g} % of the tolerance; write a finer one under coarse"


def _measure(planned: "Study", name: str, value: float) -> str:
    if not math.isfinite(value):
        return f"{name} none"
    return f"{name} {units.show(value, planned.scenario.measures[name].dimension, 4)}"


def as_object(found: "Answers", against: "Against", stopped: str, files: dict[str, str]) -> dict[str, object]:
    """The answers as one JSON object, in the form of a run."""
    planned, asked = found.study, demanded(found)
    told = {}
    for name, value in measures(found).items():
        if not math.isfinite(value):  # of no case at all
            continue
        base = name[_QUANTILE:] if name.startswith("quantile_") else None
        dimension = planned.scenario.measures[base].dimension if base is not None else "dimensionless"
        told[name] = {"value": value, "unit": units.DIMENSIONS[dimension].si}
    over = [
        {"levers": values, "probability": {"value": s.value, "low": s.low, "high": s.high}}
        for values, s in found.shares
        if math.isfinite(s.value)
    ]
    return {
        "scenario": planned.name, "process": "study", "verdict": "none" if asked is None else "pass" if asked[0] else "fail",
        "measures": told, "combinations": over, "requirements": [], "assumed": [],
        "warnings": [
            *(f"{count} failed: {text}" for text, count in found.failed.items()), *(_coarse(against) if against.too_coarse else ()),
        ],
        "full_runs": {"cases": list(against.cases), "changes": against.changes, "lost": list(against.lost)},
        "stopped": stopped, "files": files,
    }  # fmt: skip
