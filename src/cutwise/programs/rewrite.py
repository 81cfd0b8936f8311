"""A program with other feeds, and nothing else changed: blocks keep their text but for F, or are split where the feed changes.

What was modal in the program stays so: the first later block that lived on a feed that is no longer in force gets it written.
The new feeds in force are followed along the run itself, so that loops and subroutines are right too.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from cutwise.programs.arcs import arc_length, sweep
from cutwise.programs.canon import Arc, Feed
from cutwise.programs.controller import INCH, MILLIMETRE, PLANES
from cutwise.programs.groups import CYCLES, PROBES
from cutwise.programs.in_force import InForce, rate_of, same
from cutwise.programs.line_words import LineWords, line_words, with_words
from cutwise.programs.plane_curves import Circle
from cutwise.programs.trace import Ran, State, Trace, Word

Triple = tuple[float, float, float]

_DECIMALS = {
    False: 6,
    True: 7,
}  # of coordinates where a block is split, by inch: 1 nm, so that a slanting line stays straight
_SPLIT_WITH = frozenset(
    {0.0, 1.0, 2.0, 3.0, 17.0, 18.0, 19.0, 20.0, 21.0, 61.0, 64.0, 90.0, 91.0, 90.1, 91.1, 93.0, 94.0, 95.0}
)
_LEFT_WHOLE = frozenset("abcuvw@^pthdlq")
_SYNCHRONISED = (330, 331)
_EASE = 1e-6  # relative, by which rounding down may miss a number that is meant


class Part(NamedTuple):
    """A part of a block up to a share of its length, and its feed."""

    share: float  # of the tool's way on the block, 1 at its end
    feed: float  # [m/s]


class Handle(NamedTuple):
    """What may be done with the feed of a line."""

    line: int
    moves: tuple[int, ...]  # numbers of its feed moves in the run
    main: int  # number of the move that the block itself is; others round corners of a compensated contour before it
    change: bool  # its feed may be another one
    split: bool  # it may be split
    why: str  # why not; empty where it may


def down(feed: float, inch: bool) -> float:
    """A feed rounded down to what is written: 1 mm/min, or 0.01 in/min [m/s].

    Examples
    --------
    >>> round(60e3 * down(0.0412345, False), 9), round(60 / 0.0254 * down(0.0412345, True), 9)
    (2474.0, 97.4)
    """
    step = feed_step(inch)
    steps = math.floor(feed / step * (1.0 + _EASE))
    return steps * step if steps >= 1 else feed


def feed_step(inch: bool) -> float:
    """What written feeds are multiples of: 1 mm/min, or 0.01 in/min [m/s]."""
    return (1e-2 * INCH if inch else MILLIMETRE) / 60.0


def handles(trace: Trace) -> dict[int, Handle]:
    """Every line with feed moves, and what may be done with it."""
    found: dict[int, list[int]] = {}
    made = [step for step in trace.steps if isinstance(step, Ran)]
    for number, step in enumerate(made):
        if step.move.kind in ("feed", "arc", "probe"):
            found.setdefault(step.move.line, []).append(number)
    return {line: _handle(trace, made, line, numbers) for line, numbers in found.items()}


def _handle(trace: Trace, made: Sequence[Ran], line: int, numbers: list[int]) -> Handle:
    state, main = trace.state(line), numbers[-1]
    if line not in trace.states and trace.runs[line - 1] == 1 and len(numbers) == 1 and made[main].start is not None:
        return Handle(line, tuple(numbers), main, True, True, "")  # straight, and nothing else in it
    words = line_words(trace.lines[line - 1])

    def one(change: bool, why: str) -> Handle:
        return Handle(line, tuple(numbers), main, change, False, why)

    if any(made[n].move.kind == "probe" for n in numbers) or (line in trace.states and state.motion in PROBES):
        return one(False, "a probing move")
    if line in trace.states and state.motion in _SYNCHRONISED:
        return one(False, "a thread, in step with the spindle")
    if any(type(made[n].command).__name__ in ("TapStroke", "RigidTap") for n in numbers):
        return one(False, "a tapping cycle, in step with the spindle")
    if line in trace.states and state.motion in CYCLES:
        return one(False, "a canned cycle, whose plunge keeps its feed")
    if words.deleted:
        return one(False, "a block that the operator may leave out (/)")
    if not words.words and not words.whole:
        return one(False, "a subroutine of another file")
    runs = int(trace.runs[line - 1])
    if runs > 1 or state.inside:
        return one(True, f"it runs {runs} times" if runs > 1 else "it stands in a subroutine")
    why = _whole_because(made, numbers, words, state)
    return Handle(line, tuple(numbers), main, True, not why, why)


def _whole_because(made: Sequence[Ran], numbers: list[int], words: LineWords, state: State) -> str:
    """Why a block cannot be split; empty where it can."""
    main = made[numbers[-1]]
    rounding = numbers[:-1]
    if rounding and (state.beside is None or len(rounding) > 1 or not isinstance(made[rounding[0]].command, Arc)):
        return "it makes several moves"
    if not isinstance(main.command, Feed | Arc) or main.start is None:
        return "it is no plain line or arc, or coordinates change before it"
    if isinstance(main.command, Arc) and abs(main.command.turns) != 1:
        return "an arc of several turns"
    if not words.whole or any(not word.plain for word in words.words if word.letter != "f"):
        return "it holds expressions"
    if any(word.letter in _LEFT_WHOLE or word.letter == "m" for word in words.words):
        return "it holds words besides a line or an arc"
    if not set(words.codes("g")) <= _SPLIT_WITH:
        return "it holds words besides a line or an arc"
    return ""


def rewritten(trace: Trace, wanted: Mapping[int, Sequence[Part]], known: Mapping[int, Handle]) -> str:
    """The text with other feeds.

    Parameters
    ----------
    trace : Trace
        The program as it ran.
    wanted : mapping
        Line: the parts that it is to be run in, the last up to share 1. Lines that are not there keep their feed.
    known : mapping
        What :func:`handles` tells of the lines.
    """
    made = [step for step in trace.steps if isinstance(step, Ran)]
    style = _Style(trace)
    feeds = {line: _feed_texts(made, known[line], parts, trace, style) for line, parts in wanted.items()}
    explicit = _explicit(trace, feeds)
    out: list[str] = []
    for number, raw in enumerate(trace.lines, start=1):
        if number in feeds and len(feeds[number]) > 1:
            out += _split(trace, made, known[number], wanted[number], feeds[number], number in explicit, style)
        elif number in explicit:
            out.append(_with_feed(raw, explicit[number]))
        else:
            out.append(raw)
    return "\n".join(out)


class _Style:
    """How the program writes its numbers."""

    def __init__(self, trace: Trace) -> None:
        words = [line_words(raw) for raw in trace.lines[:200]]
        plain = [word for one in words for word in one.words if word.plain]
        feeds = [word.value for word in plain if word.letter == "f"]
        places = [word.value for word in plain if word.letter in "xyz"]
        self.point_in_feeds = bool(feeds) and all("." in value for value in feeds)
        self.point_in_places = bool(places) and all("." in value for value in places)

    def feed(self, value: float, decimals: int) -> str:
        """A feed rounded down to some decimals."""
        step = 10.0**-decimals
        number = math.floor(value / step * (1.0 + _EASE)) * step
        return _plain(f"{number:.{decimals}f}", self.point_in_feeds)

    def place(self, value: float, inch: bool) -> str:
        """A coordinate."""
        text = _plain(f"{value:.{_DECIMALS[inch]}f}", self.point_in_places)
        return text.removeprefix("-") if float(text) == 0.0 else text


def _plain(text: str, point: bool) -> str:
    text = text.rstrip("0") if "." in text else text + "."
    return text if point else text.rstrip(".")


def _feed_texts(made: Sequence[Ran], handle: Handle, parts: Sequence[Part], trace: Trace, style: _Style) -> list[str]:
    """F of every part, in the feed mode of the line."""
    state, out, before = trace.state(handle.line), [], 0.0
    unit = INCH if state.inch else MILLIMETRE
    main = made[handle.main]
    for part in parts:
        if state.feed_mode == 95:
            turns = abs(main.move.spindle) / (2.0 * math.pi)
            out.append(style.feed(part.feed / turns / unit, 5 if state.inch else 4))
        elif state.feed_mode == 93:
            way = (part.share - before) * _programmed_length(trace, main, handle.line) * unit
            rate = 60.0 * part.feed / way
            out.append(style.feed(rate, max(0, 6 - math.ceil(math.log10(rate)))))
        else:
            rate = 60.0 * part.feed / unit
            out.append(style.feed(rate, 2 if state.inch else 0 if rate >= 1.0 else 4))
        before = part.share
    return out


def _programmed_length(trace: Trace, main: Ran, line: int) -> float:
    """Length of a block along the programmed contour, in program units, as inverse time counts it."""
    start, end = programmed(trace, main, line)
    if isinstance(main.command, Arc):
        c = main.command
        return arc_length(start, end, Circle(c.first_centre, c.second_centre, c.turns), PLANES[main.plane])
    return math.dist(start, end)


def programmed(trace: Trace, main: Ran, line: int) -> tuple[Triple, Triple]:
    """Ends of a block on the programmed contour, in program units."""
    assert main.start is not None
    if trace.state(line).beside is None:
        return main.start, _command_end(main)
    return trace.state(line - 1).at, trace.states[line].at


def _command_end(main: Ran) -> Triple:
    command = main.command
    if isinstance(command, Arc):
        u, v, w = PLANES[main.plane]
        end = [0.0, 0.0, 0.0]
        end[u], end[v], end[w] = command.first, command.second, command.axial
        return end[0], end[1], end[2]
    assert isinstance(command, Feed)
    return command.x, command.y, command.z


def _explicit(trace: Trace, feeds: Mapping[int, list[str]]) -> dict[int, str]:
    """Lines whose (first) F has to be written, and what: followed along the run until nothing more is found."""
    out = {line: texts[0] for line, texts in feeds.items() if _has_feed(trace.lines[line - 1])}
    out |= {line: texts[0] for line, texts in feeds.items() if trace.state(line).feed_mode == 93}
    while True:
        found = dict(out)
        for line, text in _needed(trace, feeds, out):
            found.setdefault(line, text)
        if len(found) == len(out):
            return out
        out = found


def _needed(trace: Trace, feeds: Mapping[int, list[str]], written: Mapping[int, str]) -> Iterator[tuple[int, str]]:
    """Lines that would run at another feed than they should, with the feed that they need.

    Blocks with ``/`` ran; a line behind them has to have its feed also where the operator leaves all of them out.
    """
    old, new = InForce(), InForce()  # in the program as it was, and in the new one
    deleted = {n for n, raw in enumerate(trace.lines, start=1) if "/" in raw and line_words(raw).deleted}
    for step in trace.steps:
        if isinstance(step, Word):
            old, new = old.told(step, step.rate, deleted), new.told(step, rate_of(step, written), deleted)
            continue
        line = step.move.line
        if step.move.kind not in ("feed", "arc", "probe") or trace.state(line).feed_mode == 93:
            continue
        texts = feeds.get(line)
        wanted = old if texts is None else InForce(float(texts[0]), float(texts[0]))
        said = written.get(line)
        if said is None and wanted.run is not None and _may_be_written(trace, line):
            left_out = line in deleted or wanted.without is None or same(new.without, wanted.without)
            if not (same(new.run, wanted.run) and left_out):
                said = texts[0] if texts is not None else f"{wanted.run:.10g}"
                yield line, said
        if texts is not None:
            said = texts[-1]
        last = None if said is None else float(said)
        new = InForce(wanted.run if last is None else last, new.without if last is None or line in deleted else last)


def _may_be_written(trace: Trace, line: int) -> bool:
    """Whether a word can be added to a line: not to the call of a subroutine of another file, which writes its own feeds."""
    return line not in trace.states or bool(line_words(trace.lines[line - 1]).words)


def _has_feed(raw: str) -> bool:
    """Whether a line has an F."""
    return ("F" in raw or "f" in raw) and line_words(raw).get("f") is not None


def _with_feed(raw: str, feed: str) -> str:
    """A line with a feed; the expression that stood there goes into a comment."""
    words = line_words(raw)
    word = words.get("f")
    if word is not None and not word.plain:
        return with_words(raw, {"f": feed}, [f"was F{word.value}"], words)
    if word is not None and float("".join(word.value.split())) == float(feed):
        return raw
    return with_words(raw, {"f": feed}, (), words)


def _split(
    trace: Trace, made: Sequence[Ran], handle: Handle, parts: Sequence[Part], feeds: Sequence[str], write: bool, style: _Style
) -> list[str]:  # fmt: skip
    """The lines that take the place of one."""
    raw, state, main = trace.lines[handle.line - 1], trace.state(handle.line), made[handle.main]
    words = line_words(raw)
    start, end = programmed(trace, main, handle.line)
    places = [_on_contour(trace, main, handle.line, part.share) for part in parts[:-1]]
    arc = main.command if isinstance(main.command, Arc) else None
    axes = {letter for letter in "xyz" if words.get(letter) is not None}
    if arc is not None:
        axes |= {"xyz"[axis] for axis in PLANES[main.plane][:2]}
    out, before = [], start
    for number, feed in enumerate(feeds):
        last = number == len(feeds) - 1
        values: dict[str, str | None] = {}
        place = list(end if last else places[number])
        for axis, letter in enumerate("xyz"):
            if letter not in axes:
                place[axis] = before[axis]
                continue
            own = words.get(letter)
            if last and own is not None and not state.incremental:
                values[letter] = own.value
            else:
                text = style.place(place[axis] - (before[axis] if state.incremental else 0.0), state.inch)
                values[letter] = text
                place[axis] = float(text) + (before[axis] if state.incremental else 0.0)
        if arc is not None:
            values |= _centre_words(arc, main.plane, before, state, style, first=number == 0, words=words)
        if number > 0:
            code = "G1" if arc is None else "G3" if arc.turns > 0 else "G2"
            gap = " " if " " in raw.strip() or len(words.words) < 2 else ""
            text = gap.join([code, *(letter.upper() + str(value) for letter, value in values.items()), f"F{feed}"])
            out.append(text + ("\r" if raw.endswith("\r") else ""))
        else:
            first = with_words(raw, values)
            out.append(_with_feed(first, feed) if write else first)
        before = (place[0], place[1], place[2])
    return out


def _centre_words(
    arc: Arc, plane: str, start: Triple, state: State, style: _Style, *, first: bool, words: LineWords
) -> dict[str, str | None]:
    """I, J, K of a part from where it begins as written; R gives way to them."""
    u, v, _ = PLANES[plane]
    letters, centre = ("ijk"[u], "ijk"[v]), (arc.first_centre, arc.second_centre)
    if first and words.get("r") is None:
        return {}
    out: dict[str, str | None] = {"r": None} if first else {}
    for letter, axis, value in zip(letters, (u, v), centre, strict=True):
        out[letter] = style.place(value - (0.0 if state.arc_absolute else start[axis]), state.inch)
    return out


def _on_contour(trace: Trace, main: Ran, line: int, share: float) -> Triple:
    """The point of the programmed contour beside which the tool is at a share of its way, in program units."""
    assert main.start is not None
    start, end, beside = main.start, _command_end(main), trace.state(line).beside
    if not isinstance(main.command, Arc):
        q = [a + share * (b - a) for a, b in zip(start, end, strict=True)]
        if beside is not None:
            s, u, v = beside
            way = math.hypot(end[u] - start[u], end[v] - start[v])
            q[u] += s * (end[v] - start[v]) / way
            q[v] -= s * (end[u] - start[u]) / way
        return q[0], q[1], q[2]
    arc = main.command
    u, v, w = PLANES[main.plane]
    cu, cv = arc.first_centre, arc.second_centre
    first = (start[u] - cu, start[v] - cv)
    angle = math.atan2(first[1], first[0]) + share * sweep(first, (end[u] - cu, end[v] - cv), arc.turns)
    radius = math.hypot(*first)
    if beside is not None:
        told = trace.states[line].at
        radius = math.hypot(told[u] - cu, told[v] - cv)
    out = [0.0, 0.0, 0.0]
    out[u], out[v] = cu + radius * math.cos(angle), cv + radius * math.sin(angle)
    out[w] = start[w] + share * (end[w] - start[w])
    return out[0], out[1], out[2]


def with_speed(trace: Trace, speed: float) -> tuple[str, int]:
    """The text with another spindle speed [rpm] in every S of a line that ran, and how many there were."""
    count, out = 0, []
    for raw, runs in zip(trace.lines, trace.runs.tolist(), strict=True):
        word = line_words(raw).get("s") if runs and ("S" in raw or "s" in raw) else None
        if word is None:
            out.append(raw)
            continue
        count += 1
        text = f"{speed:.10g}" + ("." if word.plain and word.value.endswith(".") else "")
        out.append(with_words(raw, {"s": text}, [] if word.plain else [f"was S{word.value}"]))
    return "\n".join(out), count


def with_first_comment(text: str, comment: str) -> str:
    """A program whose first comment is this one; brackets in it become others."""
    said = "".join(letter if letter.isprintable() else " " for letter in comment).translate({40: "[", 41: "]"})
    lines = text.split("\n")
    at = next((n for n, raw in enumerate(lines) if raw.strip()), 0)
    at += lines[at].lstrip("\ufeff \t").startswith("%")
    end = "\r" if lines[0].endswith("\r") else ""
    return "\n".join([*lines[:at], f"({said}){end}", *lines[at:]])
