"""JSON schema of the scenarios, for editors: completion, descriptions and checks while typing."""

from collections.abc import Mapping
from typing import Any, get_args

from pydantic.json_schema import models_json_schema

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.base import LibrarySpec, Spec, Status
from cutwise.spec.kinds import KINDS
from cutwise.spec.program import Program
from cutwise.spec.scenario import PROBABILITY_ALL, Scenario
from cutwise.spec.tables import Table
from cutwise.spec.uncertain import BAND_ENDS

_PYTHON_ONLY = ("gt", "ge", "lt", "le")
_SOURCED = {
    "description": "a value with where it is from",
    "type": "object",
    "properties": {
        "value": {},
        "status": {"enum": list(get_args(Status))},
        "source": {"type": "string"},
        "library": {"type": "string"},
        "standard_error": {},
        "covariance": {"type": "string"},
    },
    "required": ["value"],
    "additionalProperties": False,
}
_TOLD = [  # a process by its name, or by what the slots of the cell name
    {"required": ["process"]},
    {"required": ["cell"], "properties": {"cell": {"anyOf": [
        {"required": [slot]} for slot in ("engagement", "cutting", "surface")]}}},
]  # fmt: skip


def schema(kind: str | None = None) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of the scenarios of one kind, or of all."""
    models = [KINDS[kind]] if kind is not None else list(KINDS.values())
    references, whole = models_json_schema([(model, "validation") for model in models])
    definitions: dict[str, Any] = whole["$defs"]
    for model in models:
        name = references[(model, "validation")]["$ref"].rpartition("/")[2]
        definitions[name]["properties"]["requirements"] = _requirements(model)
        definitions[name]["required"] = [key for key in definitions[name].get("required", ()) if key != "process"]
        definitions[name]["anyOf"] = _TOLD
    used = {section.__name__: section for model in models for section in _sections(model)}
    for name, definition in definitions.items():
        _for_editors(definition, used.get(name))
    definitions["Sourced"] = _SOURCED
    options = [dict(references[(model, "validation")]) for model in models]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"cutwise scenario{': ' + kind if kind else ''}",
        **(options[0] if len(options) == 1 else {"oneOf": options}),
        "$defs": definitions,
    }


def _sections(model: type[Spec]) -> set[type[Spec]]:
    return {section for _, info in fields.keys(model) for section in fields.inner(info)}


def _requirements(model: type[Scenario]) -> dict[str, Any]:
    limits: Mapping[str, Any] = {
        "type": "object",
        "properties": {
            "min": {"type": ["string", "number"]},
            "max": {"type": ["string", "number"]},
            "whole_band": {"type": "boolean", "description": "every history of friction and set-up has to pass"},
            "probability": {"type": ["number", "string"], "description": "with which the limits have to be kept"},
        },
        "additionalProperties": False,
        "minProperties": 1,
    }
    measures: Mapping[str, Any] = {
        name: {
            **limits,
            "description": f"{measure.description} ({units.DIMENSIONS[measure.dimension].display or 'no unit'})",
        }
        for name, measure in model.measures.items()
    }
    return {
        "type": "object",
        "description": model.model_fields["requirements"].description,
        "properties": measures,
        "patternProperties": {f"_({'|'.join(BAND_ENDS)})$|^{PROBABILITY_ALL}$": dict(limits)},
        "additionalProperties": False,
    }


def _for_editors(definition: dict[str, Any], section: type[Spec] | None) -> None:
    """What the loader admits beyond the bare model: values with a source, library entries, table files."""
    for name, value in definition.get("properties", {}).items():
        if name == "requirements":
            continue
        plain = _plain(value)
        if section is not None and name in section.model_fields and name not in ("library", "columns", "file"):
            kept = {key: plain.pop(key) for key in ("description", "examples", "title", "default") if key in plain}
            plain = {**kept, "anyOf": [plain, {"$ref": "#/$defs/Sourced"}]}
        definition["properties"][name] = plain
    if section is not None and issubclass(section, LibrarySpec):
        definition.pop("required", None)
    if section is Program:
        listed = definition["properties"]["tools"]
        listed["anyOf"] = [*listed["anyOf"], {"type": "string", "description": "tool table file"}]
        whole = {key: definition.pop(key) for key in ("type", "properties", "required", "additionalProperties")}
        definition["anyOf"] = [whole, {"type": "string", "description": "program file"}]
    if section is not None and issubclass(section, Table):
        columns = {key: definition.pop(key) for key in ("type", "properties", "required", "additionalProperties")}
        from_file = {
            "type": "object",
            "properties": {"table": {"type": "string", "description": "CSV file"}},
            "required": ["table"],
            "additionalProperties": False,
        }
        definition["anyOf"] = [columns, from_file, {"type": "string", "pattern": r"\.csv$"}]


def _plain(value: Any) -> Any:
    """A schema without what only Python knows: bounds in SI, defaults in SI, null for not given, exclusive choices."""
    if isinstance(value, list):
        return [_plain(item) for item in value if item != {"type": "null"}]
    if not isinstance(value, dict):
        return value
    plain = {key: _plain(item) for key, item in value.items() if key not in _PYTHON_ONLY}
    if plain.get("type") == "string" and not isinstance(plain.get("default", ""), str):
        del plain["default"]
    if plain.get("default", "") is None:
        del plain["default"]
    if "oneOf" in plain:
        plain["anyOf"] = plain.pop("oneOf")  # a CSV file name is also a text
    if len(plain.get("anyOf", ())) == 1:
        only = plain.pop("anyOf")[0]
        plain = {**only, **plain}
    return plain
