"""Values that a program hands over instead of a text: what of them can stand in a scenario."""

from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

from cutwise.spec.faults import Fault, Path, ScenarioFault

_DEEPEST = 60


def said(value: Any, file: str) -> Any:
    """The value as texts, numbers, lists and mappings.

    Paths become texts, numbers and arrays of numpy plain numbers and lists.

    Raises
    ------
    ScenarioFault
        Everything in it that is nothing of the kind, each with its place.
    """
    faults: list[Fault] = []
    plain = _plain(value, (), faults, file)
    if faults:
        raise ScenarioFault(faults)
    return plain


def _plain(value: Any, path: Path, faults: list[Fault], file: str) -> Any:
    if len(path) > _DEEPEST:
        faults.append(Fault(path[:3], "nested too deeply to be a scenario", file=file))
        return None
    if value is None or isinstance(value, bool | str | int | float):
        return value
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, Mapping):
        keys = [str(key) for key in value]
        twice = sorted({key for key in keys if keys.count(key) > 1})
        faults += [Fault((*path, key), "written twice; keep one", file=file) for key in twice]
        return {str(key): _plain(one, (*path, str(key)), faults, file) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one, (*path, i), faults, file) for i, one in enumerate(value)]
    plain = getattr(value, "tolist", None)  # of numpy
    if callable(plain):
        return _plain(plain(), path, faults, file)
    message = (
        f"{value!r:.40} ({type(value).__name__}) cannot stand in a scenario; expected a text, number, list or mapping"
    )
    faults.append(Fault(path, message, file=file))
    return None
