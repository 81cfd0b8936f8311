"""How a mill moves against the work it meets: feed per tooth and direction of the feed."""

import math

from cutwise.maths.compiled import inlined


@inlined
def feed_per_tooth(speed_x: float, speed_y: float, spindle_speed: float, flutes: int) -> float:
    r"""Feed per tooth :math:`c = 2\pi |V| / (N \Omega)` [m].

    Parameters
    ----------
    speed_x, speed_y : float
        Velocity V of the tool relative to the work [m/s].
    spindle_speed : float
        :math:`\Omega` [rad/s], positive.
    flutes : int
        Number of flutes N.

    Notes
    -----
    Valid for evenly spaced flutes and a velocity that is steady over a tooth period.

    Examples
    --------
    0.1 m/s, two flutes at 3000 rpm:

    >>> round(1e3 * feed_per_tooth(0.06, 0.08, 100 * math.pi, 2), 9)
    1.0

    References
    ----------
    Berselli et al. 2016, Eq. (8), whose ``n`` must be in revolutions per second.
    """
    return 2.0 * math.pi * math.hypot(speed_x, speed_y) / (flutes * spindle_speed)


@inlined
def feed_direction(speed_x: float, speed_y: float) -> float:
    r"""Feed direction :math:`\vartheta = \operatorname{atan2}(-V_y, V_x)` [rad], positive when the tool plunges.

    ``speed_x``, ``speed_y``: velocity V of the tool relative to the work [m/s]. Valid for every quadrant; at rest 0.

    Examples
    --------
    >>> round(math.degrees(feed_direction(1.0, -1.0)), 9)
    45.0

    References
    ----------
    Berselli et al. 2016 before Eq. (8), with the sign under which Eqs. (9)-(11) hold and the quadrant that the printed
    arctangent loses.
    """
    return math.atan2(-speed_y, speed_x)
