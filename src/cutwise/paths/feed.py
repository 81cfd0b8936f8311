r"""Points, feeds and leads of a chamfer path."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import lengths
from cutwise.paths.chamfer.ball_path import ChamferPath

if TYPE_CHECKING:
    from scipy import interpolate
else:
    interpolate = later("scipy.interpolate")

_LONGEST = 1e-3  # [m] between points, however straight the path


Tolerance = float | FloatArray  # chord error [m], everywhere or at each sample of a path


class Feeds(NamedTuple):
    """Speeds along a path, one per segment."""

    centre: FloatArray  # [m/s] of the ball centre: what is programmed
    contact: FloatArray  # [m/s] of the middle of the chamfer borders
    time: float  # [s] along the edge, without leads


def contact_feeds(path: ChamferPath, feed: float, *, at_contact: bool) -> Feeds:
    r"""Feeds of the segments, with constant speed at the contact or at the ball centre.

    .. math:: F_i = f\, |\Delta S_i| / |\Delta Q_i|, \qquad Q = (Q_1 + Q_2) / 2

    Parameters
    ----------
    path : ChamferPath
        The path.
    feed : float
        Speed f [m/s] of the contact, or of the centre.
    at_contact : bool
        Whether f is the speed of the contact.

    Examples
    --------
    A hole of 20 mm in a wall that is almost flat: the centre runs round at 20 - 1/sqrt(2) mm, the contact at
    20 + 3/sqrt(2) mm.

    >>> from cutwise.paths.chamfer.ball_path import TANGENT, Chamfer, chamfer_path
    >>> from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge
    >>> edge = pipe_edge(PipeHole(1e3, 0.2, 20e-3), one_turn(400), inner=False)
    >>> path = chamfer_path(edge, Chamfer(6e-3, tier=TANGENT), 5e-3)
    >>> round(float(contact_feeds(path, 1.0, at_contact=True).centre[0]), 3)
    0.872

    References
    ----------
    Derived here.
    """
    closed = path.frames.closed
    centre = lengths(path.centre, closed=closed)
    contact = lengths(path.contact.mean(axis=1), closed=closed)
    if at_contact:
        return Feeds(feed * centre / contact, np.full(len(contact), feed), float(contact.sum() / feed))
    return Feeds(np.full(len(centre), feed), feed * contact / centre, float(centre.sum() / feed))


def chord_error(path: ChamferPath) -> float:
    r"""Largest distance between the centre curve and its polyline, :math:`\kappa_S \Delta s^2 / 8` [m].

    Valid for segments short against the radius of curvature. Derived here.

    Examples
    --------
    A circle of :math:`20 - 1/\sqrt{2}` mm in 100 chords: :math:`r \sin^2(\pi/n) / 2`.

    >>> from cutwise.paths.chamfer.ball_path import TANGENT, Chamfer, chamfer_path
    >>> from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge
    >>> edge = pipe_edge(PipeHole(1e3, 0.2, 20e-3), one_turn(100), inner=False)
    >>> round(1e6 * chord_error(chamfer_path(edge, Chamfer(6e-3, tier=TANGENT), 5e-3)), 2)
    9.52
    """
    curve, at = _centre_curve(path)
    middle = 0.5 * (at[1:] + at[:-1])
    kappa = _curvature(curve, middle)
    step = lengths(path.centre, closed=path.frames.closed)
    return float((kappa * step**2 / 8.0).max())


def chord_share(path: ChamferPath, tolerance: Tolerance) -> float:
    """Largest share of its tolerance that a chord error takes."""
    curve, at = _centre_curve(path)
    error = _curvature(curve, 0.5 * (at[1:] + at[:-1])) * lengths(path.centre, closed=path.frames.closed) ** 2 / 8.0
    return float((error / _between(_at(tolerance, path))).max())


def _at(tolerance: Tolerance, path: ChamferPath) -> FloatArray:
    """A tolerance at each sample of a path, once more at the first of a closed one."""
    every = np.broadcast_to(np.asarray(tolerance, float), (len(path.centre),))
    return np.append(every, every[0]) if path.frames.closed else every


def _between(tolerance: FloatArray) -> FloatArray:
    return np.asarray(np.minimum(tolerance[1:], tolerance[:-1]))


def points_for(path: ChamferPath, tolerance: float) -> int:
    """Number of evenly spaced parameters at which the chord error stays below a tolerance.

    The chord error falls with the square of the number; ``path`` must be fine enough to show the curve.

    Parameters
    ----------
    path : ChamferPath
        A fine path.
    tolerance : float
        Chord error [m].

    Examples
    --------
    The circle of :func:`chord_error` to a quarter of its error: twice the points.

    >>> from cutwise.paths.chamfer.ball_path import TANGENT, Chamfer, chamfer_path
    >>> from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge
    >>> edge = pipe_edge(PipeHole(1e3, 0.2, 20e-3), one_turn(100), inner=False)
    >>> points_for(chamfer_path(edge, Chamfer(6e-3, tier=TANGENT), 5e-3), 0.25 * 9.53e-6)
    200
    """
    return max(8, math.ceil(len(path.centre) * math.sqrt(chord_error(path) / tolerance)))


def coarseness(path: ChamferPath, tolerance: Tolerance) -> float:
    r"""Largest distance of samples over the distance :math:`\sqrt{8 \varepsilon / \kappa_S}` of the points wanted."""
    curve, at = _centre_curve(path)
    most = _between(_at(tolerance, path))
    kappa = np.maximum(_curvature(curve, 0.5 * (at[1:] + at[:-1])), 8.0 * most / _LONGEST**2)
    return float((lengths(path.centre, closed=path.frames.closed) * np.sqrt(kappa / (8.0 * most))).max())


def samples_for(path: ChamferPath, tolerance: Tolerance) -> NDArray[np.int64]:
    r"""Samples of a path to keep, at distances :math:`\Delta s \approx \sqrt{8 \varepsilon / \kappa_S}`, at most 1 mm.

    Never more than every other sample, so that there are samples between the kept ones to prove the path at.
    """
    curve, at = _centre_curve(path)
    most = _at(tolerance, path)
    kappa = np.maximum(_curvature(curve, at), 8.0 * most / _LONGEST**2)
    density = np.linalg.norm(curve(at, 1), axis=1) * np.sqrt(kappa / (8.0 * most))
    count = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(at))])
    closed = path.frames.closed
    wanted = max(8 if closed else 3, math.ceil(1.15 * count[-1]) + (0 if closed else 1))
    return thinned(len(path.centre), np.interp(np.linspace(0.0, count[-1], wanted + closed), count, np.arange(len(at))),
                   closed=closed)  # fmt: skip


def thinned(total: int, wanted: FloatArray, *, closed: bool) -> NDArray[np.int64]:
    """Sample numbers nearest to wanted places, no two of them neighbours; an open path keeps its ends.

    Examples
    --------
    >>> thinned(10, np.array([0.0, 1.2, 4.4, 9.0]), closed=False).tolist()
    [0, 4, 9]
    """
    last = total if closed else total - 1
    kept = [0]
    for place in np.rint(wanted[1:]).astype(int):
        if place - kept[-1] >= 2 and place <= last - 2:
            kept.append(int(place))
    return np.array(kept if closed else [*kept, last], np.int64)


def _centre_curve(path: ChamferPath) -> tuple[interpolate.CubicSpline, FloatArray]:
    at, centre, closed = path.frames.parameter, path.centre, path.frames.closed
    if closed:
        at = np.append(at, at[0] + path.frames.period)
        centre = np.vstack([centre, centre[:1]])
    return interpolate.CubicSpline(at, centre, bc_type="periodic" if closed else "not-a-knot"), at


def _curvature(curve: interpolate.CubicSpline, at: FloatArray) -> FloatArray:
    first, second = curve(at, 1), curve(at, 2)
    return np.linalg.norm(np.cross(first, second), axis=1) / np.linalg.norm(first, axis=1) ** 3


class Leads(NamedTuple):
    """Ways into and out of a path [m]; the first and the last point stand clear of the part, on the hole axis."""

    entry: FloatArray  # down to the start of the path, shape (m, 3)
    overlap: FloatArray  # repeated points after a full turn, shape (k, 3)
    exit: FloatArray  # back up, shape (m, 3)


def leads(path: ChamferPath, axis: FloatArray, foot: FloatArray, retract: float, *, overlap: float = 1e-3) -> Leads:
    """Lead-in and lead-out of a closed path inside a hole.

    Down the hole axis to the height of the start point, a half circle from the axis onto the path, tangential to it;
    after the turn an overlap, then the mirror image back to the axis and out.

    Parameters
    ----------
    path : ChamferPath
        Closed path.
    axis, foot : array
        Unit vector out of the hole, and a point of the hole axis [m], shape (3,).
    retract : float
        Height above the highest path point at which the tool is clear [m].
    overlap : float
        Length of the path that is run twice [m].
    """
    run = np.concatenate([[0.0], np.cumsum(lengths(path.centre, closed=True))])
    loop = np.vstack([path.centre, path.centre[:1]])
    count = int(np.searchsorted(run, overlap))
    again = loop[1 : count + 1]
    top = float(((path.centre - foot) @ axis).max()) + retract
    end = again[-1] if len(again) else loop[0]
    ahead = path.centre[1] - path.centre[0]
    return Leads(
        np.vstack([foot + top * axis, _half_circle(path.centre[0], axis, foot, ahead)]), again,
        np.vstack([_half_circle(end, axis, foot, -ahead)[::-1], foot + top * axis]),
    )  # fmt: skip


def _half_circle(end: FloatArray, axis: FloatArray, foot: FloatArray, travel: FloatArray) -> FloatArray:
    """Half circle from the hole axis, at the height of the end point, onto that point in the direction of travel."""
    centre = foot + ((end - foot) @ axis) * axis
    outward = end - centre
    middle = centre + 0.5 * outward
    side = np.cross(axis, outward)
    side *= np.sign(side @ travel) or 1.0
    turn = np.linspace(math.pi, 0.0, 17)[:, None]
    return middle + 0.5 * (np.cos(turn) * outward - np.sin(turn) * side)
