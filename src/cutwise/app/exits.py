"""How a command ends: exit codes, refusals before any time is spent, and plain words for what went wrong."""

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NoReturn, TextIO

import typer

from cutwise.disk import in_words
from cutwise.spec.texts import visible

OK, REQUIREMENT_FAILED, BAD_INPUT, SOLVER_FAILED = 0, 1, 2, 3
INTERRUPTED, NOBODY_READS, TERMINATED = 130, 141, 143


def refuse(message: str) -> NoReturn:
    print(visible(message), file=sys.stderr)
    raise typer.Exit(BAD_INPUT)


def explain(error: Exception) -> int:
    """Say in plain words what went wrong; the exit code for it."""
    from cutwise.results import Infeasible, SolverFailure
    from cutwise.run_file import DamagedRun
    from cutwise.spec.faults import ScenarioFault

    if isinstance(error, ScenarioFault):
        print(error, file=sys.stderr)
        return BAD_INPUT
    if isinstance(error, DamagedRun):
        print(error, file=sys.stderr)
        return BAD_INPUT
    if type(error).__name__ == "CadFault":  # its module is not imported unless a CAD file is
        print(error, file=sys.stderr)
        return BAD_INPUT
    if isinstance(error, Infeasible):
        print(f"infeasible: {error}", file=sys.stderr)
        return REQUIREMENT_FAILED
    if isinstance(error, SolverFailure):
        print(f"the solver failed: {error}", file=sys.stderr)
        return SOLVER_FAILED
    if isinstance(error, OSError):
        place = f"{error.filename}: " if error.filename else ""
        print(visible(f"{place}{in_words(error)}"), file=sys.stderr)
        return BAD_INPUT
    print(
        f"cutwise stopped on an error of its own, {type(error).__name__}: {error}\n"
        "please report it with the output of: cutwise --debug ...",
        file=sys.stderr,
    )
    return SOLVER_FAILED


def open_streams() -> None:
    """Give a process that was started without standard streams (``>&-``) ones that lead nowhere.

    Else the first file that is opened takes the number of one, and what is said goes into that file.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8", errors="replace", closefd=False))


@contextmanager
def reader_of(stream: TextIO) -> Iterator[Callable[[], bool]]:
    """Tells, within the block, whether the reader of a pipe has gone away."""
    try:
        handle = os.dup(stream.fileno())
    except (OSError, ValueError, AttributeError):  # no stream of the system
        yield lambda: False
        return

    def gone() -> bool:
        if not hasattr(select, "poll"):
            return False
        poll = select.poll()
        poll.register(handle, 0)
        return any(event & select.POLLERR for _, event in poll.poll(0))

    try:
        yield gone
    finally:
        os.close(handle)


def flushed(code: int, *streams: TextIO) -> int:
    """The exit code of a command once all that it said has gone out, or could not."""
    for stream in streams:
        try:
            stream.flush()
        except BrokenPipeError:
            code = NOBODY_READS
            _silence(stream)
        except OSError as error:
            code = BAD_INPUT
            _silence(stream)
            print(f"standard output: {in_words(error)}", file=sys.stderr)
        except ValueError:  # closed
            pass
    return code


def _silence(stream: TextIO) -> None:
    """Let what could not go out go nowhere, or Python complains about it when it ends."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):  # no stream of the system
        pass
