"""Motion along an edge: constant feed, cosine lead-in and lead-out, and what the robot adds to it."""

import math
from typing import NamedTuple

from cutwise.maths.compiled import inlined
from cutwise.maths.curves import Cubic, cubic_value_slope
from cutwise.records import Pose
from cutwise.stages import driven, moved


class EdgePass(NamedTuple):
    """A pass along an edge; heights are those of the undeflected lowest point of the mill above the nominal edge."""

    feed: float  # [m/s]
    duration: float  # [s] whole pass, with lead-in and lead-out
    lead_in: float  # [s]
    lead_out: float  # [s]
    start_height: float  # [m] at the start, and again at the end of a lead-out
    preset: float  # [m] how far the undeflected mill reaches below the edge
    error_amplitude: float  # [m] sine path error
    error_frequency: float  # [Hz]
    error_curve: Cubic  # [m] over the programmed position [m]; zero where there is none


class ToolMotion(NamedTuple):
    """Programmed position and velocity of the undeflected tool at one instant."""

    position: float  # [m] along the feed
    height: float  # [m] of the lowest point above the nominal edge, path error included
    climb: float  # [m/s] velocity off the work


@inlined
def programmed_motion(path: EdgePass, time: float) -> ToolMotion:
    r"""Position, height and climb of the undeflected tool at a time.

    Lead-in: :math:`y = y_0 + (y_1 - y_0)(1 - \cos(\pi t / T_l)) / 2` from the start height :math:`y_0` to minus the
    preset :math:`y_1`; lead-out mirrors it at the end. The sine path error starts at the end of the lead-in,
    :math:`A \sin 2\pi f (t - T_l)`; a path-error curve acts all along.

    Parameters
    ----------
    path : EdgePass
        The pass.
    time : float
        Time [s] since the start.

    Returns
    -------
    ToolMotion
        Position [m], height [m], climb [m/s].

    Notes
    -----
    Valid for a lead-in and a lead-out that do not overlap. The sine error begins with its full climb
    :math:`2\pi f A`.

    Examples
    --------
    Halfway through a lead-in of 0.5 s from 5 mm above to 2 mm below the edge, at 80 mm/s:

    >>> from cutwise.maths.curves import no_cubic
    >>> tool = programmed_motion(EdgePass(0.08, 2.0, 0.5, 0.0, 0.005, 0.002, 0.0, 0.0, no_cubic()), 0.25)
    >>> [round(1e3 * part, 6) for part in tool]  # mm, mm, and 7 mm * pi / 2 / 0.5 s
    [20.0, 1.5, -21.991149]

    References
    ----------
    Derived here; Berselli et al. 2016, sec. 4, name the feed and no more of the motion.
    """
    position = path.feed * time
    low = -path.preset
    lift = path.start_height - low
    height = low
    climb = 0.0
    if time < path.lead_in:
        phase = math.pi * time / path.lead_in
        height = low + lift * 0.5 * (1.0 + math.cos(phase))
        climb = -lift * 0.5 * math.sin(phase) * math.pi / path.lead_in
    elif path.lead_out > 0.0 and time > path.duration - path.lead_out:
        phase = math.pi * (time - path.duration + path.lead_out) / path.lead_out
        height = low + lift * 0.5 * (1.0 - math.cos(phase))
        climb = lift * 0.5 * math.sin(phase) * math.pi / path.lead_out
    if path.error_amplitude != 0.0 and time > path.lead_in:
        omega = 2.0 * math.pi * path.error_frequency
        phase = omega * (time - path.lead_in)
        height += path.error_amplitude * math.sin(phase)
        climb += path.error_amplitude * omega * math.cos(phase)
    value, slope = cubic_value_slope(path.error_curve, position)
    return ToolMotion(position, height + value, climb + slope * path.feed)


@moved.of(EdgePass)
def _(motion, time):
    tool = programmed_motion(motion, time)
    return Pose(time, tool.position, tool.position, tool.height, 0.0, motion.feed, tool.climb, 0.0, 0.0)


@driven.of(EdgePass)
def _(motion, pose, load, dt):
    """The programmed motion knows no load."""
    return 0


def path_memory_index(largest_curvature: float, radius: float) -> float:
    r"""How much the tool follows its own older surface: :math:`A \omega^2 R / v_f^2 = |y''|_{max} R`.

    Below 1 the arcs of Eq. (11) carry the surface memory exactly; above 1 the mill meets a surface that it cut less
    than half a diameter ago.

    Parameters
    ----------
    largest_curvature : float
        Largest second derivative of the path error along the path, :math:`|y''| = A (\omega / v_f)^2` [1/m].
    radius : float
        Mill radius [m].

    Returns
    -------
    float
        [1]

    References
    ----------
    Derived here; the arcs are those of Berselli et al. 2016, Eq. (11).
    """
    return largest_curvature * radius
