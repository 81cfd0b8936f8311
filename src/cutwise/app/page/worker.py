"""The process that computes for the page: it keeps the engine loaded, and takes one job after another.

A job is a line of JSON on standard input; what comes of it are lines of JSON on standard output. What kernels print goes
to standard error. SIGINT stops the job and not the process.
"""

import json
import os
import signal
import sys
import time
from pathlib import Path
from types import FrameType
from typing import Any, TextIO

_OFTEN = 0.1  # [s] between two words about progress


class Worker:
    """Takes jobs until nobody sends any more."""

    def __init__(self, replies: TextIO) -> None:
        self.replies = replies
        self.busy = self.asked = False  # to stop: the compiler swallows an interrupt that meets it in a callback

    def say(self, **told: Any) -> None:
        """Send one line."""
        print(json.dumps(told), file=self.replies, flush=True)

    def interrupted(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        """A signal stops what is being done; there may be nothing.

        A module that is being imported is finished first: what is left of one that was broken off would break the next job.
        """
        if self.busy:
            self.asked = True
            if not _importing(frame):
                self.busy = False
                raise KeyboardInterrupt

    def take(self, job: dict[str, Any]) -> None:
        """Do a job and say what came of it."""
        from cutwise.disk import in_words
        from cutwise.results import Infeasible, SolverFailure
        from cutwise.spec.faults import ScenarioFault, dotted

        number = job["job"]
        try:
            self.busy, self.asked = True, False
            done = {"run": self.run, "keep": self.keep}[job["kind"]](job)
            self.busy = False
            if self.asked:
                raise KeyboardInterrupt
            self.say(job=number, state="done", **done)
        except KeyboardInterrupt:
            self.say(job=number, state="cancelled")
        except ScenarioFault as fault:
            told = [{"key": dotted(one.path) or one.file, "text": str(one)} for one in fault.faults]
            self.say(job=number, state="failed", text=str(fault), faults=told)
        except Infeasible as why:
            self.say(job=number, state="failed", text=f"infeasible: {why}")
        except SolverFailure as why:
            self.say(job=number, state="failed", text=f"the solver failed: {why}")
        except OSError as error:
            self.say(job=number, state="failed", text=f"{error.filename or ''}: {in_words(error)}".removeprefix(": "))
        except Exception as error:
            state = "cancelled" if self.asked else "failed"
            self.say(
                job=number, state=state, text=f"cutwise stopped on an error of its own, {type(error).__name__}: {error}"
            )
        finally:
            self.busy = False

    def run(self, job: dict[str, Any]) -> dict[str, Any]:
        """Run a scenario with some values changed, and write the run where it is asked for."""
        from cutwise.app.verdict_text import verdict_line
        from cutwise.disk import write_bytes
        from cutwise.io.scenario import parse
        from cutwise.study.band import simulate

        last = 0.0

        def progress(share: float) -> None:
            nonlocal last
            if self.asked:
                raise KeyboardInterrupt
            if time.monotonic() - last > _OFTEN:
                last = time.monotonic()
                self.say(job=job["job"], state="running", progress=round(share, 4))

        scenario = parse(
            job["text"], job["name"], job["edits"], folder=Path(job["folder"]), title=job["title"], named="{}"
        )
        result = simulate(scenario, progress)
        write_bytes(Path(job["out"]), result.to_bytes())
        return {"verdict": result.verdict, "text": verdict_line(result)}

    def keep(self, job: dict[str, Any]) -> dict[str, Any]:
        """Write a run as ``cutwise run`` does, with advice and report."""
        from cutwise.app.writing import written
        from cutwise.disk import file_name
        from cutwise.io.scenario import load
        from cutwise.results import Result
        from cutwise.study.review import reviewed

        scenario = load(job["run"])
        result = reviewed(Result.from_file(job["run"], scenario))
        return {"files": written(result, Path(job["folder"]) / file_name(scenario.name), True)}


def _importing(frame: FrameType | None) -> bool:
    """Whether a module is being imported at a place."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def main() -> None:
    """Take jobs from standard input until it ends."""
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    worker = Worker(replies)
    signal.signal(signal.SIGINT, worker.interrupted)
    import cutwise.study.band  # the engine, before it is asked for  # noqa: F401

    worker.say(state="ready")
    for line in sys.stdin:
        worker.take(json.loads(line))


if __name__ == "__main__":
    main()
