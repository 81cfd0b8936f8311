"""A shifted path written into its program: chords in place of the lines and arcs that it shifts."""

import math
import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import Block, block_point, join
from cutwise.process.program_path import ProgramPath
from cutwise.programs.block_text import block_named
from cutwise.programs.interpreter import Interpreted
from cutwise.programs.move_table import MODES
from cutwise.spec.faults import Fault, ScenarioFault

_MM = 1e3
_SAME = 1e-6  # [m] between a coordinate as written and where the machine goes
_WORD = re.compile(r"([A-Za-z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
_COMMENT = re.compile(r"\([^)]*\)|;.*$")
_MOTION = (0.0, 1.0, 2.0, 3.0)
_HARMLESS = (17.0, 21.0, 40.0, 54.0, 61.0, 61.1, 64.0, 80.0, 90.0, 90.1, 91.1, 94.0)  # G words that a line may keep
_SHAPE = "XYIJKRP"  # words of the motion that chords replace
_LEAST = 2.0  # times the chord error that a chord needs to run without braking


class Stretch(NamedTuple):
    """Chords of a stretch that runs through."""

    line: np.ndarray  # of the program, that each chord belongs to, shape (n,)
    end: FloatArray  # of each chord [m], shape (n, 2)
    tolerance: float  # that lets the joints run through [m]


def joint_tolerance(start: FloatArray, end: FloatArray, speed: float, acceleration: float, jerk: float) -> float:
    r"""Tolerance of G64 P with which chords are run without braking [m].

    .. math:: P = 2 \cdot \theta^2 \max\left(\frac{v^2}{0.8 a}, \sqrt{v^3/j}\right) / 8

    with the largest angle :math:`\theta` between two chords; twice what their joints need.

    Parameters
    ----------
    start : ndarray
        Where the first chord begins [m], shape (2,).
    end : ndarray
        Ends of the chords [m], shape (n, 2).
    speed, acceleration, jerk : float
        Feed v [m/s], limits a [m/s^2], j [m/s^3].

    Examples
    --------
    Chords of 0.1 mm round a fillet of 2 mm turn by 0.05 rad; at 40 mm/s, 2 m/s^2 and 50 m/s^3 twice 0.35 µm:

    >>> turn = 0.05 * np.arange(3)
    >>> ends = np.cumsum(1e-4 * np.column_stack([np.cos(turn), np.sin(turn)]), axis=0)
    >>> round(1e6 * joint_tolerance(np.zeros(2), ends, 0.04, 2.0, 50.0), 3)
    0.707
    """
    steps = np.diff(np.vstack([start, end]), axis=0)
    angle = np.arctan2(steps[:, 1], steps[:, 0])
    turn = np.abs((np.diff(angle) + math.pi) % (2.0 * math.pi) - math.pi)
    way = max(speed * speed / (0.8 * acceleration), math.sqrt(speed**3 / jerk))
    return float(_LEAST * turn.max(initial=0.0) ** 2 * way / 8.0)


def corner_program(blocks: list[Block], speeds: tuple[float, float], depth: float, mode: str) -> str:
    """A program of lines and arcs in the plane, for a path that no program had.

    Parameters
    ----------
    blocks : list of Block
        Lines and arcs [m].
    speeds : tuple
        Feed [m/s], spindle speed [rad/s].
    depth : float
        Of the cut below z = 0 [m].
    mode : str
        Words of the path mode.
    """
    x, y = (f"{value:.6f}" for value in np.array(blocks[0].start[:2]) * _MM + 0.0)
    lines = [
        "G21 G90 G17 G94",
        f"G0 X{x} Y{y}",
        f"G0 Z{-depth * _MM:.6f}",
        f"S{speeds[1] * 30.0 / math.pi:.9g} M3",
        mode,
    ]
    curve = join(blocks)
    for i, block in enumerate(blocks):
        x, y = (f"{value:.9f}" for value in np.array(block_point(curve, i, block.length)[:2]) * _MM + 0.0)
        feed = "" if i else f" F{speeds[0] * 60.0 * _MM:.9g}"
        if block.straight:
            lines.append(f"G1 X{x} Y{y}{feed}")
            continue
        middle = block.radius * np.array(block.inward[:2]) * _MM + 0.0
        left = block.along[0] * block.inward[1] - block.along[1] * block.inward[0] > 0.0
        lines.append(f"G{3 if left else 2} X{x} Y{y} I{middle[0]:.9f} J{middle[1]:.9f}{feed}")
    return "\n".join([*lines, "M5", "M2", ""])


def mode_words(tolerance: float) -> str:
    """Words of the path mode: exact path, or a blend within a tolerance [m], rounded up to 0.1 µm."""
    return f"G64 P{math.ceil(tolerance * _MM * 1e4 - 1e-9) / 1e4:.4f}" if tolerance > 0.0 else "G61"


def rewritten(read: Interpreted, path: ProgramPath, stretches: list[Stretch], decimals: int, *, moded: bool) -> str:
    """The text of a program with chords in place of some of its lines; every other line is as it was.

    ``moded``: the path mode of the scenario replaces that of the program, and is written in.

    Raises
    ------
    ScenarioFault
        A line that chords cannot stand for, with the reason.
    """
    lines = read.text.split("\n")
    faults = [fault for stretch in stretches for fault in _wrong(read, lines, stretch)]
    if faults:
        raise ScenarioFault(faults)
    ends = {int(line): read.moves[k] for k, line in enumerate(read.moves.lines)}
    new: dict[int, list[str]] = {}
    for stretch in stretches:
        own = sorted(set(_all_lines(path, stretch)))
        for line in own:
            mine = [f"X{x:.{decimals}f} Y{y:.{decimals}f}" for x, y in stretch.end[stretch.line == line] * _MM + 0.0]
            new[line] = _chorded(lines[line - 1], mine)
        new[own[0]].insert(0, mode_words(stretch.tolerance))
        last = ends[own[-1]]
        new[own[-1]].append(mode_of(last.mode, last.tolerance))
    if moded:
        first = min(int(line) for line in read.moves.lines)
        new.setdefault(first, [lines[first - 1]]).insert(0, mode_of("exact_path", 0.0))
    return "\n".join(_joined(lines, new))


def mode_of(mode: str, tolerance: float) -> str:
    """Words of a path mode as a program has it."""
    if mode == MODES[1]:
        return "G61.1"
    if mode == MODES[2]:
        return "G64" if math.isinf(tolerance) else f"G64 P{tolerance * _MM:.6g}"
    return "G61"


def _all_lines(path: ProgramPath, stretch: Stretch) -> Iterator[int]:
    """Lines from the first to the last that chords belong to, those without a chord of their own too."""
    low, high = int(stretch.line.min()), int(stretch.line.max())
    yield from (int(line) for line in np.unique(path.source) if low <= line <= high)


def _wrong(read: Interpreted, lines: list[str], stretch: Stretch) -> Iterator[Fault]:
    """Why lines of a stretch cannot become chords."""
    count = np.bincount(read.moves.lines)
    for line in sorted({int(one) for one in stretch.line}):
        why = _why_not(_words(lines[line - 1]), lines[line - 1], int(count[line]))
        if why is None:
            moves = [read.moves[int(k)] for k in np.flatnonzero(read.moves.lines == line)]
            said = dict(_words(lines[line - 1]))
            for letter, value in zip("XY", moves[-1].end[:2], strict=True):
                if letter in said and abs(said[letter] / _MM - value) > _SAME:
                    why = f"its {letter} is not where the machine goes (inches, increments, an offset, a corrected radius)"
        if why is not None:
            yield Fault(("program",), f"{block_named(read.text, line)}: {why}; its path is not shifted")


def _why_not(words: list[tuple[str, float]], raw: str, runs: int) -> str | None:
    if runs != 1:
        return "runs several times"
    if "#" in raw or "[" in _COMMENT.sub("", raw):
        return "computes its coordinates"
    odd = [value for letter, value in words if letter == "G" and value not in (*_MOTION, *_HARMLESS)]
    if odd:
        return f"G{odd[0]:g} does not go with chords"
    if len({letter for letter, _ in words if letter in "XYIJKRP"}) == 0:
        return "has no coordinates of its own"
    return None


def _words(raw: str) -> list[tuple[str, float]]:
    return [(letter.upper(), float(number)) for letter, number in _WORD.findall(_COMMENT.sub("", raw))]


def _chorded(raw: str, ends: list[str]) -> list[str]:
    """Lines of chords for one line: its N word, other words and comment stay on the first."""
    comments = " ".join(match.group().strip() for match in _COMMENT.finditer(raw))
    code = _COMMENT.sub("", raw)
    kept = [
        match.group().strip()
        for match in _WORD.finditer(code)
        if match[1].upper() not in _SHAPE and not (match[1].upper() == "G" and float(match[2]) in _MOTION)
    ]
    number = [word for word in kept if word[0] in "Nn"]
    rest = [word for word in kept if word[0] not in "Nn"]
    if not ends:
        return [" ".join([*number, *rest, comments]).strip()]
    first = " ".join([*number, "G1", ends[0], *rest, comments]).strip()
    return [first, *(f"G1 {end}" for end in ends[1:])]


def _joined(lines: list[str], new: Mapping[int, list[str]]) -> Iterator[str]:
    """All lines; a motion that later lines had from before a stretch is written where it is first needed."""
    motion: float | None = None  # in force in the program as it was
    pending = False
    for number, raw in enumerate(lines, 1):
        words = _words(raw)
        own = [value for letter, value in words if letter == "G" and value in _MOTION]
        motion = own[-1] if own else motion
        if number in new:
            yield from new[number]
            pending = True
            continue
        if pending and own:
            pending = False
        elif pending and any(letter in "XYZ" for letter, _ in words) and motion is not None:
            pending = False
            if motion != 1.0:
                match = _WORD.search(raw)
                at = match.end() if match is not None and match[1] in "Nn" else len(raw) - len(raw.lstrip())
                raw = f"{raw[:at]}{' ' if at else ''}G{motion:g} {raw[at:].lstrip()}"
        yield raw
