"""What a scenario or a result is asked for and a higher layer answers: found by its name when it is asked for.

So a scenario can be changed and a result drawn where people look for it, and neither knows the layers above it.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "with_values": "cutwise.io.revision:with_values",
    "plot": "cutwise.app.plots.paper:history",
    "result_html": "cutwise.app.notebook:result_html",
    "scenario_html": "cutwise.app.notebook:scenario_html",
    "study_html": "cutwise.app.notebook:study_html",
}


def above(name: str) -> Any:
    """The function that answers."""
    module, _, function = _HOMES[name].partition(":")
    return getattr(import_module(module), function)
