"""``cutwise report`` and ``cutwise export``: a page of a finished run, and its arrays for other programs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from cutwise.app import outputs, studying
from cutwise.app.exits import refuse
from cutwise.app.writing import REPORT, RUN
from cutwise.disk import write_bytes, write_text, write_together

if TYPE_CHECKING:
    from collections.abc import Callable

    from cutwise.results import Result
    from cutwise.spec.scenario import Scenario

Made = TypeVar("Made")


def report(
    run_file: Annotated[
        Path, typer.Argument(metavar="RUN", help="run file, the folder that holds run.nc, or that of a study")
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="where to write it; default report.html beside it"),
    ] = None,
    static: Annotated[
        bool, typer.Option("--static", help="without the viewer: pictures alone, a smaller file")
    ] = False,
) -> None:
    """Write the HTML report of a finished run again, or that of what is there of a study."""
    if studying.is_folder(run_file):
        studying.reported(run_file, output)
        return
    from cutwise.app.report import render
    from cutwise.io.scenario import loaded

    source, content = _run_file(run_file)
    scenario = loaded(content, source)
    target = output or source.with_name(REPORT)
    outputs.checked([target], [source])
    html = _of_run(source, content, lambda: render(_result(content, scenario), viewer=not static))
    print(write_text(target, html))


def export(
    run_file: Annotated[Path, typer.Argument(metavar="RUN", help="run file, the folder that holds run.nc, or that of a study")],
    what: Annotated[
        str | None,
        typer.Argument(metavar="[WHAT]", help="lines: load, volume and deviation line by line as CSV; surface: the machined stock "
                       "as .ply, .vtk or .stl; left out: every array of the run"),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="PATH",
                     help="folder, or file: of WHAT; of a study .csv, .nc or .parquet; default: beside the run")
    ] = None,
) -> None:  # fmt: skip
    """Write the arrays of a finished run as CSV tables, maps as VTK, the machined stock as a solid; the cases of a study."""
    if studying.is_folder(run_file):
        if what is not None:
            refuse(f"{what}: {run_file} is the folder of a study, whose cases are written as one table")
        studying.exported(run_file, output)
        return
    from cutwise.app.exporting import NothingThere, one_file
    from cutwise.io.export import tables
    from cutwise.run_file import tree_of

    source, content = _run_file(run_file)
    if what is not None:
        try:
            target, found = _of_run(source, content, lambda: one_file(what, tree_of(content), source, output))
        except NothingThere as fault:
            refuse(str(fault))
        outputs.checked([target], [source])
        print(write_bytes(target, found))
        return
    target = output or source.with_name("export")
    outputs.checked([], [source], target)
    texts = _of_run(source, content, lambda: tables(tree_of(content)))
    outputs.checked([target / name for name in texts], [source], target)
    for path in write_together(target, {name: text.encode() for name, text in texts.items()}):
        print(path)


def _run_file(named: Path) -> tuple[Path, bytes]:
    """The run file that is meant, and what it holds; read once, so that a run that ends meanwhile changes nothing."""
    from cutwise.io.files import read_bytes
    from cutwise.run_file import is_netcdf

    source = named / RUN if named.is_dir() else named
    content = read_bytes(source, str(source))
    if not is_netcdf(content):
        refuse(f"{source}: is not a run file of cutwise; name the {RUN} of a finished run")
    return source, content


def _result(content: bytes, scenario: "Scenario") -> "Result":
    from cutwise.results import Result

    return Result.from_bytes(content, scenario)


def _of_run(source: Path, content: bytes, made: "Callable[[], Made]") -> "Made":
    """What is made of a run file; what cannot be made of one that another program has changed is its fault."""
    from cutwise.run_file import DamagedRun, has_seal

    try:
        return made()
    except DamagedRun as damage:
        refuse(f"{source}: {damage}; name the {RUN} of a finished run")
    except Exception as error:
        if has_seal(content):
            raise
        refuse(f"{source}: was changed since cutwise wrote it, and cannot be used ({type(error).__name__}: {error})")
