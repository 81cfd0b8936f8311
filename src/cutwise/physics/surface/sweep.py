r"""What a ball leaves of an edge: measured on the true surfaces by taking away the sweep of its path.

Nothing here knows how the path was constructed. A point is gone if it is closer than the ball radius to the centre
polyline; the borders of the chamfer are where that distance equals the radius, bracketed and found along the section of
each surface with the normal plane of the edge.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled, inlined
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames
from cutwise.maths.lines import Line, distance_within, line
from cutwise.maths.surfaces import section_height

_STEPS = 60
_SCAN = 24  # steps in which the border is bracketed
_BESIDE = 10  # places looked at beside the chamfer
ZONE_SHARE = 1.02  # a chamfer may reach this multiple of its longest leg from the edge,
ZONE_SLACK = 3e-6  # and this much farther [m]: what is cut beyond is a gouge


class SweptChamfer(NamedTuple):
    """The chamfer found at each sample of an edge; NaN where a border was not found."""

    width: FloatArray  # [m] chord between the borders, shape (n,)
    leg: FloatArray  # [m] distance of the borders from the edge, shape (n, 2)
    border: FloatArray  # [m], shape (n, 2, 3)
    beyond: FloatArray  # [m] deepest cut into both surfaces in the zone beyond the chamfer, shape (n,)


def swept_chamfer(
    frames: EdgeFrames, centre: FloatArray, ball_radius: float, reach: float, *, closed: bool,
    zone: tuple[float, float] = (0.0, 0.0),
) -> SweptChamfer:  # fmt: skip
    """Measure the chamfer that a ball leaves.

    Parameters
    ----------
    frames : EdgeFrames
        Where to measure: use samples between the path points.
    centre : array
        Centre path [m], shape (m, 3); straight between its points.
    ball_radius : float
        Ball radius [m].
    reach : float
        Farthest distance from the edge at which a border is looked for [m].
    closed : bool
        Whether the path runs back to its first point.
    zone : tuple of float
        Distances from the edge, from and to, between which cuts beyond the chamfer are looked for [m].

    Returns
    -------
    SweptChamfer
        Widths, legs and borders [m]; NaN where a border was not found.

    References
    ----------
    Derived here.
    """
    path = line([np.vstack([centre, centre[:1]]) if closed else centre])
    border = np.full((len(frames.point), 2, 3), np.nan)
    beyond = np.zeros(len(frames.point))
    _find_borders(frames, path, ball_radius, reach, zone[0], zone[1], border, beyond)
    width = np.linalg.norm(border[:, 0] - border[:, 1], axis=1)
    leg = np.linalg.norm(border - frames.point[:, None, :], axis=2)
    return SweptChamfer(width, leg, border, beyond)


@inlined
def _on_section(frames: EdgeFrames, i: int, m: int, a: float, start: float) -> tuple[float, float, float, float]:
    """Height of a section over the distance a from sample i of the edge, and the point there [m]."""
    u, n, c = frames.into[i, m], frames.normal[i, m], frames.point[i]
    g, _ = section_height(frames.surfaces, frames.face[i, m], frames.section[i, m], c, u, n, a, start)
    return g, c[0] + a * u[0] + g * n[0], c[1] + a * u[1] + g * n[1], c[2] + a * u[2] + g * n[2]


@inlined
def _border(
    frames: EdgeFrames, i: int, m: int, path: Line, ball_radius: float, low: float, high: float
) -> tuple[float, float, float]:
    """The point between two distances from the edge that is just at the ball radius from the path [m]."""
    g, x, y, z = _on_section(frames, i, m, low, 0.0)
    f_low = distance_within(path, x, y, z, 2.0 * ball_radius) - ball_radius
    g, x, y, z = _on_section(frames, i, m, high, g)
    f_high = distance_within(path, x, y, z, 2.0 * ball_radius) - ball_radius
    side = 0
    for k in range(_STEPS):
        a = (low * f_high - high * f_low) / (f_high - f_low) if k % 3 < 2 and f_high > f_low else 0.5 * (low + high)
        g, x, y, z = _on_section(frames, i, m, a, g)
        f = distance_within(path, x, y, z, 2.0 * ball_radius) - ball_radius
        if abs(f) < 1e-16 or high - low < 1e-16:
            break
        if f >= 0.0:  # false position, the Illinois way; every third step halves
            high, f_high = a, f
            f_low *= 0.5 if side == 1 else 1.0
            side = 1
        else:
            low, f_low = a, f
            f_high *= 0.5 if side == -1 else 1.0
            side = -1
    return x, y, z


@compiled
def _find_borders(
    frames: EdgeFrames, path: Line, ball_radius: float, reach: float, zone_from: float, zone_to: float,
    border: FloatArray, beyond: FloatArray,
) -> None:  # fmt: skip
    """The border of the removed part on both section curves of every sample; cuts beyond it."""
    for i in range(frames.point.shape[0]):
        point = frames.point[i]
        if distance_within(path, point[0], point[1], point[2], ball_radius) >= ball_radius:
            continue  # the edge itself still stands
        for m in range(2):
            low = g = 0.0
            high = math.nan
            for k in range(1, _SCAN + 1):
                a = reach * k / _SCAN
                g, x, y, z = _on_section(frames, i, m, a, g)
                if not math.isfinite(g):
                    break
                if distance_within(path, x, y, z, ball_radius) >= ball_radius:
                    high = a
                    break
                low = a
            if not math.isfinite(high):
                continue
            border[i, m, 0], border[i, m, 1], border[i, m, 2] = _border(frames, i, m, path, ball_radius, low, high)
            if zone_to <= zone_from:
                continue
            for k in range(_BESIDE + 1):
                g, x, y, z = _on_section(frames, i, m, zone_from + (zone_to - zone_from) * k / _BESIDE, g)
                if not math.isfinite(g):
                    break
                beyond[i] = max(beyond[i], ball_radius - distance_within(path, x, y, z, ball_radius))
