r"""How fast a flat mill in exact arcs may be fed: the limits of :mod:`cutwise.physics.cutting.affine_limits`, place by place.

A is what the edges do alone, B the shearing at unit feed, over the positions of a tooth period; walls have their error besides.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.affine_limits import VALUES, Bounds, Sums, flutes_of, limits_of, values_of
from cutwise.physics.cutting.discs import Discs
from cutwise.physics.cutting.flute import Mill, mean_force
from cutwise.physics.cutting.helix import helix_lag
from cutwise.physics.cutting.uneven import Edges
from cutwise.physics.cutting.wall import DISCS, FLUTES, wall_force

FloatArray = npt.NDArray[np.float64]

POSITIONS = 120  # of a tooth period
_PASSING = 1e-9  # [rad] beside the wall, so that the disc that passes it is out of the cut
_BESIDE = 1e-9  # [rad] within the end of an arc: where the force of a straight flute is largest before it jumps
_OFF_GRID = 0.381966  # of a step, by which straight flutes are looked at beside round angles, at which arcs may meet
_AT_WALL = 1e-7  # [rad] from the wall within which an arc begins at it


class Teeth(NamedTuple):
    """A mill and its material, taken apart into what is there without feed and what grows with it."""

    law: int  # FLUTES or DISCS of :mod:`cutwise.physics.cutting.wall`
    mill: Mill
    discs: Discs  # also the heights at which the wall is read
    shear: Edges  # without edge forces
    edge: Edges  # edge forces alone


@compiled
def largest_sine(low: float, high: float) -> float:
    """Largest sine over an arc within half a turn: of the thickest chip, over the feed per tooth.

    ``low``, ``high``: ends of the arc [rad], 0 to pi. Exact.

    Examples
    --------
    >>> [round(largest_sine(*ends), 9) for ends in ((0.0, math.pi / 6), (1.0, 2.0), (2.5, math.pi))]
    [0.5, 1.0, 0.598472144]

    References
    ----------
    Derived here.
    """
    if low <= 0.5 * math.pi <= high:
        return 1.0
    return max(math.sin(low), math.sin(high))


@compiled
def _unit_force(law: int, angle: float, patches: FloatArray, teeth: Teeth) -> tuple[float, float, float, float]:
    """A [N] and B [N/m] of all patches at an angle of flute 0, x along the feed, y to its left."""
    ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0
    mill, flutes = teeth.mill, teeth.mill.flutes
    lag = helix_lag(mill.helix, mill.radius)
    for p in range(patches.shape[0]):
        low, high, bottom, top = patches[p, 0], patches[p, 1], patches[p, 2], patches[p, 3]
        if high <= low:
            continue
        if law == FLUTES:  # the same as below with one look for the flutes in cut: half of the time
            one = flutes_of(
                0.5 * math.pi - angle,
                math.pi - high,
                math.pi - low,
                bottom,
                top,
                flutes,
                lag,
                teeth.edge.linear,
                teeth.shear.linear,
            )
            ax, ay, bx, by = ax + one[0], ay + one[1], bx + one[2], by + one[3]
            continue
        x, y, _ = wall_force(law, angle, 0.0, low, high, bottom, top, 1.0, 0.0, mill, teeth.discs, teeth.edge)
        ax, ay = ax + x, ay + y
        x, y, _ = wall_force(law, angle, 0.0, low, high, bottom, top, 1.0, 0.0, mill, teeth.discs, teeth.shear)
        bx, by = bx + x, by + y
    return ax, ay, bx, by


@compiled
def _loads(patches: FloatArray, teeth: Teeth, out: FloatArray) -> int:
    """Rows of A and B over a tooth period and how many they are; straight flutes also at both ends of every arc.

    The force of a straight flute jumps where an arc ends, so its largest value lies there, between two positions; and two
    arcs that meet would both count a flute exactly at their common end.
    """
    straight = teeth.mill.helix == 0.0
    off = _OFF_GRID if straight else 0.0
    for i in range(POSITIONS):
        angle = -2.0 * math.pi * (i + off) / (POSITIONS * teeth.mill.flutes)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = _unit_force(teeth.law, angle, patches, teeth)
    count = POSITIONS
    if straight and teeth.law == FLUTES:
        for p in range(patches.shape[0]):
            if patches[p, 1] - patches[p, 0] > 2.0 * _BESIDE:
                for at in (patches[p, 0] + _BESIDE, patches[p, 1] - _BESIDE):
                    angle = at - 0.5 * math.pi
                    out[count, 0], out[count, 1], out[count, 2], out[count, 3] = _unit_force(
                        teeth.law, angle, patches, teeth
                    )
                    count += 1
    return count


@compiled
def _sums(patches: FloatArray, teeth: Teeth) -> Sums:
    """Means over a tooth of what the edges do and of what grows with the feed, the thickest chip and the volume."""
    ax, ay, bx, by, at, bt, sine, area = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    radius = teeth.mill.radius
    for p in range(patches.shape[0]):
        low, high, width = patches[p, 0], patches[p, 1], patches[p, 3] - patches[p, 2]
        if high > low:
            edge = mean_force(math.pi - high, math.pi - low, 1.0, 0.0, width, teeth.mill.flutes, teeth.edge.linear)
            shear = mean_force(math.pi - high, math.pi - low, 1.0, 0.0, width, teeth.mill.flutes, teeth.shear.linear)
            ax, ay, at = ax + edge.x, ay + edge.y, at + edge.tangential
            bx, by, bt = bx + shear.x, by + shear.y, bt + shear.tangential
            sine = max(sine, largest_sine(low, high))
            area += (math.cos(low) - math.cos(high)) * width
    return Sums(ax, ay, bx, by, radius * at, radius * bt, sine, radius * area, 0.0, 0.0)


@compiled
def wall_terms(
    law: int, patches: FloatArray, left: bool, normal: float, compliance: FloatArray, teeth: Teeth, out: FloatArray
) -> int:
    r"""Error of a wall while the discs of a tooth pass it, :math:`\varepsilon_e = (N_A + f N_B)/k`, one row a disc.

    N is the force into the wall of all other discs in contact, k the stiffness along its normal (the tip moves by the
    static compliance C, :math:`n^T C F`).

    Parameters
    ----------
    law : int
        ``DISCS``: the other discs, one by one; ``FLUTES``: the rest of the edge in closed form, smooth in the ends of the arcs.
    patches : array (p, 4)
        Arcs from the right side of the feed [rad] and heights [m].
    left : bool
        The wall is on the left, at 180 degrees, not on the right.
    normal : float
        Direction into the wall in the axes of the compliance [rad].
    compliance : array (2, 2)
        Of the tip [m/N].
    teeth : Teeth
        Mill and material.
    out : array (discs, 2)
        Filled: :math:`N_A/k` [m] and :math:`N_B/k` [-].

    Returns
    -------
    int
        How many discs pass a wall there.

    Notes
    -----
    Valid at rest: the tip follows the force at once, and the tool stands where it is told.

    Examples
    --------
    Two discs of a helix, the tip at the wall, the other one half a right angle behind it: its edge force of 1 N/µm times
    5 mm pushes the tool off by the cosine of that.

    >>> from cutwise.physics.cutting.discs import discs
    >>> from cutwise.physics.cutting.flute import EdgeCoefficients
    >>> from cutwise.physics.cutting.uneven import NO_LINEAR, even_edges
    >>> mill = Mill(5e-3, 1, math.atan(0.25 * math.pi))
    >>> edge = even_edges(EdgeCoefficients(0.0, 0.0, 0.0, 1e3, 0.0, 0.0))
    >>> teeth = Teeth(3, mill, discs(mill.radius, mill.helix, 1e-2, 1, 2), even_edges(NO_LINEAR), edge)
    >>> slot, out = np.array([[0.0, math.pi, 0.0, 1e-2]]), np.zeros((2, 2))
    >>> wall_terms(DISCS, slot, False, -0.5 * math.pi, np.eye(2) / 1e6, teeth, out), (1e6 * out[:, 0]).round(4).tolist()
    (2, [-3.5355, 0.0])

    References
    ----------
    Derived here; surface left by a helical mill as in Altintas 2012, sec. 2.7.
    """
    count, discs = 0, teeth.discs
    side = 0.5 * math.pi if left else -0.5 * math.pi  # direction into the wall with the feed along x
    nx, ny = math.cos(normal), math.sin(normal)
    px, py = compliance[0, 0] * nx + compliance[0, 1] * ny, compliance[1, 0] * nx + compliance[1, 1] * ny
    c, s = math.cos(normal - side), math.sin(normal - side)  # direction of the feed
    for e in range(discs.count):
        height = (e + 0.5) * discs.thickness
        there = False
        for p in range(patches.shape[0]):
            if patches[p, 1] > patches[p, 0] and patches[p, 2] <= height <= patches[p, 3]:
                at_wall = patches[p, 1] > math.pi - _AT_WALL if left else patches[p, 0] < _AT_WALL
                there = there or at_wall
        if not there:
            continue
        # the angle falls with time: a disc leaves the cut at the right wall, and comes into it at the left one
        angle = side - (e + 0.5) * discs.step + (_PASSING if left else -_PASSING)
        ax, ay, bx, by = _unit_force(law, angle, patches, teeth)
        out[count, 0] = px * (c * ax - s * ay) + py * (s * ax + c * ay)
        out[count, 1] = px * (c * bx - s * by) + py * (s * bx + c * by)
        count += 1
    return count


@compiled
def _same(a: FloatArray, b: FloatArray) -> bool:
    for p in range(a.shape[0]):
        for k in range(4):
            if abs(a[p, k] - b[p, k]) > 1e-12:
                return False
    return True


@compiled
def _walls(
    patches: FloatArray, walls: FloatArray, heading: float, compliance: FloatArray, teeth: Teeth, terms: FloatArray
) -> int:
    """Rows of all walls that stay; ``walls``: 1 where that on the right, and on the left, does."""
    count = 0
    for k in range(2):
        if walls[k] > 0.0:
            normal = heading + (0.5 * math.pi if k == 1 else -0.5 * math.pi)
            count += wall_terms(DISCS, patches, k == 1, normal, compliance, teeth, terms[count:])
    return count


@compiled
def feed_intervals(
    patches: FloatArray, walls: FloatArray, heading: FloatArray, feed: FloatArray, spindle: FloatArray, teeth: Teeth,
    compliance: FloatArray, bounds: Bounds,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    r"""Highest and lowest feed per tooth of every limit, place by place, and what each comes to at the feed it has.

    Parameters
    ----------
    patches : array (n, p, 4)
        Contact arcs from, to, in angles from the right side of the feed [rad], and heights above the tip from, to [m].
    walls : array (n, 2)
        1 where a wall on the right, and on the left, stays as it is left.
    heading : array (n,)
        Direction of feed in the axes of the compliance [rad].
    feed : array (n,)
        Feed per tooth [m] at which values are wanted.
    spindle : array (n,)
        Spindle speed [rad/s].
    teeth : Teeth
        Mill and material.
    compliance : array (2, 2)
        Static compliance of the tip [m/N]; zero: rigid, walls have no error.
    bounds : Bounds
        What is allowed.

    Returns
    -------
    tuple
        Highest feeds (n, 7) [m], infinite where nothing limits; lowest feeds (n, 2) [m]; values (n, 9) in SI, those of a wall
        NaN where none stays.

    Notes
    -----
    Valid for linear edges without run-out. The peak is that of 120 positions of a tooth period, of straight
    flutes also of the ends of all arcs; exact otherwise. Equal
    neighbours are computed once.

    Examples
    --------
    A slot 1 mm deep by two straight flutes, tangential force alone: 1 GPa makes 100 N of 0.1 mm.

    >>> from cutwise.physics.cutting.affine_limits import PEAK
    >>> from cutwise.physics.cutting.discs import discs
    >>> from cutwise.physics.cutting.flute import EdgeCoefficients
    >>> from cutwise.physics.cutting.uneven import NO_LINEAR, even_edges
    >>> mill = Mill(5e-3, 2, 0.0)
    >>> teeth = Teeth(2, mill, discs(5e-3, 0.0, 1e-3, 2, 1), even_edges(EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0)),
    ...               even_edges(NO_LINEAR))
    >>> slot, one = np.array([[[0.0, math.pi, 0.0, 1e-3]]]), np.ones(1)
    >>> none = Bounds(100.0, math.inf, math.inf, math.inf, math.inf, 0.0, -math.inf, math.inf, math.inf)
    >>> high, low, value = feed_intervals(slot, np.zeros((1, 2)), 0 * one, 5e-5 * one, 100 * one, teeth, np.zeros((2, 2)), none)
    >>> round(1e3 * float(high[0, PEAK]), 4), round(float(value[0, PEAK]), 1)  # 120 places of a tooth: 5e-5 beside the top
    (0.1, 50.0)

    References
    ----------
    Derived here.
    """
    n = patches.shape[0]
    high, low, value = np.empty((n, 7)), np.empty((n, 2)), np.empty((n, VALUES))
    loads, terms = np.empty((POSITIONS + 2 * patches.shape[1], 4)), np.empty((2 * teeth.discs.count, 2))
    count, rows, flutes, sums = 0, 0, teeth.mill.flutes, _sums(patches[0:0, 0], teeth)
    for k in range(n):
        here, before = patches[k], patches[max(k - 1, 0)]
        turned = abs(heading[k] - heading[max(k - 1, 0)]) > 1e-12 and walls[k].max() > 0.0
        alike = k > 0 and not turned and walls[k, 0] == walls[k - 1, 0] and walls[k, 1] == walls[k - 1, 1]
        alike = alike and spindle[k] == spindle[k - 1] and _same(here, before)
        if not alike:
            rows = _loads(here, teeth, loads)
            count = _walls(here, walls[k], heading[k], compliance, teeth, terms)
            sums = _sums(here, teeth)
            limits_of(loads, rows, terms, count, sums, spindle[k], flutes, bounds, high[k], low[k])
        else:
            high[k], low[k] = high[k - 1], low[k - 1]
        if alike and feed[k] == feed[k - 1]:
            value[k] = value[k - 1]
        else:
            values_of(loads, rows, terms, count, sums, spindle[k], flutes, feed[k], value[k])
    return high, low, value
