"""Moves written for other controls: a Fanuc-compatible program, and APT; lengths in mm, feeds in mm/min.

The moves stand as they were run: subprograms, cycles, expressions and a corrected radius are worked in.
"""

import math
from collections.abc import Callable, Iterator, Sequence

from cutwise.programs.moves import Move, Point

_MM = 1e3
_PER_MINUTE = 60e3  # m/s to mm/min
_RPM = 30.0 / math.pi
_TURN = 2.0 * math.pi
_PLANES = ((17, "IJ", 0, 1), (18, "IK", 0, 2), (19, "JK", 1, 2))  # code, centre words, their axes
_NORMAL = (2, 1, 0)  # axis that each plane leaves out
_PARALLEL = 1e-9
_LETTERS = "XYZ"


class Unwritten(ValueError):
    """A move that the language has no words for, in plain words with its line."""


def plain(text: str, *, upper: bool = False) -> str:
    """Text that is safe in a comment of any control: one line, no brackets, no control characters.

    >>> plain("pocket (2)", upper=True)
    'POCKET _2_'
    """
    kept = "".join(letter if " " <= letter <= "~" and letter not in "()%$;!&" else "_" for letter in text)
    return kept.upper() if upper else kept


def fanuc(
    name: str, moves: Sequence[Move], *, number: int = 1, decimals: int = 6, comments: Sequence[str] = ()
) -> str:  # fmt: skip
    """A program for Fanuc-compatible controls: O number, decimal points everywhere, incremental centres.

    Blends with a tolerance (G64 P) have no word there; they are written as cutting mode (G64).

    Parameters
    ----------
    name : str
        Told in the comment behind the O number.
    moves : sequence of Move
        Of the tool tip.
    number : int
        Of the program, 1 to 9999.
    decimals : int
        Of the millimetre.
    comments : sequence of str
        Comments behind the first.

    Raises
    ------
    Unwritten
        A probing move, a rotary axis, or an arc about a tilted axis.
    """
    told = [f"({plain(text, upper=True)})" for text in comments]
    lines = ["%", f"O{number:04d} ({plain(name, upper=True)[:40]})", *told, "G21 G17 G90 G94 G40 G49 G80"]
    lines += _Fanuc(decimals).lines(moves)
    return "\n".join([*lines, "M30", "%", ""])


def rs274(name: str, moves: Sequence[Move], *, decimals: int = 6, comments: Sequence[str] = ()) -> str:
    """A program in the dialect that is read here: path modes by G61, G61.1 and G64 P, dwells in seconds.

    Parameters and errors are those of :func:`fanuc`.

    Examples
    --------
    >>> print(rs274("a", []))
    (a)
    G21 G17 G90 G94 G40 G49 G80
    M2
    <BLANKLINE>
    """
    told = [f"({plain(text)})" for text in (name, *comments)]
    return "\n".join([*told, "G21 G17 G90 G94 G40 G49 G80", *_Plain(decimals).lines(moves), "M2", ""])


class _Fanuc:
    """What is in force, and the words that are not."""

    def __init__(self, decimals: int) -> None:
        self.decimals = decimals
        self.at: Point | None = None  # as written [mm]
        self.feed, self.plane, self.mode, self.tool, self.spindle, self.coolant = "", 17, "", 0, 0.0, ""

    def lines(self, moves: Sequence[Move]) -> Iterator[str]:
        for move in moves:
            _check(move)
            yield from self._before(move)
            if self.at is None and move.kind in ("feed", "arc"):  # where the tool stood is not known to this control
                start = self._rounded(move.start)
                yield f"G0 X{self._number(start[0])} Y{self._number(start[1])}"
                yield f"G0 Z{self._number(start[2])}"
                self.at = start
            if move.kind == "dwell":
                yield self._dwell(move)
            elif move.kind == "arc":
                yield from self._arc(move)
            else:
                yield from self._straight(move)

    def _before(self, move: Move) -> Iterator[str]:
        """Tool, spindle, coolant and path mode."""
        if move.tool != self.tool:
            self.tool = move.tool
            yield f"T{move.tool} M6"
        if move.spindle != self.spindle:
            self.spindle = move.spindle
            yield "M5" if move.spindle == 0.0 else f"S{abs(move.spindle) * _RPM:.0f} M{3 if move.spindle > 0.0 else 4}"
        if move.coolant != self.coolant:
            self.coolant = move.coolant
            yield from ([f"M{7 if word == 'mist' else 8}" for word in move.coolant.split()] if move.coolant else ["M9"])
        mode = self._mode(move)
        if mode != self.mode:
            self.mode = mode
            yield mode

    def _mode(self, move: Move) -> str:
        return "G61" if move.mode == "exact_stop" else "G64"

    def _dwell(self, move: Move) -> str:
        return f"G4 P{round(move.dwell * 1e3)}"

    def _straight(self, move: Move) -> Iterator[str]:
        end = self._rounded(move.end)
        words = self._ends(end)
        if words:
            yield " ".join([f"G{0 if move.kind == 'rapid' else 1}", *words, *self._feed_word(move)])
        self.at = end

    def _arc(self, move: Move) -> Iterator[str]:
        place = next((k for k, axis in enumerate(_NORMAL) if abs(abs(move.axis[axis]) - 1.0) < _PARALLEL), None)
        if place is None:
            raise Unwritten(f"line {move.line}: an arc about a tilted axis has no word in this language")
        code, letters, u, v = _PLANES[place]
        left = (move.sweep > 0.0) == (move.axis[_NORMAL[place]] > 0.0)
        if code != self.plane:
            self.plane = code
            yield f"G{code}"
        assert self.at is not None
        for end in _turns(move):
            there = self._rounded(end)
            centre = [self._number(move.centre[axis] * _MM - self.at[axis]) for axis in (u, v)]
            words = [
                f"{letter}{self._number(there[k])}"
                for k, letter in enumerate(_LETTERS)
                if k in (u, v) or there[k] != self.at[k]
            ]
            yield " ".join([
                f"G{3 if left else 2}", *words, *(f"{letter}{value}" for letter, value in zip(letters, centre, strict=True)),
                *self._feed_word(move),
            ])  # fmt: skip
            self.at = there

    def _ends(self, end: Point) -> list[str]:
        return [
            f"{letter}{self._number(value)}"
            for letter, value, old in zip(_LETTERS, end, self.at or (math.nan,) * 3, strict=True)
            if value != old
        ]

    def _feed_word(self, move: Move) -> list[str]:
        if move.kind == "rapid":
            return []
        feed = self._number(move.feed * _PER_MINUTE)
        if feed == self.feed:
            return []
        self.feed = feed
        return [f"F{feed}"]

    def _rounded(self, point: Point) -> Point:
        x, y, z = (round(value * _MM, self.decimals) + 0.0 for value in point)
        return x, y, z

    def _number(self, value: float) -> str:
        """A number with its decimal point, without which these controls take least increments."""
        text = f"{value:.{self.decimals}f}".rstrip("0")
        return "0." if text in ("-0.", "0.") else text


class _Plain(_Fanuc):
    """The same in the words of LinuxCNC."""

    def _mode(self, move: Move) -> str:
        words = {"exact_path": "G61", "exact_stop": "G61.1"}
        return words.get(move.mode, f"G64 P{self._number(move.tolerance * _MM)}" if move.tolerance > 0.0 else "G64")

    def _dwell(self, move: Move) -> str:
        return f"G4 P{move.dwell:.9g}"


def apt(
    name: str, moves: Sequence[Move], *, diameter: float | None = None, decimals: int = 6, comments: Sequence[str] = ()
) -> str:  # fmt: skip
    """APT (CL data) of moves: GOTO of the tool tip, CIRCLE before the end of an arc.

    Parameters
    ----------
    name : str
        Of the part.
    moves : sequence of Move
        Of the tool tip.
    diameter : float, optional
        Of the cutter [m].
    decimals : int
        Of the millimetre.
    comments : sequence of str
        Comments.

    Raises
    ------
    Unwritten
        A probing move or a rotary axis.
    """
    lines = [f"PARTNO/{plain(name)}", *(f"$$ {plain(text)}" for text in comments), "UNITS/MM"]
    lines += [] if diameter is None else [f"CUTTER/{diameter * _MM:.4f}"]
    lines += _apt_lines(moves, decimals)
    return "\n".join([*lines, "SPINDL/OFF", "FINI", ""])


def _apt_lines(moves: Sequence[Move], decimals: int) -> Iterator[str]:
    feed, tool, spindle, begun = "", 0, 0.0, False
    goto = _goto(decimals)
    for move in moves:
        _check(move)
        if not begun:
            begun = True
            yield "FROM/" + goto(move.start)
        if move.tool != tool:
            tool = move.tool
            yield f"LOADTL/{tool}"
        if move.spindle != spindle:
            spindle = move.spindle
            way = "CLW" if spindle > 0.0 else "CCLW"
            yield "SPINDL/OFF" if spindle == 0.0 else f"SPINDL/{abs(spindle) * _RPM:.0f},RPM,{way}"
        if move.kind == "dwell":
            yield f"DELAY/{move.dwell:.6g}"
            continue
        if move.kind == "rapid":
            yield "RAPID"
        elif (rate := f"FEDRAT/{move.feed * _PER_MINUTE:.9g},MMPM") != feed:
            feed = rate
            yield rate
        for end in _turns(move) if move.kind == "arc" else (move.end,):
            if move.kind == "arc":
                side = math.copysign(1.0, move.sweep)
                radius = _radius(move)
                axis = ",".join(f"{side * part + 0.0:.9f}" for part in move.axis)
                yield f"CIRCLE/{goto(move.centre)},{axis},{radius * _MM:.{decimals}f}"
            yield "GOTO/" + goto(end)


def _goto(decimals: int) -> Callable[[Point], str]:
    return lambda point: ",".join(f"{round(value * _MM, decimals) + 0.0:.{decimals}f}" for value in point)


def _radius(move: Move) -> float:
    """Radius of an arc [m]."""
    away = [a - b for a, b in zip(move.start, move.centre, strict=True)]
    along = sum(a * b for a, b in zip(away, move.axis, strict=True))
    return math.sqrt(max(0.0, sum(a * a for a in away) - along * along))


def _check(move: Move) -> None:
    if move.kind == "probe":
        raise Unwritten(f"line {move.line}: a probing move belongs to the control that runs it, and is not written")
    if move.rotary_start != move.rotary_end or any(move.rotary_end):
        raise Unwritten(f"line {move.line}: a rotary axis is not written in this language here")


def _turns(move: Move) -> list[Point]:
    """Ends of the turns of an arc: languages without a count of turns get one arc for each."""
    count = max(1, math.ceil(abs(move.sweep) / _TURN - 1e-9))
    if count == 1:
        return [move.end]
    rest = abs(move.sweep) - (count - 1) * _TURN
    rise = [b - a for a, b in zip(move.start, move.end, strict=True)]
    along = sum(a * b for a, b in zip(rise, move.axis, strict=True))
    ends: list[Point] = []
    for k in range(1, count):
        share = k * _TURN / (rest + (count - 1) * _TURN)
        x, y, z = (a + share * along * b for a, b in zip(move.start, move.axis, strict=True))
        ends.append((x, y, z))
    return [*ends, move.end]
