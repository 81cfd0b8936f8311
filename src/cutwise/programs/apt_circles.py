"""Arcs of CL data: the circle of a CIRCLE statement, and whether the points of an arc are on it."""

import math

from cutwise.maths.circles import Circle, distance_from_axis
from cutwise.programs.apt_frames import Frames
from cutwise.programs.cldata import Statement, StatementFault
from cutwise.programs.moves import Point

_ON_CIRCLE = 1e-3  # share of the radius by which an end may be off its circle


def circle_of(s: Statement, frames: Frames, start: Point) -> Circle:
    """The circle of a CIRCLE statement: centre, axis, radius; without a radius it is that of the start point.

    Raises
    ------
    StatementFault
        Numbers are missing, or there is no axis or radius.
    """
    n = s.numbers()
    if len(n) < 6:
        raise StatementFault("CIRCLE needs centre x,y,z, axis i,j,k and radius", s.column)
    size = math.hypot(*n[3:6])
    if size < 1e-6:
        raise StatementFault("CIRCLE needs an axis with a length", s.column)
    centre = frames.point((n[0], n[1], n[2]))
    axis = frames.vector((n[3] / size, n[4] / size, n[5] / size))
    radius = n[6] if len(n) > 6 else distance_from_axis(Circle(centre, axis, 0.0), start)
    if radius <= 0.0:
        where = "a positive radius" if len(n) > 6 else "a start point apart from its axis"
        raise StatementFault(f"CIRCLE needs {where}", s.column)
    return Circle(centre, axis, radius)


def check_ends(circle: Circle, start: Point, end: Point, slack: float, column: int) -> None:
    """Start and end of an arc are on its circle, within a share of its radius or a slack.

    Raises
    ------
    StatementFault
        One of them is not.
    """
    for name, point in (("start", start), ("end", end)):
        far = distance_from_axis(circle, point)
        if abs(far - circle.radius) > max(_ON_CIRCLE * circle.radius, slack):
            message = f"the {name} of the arc is {far:.6g} from its axis, its radius is {circle.radius:.6g}"
            raise StatementFault(message, column)
