"""Regenerative chip thickness from the true surface that earlier teeth left, disc by disc."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled_sums

FloatArray = npt.NDArray[np.float64]

OUT_OF_REACH = 1e100  # [m]


class ToothGrid(NamedTuple):
    """Angles that the discs of a mill visit when every tooth period takes a whole number of time steps.

    All discs of all teeth visit the same ``revolution`` angular stations, each disc with its own lag. Angles run
    clockwise from +y; station q of disc d lies at :math:`2\\pi q/revolution - lag_d`.
    """

    normal_x: FloatArray  # sine of the angle, shape (revolution, discs)
    normal_y: FloatArray  # cosine, shape (revolution, discs)
    inside: npt.NDArray[np.bool_]  # whether the disc is between entry and exit, shape (revolution, discs)
    any_inside: npt.NDArray[np.bool_]  # shape (revolution,)
    tooth: int  # steps per tooth period


def tooth_grid(teeth: int, steps: int, lag: FloatArray, entry: float, exit_angle: float) -> ToothGrid:
    """Stations of a mill: teeth, steps per tooth period, lag of each disc [rad], entry and exit angle [rad].

    Valid for a helix whose lags are given and for arcs of a turn at most.

    Examples
    --------
    Two teeth, two steps a tooth: stations at 0, 90, 180 and 270 degrees, of which two lie before an exit at 2 rad.

    >>> tooth_grid(2, 2, np.zeros(1), 0.0, 2.0).inside.ravel().tolist()
    [True, True, False, False]

    References
    ----------
    Derived here.
    """
    angle = 2.0 * math.pi * np.arange(teeth * steps)[:, None] / (teeth * steps) - np.asarray(lag)[None, :]
    past = np.mod(angle - entry, 2.0 * math.pi)
    inside = past < exit_angle - entry
    return ToothGrid(np.sin(angle), np.cos(angle), inside, inside.any(axis=1), steps)  # type: ignore[arg-type]


@compiled_sums
def cut_station(
    x: float, y: float, q: int, normal_x: FloatArray, normal_y: FloatArray, surface: FloatArray, least_chip: float
) -> tuple[float, float, float, float]:  # fmt: skip
    r"""Chip sums of the discs of one tooth at one station; the surface that they leave is recorded.

    .. math:: h_d = n_d \cdot r - s_d, \qquad \text{in cut where } h_d > 0, \qquad s_d \leftarrow n_d \cdot r

    Because a disc that misses the surface leaves :math:`s_d` as it was, the chip is measured from the highest of all
    earlier passes (multiple delays), and a tooth out of contact cuts nothing.

    Parameters
    ----------
    x, y : float
        Tool centre :math:`r`, feed motion included [m].
    q : int
        Station.
    normal_x, normal_y : ndarray
        Of :class:`ToothGrid`, shape (revolution, discs).
    surface : ndarray
        Surface :math:`s` [m], shape (revolution, discs), of :func:`fed_surface`; row ``q`` is changed in place.
    least_chip : float
        Zero; a large negative number lets teeth "cut" thin air, which makes the law linear for a stability check [m].

    Returns
    -------
    tuple
        Sums over the discs in cut of :math:`h n_x`, :math:`h n_y` [m], :math:`n_x`, :math:`n_y` [-].

    Notes
    -----
    Valid for a steady spindle speed, whole steps per tooth period, and displacements small against the mill radius.

    Examples
    --------
    Of two discs, one along x and one along y, the tool moves into the surface of the first and away from the other's:

    >>> surface = np.zeros((1, 2))
    >>> sums = cut_station(1e-4, -2e-4, 0, np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]]), surface, 0.0)
    >>> [value + 0.0 for value in sums], (surface[0] + 0.0).tolist()
    ([0.0001, 0.0, 1.0, 0.0], [0.0001, 0.0])

    References
    ----------
    Derived here; that the highest of the earlier passes counts is the multiple regeneration of Tlusty and Ismail 1981.
    """
    hx, hy, ex, ey = 0.0, 0.0, 0.0, 0.0
    for d in range(surface.shape[1]):
        nx, ny, old = normal_x[q, d], normal_y[q, d], surface[q, d]
        chip = x * nx + y * ny - old
        cuts = 1.0 if chip > least_chip else 0.0
        chip = chip if chip > least_chip else 0.0
        surface[q, d] = old + chip
        hx += chip * nx
        hy += chip * ny
        ex += cuts * nx
        ey += cuts * ny
    return hx, hy, ex, ey


def fed_surface(grid: ToothGrid, feed_per_tooth: float) -> FloatArray:
    """Surface that a rigid tool fed along +x has left one tooth period before each station is first met [m].

    Station q is first met by tooth 0 at step q; the pass before it was a tooth period earlier. Outside entry and exit
    it is out of reach, so that nothing is cut there.

    ``grid``: stations of the mill; ``feed_per_tooth`` [m]. Returns shape (revolution, discs). Valid without run-out.

    Examples
    --------
    The station across the feed is met half a tooth period on, half a feed before where the tool stands then:

    >>> surface = fed_surface(tooth_grid(2, 2, np.zeros(1), 0.0, 2.0), 1e-4)
    >>> round(float(surface[1, 0]), 9), float(surface[2, 0])
    (-5e-05, 1e+100)

    References
    ----------
    Derived here.
    """
    revolution = grid.normal_x.shape[0]
    first = np.arange(revolution) % grid.tooth  # the step at which some tooth first meets the station
    fed = feed_per_tooth * (first / grid.tooth - 1.0)
    return np.where(grid.inside, grid.normal_x * fed[:, None], OUT_OF_REACH)
