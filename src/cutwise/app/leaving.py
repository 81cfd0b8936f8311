"""How a command ends: exit codes, refusals before any time is spent, and plain words for what went wrong."""

import sys
from pathlib import Path
from typing import NoReturn

import typer

OK, REQUIREMENT_FAILED, BAD_INPUT, SOLVER_FAILED, INTERRUPTED = 0, 1, 2, 3, 130


def writable(folder: Path) -> None:
    """Refuse a folder that cannot be made or written to, before any time is spent on the run."""
    import os

    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        refuse(f"{folder}: {place} is a file, not a folder; name another folder with -o")
    if not os.access(place, os.W_OK | os.X_OK):
        refuse(f"{folder}: may not be written to (permission denied); name another folder with -o")


def refuse(message: str) -> NoReturn:
    print(message, file=sys.stderr)
    raise typer.Exit(BAD_INPUT)


def explain(error: Exception) -> int:
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
