"""Files written whole or not at all, whatever else happens: a full disk, a signal, another run in the same folder."""

import errno
import os
import secrets
import tempfile
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: two runs that end in one folder within a millisecond may mix there
    fcntl = None  # type: ignore[assignment]

_WORDS = {
    errno.ENOSPC: "the disk is full; nothing was written: free some room, or write elsewhere",
    errno.EFBIG: "is larger than a file may be here; nothing was written: write elsewhere",
    errno.EROFS: "cannot be written: the file system is read-only",
    errno.EACCES: "may not be written to (permission denied)",
    errno.EPERM: "may not be written to (permission denied)",
    errno.EISDIR: "is a folder; name a file in it",
    errno.ENOTDIR: "a part of this path is a file, not a folder",
    errno.ENAMETOOLONG: "the name is too long for a file",
    errno.ELOOP: "is a link that leads back to itself",
}
if hasattr(errno, "EDQUOT"):
    _WORDS[errno.EDQUOT] = "your share of the disk (quota) is full; nothing was written: free some room"


def in_words(error: OSError) -> str:
    """What is wrong with a file, as a sentence without its name."""
    return _WORDS.get(error.errno or 0, error.strerror or str(error))


def write_text(path: Path, text: str) -> Path:
    """Write a text file (UTF-8) whole or not at all.

    Raises
    ------
    OSError
        It cannot be written; ``filename`` names it, nothing of it is left behind, and what was there before still is.
    """
    return write_bytes(path, text.encode("utf-8", errors="replace"))


def write_bytes(path: Path, content: bytes) -> Path:
    """Write a file whole or not at all; raises as :func:`write_text` does."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with _errors_name(path):
        if path.exists() and not path.is_file():
            _write_onto(path, content)
        else:
            with _beside(path, content) as partial:
                partial.replace(path.resolve())  # through a link, not in place of it
    return path


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """A file to be written bit by bit, beside the path; it takes its place at the end, whole, or is removed.

    Raises
    ------
    OSError
        As :func:`write_text`.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with _errors_name(path):
        if path.exists() and not path.is_file():
            with tempfile.TemporaryDirectory() as elsewhere:
                partial = Path(elsewhere, path.name + path.suffix)
                yield partial
                _write_onto(path, partial.read_bytes())
            return
        with _beside(path, b"") as partial:
            yield partial
            with partial.open("rb+") as file:
                os.fsync(file.fileno())
            partial.replace(path.resolve())


def write_together(folder: Path, contents: Mapping[str, bytes], without: Collection[str] = ()) -> list[Path]:
    """Write files of one folder that belong together: all of them or none, and never those of two writers mixed.

    Parameters
    ----------
    folder : Path
        Where to; made if it is not there.
    contents : mapping
        Content of each file by its name. Those that come first are needed most: between two of them the writer may
        be killed, and later ones are then missing rather than of an earlier writer.
    without : collection of str
        Files of an earlier writer that must not stay beside the new ones.

    Raises
    ------
    OSError
        As :func:`write_text`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / name for name in contents]
    partial: list[Path] = []
    try:
        for path, content in zip(paths, contents.values(), strict=True):
            with _errors_name(path):
                partial.append(_written_beside(path, content))
        with alone_in(folder):
            for old in (*paths[1:], *(folder / name for name in without)):
                old.unlink(missing_ok=True)
            for whole, path in zip(partial, paths, strict=True):
                with _errors_name(path):
                    whole.replace(path)
    finally:
        for rest in partial:
            rest.unlink(missing_ok=True)
    return paths


def create_text(path: Path, text: str) -> Path:
    """Write a text file that is not there yet, whole or not at all; raises as :func:`create_bytes` does."""
    return create_bytes(path, text.encode("utf-8", errors="replace"))


def create_bytes(path: Path, content: bytes) -> Path:
    """Write a file that is not there yet, whole or not at all; one that appears in the meantime is not written over.

    Raises
    ------
    FileExistsError
        There is one already.
    OSError
        As :func:`write_text`.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with _errors_name(path):
        if path.exists() and not path.is_file() and not path.is_dir():
            _write_onto(path, content)
            return path
        if os.path.lexists(path):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
        with _beside(path, content) as partial:
            try:
                os.link(partial, path)  # fails where a replace would win over a file made in the meantime
            except FileExistsError:
                raise
            except OSError:  # a file system without links
                _write_new(path, content)
    return path


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep others who write together out of a folder, where the system can."""
    if fcntl is None:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # network file systems without locks
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


@contextmanager
def _beside(path: Path, content: bytes) -> Iterator[Path]:
    partial = _written_beside(path, content)
    try:
        yield partial
    finally:
        partial.unlink(missing_ok=True)


def _written_beside(path: Path, content: bytes) -> Path:
    """A new file with the content beside the path, under a name that nobody else uses."""
    target = path.resolve()
    partial = target.with_name(f".{target.name[:100]}.{secrets.token_hex(6)}.part")
    handle = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())  # some systems tell only now that the disk is full
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    return partial


def _write_new(path: Path, content: bytes) -> None:
    """Write to a name that must be nobody's, in place; nothing is left of what cannot be written."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
    except BaseException:
        path.unlink(missing_ok=True)
        raise


def _write_onto(path: Path, content: bytes) -> None:
    """Write to what is no plain file: a device, a pipe."""
    with path.open("wb") as file:
        file.write(content)


@contextmanager
def _errors_name(path: Path) -> Iterator[None]:
    """Errors that name the file that the engineer knows, not the one beside it."""
    try:
        yield
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            raise
        raise type(error)(error.errno, error.strerror, str(path)) from None


def file_name(name: str) -> str:
    """A name as that of one file or folder on every system."""
    safe = "".join("_" if letter in '<>:"/\\|?*' or not letter.isprintable() else letter for letter in name)
    return safe[:100].strip(" .") or "unnamed"
