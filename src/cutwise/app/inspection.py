"""Commands that look at one thing without running it: a STEP part, an NC program, the spindle of a scenario."""

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from cutwise.app import outputs
from cutwise.app.exits import refuse
from cutwise.app.options import SET, Overrides, ScenarioFile
from cutwise.disk import write_text


def part(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="STEP file")],
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI)")] = False,
    picture: Annotated[Path | None, typer.Option("--svg", metavar="FILE", help="draw the sharp edges")] = None,
) -> None:
    """List solids, holes and sharp edges of a STEP file, with the numbers that a chamfer scenario selects them by."""
    from cutwise.app.console import Console
    from cutwise.app.parts import draw, listing, shown
    from cutwise.io.occ import CadFault

    outputs.checked([picture], [file])
    try:
        with Console().progress(f"edges of {file.name}") as done:
            found = listing(file, done)
    except CadFault as fault:
        refuse(str(fault))
    if as_json:
        import json

        print(json.dumps(found.as_json(), allow_nan=False))
    else:
        print(shown(found))
    if picture is not None:
        write_text(picture, draw(found))
        print(picture, file=sys.stderr)


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
    dialect: Annotated[
        Literal["auto", "rs274", "fanuc"], typer.Option(help="of G-code; auto: fanuc where the program shows macro B")
    ] = "auto",
    step_limit: Annotated[
        int | None,
        typer.Option(
            min=1, metavar="N", help="steps not written out (loops, repeats, pecks) before it counts as endless"
        ),
    ] = None,
) -> None:
    """Run through an NC program without a machine: tools, feeds, extents, lengths, time, and all its faults."""
    from cutwise.app.programs import Sketch, opened
    from cutwise.io.program_setup import SUBROUTINE_SUFFIXES
    from cutwise.programs import canonical_text, summary

    called = outputs.beside(file, SUBROUTINE_SUFFIXES) if picture is not None else []
    outputs.checked([picture], [file, *([tool_table] if tool_table is not None else []), *called])
    run, setup, notices = opened(file, tool_table, dialect, step_limit)
    if canonical:
        lines = list(canonical_text.lines(run.commands()))  # first all of them: a faulty program prints none
        print("\n".join(lines))
        return
    sketch = Sketch() if picture is not None else None
    found = summary.summarise(run, setup, sketch.add if sketch is not None else None)
    found = found._replace(notices=(*found.notices, *notices))
    if as_json:
        import json

        print(json.dumps({"file": str(file), **summary.as_json(found)}, allow_nan=False))
    else:
        print(summary.shown(str(file), found))
    if picture is not None and sketch is not None:
        write_text(picture, sketch.svg(file.name))
        print(picture, file=sys.stderr)


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

    scenario = load(file, overrides or (), named=SET)
    outputs.checked([output], [file, *scenario.files])
    try:
        found = sheets.sheet(scenario)
        tip = [units.parse(part.strip(), "length") for part in deflection.split(",")]
        if len(tip) != 2:
            raise ValueError(f"--deflection {deflection}: write two lengths, for example '1 mm, 2 mm'")
    except ValueError as fault:
        refuse(str(fault))
    if as_json:
        import json

        print(json.dumps(found.as_json(), allow_nan=False))
    else:
        print(sheets.shown(found))
    if output is not None:
        print(sheets.export(found, output, (tip[0], tip[1])), file=sys.stderr)
