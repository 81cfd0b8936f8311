"""Commands for many cases: a study is begun, gone on with, shared with other machines, and told in words."""

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from cutwise import units
from cutwise.app import outputs
from cutwise.app.exits import OK, REQUIREMENT_FAILED, SOLVER_FAILED, refuse
from cutwise.app.options import Overrides

if TYPE_CHECKING:
    from cutwise.study.many.best import Best
    from cutwise.study.many.columns import Columns
    from cutwise.study.many.definition import Study
    from cutwise.study.many.rarely import Rarely


Told = TypeVar("Told")
StudyFile = Annotated[Path, typer.Argument(metavar="FILE", help="study (YAML): a scenario, and what varies in it")]


def study(
    file: StudyFile,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="its folder; default NAME-study")
    ] = None,
    overrides: Overrides = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, metavar="N", help="processes")] = 1,
    executor: Annotated[
        str, typer.Option("--executor", metavar="local|dask", help="what starts the workers; dask is the extra 'distributed'")
    ] = "local",
    address: Annotated[
        str | None, typer.Option("--address", metavar="URL", help="of a dask scheduler, for example tcp://host:8786")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="go on with the cases that are there")] = False,
    accept_version: Annotated[
        bool, typer.Option("--accept-version", help="with --resume: go on with cases of another version of cutwise")
    ] = False,
    cases: Annotated[int | None, typer.Option("--cases", min=1, metavar="N", help="draws, instead of those of the file")] = None,
    seed: Annotated[int | None, typer.Option("--seed", min=0, metavar="N", help="seed, instead of that of the file")] = None,
    table: Annotated[Path | None, typer.Option("--table", metavar="FILE", help="write all cases as .csv, SI with units")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI) and nothing else")] = False,
) -> None:  # fmt: skip
    """Run a scenario many times over what varies: how likely is a good part, what decides it, which cases are worst."""
    from cutwise.app.console import Console
    from cutwise.app.live import Live
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
    more: dict[str, Any] = {
        "jobs": jobs, "resume": resume, "executor": executor, "address": address, "accept_version": accept_version
    }  # fmt: skip
    if planned.method in (OPTIMISE, RARE):
        (_optimised if planned.method == OPTIMISE else _rarely)(planned, folder, table, more, as_json=as_json)
        return
    with console.progress(planned.name) as show:
        live = Live(planned, folder, show)
        try:
            ran = engine.run_study(planned, folder, progress=live, **more)
        except KeyboardInterrupt:
            done = live.done()
            console.err.print(f"stopped at {done:,} of {planned.cases:,}; --resume goes on", markup=False)
            raise
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


def is_folder(path: Path) -> bool:
    """Whether a path is the folder of a study."""
    return path.is_dir() and (path / "identity.json").exists()


def reported(folder: Path, target: Path | None) -> None:
    """Tell what is there of the study in a folder, and write its page."""
    from cutwise.study.many.definition import OPTIMISE, RARE
    from cutwise.study.many.engine import in_folder

    planned, known = in_folder(folder)
    outputs.checked([target], [folder / "study.json"])
    page = target or folder / "report.html"
    if planned.method == OPTIMISE:
        from cutwise.study.many import best

        _tell_best(_there(folder, best.told, planned, known), page, None, as_json=False)
    elif planned.method == RARE:
        from cutwise.study.many import rarely

        _tell_rarely(_there(folder, rarely.told, planned, known), page, None, as_json=False)
    else:
        done = _there(folder, _columns, planned, known).count
        stopped = "" if done == planned.cases else "what is there now"
        _tell(planned, folder, stopped, None, as_json=False, target=target)


def exported(folder: Path, target: Path | None) -> None:
    """Write the cases of the study in a folder as one file; of an optimisation the settings that were tried."""
    from cutwise.study.many.definition import OPTIMISE, RARE
    from cutwise.study.many.engine import in_folder
    from cutwise.study.many.tables import NoWriter, write_table

    planned, known = in_folder(folder)
    file = target or folder / "cases.csv"
    outputs.checked([file], [folder / "study.json"])
    try:
        if planned.method == OPTIMISE:
            from cutwise.app.optimum_text import write_tried
            from cutwise.study.many.best import so_far

            print(write_tried(_there(folder, so_far, planned, known), file))
        elif planned.method == RARE:
            from cutwise.study.many.rarely import told

            print(write_table(planned, _there(folder, told, planned, known).table, file))
        else:
            print(write_table(planned, _there(folder, _columns, planned, known), file))
    except NoWriter as why:
        refuse(f"{file}: {why}")


def _columns(planned: "Study", folder: Path, known: dict[str, Any]) -> "Columns":
    """Columns of what is finished."""
    from cutwise.study.many.columns import collected

    table, done = collected(planned, folder, int(known["chunk"]))
    if not done:
        raise ValueError("no case is finished yet")
    return table


def _there(
    folder: Path, told: "Callable[[Study, Path, dict[str, Any]], Told]", planned: "Study", known: dict[str, Any]
) -> Told:  # fmt: skip
    """What a folder tells; refused where there is nothing yet."""
    try:
        return told(planned, folder, known)
    except ValueError as why:
        refuse(f"{folder}: {why}")


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


def _optimised(planned: "Study", folder: Path, table: Path | None, more: dict[str, Any], *, as_json: bool) -> None:
    """Look for the best setting, and tell it."""
    from cutwise.app.console import Console
    from cutwise.study.many.best import optimised

    with Console().progress(planned.name) as show:
        found = optimised(planned, folder, progress=lambda done, _: show(done / (done + 100)), **more)
    _tell_best(found, folder / "report.html", table, as_json=as_json)


def _tell_best(found: "Best", target: Path, table: Path | None, *, as_json: bool) -> None:
    """An optimum in lines or as JSON, on a page, its settings as a table; leaves with the exit code."""
    from cutwise.app import optimum_text
    from cutwise.app.optimum_page import page
    from cutwise.disk import write_text

    lines = list(optimum_text.said(found))
    report = write_text(target, page(found, lines))
    if table is not None:
        optimum_text.write_tried(found, table)
    _print(lines, optimum_text.as_object(found, {"report": str(report)}), report, as_json=as_json)
    if not found.optimum.met and all(one.measures == {} for one in found.tried):
        raise typer.Exit(SOLVER_FAILED)
    raise typer.Exit(OK if found.proven else REQUIREMENT_FAILED)


def _rarely(planned: "Study", folder: Path, table: Path | None, more: dict[str, Any], *, as_json: bool) -> None:
    """Find how rare failures are, and tell it."""
    from cutwise.app.console import Console
    from cutwise.study.many.rarely import rarely

    each = planned.draws
    with Console().progress(planned.name) as show:
        found = rarely(planned, folder, progress=lambda done, _: show(done / (done + each)), **more)
    _tell_rarely(found, folder / "report.html", table, as_json=as_json)


def _tell_rarely(found: "Rarely", target: Path, table: Path | None, *, as_json: bool) -> None:
    """Rare failures in lines or as JSON, on a page, as a table; leaves with the exit code."""
    from cutwise.app import rare_text
    from cutwise.disk import write_text
    from cutwise.study.many.tables import write_table

    lines = list(rare_text.said(found))
    report = write_text(target, rare_text.page(found, lines))
    if table is not None:
        write_table(found.study, found.table, table)
    _print(lines, rare_text.as_object(found, {"report": str(report)}), report, as_json=as_json)
    if sum(found.failed.values()) == found.done:
        raise typer.Exit(SOLVER_FAILED)
    missed = found.unfinished and found.study.demanded is not None
    raise typer.Exit(OK if found.demanded in (None, True) and not missed else REQUIREMENT_FAILED)


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
    planned: "Study", folder: Path, stopped: str, table: Path | None, *, as_json: bool, target: Path | None = None
) -> None:  # fmt: skip
    """What is there of a study: in lines or as JSON, on a page, as a table; leaves with the exit code."""
    from cutwise.app.study_page import page
    from cutwise.app.study_text import as_object, held, said
    from cutwise.disk import write_text
    from cutwise.study.many import folder as at
    from cutwise.study.many.answers import answers, demanded
    from cutwise.study.many.held import against_full_runs
    from cutwise.study.many.tables import write_table

    known = at.identity_in(folder)
    assert known is not None
    found = answers(planned, folder, int(known["chunk"]))
    against = against_full_runs(found)
    lines = [
        *([f"stopped at {found.done:,} of {planned.cases:,}: {stopped}"] if stopped else []),
        *said(found),
        *held(found, against),
        *([f"cases of cutwise {' and '.join(at.versions(known))} stand beside each other"] if known["also"] else []),
    ]
    report = write_text(target or folder / "report.html", page(found, lines, known["study"][:16]))
    if table is not None:
        write_table(planned, found.table, table)
    _print(lines, as_object(found, against, stopped, {"report": str(report)}), report, as_json=as_json)
    asked = demanded(found)
    if found.count_failed == found.done:
        raise typer.Exit(SOLVER_FAILED)
    raise typer.Exit(OK if asked is None or asked[0] else REQUIREMENT_FAILED)
