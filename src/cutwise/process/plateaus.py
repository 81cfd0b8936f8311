"""Quasi-static equilibria of a compliant edge: where loading, unloading and frictionless sliding would settle."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import FloatArray, Polyline, constant, no_cubic
from cutwise.physics.cutting.wall import AVERAGED
from cutwise.physics.structure.pistons import PistonRing
from cutwise.physics.structure.statics import Borders, borders, gauge, mean_support
from cutwise.process.loops import EdgeCell, cell_of, loads_at

if TYPE_CHECKING:
    from scipy import optimize
else:
    optimize = later("scipy.optimize")


class Equilibrium(NamedTuple):
    """A tool at rest against its pistons."""

    error: float  # [m] of the edge
    tilt: FloatArray  # [rad], shape (2,)


class Band(NamedTuple):
    """The edge errors between which friction can hold the tool; None where a branch has no equilibrium."""

    loaded: Equilibrium | None
    unloaded: Equilibrium | None
    frictionless: Equilibrium | None


def _ring(cell: EdgeCell) -> PistonRing:
    """The pistons of a compliant spindle."""
    assert cell.ring is not None
    return cell.ring


def band(cell: EdgeCell, burr_height: float, burr_width: float) -> Band:
    """All three equilibria for one burr."""
    piston = _ring(cell).piston
    friction = 0.0 if piston.law == 0 else piston.friction_dynamic
    force = piston.pressure_force
    of = borders(_ring(cell))
    return Band(
        *(equilibrium(cell, f, burr_height, burr_width, of) for f in (force + friction, force - friction, force))
    )


def equilibrium(
    cell: EdgeCell, piston_force: float, burr_height: float, burr_width: float, of: Borders
) -> Equilibrium | None:
    r"""Where the moment of the tooth-averaged cutting force meets the border of what the pistons hold.

    The height of the tool solves :math:`g(M(h)) = 1` (:func:`~cutwise.physics.structure.statics.gauge`) between the
    undeflected height and the top of the burr. None if the pistons have no force left, if the tool is carried to a
    stop, or if the force does not push it off the work at all.
    """
    if piston_force <= 0.0 or (cell.arc is not None and not cell.arc.follow):
        return None  # a tool that keeps its attitude on an arc is nowhere at rest
    low = -cell.path.preset
    arm = cell.reach - cell.layers.strips.burr_start - 0.5 * burr_width
    moment = _moments(cell, constant(burr_height), burr_width, arm)

    def excess(height: float) -> tuple[float, FloatArray]:
        used, normal = gauge(_ring(cell), piston_force, moment(height), of)
        return used - 1.0, normal

    start, _ = excess(low)
    if start <= 0.0 or low >= burr_height:
        return Equilibrium(min(low, burr_height), np.zeros(2))
    if excess(burr_height)[0] >= 0.0:
        return None
    height = float(optimize.brentq(lambda h: excess(h)[0], low, burr_height, xtol=1e-12))
    normal = excess(height)[1]
    rise = (height - low) / arm
    if normal[1] <= 1e-9:
        return None
    tilt = rise * normal / normal[1]
    if _ring(cell).arm * float((_ring(cell).direction @ tilt).max()) > _ring(cell).piston.stroke:
        return None
    return Equilibrium(min(height, burr_height), tilt)


def plateau_moment(cell: EdgeCell) -> float:
    r"""Moment about the joint at which the pistons give way on loading, mean over directions [N m].

    .. math:: M = l_p \frac{n}{\pi} (F_p + F_d)
    """
    piston = _ring(cell).piston
    friction = 0.0 if piston.law == 0 else piston.friction_dynamic
    return float(_ring(cell).arm * mean_support(_ring(cell).direction) * (piston.pressure_force + friction))


def feed_for(
    cell: EdgeCell, burr_height: float, burr_width: float, error: float, feeds: tuple[float, float]
) -> float:  # fmt: skip
    r"""Feed at which the mean cutting force holds the loading plateau with the bottom of the mill at a height [m/s].

    .. math:: |L_A F_b(v) + L_B F_w(v)| = l_p \frac{n}{\pi} (F_p + F_d)

    with the tooth-mean forces of burr and work of a mill that goes straight along the edge. They rise with the feed, so
    that there is one root.

    Parameters
    ----------
    cell : EdgeCell
        The pass.
    burr_height, burr_width : float
        [m]
    error : float
        Height of the lowest point of the mill above the nominal edge [m]: below zero it cuts into the work.
    feeds : tuple
        Lowest and highest feed [m/s]; the nearer end where no feed between them does.

    References
    ----------
    Derived here from Berselli et al. 2016, Eqs. (10) and (11), corrected.
    """
    held = plateau_moment(cell)
    arm = cell.reach - cell.layers.strips.burr_start - 0.5 * burr_width

    def excess(feed: float) -> float:
        at_feed = cell._replace(path=cell.path._replace(feed=feed))
        return float(np.linalg.norm(_moments(at_feed, constant(burr_height), burr_width, arm)(error))) - held

    low, high = feeds
    if excess(low) >= 0.0:
        return low
    if excess(high) <= 0.0:
        return high
    return float(optimize.brentq(excess, low, high, xtol=1e-9))


def _moments(cell: EdgeCell, profile: Polyline, burr_width: float, arm: float) -> Callable[[float], FloatArray]:
    """Moment of cutting and weight on the motor when the tool stands at a height and moves along at the feed."""
    still = cell.path._replace(lead_in=0.0, lead_out=0.0, error_amplitude=0.0, error_curve=no_cubic())
    layers = cell.layers._replace(burr_height=profile, burr_width=constant(burr_width))
    alone = cell._replace(path=still, layers=layers, cutter=cell.cutter._replace(force_law=AVERAGED), behind=(),
                         paced=None)  # fmt: skip
    record, start = cell_of(alone), np.zeros(1)
    weight = np.array([_ring(cell).moment_x, _ring(cell).moment_y])

    def moment(height: float) -> FloatArray:
        tilt = np.array([[0.0, (height + cell.path.preset) / arm, 0.0, 0.0]])
        return loads_at(record, start, tilt, layers.strips.slices)[0][6:] + weight

    return moment
