"""From the moves of a program, or the blocks of a path, to the commanded path with its feeds, stops and blends."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.linearc import FloatArray, LineArc, arcs, lines
from cutwise.paths.blends import blended, feed_tolerances
from cutwise.programs.block_text import block_named
from cutwise.programs.interpreter import Interpreted
from cutwise.programs.move_table import CUTTING, KINDS, MODES, Moves
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
    tool: npt.NDArray[np.int64] = np.zeros(
        0, np.int64
    )  # in the spindle, 0: none was called; of a program only, shape (n,)
    spindle: FloatArray = np.zeros(0)  # [rad/s], positive clockwise, 0 stopped; of a program only, shape (n,)

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
        Speed [m/s] that replaces those of the program where it cuts; plunges and feed moves above the material keep
        theirs, which were chosen for other reasons.
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
    table = program.moves
    keep, dwell = kept_moves(table)
    curve = _curve(table, keep)
    cutting = np.isin(table.kinds[keep], CUTTING)
    within = cutting & _within(curve, table.ends[keep, 2], top, rotary)
    turns = turning | (table.spindles[keep] > 0.0)
    modes = table.modes[keep]
    given = PathModes(
        modes == MODES.index("exact_stop"), np.where(modes == MODES.index("blend"), table.tolerances[keep], 0.0)
    )
    if mode is not None:
        given = _all_alike(mode, len(keep))
    given.stops[:-1] |= np.diff(table.tools[keep]) != 0  # the tool is changed at rest
    given.tolerance[table.kinds[keep] == KINDS.index("probe")] = 0.0
    feeds = table.feeds[keep]
    path = blocks_path(
        curve,
        feeds if feed is None else np.where(within, feed, feeds),
        within & turns,
        given,
        dwell=dwell,
        source=table.lines[keep].astype(np.int64),
        pace=pace,
    )
    still = tuple(int(line) for line in np.unique(table.lines[keep[within & ~turns]]))
    if rotary:
        path = path._replace(rotary=table.rotary(keep)[path.origin])
    tools, speeds = table.tools[keep][path.origin].astype(np.int64), table.spindles[keep][path.origin]
    return path._replace(still=still, tool=tools, spindle=speeds)


def _check_covered(program: Interpreted, rotary: bool) -> None:
    """Cuts are those of a spindle that turns to the right, and of x, y and z unless rotary axes may move."""
    faults = []
    left = np.flatnonzero(program.moves.spindles < 0.0)
    if left.size:
        where = block_named(program.text, int(program.moves.lines[left[0]]))
        faults.append(f"{where}: the spindle turns to the left (M4); milling is covered for M3 only")
    turned = None if rotary else next((m for m in program.moves.turning() if m.rotary_start != m.rotary_end), None)
    if turned is not None:
        faults.append(
            f"{block_named(program.text, turned.line)}: a rotary axis moves; milling is covered for x, y and z only"
        )
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
    table = program.moves
    speeds = set(np.unique(np.abs(table.spindles[np.isin(table.kinds, CUTTING)])).tolist()) - {0.0}
    if len(speeds) != 1:
        found = "no spindle speed (S with M3)" if not speeds else f"{len(speeds)} spindle speeds"
        raise ScenarioFault([Fault(key, f"the program has {found}; write {dotted(key)}")])
    return speeds.pop()


def _all_alike(mode: str | Blend, count: int) -> PathModes:
    shape = mode.shape if isinstance(mode, Blend) else "arc"
    tolerance = mode.blend if isinstance(mode, Blend) else 0.0
    return PathModes(np.full(count, mode == "exact_stop"), np.full(count, tolerance), shape)


def kept_moves(table: Moves) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Which moves lead somewhere, and the time at rest behind each of them [s]."""
    pauses = table.kinds == KINDS.index("dwell")
    somewhere = (table.kinds == KINDS.index("arc")) | (table.starts != table.ends).any(axis=1)
    keep = np.flatnonzero(somewhere & ~pauses)
    dwell = np.zeros(len(keep))
    rests = np.flatnonzero(pauses)
    behind = np.searchsorted(keep, rests) - 1
    np.add.at(dwell, behind[behind >= 0], table.dwells[rests[behind >= 0]])
    return keep, dwell


def _curve(table: Moves, keep: npt.NDArray[np.intp]) -> LineArc:
    """Lines, arcs and helices of the moves."""
    start, end = table.starts[keep], table.ends[keep]
    number, centre, axis, sweep = table.arcs
    which = np.searchsorted(keep, number)
    if which.size == 0:
        return lines(start, end)
    rise = np.einsum("ij,ij->i", end[which] - start[which], axis)
    found = arcs(start[which], centre, sweep, axis, rise)
    end[which] = start[which] + 1.0  # any line will do: it is written over
    curve = lines(start, end)
    for column, values in zip(curve, found, strict=True):
        column[which] = values
    return curve


def _within(curve: LineArc, ends: FloatArray, top: float, rotary: bool) -> npt.NDArray[np.bool_]:
    """Blocks below the top of the material, and no plunges unless the tool may be tilted."""
    across = np.hypot(curve.along[:, 0], curve.along[:, 1]) * curve.length
    flat = ~curve.straight | (across > 1e-9)
    return np.asarray((flat | rotary) & (np.minimum(curve.start[:, 2], ends) < top))
