"""Where the command ``cutwise`` and ``python -m cutwise`` begin: signals first, then everything that takes long to load."""

import os
import signal
import sys
from types import FrameType
from typing import NoReturn

_WORDS = {"SIGINT": (b"interrupted\n", 130), "SIGTERM": (b"terminated\n", 143), "SIGHUP": (b"terminated\n", 143)}


def _leave(number: int, frame: FrameType | None) -> NoReturn:  # noqa: ARG001
    """Leave at once: nothing was begun while the program was still loading."""
    words, code = _WORDS[signal.Signals(number).name]
    os.write(sys.stderr.fileno() if sys.stderr else 2, words)
    os._exit(code)


def main() -> NoReturn:
    """Run the command line; a signal during the second that loading takes ends it in words, not in a traceback."""
    for name in _WORDS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _leave)
    from cutwise.app import cli

    cli.main()


if __name__ == "__main__":
    main()
