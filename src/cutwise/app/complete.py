"""What a shell offers while a command is typed: processes, shelves and entries of the library, keys of a scenario.

The engine is not loaded: names come from tables, folders and specifications.
"""

import re
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

import typer

_MOST = 400  # keys that are offered at once


def kinds(incomplete: str) -> list[str]:
    """Processes."""
    from cutwise.spec.kinds import HOMES

    return [kind for kind in HOMES if kind.startswith(incomplete)]


def shelves(incomplete: str) -> list[str]:
    """Shelves of the library."""
    return sorted(one.name for one in _library().iterdir() if one.is_dir() and _offered(one.name, incomplete))


def entries(ctx: typer.Context, incomplete: str) -> list[str]:
    """Entries of the shelf that was named before."""
    shelf = str(ctx.params.get("kind") or "")
    folder = _library() / shelf
    if not shelf or not folder.is_dir():
        return []
    names = (one.name.removesuffix(".yaml") for one in folder.iterdir() if one.name.endswith(".yaml"))
    return sorted(name for name in names if name.startswith(incomplete))


def assignments(ctx: typer.Context, incomplete: str) -> list[str]:
    """``key=`` for each key of the scenario that was named before; without one, of every process.

    Behind ``library=`` the entries of the shelf of that section are offered.
    """
    key, sign, value = incomplete.partition("=")
    if sign:
        return [f"{key}={name}" for name in _entries_of(ctx, key) if name.startswith(value)]
    return [f"{one}=" for one in dict.fromkeys(_keys(ctx)) if one.startswith(key)][:_MOST]


def _keys(ctx: typer.Context) -> Iterator[str]:
    """Dotted keys, nearest sections first: those below a section are offered once its name is typed."""
    from cutwise.spec import fields
    from cutwise.spec.faults import dotted
    from cutwise.spec.kinds import KINDS

    for kind in _meant(ctx):
        model = KINDS[kind]
        yield from model.levers
        for path, _ in fields.keys(model):
            yield dotted(path)
        for name in model.measures:
            yield from (f"requirements.{name}.min", f"requirements.{name}.max")


def _entries_of(ctx: typer.Context, key: str) -> list[str]:
    """Library names behind a key that ends in ``library``."""
    from cutwise.spec import fields
    from cutwise.spec.base import LibrarySpec
    from cutwise.spec.faults import split_dotted
    from cutwise.spec.kinds import KINDS

    path = split_dotted(key)
    if not path or path[-1] != "library":
        return []
    found: dict[str, None] = {}
    for kind in _meant(ctx):
        info = fields.field_at(KINDS[kind], path[:-1])
        for section in fields.sections(info) if info is not None else ():
            if issubclass(section, LibrarySpec):
                folder = _library() / section.library_shelf
                found |= dict.fromkeys(
                    sorted(one.name.removesuffix(".yaml") for one in folder.iterdir() if one.name.endswith(".yaml"))
                )
    return list(found)


def _meant(ctx: typer.Context) -> list[str]:
    """The process of the scenario that was named before; all of them where it tells none."""
    from cutwise.spec.kinds import HOMES

    given = [*(value for value in ctx.params.values() if isinstance(value, Path)), *map(Path, ctx.args)]
    named = next((one for one in given if one.suffix in (".yaml", ".yml", ".json")), None)
    if named is not None:
        try:
            with named.open(encoding="utf-8") as file:
                said = re.search(r"^\s*\"?process\"?\s*:\s*\"?(\w+)", file.read(100_000), re.MULTILINE)
        except (OSError, ValueError):
            said = None
        if said is not None and said[1] in HOMES:
            return [said[1]]
    return list(HOMES)


def _offered(name: str, incomplete: str) -> bool:
    return name.startswith(incomplete) and not name.startswith(("_", "."))


def _library() -> Path:
    return Path(str(files("cutwise") / "library"))
