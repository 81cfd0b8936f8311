"""Where a mill meets a burr whose height varies along the edge."""

import math

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import Polyline, polyline_value

_SCAN = 64  # steps over one radius in the search for the outermost crossing


@compiled
def circle_above_profile(w: float, x: float, centre_height: float, radius: float, profile: Polyline) -> float:
    """Height of the lower half of the mill circle above the profile at w [m]."""
    reach = max(0.0, radius * radius - (w - x) * (w - x))
    return centre_height - math.sqrt(reach) - polyline_value(profile, w)


@compiled
def entry_position(x: float, height: float, radius: float, profile: Polyline) -> float:
    """Where the mill enters the burr: the outermost crossing of mill circle and burr profile ahead of the tool.

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
