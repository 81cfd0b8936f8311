"""Arguments that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

from cutwise.app.complete import assignments

ScenarioFile = Annotated[Path, typer.Argument(metavar="FILE", help="scenario (YAML or JSON), run file or HTML report")]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="replace a value, for example operation.feed='60 mm/s'; repeatable",
        autocompletion=assignments,
    ),
]

SET = "--set {}"
"""How messages name an override that came from the command line."""
