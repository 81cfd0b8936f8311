"""Commands for many cases: a study is begun, gone on with, shared with other machines, and told in words."""

import json
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutwise import units
from cutwise.app import outputs
from cutwise.app.exits import OK, REQUIREMENT_FAILED, SOLVER_FAILED, refuse
from cutwise.app.options import Overrides

if TYPE_CHECKING:
    import numpy as np

    from cutwise.study.many.answers import Answers
    from cutwise.study.many.definition import Study

_SHOWN = 3  # worst cases
_REASONS = 5  # of failures

StudyFile = Annotated[Path, typer.Argument(metavar="FILE", help="study (YAML): a scenario, and what varies in it")]


def study(
    file: StudyFile,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="its folder; default NAME-study")
    ] = None,
    overrides: Overrides = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, metavar="N", help="processes")] = 1,
    resume: Annotated[bool, typer.Option("--resume", help="go on with the cases that are there")] = False,
    cases: Annotated[int | None, typer.Option("--cases", min=1, metavar="N", help="draws, instead of those of the file")] = None,
    seed: Annotated[int | None, typer.Option("--seed", min=0, metavar="N", help="seed, instead of that of the file")] = None,
    table: Annotated[Path | None, typer.Option("--table", metavar="FILE", help="write all cases as .csv, SI with units")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI) and nothing else")] = False,
) -> None:  # fmt: skip
    """Run a scenario many times over what varies: how likely is a good part, what decides it, which cases are worst."""
    from cutwise.app.console import Console
    from cutwise.study.many import engine
    from cutwise.study.many.definition import OPTIMISE, RARE
    from cutwise.study.many.reading import read_study, told

    planned = read_study(file, overrides or (), cases=cases, seed=seed)
    folder = output or Path(f"{planned.name}-study")
    outputs.checked([table], [file, *planned.scenario.files])
    if table is not None and table.suffix != ".csv":
        refuse(f"{table}: write a .csv file")
    console = Console()
    for line in told(planned):
        console.err.print(line, markup=False)
    if planned.method == OPTIMISE:
        _optimised(planned, folder, table, jobs=jobs, resume=resume, as_json=as_json)
        return
    if planned.method == RARE:
        _rarely(planned, folder, table, jobs=jobs, resume=resume, as_json=as_json)
        return
    with console.progress(planned.name) as show:
        ran = engine.run_study(planned, folder, jobs=jobs, resume=resume, progress=lambda done, of: show(done / of))
    _tell(planned, folder, ran.stopped, table, as_json=as_json)


def checked(file: Path, overrides: Sequence[str]) -> bool:
    """Check a study file and say what it would do; False if it is no study but a scenario."""
    if not file.is_file() or "\nvary:" not in "\n" + file.read_text(encoding="utf-8", errors="replace"):
        return False  # most files: nothing of studies is imported for them
    from cutwise.study.many.reading import is_study, read_study, told

    if not is_study(file):
        return False
    planned = read_study(file, overrides)
    print(f"{file}: no fault (study of {planned.scenario.name}, {planned.scenario.process})")
    for line in told(planned):
        print(line)
    return True


def worker(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="folder of a study that was begun, seen by this machine")],
    for_time: Annotated[
        str | None, typer.Option("--time", metavar="TIME", help="begin nothing new after, for example '50 min'")
    ] = None,
) -> None:  # fmt: skip
    """Do parts of a study, on any machine that sees its folder, until nothing is left."""
    from cutwise.app.console import Console
    from cutwise.study.many import engine

    until = None
    if for_time is not None:
        try:
            until = time.monotonic() + units.parse(for_time, "time")
        except units.UnitFault as why:
            refuse(f"--time: {why}")
    with Console().progress(str(folder)) as show:
        done = engine.work(folder, until=until, progress=lambda done, of: show(done / of))
    print(f"{done:,} cases done here")


def _optimised(
    planned: "Study", folder: Path, table: Path | None, *, jobs: int, resume: bool, as_json: bool
) -> None:  # fmt: skip
    """Look for the best setting, and tell it."""
    from cutwise.app import optimum_text
    from cutwise.app.console import Console
    from cutwise.app.optimum_page import page
    from cutwise.disk import write_text
    from cutwise.study.many.best import optimised

    with Console().progress(planned.name) as show:
        found = optimised(planned, folder, jobs=jobs, resume=resume, progress=lambda done, _: show(done / (done + 100)))
    lines = list(optimum_text.said(found))
    report = write_text(folder / "report.html", page(found, lines))
    if table is not None:
        write_text(table, optimum_text.as_table(found))
    _print(lines, optimum_text.as_object(found, {"report": str(report)}), report, as_json=as_json)
    if not found.optimum.met and all(one.measures == {} for one in found.tried):
        raise typer.Exit(SOLVER_FAILED)
    raise typer.Exit(OK if found.proven else REQUIREMENT_FAILED)


def _rarely(
    planned: "Study", folder: Path, table: Path | None, *, jobs: int, resume: bool, as_json: bool
) -> None:  # fmt: skip
    """Find how rare failures are, and tell it."""
    from cutwise.app import rare_text
    from cutwise.app.console import Console
    from cutwise.disk import write_text
    from cutwise.study.many.rarely import rarely

    each = planned.draws
    with Console().progress(planned.name) as show:
        found = rarely(planned, folder, jobs=jobs, resume=resume, progress=lambda done, _: show(done / (done + each)))
    lines = list(rare_text.said(found))
    report = write_text(folder / "report.html", rare_text.page(found, lines))
    if table is not None:
        write_text(table, table_of(planned, found.table))
    _print(lines, rare_text.as_object(found, {"report": str(report)}), report, as_json=as_json)
    if sum(found.failed.values()) == found.done:
        raise typer.Exit(SOLVER_FAILED)
    raise typer.Exit(OK if found.demanded in (None, True) else REQUIREMENT_FAILED)


def _print(lines: Sequence[str], answer: dict[str, object], report: Path, *, as_json: bool) -> None:
    """One JSON object, or the lines and where the page is."""
    from cutwise.app.console import Console

    if as_json:
        print(json.dumps(answer, allow_nan=False))
        return
    console = Console()
    for line in lines:
        console.line(line)
    print(f"report: {report}")


def _tell(
    planned: "Study", folder: Path, stopped: str, table: Path | None, *, as_json: bool
) -> None:  # fmt: skip
    from cutwise.app.study_page import page
    from cutwise.disk import write_text
    from cutwise.study.many import folder as at
    from cutwise.study.many.answers import answers, demanded

    known = at.identity_in(folder)
    assert known is not None
    found = answers(planned, folder, int(known["chunk"]))
    lines = [
        *([f"stopped at {found.done:,} of {planned.cases:,}: {stopped}"] if stopped else []),
        *said(found),
    ]
    report = write_text(folder / "report.html", page(found, lines))
    if table is not None:
        write_text(table, as_table(found))
    _print(lines, as_object(found, stopped, {"report": str(report)}), report, as_json=as_json)
    asked = demanded(found)
    if found.count_failed == found.done:
        raise typer.Exit(SOLVER_FAILED)
    raise typer.Exit(OK if asked is None or asked[0] else REQUIREMENT_FAILED)


def said(found: "Answers") -> Iterator[str]:
    """What a study says, in a few lines."""
    from cutwise.study.many.answers import command, demanded, shown, worst
    from cutwise.study.many.cases import GOOD
    from cutwise.study.many.statements import Indices

    planned, failed = found.study, found.count_failed
    state, finer = found.table["state"], int(found.table["finer"].sum())
    for values, share in found.shares:
        at = ", ".join(f"{key} {shown(planned, key, value)}" for key, value in values.items())
        ended = found.done - failed
        of = f" of the {ended:,} cases that came to an end" if failed else ""
        yield (
            f"{f'{at}: ' if at else ''}P(good) = {share.value:.3f} ({share.low:.3f} to {share.high:.3f} with "
            f"{100 * (planned.stop.level if planned.stop else 0.95):g} %){of}"
        )
    if planned.scenario.requirements and not found.shares:  # nothing scatters: no share of anything
        yield f"{int((state == GOOD).sum()):,} of {found.done:,} combinations meet the requirements, {failed or 'none'} failed"
    if found.shares:
        good = int((state == GOOD).sum())
        again = f", {finer} borderline cases run finer" if finer else ""
        yield f"{good:,} of {found.done:,} cases are good, {failed or 'none'} failed{again}"
        if failed:
            low, high = good / found.done, (good + failed) / found.done
            yield f"P(good) is {low:.3f} if all that failed are bad, {high:.3f} if all are good"
    wrong = [f"{100 * count / found.done:.1f} % {text}" for text, count in found.wrong.items() if count]
    if wrong:
        yield f"  {', '.join(wrong)}"
    for reasons, word in ((found.failed, "failed"), (found.infeasible, "infeasible")):
        for text, count in list(reasons.items())[:_REASONS]:
            yield f"  {count:,} {word}: {text}"
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
    asked = demanded(found)
    if asked is not None:
        yield asked[1]
    for case in worst(found, _SHOWN if planned.scenario.requirements else 1):
        measures = ", ".join(
            _measure(planned, name, found.table[f"measure {name}"][case]) for name in planned.measures[:3]
        )
        yield f"  worst: case {case}, {measures}: {command(found, case)}"
    if found.shares:
        yield "A share is about the model and these distributions, not about what they leave out."


def _measure(planned: "Study", name: str, value: float) -> str:
    if not math.isfinite(value):
        return f"{name} none"
    return f"{name} {units.show(value, planned.scenario.measures[name].dimension, 4)}"


def as_object(found: "Answers", stopped: str, files: dict[str, str]) -> dict[str, object]:
    """The answers as one JSON object, in the form of a run."""
    from cutwise.study.many.answers import demanded, measures

    planned, asked = found.study, demanded(found)
    told = {}
    for name, value in measures(found).items():
        if not math.isfinite(value):  # of no case at all
            continue
        base = next(
            (known for known in planned.scenario.measures if name.endswith(known) and name.startswith("quantile")), None
        )
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
        "warnings": [f"{count} failed: {text}" for text, count in found.failed.items()], "stopped": stopped, "files": files,
    }  # fmt: skip


def as_table(found: "Answers") -> str:
    """All cases of a study, one a line; SI with units in the titles."""
    return table_of(found.study, found.table)


def table_of(planned: "Study", table: Mapping[str, "np.ndarray"]) -> str:
    """Columns of cases as CSV, one case a line; SI with units in the titles."""
    import pandas as pd

    from cutwise.io.cells import harmless
    from cutwise.study.many.answers import dimension_of

    columns = {"case": table["case"]}
    for key in planned.keys:
        dimension = dimension_of(planned, key)
        columns[key if dimension is None else f"{key} [{units.DIMENSIONS[dimension].si}]"] = table[f"lever {key}"]
    for name in planned.measures:
        columns[f"{name} [{units.DIMENSIONS[planned.scenario.measures[name].dimension].si}]"] = table[f"measure {name}"]
    words = ("good", "bad", "infeasible", "failed")
    columns["state"] = [words[int(i)] for i in table["state"]]
    columns["said"] = [harmless(str(text)) for text in table["said"]]
    return pd.DataFrame(columns).to_csv(index=False, lineterminator="\n")
