"""Ctrl-C and termination that are not lost: the compiler swallows an interrupt that meets it in a callback, or turns
it into an error."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_asked: list[int] = []


class Terminated(KeyboardInterrupt):
    """The system, or whoever started this, has asked to stop (SIGTERM, or a terminal that went away)."""


_MEANS: dict[str, type[KeyboardInterrupt]] = {"SIGINT": KeyboardInterrupt, "SIGTERM": Terminated, "SIGHUP": Terminated}


def asked() -> int:
    """The exit code of an interrupt that was asked for, 0 if none was."""
    return _asked[0] if _asked else 0


def stop_if_asked() -> None:
    """Stop here if an earlier Ctrl-C was swallowed.

    Raises
    ------
    KeyboardInterrupt
        The engineer has asked to stop.
    """
    if _asked:
        raise KeyboardInterrupt if _asked[0] == 128 + signal.SIGINT else Terminated


@contextmanager
def watched() -> Iterator[None]:
    """Remember every interrupt within the block, and keep the trace of a swallowed one off the screen.

    Where the shell has interrupts ignored, as for a job in the background, they stay ignored.
    """
    _asked.clear()
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    show = sys.unraisablehook
    sys.unraisablehook = lambda lost: None if issubclass(lost.exc_type, KeyboardInterrupt) else show(lost)
    numbers = [getattr(signal, name) for name in _MEANS if hasattr(signal, name)]
    before = {n: signal.signal(n, _remember) for n in numbers if signal.getsignal(n) is not signal.SIG_IGN}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook = show


def _remember(signal_number: int, frame: FrameType | None) -> Any:  # noqa: ARG001
    _asked.append(128 + (signal.SIGTERM if signal_number != signal.SIGINT else signal.SIGINT))
    raise _MEANS[signal.Signals(signal_number).name]
