"""One way to compile a kernel, with a disk cache in which a kernel is void when what it uses has changed, and only then.

numba's own cache looks at the file of the compiled function: a loop whose callee was edited in another file would
silently keep the old code, a comment voids a whole file, and two processes that write at the same time may exchange
the code of two signatures. Here the name of a cached file says everything its code depends on, so a file is either
right or not looked at; it is written whole or not at all.
"""

import hashlib
import itertools
import os
import pickle
import sys
import time
import types
from collections.abc import Callable, Iterator
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
from numba.core.caching import CompileResultCacheImpl, FunctionCache, dumps  # type: ignore[attr-defined]

Function = TypeVar("Function", bound=Callable[..., Any])

_SUFFIX = ".nbc"
_FORGOTTEN = 14 * 86400.0  # [s] after which an unused kernel of older sources is removed


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
    """Folder of the compiled kernels."""
    return _user_cache() / "kernels"


def cached_kernels() -> list[Path]:
    """Files of the kernel cache, those of older versions included."""
    folder = cache_folder()
    return [file for file in folder.rglob("*") if file.is_file()] if folder.is_dir() else []


def clear_kernels() -> int:
    """Remove every cached kernel; returns the number of bytes given back."""
    freed = 0
    for file in cached_kernels():
        size = file.stat().st_size
        file.unlink(missing_ok=True)
        freed += size
    for folder in sorted((f for f in cache_folder().rglob("*") if f.is_dir()), reverse=True):
        folder.rmdir()
    return freed


def compiled(function: Function) -> Function:
    """Compile a scalar kernel with numba; ``kernel.py_func`` stays the plain Python version for the tests."""
    return _compiled(function)


def inlined(function: Function) -> Function:
    """Compile a small kernel of an innermost loop into the kernels that call it.

    The compiler leaves a call where a kernel takes many numbers, and the call then costs more than the kernel: the
    averaged edge loop takes a quarter less with its stages inlined. Results are the same to the last bit.
    """
    return _compiled(function, forceinline=True)


def stepping(function: Function) -> Function:
    """As :func:`compiled`, for a loop that allocates nothing: no reference is counted in it, although tuples of arrays
    are handed from stage to stage in every step."""
    return _compiled(function, _nrt=False)


def inlined_stepping(function: Function) -> Function:
    """As :func:`inlined`, for a part of such a loop."""
    return _compiled(function, forceinline=True, _nrt=False)


def merged(function: Function) -> Function:
    """A part of such a loop that stands in the text of the loop itself: it is not compiled on its own.

    A part that is large and that holds the laws of a run is compiled anew for every combination of them, and the compiler
    goes through it at each level of calls again. Results are the same to the last bit.
    """
    return _compiled(function, inline="always", _nrt=False)


def internal(function: Function) -> Function:
    """As :func:`compiled`, for a kernel that only other kernels call: no wrapper for Python, which takes as long to
    compile as the kernel where arguments are tuples of tuples."""
    return _compiled(function, no_cpython_wrapper=True)


def unlocked(function: Function) -> Function:
    """As :func:`compiled`, for a kernel that several threads may run side by side."""
    return _compiled(function, nogil=True)


def compiled_sums(function: Function) -> Function:
    """As :func:`compiled`, but sums may be taken in any order, so that loops over short arrays run in vector lanes.

    Results differ in the last digits from one processor to another; not for loops that test for NaN or infinity.
    """
    return _compiled(function, fastmath={"reassoc", "nsz", "contract"})


def _compiled(function: Function, **options: Any) -> Function:
    dispatcher = numba.njit(error_model="numpy", **options)(function)
    dispatcher._cache = _KernelCache(function, options)
    dispatcher.get_call_template = _of_any_number(dispatcher.get_call_template)
    return cast(Function, dispatcher)


def _of_any_number(template: Callable[..., Any]) -> Callable[..., Any]:
    """Typing of a call in which a whole number or a truth that is written down is like any other.

    Left alone, the compiler makes a kernel anew for each of them, ``count=0`` or ``refine=True``: twice the time, the same code.
    """

    plain: Callable[[Any], Any] = numba.types.unliteral

    def called(args: Any, kws: Any) -> Any:
        return template(tuple(map(plain, args)), {name: plain(kind) for name, kind in kws.items()})

    return called


class _KernelCache(FunctionCache):
    """Cache of one kernel: a file for each signature, named after the kernel, what it uses, and the signature."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self._name = repr(function)
        self._py_func = function
        self._options = repr(sorted(options.items(), key=str))
        self._impl = _Serialised()
        self._cache_path = str(cache_folder())
        self._label = f"{function.__module__.removeprefix('cutwise.')}.{function.__name__}"
        self.enable()  # type: ignore[no-untyped-call]

    def flush(self) -> None:
        for file in cache_folder().glob(f"{self._label}-*{_SUFFIX}"):
            file.unlink(missing_ok=True)

    def _file(self, sig: Any, codegen: Any) -> Path:
        kinds = sig if isinstance(sig, tuple) else sig.args
        said = [_spelled(kind) for kind in kinds]
        used = digest_of_use(
            self._py_func, self._options, frozenset(record for kind in kinds for record in _records(kind))
        )
        key = hashlib.sha256(repr((said, codegen.magic_tuple())).encode()).hexdigest()
        return cache_folder() / f"{self._label}-{used[:16]}-{key[:24]}{_SUFFIX}"

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        if not self._enabled:
            return None
        file = self._file(sig, target_context.codegen())
        try:
            data = file.read_bytes()
        except OSError:
            return None
        try:
            payload = _unwrapped(data)
            os.utime(file)  # seen: it is not forgotten
        except (ValueError, OSError):
            return None
        return self._impl.rebuild(target_context, payload)

    def _save_overload(self, sig: Any, data: Any) -> None:
        if not self._enabled or not self._impl.check_cachable(data):
            return
        file = self._file(sig, data.codegen)
        scratch = file.with_suffix(f".{os.getpid()}.tmp")
        try:  # a cache that cannot be written costs time, never the result
            file.parent.mkdir(parents=True, exist_ok=True)
            scratch.write_bytes(_wrapped(self._impl.reduce(data)))
            os.replace(scratch, file)
            self._forget_older(file)
        except OSError:
            scratch.unlink(missing_ok=True)

    def _forget_older(self, kept: Path) -> None:
        oldest = time.time() - _FORGOTTEN
        for file in kept.parent.glob(f"{self._label}-*"):
            if file != kept and file.stat().st_mtime < oldest:
                file.unlink(missing_ok=True)


def _records(kind: Any) -> Iterator[type]:
    """Record classes in a type, however deep."""
    if (record := getattr(kind, "instance_class", None)) is not None:
        yield record
    for part in getattr(kind, "types", None) or (() if not hasattr(kind, "dtype") else (kind.dtype,)):
        yield from _records(part)


def _spelled(kind: Any) -> str:
    """A type in full: its name, and where the record classes in it were defined (two may share a name)."""
    inner = getattr(kind, "types", None)
    record = getattr(kind, "instance_class", None)
    place = f"{record.__module__}.{record.__qualname__}{record._fields}" if record is not None else ""
    return f"{place}{kind!r}[{', '.join(_spelled(part) for part in inner)}]" if inner else f"{place}{kind!r}"


class _Serialised(CompileResultCacheImpl):
    """numba's own way to write a compiled function down, without its way to choose a file."""

    def __init__(self) -> None:
        self._lineno = 0
        self._locator = types.SimpleNamespace(_py_file="")


def _wrapped(payload: Any) -> bytes:
    """Payload with its checksum in front: a file cut short by a full disk or a crash is not believed."""
    data = dumps(payload)  # type: ignore[no-untyped-call]
    return hashlib.sha256(data).digest() + bytes(data)


def _unwrapped(data: bytes) -> Any:
    if hashlib.sha256(data[32:]).digest() != data[:32]:
        raise ValueError("damaged kernel")
    return pickle.loads(data[32:])


@cache
def digest_of_use(function: Callable[..., Any], options: str = "", records: frozenset[type] = frozenset()) -> str:
    """Digest of everything that the compiled code of a function depends on.

    Its own byte code and constants, the value of each global that it names, the same of every kernel among these, and
    of the laws that a stage has for the record classes of the signature; not comments, not docstrings, not its place
    in the file. Called when a kernel is first used: its module is complete by then.
    """
    digest = hashlib.sha256(f"{numba.__version__} {np.__version__} {sys.version} {options}".encode())
    used = _Used(set(records), [], set())
    todo: list[Callable[..., Any]] = [function]
    while todo:
        while todo:
            current = todo.pop()
            if id(current) not in used.seen:
                used.seen.add(id(current))
                _add_function(digest, current)
                todo.extend(_add_values(digest, current, used))
        todo.extend(used.laws())
    return digest.hexdigest()


class _Used(NamedTuple):
    """What has been met on the way through a kernel and its callees."""

    records: set[type]
    stages: list[Any]
    seen: set[int]

    def laws(self) -> list[Callable[..., Any]]:
        """Laws that are not among the functions seen, of the stages and the record classes met so far."""
        named = sorted(self.records, key=lambda record: f"{record.__module__}.{record.__qualname__}")
        found = (place.laws[record] for place in self.stages for record in named if record in place.laws)
        return [law for law in found if id(law) not in self.seen]


def _add_function(digest: Any, function: Callable[..., Any]) -> None:
    """A function's own code and constants."""
    digest.update(f"{function.__module__}.{function.__qualname__} {function.__defaults__!r}".encode())
    for part in _codes(function.__code__):
        constants = part.co_consts[1:] if part is function.__code__ and function.__doc__ else part.co_consts
        digest.update(part.co_code)
        digest.update(repr([c for c in constants if not isinstance(c, types.CodeType)]).encode())
        digest.update(repr((part.co_names, part.co_varnames, part.co_freevars)).encode())


def _add_values(digest: Any, function: Callable[..., Any], used: _Used) -> list[Callable[..., Any]]:
    """What a function names; returns the functions among it."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    found: list[Callable[..., Any]] = []
    for value in itertools.chain(_globals_used(function), cells):
        if hasattr(value, "laws"):
            digest.update(value.__qualname__.encode())
            used.stages.append(value)
            continue
        if isinstance(value, type) and hasattr(value, "_fields"):
            used.records.add(value)
        text, functions = _meaning(value)
        digest.update(text.encode())
        found.extend(functions)
    return found


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _globals_used(function: Callable[..., Any]) -> Iterator[Any]:
    """Values of the globals that a function names; of a module of this package also the attributes it may mean."""
    names = sorted({name for code in _codes(function.__code__) for name in code.co_names})
    space = function.__globals__
    for name in names:
        value = space.get(name)
        yield value
        if isinstance(value, types.ModuleType) and value.__name__.startswith("cutwise"):
            yield from (getattr(value, other, None) for other in names)


def _meaning(value: Any) -> tuple[str, list[Callable[..., Any]]]:
    """What a global means to compiled code, as text, and the functions behind it."""
    if isinstance(value, numba.core.dispatcher.Dispatcher):
        options = getattr(value._cache, "_options", "")  # type: ignore[attr-defined]
        return f"{value.py_func.__qualname__} {options}", [value.py_func]
    if isinstance(value, types.FunctionType):
        return value.__qualname__, [value] if value.__module__.startswith("cutwise") else []
    if isinstance(value, type):
        return f"{value.__qualname__} {getattr(value, '_fields', '')} {getattr(value, '_field_defaults', '')}", []
    if isinstance(value, types.ModuleType):
        return value.__name__, []
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}", []
    return repr(value) if isinstance(value, (int, float, complex, str, bytes, tuple, bool, type(None))) else "", []
