"""Cutter radius compensation (G40 to G42.1): the path of the tool centre beside the programmed contour.

Convex corners are rounded by an arc about the corner, concave ones cut short to where the offset curves meet; so the
end of a motion is not known before the next one, and commands wait until then.
"""

import math

from cutwise.programs.block import Block
from cutwise.programs.canon import Arc, Command, Feed, Traverse
from cutwise.programs.controller import PLANES, Compensation, Controller
from cutwise.programs.expressions import BlockFault
from cutwise.programs.offsets import tool_of
from cutwise.programs.plane_curves import (
    SLACK,
    Circle,
    Curve,
    Point,
    along,
    backwards,
    beyond,
    meetings,
    tangent,
    within,
)

_STRAIGHT_ON = 0.05  # [rad]; a corner that turns less is taken as tangent


def switch_on(c: Controller, block: Block, code: int) -> None:
    """G41, G42 by tool number or the tool in the spindle; G41.1, G42.1 by a diameter D."""
    key = "g.cutter compensation"
    if c.compensation is not None:
        raise block.fault("cutter compensation is on already; write G40 before", key)
    if c.plane == "YZ":
        raise block.fault("cutter compensation needs the plane XY or XZ (G17, G18)", key)
    if code in (411, 421):
        if "d" not in block.values:
            raise block.fault(f"G{code // 10}.1 needs the diameter of the tool D", key)
        radius = 0.5 * block.values["d"]
    else:
        d = block.whole("d")
        tool = tool_of(c, d, block, "d") if d is not None else c.tool
        if tool.orientation:
            raise block.fault(
                f"tool {tool.number} has an orientation: it is for lathes, which are not supported", "d", key
            )
        radius = 0.5 * tool.diameter / c.unit()
        if tool.diameter == 0.0 and c.setup.tools is None:
            c.notice("cutter compensation without a tool table: diameters are taken as 0, the path as programmed")
    u, v, _ = PLANES[c.plane]
    left = (code in (410, 411)) == (radius >= 0.0)
    c.compensation = Compensation(left, abs(radius), u, v, c.out)


def switch_off(c: Controller, block: Block | None = None) -> None:
    """G40: the tool stays where it is until the next motion, which must be straight and begins from the contour.

    The controller is back at the programmed point: axes that the next block does not name go there, not to where the
    radius had put the tool, and incremental distances count from there.
    """
    on = c.compensation
    if on is None:
        return
    if block is not None:
        _not_backwards(on, block)
    flush(on)
    if on.programmed is not None:
        c.at[on.u], c.at[on.v] = on.programmed
    c.out = on.out
    c.compensation = None
    c.no_arc_yet = True


def flush(on: Compensation) -> None:
    """What waited is final."""
    on.out.extend(on.pending)
    on.pending.clear()


def straight(c: Controller, block: Block, end: list[float]) -> None:
    """A line along the contour, or to it if it is the first one."""
    on = c.compensation
    assert on is not None
    rapid = block.motion == 0
    point = (end[on.u], end[on.v])
    start = on.programmed if on.programmed is not None else (c.at[on.u], c.at[on.v])
    way = math.hypot(point[0] - start[0], point[1] - start[1])
    if on.last is None and way <= on.radius:
        raise block.fault(f"entry of cutter compensation of {way:.6g}, not longer than the tool radius {on.radius:.6g}; "
                          "begin further away", *block.axes())  # fmt: skip
    if way == 0.0:
        _move(c, rapid, (c.at[on.u], c.at[on.v]), end)
        return
    heading = ((point[0] - start[0]) / way, (point[1] - start[1]) / way)
    curve = Curve(on.beside(start, heading), on.beside(point, heading), heading, entry=on.last is None)
    curve = _joined(c, block, curve, heading, start, rapid) if on.last is not None else curve
    _wait(c, curve, point)
    _move(c, rapid, curve.end, end)


def arc(c: Controller, block: Block, end: list[float], circle: Circle) -> None:
    """An arc along the contour, or to it if it is the first motion."""
    on = c.compensation
    assert on is not None
    point, centre = (end[on.u], end[on.v]), (circle.u, circle.v)
    start = on.programmed if on.programmed is not None else (c.at[on.u], c.at[on.v])
    inside = on.left == (circle.turns > 0)
    reach = -on.radius if inside else on.radius
    first, last = math.dist(start, centre), math.dist(point, centre)
    least = on.radius * (1.0 - SLACK) if "r" in block.values else on.radius * (1.0 + SLACK)  # by R: down to a point
    if min(first, last) < least and (inside or on.last is None):
        raise block.fault(f"arc of radius {min(first, last):.6g}, not larger than the tool radius {on.radius:.6g}",
                          *block.axes(), *"rijk")  # fmt: skip
    entering, end_tangent = tangent(start, centre, circle.turns), tangent(point, centre, circle.turns)
    finish = along(centre, point, (last + reach) / last)
    curve = Curve(along(centre, start, (first + reach) / first), finish, end_tangent, centre, last + reach, circle.turns,
                  finish)  # fmt: skip
    if on.last is None:
        curve = _entry_arc(c, block, (c.at[on.u], c.at[on.v]), curve)
    else:
        curve = _joined(c, block, curve, entering, start, False)
    _wait(c, curve, point)
    _emit_arc(c, on.pending, curve, end)


def _entry_arc(c: Controller, block: Block, start: Point, curve: Curve) -> Curve:
    """An arc from where the tool stands that ends as the contour does, beside it."""
    normal = (-curve.end_tangent[1], curve.end_tangent[0])
    to = (start[0] - curve.end[0], start[1] - curve.end[1])
    across = normal[0] * to[0] + normal[1] * to[1]
    if abs(across) < 1e-12:
        raise block.fault("no arc from here ends beside the contour in its direction; begin with a line", *block.axes())
    if (across > 0.0) != (curve.turns > 0):
        c.notice("cutter compensation begins with an arc that goes the long way round; begin further to the side")
    r = (to[0] ** 2 + to[1] ** 2) / (2.0 * across)
    centre = (curve.end[0] + r * normal[0], curve.end[1] + r * normal[1])
    return curve._replace(start=start, centre=centre, radius=abs(r), entry=True)


def _joined(c: Controller, block: Block, curve: Curve, heading: Point, corner: Point, rapid: bool) -> Curve:
    """The next curve behind what waits: round a convex corner, or from where it meets the last curve."""
    on = c.compensation
    assert on is not None
    assert on.last is not None
    a, b = on.last.end_tangent, heading
    turn = on.side * math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])  # positive: toward the tool
    bent = curve if curve.turns else on.last
    back_along_arc = math.pi - abs(turn) < _STRAIGHT_ON and bent.turns != 0 and on.left != (bent.turns > 0)
    if _STRAIGHT_ON < turn < math.pi - _STRAIGHT_ON or back_along_arc:
        meeting = _meeting(on, block, curve)
        on.last = on.last._replace(end=meeting)
        _not_backwards(on, block)
        _cut_short(on, meeting)
        flush(on)
        return curve._replace(start=meeting, missed=beyond(curve, meeting))
    if not curve.turns:
        _not_backwards(on, block)
    elif backwards(on.last):
        c.notice(f"a tool of radius {on.radius:.6g} cuts into the contour in the concave corner before this block")
    flush(on)
    if abs(turn) > _STRAIGHT_ON:
        at = list(c.at)
        at[on.u], at[on.v] = curve.start
        if rapid:
            c.at[:] = at
            on.out.append(Traverse(at[0], at[1], at[2], c.rotary, c.extra, c.line, c.number))
        else:
            corner_arc = Curve(on.last.end, curve.start, heading, corner, on.radius, -1 if on.left else 1)
            _emit_arc(c, on.out, corner_arc, at)
        return curve
    return curve._replace(start=on.last.end)


def _wait(c: Controller, curve: Curve, point: Point) -> None:
    on = c.compensation
    assert on is not None
    on.last, on.programmed = curve, point
    c.out = on.pending


def _move(c: Controller, rapid: bool, place: Point, end: list[float]) -> None:
    on = c.compensation
    assert on is not None
    at = list(end)
    at[on.u], at[on.v] = place
    c.at[:] = at
    kind = Traverse if rapid else Feed
    c.out.append(kind(at[0], at[1], at[2], c.rotary, c.extra, c.line, c.number))


def _emit_arc(c: Controller, out: list[Command], curve: Curve, end: list[float]) -> None:
    u, v, w = PLANES[c.plane]
    at = list(end)
    at[u], at[v] = curve.end
    c.at[:] = at
    out.append(Arc(*curve.end, *curve.centre, curve.turns, at[w], c.rotary, c.extra, c.line, c.number))


def _cut_short(on: Compensation, meeting: Point) -> None:
    """All that waits ends where the curves meet: the last motion, and those across the plane behind it."""
    for place, command in enumerate(on.pending):
        if isinstance(command, Arc):
            on.pending[place] = command._replace(first=meeting[0], second=meeting[1])
        elif isinstance(command, Feed | Traverse):
            at = [command.x, command.y, command.z]
            at[on.u], at[on.v] = meeting
            on.pending[place] = command._replace(x=at[0], y=at[1], z=at[2])


def _meeting(on: Compensation, block: Block, curve: Curve) -> Point:
    """Where the next curve meets the last one: on both of them if it can be, nearest to the corner."""
    assert on.last is not None
    last = on.last
    found = meetings(last, curve)
    if not found:
        raise _unreachable(on, block)
    on_both = [point for point in found if within(last, point) and within(curve, point)]
    on_last = [point for point in found if within(last, point)]
    return min(on_both or on_last or found, key=lambda point: math.dist(point, last.end))


def _not_backwards(on: Compensation, block: Block) -> None:
    if on.last is not None and backwards(on.last):
        raise _unreachable(on, block)


def _unreachable(on: Compensation, block: Block) -> BlockFault:
    return block.fault(f"concave corner that a tool of radius {on.radius:.6g} does not reach without cutting into the "
                       "contour", *block.axes(), *"rijk")  # fmt: skip
