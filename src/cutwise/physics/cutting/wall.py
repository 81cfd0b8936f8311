"""Climb milling along a wall whose direction turns: the flute kernel in the frame of the machine.

The mill turns clockwise and has the wall to the right of its heading. What it meets is given as contact patches: an arc,
in angles from the wall side (heading - 90°), over a range of heights above the tip.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.delayed import delayed_disc_forces
from cutwise.physics.cutting.discs import Discs, disc_forces
from cutwise.physics.cutting.flute import FluteForce, Mill, mean_force, tooth_force
from cutwise.physics.cutting.uneven import Edges, even_and_linear, turning_mean_force
from cutwise.stages import cut

FloatArray = npt.NDArray[np.float64]

AVERAGED, FLUTES, DISCS, DELAYED = 1, 2, 3, 4


class WallFlutes(NamedTuple):
    """A turning mill that meets patches, by the chip of a steady feed."""

    law: int  # AVERAGED, FLUTES or DISCS
    mill: Mill
    discs: Discs
    edges: Edges
    spindle: float  # [rad/s]
    half: float  # [s] half a step of the loop: the teeth stand as in its middle


@compiled
def _to_machine(force: FluteForce, heading: float) -> tuple[float, float, float]:
    """A force of the flute kernel (x along the heading) in machine axes; a right-hand helix pulls down."""
    c, s = math.cos(heading), math.sin(heading)
    return force.x * c - force.y * s, force.x * s + force.y * c, -force.z


@compiled
def wall_force(
    law: int, angle: float, heading: float, low: float, high: float, z_lo: float, z_hi: float, feed_x: float,
    feed_y: float, mill: Mill, discs: Discs, edges: Edges,
) -> tuple[float, float, float]:  # fmt: skip
    r"""Force on the mill from one contact patch, with the chip of a steady feed.

    The arc :math:`[a_1, a_2]` from the wall side is the arc :math:`[\pi - a_2, \pi - a_1]` of the flute kernel, whose
    frame is turned by the heading; where the tool does not move along the heading, the chip follows its true direction
    and is cut where it is positive.

    Parameters
    ----------
    law : int
        ``AVERAGED`` over a revolution (run-out left out), or tooth by tooth with ``FLUTES`` (closed form) or ``DISCS``
        (midpoint rule), both for linear edges without run-out. ``DELAYED`` is :func:`delayed_disc_forces`.
    angle : float
        Angle of flute 0 at the tip in machine axes [rad], falling with time.
    heading : float
        Direction of the commanded path [rad].
    low, high : float
        Arc of the patch from the wall side [rad]; a wall cut alone runs from 0 to the immersion angle :math:`\alpha`.
    z_lo, z_hi : float
        Heights of the patch above the tip [m].
    feed_x, feed_y : float
        Displacement of the tool centre per tooth [m].
    mill, discs, edges
        The mill, its discs (``DISCS`` only), and the force law of its edges.

    Returns
    -------
    tuple
        Force on the tool x, y, z in machine axes [N].

    Notes
    -----
    Valid for :math:`0 \le a_1 \le a_2 \le \pi` and feeds per tooth small against the mill radius.

    Examples
    --------
    The mean over a slot along x, 1 mm deep with two flutes: :math:`N c b / 4` of :math:`-K_{rc}` and :math:`K_{tc}`.

    >>> from cutwise.physics.cutting.discs import discs
    >>> from cutwise.physics.cutting.uneven import EdgeCoefficients, even_edges
    >>> mill, parts = Mill(5e-3, 2, 0.0), discs(5e-3, 0.0, 1e-3, 2, 1)
    >>> edges = even_edges(EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0))
    >>> force = wall_force(AVERAGED, 0.0, 0.0, 0.0, math.pi, 0.0, 1e-3, 1e-4, 0.0, mill, parts, edges)
    >>> [round(f, 4) for f in force]
    [-25.0, 50.0, -12.7324]

    References
    ----------
    Berselli et al. 2016, Eqs. (2)-(7), (9) and (10), corrected, in machine axes.
    """
    if law == DISCS:
        lowest, highest = disc_range(z_lo, z_hi, discs)
        wall = heading - 0.5 * math.pi + low
        return disc_forces(angle, wall, high - low, feed_x, feed_y, lowest, highest, discs, edges.linear)
    chip = math.hypot(feed_x, feed_y)
    theta = (heading - math.atan2(feed_y, feed_x) + math.pi) % (2.0 * math.pi) - math.pi
    lo, hi = max(math.pi - high, theta), min(math.pi - low, theta + math.pi)
    if law == AVERAGED:
        if even_and_linear(edges):
            return _to_machine(mean_force(lo, hi, chip, theta, z_hi - z_lo, mill.flutes, edges.linear), heading)
        return _to_machine(turning_mean_force(0.0, lo, hi, chip, theta, z_hi - z_lo, mill, edges), heading)
    rotation = 0.5 * math.pi + heading - angle
    return _to_machine(tooth_force(rotation, lo, hi, chip, theta, z_lo, z_hi, mill, edges.linear), heading)


@cut.of(WallFlutes)
def _(cutting, contact, count, time, pivot, load):
    """In the axes of the machine: rows are arc, heights, displacement per tooth and heading of each patch."""
    rows = contact.rows
    angle = -cutting.spindle * (time + cutting.half)
    for p in range(count):
        fx, fy, fz = wall_force(
            cutting.law, angle, rows[p, 7], rows[p, 3], rows[p, 4], rows[p, 1], rows[p, 2], rows[p, 5], rows[p, 6],
            cutting.mill, cutting.discs, cutting.edges,
        )  # fmt: skip
        load.total[0] += fx
        load.total[1] += fy
        load.total[2] += fz


@compiled
def place_loads(patches: FloatArray, chip: FloatArray, mill: Mill, discs: Discs, edges: Edges) -> FloatArray:
    """Mean force in the plane of a steady cut at each place with its own feed, run-out left out [N], shape (n,).

    Parameters
    ----------
    patches : array (n, p, 4)
        Those of :func:`wall_force`: arc from, to [rad], heights from, to [m].
    chip : array (n,)
        Feed per tooth [m]; nothing is cut without it.
    mill, discs, edges
        As there.

    Notes
    -----
    Valid as :func:`wall_force` with ``AVERAGED``. Equal neighbours are computed once.

    Examples
    --------
    The slot of :func:`wall_force`, 25 N along and 50 N across, and the same at rest:

    >>> from cutwise.physics.cutting.discs import discs
    >>> from cutwise.physics.cutting.uneven import EdgeCoefficients, even_edges
    >>> mill, parts = Mill(5e-3, 2, 0.0), discs(5e-3, 0.0, 1e-3, 2, 1)
    >>> edges = even_edges(EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0))
    >>> slot = np.array([[[0.0, math.pi, 0.0, 1e-3]]] * 2)
    >>> place_loads(slot, np.array([1e-4, 0.0]), mill, parts, edges).round(4).tolist()
    [55.9017, 0.0]

    References
    ----------
    As :func:`wall_force`.
    """
    loads = np.zeros(chip.shape[0])
    for k in range(chip.shape[0]):
        if k > 0 and chip[k] == chip[k - 1] and np.abs(patches[k] - patches[k - 1]).max() < 1e-12:
            loads[k] = loads[k - 1]
            continue
        x, y = 0.0, 0.0
        for p in range(patches.shape[1]):
            low, high, z_lo, z_hi = patches[k, p]
            if high > low and chip[k] > 0.0:
                fx, fy, _ = wall_force(AVERAGED, 0.0, 0.0, low, high, z_lo, z_hi, chip[k], 0.0, mill, discs, edges)
                x, y = x + fx, y + fy
        loads[k] = math.hypot(x, y)
    return loads


@compiled
def place_torques(patches: FloatArray, chip: FloatArray, mill: Mill, edges: Edges) -> FloatArray:
    r"""Mean torque on the spindle of a steady cut at each place with its own feed [N m], shape (n,).

    .. math:: M = R \sum_p \bar F_t, \qquad
              \bar F_t = \frac{N b}{2\pi} \left[K_{tc} f (\cos a_1 - \cos a_2) + K_{te} (a_2 - a_1)\right]
              \text{ of linear edges}

    Parameters
    ----------
    patches : array (n, p, 4)
        Those of :func:`wall_force`: arc :math:`a_1, a_2` [rad], heights from, to [m].
    chip : array (n,)
        Feed per tooth f [m]; nothing is cut without it.
    mill, edges
        R, N, and the force law of the edges.

    Notes
    -----
    Valid as :func:`wall_force` with ``AVERAGED``; run-out as it stands in ``edges``. Equal neighbours are computed once.

    Examples
    --------
    A slot of R = 5 mm, 1 mm deep, two flutes of 1 kN/mm^2 alone: :math:`N b K_{tc} f R / \pi`, and the same at rest.

    >>> from cutwise.physics.cutting.uneven import EdgeCoefficients, even_edges
    >>> edges = even_edges(EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0))
    >>> slot = np.array([[[0.0, math.pi, 0.0, 1e-3]]] * 2)
    >>> place_torques(slot, np.array([1e-4, 0.0]), Mill(5e-3, 2, 0.0), edges).round(6).tolist()
    [0.31831, 0.0]

    References
    ----------
    Altintas 2012, Manufacturing Automation, sec. 2.6.
    """
    torques = np.zeros(chip.shape[0])
    for k in range(chip.shape[0]):
        if k > 0 and chip[k] == chip[k - 1] and np.abs(patches[k] - patches[k - 1]).max() < 1e-12:
            torques[k] = torques[k - 1]
            continue
        for p in range(patches.shape[1]):
            low, high, z_lo, z_hi = patches[k, p]
            if high > low and chip[k] > 0.0:
                lo, hi = math.pi - high, math.pi - low
                if even_and_linear(edges):
                    force = mean_force(lo, hi, chip[k], 0.0, z_hi - z_lo, mill.flutes, edges.linear)
                else:
                    force = turning_mean_force(0.0, lo, hi, chip[k], 0.0, z_hi - z_lo, mill, edges)
                torques[k] += mill.radius * force.tangential
    return torques


@compiled
def disc_range(z_lo: float, z_hi: float, discs: Discs) -> tuple[int, int]:
    r"""Discs whose middle lies between two heights above the tip [m]: the first, and the one after the last.

    .. math:: d \ge z / \Delta z - 1/2

    Parameters
    ----------
    z_lo, z_hi : float
        Heights [m]; beyond the mill there are no discs.
    discs : Discs
        Thickness :math:`\Delta z` [m] and number of the discs.

    Notes
    -----
    Valid to half a disc: a patch thinner than that may have none, or a whole one. A height within 1e-9 of a middle is one.

    Examples
    --------
    >>> from cutwise.physics.cutting.discs import discs
    >>> disc_range(2e-3, 5e-3, discs(5e-3, 0.0, 1e-2, 2, 10))  # middles at 2.5, 3.5 and 4.5 mm
    (2, 5)

    References
    ----------
    Derived here.
    """
    lowest = math.ceil(z_lo / discs.thickness - 0.5 - 1e-9)
    highest = math.ceil(z_hi / discs.thickness - 0.5 - 1e-9)
    return min(max(lowest, 0), discs.count), min(max(highest, 0), discs.count)


@compiled
def tooth_period(
    law: int, low: float, high: float, chip: float, depth: float, mill: Mill, discs: Discs, edges: Edges, positions: int
) -> FloatArray:
    """Forces over a revolution at a steady feed per tooth along +x; shape (positions x flutes, 3) [N].

    Without run-out every tooth period is alike, and one of them is given: shape (positions, 3).

    Parameters
    ----------
    law : int
        As for :func:`wall_force`, or ``DELAYED``, which knows run-out.
    low, high : float
        Arc from the wall side [rad], within 0 and pi.
    chip : float
        Feed per tooth [m].
    depth : float
        Axial depth from the tip up [m].
    mill, discs, edges
        The mill, its discs, and the force law of its edges.
    positions : int
        In a tooth period.

    Notes
    -----
    Valid for a feed per tooth that is small beside the radius: chips are feed times sine.

    Examples
    --------
    A straight flute across the feed, 1 mm deep, chip 0.1 mm:

    >>> from cutwise.physics.cutting.discs import discs
    >>> from cutwise.physics.cutting.uneven import EdgeCoefficients, even_edges
    >>> mill, parts = Mill(5e-3, 2, 0.0), discs(5e-3, 0.0, 1e-3, 2, 1)
    >>> edges = even_edges(EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0))
    >>> tooth_period(FLUTES, 0.0, math.pi, 1e-4, 1e-3, mill, parts, edges, 1).round(6).tolist()
    [[-50.0, 100.0, -20.0]]

    References
    ----------
    Berselli et al. 2016, Eqs. (2)-(7), corrected; run-out by :func:`delayed_disc_forces`.
    """
    turns = 1 if even_and_linear(edges) or edges.runout == 0.0 else mill.flutes
    out = np.empty((positions * turns, 3))
    moved = np.empty((2 * mill.flutes, 2))
    for i in range(positions * turns):
        angle = -2.0 * math.pi * i / (positions * mill.flutes)
        if law == DELAYED:
            lowest, highest = disc_range(0.0, depth, discs)
            for k in range(moved.shape[0]):
                moved[k, 0], moved[k, 1] = steady_step(k + 1, angle, chip, mill.flutes, edges)
            fx, fy, fz = delayed_disc_forces(
                angle, low - 0.5 * math.pi, high - low, lowest, highest, moved, discs, edges
            )
        else:
            fx, fy, fz = wall_force(law, angle, 0.0, low, high, 0.0, depth, chip, 0.0, mill, discs, edges)
        out[i, 0], out[i, 1], out[i, 2] = fx, fy, fz
    return out


@compiled
def steady_step(teeth: int, angle: float, chip: float, flutes: int, edges: Edges) -> tuple[float, float]:
    r"""How far the tool axis has come in a number of tooth periods of a steady feed along +x, run-out included [m].

    .. math:: r(t) - r(t - k\tau) = (k c, 0) + \rho(\psi) - \rho(\psi + 2\pi k / N)

    Parameters
    ----------
    teeth : int
        Tooth periods k.
    angle : float
        Angle of flute 0 in machine axes [rad], falling with time.
    chip : float
        Feed per tooth c [m].
    flutes : int
        Number of flutes N.
    edges : Edges
        Run-out :math:`\rho`, see :func:`runout_offset`.

    Notes
    -----
    Valid for a steady feed and spindle speed; exact then.

    Examples
    --------
    Run-out of 10 µm across the feed: two flutes differ by 20 µm there.

    >>> from cutwise.physics.cutting.uneven import NO_LINEAR, even_edges
    >>> step = steady_step(1, 0.5 * math.pi, 1e-4, 2, even_edges(NO_LINEAR)._replace(runout=1e-5))
    >>> [round(1e6 * v, 6) for v in step]
    [100.0, 20.0]

    References
    ----------
    Derived here.
    """
    x, y = runout_offset(angle, edges)
    x0, y0 = runout_offset(angle + 2.0 * math.pi * teeth / flutes, edges)
    return teeth * chip + x - x0, y - y0


@compiled
def runout_offset(angle: float, edges: Edges) -> tuple[float, float]:
    r"""Where the tool axis stands off the spindle axis, :math:`\rho(\cos\psi, \sin\psi)`, :math:`\psi` = angle - lambda [m].

    ``angle`` is that of flute 0 in machine axes [rad]; the direction of the run-out is ``runout_angle`` ahead of it in the
    sense of turning, clockwise. ``edges``: run-out :math:`\rho` [m] and its angle :math:`\lambda` [rad]. Valid for a
    parallel offset, the same at every height.

    Examples
    --------
    >>> from cutwise.physics.cutting.uneven import NO_LINEAR, even_edges
    >>> offset = runout_offset(math.pi / 3, even_edges(NO_LINEAR)._replace(runout=1e-5))
    >>> [round(1e6 * v, 6) for v in offset]
    [5.0, 8.660254]

    References
    ----------
    Derived here.
    """
    direction = angle - edges.runout_angle
    return edges.runout * math.cos(direction), edges.runout * math.sin(direction)
