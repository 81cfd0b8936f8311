"""The files of a run: the run itself, its report, and the programs of its tool path."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from cutwise.app import interrupt
from cutwise.disk import write_text, write_together

if TYPE_CHECKING:
    from cutwise.results import Result

RUN, REPORT = "run.nc", "report.html"


def written(result: "Result", folder: Path, with_report: bool, viewer: bool = True) -> dict[str, str]:
    """Write the files of a run, all of them or none; a report of an earlier run does not stay beside this one."""
    interrupt.stop_if_asked()

    html = None
    if with_report:
        from cutwise.app.report import render

        html = render(result, viewer=viewer)
    contents = {RUN: result.to_bytes()}
    if html is not None:
        contents[REPORT] = html.encode("utf-8", errors="replace")
    paths = write_together(folder, contents, without=() if html is not None else (REPORT,))
    return {kind: str(path) for kind, path in zip(("run", "report"), paths, strict=False)}


def programs(result: "Result", wanted: dict[str, Path | None]) -> dict[str, str]:
    """Write the programs that were asked for; a run without a path has none."""
    asked = {kind: path for kind, path in wanted.items() if path is not None}
    if not asked:
        return {}
    from cutwise.process.chamfer_program import program_of
    from cutwise.programs import post

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
