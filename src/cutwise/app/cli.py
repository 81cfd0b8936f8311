"""The command line: what an engineer types, what comes back, and the exit code that says how it went."""

import gc
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

import cutwise
from cutwise.app import (
    calibrating,
    comparing,
    complete,
    correcting,
    exits,
    inspection,
    interrupt,
    new,
    outputs,
    reporting,
    studying,
    validating,
    viewing,
)
from cutwise.app.exits import INTERRUPTED, NOBODY_READS, OK, REQUIREMENT_FAILED, TERMINATED, explain, refuse
from cutwise.app.options import SET, Overrides, ScenarioFile
from cutwise.app.writing import REPORT, RUN, programs, written
from cutwise.disk import file_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cutwise.results import Result
    from cutwise.spec.scenario import Scenario

_COLLECT = 200_000  # objects between two looks for garbage: imports and figures make many and drop few, 8 % of a run

app = typer.Typer(
    name="cutwise",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Virtual machining: what an operation will do to the part before anything is cut, and what to change.",
    epilog="Exit codes: 0 ok; 1 finished, but a requirement fails or the operation is infeasible; 2 bad input; "
    "3 the solver failed; 130 interrupted; 143 terminated.",
)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"cutwise {cutwise.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    debug: Annotated[bool, typer.Option("--debug", help="show the traceback of an error")] = False,
    version: Annotated[
        bool, typer.Option("--version", help="show the version and exit", is_eager=True, callback=_show_version)
    ] = False,
) -> None:
    """Options of all commands; ``main`` looks for --debug itself, since it may stand anywhere."""


app.command()(new.new)


@app.command()
def check(file: ScenarioFile, overrides: Overrides = None) -> None:
    """Find every fault of a scenario without running it."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load
    from cutwise.process.recipes import prepare
    from cutwise.spec.notices import notices

    if file.suffix in (".yaml", ".yml") and studying.checked(file, overrides or ()):
        return
    scenario = load(file, overrides or (), named=SET)
    prepare(scenario)
    if scenario.correct is not None:
        from cutwise.study.correct.entry import checked as correction

        correction(scenario)
    Console().checked(str(file), scenario, notices(scenario))


@app.command()
def run(
    file: ScenarioFile,
    overrides: Overrides = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="DIR", help="folder for run.nc and report.html; default cutwise-runs/NAME"
        ),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="print one JSON object (SI) and nothing else on standard output")
    ] = False,
    report: Annotated[bool, typer.Option("--report/--no-report", help="write the HTML report")] = True,
    static: Annotated[
        bool,
        typer.Option("--static-report", help="write the report without the viewer: pictures alone, a smaller file"),
    ] = False,
    advice: Annotated[
        bool, typer.Option("--advice/--no-advice", help="run variants for advice and sensitivities where that is quick")
    ] = True,
    jobs: Annotated[int, typer.Option("--jobs", min=1, metavar="N", help="processes for bands and sensitivities")] = 1,
    gcode: Annotated[
        Path | None, typer.Option("--gcode", metavar="FILE", help="write the tool path as G-code (chamfer)")
    ] = None,
    apt: Annotated[
        Path | None, typer.Option("--apt", metavar="FILE", help="write the tool path as APT (chamfer)")
    ] = None,
    poses: Annotated[
        Path | None, typer.Option("--poses", metavar="FILE", help="write the tool path as robot poses, CSV (chamfer)")
    ] = None,
) -> None:
    """Simulate a scenario and hold the result against its requirements."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load

    scenario = load(file, overrides or (), named=SET)
    folder = output or Path("cutwise-runs") / file_name(scenario.name)
    outputs.checked([folder / RUN, folder / REPORT, gcode, apt, poses], [file, *scenario.files], folder)
    for program in filter(None, (gcode, apt, poses)):
        if scenario.process != "chamfer":
            refuse(f"{program}: a {scenario.process} run has no tool path to write")
    console = Console()
    with console.progress(scenario.name) as progress:
        result = _simulated(scenario, progress, advice, jobs)
        files = written(result, folder, report, viewer=not static)
        files |= programs(result, {"gcode": gcode, "apt": apt, "poses": poses})
    if as_json:
        import json

        from cutwise.app.findings import reasons

        print(json.dumps(result.summary(files, reasons(result)), allow_nan=False))
    else:
        console.result(result, files)
    raise typer.Exit(REQUIREMENT_FAILED if result.verdict == "fail" else OK)


for _written in (reporting.report, reporting.export):
    app.command()(_written)


@app.command()
def advise(
    file: ScenarioFile,
    overrides: Overrides = None,
    limits: Annotated[
        list[str] | None,
        typer.Option("--limit", metavar="KEY=LOW..HIGH", autocompletion=complete.assignments,
                     help="a setting that may be turned and how far, for example operation.feed='40 mm/s..90 mm/s'; "
                     "repeatable; default: the usual ones of the process"),
    ] = None,
    budget: Annotated[
        str | None,
        typer.Option("--budget", metavar="N|TIME", help="the most runs (200) or processor time ('60 s') to spend"),
    ] = None,
) -> None:  # fmt: skip
    """Find by many runs which settings meet the requirements, or how much room there is, and which assumptions matter."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load
    from cutwise.study.advice import consult, most_runs
    from cutwise.study.levers import levers_of, read_limits
    from cutwise.study.sensitivity import assumed_sensitivity
    from cutwise.study.trials import NO_END, read_budget

    most = read_budget(budget) if budget is not None else NO_END
    scenario = load(file, overrides or (), named=SET)
    if not scenario.requirements:
        example = scenario.starts.get("requirements", f"{{{scenario.focus}: {{max: ...}}}}")
        refuse(f"{file}: has no requirements to advise on; add some, for example requirements: {example}")
    levers = read_limits(scenario, limits or ())
    console = Console()
    if budget is None:
        console.err.print(f"up to {most_runs(levers_of(scenario, levers))} runs; --budget sets an end")
    with console.progress(scenario.name):
        found = consult(scenario, levers, budget=most, named="--limit {}")
        weights = assumed_sensitivity(scenario) if budget is None else {}
    console.consulted(scenario, found, weights)
    if getattr(scenario, "program", None) is not None and scenario.process == "mill":
        console.line(f"the feed of each block of the program by itself: cutwise correct {file} --dry-run")
    raise typer.Exit(OK if found.met else REQUIREMENT_FAILED)


@app.command()
def sweep(
    file: ScenarioFile,
    over: Annotated[
        list[str],
        typer.Option("--over", metavar="KEY=VALUE,VALUE,...", autocompletion=complete.assignments,
                     help="values of a key, for example spindle.pressure='3 bar,4 bar,5 bar'; repeat for a grid"),
    ],
    overrides: Overrides = None,
    measure: Annotated[
        list[str] | None, typer.Option("--measure", metavar="NAME", help="measures to show; default those required")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="write all measures (SI) as .csv or .nc")
    ] = None,
    in_full: Annotated[
        bool, typer.Option("--check/--no-check", help="run first, last and worst combination in full, with half the step too")
    ] = True,
    jobs: Annotated[int, typer.Option("--jobs", min=1, metavar="N", help="processes")] = 1,
) -> None:  # fmt: skip
    """Run a scenario over values of its keys and print a table."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load
    from cutwise.study.sweep import parse_values, save, shown_measures
    from cutwise.study.sweep import sweep as swept

    scenario = load(file, overrides or (), named=SET)
    values = parse_values(over)
    names = shown_measures(scenario, measure or ())
    if output is not None and output.suffix not in (".csv", ".nc"):
        refuse(f"{output}: write a .csv or a .nc file")
    outputs.checked([output], [file, *scenario.files])
    console = Console()
    with console.progress(f"sweep of {scenario.name}") as progress:
        table = swept(scenario, values, progress, names, check=in_full, jobs=jobs, named="--over {}")
    console.sweep(scenario, table, names)
    if output is not None:
        print(save(table, output))


for _look in (
    studying.study,
    studying.worker,
    calibrating.calibrate,
    validating.validate,
    correcting.correct,
    comparing.compare,
    inspection.part,
    inspection.program,
    inspection.spindle,
    viewing.view,
):
    app.command()(_look)


@app.command()
def library(
    kind: Annotated[
        str | None,
        typer.Argument(
            metavar="[KIND]", help="shelf: tools, materials, spindles, ...", autocompletion=complete.shelves
        ),
    ] = None,
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="entry, whose values are shown", autocompletion=complete.entries),
    ] = None,
) -> None:
    """Show the library: shelves, their entries, or the values of an entry with their sources."""
    from cutwise.app.console import Console
    from cutwise.io import library as shelves

    console = Console()
    if kind is None:
        for shelf in shelves.SHELVES:
            console.shelf(shelf, shelves.shelf(shelf).values())
    elif name is None:
        console.shelf(kind, shelves.shelf(kind).values())
    else:
        shelves.shelf(kind)
        console.entry(shelves.entry(kind, name))


@app.command()
def schema(
    kind: Annotated[
        str | None,
        typer.Argument(metavar="[KIND]", help="process; left out: all processes", autocompletion=complete.kinds),
    ] = None,
) -> None:
    """Print the JSON schema of scenarios, for editors."""
    import json

    from cutwise.spec.kinds import KINDS
    from cutwise.spec.schema import schema as json_schema

    if kind is not None and kind not in KINDS:
        refuse(f'"{kind}" is not a process; known are: {", ".join(KINDS)}')
    print(json.dumps(json_schema(kind), indent=2))


@app.command()
def doctor(
    clear: Annotated[
        bool, typer.Option("--clear", help="remove the compiled kernels; they are made again when used")
    ] = False,
) -> None:
    """Look at the installation: versions, library, compiler, folders."""
    from cutwise.app import installation
    from cutwise.app.console import Console

    if clear:
        from cutwise.maths.compiled import clear_kernels

        Console().line(f"compiled kernels removed: {clear_kernels() / 1e6:.1f} MB")
    findings = list(installation.examine())
    Console().findings(findings)
    raise typer.Exit(OK if all(finding.good for finding in findings) else REQUIREMENT_FAILED)


@app.command()
def selftest() -> None:
    """Compute reference cases on this machine and compare them with their published or derived values."""
    from cutwise.app.console import Console
    from cutwise.process.selfchecks import CHECKS, outcomes

    console = Console()
    with console.progress("selftest") as progress:
        found = []
        for outcome in outcomes(CHECKS):
            found.append(outcome)
            progress(len(found) / len(CHECKS))
    console.outcomes(found)
    raise typer.Exit(OK if all(outcome.passed for outcome in found) else REQUIREMENT_FAILED)


def _simulated(scenario: "Scenario", progress: Any, advice: bool, jobs: int) -> "Result":
    from cutwise.study.band import simulate
    from cutwise.study.review import reviewed

    result = simulate(scenario, progress, jobs=jobs)
    return reviewed(result, jobs=jobs) if advice else result


def main(arguments: "Sequence[str] | None" = None) -> NoReturn:
    """Run the command line; leaves with the exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given  # it may stand anywhere
    gc.set_threshold(_COLLECT, 20, 50)
    exits.open_streams()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal that lacks a letter gets a question mark, not a traceback
    out, err = sys.stdout, sys.stderr
    with interrupt.watched(), exits.reader_of(out) as gone:
        code = exits.flushed(_code([argument for argument in given if argument != "--debug"], debug), out, err)
        if code == REQUIREMENT_FAILED and gone():  # typer and rich leave with 1 when nobody reads on
            code = NOBODY_READS
    words = {INTERRUPTED: "interrupted", TERMINATED: "terminated"}
    if code in words:
        print(words[code], file=sys.stderr)
    sys.exit(code)


def _code(arguments: "Sequence[str]", debug: bool) -> int:
    """Run a command; the exit code that it comes to."""
    try:
        app(arguments, prog_name="cutwise")
    except interrupt.Terminated:
        return TERMINATED
    except KeyboardInterrupt:
        return INTERRUPTED
    except SystemExit as left:
        if interrupt.asked():
            return interrupt.asked()
        return left.code if isinstance(left.code, int) else OK
    except BrokenPipeError:
        return NOBODY_READS
    except Exception as error:
        if interrupt.asked():
            return interrupt.asked()
        if debug:
            raise
        return explain(error)
    return OK
