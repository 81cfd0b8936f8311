"""What ``cutwise doctor`` looks at: whether this installation can do its work."""

import importlib.metadata
import importlib.util
import platform
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import cutwise

_NEEDED = (
    "numpy",
    "scipy",
    "numba",
    "pydantic",
    "pint",
    "ruamel.yaml",
    "xarray",
    "h5netcdf",
    "matplotlib",
    "jinja2",
    "starlette",
    "uvicorn",
)
_ROOM = 200e6  # [bytes] a long run with its report


class Finding(NamedTuple):
    """One thing looked at."""

    subject: str
    found: str
    good: bool
    remedy: str = ""


def examine() -> Iterator[Finding]:
    """Look at everything, one after the other; nothing raises."""
    yield Finding("cutwise", f"{cutwise.__version__} in {Path(cutwise.__file__).parent}", True)
    python = platform.python_version()
    yield Finding(
        "python", f"{python} on {platform.platform()}", sys.version_info >= (3, 11), "use Python 3.11 or newer"
    )
    for name in _NEEDED:
        yield _package(name)
    yield _tried("library", _library, "install cutwise again: its library files are damaged")
    yield _tried("units", _units, "install pint again")
    yield _tried("compiled kernels", _compiler, "set NUMBA_CACHE_DIR to a folder that you may write to")
    yield _tried("run files", _run_file, "install h5py and h5netcdf again")
    free = shutil.disk_usage(Path.cwd()).free
    yield Finding("free space here", f"{free / 1e9:.1f} GB", free > _ROOM, "run files need room: free some, or use -o")


def _package(name: str) -> Finding:
    try:
        return Finding(name, importlib.metadata.version(name), True)
    except importlib.metadata.PackageNotFoundError:
        return Finding(name, "not installed", False, f"pip install {name}")


def _tried(subject: str, trial: Callable[[], str], remedy: str) -> Finding:
    try:
        return Finding(subject, trial(), True)
    except Exception as error:
        return Finding(subject, f"{type(error).__name__}: {error}", False, remedy)


def _library() -> str:
    from cutwise.io import library

    count = sum(len(library.shelf(kind)) for kind in library.SHELVES)
    return f"{count} entries on {len(library.SHELVES)} shelves"


def _units() -> str:
    from cutwise import units

    speed = units.parse("6000 mm/min", "speed")
    if abs(speed - 0.1) > 1e-12:
        raise ValueError(f"6000 mm/min is read as {speed} m/s")
    return "6000 mm/min is 0.1 m/s"


def _compiler() -> str:
    import numba

    from cutwise.maths.compiled import cache_folder, cached_kernels

    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        pass
    double = numba.njit(lambda value: 2.0 * value)
    if double(21.0) != 42.0:
        raise ValueError("a compiled function gives a wrong number")
    size = sum(file.stat().st_size for file in cached_kernels())
    return f"compiler works, kernels are kept in {folder}: {size / 1e6:.1f} MB (cutwise doctor --clear gives them back)"


def _run_file() -> str:
    import xarray as xr

    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "trial.nc"
        xr.Dataset({"force": ("time", [1.0, 2.0])}).to_netcdf(place, engine="h5netcdf")
        with xr.open_dataset(place, engine="h5netcdf") as back:
            if back["force"].values.tolist() != [1.0, 2.0]:
                raise ValueError("a run file does not come back as written")
    return "written and read back"
