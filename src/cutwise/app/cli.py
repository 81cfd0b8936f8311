"""The command line: what an engineer types, what comes back, and the exit code that says how it went."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

import cutwise
from cutwise.app import interrupt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cutwise.results import Result
    from cutwise.spec.scenario import Scenario

OK, REQUIREMENT_FAILED, BAD_INPUT, SOLVER_FAILED, INTERRUPTED = 0, 1, 2, 3, 130

app = typer.Typer(
    name="cutwise",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Virtual machining: what an operation will do to the part before anything is cut, and what to change.",
    epilog="Exit codes: 0 ok; 1 finished, but a requirement fails or the operation is infeasible; 2 bad input; "
    "3 the solver failed; 130 interrupted.",
)

ScenarioFile = Annotated[Path, typer.Argument(metavar="FILE", help="scenario (YAML or JSON), run file or HTML report")]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="replace a value, for example operation.feed='60 mm/s'; repeatable"
    ),
]


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


@app.command()
def new(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="process, for example deburr")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="where to write it; default KIND.yaml, - prints it"),
    ] = None,
) -> None:
    """Write a commented scenario to begin with."""
    from cutwise.io.template import template

    text = template(kind)
    if str(output) == "-":
        print(text, end="")
        return
    path = output or Path(f"{kind}.yaml")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        _refuse(f"{path}: is there already; name another file with -o")
    except OSError as error:
        _refuse(f"{path}: cannot be written: {error.strerror}")
    print(f"{path}\nnext: cutwise check {path}; cutwise run {path}")


@app.command()
def check(file: ScenarioFile, overrides: Overrides = None) -> None:
    """Find every fault of a scenario without running it."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load
    from cutwise.process.recipes import prepare
    from cutwise.spec.notices import notices

    scenario = load(file, overrides or ())
    prepare(scenario)
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
    advice: Annotated[
        bool, typer.Option("--advice/--no-advice", help="run variants for advice and sensitivities where that is quick")
    ] = True,
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

    scenario = load(file, overrides or ())
    folder = output or Path("cutwise-runs") / _folder_name(scenario.name)
    _writable(folder)
    for program in filter(None, (gcode, apt, poses)):
        if scenario.process != "chamfer":
            _refuse(f"{program}: a {scenario.process} run has no tool path to write")
        _writable(program.parent)
    console = Console()
    with console.progress(scenario.name) as progress:
        result = _simulated(scenario, progress, advice)
        files = _written(result, folder, report)
        files |= _programs(result, {"gcode": gcode, "apt": apt, "poses": poses})
    if as_json:
        import json

        print(json.dumps(result.summary(files), allow_nan=False))
    else:
        console.result(result, files)
    raise typer.Exit(REQUIREMENT_FAILED if result.verdict == "fail" else OK)


@app.command()
def report(
    run_file: Annotated[Path, typer.Argument(metavar="RUN", help="run file, or the folder that holds run.nc")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="where to write it; default report.html beside it"),
    ] = None,
) -> None:
    """Write the HTML report of a finished run again."""
    from cutwise.app.report import render
    from cutwise.io.files import write_text
    from cutwise.io.scenario import load
    from cutwise.results import Result

    source = run_file / "run.nc" if run_file.is_dir() else run_file
    scenario = load(source)
    target = output or source.with_name("report.html")
    _writable(target.parent)
    try:
        result = Result.from_file(source, scenario)
    except (OSError, KeyError, ValueError):
        _refuse(f"{source}: is not a run file of cutwise; name the run.nc of a finished run")
    write_text(target, render(result))
    print(target)


@app.command()
def export(
    run_file: Annotated[Path, typer.Argument(metavar="RUN", help="run file, or the folder that holds run.nc")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="where to write; default: export beside it")
    ] = None,
) -> None:
    """Write the arrays of a finished run as CSV tables, and maps of the working space as VTK."""
    import xarray as xr

    from cutwise.io.export import export as write

    source = run_file / "run.nc" if run_file.is_dir() else run_file
    target = output or source.with_name("export")
    _writable(target)
    try:
        stages = xr.open_datatree(source, engine="h5netcdf").load()
    except (OSError, KeyError, ValueError):
        _refuse(f"{source}: is not a run file of cutwise; name the run.nc of a finished run")
    for path in write(stages, target):
        print(path)


@app.command()
def advise(
    file: ScenarioFile,
    overrides: Overrides = None,
    limits: Annotated[
        list[str] | None,
        typer.Option("--limit", metavar="KEY=LOW..HIGH",
                     help="a setting that may be turned and how far, for example operation.feed='40 mm/s..90 mm/s'; "
                     "repeatable; default: the usual ones of the process"),
    ] = None,
) -> None:  # fmt: skip
    """Find by many runs which settings meet the requirements, or how much room there is, and which assumptions matter."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load
    from cutwise.study.advice import advise as advice
    from cutwise.study.advice import read_limits
    from cutwise.study.sensitivity import assumed_sensitivity

    scenario = load(file, overrides or ())
    if not scenario.requirements:
        _refuse(f"{file}: has no requirements to advise on; add some, for example surface_error_max: {{max: 0.05 mm}}")
    levers = read_limits(scenario, limits or ())
    console = Console()
    with console.progress(scenario.name):
        found, weights = advice(scenario, levers), assumed_sensitivity(scenario)
    console.advice(scenario, found, weights)


@app.command()
def sweep(
    file: ScenarioFile,
    over: Annotated[
        list[str],
        typer.Option("--over", metavar="KEY=VALUE,VALUE,...",
                     help="values of a key, for example spindle.pressure='3 bar,4 bar,5 bar'; repeat for a grid"),
    ],
    overrides: Overrides = None,
    measure: Annotated[
        list[str] | None, typer.Option("--measure", metavar="NAME", help="measures to show; default those required")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="write all measures (SI) as .csv or .nc")
    ] = None,
) -> None:  # fmt: skip
    """Run a scenario over values of its keys and print a table."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load
    from cutwise.study.sweep import parse_values, save, shown_measures
    from cutwise.study.sweep import sweep as swept

    scenario = load(file, overrides or ())
    values = parse_values(over)
    names = shown_measures(scenario, measure or ())
    if output is not None and output.suffix not in (".csv", ".nc"):
        _refuse(f"{output}: write a .csv or a .nc file")
    console = Console()
    with console.progress(f"sweep of {scenario.name}") as progress:
        table = swept(scenario, values, progress, names)
    console.sweep(scenario, table, names)
    if output is not None:
        print(save(table, output))


@app.command()
def part(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="STEP file")],
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI)")] = False,
    picture: Annotated[Path | None, typer.Option("--svg", metavar="FILE", help="draw the sharp edges")] = None,
) -> None:
    """List solids, holes and sharp edges of a STEP file, with the numbers that a chamfer scenario selects them by."""
    from cutwise.app.parts import draw, listing, shown
    from cutwise.io.files import write_text
    from cutwise.io.step import CadFault

    try:
        found = listing(file)
    except CadFault as fault:
        _refuse(str(fault))
    if as_json:
        import json

        print(json.dumps(found.as_json(), allow_nan=False))
    else:
        print(shown(found))
    if picture is not None:
        write_text(picture, draw(found))
        print(picture, file=sys.stderr)


@app.command()
def program(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="G-code, or APT cutter location data (.apt, .cls)")],
    canonical: Annotated[
        bool, typer.Option("--canonical", help="print the canonical machining commands, one call a line")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI)")] = False,
    picture: Annotated[Path | None, typer.Option("--svg", metavar="FILE", help="draw the path")] = None,
    tool_table: Annotated[
        Path | None, typer.Option("--tool-table", metavar="FILE", help="tools, in the format of LinuxCNC")
    ] = None,
) -> None:
    """Run through an NC program without a machine: tools, feeds, extents, lengths, time, and all its faults."""
    from cutwise.app.programs import Sketch, opened
    from cutwise.io.files import write_text
    from cutwise.io.programs import canonical_text, summary

    run, setup, remarks = opened(file, tool_table)
    if canonical:
        lines = list(canonical_text.lines(run.commands()))  # first all of them: a faulty program prints none
        print("\n".join(lines))
        return
    sketch = Sketch() if picture is not None else None
    found = summary.summarise(run, setup, sketch.add if sketch is not None else None)
    found = found._replace(notices=(*found.notices, *remarks))
    if as_json:
        import json

        print(json.dumps({"file": str(file), **summary.as_json(found)}, allow_nan=False))
    else:
        print(summary.shown(str(file), found))
    if picture is not None and sketch is not None:
        write_text(picture, sketch.svg(file.name))
        print(picture, file=sys.stderr)


@app.command()
def spindle(
    file: ScenarioFile,
    overrides: Overrides = None,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI)")] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="write the spindle as STEP (needs sizes)")
    ] = None,
    deflection: Annotated[
        str, typer.Option("--deflection", metavar="'X, Y'", help="how far the tip is pushed aside in the STEP file")
    ] = "0 mm, 0 mm",
) -> None:
    """Show mass, inertia and static forces of the compliant spindle of a scenario, and write it as a solid."""
    from cutwise import units
    from cutwise.app import spindle as sheets
    from cutwise.io.scenario import load

    scenario = load(file, overrides or ())
    try:
        found = sheets.sheet(scenario)
        tip = [units.parse(part.strip(), "length") for part in deflection.split(",")]
        if len(tip) != 2:
            raise ValueError(f"--deflection {deflection}: write two lengths, for example '1 mm, 2 mm'")
    except ValueError as fault:
        _refuse(str(fault))
    if as_json:
        import json

        print(json.dumps(found.as_json(), allow_nan=False))
    else:
        print(sheets.shown(found))
    if output is not None:
        _writable(output.parent)
        print(sheets.export(found, output, (tip[0], tip[1])), file=sys.stderr)


@app.command()
def library(
    kind: Annotated[str | None, typer.Argument(metavar="[KIND]", help="shelf: tools, materials, spindles, ...")] = None,
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="entry, whose values are shown")] = None,
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
    kind: Annotated[str | None, typer.Argument(metavar="[KIND]", help="process; left out: all processes")] = None,
) -> None:
    """Print the JSON schema of scenarios, for editors."""
    import json

    from cutwise.spec.kinds import KINDS
    from cutwise.spec.schema import schema as json_schema

    if kind is not None and kind not in KINDS:
        _refuse(f'"{kind}" is not a process; known are: {", ".join(KINDS)}')
    print(json.dumps(json_schema(kind), indent=2))


@app.command()
def doctor() -> None:
    """Look at the installation: versions, library, compiler, folders."""
    from cutwise.app import installation
    from cutwise.app.console import Console

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


def _simulated(scenario: "Scenario", progress: Any, advice: bool) -> "Result":
    from cutwise.process.recipes import simulate
    from cutwise.study.review import reviewed

    result = simulate(scenario, progress)
    return reviewed(result) if advice else result


def _written(result: "Result", folder: Path, with_report: bool) -> dict[str, str]:
    """Write the files of a run, each whole or not at all."""
    from cutwise.io.files import write_text

    interrupt.stop_if_asked()

    html = None
    if with_report:
        from cutwise.app.report import render

        html = render(result)
    folder.mkdir(parents=True, exist_ok=True)
    files = {"run": str(result.save(folder / "run.nc"))}
    if html is not None:
        files["report"] = str(write_text(folder / "report.html", html))
    return files


def _programs(result: "Result", wanted: dict[str, Path | None]) -> dict[str, str]:
    """Write the programs that were asked for; a run without a path has none."""
    asked = {kind: path for kind, path in wanted.items() if path is not None}
    if not asked:
        return {}
    from cutwise.io.files import write_text
    from cutwise.io.programs import post
    from cutwise.process.chamfer_program import program_of

    if "program" not in result.stages.children:
        print("no program was written: there is no path", file=sys.stderr)
        return {}
    if result.infeasible:
        print("no program was written: the operation is infeasible as it stands", file=sys.stderr)
        return {}
    program = program_of(result)
    writers = {"gcode": post.gcode, "apt": post.apt, "poses": post.poses_csv}
    return {kind: str(write_text(path, writers[kind](program))) for kind, path in asked.items()}


def _folder_name(name: str) -> str:
    """A scenario name as one folder name on every system."""
    safe = "".join("_" if letter in '<>:"/\\|?*' or ord(letter) < 32 else letter for letter in name)
    return safe.strip(" .") or "unnamed"


def _writable(folder: Path) -> None:
    """Refuse a folder that cannot be made or written to, before any time is spent on the run."""
    import os

    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        _refuse(f"{folder}: {place} is a file, not a folder; name another folder with -o")
    if not os.access(place, os.W_OK | os.X_OK):
        _refuse(f"{folder}: may not be written to (permission denied); name another folder with -o")


def _refuse(message: str) -> NoReturn:
    print(message, file=sys.stderr)
    raise typer.Exit(BAD_INPUT)


def _explain(error: Exception) -> int:
    """Say in plain words what went wrong; the exit code for it."""
    from cutwise.results import SolverFailure
    from cutwise.spec.faults import ScenarioFault

    if isinstance(error, ScenarioFault):
        print(error, file=sys.stderr)
        return BAD_INPUT
    if type(error).__name__ == "CadFault":  # its module is not imported unless a CAD file is
        print(error, file=sys.stderr)
        return BAD_INPUT
    if isinstance(error, SolverFailure):
        print(f"the solver failed: {error}", file=sys.stderr)
        return SOLVER_FAILED
    if isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        print(f"{place}{error.strerror or error}", file=sys.stderr)
        return BAD_INPUT
    print(
        f"cutwise stopped on an error of its own, {type(error).__name__}: {error}\n"
        "please report it with the output of: cutwise --debug ...",
        file=sys.stderr,
    )
    return SOLVER_FAILED


def main(arguments: "Sequence[str] | None" = None) -> NoReturn:
    """Run the command line; leaves with the exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given  # it may stand anywhere
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal that lacks a letter gets a question mark, not a traceback
    with interrupt.watched():
        code = _code([argument for argument in given if argument != "--debug"], debug)
    if code == INTERRUPTED:
        print("interrupted", file=sys.stderr)
    sys.exit(code)


def _code(arguments: "Sequence[str]", debug: bool) -> int:
    """Run a command; the exit code that it comes to."""
    try:
        app(arguments, prog_name="cutwise")
    except KeyboardInterrupt:
        return INTERRUPTED
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else OK
    except BrokenPipeError:
        sys.stderr.close()
    except Exception as error:
        if interrupt.asked():
            return INTERRUPTED
        if debug:
            raise
        return _explain(error)
    return OK
