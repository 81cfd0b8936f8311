"""The inputs of a run as a reader wants them: value, meaning, where from; and the scenario as text to run again."""

import io
import json
import zlib
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.faults import Path, dotted
from cutwise.spec.scenario import Scenario

_LONG = 10_000  # characters of a text that is a whole program
_NO_INPUTS = ("name", "process", "requirements", "band", "covariances", "measured")
_STATUS = {
    "measured": "measured", "catalogue": "catalogue", "paper": "paper", "assumed": "assumed", "derived": "derived",
    "user": "scenario", "default": "default",
}  # fmt: skip


class Input(NamedTuple):
    """One input value."""

    section: str
    key: str
    shown: str
    meaning: str
    status: str
    source: str


def inputs(scenario: Scenario) -> Iterator[Input]:
    """Every input value of a scenario, those that were left to their default included."""
    origins = scenario.origins
    for path, info, value in _values(scenario):
        if path[0] in _NO_INPUTS or path[-1] == "library":
            continue
        key = dotted(path)
        origin = origins.get(key)
        dimension = fields.dimension(info)
        shown = origin.text if origin is not None and origin.text else _shown(value, dimension)
        status = origin.status if origin is not None else "default"
        source = origin.source if origin is not None else ""
        if origin is not None and origin.library:
            source = f"{source} (library: {origin.library})" if source else f"library: {origin.library}"
        yield Input(
            str(path[0]) if len(path) > 1 else "general", key, shown, info.description or "", _STATUS[status], source
        )


def _values(scenario: Scenario) -> Iterator[tuple[Path, FieldInfo, Any]]:
    """Every value, those in lists of sections with their numbers."""
    for before, section in fields.specs(scenario):
        for name, info in type(section).model_fields.items():
            value = getattr(section, name)
            entries = value if isinstance(value, tuple) else (value,)
            if value is not None and not any(isinstance(entry, Spec | Mapping) for entry in entries):
                yield (*before, name), info, value


def _shown(value: Any, dimension: str | None) -> str:
    if isinstance(value, float | int) and not isinstance(value, bool):
        return units.show(value, dimension) if dimension else f"{value:g}"
    if isinstance(value, list | tuple) and len(value) > 6:
        return f"{len(value)} values"
    return str(value)


def as_json(scenario: Scenario) -> str:
    """The scenario as JSON that is safe inside a ``<script>`` element."""
    text = json.dumps(scenario.document(), indent=1)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def as_yaml(scenario: Scenario) -> str:
    """The scenario as YAML that a person reads and ``cutwise run`` takes."""
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.width = 4096
    yaml.indent(mapping=2, sequence=4, offset=2)
    stream = io.StringIO()
    texts: dict[str, str] = {}
    yaml.dump(_laid_out(scenario.document(), texts), stream)
    written = stream.getvalue()
    for mark, text in texts.items():
        written = written.replace(mark, json.dumps(text))
    return written


def _laid_out(value: Any, texts: dict[str, str]) -> Any:
    """Mappings and lists with values that stand in one line written in one line.

    A whole program goes past the writer, which takes seconds for it: a mark for it here, what it stands for into ``texts``.
    """
    from ruamel.yaml.comments import CommentedMap, CommentedSeq

    if isinstance(value, Mapping):
        block = CommentedMap({key: _laid_out(item, texts) for key, item in value.items()})
        if block and not any(isinstance(item, CommentedMap) for item in block.values()):
            sourced = "value" in block and "status" in block
            if sourced or set(block) <= {"min", "max", "whole_band", "probability"}:
                block.fa.set_flow_style()
        return block
    if isinstance(value, list | tuple):
        row = CommentedSeq(_laid_out(item, texts) for item in value)
        if not any(isinstance(item, CommentedMap) for item in row):
            row.fa.set_flow_style()
        return row
    if isinstance(value, str) and len(value) > _LONG and value.isascii() and "\x7f" not in value:
        mark = f"cutwise-text-{len(texts)}-of-{zlib.crc32(value.encode()):08x}-"
        texts[mark] = value  # JSON of ASCII is YAML
        return mark
    return value
