"""What every request has to bring before anything else looks at it: the right host, origin, user and token."""

import asyncio
import hmac
import re
import secrets
import sys
from collections.abc import Callable, Mapping
from typing import Any
from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

MOST_HEADERS = 16 * 1024  # bytes
PATIENCE = 20.0  # [s] for the head of a request, from when its connection or its first byte is there
_ONCE = ("host", "origin", "cookie", "content-length", "sec-fetch-site", "x-cutwise")
_READING = ("GET", "HEAD")
_POLICY = (
    "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
SAFE: Mapping[str, str] = {
    "content-security-policy": _POLICY,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "x-frame-options": "DENY",
    "cache-control": "no-store",
}
SameUser = Callable[[tuple[str, int], tuple[str, int]], bool]


class Tokens:
    """What opens the page: a token that stays, and one that works once, for a browser whose command line others see."""

    def __init__(self) -> None:
        self.stays = secrets.token_urlsafe(32)
        self._once: str | None = secrets.token_urlsafe(32)

    @property
    def once(self) -> str:
        """The token for the browser that is opened."""
        assert self._once is not None
        return self._once

    def fits(self, given: str) -> bool:
        """Whether a token is the one that stays, compared in constant time."""
        return hmac.compare_digest(given.encode(), self.stays.encode())

    def opens(self, given: str) -> bool:
        """Whether a token in an address is one of the two; the second is used up by that."""
        if self.fits(given):
            return True
        if self._once is not None and hmac.compare_digest(given.encode(), self._once.encode()):
            self._once = None
            return True
        return False


class Guard:
    """Lets through what comes from the page of this server, in the browser of this user."""

    def __init__(self, app: ASGIApp, *, port: int, tokens: Tokens, same_user: SameUser | None) -> None:
        self.app, self.port, self.tokens, self.same_user = app, port, tokens, same_user
        self.hosts = (f"127.0.0.1:{port}", f"localhost:{port}")
        self.cookie = f"cutwise-{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return

        async def safely(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(SAFE)
            await send(message)

        answer = self._refusal(scope) or self._welcome(scope)
        await (answer or self.app)(scope, receive, safely)

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        if sum(len(name) + len(value) + 4 for name, value in scope["headers"]) > MOST_HEADERS:
            return PlainTextResponse("refused: more than 16 kB of headers", 431)
        twice = next((name for name in _ONCE if len(headers.getlist(name)) > 1), None)
        if twice is not None:
            return PlainTextResponse(f"refused: {twice} is there twice", 400)
        why = self._stranger(scope, headers)
        return PlainTextResponse(f"refused: {why}", 403) if why else None

    def _stranger(self, scope: Scope, headers: Headers) -> str:
        """What is wrong with where a request comes from; nothing if it is in order."""
        if self.same_user is not None and not self._of_this_user(scope):
            return "another user of this machine"
        if headers.get("host") not in self.hosts:
            return "Host"
        origin = headers.get("origin")
        if origin is not None and origin != f"http://{headers['host']}":
            return "Origin"
        reading = scope["method"] in _READING
        opening = _token_of(scope) is not None
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none") and not (
            opening and _navigates(headers)
        ):
            return "Sec-Fetch-Site"
        if opening:
            return "" if self.tokens.opens(_token_of(scope) or "") else "token"
        if not any(self.tokens.fits(one) for one in _cookies(headers, self.cookie)):
            return "token"
        if not reading and origin is None:
            return "Origin"
        if not reading and headers.get("x-cutwise") != "1":
            return "X-Cutwise"
        return ""

    def _of_this_user(self, scope: Scope) -> bool:
        client, server = scope.get("client"), scope.get("server")
        if client is None or server is None or self.same_user is None:
            return False
        return self.same_user((client[0], client[1]), (server[0], server[1]))

    def _welcome(self, scope: Scope) -> Response | None:
        """The answer to an address with the token: the cookie, and the way on without it.

        Not a redirect: along one that began on another site a browser does not send a strict cookie.
        """
        if _token_of(scope) is None:
            return None
        page = (
            '<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0;url=/"><title>cutwise</title>'
            '<link rel="icon" href="data:,">'  # else a slow browser asks for one in between, and says that there is none
        )
        answer = HTMLResponse(page)
        answer.set_cookie(self.cookie, self.tokens.stays, path="/", httponly=True, samesite="strict")
        return answer


def _token_of(scope: Scope) -> str | None:
    """The token in an address, where one may be: ``GET /?token=...``."""
    if scope["method"] not in _READING or scope["path"] != "/" or not scope["query_string"]:
        return None
    given = parse_qs(scope["query_string"].decode("latin-1"), keep_blank_values=True)
    found = given.get("token", [])
    return found[0] if len(found) == 1 and len(given) == 1 else None


def _navigates(headers: Headers) -> bool:
    """Whether a person opens a document, wherever the link stands."""
    return headers.get("sec-fetch-mode") == "navigate" and headers.get("sec-fetch-dest") == "document"


def _cookies(headers: Headers, name: str) -> list[str]:
    """Every value of a cookie: other servers of this machine may have set one of the same name."""
    pairs = (pair.strip().partition("=") for pair in headers.get("cookie", "").split(";"))
    return [value for key, _, value in pairs if key == name]


_LENGTH = re.compile(rb"^content-length[ \t]*:", re.IGNORECASE | re.MULTILINE)


class Protocol(H11Protocol):
    """HTTP as uvicorn speaks it, with two answers that the parser below it does not give."""

    def __init__(self, *given: Any, **more: Any) -> None:
        super().__init__(*given, **more)
        self._head = b""
        self._waiting: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Who connects has to ask for something: places are counted, and may not be kept by silence."""
        super().connection_made(transport)
        self._waiting = self.loop.call_later(PATIENCE, self._silent)

    def connection_lost(self, exc: Exception | None) -> None:
        """Nobody is waited for any more."""
        self._heard()
        super().connection_lost(exc)

    def _heard(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def _silent(self) -> None:
        if self.transport is not None and not self.transport.is_closing():
            self.transport.close()

    def data_received(self, data: bytes) -> None:
        """Refuse a length that is said twice, which the parser takes for one; then go on as usual."""
        if self._head is not None and self.conn.their_state.__name__ == "IDLE":
            self._head += data[: 2 * MOST_HEADERS]
            head, end, _ = self._head.partition(b"\r\n\r\n")
            if len(_LENGTH.findall(head)) > 1:
                self._refuse(400, "refused: content-length is there twice")
                return
            if end or len(self._head) > 4 * MOST_HEADERS:
                self._head = b""
        super().data_received(data)
        if self.conn.their_state.__name__ != "IDLE":
            self._heard()
        elif self._waiting is None and self._head:
            self._waiting = self.loop.call_later(PATIENCE, self._silent)

    def send_400_response(self, msg: str) -> None:
        """Headers that go on without end are too large, not invalid."""
        hint = getattr(sys.exc_info()[1], "error_status_hint", 400)
        self._refuse(431 if hint == 431 else 400, "refused: more than 16 kB of headers" if hint == 431 else msg)

    def _refuse(self, status: int, words: str) -> None:
        reason = {400: "Bad Request", 431: "Request Header Fields Too Large"}[status]
        lines = (f"HTTP/1.1 {status} {reason}", *(f"{name}: {value}" for name, value in SAFE.items()))
        head = "\r\n".join(
            (*lines, "content-type: text/plain; charset=utf-8", "connection: close", f"content-length: {len(words)}")
        )
        self.transport.write(f"{head}\r\n\r\n{words}".encode("ascii", errors="replace"))
        self.transport.close()
