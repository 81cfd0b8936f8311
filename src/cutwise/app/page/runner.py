"""One job at a time, in one process that stays; who waits for it is told how it goes."""

import asyncio
import json
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

_PATIENCE = 2.0  # [s] between asking a job to stop and ending its process
_LONGEST_LINE = 16 * 1024 * 1024
_BEAT = 15.0  # [s] between two signs of life to who waits


class Busy(Exception):
    """A job of somebody else is running."""


@dataclass(slots=True)
class Told:
    """How the job goes: ``idle``, ``running``, ``done``, ``failed``, ``cancelled`` or ``killed``."""

    state: str = "idle"
    more: dict[str, Any] = field(default_factory=dict)

    def as_json(self) -> str:
        """One object."""
        return json.dumps({"state": self.state, **self.more})


class Runner:
    """Runs jobs in a child of its own session; a job that is asked to stop and does not is ended with its process."""

    def __init__(self) -> None:
        self.told = Told()
        self.owner = ""
        self._job: Mapping[str, Any] = {}
        self._count = 0
        self._child: asyncio.subprocess.Process | None = None
        self._task: asyncio.Task[None] | None = None
        self._changed = asyncio.Condition()
        self._stopping = False
        self._closed = False

    @property
    def running(self) -> bool:
        """Whether a job is being done."""
        return self._task is not None and not self._task.done()

    async def warm(self) -> None:
        """Have the process loaded before it is needed."""
        with suppress(OSError):
            await self._alive()

    async def start(
        self, job: Mapping[str, Any], *, owner: str, ended: Callable[[dict[str, Any]], dict[str, Any]]
    ) -> None:
        """Begin a job; one of the same owner that is running is stopped first.

        Parameters
        ----------
        job : mapping
            What :mod:`cutwise.app.page.worker` takes.
        owner : str
            Who asks: a tab of the browser.
        ended : callable
            Called with what came of a job that is done; what it gives back is told to who waits.

        Raises
        ------
        Busy
            A job of another owner is running, or the same job.
        """
        if self.running:
            if owner != self.owner or dict(job) == {**self._job, "out": job.get("out")}:
                raise Busy
            await self.cancel()
        self.owner, self._job, self._stopping = owner, dict(job), False
        self._count += 1
        await self._tell(Told("running", {"progress": 0.0, "kind": job["kind"]}))
        self._task = asyncio.create_task(self._done(self._count, dict(job), ended))

    async def cancel(self) -> None:
        """Stop the job: politely, then by ending its process."""
        task, child = self._task, self._child
        if task is None or task.done():
            return
        self._stopping = True
        _signal(child, signal.SIGINT)
        with suppress(TimeoutError):
            await asyncio.wait_for(asyncio.shield(task), _PATIENCE)
        if not task.done():
            self._end()
            await task

    async def close(self) -> None:
        """End the process."""
        self._closed = True
        self._end()
        if self._task is not None:
            with suppress(Exception):
                await asyncio.wait_for(self._task, _PATIENCE)
        if self._child is not None:
            with suppress(Exception):
                await asyncio.wait_for(self._child.wait(), _PATIENCE)
        async with self._changed:
            self._changed.notify_all()

    async def events(self) -> AsyncIterator[str]:
        """How the job goes, until it has ended."""
        last: str | None = None
        while True:
            now = self.told.as_json()
            if now != last:
                last = now
                yield f"data: {now}\n\n"
            if self._closed or self.told.state != "running":
                return
            try:
                async with self._changed:
                    if self.told.as_json() == last and not self._closed:
                        await asyncio.wait_for(self._changed.wait(), _BEAT)
            except TimeoutError:
                yield ": still here\n\n"

    # ----------------------------------------------------------------------------------------------------------------
    async def _done(self, number: int, job: dict[str, Any], ended: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
        try:
            answer = await self._answer(number, job)
        except OSError as error:
            answer = {"state": "failed", "text": f"no process to compute in: {error.strerror}"}
        state = answer.pop("state")
        if self._stopping and state != "done":
            state, answer = "cancelled", {}  # whoever asked for it, however it ended
        if state == "done":
            answer = await asyncio.to_thread(ended, answer)
        await self._tell(Told(state, answer))

    async def _answer(self, number: int, job: dict[str, Any]) -> dict[str, Any]:
        child = await self._alive()
        if self._stopping:
            return {"state": "cancelled"}
        assert child.stdin is not None
        assert child.stdout is not None
        with suppress(OSError):
            child.stdin.write(json.dumps({**job, "job": number}).encode() + b"\n")
            await child.stdin.drain()
        while line := await child.stdout.readline():
            told = json.loads(line)
            if told.pop("job", None) != number:
                continue  # of a job before
            if told["state"] != "running":
                return dict(told)
            if not self._stopping:
                await self._tell(Told("running", {"progress": told["progress"], "kind": job["kind"]}))
        code = await child.wait()
        self._child = None
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        return {"state": "killed", "text": f"the process that computes was ended from outside ({how}); run again"}

    async def _alive(self) -> asyncio.subprocess.Process:
        """The child, begun if there is none."""
        if self._child is not None and self._child.returncode is None:
            return self._child
        self._child = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "cutwise.app.page.worker", stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL, start_new_session=True, limit=_LONGEST_LINE,
        )  # fmt: skip
        return self._child

    def _end(self) -> None:
        """End the child with all that it has begun."""
        child = self._child
        if child is None or child.returncode is not None:
            return
        with suppress(ProcessLookupError):
            if hasattr(os, "killpg"):
                os.killpg(child.pid, signal.SIGKILL)
            else:
                child.kill()

    async def _tell(self, told: Told) -> None:
        async with self._changed:
            self.told = told
            self._changed.notify_all()


def _signal(child: asyncio.subprocess.Process | None, number: int) -> None:
    if child is not None and child.returncode is None:
        with suppress(ProcessLookupError, ValueError):
            child.send_signal(number)
