"""Which scene a process has."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

from cutwise.app.scene.carrier import with_carrier
from cutwise.app.scene.part import with_part
from cutwise.app.scene.scene import Scene

if TYPE_CHECKING:
    from cutwise.results import Result

HOMES: Mapping[str, str] = {
    name: f"cutwise.app.scene.{name}" for name in ("deburr", "mill", "drill", "chamfer", "machine", "turn")
}


def of(result: "Result") -> Scene:
    """What there is to see of a run.

    Raises
    ------
    NothingToSee
        The run has no history, as one that could not be done.
    """
    made: Callable[[Result], Scene] = import_module(HOMES[result.scenario.process]).scene
    try:
        return with_part(result, with_carrier(result, made(result)))
    except KeyError as missing:
        raise NothingToSee("it recorded no motion, or no surface") from missing


class NothingToSee(ValueError):
    """A run without what its scene is made of."""
