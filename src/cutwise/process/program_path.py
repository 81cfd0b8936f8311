"""From the moves of a program, or the blocks of a path, to the commanded path with its feeds, stops and blends."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.io.programs.interpreter import Interpreted
from cutwise.io.programs.moves import Move
from cutwise.maths.linearc import FloatArray, LineArc, arcs, lines
from cutwise.paths.blends import blended, feed_tolerances
from cutwise.spec.faults import Fault, ScenarioFault, dotted
from cutwise.spec.program import Blend


class ProgramPath(NamedTuple):
    """The path of a program or corner, block by block."""

    curve: LineArc
    feed: FloatArray  # programmed speed [m/s], infinite for rapid moves, shape (n,)
    cuts: npt.NDArray[np.bool_]  # whether the block cuts, shape (n,)
    stop_at: npt.NDArray[np.bool_]  # inner joints with a stop (G61.1), shape (n - 1,)
    dwell_after: FloatArray  # [s] at the end of each block, shape (n,)
    source: npt.NDArray[np.int64]  # line of the program, 0 for a corner, shape (n,)
    programmed: LineArc  # the path before its corners were blended: what the contour error is measured from
    origin: npt.NDArray[np.int64]  # block of the programmed path that each block came from, shape (n,)
    rotary: FloatArray  # A, B, C at its start and end [rad], shape (n, 2, 3)
    still: tuple[int, ...]  # lines of moves that would cut if the spindle turned
    cut_short: int  # blends that are smaller than their tolerance allows, because the blocks are short
    kept_feed: tuple[float, int]  # largest tolerance that G64 without P was given [m], and the line; 0 where it is not

    @property
    def blended(self) -> bool:
        """Whether a corner was blended, so that the path driven is not the programmed one."""
        return self.curve is not self.programmed


class PathModes(NamedTuple):
    """How each block ends, ``n`` of them."""

    stops: npt.NDArray[np.bool_]  # in any case (G61.1)
    tolerance: FloatArray  # of a blend [m]; 0: none, infinite: as the feed asks for
    shape: str = "arc"  # of the blends


class Pace(NamedTuple):
    """What bounds the speed through a corner whose tolerance is not given."""

    speed: float  # [m/s]
    acceleration: float  # [m/s^2]
    jerk: float  # [m/s^3]


def moves_path(
    program: Interpreted, *, feed: float | None, turning: bool, mode: str | Blend | None, top: float,
    rotary: bool = False, pace: Pace | None = None,
) -> ProgramPath:  # fmt: skip
    """The path of a program; moves of rotary axes alone are left out.

    Parameters
    ----------
    program : Interpreted
        Its moves.
    feed : float or None
        Speed [m/s] that replaces those of the program.
    turning : bool
        The spindle is taken to turn although the program does not say so.
    mode : str, Blend or None
        Path mode that replaces those of the program (G61, G61.1, G64 P).
    top : float
        Top of the material [m]: feed moves below it cut, if they are no plunges.
    rotary : bool
        Whether rotary axes may move; then plunges are not told from other moves.
    pace : Pace, optional
        What the machine may do, for corners whose tolerance is not given (G64 without P); left out: such corners stay.

    Raises
    ------
    ScenarioFault
        The spindle turns to the left, or a rotary axis moves that may not.
    """
    _check_covered(program, rotary)
    moves, dwell = [], []
    for move in program.moves:
        if move.kind == "dwell" and moves:
            dwell[-1] += move.dwell
        elif move.kind == "arc" or (move.kind != "dwell" and move.start != move.end):
            moves.append(move)
            dwell.append(0.0)
    curve = _curve(moves)
    within = _within(moves, curve, top, rotary)
    turns = np.array([turning or move.spindle > 0.0 for move in moves], dtype=bool)
    given = PathModes(
        np.array([move.mode == "exact_stop" for move in moves]),
        np.array([move.tolerance if move.mode == "blend" else 0.0 for move in moves]),
    )
    if mode is not None:
        given = _all_alike(mode, len(moves))
    changes = np.array([a.tool != b.tool for a, b in pairwise(moves)], dtype=bool)
    given.stops[:-1] |= changes  # the tool is changed at rest
    probes = np.array([move.kind == "probe" for move in moves], dtype=bool)
    given.tolerance[probes] = 0.0
    path = blocks_path(
        curve,
        np.array([move.feed if math.isinf(move.feed) or feed is None else feed for move in moves]),
        within & turns,
        given,
        dwell=np.array(dwell),
        source=np.array([move.line for move in moves]),
        pace=pace,
    )
    still = tuple(sorted({int(line) for line in np.array([move.line for move in moves])[within & ~turns]}))
    if rotary:
        ends = np.array([(move.rotary_start, move.rotary_end) for move in moves])
        path = path._replace(rotary=ends[path.origin])
    return path._replace(still=still)


def _check_covered(program: Interpreted, rotary: bool) -> None:
    """Cuts are those of a spindle that turns to the right, and of x, y and z unless rotary axes may move."""
    faults = []
    left = next((move for move in program.moves if move.spindle < 0.0), None)
    if left is not None:
        faults.append(f"line {left.line}: the spindle turns to the left (M4); milling is covered for M3 only")
    turned = next((move for move in program.moves if move.rotary_start != move.rotary_end), None)
    if turned is not None and not rotary:
        faults.append(f"line {turned.line}: a rotary axis moves; milling is covered for x, y and z only")
    if faults:
        raise ScenarioFault([Fault(("program",), message) for message in faults])


def blocks_path(
    curve: LineArc, feed: FloatArray, cuts: npt.NDArray[np.bool_], modes: PathModes | str | Blend, *,
    dwell: FloatArray | None = None, source: npt.NDArray[np.int64] | None = None, pace: Pace | None = None,
) -> ProgramPath:  # fmt: skip
    """The path of blocks, its corners blended where the path mode asks for it."""
    count = curve.count
    given = modes if isinstance(modes, PathModes) else _all_alike(modes, count)
    pause = np.zeros(count) if dwell is None else dwell
    lines = np.zeros(count, np.int64) if source is None else source
    allowed = np.where(given.stops[:-1] | (pause[:-1] > 0.0), 0.0, given.tolerance[:-1])
    asked = np.isinf(allowed)
    kept = (0.0, 0)
    if pace is None:
        allowed[asked] = 0.0
    elif asked.any():
        allowed = feed_tolerances(curve, allowed, np.minimum(feed, pace.speed), pace.acceleration, pace.jerk)
    parted = (feed[:-1] != feed[1:]) | (cuts[:-1] != cuts[1:])
    path, index, cut_short, rounded = blended(curve, allowed, given.shape, parted)
    if (asked & rounded).any():
        worst = int(np.argmax(np.where(asked & rounded, allowed, 0.0)))
        kept = float(allowed[worst]), int(lines[worst])
        cut_short = 0 if asked[rounded].all() else cut_short
    last_of_origin = np.append(index[1:] != index[:-1], True)
    last_of_origin[:-1][np.append(rounded, False)[index[:-1]]] = False
    stop = given.stops[index[:-1]] & last_of_origin[:-1]
    rest = np.where(last_of_origin, pause[index], 0.0)
    stop |= rest[:-1] > 0.0
    return ProgramPath(
        path, feed[index], cuts[index], stop, rest, lines[index], curve, index, np.zeros((len(index), 2, 3)), (),
        cut_short, kept,
    )  # fmt: skip


def program_speed(program: Interpreted, key: tuple[str, ...]) -> float:
    """The one spindle speed of a program's cuts [rad/s].

    Raises
    ------
    ScenarioFault
        There is none, or more than one; the fault names the ``key`` to write instead.
    """
    speeds = {abs(move.spindle) for move in program.moves if move.kind in ("feed", "arc") and move.spindle}
    if len(speeds) != 1:
        found = "no spindle speed (S with M3)" if not speeds else f"{len(speeds)} spindle speeds"
        raise ScenarioFault([Fault(key, f"the program has {found}; write {dotted(key)}")])
    return speeds.pop()


def _all_alike(mode: str | Blend, count: int) -> PathModes:
    shape = mode.shape if isinstance(mode, Blend) else "arc"
    tolerance = mode.blend if isinstance(mode, Blend) else 0.0
    return PathModes(np.full(count, mode == "exact_stop"), np.full(count, tolerance), shape)


def _curve(moves: list[Move]) -> LineArc:
    """Lines, arcs and helices of the moves."""
    start, end = (np.array([getattr(move, key) for move in moves]).reshape(-1, 3) for key in ("start", "end"))
    bent = np.array([move.kind == "arc" for move in moves], dtype=bool)
    which = np.flatnonzero(bent)
    if which.size == 0:
        return lines(start, end)
    round_ = [moves[i] for i in which]
    centre, axis = (np.array([getattr(move, key) for move in round_]) for key in ("centre", "axis"))
    rise = np.einsum("ij,ij->i", end[which] - start[which], axis)
    found = arcs(start[which], centre, np.array([move.sweep for move in round_]), axis, rise)
    end[which] = start[which] + 1.0  # any line will do: it is written over
    curve = lines(start, end)
    for column, values in zip(curve, found, strict=True):
        column[which] = values
    return curve


def _within(moves: list[Move], curve: LineArc, top: float, rotary: bool) -> npt.NDArray[np.bool_]:
    """Feed moves below the top of the material, and no plunges unless the tool may be tilted."""
    feeds = np.array([move.kind in ("feed", "arc") for move in moves], dtype=bool)
    height = np.array([min(move.start[2], move.end[2]) for move in moves])
    across = np.hypot(curve.along[:, 0], curve.along[:, 1]) * curve.length
    flat = ~curve.straight | (across > 1e-9)
    return np.asarray(feeds & (flat | rotary) & (height < top))
