"""The page over HTTP, for one person on one machine: what is asked for, and what answers."""

import asyncio
import json
import signal
import socket
import tempfile
from collections.abc import Callable, Mapping
from contextlib import contextmanager, suppress
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import uvicorn
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route

from cutwise.app.page import peers
from cutwise.app.page.desk import RUNS, Desk, Refused, Target
from cutwise.app.page.guard import Guard, Protocol, Tokens
from cutwise.app.page.runner import Busy, Runner
from cutwise.disk import in_words

if TYPE_CHECKING:
    from cutwise.app.page.studied import Studied

_MOST_BODY = 1_000_000  # bytes of a request that is no file
_MOST_EDITS, _LONGEST_KEY = 300, 500  # a check of thousands would keep everybody else waiting
MOST_FILE, MOST_FILES = 50_000_000, 500_000_000
_KINDS = {
    ".js": "text/javascript",
    ".css": "text/css",
    ".html": "text/html",
    ".txt": "text/plain",
    ".svg": "image/svg+xml",
}
_NO_BUNDLE = "The viewer is not part of this installation: the report of the run has its pictures."


class Page:
    """Answers requests that the guard has let through."""

    def __init__(self, desk: Desk | None, study: "Studied | str", runner: Runner) -> None:
        self.desk, self.study, self.runner = desk, study, runner
        self.received = 0  # bytes of files
        self.static = _bundle()

    def routes(self) -> list[Route]:
        """All addresses; none of them holds a path of the disk."""
        if self.desk is None:
            return [Route("/", self.begin)]
        return [
            Route("/", self.begin),
            Route("/static/{name}", self.asset),
            Route("/api/run/{number:int}/view", self.view),
            Route("/api/check", self.check, methods=["POST"]),
            Route("/api/save", self.save, methods=["POST"]),
            Route("/api/keep/{number:int}", self.keep, methods=["POST"]),
            Route("/api/files", self.upload, methods=["POST"]),
            Route("/api/job", self.job, methods=["POST"]),
            Route("/api/job/cancel", self.cancel, methods=["POST"]),
            Route("/api/job/events", self.events),
            *([] if isinstance(self.study, str) else self._of_a_study()),
        ]

    def _of_a_study(self) -> list[Route]:
        return [
            Route("/study", self.report),
            Route("/api/study", self.points),
            Route("/api/case/{number:int}", self.case, methods=["POST"]),
        ]

    async def begin(self, request: Request) -> Response:
        """The page."""
        if request.url.query:
            raise HTTPException(404)
        if self.desk is None:
            assert isinstance(self.study, str)
            return HTMLResponse(self.study)
        runs = self.desk.shown
        study = "" if isinstance(self.study, str) else ' data-study="1"'
        script = '<script src="/static/view.js"></script>' if "view.js" in self.static else f"<p>{_NO_BUNDLE}</p>"
        return HTMLResponse(
            f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
            f'<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
            f'<link rel="icon" href="data:,"><link rel="stylesheet" href="/static/view.css">'
            f"<title>{escape(self.desk.title)} – cutwise</title></head><body>"
            f'<main id="cutwise-view" data-run="{runs[0] if runs else ""}"'
            f'{f""" data-other="{runs[1]}" """ if len(runs) > 1 else ""}{study}></main>{script}</body></html>'
        )

    async def asset(self, request: Request) -> Response:
        """A file of the bundle, by its name alone."""
        found = self.static.get(request.path_params["name"])
        if found is None:
            raise HTTPException(404)
        return Response(found[1], media_type=found[0])

    async def view(self, request: Request) -> Response:
        """What there is to see of a run."""
        packed = await asyncio.to_thread(self._desk.view, request.path_params["number"])
        return Response(packed, media_type="application/octet-stream")

    async def check(self, request: Request) -> Response:
        """Keys, and the faults of the scenario with these edits."""
        edits = _edits(await _object(request))
        return JSONResponse(await asyncio.to_thread(self._desk.check, edits))

    async def save(self, request: Request) -> Response:
        """Write the scenario with these edits."""
        asked = await _object(request)
        name = asked.get("as")
        if name is not None and not isinstance(name, str):
            raise Refused(400, '"as" is a name of a file')
        return JSONResponse({"file": await asyncio.to_thread(self._desk.save, _edits(asked), name)})

    async def job(self, request: Request) -> Response:
        """Run the scenario with these edits."""
        asked = await _object(request)
        edits, owner = _edits(asked), asked.get("tab", "")
        found = await asyncio.to_thread(self._desk.check, edits)
        if found["faults"]:
            return JSONResponse({"faults": found["faults"]}, 400)
        return JSONResponse({"state": "running", "run": await self._begun_run(edits, str(owner))}, 202)

    async def _begun_run(self, edits: Mapping[str, str], owner: str) -> int:
        """Begin a run with these edits; its number."""
        desk = self._desk
        number = desk.next_run()

        def ended(told: dict[str, Any]) -> dict[str, Any]:
            desk.made(number)
            return {**told, "run": number}

        job = {**desk.job(edits), "out": str(desk.runs[number])}
        await self._begun(job, owner, ended)
        return number

    async def report(self, request: Request) -> Response:  # noqa: ARG002
        """What the study wrote into its folder."""
        assert not isinstance(self.study, str)
        return HTMLResponse(self.study.report)

    async def points(self, request: Request) -> Response:  # noqa: ARG002
        """The cases of the study."""
        assert not isinstance(self.study, str)
        return JSONResponse(await asyncio.to_thread(self.study.told))

    async def case(self, request: Request) -> Response:
        """Run a case of the study again, with everything that a run tells."""
        assert not isinstance(self.study, str)
        asked = await _object(request)
        edits, command = self.study.case(request.path_params["number"])
        number = await self._begun_run(edits, str(asked.get("tab", "")))
        return JSONResponse({"state": "running", "run": number, "edits": edits, "command": command}, 202)

    async def keep(self, request: Request) -> Response:
        """Write a run where ``cutwise run`` writes it."""
        await _object(request)
        file = self._desk.run(request.path_params["number"])
        job = {"kind": "keep", "run": str(file), "folder": str(RUNS.absolute())}
        await self._begun(job, "keep", lambda told: told)
        return JSONResponse({"state": "running"}, 202)

    async def _begun(
        self, job: Mapping[str, Any], owner: str, ended: Callable[[dict[str, Any]], dict[str, Any]]
    ) -> None:
        try:
            await self.runner.start(job, owner=owner, ended=ended)
        except Busy:
            raise Refused(409, "a job is running already: it is shown; cancel it first") from None

    async def cancel(self, request: Request) -> Response:
        """Stop the job."""
        await _object(request)
        await self.runner.cancel()
        return JSONResponse({"state": "cancelled"})

    async def events(self, request: Request) -> Response:  # noqa: ARG002
        """How the job goes, as it goes."""
        return StreamingResponse(self.runner.events(), media_type="text/event-stream")

    async def upload(self, request: Request) -> Response:
        """Take a file: counted as it comes, whatever its sender says."""
        name = request.query_params.get("name", "")
        place = self._desk.upload_place(name)
        if int(request.headers.get("content-length", "0")) > MOST_FILE:
            raise Refused(413, f"files are at most {MOST_FILE // 1_000_000} MB")
        size = 0
        try:
            with place.open("xb") as file:
                async for part in request.stream():
                    size += len(part)
                    self.received += len(part)
                    if size > MOST_FILE or self.received > MOST_FILES:
                        most = MOST_FILE if size > MOST_FILE else MOST_FILES
                        raise Refused(
                            413, f"files are at most {most // 1_000_000} MB{'' if size > MOST_FILE else ' together'}"
                        )
                    file.write(part)
        except BaseException:
            self.received -= size
            place.unlink(missing_ok=True)
            raise
        return JSONResponse({"file": self._desk.uploaded(place, name), "name": name, "bytes": size}, 201)

    @property
    def _desk(self) -> Desk:
        assert self.desk is not None
        return self.desk


def _bundle() -> dict[str, tuple[str, bytes]]:
    """Media type and content of the files of the viewer, by name."""
    folder = files("cutwise.app.page") / "static"
    if not folder.is_dir():
        return {}
    found = {one.name: one for one in folder.iterdir() if one.is_file() and Path(one.name).suffix in _KINDS}
    return {name: (_KINDS[Path(name).suffix], one.read_bytes()) for name, one in found.items()}


async def _object(request: Request) -> dict[str, Any]:
    """The object that a request brings."""
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > _MOST_BODY:
            raise Refused(413, f"a request holds at most {_MOST_BODY // 1_000_000} MB")
    try:
        found = json.loads(body or b"{}")
    except (ValueError, RecursionError):
        raise Refused(400, "this is not JSON") from None
    if not isinstance(found, dict):
        raise Refused(400, "an object is expected")
    return found


def _edits(asked: Mapping[str, Any]) -> dict[str, str]:
    edits = asked.get("edits", {})
    if not isinstance(edits, dict) or not all(isinstance(value, str) for value in edits.values()):
        raise Refused(400, "edits are dotted keys with their values as texts")
    if len(edits) > _MOST_EDITS or any(len(key) > _LONGEST_KEY for key in edits):
        raise Refused(400, f"at most {_MOST_EDITS} values are changed at a time, by keys of {_LONGEST_KEY} characters")
    return edits


async def _refused(request: Request, why: Exception) -> Response:  # noqa: ARG001
    assert isinstance(why, Refused)
    headers = {"connection": "close"} if why.status == 413 else None  # what is still coming is not read
    return PlainTextResponse(why.why, why.status, headers=headers)


async def _no_room(request: Request, why: Exception) -> Response:  # noqa: ARG001
    """A file that cannot be read or written: what a person can do about it."""
    assert isinstance(why, OSError)
    return PlainTextResponse(f"{Path(str(why.filename or '')).name}: {in_words(why)}".removeprefix(": "), 507)


async def _failed(request: Request, why: Exception) -> Response:  # noqa: ARG001
    return PlainTextResponse(f"cutwise stopped on an error of its own, {type(why).__name__}: {why}", 500)


class _Server(uvicorn.Server):
    """uvicorn, which is told to stop by us: of its own it ends with the signal again, and the way out is no failure."""

    @contextmanager
    def capture_signals(self) -> Any:
        yield


def serve(
    targets: tuple[Target, ...], study: "Studied | str", listener: socket.socket, *, announced: Callable[[Tokens], None]
) -> None:
    """Serve until a signal comes; the job is stopped and the private folder gone when this returns.

    Parameters
    ----------
    targets : tuple
        What is opened: one, or two to be compared; none for the page of a study.
    study : Studied or str
        The study whose scenario is the target; or that page, where its cases cannot be run one by one.
    listener : socket
        Bound to 127.0.0.1, listening or not.
    announced : callable
        Called with the tokens as soon as requests are answered.
    """
    with tempfile.TemporaryDirectory(prefix="cutwise-view-", ignore_cleanup_errors=True) as folder:
        desk = Desk(targets[0], targets[1:], Path(folder)) if targets else None
        asyncio.run(_serve(desk, study, listener, announced))


async def _serve(
    desk: Desk | None, study: "Studied | str", listener: socket.socket, announced: Callable[[Tokens], None]
) -> None:
    runner, tokens = Runner(), Tokens()
    page = Page(desk, study, runner)
    app = Starlette(routes=page.routes(), exception_handlers={Refused: _refused, OSError: _no_room, Exception: _failed})
    app.router.redirect_slashes = False
    guarded = Guard(
        app, port=listener.getsockname()[1], tokens=tokens, same_user=peers.same_user if peers.known() else None
    )
    config = uvicorn.Config(
        guarded, http=Protocol, ws="none", lifespan="off", log_config=None, access_log=False, proxy_headers=False,
        server_header=False, timeout_graceful_shutdown=1, timeout_keep_alive=30, limit_concurrency=200,
        h11_max_incomplete_event_size=64 * 1024,
    )  # fmt: skip
    server = _Server(config)

    def stop(*_: Any) -> None:
        server.should_exit = True

    with _signals(stop):
        ready = asyncio.create_task(_when_started(server, lambda: announced(tokens)))
        warming = asyncio.create_task(runner.warm()) if desk is not None else None
        closing = asyncio.create_task(_close_when_stopped(server, runner))
        try:
            await server.serve(sockets=[listener])
        finally:
            server.should_exit = True
            for task in filter(None, (ready, warming)):
                task.cancel()
            with suppress(Exception):
                await closing


async def _when_started(server: uvicorn.Server, do: Callable[[], None]) -> None:
    while not server.started:
        await asyncio.sleep(0.01)
    await asyncio.to_thread(do)


async def _close_when_stopped(server: uvicorn.Server, runner: Runner) -> None:
    """End the job as soon as the server is told to stop: who waits for its events lets go then."""
    while not server.should_exit:
        await asyncio.sleep(0.05)
    await runner.close()


@contextmanager
def _signals(stop: Callable[..., None]) -> Any:
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)]
    before = {number: signal.signal(number, stop) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
