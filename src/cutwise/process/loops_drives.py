"""Feed drives along a path whose contact is known, with a rigid tool or one whose tip swings: cells of the one loop."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.loop import Cell, march
from cutwise.physics.cutting.discs import Discs
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.swinging import SwingingFlutes, Tip, tip_at_rest, tip_log
from cutwise.physics.cutting.uneven import Edges
from cutwise.physics.cutting.wall import AVERAGED, DELAYED, WallFlutes
from cutwise.physics.engagement.patches import SEEN, Patches
from cutwise.physics.motion.driven import SetPoints, driven_plane
from cutwise.physics.motion.drives import Drive, axes_of
from cutwise.physics.structure.modes import Modes, transition
from cutwise.physics.structure.terms import Rigid

FloatArray = npt.NDArray[np.float64]

NO_FORCE = 0  # the laws that cut are those of cutting/wall.py
STANDSTILL = 0.05e-3  # [m/s]
STEPS_PER_OSCILLATION = 60  # of the quickest mode, at ten substeps of the drives
STEPS_PER_TOOTH = 200  # of a rigid mill whose chips depend on earlier teeth, at ten substeps
_DELAYS_PER_TURN = 2  # how many turns back a tooth that jumped out of the cut may matter


class Cut(NamedTuple):
    """What cuts while the drives move."""

    law: int  # NO_FORCE, or AVERAGED, FLUTES, DISCS or DELAYED
    mill: Mill
    discs: Discs
    edges: Edges
    spindle: float  # [rad/s]
    standstill: float = STANDSTILL  # [m/s] slower feed cuts nothing


class DriveHistory(NamedTuple):
    """What the drives did, at the servo instants (positions before the step) and as peaks over the step's substeps."""

    position: FloatArray  # of the load [m], shape (n, axes)
    speed: FloatArray  # of the load side of the motor, r_g w [m/s], shape (n, axes)
    voltage: FloatArray  # held over the step [V], shape (n, axes)
    clipped: npt.NDArray[np.bool_]  # controller at its limit, shape (n, axes)
    force: FloatArray  # mean over the step, on the tool [N], shape (n, 3)
    force_peak: FloatArray  # largest magnitude in the step of x, y, z and of the xy vector [N], shape (n, 4)
    tip: FloatArray  # displacement of the tip by its modes: mean x, y, and largest length in the step [m], shape (n, 3)
    left: FloatArray  # least and greatest displacement into the wall on the right, on the left, NaN: none [m], shape (n, 4)
    known: int  # instants before the tip swung beyond its limit; everything is NaN from there on


def tip_dynamics(modes: Modes | None, cut: Cut, step: float, substeps: int, limit: float = math.inf) -> Tip:
    """Modes ready for a substep of ``step`` / ``substeps`` [s]; at ten substeps 60 micro steps per oscillation.

    A rigid mill whose teeth cut deeper than they are fed, as under run-out, has 200 of them per tooth instead.
    """
    if modes is not None:
        rate = float(modes.frequency.max()) / (2.0 * math.pi) * STEPS_PER_OSCILLATION
    else:
        rate = STEPS_PER_TOOTH * cut.spindle * cut.mill.flutes / (2.0 * math.pi) if cut.law == DELAYED else 0.0
    nominal = step / 10.0 * rate
    micro = max(1, math.ceil(nominal))
    dt = step / substeps / micro
    count = _DELAYS_PER_TURN * cut.mill.flutes
    period = 2.0 * math.pi / (cut.spindle * cut.mill.flutes) if cut.law != NO_FORCE else dt
    delay = np.arange(1.0, count + 1.0) * period / dt
    if modes is None:
        return Tip(np.zeros((0, 2, 3)), np.zeros((0, 2)), micro, delay, limit)
    exact = [transition(float(w), float(z), float(m), dt) for w, z, m, _ in zip(*modes, strict=True)]
    return Tip(np.array(exact), np.ascontiguousarray(modes.direction), micro, delay, limit)


def run_drives(
    order: SetPoints, patches: FloatArray, drives: tuple[Drive, ...], cut: Cut, substeps: int,
    progress: Callable[[float], None] | None = None, *, modes: Modes | None = None, tip_limit: float = math.inf,
) -> DriveHistory:  # fmt: skip
    """Feed drives following their commands under friction and cutting forces.

    Each servo step measures, computes the voltage and holds it; the plant is stepped exactly in ``substeps`` with
    force and friction held over each. The chip load follows from the actual velocity (with the law ``DELAYED`` from the
    true positions at earlier teeth, vibration and run-out included), the immersion from the commanded position. The
    drives start at rest on the first point, integrals and previous error zero.

    Parameters
    ----------
    order : SetPoints
        What the drives are told at the servo instants, ``n`` of them.
    patches : array (n, p, 4)
        What the tool meets over each servo step: arc from, to [rad], heights from, to [m].
    drives : tuple of Drive
        Those of x and y, and of z if it has one; all controllers have the same sample time.
    cut : Cut
        Cutting force law, or none.
    substeps : int
        Steps of the plant per servo step, at least 1.
    progress : callable, optional
        Called with the share done after each chunk.
    modes : Modes, optional
        Modes of the tool tip; they need the law ``DELAYED``.
    tip_limit : float
        Displacement of the tip at which the run ends [m]: the tool then is not where its arc of contact says.

    Raises
    ------
    ValueError
        Sample times differ, there are no substeps, or modes come with another law.
    """
    axes = axes_of(drives, substeps)
    if modes is not None and cut.law != DELAYED:
        raise ValueError("tool-tip modes need chips from the true positions: the law DELAYED")
    n, step = order.point.shape[0], axes[0].step
    motion = driven_plane(axes, order, substeps)
    pitch_time = 2.0 * math.pi / (cut.spindle * cut.mill.flutes) if cut.law != NO_FORCE else 0.0
    engagement = Patches(patches, order.heading, motion.clock, pitch_time, cut.law == AVERAGED, cut.standstill)
    flutes: WallFlutes | SwingingFlutes = WallFlutes(cut.law, cut.mill, cut.discs, cut.edges, cut.spindle, 0.5 * step)
    if cut.law == DELAYED:
        tip = tip_dynamics(modes, cut, axes[0].law.sample_time, substeps, tip_limit)
        memory, log = tip_at_rest(tip, order.point[0, :2]), tip_log(n)
        flutes = SwingingFlutes(cut.discs, cut.edges, cut.spindle, step, substeps, tip, memory, log)
    march(
        Cell(motion, engagement, (), flutes, Rigid(0.0)), (), duration=n * substeps * step, time_step=step, seen=SEEN,
        state=0, layers=0, contacts=patches.shape[1], starts=np.array([0, n * substeps]), progress=progress,
    )  # fmt: skip
    if not isinstance(flutes, SwingingFlutes):
        return DriveHistory(*motion.log, np.empty((0, 3)), np.empty((0, 4)), n)
    found = DriveHistory(*motion.log._replace(force_peak=flutes.log.peak), flutes.log.swing, flutes.log.wall, n)
    lost = np.flatnonzero(~(flutes.log.swing[:, 2] <= tip_limit))
    return _known_until(found, int(lost[0])) if lost.size else found


def _known_until(history: DriveHistory, known: int) -> DriveHistory:
    for values in history[:-1]:
        assert isinstance(values, np.ndarray)
        values[known:] = False if values.dtype == bool else math.nan
    return history._replace(known=known)
