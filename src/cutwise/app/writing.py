"""The files of a run: the run itself, its report, and the programs of its tool path."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from cutwise.app import interrupt

if TYPE_CHECKING:
    from cutwise.results import Result


def written(result: "Result", folder: Path, with_report: bool) -> dict[str, str]:
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


def programs(result: "Result", wanted: dict[str, Path | None]) -> dict[str, str]:
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
    files = {}
    for kind, path in asked.items():
        try:
            files[kind] = str(write_text(path, writers[kind](program)))
        except post.SetupFault as fault:
            print(f"no {kind} was written: {fault}", file=sys.stderr)
    return files


def folder_name(name: str) -> str:
    """A scenario name as one folder name on every system."""
    safe = "".join("_" if letter in '<>:"/\\|?*' or ord(letter) < 32 else letter for letter in name)
    return safe.strip(" .") or "unnamed"
