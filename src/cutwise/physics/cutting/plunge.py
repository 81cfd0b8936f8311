"""A flat mill that goes straight down: its bottom edges cut."""

import math

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill


@compiled
def plunge_force(feed: float, core: float, mill: Mill, coefficients: EdgeCoefficients) -> float:
    r"""Force along the axis of a mill whose whole bottom cuts.

    .. math:: F_z = N (K_{rc} f + K_{re}) (R - r_0)

    Parameters
    ----------
    feed : float
        f downward per tooth [m].
    core : float
        Radius :math:`r_0` inside which bottom edges do not cut [m].
    mill : Mill
        Radius R and number of teeth N.
    coefficients : EdgeCoefficients
        Of linear edges; the radial ones act along the axis.

    Returns
    -------
    float
        Upward on the tool [N]; 0 without feed.

    Notes
    -----
    Valid for bottom edges without dish angle that meet material from :math:`r_0` to R: a plunge whose bottom stands partly
    in air takes less. Coefficients depend on the engagement in plunge tests; those of the flutes are taken.

    Examples
    --------
    D 20, three teeth, 5 mm/s at 8000 rpm in aluminium, over the centre and with a core of 2 mm:

    >>> k = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
    >>> [round(plunge_force(12.5e-6, core, Mill(10e-3, 3, 0.5), k), 2) for core in (0.0, 2e-3)]
    [861.3, 689.04]

    References
    ----------
    Derived from the edge forces of Altintas 2012, sec. 2.6.
    """
    if feed <= 0.0:
        return 0.0
    return mill.flutes * (coefficients.K_rc * feed + coefficients.K_re) * (mill.radius - core)


@compiled
def plunge_feed(force: float, core: float, mill: Mill, coefficients: EdgeCoefficients) -> float:
    r"""Feed down per tooth at which :func:`plunge_force` is a force [m].

    .. math:: f = \left(\frac{F}{N (R - r_0)} - K_{re}\right) / K_{rc}

    Parameters
    ----------
    force : float
        F [N].
    core, mill, coefficients
        Those of :func:`plunge_force`.

    Returns
    -------
    float
        f [m]; negative where the edges alone take more, infinite where nothing of the bottom cuts.

    Notes
    -----
    Valid as :func:`plunge_force`.

    Examples
    --------
    >>> k = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
    >>> round(1e6 * plunge_feed(861.3, 0.0, Mill(10e-3, 3, 0.5), k), 9)
    12.5

    References
    ----------
    As :func:`plunge_force`.
    """
    width = mill.flutes * (mill.radius - core)
    if width <= 0.0 or coefficients.K_rc <= 0.0:
        return math.inf
    return (force / width - coefficients.K_re) / coefficients.K_rc
