"""``cutwise compare``: scenarios, programs or cases of one scenario side by side."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutwise.app.exits import OK, REQUIREMENT_FAILED, refuse
from cutwise.app.options import SET, Overrides

if TYPE_CHECKING:
    from cutwise.spec.scenario import Scenario

_SCENARIOS = (".yaml", ".yml", ".json")


def compare(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="scenarios; a program (.nc) stands for the first scenario with that program; one "
                       "scenario alone: its compare.cases"),
    ],
    overrides: Overrides = None,
    measure: Annotated[
        list[str] | None, typer.Option("--measure", metavar="NAME", help="measures to show; default time, load, errors, cost")
    ] = None,
    draws: Annotated[int | None, typer.Option("--draws", metavar="N", min=8, help="draws of what is uncertain")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object (SI) and nothing else")] = False,
) -> None:  # fmt: skip
    """Hold scenarios side by side: time, load, errors, cost of a part, and which differences can be told."""
    from cutwise.app.console import Console
    from cutwise.spec.comparison import Comparison
    from cutwise.study import comparison

    scenarios = _scenarios(files, [*(overrides or ())])
    first = next(iter(scenarios.values()))
    unknown = [name for name in measure or () if all(name not in type(one).measures for one in scenarios.values())]
    if unknown:
        refuse(f"--measure {unknown[0]}: is no measure of these scenarios")
    said = first.compare or Comparison()
    if draws is not None:
        said = Comparison.model_validate({**said.model_dump(exclude_unset=True), "draws": draws})
    console = Console()
    with console.progress("compare") as progress:
        found = comparison.compare(scenarios, said, measure or (), progress)
    if as_json:
        import json

        print(json.dumps(found.as_json(), allow_nan=False))
    else:
        for line in comparison.shown(found):
            console.line(line)
    failed = any(case.result.verdict == "fail" for case in found.cases)
    raise typer.Exit(REQUIREMENT_FAILED if failed else OK)


def _scenarios(files: list[Path], overrides: list[str]) -> "dict[str, Scenario]":
    """Scenarios by name; of files of one name by their paths."""
    from cutwise.io.scenario import load
    from cutwise.study.comparison import cases_of

    if files[0].suffix not in _SCENARIOS:
        refuse(f"{files[0]}: is no scenario (.yaml, .json); the first file is one, programs may follow")
    if len(files) == 1:
        return cases_of(load(files[0], overrides, named=SET))
    found: dict[str, Scenario] = {}
    for file in files:
        program = [] if file.suffix in _SCENARIOS else [f"program={file}"]
        scenario = load(files[0] if program else file, [*overrides, *program], named=SET)
        name = file.name if program else scenario.name
        found[name if name not in found else str(file)] = scenario
    if len(found) < len(files):
        refuse("a file is named twice; give different ones")
    return found
