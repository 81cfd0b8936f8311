"""A shifted path written into its program: chords in place of the lines and arcs that it shifts."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import Block, block_point, join
from cutwise.process.program_path import ProgramPath
from cutwise.programs.block_text import block_named
from cutwise.programs.controller import INCH, MILLIMETRE
from cutwise.programs.line_words import TextWord, line_words
from cutwise.programs.move_table import MODES
from cutwise.programs.rewrite import Handle, handles, programmed
from cutwise.programs.trace import Ran, Trace
from cutwise.spec.faults import Fault

_MM = 1e3
_SAME = 1e-6  # [m] by which the coordinates of a program may be shifted otherwise at the two ends of a block
_MOTION = (0.0, 1.0, 2.0, 3.0)
_PATH_MODES = (61.0, 61.1, 64.0)
_SHAPE = "xyijkr"  # words of the motion that chords replace
_PLACES = "xyzijkr"  # words with which a line moves
_LEAST = 2.0  # times the chord error that a chord needs to run without braking
_FINE = 7  # decimals of the last increment of a stretch: what follows in increments stands on it


class Stretch(NamedTuple):
    """Chords of a stretch that runs through."""

    line: np.ndarray  # of the program, that each chord belongs to, shape (n,)
    end: FloatArray  # of each chord [m], shape (n, 2)
    tolerance: float  # that lets the joints run through [m]


def joint_tolerance(
    start: FloatArray, end: FloatArray, speed: FloatArray | float, acceleration: float, jerk: float
) -> float:  # fmt: skip
    r"""Tolerance of G64 P with which chords are run without braking [m].

    .. math:: P = 2 \cdot \theta^2 \max\left(\frac{v^2}{0.8 a}, \sqrt{v^3/j}\right) / 8

    the largest over all joints, with the angle :math:`\theta` between two chords; twice what a joint needs.

    Parameters
    ----------
    start : ndarray
        Where the first chord begins [m], shape (2,).
    end : ndarray
        Ends of the chords [m], shape (n, 2).
    speed : float or ndarray
        At the joints, v [m/s]: one for all, or shape (n - 1,).
    acceleration, jerk : float
        Limits a [m/s^2], j [m/s^3].

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
    v = np.asarray(speed, float)
    way = np.maximum(v * v / (0.8 * acceleration), np.sqrt(v**3 / jerk))
    return float((_LEAST * turn**2 * way / 8.0).max(initial=0.0))


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


def mode_words(tolerance: float, *, inch: bool = False) -> str:
    """Words of the path mode: exact path, or a blend within a tolerance [m], rounded up to 0.1 µm.

    >>> mode_words(5.51e-7), mode_words(0.0), mode_words(5.51e-7, inch=True)
    ('G64 P0.0006', 'G61', 'G64 P0.000022')
    """
    if tolerance <= 0.0:
        return "G61"
    decimals = 6 if inch else 4
    steps = math.ceil(tolerance / (INCH if inch else MILLIMETRE) * 10**decimals - 1e-9)
    return f"G64 P{steps / 10**decimals:.{decimals}f}"


def mode_of(mode: str, tolerance: float, *, inch: bool = False) -> str:
    """Words of a path mode as a program has it."""
    if mode == MODES[1]:
        return "G61.1"
    if mode == MODES[2]:
        return "G64" if math.isinf(tolerance) else f"G64 P{tolerance / (INCH if inch else MILLIMETRE):.6g}"
    return "G61"


def writable(
    trace: Trace, path: ProgramPath, stretches: Sequence[Stretch]
) -> tuple[list[Stretch], list[Fault]]:  # fmt: skip
    """Stretches whose lines chords can stand for, and why the others cannot, line by line."""
    known, made, text = handles(trace), _made(trace), "\n".join(trace.lines)
    kept, faults = [], []
    for stretch in stretches:
        found = [
            Fault(("program",), f"{block_named(text, line)}: {why}; its path is not shifted")
            for line in _all_lines(path, stretch)
            if (why := _why_not(trace, made, known.get(line), line))
        ]
        faults += found
        if not found:
            kept.append(stretch)
    return kept, list(dict.fromkeys(faults))  # a line that runs several times has one reason


def _made(trace: Trace) -> list[Ran]:
    return [step for step in trace.steps if isinstance(step, Ran)]


def _why_not(trace: Trace, made: Sequence[Ran], handle: Handle | None, line: int) -> str:
    """Why a line cannot become chords; empty where it can."""
    state = trace.state(line)
    if handle is None:
        return "it is no feed move of this file"
    if not handle.split:
        return handle.why
    if state.beside is not None:
        return "cutter compensation is on (G41, G42), and chords are those of the tool centre"
    if state.feed_mode == 93:
        return "in inverse time (G93) each chord would need an F of its own"
    if not any(line_words(trace.lines[line - 1]).get(letter) for letter in _SHAPE):
        return "it has no coordinates of its own"
    if _origin(trace, made[handle.main]) is None:
        return "its coordinates are turned"
    return ""


def _origin(trace: Trace, main: Ran) -> FloatArray | None:
    """Where the zero of the program's x and y stands among the moves [m]; None where its axes are turned."""
    state = trace.state(main.move.line)
    unit = INCH if state.inch else MILLIMETRE
    start, end = programmed(trace, main, main.move.line)
    found = [np.subtract(a[:2], np.multiply(b[:2], unit)) for a, b in ((main.move.start, start), (main.move.end, end))]
    return np.asarray(found[1]) if np.abs(found[0] - found[1]).max() < _SAME else None


def rewritten(trace: Trace, path: ProgramPath, stretches: Sequence[Stretch], decimals: int, *, moded: bool) -> str:
    """The text of a program with chords in place of some of its lines; every other line is as it was.

    Chords stand in the coordinates of the lines that they replace: inches or millimetres, absolute or in increments, shifted.

    Parameters
    ----------
    trace : Trace
        The program as it ran.
    path : ProgramPath
        Its path.
    stretches : sequence of Stretch
        Of lines that :func:`writable` lets pass.
    decimals : int
        Of the millimetre.
    moded : bool
        The path mode of the scenario replaces that of the program, and is written in.
    """
    known, made = handles(trace), _made(trace)
    new: dict[int, list[str]] = {}
    at: dict[int, FloatArray] = {}  # where chorded moves end as written, among the moves [m]
    for stretch in stretches:
        own = list(_all_lines(path, stretch))
        for line in own:
            handle = known[line]
            main = made[handle.main]
            begin = at.get(handle.main - 1, np.asarray(main.move.start[:2]))
            ends = stretch.end[stretch.line == line]
            texts, at[handle.main] = _places(trace, main, begin, ends, decimals, last=line == own[-1])
            new[line] = _chorded(trace.lines[line - 1], texts)
            if line == own[0] or _moded_between(trace, own, line):
                words = mode_words(stretch.tolerance, inch=trace.state(line - 1).inch)
                new[line].insert(0, _like(trace.lines[line - 1], words))
        last = made[known[own[-1]].main].move
        words = mode_of(last.mode, last.tolerance, inch=trace.state(own[-1]).inch)
        new[own[-1]].append(_like(trace.lines[own[-1] - 1], words))
    if moded:
        first = min(one.move.line for one in made)
        text = _like(trace.lines[first - 1], mode_of("exact_path", 0.0))
        new.setdefault(first, [trace.lines[first - 1]]).insert(0, text)
    return "\n".join(_joined(trace.lines, new))


def _like(raw: str, text: str) -> str:
    """A line that ends as another one does."""
    return text + ("\r" if raw.endswith("\r") else "")


def _places(
    trace: Trace, main: Ran, begin: FloatArray, ends: FloatArray, decimals: int, *, last: bool
) -> tuple[list[str], FloatArray]:
    """X and Y of the chords of a line, and where the last one ends as written [m]; ``begin``: where the tool is [m]."""
    state = trace.state(main.move.line)
    unit, most = (INCH, decimals + 2) if state.inch else (MILLIMETRE, decimals)
    origin = _origin(trace, main)
    assert origin is not None
    at, texts = (begin - origin) / unit, []
    for number, end in enumerate((ends - origin) / unit):
        exact = state.incremental and last and number == len(ends) - 1
        digits = max(most, _FINE) if exact else most
        base = at if state.incremental else np.zeros(2)
        values = [round(float(value), digits) + 0.0 for value in end - base]
        texts.append(" ".join(f"{letter}{value:.{digits}f}" for letter, value in zip("XY", values, strict=True)))
        at = base + values
    return texts, at * unit + origin


def _moded_between(trace: Trace, own: Sequence[int], line: int) -> bool:
    """Whether a line between this one of a stretch and the one before has another path mode."""
    before = own[own.index(line) - 1]
    words = (line_words(raw) for raw in trace.lines[before - 1 : line - 1])
    return any(code in _PATH_MODES for one in words for code in one.codes("g"))


def _all_lines(path: ProgramPath, stretch: Stretch) -> Iterator[int]:
    """Lines from the first to the last that chords belong to, those without a chord of their own too."""
    low, high = int(stretch.line.min()), int(stretch.line.max())
    yield from (int(line) for line in np.unique(path.source) if low <= line <= high)


def _chorded(raw: str, ends: list[str]) -> list[str]:
    """Lines of chords for one line: its N word, other words and comment stay on the first."""
    text = _without(raw, [
        word for word in line_words(raw).words
        if word.letter in _SHAPE or (word.letter == "g" and float("".join(word.value.split())) in (*_MOTION, *_PATH_MODES))
    ])  # fmt: skip
    if not ends:
        return [text]
    number = line_words(text).get("n")
    at = number.end if number is not None else len(text) - len(text.lstrip(" \t\ufeff"))
    end = "\r" if raw.endswith("\r") else ""
    first = " ".join(part for part in (text[:at].rstrip(), f"G1 {ends[0]}", text[at:].strip()) if part) + end
    return [first, *(_like(raw, f"G1 {end}") for end in ends[1:])]


def _without(raw: str, gone: Sequence[TextWord]) -> str:
    """A line without some of its words."""
    for word in sorted(gone, key=lambda one: -one.start):
        start = word.start
        while start > 0 and raw[start - 1] in " \t":
            start -= 1
        raw = raw[:start] + raw[word.end :]
    return raw


def _joined(lines: Sequence[str], new: Mapping[int, list[str]]) -> Iterator[str]:
    """All lines; a motion that later lines had from before a stretch is written where it is first needed."""
    motion: float | None = None  # in force in the program as it was
    pending = False
    for number, raw in enumerate(lines, 1):
        words = line_words(raw)
        own = [code for code in words.codes("g") if code in _MOTION]
        motion = own[-1] if own else motion
        if number in new:
            yield from new[number]
            pending = True
            continue
        if pending and own:
            pending = False
        elif pending and motion is not None and any(words.get(letter) for letter in _PLACES):
            pending = False
            if motion != 1.0:
                first = words.get("n")
                at = first.end if first is not None else len(raw) - len(raw.lstrip())
                raw = f"{raw[:at]}{' ' if at else ''}G{motion:g} {raw[at:].lstrip()}"
        yield raw
