"""Outputs held against inputs and against one another before anything runs."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from cutwise.app.exits import refuse


def checked(outputs: Iterable[Path | None], inputs: Sequence[str | Path], folder: Path | None = None) -> None:
    """Refuse outputs that would overwrite an input or one another, or that cannot be written.

    Links, relative paths and other spellings of one file count as that file. Everything that is wrong is said at once.

    Parameters
    ----------
    outputs : iterable of Path
        Files to be written; None is passed over.
    inputs : sequence
        Files that are read.
    folder : Path, optional
        Folder of the run, which is made if need be.
    """
    wanted = [path for path in outputs if path is not None]
    wrong: list[str] = []
    for place, path in enumerate(wanted):
        wrong += _faults(path, wanted[:place], [Path(one) for one in inputs], folder)
    if folder is not None:
        wrong += filter(None, [_unwritable(folder)])
    if wrong:
        refuse("\n".join(dict.fromkeys(wrong)))


def beside(file: Path, suffixes: Iterable[str]) -> list[Path]:
    """Files in the folder of another one that it may call by name."""
    return [path for suffix in suffixes for path in file.parent.glob(f"*{suffix}")]


def _faults(path: Path, others: Sequence[Path], inputs: Sequence[Path], folder: Path | None) -> list[str]:
    read = next((one for one in inputs if same(path, one)), None)
    if read is not None:
        named = "" if str(read) == str(path) else f", by another name: {read}"
        return [f"{path}: would be overwritten, and it is read{named}; name another file"]
    twice = next((one for one in others if same(path, one)), None)
    if twice is not None:
        return [f"{path}: two outputs would be written to this file; name another one"]
    if path.is_dir() or (folder is not None and same(path, folder)):
        return [f"{path}: is a folder; name a file in it"]
    if path.exists() and not os.access(path, os.W_OK):
        return [f"{path}: may not be written to (permission denied); name another file"]
    found = _unwritable(path.parent)
    return [found] if found else []


def same(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file, there or not yet."""
    try:
        if os.path.samefile(one, other):
            return True
    except (OSError, ValueError):
        pass
    return os.path.normcase(os.path.realpath(one)) == os.path.normcase(os.path.realpath(other))


def _unwritable(folder: Path) -> str | None:
    """Why a folder cannot be made or written to."""
    try:
        place = folder.resolve()
        while not place.exists() and place != place.parent:
            place = place.parent
    except (OSError, RuntimeError, ValueError) as error:
        return f"{folder}: cannot be used: {getattr(error, 'strerror', None) or error}"
    if not place.is_dir():
        return f"{folder}: {place} is a file, not a folder; name another folder with -o"
    if not os.access(place, os.W_OK | os.X_OK):
        return f"{folder}: may not be written to (permission denied); name another folder with -o"
    return None
