"""What the command line shows: tables, verdicts and progress; plain text when it is not a terminal that reads."""

import errno
import logging
import os
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import product
from math import isnan
from typing import TYPE_CHECKING

import rich.console
from rich import box
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from cutwise import units
from cutwise.app import interrupt
from cutwise.app.findings import notices, reasons
from cutwise.app.inputs import inputs
from cutwise.app.measured import caveats, listed
from cutwise.app.numbers import form
from cutwise.app.surety import surety
from cutwise.app.verdict_text import against, compared, sensitivity_line, verdict_line
from cutwise.spec.filled import in_words
from cutwise.spec.texts import visible

if TYPE_CHECKING:
    import xarray as xr

    from cutwise.app.installation import Finding
    from cutwise.io.library import Entry
    from cutwise.process.selfchecks import Outcome
    from cutwise.results import Result
    from cutwise.spec.scenario import Scenario
    from cutwise.study.advice import Advice

_PATIENCE = 2.0  # [s] a progress bar appears only after this
_SAID_ALREADY = ("remedies", "left_out")  # notes for the report: advice and warnings say the same
_SAID_AS = {"infeasible": "infeasible", "warnings": "warning", "unsound": "not sound"}
_COLOURS = {"pass": "bold green", "fail": "bold red", "none": "bold"}


class _Stream(rich.console.Console):
    """A stream whose reader may go away: rich would end the program as if a requirement had failed."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


class Console:
    """Standard output for results, standard error for everything that is not a result."""

    def __init__(self) -> None:
        self.out = _Stream(highlight=False, soft_wrap=True)
        self.err = _Stream(highlight=False, soft_wrap=True, stderr=True)

    def table(
        self, title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[str] = ()
    ) -> None:
        """A table; when piped aligned columns of plain text, never cut off."""
        rows = list(rows)
        used = [i for i in range(len(columns)) if any(row[i] for row in rows)]
        names, rows = [columns[i] for i in used], [[row[i] for i in used] for row in rows]
        if title:
            self.line(title, "bold")
        if not self.out.is_terminal:
            self._plain(names, rows, right)
            return
        table = Table(header_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
        for name in names:
            table.add_column(name, justify="right" if name in right else "left")
        for row in rows:
            table.add_row(*map(visible, row))
        self.out.print(table, soft_wrap=False)

    def _plain(self, names: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[str]) -> None:
        cells = [[Text.from_markup(cell).plain for cell in row] for row in (names, *rows)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        for row in cells:
            aligned = (c.rjust(w) if n in right else c.ljust(w) for n, c, w in zip(names, row, widths, strict=True))
            self.line("  ".join(aligned).rstrip())

    def line(self, text: str = "", style: str | None = None) -> None:
        """One line of plain text."""
        self.out.print(visible(text), style=style, markup=False)

    def checked(self, file: str, scenario: "Scenario", unusual: Sequence[str]) -> None:
        """What ``check`` says about a scenario without fault."""
        self.line(f"{file}: no fault ({scenario.process}, {scenario.name})")
        self.line(f"cell: {in_words(scenario)}")
        self.line(_assumed(scenario))
        for notice in unusual:
            self.line(f"unusual: {notice}", "yellow")

    def result(self, result: "Result", files: Mapping[str, str]) -> None:
        """Measures, verdict, warnings, and where the files are."""
        rows: list[tuple[str, ...]] = []
        for group, lines in listed(result).items():
            rows += [(group, *[""] * 5)] if group else []
            for line in lines:
                judged = (
                    _mark(line.check.passed) + against(line.check, result.scenario) if line.check is not None else ""
                )
                name = f"  {line.name}" if group else line.name
                rows.append((name, line.number, line.band, line.unit, line.asked, judged))
        self.table(
            f"{result.scenario.name} ({result.scenario.process})",
            ("measure", "value", "90 % band", "unit", "requirement", "result"), rows, right=("value", "90 % band"),
        )  # fmt: skip
        self.line()
        variants = compared(result)
        if variants is not None:
            self.table("comparison", *variants, right=variants[0][1:])
            self.line()
        for reason in result.infeasible:
            self.line(f"infeasible: {reason}", "red")
        for reason in reasons(result):
            self.line(f"not sound: {reason}", "red")
        for notice in notices(result):
            self.line(f"warning: {notice}", "yellow")
        for warning in result.warnings:
            self.line(f"warning: {warning}", "yellow")
        for name, note in result.notes.items():
            if name not in _SAID_ALREADY:
                self.line(f"note: {note}")
        for names, sentence in caveats(result):
            self.line(f"note: {', '.join(names)}: {sentence}")
        for sentence in surety(result):
            self.line(f"band: {sentence}")
        self.line(_assumed(result.scenario))
        self.advice(result.scenario, result.advice, result.sensitivity)
        for kind, place in files.items():
            self.line(f"{kind}: {place}")
        self.line(verdict_line(result), _COLOURS[result.verdict])

    def sweep(self, scenario: "Scenario", table: "xr.Dataset", names: "Sequence[str]") -> None:
        """Measures over all combinations of values, and what the runs say, each sentence once."""
        from cutwise.study.sweep import TEXT

        keys = [str(key) for key in table.dims]
        known, shown = scenario.measures, [name for name in names if name in table]
        shapes = {name: form(known[name].dimension, table[name].values.ravel().tolist()) for name in shown}
        rows: list[tuple[str, ...]] = []
        said: dict[str, int] = {}
        for place in product(*(range(table.sizes[key]) for key in keys)):
            here = table.isel(dict(zip(keys, place, strict=True)))
            point = [
                escape(str(here[name if (name := TEXT.format(key)) in table.coords else key].values)) for key in keys
            ]
            cells = ("-" if isnan(float(here[name])) else shapes[name].text(float(here[name]))
                     for name in shown)  # fmt: skip
            marks = []
            for what in ("infeasible", "warnings", "unsound"):
                for sentence in str(here[what].values).splitlines():
                    marks.append(said.setdefault(f"{_SAID_AS[what]}: {sentence}", len(said) + 1))
            rows.append((*point, *cells, ", ".join(map(str, marks))))
        self.table(f"{scenario.name} ({scenario.process})", (*keys, *shown, "said"), rows)
        for sentence, number in said.items():
            self.line(f"{number}: {sentence}", "yellow")
        for reason in str(table.attrs.get("failed", "")).splitlines():
            self.line(f"not run: {reason}")

    def consulted(self, scenario: "Scenario", found: "Advice", sensitivity: Mapping[str, float]) -> None:
        """Advice with the verdict that it starts from, and what it cost."""
        self.advice(scenario, found.sentences, sensitivity)
        self.line(f"cost: {found.runs} runs, {found.seconds:.1f} s of processor time")
        self.line(
            "PASS: the requirements are met as it stands"
            if found.met
            else "FAIL: the requirements are not met as it stands",
            _COLOURS["pass" if found.met else "fail"],
        )

    def advice(self, scenario: "Scenario", advice: Sequence[str], sensitivity: Mapping[str, float]) -> None:
        """What to change, or how much room there is, and which assumed values matter."""
        for sentence in advice:
            self.line(f"advice: {sentence}")
        if sensitivity:
            self.line(sensitivity_line(scenario, sensitivity))

    def shelf(self, kind: str, entries: "Iterable[Entry]") -> None:
        """The entries of a library shelf."""
        rows = [(f"  {entry.name}", escape(entry.describes)) for entry in entries]
        self.table(kind, ("  name", "describes"), rows or [("  (empty)", "")])
        self.line()

    def entry(self, entry: "Entry") -> None:
        """The values of a library entry with their sources."""
        self.line(f"{entry.shelf}/{entry.name}", "bold")
        self.line(entry.describes)
        self.line(f"file: {entry.file}")
        rows = [(key, escape(text), origin.status, escape(origin.source)) for key, text, origin in entry.origins()]
        self.table("", ("key", "value", "status", "source"), rows)

    def findings(self, findings: "Iterable[Finding]") -> None:
        """What ``doctor`` found."""
        rows = [(_mark(f.good), f.subject, escape(f.found), escape("" if f.good else f.remedy)) for f in findings]
        self.table("", ("", "subject", "found", "remedy"), rows)

    def outcomes(self, outcomes: "Sequence[Outcome]") -> None:
        """What ``selftest`` computed, and how far it is from what is known."""
        rows = []
        for check, found, passed in outcomes:
            shown = [units.show(value, check.dimension, 6) for value in (found, check.expected)]
            deviation = units.show(found - check.expected, check.dimension, 2)
            allowed = units.show(check.tolerance, check.dimension, 2)
            rows.append((_mark(passed), escape(check.name), *shown, deviation, allowed, escape(check.source)))
        columns = ("", "check", "found", "expected", "deviation", "allowed", "source")
        self.table("", columns, rows, right=columns[2:6])
        failed = sum(not outcome.passed for outcome in outcomes)
        self.line()
        self.line(f"{len(outcomes) - failed} of {len(outcomes)} checks pass", "bold red" if failed else "bold green")

    @contextmanager
    def progress(self, what: str) -> Iterator[Callable[[float], None]]:
        """A progress bar on standard error, if that is a terminal and it takes longer than two seconds.

        What is given back also stops the work after a Ctrl-C. What the work has to say meanwhile goes to standard error.
        """
        told = logging.getLogger("cutwise")
        teller = _Teller(self.err)
        level = told.level
        told.addHandler(teller)
        told.setLevel(logging.INFO)
        try:
            with self._bar(what) as show:
                yield show
        finally:
            told.removeHandler(teller)
            told.setLevel(level)

    @contextmanager
    def _bar(self, what: str) -> Iterator[Callable[[float], None]]:
        if not self.err.is_terminal:
            yield lambda share: interrupt.stop_if_asked()  # noqa: ARG005
            return
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        bar = Progress(
            TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"), TimeElapsedColumn(),
            console=self.err, transient=True,
        )  # fmt: skip
        task = bar.add_task(escape(what), total=1.0)
        late = threading.Timer(_PATIENCE, bar.start)
        late.daemon = True
        late.start()

        def show(share: float) -> None:
            interrupt.stop_if_asked()
            bar.update(task, completed=share)

        try:
            yield show
        finally:
            late.cancel()
            late.join()
            bar.stop()


class _Teller(logging.Handler):
    """Prints what a run says while it is going on."""

    def __init__(self, console: rich.console.Console) -> None:
        super().__init__(logging.INFO)
        self.console = console

    def emit(self, record: logging.LogRecord) -> None:
        self.console.print(record.getMessage(), markup=False)


def _assumed(scenario: "Scenario") -> str:
    statuses = [row.status for row in inputs(scenario)]
    count = statuses.count("assumed")
    if not count:
        return f"{len(statuses)} input values, none of them assumed"
    return (
        f"{count} of {len(statuses)} input values are assumed: neither measured nor published (the report lists them)"
    )


def _mark(good: bool) -> str:
    return "[green]pass[/green]" if good else "[bold red]FAIL[/bold red]"
