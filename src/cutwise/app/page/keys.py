"""The keys of a scenario as the page offers them for change: what is usually turned first, then all."""

from collections.abc import Iterator
from typing import Any

from cutwise import units
from cutwise.app.inputs import inputs
from cutwise.io.processes import model_of
from cutwise.io.tree import compose, unwrapped
from cutwise.spec import fields
from cutwise.spec.faults import dotted, split_dotted
from cutwise.spec.scenario import Scenario

UPLOADS = (
    ".step",
    ".stp",
    ".nc",
    ".ngc",
    ".tap",
    ".gcode",
    ".apt",
    ".cls",
    ".csv",
    ".urdf",
    ".stl",
    ".tbl",
    ".yaml",
)  # what a file may be


def of_scenario(scenario: Scenario) -> list[dict[str, Any]]:
    """Every value with its meaning, unit, source and usual range; levers first, then limits of measures."""
    levers = {key: place for place, key in enumerate(scenario.turned())}
    found = [
        _told(type(scenario), row.key, row.shown, row.status, row.source, row.key in levers) for row in inputs(scenario)
    ]
    found += list(_limits(scenario))
    return sorted(found, key=lambda one: levers.get(one["key"], len(levers)))


def of_text(text: str) -> list[dict[str, Any]]:
    """The values that stand in a text that is no sound scenario yet; none where it cannot be read."""
    tree, _ = compose(text, "scenario")
    if tree is None or not isinstance(tree.value, dict):
        return []
    tree = unwrapped(tree, (), [])
    model = model_of(tree, [])
    if model is None:
        return []
    levers = set(model.levers)
    found = [
        _told(model, dotted(path), node.text, "scenario", "", dotted(path) in levers)
        for path, node in tree.walk()
        if path and not isinstance(node.value, dict | list)
    ]
    return sorted(found, key=lambda one: not one["lever"])


def _told(model: type[Scenario], key: str, text: str, status: str, source: str, lever: bool) -> dict[str, Any]:
    info = fields.field_at(model, split_dotted(key))
    dimension = fields.dimension(info) if info is not None else None
    usual = fields.usual(info) if info is not None else None
    ends = None if usual is None or usual.low is None or usual.high is None else [str(usual.low), str(usual.high)]
    return {
        "key": key, "text": text, "meaning": (info.description or "") if info is not None else "",
        "unit": units.pretty(units.DIMENSIONS[dimension].display) if dimension else "", "status": status, "source": source,
        "lever": lever, "usual": ends, "file": _of_a_file(key, text),
    }  # fmt: skip


def _of_a_file(key: str, text: str) -> bool:
    """Whether a value names a file: by its key, or as the short form of a section does (``program: a.nc``)."""
    return key.endswith(".file") or ("\n" not in text and text.strip().lower().endswith(UPLOADS))


def _limits(scenario: Scenario) -> Iterator[dict[str, Any]]:
    """The limits that the scenario writes."""
    for name, limit in scenario.requirements.items():
        for end in ("min", "max"):
            key = f"requirements.{name}.{end}"
            if getattr(limit, end) is not None:
                dimension = scenario.measures[name].dimension
                origin = scenario.origins.get(key)
                text = origin.text if origin is not None and origin.text else units.show(getattr(limit, end), dimension)
                yield {
                    "key": key, "text": text, "meaning": scenario.measures[name].description, "status": "scenario", "source": "",
                    "unit": units.pretty(units.DIMENSIONS[dimension].display), "lever": False, "usual": None, "file": False,
                }  # fmt: skip
