"""A cell with the terms of its structure, at rest or stepped: the same for every process."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from cutwise import loop, units
from cutwise.balance import TRIALS
from cutwise.loop import Cell
from cutwise.maths.curves import FloatArray
from cutwise.physics.structure.terms import Pistons, Rigid, in_series, relaxed, width
from cutwise.process.carriage import Terms
from cutwise.records import UNSOLVED, History
from cutwise.results import Finding, Place, SolverFailure
from cutwise.still import Rest, rest

_STOP = 1e-9  # share of a stroke
_DRIFT = 5e-6  # [m] by which what is judged may still move


def structure_of(terms: Terms) -> Any:
    """The terms in series, the first at the tool; a rigid one without any."""
    return in_series([term for _, term in terms] or [Rigid(0.0)])


def too_soft(where: str, remedy: str, what: str = "what carries the mill") -> SolverFailure:
    """That a structure gives way to a cut without end: where, and what helps."""
    return SolverFailure(
        f"no equilibrium of force and displacement was found {where}: {what} is too soft for this cut; {remedy}"
    )


def on_path(place: float, of: str = "path") -> str:
    """A place [m] of a path in words."""
    return f"at {units.show(float(place), 'length', 4)} of the {of}"


def at_rest(
    cell: Cell, poses: FloatArray, soft: Callable[[int], SolverFailure] | None = None, **sizes: int
) -> Rest:  # fmt: skip
    """A cell at rest at each pose; ``sizes`` as those of :func:`cutwise.still.rest`, the structure's left out.

    Raises
    ------
    SolverFailure
        What ``soft`` makes of the first pose at which force and displacement do not meet; without it they may.
    """
    found = rest(cell, relaxed(cell.structure), poses, state=width(cell.structure), **sizes)
    if soft is not None and not found.found.all():
        raise soft(int(np.argmin(found.found)))
    return found


def wrenches(total: FloatArray) -> FloatArray:
    """Force and moment about the tip of tools whose structure turns about it [N, N m], from rows of a load; shape (n, 6)."""
    return np.column_stack([total[:, :3], total[:, 5], -total[:, 4], np.zeros(len(total))])


def stepped(cell: Cell, soft: Callable[[FloatArray], SolverFailure] | None = None, **how: Any) -> History:
    """A run from rest; ``how`` as in :func:`cutwise.loop.march`, the state of the structure left out.

    Raises
    ------
    SolverFailure
        What ``soft`` makes of the last row of the table (time, place, ...) with finite numbers; without it others may be.
    """
    history = loop.march(cell, relaxed(cell.structure), state=width(cell.structure), **how)
    finite = np.isfinite(history.table).all(axis=1)
    if soft is not None and not finite.all():
        raise soft(history.table[max(0, int(np.argmin(finite)) - 1)])
    return history


def unsolved(history: History, terms: Terms) -> npt.NDArray[np.int64]:
    """Rows with a step whose displacement, or the forces of whose pistons, were not found."""
    pistons = any(isinstance(term, Pistons) for _, term in terms)
    return np.flatnonzero(history.effort >= (UNSOLVED if pistons else TRIALS))


def at_stop(time: FloatArray, travel: FloatArray, stroke: float) -> Iterator[Finding]:
    """A piston, the farthest of them ``travel`` [m] over time [s], that has used its whole stroke [m]."""
    stopped = np.flatnonzero(travel >= stroke * (1.0 - _STOP))
    if stopped.size:
        yield Finding("at_stop", Place(time=float(time[stopped[0]])), float(travel.max()), stroke, "length")


def drifting(since: float, off: FloatArray) -> Iterator[Finding]:
    """What is judged since a time [s], and between the first and the last third of it still moves: a displacement [m]."""
    third = max(1, len(off) // 3)
    drift = float(off[-third:].mean() - off[:third].mean()) if len(off) else 0.0
    if abs(drift) > _DRIFT:
        yield Finding("unsettled", Place(time=since), drift, _DRIFT, "small_length")
