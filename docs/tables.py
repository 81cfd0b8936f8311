"""Tables of the documentation that the program knows better: ``python docs/tables.py`` brings all pages up to date.

A page says where a table goes with a pair of comments, ``<!-- table: NAME -->`` and ``<!-- end of table -->``.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from cutwise import units
from cutwise.io import library
from cutwise.references import SOURCES
from cutwise.spec import cell, fields, notices
from cutwise.spec.kinds import KINDS

DOCS = Path(__file__).resolve().parent
_PLACE = re.compile(r"(<!-- table: ([\w.]+) -->\n).*?(\n?<!-- end of table -->)", re.DOTALL)


def _rows(head: tuple[str, ...], rows: Iterator[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in line) + " |" for line in lines)


def measures(process: str) -> str:
    """Every measure of a process with its unit and meaning."""
    known = KINDS[process].measures
    lines = (
        (f"`{name}`", _unit(m.dimension, "si"), _unit(m.dimension, "display"), m.description)
        for name, m in known.items()
    )
    return _rows(("measure", "unit in `--json`", "unit shown", "meaning"), lines)


def _unit(dimension: str, which: str) -> str:
    return units.pretty(getattr(units.DIMENSIONS[dimension], which)) or "none"


def keys(process: str) -> str:
    """Every key of a scenario with an example, the usual range, and what it is."""
    model = KINDS[process]
    shown = (
        (path, info)
        for path, info in fields.keys(model)
        if path[-1] not in ("columns", "file") and not _only_a_section(info)
    )
    lines = (
        (f"`{'.'.join(map(str, path))}`", _example(info), _usual(info), info.description or "") for path, info in shown
    )
    return _rows(("key", "example", "usual", "what it is"), lines)


def _only_a_section(info: FieldInfo) -> bool:
    return len(fields.sections(info)) == len(list(fields.of_field(info))) > 0


def _example(info: FieldInfo) -> str:
    for kind, _ in fields.of_field(info):
        if get_origin(kind) is Literal and len(get_args(kind)) > 1:
            return " ".join(f"`{choice}`" for choice in get_args(kind))
    return f"`{info.examples[0]}`" if info.examples else ""


def _usual(info: FieldInfo) -> str:
    usual = fields.usual(info)
    return "" if usual is None else notices.range_text(usual)


def errata(key: str) -> str:
    """The misprints of a source, each with the test that asserts it."""
    lines = ((e.place, e.printed, e.correct, f"`{e.test.partition('::')[2]}`") for e in SOURCES[key].errata)
    return _rows(("place", "printed", "correct", "test"), lines)


def entry(name: str) -> str:
    """The values of a library entry (shelf.name), with their status and source."""
    shelf, _, label = name.partition(".")
    lines = (
        (f"`{key}`", text, origin.status, origin.source) for key, text, origin in library.entry(shelf, label).origins()
    )
    return _rows(("value", "", "status", "source"), lines)


def slots() -> str:
    """The rows of every slot, and what fills them."""
    lines = (
        (slot if place == 0 else "", f"`{name}`", row.meaning, f"`{row.filled}`")
        for slot, rows in cell.ROWS.items() for place, (name, row) in enumerate(rows.items())
    )  # fmt: skip
    return _rows(("slot", "row", "what it is", "written as"), lines)


def presets() -> str:
    """Which rows each process may have in each slot."""
    lines = (
        (f"`{process}`", *(" ".join(f"`{row}`" for row in rows) for rows in preset))
        for process, preset in cell.PRESETS.items()
    )
    return _rows(("process", *cell.SLOTS), lines)


def refused() -> str:
    """Rows that a process refuses, with the reason."""
    lines = ((f"`{process}`", f"`{row}`", why) for (process, row), why in cell.REFUSED.items())
    return _rows(("process", "row", "why not, and what instead"), lines)


TABLES: Mapping[str, Callable[[], str]] = {
    "cell.slots": slots,
    "cell.presets": presets,
    "cell.refused": refused,
    **{f"measures.{kind}": partial(measures, kind) for kind in KINDS},
    **{f"keys.{kind}": partial(keys, kind) for kind in KINDS},
    **{f"errata.{key}": partial(errata, key) for key, source in SOURCES.items() if source.errata},
    "entry.spindles.berselli2016": partial(entry, "spindles.berselli2016"),
    "entry.machines.fadal2216": partial(entry, "machines.fadal2216"),
    "entry.machines.cjme2023": partial(entry, "machines.cjme2023"),
}


def filled(text: str) -> str:
    """The text of a page with its tables up to date."""
    return _PLACE.sub(lambda found: f"{found[1]}{TABLES[found[2]]()}\n<!-- end of table -->", text)


def pages() -> Iterator[Path]:
    """All pages of the documentation, the read-me first."""
    yield DOCS.parent / "README.md"
    yield from sorted(DOCS.rglob("*.md"))


if __name__ == "__main__":
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if text != (new := filled(text)):
            page.write_text(new, encoding="utf-8")
            print(f"updated {page.relative_to(DOCS.parent)}")
