"""A server of ``cutwise view`` in a process of its own, spoken to over bare sockets."""

import importlib.util
import json
import os
import re
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager, suppress
from typing import NamedTuple

_STUB = (
    "import sys, types; one = types.ModuleType('cutwise.app.scene.view'); one.view_file = lambda result: b'CWVIEW1\\n' + "
    "result.scenario.name.encode(); sys.modules['cutwise.app.scene'] = types.ModuleType('cutwise.app.scene'); "
    "sys.modules['cutwise.app.scene.view'] = one; "
)
_PACKED = importlib.util.find_spec("cutwise.app.scene") is not None


class Answer(NamedTuple):
    """What came back."""

    status: int
    headers: dict
    body: bytes

    @property
    def json(self):
        return json.loads(self.body)


class Viewed:
    """A running server."""

    def __init__(self, process, port, token, said):
        self.process, self.port, self.token, self.said = process, port, token, said
        self.host = f"127.0.0.1:{port}"
        self.cookie = f"cutwise-{port}={token}"

    def raw(self, request: bytes, *, timeout=20.0) -> Answer:
        """Send bytes, read until the server closes."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=timeout) as wire:
            with suppress(OSError):  # it may refuse before everything was sent
                wire.sendall(request)
            return received(wire)

    def ask(self, method, path, body=None, *, without=(), **headers) -> Answer:
        """A request as the page makes it; ``without`` leaves headers out, keywords replace them."""
        content = body if isinstance(body, bytes) else b"" if body is None else json.dumps(body).encode()
        usual = {"host": self.host, "cookie": self.cookie, "connection": "close"}
        if method not in ("GET", "HEAD"):
            usual |= {"origin": f"http://{self.host}", "x-cutwise": "1", "content-length": str(len(content))}
        usual |= {name.replace("_", "-"): value for name, value in headers.items()}
        lines = [f"{name}: {value}" for name, value in usual.items() if name not in without]
        return self.raw("\r\n".join([f"{method} {path} HTTP/1.1", *lines, "", ""]).encode() + content)

    def events(self, **headers):
        """What is told of the job, until it has ended."""
        body = self.ask("GET", "/api/job/events", **headers).body.decode()
        return [json.loads(line) for line in re.findall(r"^data: (.*)$", body, re.MULTILINE)]

    def child(self):
        """Number of the process that computes."""
        found = subprocess.run(
            ["ps", "-o", "pid=", "--ppid", str(self.process.pid)], capture_output=True, text=True, check=False
        )
        return int(found.stdout.split()[0])


def received(wire) -> Answer:
    whole = b""
    try:
        while part := wire.recv(65536):
            whole += part
    except (ConnectionResetError, TimeoutError):
        pass
    head, _, body = whole.partition(b"\r\n\r\n")
    first, *lines = head.decode("latin-1").split("\r\n")
    headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    if headers.get("transfer-encoding") == "chunked":
        body = _joined(body)
    return Answer(int(first.split()[1]) if first else 0, headers, body)


def _joined(chunks: bytes) -> bytes:
    body = b""
    while chunks:
        size, _, chunks = chunks.partition(b"\r\n")
        count = int(size or b"0", 16)
        body, chunks = body + chunks[:count], chunks[count + 2 :]
    return body


@contextmanager
def viewing(*arguments, cwd, **environment):
    """A server; gone at the end."""
    code = ("" if _PACKED else _STUB) + "from cutwise.app.cli import main; main()"
    env = {**os.environ, "SSH_CONNECTION": "", "TMPDIR": str(cwd), **environment}
    words = [sys.executable, "-c", code, "view", *map(str, arguments), "--no-browser"]
    process = subprocess.Popen(words, cwd=cwd, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        said = [process.stdout.readline(), process.stdout.readline()]
        found = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=(\S+)", said[0])
        assert found, said[0] + process.stderr.read()
        yield Viewed(process, int(found[1]), found[2], said)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                process.kill()
        process.stdout.close()
        process.stderr.close()
