"""Comments, and what the active ones among them say: MSG, DEBUG, PRINT, LOG."""

import re

from cutwise.programs.canon import Comment, Message, Printed, Signal
from cutwise.programs.controller import Controller
from cutwise.programs.expressions import FlowFault
from cutwise.programs.variables import Memory
from cutwise.programs.words import Notice

_PLACE = re.compile(r"%(?:d|f|\.(?P<decimals>\d)f)|#(?P<number>\d+)|#<(?P<name>[^<>]*)>")
_UNKNOWN = "######"
_DEFAULT, _PLAIN_F = 6, 4  # decimals of a value without a format, and after %f


def say(c: Controller, memory: Memory, notice: Notice) -> None:
    """The command that a comment is."""
    kind, text = notice.active, notice.text
    if kind is None:
        c.out.append(Comment(text, c.line, c.number))
    elif kind == "abort":
        raise FlowFault(f"the program aborts: {expanded(text, memory).strip()}", 0)
    elif kind == "msg":
        c.out.append(Message(text, c.line, c.number))
    elif kind == "debug":
        if memory.number(5599) != 0.0:
            c.out.append(Message(expanded(text, memory), c.line, c.number))
    elif kind in ("print", "log"):
        c.out.append(Printed(expanded(text, memory), kind == "log", c.line, c.number))
    elif kind in ("logopen", "logappend", "logclose"):
        quoted = "" if kind == "logclose" else f'"{text}"'
        c.out.append(Signal(kind.upper(), quoted, c.line, c.number))


def expanded(text: str, memory: Memory) -> str:
    """Text with its variables as numbers; ``%d``, ``%f`` and ``%.3f`` say with how many decimals from there on."""
    decimals = _DEFAULT

    def shown(match: re.Match[str]) -> str:
        nonlocal decimals
        if match["number"] is None and match["name"] is None:
            wanted = match["decimals"]
            decimals = int(wanted) if wanted is not None else 0 if match.group() == "%d" else _PLAIN_F
            return ""
        key = int(match["number"][-9:]) if match["number"] is not None else re.sub(r"\s", "", match["name"]).lower()
        value = memory.value(key)
        return _UNKNOWN if value is None else f"{round(value, decimals) + 0.0:.{decimals}f}"

    return _PLACE.sub(shown, text)
