"""One way to compile a kernel, with a disk cache that notices when any kernel changes.

numba's own cache looks at the file of the compiled function only: a loop whose callee was edited in another file
would silently keep the old code. The folder used here carries a digest of every source file that can take part in a
kernel, so an edited or upgraded cutwise never meets a stale one.
"""

import hashlib
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

_KERNEL_SOURCES = ("maths", "physics", "paths", "process", "records.py")


def _user_cache() -> Path:
    if os.environ.get("NUMBA_CACHE_DIR"):
        return Path(os.environ["NUMBA_CACHE_DIR"])
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "cutwise"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "cutwise"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "cutwise"


@lru_cache(maxsize=1)
def cache_folder() -> Path:
    """Folder of the compiled kernels of exactly these sources."""
    package = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for name in _KERNEL_SOURCES:
        place = package / name
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(str(file.relative_to(package)).encode())
            digest.update(file.read_bytes())
    return _user_cache() / "kernels" / digest.hexdigest()[:16]


def compiled(function: Function) -> Function:
    """Compile a scalar kernel with numba; ``kernel.py_func`` stays the plain Python version for the tests."""
    return _compiled(function)


def inlined(function: Function) -> Function:
    """Compile a small kernel of an innermost loop into the kernels that call it.

    The compiler leaves a call where a kernel takes many numbers, and the call then costs more than the kernel: the
    averaged edge loop takes a quarter less with its stages inlined. Results are the same to the last bit.
    """
    return _compiled(function, forceinline=True)


def internal(function: Function) -> Function:
    """As :func:`compiled`, for a kernel that only other kernels call: no wrapper for Python, which takes as long to
    compile as the kernel where arguments are tuples of tuples."""
    return _compiled(function, no_cpython_wrapper=True)


def compiled_sums(function: Function) -> Function:
    """As :func:`compiled`, but sums may be taken in any order, so that loops over short arrays run in vector lanes.

    Results differ in the last digits from one processor to another; not for loops that test for NaN or infinity.
    """
    return _compiled(function, fastmath={"reassoc", "nsz", "contract"})


def _compiled(function: Function, **options: Any) -> Function:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        return cast(Function, numba.njit(cache=True, error_model="numpy", **options)(function))
    finally:
        numba.config.CACHE_DIR = before
