"""The moves of a program, kept as columns of numbers: a tenth of the room that as many records take."""

from array import array
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from cutwise.programs.moves import Kind, Move, Point

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

KINDS: tuple[Kind, ...] = ("rapid", "feed", "arc", "dwell", "probe")
CUTTING = (KINDS.index("feed"), KINDS.index("arc"))  # kinds of moves that have a feed
MODES = ("exact_path", "exact_stop", "blend")
_ORIGIN: Point = (0.0, 0.0, 0.0)
_Z: Point = (0.0, 0.0, 1.0)
_NUMBERS, _CODES, _ARC = 6, 5, 7  # a move


class Moves(Sequence[Move]):
    """Moves in their order; each record is made when it is asked for."""

    def __init__(self, source: Iterable[Move]) -> None:
        self._numbers = array("d")  # end, feed, spindle, tolerance
        self._codes = array("i")  # kind, mode, line, tool, coolant
        self._arc_numbers = array("d")  # centre, axis, sweep of the arcs
        self._arcs = array("i")  # which moves are arcs
        self._starts: dict[int, Point] = {}  # where a move does not begin at the end of the last
        self._dwells: dict[int, float] = {}
        self._turns: dict[int, tuple[Point, Point]] = {}  # rotary axes that are not at zero
        self._coolants: dict[str, int] = {}
        at = _ORIGIN
        kinds, modes = ({name: k for k, name in enumerate(names)} for names in (KINDS, MODES))
        for i, move in enumerate(source):
            self._numbers.extend((*move.end, move.feed, move.spindle, move.tolerance))
            coolant = self._coolants.setdefault(move.coolant, len(self._coolants))
            self._codes.extend((kinds[move.kind], modes[move.mode], move.line, move.tool, coolant))
            if move.kind == "arc":
                self._arcs.append(i)
                self._arc_numbers.extend((*move.centre, *move.axis, move.sweep))
            elif move.dwell:
                self._dwells[i] = move.dwell
            if move.start != at:
                self._starts[i] = move.start
            if move.rotary_start != _ORIGIN or move.rotary_end != _ORIGIN:
                self._turns[i] = (move.rotary_start, move.rotary_end)
            at = move.end
        self._coolant_names = list(self._coolants)

    def __len__(self) -> int:
        return len(self._codes) // _CODES

    @overload
    def __getitem__(self, i: int) -> Move: ...
    @overload
    def __getitem__(self, i: slice) -> tuple[Move, ...]: ...
    def __getitem__(self, i: int | slice) -> Move | tuple[Move, ...]:
        if isinstance(i, slice):
            return tuple(self._made(k, bisect_left(self._arcs, k)) for k in range(*i.indices(len(self))))
        k = i if i >= 0 else len(self) + i
        if not 0 <= k < len(self):
            raise IndexError(f"move {i} of {len(self)}")
        return self._made(k, bisect_left(self._arcs, k))

    def __iter__(self) -> Iterator[Move]:
        arc = 0
        for k in range(len(self)):
            move = self._made(k, arc)
            arc += move.kind == "arc"
            yield move

    def __eq__(self, other: Any) -> bool:
        if not isinstance(other, Sequence):
            return NotImplemented
        return len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def _end(self, k: int) -> Point:
        x, y, z = self._numbers[_NUMBERS * k : _NUMBERS * k + 3]
        return x, y, z

    def _made(self, k: int, arc: int) -> Move:
        x, y, z, feed, spindle, tolerance = self._numbers[_NUMBERS * k : _NUMBERS * (k + 1)]
        kind, mode, line, tool, coolant = self._codes[_CODES * k : _CODES * (k + 1)]
        start = self._starts.get(k) or (self._end(k - 1) if k else _ORIGIN)
        centre, axis, sweep = _ORIGIN, _Z, 0.0
        if KINDS[kind] == "arc":
            a, b, c, u, v, w, sweep = self._arc_numbers[_ARC * arc : _ARC * (arc + 1)]
            centre, axis = (a, b, c), (u, v, w)
        turned = self._turns.get(k, (_ORIGIN, _ORIGIN))
        return Move(
            KINDS[kind], start, (x, y, z), centre, axis, sweep, feed, spindle, MODES[mode], tolerance,
            self._dwells.get(k, 0.0), line, *turned, tool, self._coolant_names[coolant],
        )  # fmt: skip

    def turning(self) -> Iterator[Move]:
        """The moves at which a rotary axis is not at zero."""
        return (self[k] for k in self._turns)

    # columns

    @property
    def kinds(self) -> IntArray:
        """Number of each kind in :data:`KINDS`, shape (n,)."""
        return self._code(0)

    @property
    def modes(self) -> IntArray:
        """Number of each path mode in :data:`MODES`, shape (n,)."""
        return self._code(1)

    @property
    def lines(self) -> IntArray:
        """Line of the program, shape (n,)."""
        return self._code(2)

    @property
    def tools(self) -> IntArray:
        """Tool in the spindle, shape (n,)."""
        return self._code(3)

    def _code(self, k: int) -> IntArray:
        return np.frombuffer(self._codes, dtype=np.int32).reshape(-1, _CODES)[:, k]

    @property
    def ends(self) -> FloatArray:
        """End points [m], shape (n, 3)."""
        return self._number()[:, :3]

    @property
    def starts(self) -> FloatArray:
        """Start points [m], shape (n, 3)."""
        out = np.zeros((len(self), 3))
        out[1:] = self.ends[:-1]
        for k, point in self._starts.items():
            out[k] = point
        return out

    @property
    def feeds(self) -> FloatArray:
        """Feed [m/s], infinite for rapid moves, shape (n,)."""
        return self._number()[:, 3]

    @property
    def spindles(self) -> FloatArray:
        """Spindle speed [rad/s], positive clockwise, shape (n,)."""
        return self._number()[:, 4]

    @property
    def tolerances(self) -> FloatArray:
        """Of blends [m], shape (n,)."""
        return self._number()[:, 5]

    def _number(self) -> FloatArray:
        return np.frombuffer(self._numbers, dtype=np.float64).reshape(-1, _NUMBERS)

    @property
    def dwells(self) -> FloatArray:
        """Time of each dwell [s], shape (n,)."""
        out = np.zeros(len(self))
        out[list(self._dwells)] = list(self._dwells.values())
        return out

    @property
    def arcs(self) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """Which moves are arcs, their centres [m], axes, and sweeps [rad]."""
        table = np.frombuffer(self._arc_numbers, dtype=np.float64).reshape(-1, _ARC)
        return np.frombuffer(self._arcs, dtype=np.int32), table[:, :3], table[:, 3:6], table[:, 6]

    def rotary(self, which: npt.NDArray[np.intp]) -> FloatArray:
        """A, B, C at start and end of some moves [rad], shape (m, 2, 3)."""
        out = np.zeros((len(self), 2, 3)) if self._turns else np.zeros((1, 2, 3))
        for k, turned in self._turns.items():
            out[k] = turned
        return out[which] if self._turns else np.zeros((len(which), 2, 3))
