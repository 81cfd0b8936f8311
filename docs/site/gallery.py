"""The examples, each run, with its verdict and the picture that its report begins with."""

import hashlib
import json
import re
from html import escape
from pathlib import Path

import cutwise
from cutwise.app.measured import listed
from cutwise.app.plots import PLOTS
from cutwise.app.plots.figures import COLOURS, svg
from cutwise.app.verdict_text import verdict_line
from cutwise.results import Result

EXAMPLES = Path(__file__).resolve().parent.parent.parent / "examples"
_SHOWN = 6  # numbers of an example


def write(folder: Path, *, only: str = "") -> None:
    """Run the examples and write their page; a run whose scenario and version are known is not made again.

    ``only``: names of examples, with commas between them; all of them if empty.
    """
    folder.mkdir(exist_ok=True)
    wanted = [name.strip() for name in only.split(",") if name.strip()]
    files = [file for file in sorted(EXAMPLES.glob("*.yaml")) if not wanted or file.stem in wanted]
    parts = ["# Gallery", "", "Every example, run when this page was made. The file of each lies in `examples/`.", ""]
    for file in files:
        parts += _part(file, folder)
    text = "\n".join(parts) + "\n"
    page = folder / "gallery.md"
    if not page.exists() or page.read_text(encoding="utf-8") != text:
        page.write_text(text, encoding="utf-8")


def _part(file: Path, folder: Path) -> list[str]:
    scenario = cutwise.load(file)
    said = json.dumps([cutwise.__version__, scenario.document()], sort_keys=True, default=str)
    kept = folder / f"{file.stem}-{hashlib.sha256(said.encode()).hexdigest()[:16]}.kept"
    if not kept.exists():
        for old in folder.glob(f"{file.stem}-*.kept"):
            old.unlink()
        kept.write_text("\n".join(_shown(file, cutwise.simulate(scenario))), encoding="utf-8")
    return [kept.read_text(encoding="utf-8"), ""]


def _shown(file: Path, result: Result) -> list[str]:
    """The section of an example: its first lines, verdict, numbers, picture."""
    about = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        about.append(line.lstrip("# ").rstrip())
    rows = [line for lines in listed(result).values() for line in lines][:_SHOWN]
    numbers = [f"| `{line.name}` | {line.text} | {line.asked} |" for line in rows]
    return [
        f"## {file.stem}", "", " ".join(about), "", f"**{verdict_line(result)}**", "",
        "| measure | value | limit |", "|---|---|---|",
        *numbers, "", *_picture(file.stem, result),
    ]  # fmt: skip


def _picture(name: str, result: Result) -> list[str]:
    plot = next((one for one in PLOTS[result.scenario.process] if one.applies(result)), None)
    if plot is None:
        return []
    colours = ";".join(f"{variable}:{colour}" for variable, colour in COLOURS.items())
    drawn = re.sub(r"\n\s*", " ", svg(plot.draw, result, re.sub(r"\W", "-", name), plot.title))
    caption = f'<figcaption style="color:var(--ink)">{escape(plot.title)}. {escape(plot.caption)}</figcaption>'
    figure = f'<figure style="{colours};background:{COLOURS["--card"]}">{drawn}{caption}</figure>'
    return ["```{raw} html", figure, "```", ""]
