"""Pages of the reference that the program writes: its commands, its library, its Python functions."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

import cutwise
from cutwise.app import cli
from cutwise.io import library


def write(folder: Path) -> None:
    """Write the pages; one that says the same already is left alone."""
    folder.mkdir(exist_ok=True)
    for name, lines in (("commands", _commands()), ("library", _library()), ("api", _api())):
        text = "\n".join(lines) + "\n"
        file = folder / f"{name}.md"
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def _commands() -> Iterator[str]:
    root: Any = typer.main.get_command(cli.app)
    yield from ("# Commands", "", str(root.help), "", str(root.epilog), "")
    for name, command in root.commands.items():
        context = typer.Context(command, info_name=f"cutwise {name}")
        usage = " ".join(command.collect_usage_pieces(context))
        yield from (f"## {name}", "", str(command.help or ""), "", f"```text\ncutwise {name} {usage}\n```", "")
        rows = [record for one in command.get_params(context) if (record := _row(one, context))]
        if rows:
            yield from ("| option | what it does |", "|---|---|", *rows, "")


def _row(one: Any, context: typer.Context) -> str:
    record = one.get_help_record(context)
    if record is None:
        return ""
    said, meaning = (part.replace("|", r"\|") for part in record)
    return f"| `{re.sub(r' <(str|path|int|float)>', '', said)}` | {meaning.replace('<', '&lt;')} |"


def _library() -> Iterator[str]:
    yield from (
        "# Library",
        "",
        "Parameter values with their sources; `cutwise library SHELF NAME` shows an entry.",
        "",
    )
    for shelf in library.SHELVES:
        yield from (f"## {shelf}", "", "| entry | describes |", "|---|---|")
        for entry in library.shelf(shelf).values():
            yield f"| `{entry.name}` | {entry.describes.replace('|', ' ')} |"
        yield ""


def _api() -> Iterator[str]:
    yield from (
        "# Python",
        "",
        "Every name of `cutwise`, as its docstring says it; [how to use them](../python.md).",
        "",
    )
    for name in cutwise.__all__:
        value = getattr(cutwise, name)
        if name.startswith("_") or name == "plots":
            continue
        kind = "autoclass" if isinstance(value, type) else "autofunction"
        more = [":members:", ":undoc-members:"] if kind == "autoclass" and name == "Result" else []
        yield from (
            f"## {name}",
            "",
            "```{eval-rst}",
            f".. {kind}:: {value.__module__}.{name}",
            *(f"   {m}" for m in more),
        )
        yield from ("```", "")
    yield from ("## plots", "", "```{eval-rst}", ".. autofunction:: cutwise.app.plots.paper.history", "```", "")
    for name in ("Measures", "Measure", "Check", "Finding"):
        yield from (
            f"## {name}",
            "",
            "```{eval-rst}",
            f".. autoclass:: cutwise.results.{name}",
            "   :members:",
            "```",
            "",
        )
    yield from ("## Scenario", "", "```{eval-rst}", ".. automethod:: cutwise.spec.scenario.Scenario.with_",
                ".. automethod:: cutwise.spec.scenario.Scenario.__getitem__", "```")  # fmt: skip
