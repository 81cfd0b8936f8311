"""From the moves of a program, or the blocks of a path, to the commanded path with its feeds, stops and blends."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.io.programs.block_text import block_named
from cutwise.io.programs.interpreter import Interpreted
from cutwise.io.programs.moves import Move
from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import Block, LineArc, arc, join, line
from cutwise.paths.pocket import blended
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

    @property
    def blended(self) -> bool:
        """Whether a corner was blended, so that the path driven is not the programmed one."""
        return self.curve.count != self.programmed.count


class PathModes(NamedTuple):
    """How each block ends."""

    mode: Sequence[str]  # exact_path, exact_stop or blend
    tolerance: Sequence[float]  # of a blend [m]
    shape: str = "arc"  # of the blends


def moves_path(
    program: Interpreted, *, feed: float | None, turning: bool, mode: str | Blend | None, top: float, rotary: bool = False
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
    within = np.array([_within(move, top, rotary) for move in moves], dtype=bool)
    turns = np.array([turning or move.spindle > 0.0 for move in moves], dtype=bool)
    given = PathModes([move.mode for move in moves], [move.tolerance for move in moves])
    path = blocks_path(
        [_block(move) for move in moves],
        np.array([move.feed if math.isinf(move.feed) or feed is None else feed for move in moves]),
        within & turns,
        given if mode is None else _all_alike(mode, len(moves)),
        dwell=np.array(dwell),
        source=np.array([move.line for move in moves]),
    )
    ends = np.array([(move.rotary_start, move.rotary_end) for move in moves])
    still = tuple(sorted({move.line for move, idle in zip(moves, within & ~turns, strict=True) if idle}))
    return path._replace(rotary=ends[path.origin], still=still)


def _check_covered(program: Interpreted, rotary: bool) -> None:
    """Cuts are those of a spindle that turns to the right, and of x, y and z unless rotary axes may move."""
    faults = []
    left = next((move for move in program.moves if move.spindle < 0.0), None)
    if left is not None:
        faults.append(
            f"{block_named(program.text, left.line)}: the spindle turns to the left (M4); milling is covered for M3 only"
        )
    turned = next((move for move in program.moves if move.rotary_start != move.rotary_end), None)
    if turned is not None and not rotary:
        faults.append(
            f"{block_named(program.text, turned.line)}: a rotary axis moves; milling is covered for x, y and z only"
        )
    if faults:
        raise ScenarioFault([Fault(("program",), message) for message in faults])


def blocks_path(
    blocks: list[Block], feed: FloatArray, cuts: npt.NDArray[np.bool_], modes: PathModes | str | Blend, *,
    dwell: FloatArray | None = None, source: npt.NDArray[np.int64] | None = None,
) -> ProgramPath:  # fmt: skip
    """The path of blocks, its corners blended where the path mode asks for it."""
    count = len(blocks)
    mode, tolerances, shape = modes if isinstance(modes, PathModes) else _all_alike(modes, count)
    pause = np.zeros(count) if dwell is None else dwell
    lines = np.zeros(count, np.int64) if source is None else source
    free = np.isfinite(feed[:-1]) & np.isfinite(feed[1:]) & (pause[:-1] == 0.0)
    allowed = [
        tolerance if name == "blend" and ok else 0.0
        for name, tolerance, ok in zip(mode[:-1], tolerances[:-1], free, strict=True)
    ]
    path, origin, cut_short = blended(blocks, allowed, shape)
    index = np.array(origin)
    last_of_origin = np.append(index[1:] != index[:-1], True)
    stop = np.array([mode[i] == "exact_stop" for i in origin[:-1]], dtype=bool) & last_of_origin[:-1]
    rest = np.where(last_of_origin, pause[index], 0.0)
    stop |= rest[:-1] > 0.0
    return ProgramPath(
        join(path), feed[index], cuts[index], stop, rest, lines[index], join(blocks), index,
        np.zeros((len(index), 2, 3)), (), cut_short,
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
    if isinstance(mode, Blend):
        return PathModes(["blend"] * count, [mode.blend] * count, mode.shape)
    return PathModes([mode] * count, [0.0] * count)


def _block(move: Move) -> Block:
    if move.kind == "arc":
        rise = sum((b - a) * c for a, b, c in zip(move.start, move.end, move.axis, strict=True))
        return arc(move.start, move.centre, move.sweep, move.axis, rise)
    return line(move.start, move.end)


def _within(move: Move, top: float, rotary: bool) -> bool:
    """A feed move below the top of the material, and not a plunge unless the tool may be tilted."""
    flat = move.kind == "arc" or math.hypot(move.end[0] - move.start[0], move.end[1] - move.start[1]) > 1e-9
    return move.kind in ("feed", "arc") and (flat or rotary) and min(move.start[2], move.end[2]) < top
