"""OpenCascade (the ``cad`` extra): its modules when they are first needed, and the parts of a shape."""

import importlib
from functools import lru_cache
from typing import Any

MM = 1e-3  # OpenCascade converts whatever a file says to millimetres

# Printed once by the importing of OpenCascade if the extra is missing.
MISSING = "reading CAD files needs the extra: pip install 'cutwise[cad]'"


class CadFault(ValueError):
    """A CAD file that cannot be used, in plain words."""


@lru_cache(maxsize=64)
def occ(module: str) -> Any:
    """A module of the OpenCascade bindings, imported at its first use (1 to 5 s).

    Raises
    ------
    CadFault
        The extra is not installed.
    """
    try:
        loaded = importlib.import_module(f"OCP.{module}")
    except ImportError:
        raise CadFault(MISSING) from None
    _silence()
    return loaded


_silent = False


def _silence() -> None:
    """Take the message printers of OpenCascade away: they write to standard output, between our JSON."""
    global _silent
    if _silent:
        return
    _silent = True
    messenger = importlib.import_module("OCP.Message").Message.DefaultMessenger_s()
    for printer in list(messenger.Printers()):
        messenger.RemovePrinter(printer)


def explored(shape: Any, kind: Any) -> list[Any]:
    """All different sub-shapes of a kind, each with its orientation in the shape."""
    topology = occ("TopoDS").TopoDS
    typed = getattr(topology, kind.name.removeprefix("TopAbs_").capitalize())
    found = shape_map(shape, kind)
    return [typed(found.FindKey(i)) for i in range(1, found.Extent() + 1)]


def shape_map(shape: Any, kind: Any) -> Any:
    """All different sub-shapes of a kind, counted from 1; both uses of an edge are the same."""
    found = occ("collections").IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    occ("TopExp").TopExp.MapShapes_s(shape, kind, found)
    return found
