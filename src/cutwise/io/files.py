"""Reading the text files that an engineer names, with plain words for what can be wrong."""

from difflib import get_close_matches
from pathlib import Path

from cutwise.spec.faults import Fault, ScenarioFault


def read_bytes(path: Path, shown: str) -> bytes:
    """Content of a file.

    Raises
    ------
    ScenarioFault
        There is no such file, or it cannot be read.
    """
    try:
        return path.read_bytes()
    except FileNotFoundError:
        message = "no such file"
        if path.parent.is_dir():
            near = get_close_matches(path.name, [entry.name for entry in path.parent.iterdir()], n=1, cutoff=0.75)
            message += f"; did you mean {near[0]}?" if near else ""
    except IsADirectoryError:
        message = "is a folder; name a file in it"
    except PermissionError:
        message = "is a folder; name a file in it" if path.is_dir() else "may not be read (permission denied)"
    except (OSError, ValueError) as error:
        message = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    raise ScenarioFault([Fault((), message, file=shown)]) from None


def as_text(content: bytes, shown: str) -> str:
    """Text of a UTF-8 file, with or without a byte order mark.

    Raises
    ------
    ScenarioFault
        It is a binary file or one of another encoding.
    """
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ScenarioFault([Fault((), "is UTF-16 text; save it as UTF-8", file=shown)])
    if b"\0" in content:
        raise ScenarioFault([Fault((), "is a binary file, not text", file=shown)])
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line, column = before.count(b"\n") + 1, error.start - (before.rfind(b"\n") + 1) + 1
        message = f"byte 0x{content[error.start]:02x} is not UTF-8 text; save the file as UTF-8"
        raise ScenarioFault([Fault((), message, line, column, shown)]) from None
