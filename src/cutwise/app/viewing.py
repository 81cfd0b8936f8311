"""``cutwise view``: the page of a scenario, a run, a report or a study, for one person on this machine."""

import os
import socket
import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutwise.app.exits import refuse
from cutwise.disk import in_words

if TYPE_CHECKING:
    from cutwise.app.page.desk import Target
    from cutwise.app.page.guard import Tokens
    from cutwise.app.page.studied import Studied

_LOCAL = "127.0.0.1"  # and no other: the page can write files and compute
_MOST = 2


def view(
    targets: Annotated[
        list[Path],
        typer.Argument(metavar="TARGET...", help="scenario, run file or its folder, report, folder of a study; two runs: compared"),
    ],
    port: Annotated[
        int | None, typer.Option("--port", metavar="N", min=1, max=65535, help="port on this machine; default: a free one")
    ] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="open the browser, or print the address only")] = True,
) -> None:  # fmt: skip
    """Show a run in the browser, turn its settings and run it again."""
    from cutwise.app.page.server import serve

    if len(targets) > _MOST:
        refuse(f"{len(targets)} targets: one is shown, two are compared")
    study = _study(targets[0]) if len(targets) == 1 else ""
    cases = _cases(targets[0], study) if study else None
    opened = (cases.target,) if cases else () if study else _opened(targets)
    listener = _listener(port)
    with listener:
        serve(opened, cases or study, listener, announced=lambda tokens: _announce(listener, tokens, open_it=browser))


def _opened(named: list[Path]) -> "tuple[Target, ...]":
    from cutwise.app.page.desk import target

    found = tuple(target(one) for one in named)
    others = [one for one in found if not one.is_run] if len(found) > 1 else []
    if others:
        refuse("\n".join(f"{one.path}: is no run file; only runs are compared" for one in others))
    return found


def _study(named: Path) -> str:
    """The page that a study has written into its folder; nothing if it is no such folder."""
    if not (named / "identity.json").is_file():
        return ""
    try:
        return (named / "report.html").read_text(encoding="utf-8")
    except FileNotFoundError:
        refuse(f"{named}: this study has no report yet; cutwise study writes it when it ends")
    except (OSError, ValueError) as error:
        refuse(f"{named / 'report.html'}: {in_words(error) if isinstance(error, OSError) else 'is no text'}")


def _cases(folder: Path, report: str) -> "Studied | None":
    """The cases of a study, to be looked at one by one; none where its folder holds a page alone."""
    if not (folder / "study.json").is_file():
        return None
    from cutwise.app.page.studied import opened

    return opened(folder, report)


def _listener(port: int | None) -> socket.socket:
    """A socket on this machine alone."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if sys.platform != "win32":  # there it would let two servers share a port
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((_LOCAL, port or 0))
        listener.listen(128)
    except PermissionError:
        refuse(f"port {port} may not be used (permission denied); leave --port away or name another")
    except OSError:
        refuse(f"port {port} is in use; leave --port away or name another")
    return listener


def _announce(listener: socket.socket, tokens: "Tokens", *, open_it: bool) -> None:
    """Print the address, and open it."""
    from cutwise.app.page import peers

    port = listener.getsockname()[1]
    address = f"http://{_LOCAL}:{port}/?token="
    lines = [f"{address}{tokens.stays}", "Ctrl+C ends it"]
    over = os.environ.get("SSH_CONNECTION", "").split()
    if over:
        host = over[2] if len(over) == 4 else socket.gethostname()
        lines.append(f"on your own computer: ssh -N -L {port}:{_LOCAL}:{port} {host}")
    if not peers.known():
        lines.append("other users of this machine are not kept out by their user, only by the token")
    print("\n".join(lines), flush=True)
    if open_it and not _open(f"{address}{tokens.once}"):
        print("no browser was found: open the address yourself", flush=True)


def _open(address: str) -> bool:
    """Open the browser of the desktop; one that would take over the terminal is none."""
    desktop = sys.platform in ("win32", "darwin") or any(
        os.environ.get(n) for n in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    )
    try:
        return desktop and webbrowser.open(address)
    except (webbrowser.Error, OSError):
        return False
