"""What rows of contact come to: the volume that they take along the way, and the angle of contact."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import stepping
from cutwise.physics.engagement.map_contact import CYLINDER, Edge

FloatArray = npt.NDArray[np.float64]


@stepping
def removal(rows: FloatArray, count: int, edge: Edge, slope: float) -> float:
    r"""Volume that rows of contact take per horizontal length, straight down per depth [m^2].

    .. math:: \sum r\,ds \int (\sin\kappa \cos\psi - k \cos\kappa)\,d\psi

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, from :func:`contact_rows`.
    edge : Edge
        Where the tool cuts.
    slope : float
        Rise per horizontal length :math:`k` [-]; infinite: straight down, where the term of :math:`\cos\kappa` alone counts.

    Returns
    -------
    float
        Area [m^2].

    Notes
    -----
    Valid to the width of the elements: one that is partly in contact counts whole or not at all.

    Examples
    --------
    The mill of :func:`contact_rows` takes 2 mm of the block 2 mm deep; straight down the whole of its bottom takes
    :math:`\pi R^2`.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> edge = Edge(meridian(flat(5e-3), 0.0, 1), 5e-3, 0.0, 10e-3)
    >>> side = np.array([[CYLINDER, math.asin(0.6), 0.5 * math.pi, 0.0, 2e-3]])
    >>> bottom = np.array([[0, -math.pi, math.pi, 0.0, 0.0]])
    >>> round(1e6 * removal(side, 1, edge, 0.0), 6), round(1e6 * removal(bottom, 1, edge, -math.inf), 6)
    (4.0, 78.539816)

    References
    ----------
    Derived here: the flow of the feed through the surface in contact.
    """
    mer, area = edge.meridian, 0.0
    for n in range(count):
        element, low, high = int(rows[n, 0]), rows[n, 1], rows[n, 2]
        turn = math.sin(high) - math.sin(low)
        if element == CYLINDER:
            area += edge.radius * (rows[n, 4] - rows[n, 3]) * turn
        elif math.isinf(slope):
            area += mer.radius[element] * mer.length[element] * mer.cosine[element] * (high - low)
        else:
            area += (
                mer.radius[element] * mer.length[element]
                * (mer.sine[element] * turn - slope * mer.cosine[element] * (high - low))
            )  # fmt: skip
    return area


@stepping
def angle_of_contact(rows: FloatArray, count: int, edge: Edge) -> float:
    """Largest sum of arcs at one height, of flute elements with kappa of at least 45 degrees [rad].

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, from :func:`contact_rows`: arcs at one height follow one another.
    edge : Edge
        Where the tool cuts.

    Returns
    -------
    float
        Angle [rad]; 0 without contact.

    Notes
    -----
    Valid for any tool; of a flat one the cylinder alone counts, of a ball the upper part.

    Examples
    --------
    Two arcs of 30 and of 40 degrees in one layer, and one of 60 in the layer above; the bottom does not count.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> layers = [[CYLINDER, -90, -60, 0, 1e-3], [CYLINDER, 20, 60, 0, 1e-3], [CYLINDER, 0, 60, 1e-3, 2e-3]]
    >>> rows = np.array([[0, -180, 180, 0, 0], *layers])
    >>> rows[:, 1:3] = np.radians(rows[:, 1:3])
    >>> round(math.degrees(angle_of_contact(rows, 4, Edge(meridian(flat(5e-3), 0.0, 1), 5e-3, 0.0, 10e-3))), 9)
    70.0

    References
    ----------
    Derived here.
    """
    largest = here = 0.0
    for n in range(count):
        element = int(rows[n, 0])
        if element != CYLINDER and edge.meridian.sine[element] < math.sqrt(0.5) * (1.0 - 1e-9):
            here = 0.0
            continue
        same = n > 0 and rows[n, 0] == rows[n - 1, 0] and rows[n, 3] == rows[n - 1, 3]
        here = here + rows[n, 2] - rows[n, 1] if same else rows[n, 2] - rows[n, 1]
        largest = max(largest, here)
    return largest
