"""Scenarios to begin with that are wired to a file: an NC program to be milled, a STEP part to be chamfered.

Every value says where it came from; what no file tells is assumed and marked so, or left for ``cutwise check`` to name.
"""

import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from cutwise import units
from cutwise.io.template import comment, template
from cutwise.programs.summary import Summary
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.kinds import KINDS
from cutwise.spec.texts import visible

_BELOW = 5e-3  # [m] of the block below the lowest move
_USUAL = {"flutes": "3", "helix": "30 deg"}
_PLAIN = re.compile(r"[A-Za-z0-9_][\w./+-]*")
_MM = 1e3
# how a comment tells the diameter of a tool: T1 D=20. / T1 D20 / DIAMETER 20 / DIA. 20 / Ø20 / END MILL 20 / 20 MM END MILL
_SAID = re.compile(
    r"(?:\bT(?P<tool>\d+)\b[^()]*?)?(?:\bD\s*=?\s*|\bDIA(?:METER|\.)?\s*[=:]?\s*|Ø\s*|\bEND\s?MILL\s+)(?P<after>\d+\.?\d*|\.\d+)\b"
    r"|(?P<before>\d+\.?\d*)\s*(?:MM|IN(?:CH)?)?\s+END\s?MILL\b",
    re.IGNORECASE,
)
_COMMENT = re.compile(r"\(([^()]*)\)|;(.*)$", re.MULTILINE)


class Known(NamedTuple):
    """A value and where it is from."""

    text: str
    status: str
    source: str

    @property
    def written(self) -> str:
        """As a scenario has it."""
        return f"{{value: {self.text}, status: {self.status}, source: {json.dumps(self.source, ensure_ascii=False)}}}"


def milled(program: Path, diameter: str | None, beside: Path) -> str:
    """A scenario that mills a program out of a block.

    Parameters
    ----------
    program : Path
        G-code or APT.
    diameter : str, optional
        Of its tool, ``"20 mm"``.
    beside : Path
        Folder that the scenario will stand in.

    Raises
    ------
    ScenarioFault
        The program cannot be read or run, has no feed move, or the diameter is none.
    """
    from cutwise.app.programs import opened
    from cutwise.programs.summary import summarise

    table = program.with_suffix(".tbl")
    has_table = table.is_file() and table != program
    run, setup, _ = opened(program, table if has_table else None)
    found = summarise(run, setup)
    if "feed" not in found.boxes:
        raise ScenarioFault([Fault((), "has no feed move: there is nothing to mill", file=str(program))])
    tools = _diameters(program, found, diameter, {n: t.diameter for n, t in setup.tools.items()} if setup.tools else {})
    named = _named(program, beside)
    wired = f"{{file: {named}, tools: {_named(table, beside)}}}" if has_table else named
    one = len(found.tools) == 1
    lines = [
        f"# {(KINDS['mill'].__doc__ or '').strip().splitlines()[0]}",
        f"# Made from {program.name}; what it does not tell is marked assumed. See: cutwise program {named}",
        f"name: {_word(visible(program.stem, lines=False))}", "process: mill", "", f"program: {wired}", "",
        *_stock(program, found, tools), "", *_speed(program, found), "",
        *(_tool(found, tools) if one else _tools(found, tools)), "",
        *comment("cutting coefficients: the program does not name the material; see: cutwise library materials", ""),
        "material: {library: al7075t6}", "",
    ]  # fmt: skip
    if one:
        lines += [
            *comment("the machine and its drives: the program does not name it; see: cutwise library machines", ""),
            "machine: {library: fadal2216, reading: kp_ki_swapped}", "",
        ]  # fmt: skip
    lines += [
        "# limits are yours to say; the run has no verdict without",
        "# requirements: {force_xy_peak: {max: 800 N}}",
    ]
    return "\n".join(lines) + "\n"


def chamfered(step: Path, beside: Path) -> str:
    """A scenario that chamfers the edges of a STEP part; edges and holes that were found stand in comments.

    Raises
    ------
    CadFault
        The file cannot be used; the message says why.
    """
    from cutwise.app.parts import listing, shown

    found = shown(listing(step))
    kept = {key: value for key, value in KINDS["chamfer"].starts.items() if not key.startswith("part.")}
    text = template("chamfer", {**kept, "part.step": _named(step, beside), "part.edges": "all"}, name=step.stem)
    about = [f"# {line}".rstrip() for line in found.splitlines()]
    marker = "\npart:\n"
    head, there, rest = text.partition(marker)
    assert there
    said = "\n".join(
        [f"# what cutwise part finds in {step.name}; select by part.edges: hole:1, edge:2-5, closed, ...", *about]
    )
    return f"{head}\n{said}{marker}{rest}"


# --- the parts of a milling scenario --------------------------------------------------------------------------------------
def _diameters(program: Path, found: Summary, given: str | None, table: Mapping[int, float]) -> dict[int, Known | None]:
    """The diameter of each tool: from the command line, the tool table, or a comment of the program; None if nobody says."""
    if given is not None:
        try:
            size = units.parse(given, "length")
        except units.UnitFault as fault:
            raise ScenarioFault([Fault((), str(fault), file="--tool-diameter")]) from None
        if size <= 0.0:
            raise ScenarioFault([Fault((), "must be greater than 0", file="--tool-diameter")])
        if len(found.tools) > 1:
            called = ", ".join(f"T{tool}" for tool in found.tools)
            message = f"the program calls {called}; write their diameters into a tool table, {program.with_suffix('.tbl').name}"
            raise ScenarioFault([Fault((), message, file="--tool-diameter")])
        return {found.tools[0]: Known(given.strip(), "user", "--tool-diameter")}
    said = _said(program, found)
    known: dict[int, Known | None] = {}
    for tool in found.tools:
        in_table = table.get(tool, 0.0)
        if in_table > 0.0:
            known[tool] = Known(f"{in_table * _MM:.6g} mm", "user", f"tool table beside {program.name}")
        else:
            known[tool] = said.get(tool)
    return known


def _said(program: Path, found: Summary) -> dict[int, Known]:
    """Diameters that comments of the program tell, each with its line; two that differ tell nothing."""
    text = program.read_text(encoding="utf-8", errors="replace")
    unit = "in" if found.units == ("inch",) else "mm"
    seen: dict[int, set[str]] = {}
    sources: dict[int, str] = {}
    for place in _COMMENT.finditer(text):
        words = place[1] or place[2] or ""
        for one in _SAID.finditer(words):
            tool = int(one["tool"]) if one["tool"] else found.tools[0] if len(found.tools) == 1 else 0
            size = float(one["after"] or one["before"])
            if size <= 0.0:
                continue
            seen.setdefault(tool, set()).add(f"{size:.6g} {unit}")
            line = text.count("\n", 0, place.start()) + 1
            sources.setdefault(tool, f"comment in line {line} of {program.name}: {words.strip()[:80]}")
    return {
        tool: Known(next(iter(sizes)), "user", visible(sources[tool], lines=False))
        for tool, sizes in seen.items() if len(sizes) == 1
    }  # fmt: skip


def _stock(program: Path, found: Summary, tools: Mapping[int, Known | None]) -> Iterator[str]:
    """A block round the feed moves; without a diameter only what they span."""
    low, high = found.boxes["feed"]
    top = 0.0 if low[2] < 0.0 else high[2]
    z = f"[{_mm(low[2] - _BELOW)}, {_mm(top)}]"
    of_top = "0, the zero of the program" if low[2] < 0.0 else "the highest feed move"
    sizes = [units.parse(one.text, "length") for one in tools.values() if one is not None]
    if len(sizes) < len(tools):
        yield from comment(
            f"the block: feed moves of {program.name} span x {_mm(low[0])} to {_mm(high[0])}, y {_mm(low[1])} to {_mm(high[1])}; "
            "add radius and diameter of the tool on every side, or make this file again with --tool-diameter", "",
        )  # fmt: skip
        room = 0.0
    else:
        room = 1.5 * max(sizes)
        yield from comment(
            f"assumed: feed moves of {program.name} and, on every side, radius and diameter of the tool; top: {of_top}; bottom: "
            "5 mm below the lowest feed move", "",
        )  # fmt: skip
    x, y = (f"[{_mm(low[i] - room)}, {_mm(high[i] + room)}]" for i in (0, 1))
    yield f"stock: {{x: {x}, y: {y}, z: {z}}}"


def _mm(value: float) -> str:
    return f"{round(value * _MM, 4) + 0.0:.8g} mm"


def _speed(program: Path, found: Summary) -> Iterator[str]:
    speeds = sorted({abs(speed) for speed in found.spindle_speeds})
    if len(speeds) == 1:
        known = Known(f"{speeds[0] * 30.0 / math.pi:.6g} rpm", "user", f"S of {program.name}")
        yield f"operation: {{spindle_speed: {known.written}}}"
    elif speeds:
        yield from comment(
            f"spindle speeds are those of {program.name}: {len(speeds)} of them (operation.spindle_speed replaces all)",
            "",
        )
    else:
        yield from comment(
            f"{program.name} turns no spindle while it cuts (S, M3): write operation: {{spindle_speed: 8000 rpm}}", ""
        )


def _tool(found: Summary, tools: Mapping[int, Known | None]) -> Iterator[str]:
    known = tools[found.tools[0]]
    yield f"tool:                                    # T{found.tools[0]}"
    if known is None:
        yield "  # diameter: neither the program, a tool table beside it nor --tool-diameter tells it: write it here"
    else:
        yield f"  diameter: {known.written}"
    for key, value in _USUAL.items():
        yield f"  {key}: {Known(value, 'assumed', 'usual for aluminium; the program does not say').written}"


def _tools(found: Summary, tools: Mapping[int, Known | None]) -> Iterator[str]:
    yield from comment("shapes are assumed flat, flutes and helix usual: the program tells neither", "")
    yield "tools:"
    for number in found.tools:
        known = tools[number]
        yield f"  - number: {number}"
        yield "    shape: flat"
        if known is None:
            yield "    # diameter: neither the program nor a tool table beside it tells it: write it here"
        else:
            yield f"    diameter: {known.written}"
        for key, value in _USUAL.items():
            yield f"    {key}: {Known(value, 'assumed', 'usual for aluminium; the program does not say').written}"


def _named(file: Path, beside: Path) -> str:
    """The file as the scenario names it: from its own folder."""
    try:
        path = os.path.relpath(file, beside)
    except ValueError:  # another drive
        path = str(file.absolute())
    return _word(path.replace(os.sep, "/"))


def _word(text: str) -> str:
    return (
        text if _PLAIN.fullmatch(text) and not text.replace(".", "").isdigit() else json.dumps(text, ensure_ascii=False)
    )
