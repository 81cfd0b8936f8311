"""A program without loops and subprograms: every line that runs several times is written out, once for each run."""

import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cutwise.programs import written_moves
from cutwise.programs.block import Block
from cutwise.programs.controller import Controller
from cutwise.programs.interpreter import interpret, reading
from cutwise.programs.line_words import LineWords, line_words, with_words
from cutwise.programs.move_table import Moves
from cutwise.programs.moves import Point
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup
from cutwise.spec.faults import Fault, ScenarioFault

_HEADER = re.compile(r"\s*O\s*\d+\s*(\(.*)?$")  # of a program of a Fanuc control
_MOST = 500_000  # lines
_SAME = 1e-9  # [m] by which a written out move may end elsewhere
_ALIKE = 1e-9  # relative, of feeds and speeds
_STEERS = (98.0, 99.0)  # M words that call, and return


class Unrolled(NamedTuple):
    """A program that is written out."""

    text: str
    before: int  # lines of the program
    repeated: int  # of them those that ran several times


class _Order:
    """Keeps every line of the main program as it runs, with what it came to."""

    closely = True

    def __init__(self, run: Rs274) -> None:
        self.run = run
        self.ran_lines: list[tuple[int, Block | None]] = []

    def ran_plain(self, first: int, end: int) -> None:  # noqa: ARG002
        raise AssertionError("every line is asked for by itself")

    def ran(self, at: int, controller: Controller) -> None:  # noqa: ARG002
        self.ran_lines.append((at, self.run.executed))


def unrolled(text: str, name: str, setup: Setup) -> Unrolled:
    """A G-code program without loops, branches, calls and variables, that makes the same moves.

    Lines that run once keep their text but for expressions, which become their numbers. Lines that steer (O words, WHILE, M98,
    assignments) go. A program in which no line runs twice stays as it is.

    Raises
    ------
    ScenarioFault
        The program cannot be run, is APT, gets too long, or would not make the same moves (subroutines of other files).

    Examples
    --------
    >>> told = unrolled("G21 G90\\nO1 REPEAT [2]\\nG91 G1 X1 F60 (step)\\nO1 ENDREPEAT\\nM2\\n", "a.nc", Setup())
    >>> told.text.split("\\n")[:4], told.repeated
    (['G21 G90', 'G91 G1 X1 F60 (step)', 'G91 G1 X1 F60 (step)', 'M2'], 1)
    """
    run = reading(text, name, setup)
    if not isinstance(run, Rs274):
        raise ScenarioFault([Fault(("program",), "is APT, which has no subprograms to be written out here")])
    order = _Order(run)
    run.watch = order
    for _ in run.commands():
        pass
    lines = run.flow.main.lines
    runs = np.bincount([at for at, _ in order.ran_lines], minlength=len(lines))
    acts = {at for at, block in order.ran_lines if block is not None}
    repeated = sum(1 for at in acts if runs[at] > 1)
    if not repeated:
        return Unrolled(text, len(lines), 0)
    if len(order.ran_lines) > _MOST:
        raise ScenarioFault(
            [Fault(("program",), f"has {len(order.ran_lines)} lines when it is written out, more than {_MOST}")]
        )
    found = "\n".join(_lines(lines, order.ran_lines, runs))
    _prove(text, found, name, setup)
    return Unrolled(found, len(lines), repeated)


def _lines(lines: list[str], order: list[tuple[int, Block | None]], runs: np.ndarray) -> Iterator[str]:
    end = "\r" if lines[0].endswith("\r") else ""
    first = order[0][0]
    yield from (raw for raw in lines[:first] if raw.lstrip("\ufeff \t").startswith("%"))
    begun = False
    for at, block in order:
        raw = lines[at]
        words = line_words(raw)
        begun = begun or block is not None
        if block is None:
            if (words.whole and not words.words) or (
                not begun and _HEADER.match(raw)
            ):  # a comment, nothing, the O number
                yield raw
            continue
        steers = not words.whole or set(words.codes("m")) & set(_STEERS) or 65.0 in words.codes("g")
        if not steers and all(word.plain for word in words.words):
            yield _unnumbered(raw, words) if runs[at] > 1 else raw
        else:
            yield _written(block) + end
    if any(raw.lstrip("\ufeff \t").startswith("%") for raw in lines[:first]):
        yield "%" + end
    yield ""


def _unnumbered(raw: str, words: LineWords) -> str:
    """A line without its block number, which would be there several times."""
    return with_words(raw, {"n": None}, (), words).lstrip() if words.get("n") is not None else raw


def _written(block: Block) -> str:
    """A block by its numbers."""
    codes = [f"G{code / 10.0:g}" for code in block.g.values()]
    places = [letter.upper() + _number(letter, value) for letter, value in block.values.items() if letter != "n"]
    return " ".join([*codes, *places, *(f"M{code}" for code in block.m.values())])


def _number(letter: str, value: float) -> str:
    if letter in "thdplq" and value == round(value):
        return f"{value:.0f}"
    text = f"{value:.9f}".rstrip("0")
    return "0." if text == "-0." else text


def _prove(text: str, found: str, name: str, setup: Setup) -> None:
    """Both programs make the same moves.

    Raises
    ------
    ScenarioFault
        With the line of the first that differs.
    """
    compare(interpret(text, name, setup).moves, interpret(found, name, setup).moves)


def as_rs274(text: str, name: str, setup: Setup) -> tuple[str, Point | None]:
    """A program of any kind as plain G-code, by its moves, and where it begins [m].

    Comments and words that make no motion are not kept; work offsets and lengths of tools are worked in.

    Raises
    ------
    ScenarioFault
        The program cannot be run, or has moves that plain G-code has no words for.
    """
    old = interpret(text, name, setup).moves
    try:
        found = written_moves.rs274(name, old)
    except written_moves.Unwritten as why:
        raise ScenarioFault([Fault(("program",), f"cannot be written as G-code: {why}")]) from None
    begin = old[0].start if len(old) else None
    compare(old, interpret(found, "program.nc", setup._replace(start=begin, systems={})).moves)
    return found, begin


def compare(old: Moves, new: Moves) -> None:
    """Two programs make the same moves.

    Raises
    ------
    ScenarioFault
        With the line of the first that differs.
    """
    for k in range(min(len(old), len(new))):
        if not _same(old, new, k):
            raise ScenarioFault([_differs(old[k].line)])
    if len(old) != len(new):
        raise ScenarioFault([_differs(old[min(len(old), len(new)) - 1].line)])


def _same(old: Moves, new: Moves, k: int) -> bool:
    a, b = old[k], new[k]
    ends = all(abs(p - q) <= _SAME for p, q in zip((*a.end, *a.centre), (*b.end, *b.centre), strict=True))
    rates = all(
        p == q or abs(p - q) <= _ALIKE * abs(p)
        for p, q in ((a.feed, b.feed), (a.spindle, b.spindle), (a.sweep, b.sweep))
    )
    return a.kind == b.kind and a.tool == b.tool and a.mode == b.mode and ends and rates


def _differs(line: int) -> Fault:
    why = "a subroutine of another file, or a parameter of the control, is behind it"
    return Fault(("program",), f"cannot be written out: moves from line {line} on would not be the same ({why})")
