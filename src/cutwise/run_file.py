"""The bytes of a run file: a netCDF-4 file with a seal behind it, by which damage is known before a reader meets it.

HDF5 ends a program, or never ends, on some damaged files (5 of 1,000 with a few bytes changed took longer than 20 CPU s),
and it does not look at what stands behind its own end, so that the seal disturbs no other program. A file without one
was written by another version or changed since by another program; it is tried in a process of its own first.
"""

import contextlib
import hashlib
import io
import subprocess
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

_SEAL = b"\ncutwise run file; sha256 of all before this line: "
_LENGTH = len(_SEAL) + 64 + 1
_PATIENCE = 15  # CPU seconds of a trial
_ROOM = 4 * 2**30  # [bytes] address space of a trial
_MUCH, _SWOLLEN = 2e8, 50  # arrays beyond this size, and so many times the file, are not what a run wrote
_LONG = 4096  # numbers of an array that is worth packing
_sound: set[bytes] = set()  # digests of what was tried and found readable


class DamagedRun(ValueError):
    """A file that is no run of cutwise, or not a whole one; the message says what is wrong with it."""


def is_netcdf(content: bytes) -> bool:
    """Whether these are the bytes of a netCDF-4 (HDF5) file."""
    return content.startswith(b"\x89HDF\r\n\x1a\n")


def sealed(content: bytes) -> bytes:
    """The content of a netCDF file with its seal."""
    return content + _SEAL + hashlib.sha256(content).hexdigest().encode() + b"\n"


def written(tree: "xr.DataTree") -> bytes:
    """A tree as a netCDF-4 file; long arrays are packed, as long as the file still opens (:func:`_opened`)."""
    packed = {
        node.path: {
            name: {"zlib": True, "complevel": 1, "shuffle": True}
            for name, array in node.dataset.variables.items()
            if array.size >= _LONG and array.dtype.kind in "fiub"
        }
        for node in tree.subtree
    }
    content = _written(tree, {path: found for path, found in packed.items() if found})
    return _written(tree, {}) if _swollen(tree, len(content)) else content


def _written(tree: "xr.DataTree", encoding: dict[str, Any]) -> bytes:
    stream = io.BytesIO()
    tree.to_netcdf(stream, engine="h5netcdf", encoding=encoding)
    return stream.getvalue()


def _swollen(tree: "xr.DataTree", length: int) -> bool:
    """Whether arrays are larger than a file of a length [bytes] may unpack to."""
    size = sum(array.nbytes for node in tree.subtree for array in node.dataset.variables.values())
    return size > max(_MUCH, _SWOLLEN * length)


def has_seal(content: bytes) -> bool:
    """Whether a file is as cutwise wrote it.

    Raises
    ------
    DamagedRun
        It has a seal that is not its own.
    """
    end = content[-_LENGTH:]
    if not end.startswith(_SEAL):
        return False
    if sealed(content[:-_LENGTH])[-_LENGTH:] != end:
        raise DamagedRun("is damaged: its content is not what cutwise wrote (its checksum says so)")
    return True


def tree_of(content: bytes) -> "xr.DataTree":
    """Every array of a run file.

    Raises
    ------
    DamagedRun
        It cannot be read.
    """
    make_sure(content)
    try:
        return _opened(content)
    except MemoryError:
        raise
    except Exception as error:  # whatever a reader of netCDF stumbles over
        raise DamagedRun(f"is not a run file of cutwise, or damaged ({_brief(error)})") from None


def attribute(content: bytes, name: str) -> Any:
    """One attribute of a run file; None if there is none.

    Raises
    ------
    DamagedRun
        It cannot be read.
    """
    import h5py

    make_sure(content)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            return file.attrs.get(name)
    except Exception as error:
        raise DamagedRun(f"is not a run file of cutwise, or damaged ({_brief(error)})") from None


def make_sure(content: bytes) -> None:
    """Let no damaged file come before HDF5 in this process.

    Raises
    ------
    DamagedRun
        It has a wrong seal, or none and a trial in another process fails.
    """
    if has_seal(content):
        return
    digest = hashlib.sha256(content).digest()
    if digest in _sound:
        return
    trial = f"import sys; sys.path[:] = {sys.path!r}; from cutwise.run_file import _trial; _trial()"
    with contextlib.suppress(subprocess.TimeoutExpired):
        done = subprocess.run(
            [sys.executable, "-c", trial], input=content, capture_output=True, timeout=20 * _PATIENCE, check=False
        )
        if done.returncode == 0:
            _sound.add(digest)
            return
    raise DamagedRun("is not a run file of cutwise, or damaged")


def _trial() -> None:
    """Read a file from standard input, in a process that may come to harm."""
    with contextlib.suppress(ImportError, ValueError, OSError):  # Windows; limits that are lower already
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (_PATIENCE, _PATIENCE + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (_ROOM, _ROOM))
    _opened(sys.stdin.buffer.read())


def _opened(content: bytes) -> "xr.DataTree":
    import xarray as xr

    with xr.open_datatree(io.BytesIO(content), engine="h5netcdf") as tree:
        if _swollen(tree, len(content)):
            size = sum(array.nbytes for node in tree.subtree for array in node.dataset.variables.values())
            raise DamagedRun(f"its arrays would take {size / 1e9:.3g} GB")
        return tree.load()


def _brief(error: Exception) -> str:
    first = (str(error).splitlines() or [""])[0].strip()
    return f"{type(error).__name__}: {first[:120]}" if first else type(error).__name__
