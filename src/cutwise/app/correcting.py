"""``cutwise correct``: the program that keeps the limits, and the proof."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutwise.app import outputs
from cutwise.app.exits import OK, REQUIREMENT_FAILED, refuse
from cutwise.app.options import SET, ScenarioFile
from cutwise.app.options import Overrides as Settings
from cutwise.disk import write_bytes, write_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from cutwise.spec.scenario import Scenario
    from cutwise.study.correct.outcome import Corrected

_LISTED = 8  # changes that are shown one by one


def correct(
    file: ScenarioFile,
    overrides: Settings = None,
    objective: Annotated[str | None, typer.Option("--objective", metavar="time|error|cost", help="what is made least")] = None,
    change: Annotated[str | None, typer.Option("--change", metavar="LIST", help="what may be changed: feed,speed,...")] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="OUT", help="write the new program")] = None,
    form: Annotated[
        str | None,
        typer.Option("--format", metavar="FORMAT", help="language of the new program: rs274 (its own), fanuc, apt; of robots "
                     "poses, krl, rapid; table of feeds or errors"),
    ] = None,
    draws: Annotated[str | None, typer.Option("--draws", metavar="N", help="draws of what is uncertain")] = None,
    ranges: Annotated[
        list[str] | None, typer.Option("--range", metavar="KEY=LO..HI", help="how far a setting may be turned; repeatable")
    ] = None,
    front: Annotated[
        str | None, typer.Option("--front", metavar="MEASURE=A,B,...", help="a program for each budget of a limit")
    ] = None,
    unroll: Annotated[bool, typer.Option("--unroll", help="write out lines that run several times, where that gains")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="say what would be changed, and write nothing")] = False,
    force: Annotated[bool, typer.Option("--force", help="write the best program although it misses a limit")] = False,
    report: Annotated[
        Path | None, typer.Option("--report", metavar="FILE", help="write a page: feed before and after along the path, what binds")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI) and nothing else")] = False,
) -> None:  # fmt: skip
    """Change feeds, speeds or coordinates so that limits are kept and time is least; proved by another simulation."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load
    from cutwise.study.correct.entry import correct as corrected

    settings = [*(overrides or ()), *_settings(objective, change, draws, ranges or ()), *_front(front)]
    scenario = load(file, settings, named=SET)
    form = _language(form, scenario)
    outputs.checked([output, report], [file, *scenario.files])
    console = Console()
    with console.progress(f"correct {scenario.name}") as progress:
        found = corrected(scenario, unroll=unroll, progress=progress)
    files: dict[str, str] = {}
    if output is not None and not dry_run and (found.good or force):
        files["program"] = str(write_bytes(output, encoded(found, written(found, form))))
    if report is not None and not dry_run:
        from cutwise.app.correct_page import page

        files["report"] = str(write_text(report, page(found, rows_of(found), front_of(found))))
    if as_json:
        import json

        print(json.dumps(found.as_json(files), allow_nan=False))
    else:
        for line in shown(found):
            console.line(line)
        for kind, path in files.items():
            console.line(f"{kind}: {path}")
        if "program" not in files and not dry_run:
            why = "-o FILE writes the new program" if output is None else "--force writes it all the same"
            print(f"no program written; {why}", file=sys.stderr)
    raise typer.Exit(OK if found.good else REQUIREMENT_FAILED)


def _language(form: str | None, scenario: "Scenario") -> str:
    """The language that is asked for, or that of the program, or the first in which corrections of a process are written."""
    from cutwise.programs.cldata import is_apt
    from cutwise.study.correct.table import FORMATS, WRITTEN

    process, program = scenario.process, getattr(scenario, "program", None)
    if form is None and program is not None and is_apt(program.text, program.file):
        form = "apt"
    if form not in (None, *FORMATS):
        refuse(f"--format {form}: is not there; there are {', '.join(FORMATS)}")
    languages = WRITTEN.get(process, ("rs274",))
    if form is not None and form not in languages:
        refuse(f"--format {form}: does not go with process: {process}, of which there is {', '.join(languages)}")
    return form or languages[0]


def _settings(
    objective: str | None, change: str | None, draws: str | None, ranges: list[str] | tuple[str, ...]
) -> "Iterator[str]":
    """Options of the command line as keys of the section."""
    if objective is not None:
        yield f"correct.objective={objective}"
    if change is not None:
        yield f"correct.change=[{change}]"
    if draws is not None:
        yield f"correct.draws={draws}"
    spans = []
    for text in ranges:
        key, sign, span = text.partition("=")
        low, dots, high = (part.strip() for part in span.partition(".."))
        if not sign or not dots:
            refuse(f"--range {text}: is not of the form dotted.key=low..high")
        spans.append(f"{key.strip()}: ['{low}', '{high}']")
    if spans:
        yield f"correct.ranges={{{', '.join(spans)}}}"


def _front(text: str | None) -> "Iterator[str]":
    """Budgets of the command line as a key of the section."""
    if text is None:
        return
    name, sign, budgets = text.partition("=")
    if not sign:
        refuse(f"--front {text}: is not of the form measure=budget,budget")
    listed = ", ".join(f"'{one.strip()}'" for one in budgets.split(","))
    yield f"correct.front={{{name.strip()}: [{listed}]}}"


def written(found: "Corrected", form: str) -> str:
    """The new program in a language; one that misses a limit says so in a comment of that language."""
    from importlib import import_module

    from cutwise.study.correct.table import FORMATS

    module, _, name = FORMATS[form].partition(":")
    return str(getattr(import_module(module), name)(found))


def encoded(found: "Corrected", text: str) -> bytes:
    """The text in the bytes of the file that it was read from: its encoding and its byte order mark."""
    program = getattr(found.before.scenario, "program", None)
    name = Path(program.file).name if program is not None else ""
    source = next((Path(one) for one in found.before.scenario.files if Path(one).name == name), None)
    given = source.read_bytes() if source is not None and source.is_file() else b""
    mark = b"\xef\xbb\xbf" if given.startswith(b"\xef\xbb\xbf") else b""
    try:
        given.decode("utf-8")
    except UnicodeDecodeError:
        return text.encode("latin-1", errors="replace")
    return mark + text.encode("utf-8", errors="replace")


def rows_of(found: "Corrected") -> list[tuple[str, str, str]]:
    """Measures before and after in words."""
    from cutwise import units

    rows = []
    for name, after in found.measures.items():
        if name.endswith("_after") and (before := found.measures.get(f"{name[:-6]}_before")) is not None:
            shown = [units.show(one.value, one.dimension, 5) for one in (before, after)]
            rows.append((name[:-6], shown[0], shown[1]))
    return rows


def front_of(found: "Corrected") -> list[tuple[str, ...]]:
    """Programs of other budgets in words: a head and a row each; empty where none was asked for."""
    from cutwise.study.correct.front import BUDGET, shown

    rows = [row for row in found.pareto if BUDGET in row]
    if not rows:
        return []
    name = next(iter(found.scenario.correct.front))  # type: ignore[union-attr]
    measures = ("cycle_time", "force_xy_peak", "wall_error_min", "wall_error_max", "contour_error_max", "cost_per_part")
    return shown(rows, name, measures)


def _columns(rows: list[tuple[str, ...]]) -> "Iterator[str]":
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    yield from ("  ".join(f"{cell:<{width}}" for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows)


def shown(found: "Corrected") -> "Iterator[str]":
    """A correction as text: before and after, what was changed and why, and what is missed."""
    from cutwise import units

    yield from _columns([("", "before", "after"), *rows_of(found)])
    for name, one in found.measures.items():
        if not name.endswith(("_after", "_before")):
            yield f"{name}: {units.show(one.value, one.dimension, 4)}"
    if rows := front_of(found):
        yield from _columns(rows)
    yield from (str(change) for change in found.changes[:_LISTED])
    if len(found.changes) > _LISTED:
        yield f"and {len(found.changes) - _LISTED} more changes"
    yield from found.told
    yield from (f"not good enough: {text}" for text in found.reasons)
