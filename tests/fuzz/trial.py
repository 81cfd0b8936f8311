"""Commands run on hostile inputs in processes that may come to harm: what crashes, hangs or swells is counted."""

import contextlib
import io
import multiprocessing
import os
import resource
import signal
import time
import traceback
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from cutwise.app import cli, exits

CPU = 20.0  # [s] an input may take
MEMORY = 0.7e9  # [bytes] a process may take beyond what it is started with


class Trial(NamedTuple):
    """A command on an input."""

    name: str
    arguments: tuple[str, ...]
    files: tuple[tuple[str, bytes], ...]  # written beside each other before
    allowed: tuple[int, ...] = (0, 2)


class Harm(NamedTuple):
    """What a trial did that it must not."""

    trial: Trial
    kind: str  # crash, hang, memory, code
    said: str

    def __str__(self) -> str:
        return f"{self.trial.name}: {self.kind}: cutwise {' '.join(self.trial.arguments)[:200]}\n{self.said[-1500:]}"


def harms(trials: Iterable[Trial], folder: Path, most: int = 20) -> Iterator[Harm]:
    """Run trials one after the other in a child that is replaced when it dies; give back those that did harm."""
    context = multiprocessing.get_context("fork")
    child, pipe = None, None
    found = 0
    for trial in trials:
        if child is None or not child.is_alive():
            pipe, end = context.Pipe()
            child = context.Process(target=_serve, args=(end, folder), daemon=True)
            child.start()
            end.close()
        harm = _harm(trial, child, pipe)
        if harm is not None:
            child = None
            found += 1
            yield harm
            if found >= most:
                return
    if child is not None:
        pipe.send(None)
        child.join(5.0)


def _harm(trial: Trial, child, pipe) -> Harm | None:
    pipe.send(trial)
    try:
        if not pipe.poll(40.0 * CPU):
            child.kill()
            child.join()
            return Harm(trial, "hang", f"no answer after {40.0 * CPU:.0f} s")
        kind, said = pipe.recv()
    except EOFError:
        child.join()
        signalled = -(child.exitcode or 0)
        kind = "hang" if signalled in (signal.SIGXCPU, signal.SIGKILL) else "crash"
        return Harm(trial, kind, f"the process ended with {child.exitcode}")
    if kind:
        child.kill()
        child.join()
        return Harm(trial, kind, said)
    return None


def _serve(pipe, folder: Path) -> None:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    began = _peak()  # that of the process of the tests, of which this one is a copy
    resource.setrlimit(resource.RLIMIT_AS, (int(began + 12 * MEMORY),) * 2)  # libraries map much more than they use
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 2)  # libraries in C
    while True:
        trial = pipe.recv()
        if trial is None:
            return
        pipe.send(_tried(trial, folder, began))


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _tried(trial: Trial, folder: Path, began: int) -> tuple[str, str]:
    """What a trial did wrong, empty if nothing, and what it said."""
    for file in folder.iterdir():
        if file.is_file():
            file.unlink()
    for name, content in trial.files:
        (folder / name).write_bytes(content)
    os.chdir(folder)
    used = resource.getrusage(resource.RUSAGE_SELF)
    limit = int(used.ru_utime + used.ru_stime + CPU) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (limit, resource.getrlimit(resource.RLIMIT_CPU)[1]))
    out, err = io.StringIO(), io.StringIO()
    code: object = None
    begun = time.process_time()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = _code(trial.arguments)
    except BaseException:
        return "crash", traceback.format_exc()
    spent = time.process_time() - begun
    said = err.getvalue()
    if code not in trial.allowed or "Traceback" in said:
        return "code", f"exit code {code}\n{said}"
    if code == 2 and not said.strip():
        return "code", "exit code 2 without a word"
    if spent > CPU:
        return "hang", f"{spent:.1f} CPU s"
    size = _peak() - began
    return ("memory", f"{size / 1e9:.2f} GB") if size > MEMORY else ("", "")


def _explained(error: Exception) -> int:
    """As the command line says it, with the trace of an error of its own behind it."""
    code = exits.explain(error)
    if code not in (0, 1, 2):
        traceback.print_exception(error)
    return code


def _code(arguments: tuple[str, ...]) -> object:
    cli.explain = _explained
    try:
        cli.main(arguments)
    except SystemExit as left:
        return left.code
