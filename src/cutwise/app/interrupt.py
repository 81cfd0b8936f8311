"""Ctrl-C that is not lost: the compiler swallows an interrupt that meets it in a callback, or turns it into an error."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_asked = threading.Event()


def asked() -> bool:
    """Whether the engineer has asked to stop."""
    return _asked.is_set()


def stop_if_asked() -> None:
    """Stop here if an earlier Ctrl-C was swallowed.

    Raises
    ------
    KeyboardInterrupt
        The engineer has asked to stop.
    """
    if _asked.is_set():
        raise KeyboardInterrupt


@contextmanager
def watched() -> Iterator[None]:
    """Remember every Ctrl-C within the block, and keep the trace of a swallowed one off the screen.

    Where the shell has interrupts ignored, as for a job in the background, they stay ignored.
    """
    _asked.clear()
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        yield
        return
    show = sys.unraisablehook
    sys.unraisablehook = lambda lost: None if lost.exc_type is KeyboardInterrupt else show(lost)
    before = signal.signal(signal.SIGINT, _remember)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        sys.unraisablehook = show


def _remember(signal_number: int, frame: FrameType | None) -> Any:  # noqa: ARG001
    _asked.set()
    raise KeyboardInterrupt
