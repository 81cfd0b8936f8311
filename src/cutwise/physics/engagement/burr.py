"""Where a mill meets a burr whose height varies along the edge."""

import math

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import Polyline, polyline_value

_SCAN = 64  # steps over one radius in the search for the outermost crossing


@compiled
def circle_above_profile(w: float, x: float, centre_height: float, radius: float, profile: Polyline) -> float:
    r"""Height of the lower half of the mill circle above the profile at w [m].

    .. math:: y_c - \sqrt{R^2 - (w - x)^2} - h_b(w)

    Parameters
    ----------
    w, x : float
        Place, and place of the mill axis, along the edge [m]; valid for :math:`|w - x| \le R`, beyond the root is 0.
    centre_height : float
        :math:`y_c` of the mill axis above the nominal edge [m].
    radius : float
        Mill radius R [m].
    profile : Polyline
        Burr height :math:`h_b` over the position along the edge [m].

    Examples
    --------
    3 mm from the axis of a mill of 5 mm the circle is 1 mm above its lowest point:

    >>> import numpy as np
    >>> round(1e3 * circle_above_profile(3e-3, 0.0, 5e-3, 5e-3, Polyline(np.zeros(1), np.array([4e-4]))), 9)
    0.6

    References
    ----------
    Derived here.
    """
    reach = max(0.0, radius * radius - (w - x) * (w - x))
    return centre_height - math.sqrt(reach) - polyline_value(profile, w)


@compiled
def entry_position(x: float, height: float, radius: float, profile: Polyline) -> float:
    r"""Where the mill enters the burr: the outermost crossing of mill circle and burr profile ahead of the tool.

    .. math:: w_e = x + \sqrt{p_r (2R - p_r)} \;\text{on an even burr, else the greatest root of}\;
              y_c - \sqrt{R^2 - (w - x)^2} = h_b(w), \quad x \le w \le x + R

    Parameters
    ----------
    x : float
        Position of the mill axis along the edge [m].
    height : float
        Height of the lowest point of the mill above the nominal edge [m].
    radius : float
        Mill radius [m].
    profile : Polyline
        Burr height over the position along the edge [m].

    Returns
    -------
    float
        Position w_e [m]; x itself where the mill touches nothing ahead. A crossing narrower than 1/64 of the radius
        can be missed.

    Notes
    -----
    Valid for burrs that are wider than that, on a straight edge.

    Examples
    --------
    A burr of 1 mm before a mill of 5 mm radius that touches the edge, at 10 mm: :math:`\sqrt{1 \cdot 9}` mm ahead.

    >>> import numpy as np
    >>> round(1e3 * entry_position(1e-2, 0.0, 5e-3, Polyline(np.zeros(1), np.array([1e-3]))), 9)
    13.0

    References
    ----------
    Derived here; Berselli et al. 2016, sec. 3.1, takes the burr at the axis.
    """
    centre = height + radius
    if profile.at.size == 1:
        depth = min(profile.value[0] - height, radius)
        return x + math.sqrt(max(0.0, depth * (2.0 * radius - depth))) if depth > 0.0 else x
    outer = x + radius
    if circle_above_profile(outer, x, centre, radius, profile) < 0.0:
        return outer
    step = radius / _SCAN
    for i in range(1, _SCAN + 1):
        inner = x + radius - i * step
        if circle_above_profile(inner, x, centre, radius, profile) < 0.0:
            low, high = inner, inner + step
            for _ in range(40):
                middle = 0.5 * (low + high)
                if circle_above_profile(middle, x, centre, radius, profile) < 0.0:
                    low = middle
                else:
                    high = middle
            return 0.5 * (low + high)
    return x
