"""Modules that are imported when they are first used: a command pays for what it does, not for what others do.

The interpreter's own ``importlib.util.LazyLoader``; what it holds is the module itself, so nothing else differs.
Importing scipy.interpolate, xarray (with pandas) and the four processes that a run is not about took half of the
time of ``cutwise check``.
"""

import importlib.util
import sys
from types import ModuleType


def later(name: str) -> ModuleType:
    """The module of that name, read from its file when an attribute of it is first asked for.

    Parameters
    ----------
    name : str
        Full name. Beside the call stands the plain import, under ``TYPE_CHECKING``, for type checkers, editors and the
        check of import directions.

    Raises
    ------
    ModuleNotFoundError
        There is no such module; said at once, not at the first use.
    """
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.find_spec(name)
    if spec is None or spec.loader is None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    spec.loader = importlib.util.LazyLoader(spec.loader)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
