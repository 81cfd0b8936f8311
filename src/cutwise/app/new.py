"""``cutwise new``: a scenario to begin with, and its schema beside it for editors."""

from pathlib import Path
from typing import Annotated

import typer

from cutwise.app import outputs
from cutwise.app.complete import kinds
from cutwise.app.exits import refuse
from cutwise.disk import create_text, write_text

_GOES_WITH = {"--program": "mill", "--tool-diameter": "mill", "--step": "chamfer"}


def new(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="process, for example deburr", autocompletion=kinds)
    ],
    program: Annotated[
        Path | None, typer.Option("--program", metavar="FILE", help="NC program to mill: stock, speed and tool from it")
    ] = None,
    diameter: Annotated[
        str | None, typer.Option("--tool-diameter", metavar="LENGTH", help="of the tool of the program, for example '20 mm'")
    ] = None,
    step: Annotated[
        Path | None, typer.Option("--step", metavar="FILE", help="STEP part to chamfer: its edges and holes are listed")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE",
                     help="where to write it; default: named after kind, program or part; - prints it"),
    ] = None,
    schema: Annotated[
        bool, typer.Option("--schema/--no-schema", help="put the schema beside it, for editors that complete and check")
    ] = True,
) -> None:  # fmt: skip
    """Write a commented scenario to begin with."""
    import json

    from cutwise.io.template import SCHEMAS, schema_line
    from cutwise.spec.schema import schema as json_schema

    _checked(kind, {"--program": program, "--tool-diameter": diameter, "--step": step})
    source = program or step
    path = output or Path(f"{source.stem}.yaml" if source is not None else f"{kind}.yaml")
    text = _text(kind, program, diameter, step, Path() if str(output) == "-" else path.parent)
    if str(output) == "-":
        print(text, end="")
        return
    outputs.checked([path], [source] if source is not None else [])
    try:
        create_text(path, f"{schema_line(kind)}\n{text}" if schema else text)
    except FileExistsError:
        refuse(f"{path}: is there already; name another file with -o")
    if schema and path.is_file():
        write_text(path.parent / SCHEMAS / f"{kind}.json", json.dumps(json_schema(kind), indent=1) + "\n")
    print(f"{path}\nnext: cutwise check {path}; cutwise run {path}")


def _checked(kind: str, given: dict[str, object]) -> None:
    """Refuse options that say nothing to this kind."""
    wrong = [
        f"{option}: goes with {of}, not with {kind}"
        for option, of in _GOES_WITH.items()
        if given[option] is not None and kind != of
    ]
    if given["--tool-diameter"] is not None and given["--program"] is None and not wrong:
        wrong.append("--tool-diameter: goes with --program")
    if wrong:
        refuse("\n".join(wrong))


def _text(kind: str, program: Path | None, diameter: str | None, step: Path | None, beside: Path) -> str:
    from cutwise.app import starting
    from cutwise.io.template import template

    if program is not None:
        return starting.milled(program, diameter, beside)
    if step is not None:
        return starting.chamfered(step, beside)
    return template(kind)
