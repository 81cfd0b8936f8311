"""Modal words: units, plane, distances, feed, path control; saving and restoring all of them (M70 to M73)."""

from cutwise.programs import auxiliary, compensation, offsets
from cutwise.programs.block import Block
from cutwise.programs.canon import (
    FeedMode,
    FeedRate,
    LengthUnits,
    NaiveTolerance,
    PathControl,
    Plane,
    SpindleMode,
    SpindleSpeed,
)
from cutwise.programs.controller import INCH, MILLIMETRE, Controller, PathModeName, PlaneName, Saved, scaled
from cutwise.programs.expressions import BlockFault
from cutwise.programs.scale import feed_out_of_scale, feed_too_small

_PLANES: dict[int, PlaneName] = {170: "XY", 180: "XZ", 190: "YZ"}
_PATH_MODES: dict[int, PathModeName] = {610: "exact_path", 611: "exact_stop", 640: "continuous"}
_NO_LIMIT = 1e30  # [1/min] under constant surface speed without D


def set_units(c: Controller, inch: bool, place: int = 0) -> None:
    """G20 and G21: everything that is a length is meant in the new unit from here on.

    Raises
    ------
    BlockFault
        The unit changes while the tool is beside the contour: its radius and the point on the contour are lengths too.
    """
    if inch != c.inch:
        if c.compensation is not None:
            raise BlockFault("the unit cannot change with cutter compensation; write G40 before", place)
        factor = MILLIMETRE / INCH if inch else INCH / MILLIMETRE
        c.at[:] = scaled(c.at, factor)
        o = c.offsets
        o.origin, o.axis, o.tool = scaled(o.origin, factor), scaled(o.axis, factor), scaled(o.tool, factor)
        c.inch = inch
    c.out.append(LengthUnits(inch, c.line, c.number))


def set_plane(c: Controller, block: Block) -> None:
    """G17, G18, G19."""
    plane = _PLANES[block.g["plane"]]
    if c.compensation is not None and plane != c.plane:
        raise block.fault("the plane cannot change with cutter compensation; write G40 before", "g.plane")
    select_plane(c, plane)


def select_plane(c: Controller, plane: PlaneName) -> None:
    """The plane of arcs."""
    c.plane = plane
    c.out.append(Plane(plane, c.line, c.number))


def set_feed_mode(c: Controller, mode: int) -> None:
    """G93, G94, G95; a feed of the mode before does not hold on."""
    c.feed_mode = mode
    c.feed = 0.0
    c.out.append(FeedMode(mode == 95, c.line, c.number))
    if mode != 93:
        c.out.append(FeedRate(0.0, c.line, c.number))


def set_feed(c: Controller, block: Block) -> None:
    """F: kept for its block under G93, a feed from here on otherwise."""
    value = block.values["f"]
    if value < 0.0:
        raise block.fault(f"the feed must not be negative, found F{value:g}", "f")
    if feed_too_small(value):
        raise block.fault(feed_out_of_scale(value), "f")
    if c.feed_mode != 93:
        say_feed(c, value)


def say_feed(c: Controller, value: float) -> None:
    """A feed per minute or revolution."""
    c.feed = value
    c.out.append(FeedRate(value, c.line, c.number))


def set_spindle_mode(c: Controller, block: Block) -> None:
    """G96 and G97."""
    if block.g["spindle mode"] == 960:
        if "s" not in block.values:
            raise block.fault("G96 needs the surface speed S", "g.spindle mode")
        say_spindle_mode(c, abs(block.values["d"]) if "d" in block.values else _NO_LIMIT)
    else:
        say_spindle_mode(c, 0.0)


def say_spindle_mode(c: Controller, limit: float) -> None:
    """Surface speed up to a limit, or revolutions per minute (0)."""
    c.spindle.surface_limit = limit
    c.out.append(SpindleMode(limit, c.line, c.number))


def set_speed(c: Controller, block: Block) -> None:
    """S."""
    value = block.values["s"]
    if value < 0.0:
        raise block.fault(f"the spindle speed must not be negative, found S{value:g}; M4 turns to the left", "s")
    say_speed(c, value)


def say_speed(c: Controller, value: float) -> None:
    """Revolutions per minute, or a surface speed."""
    c.spindle.speed = value
    c.out.append(SpindleSpeed(value, c.line, c.number))


def set_path_control(c: Controller, block: Block) -> None:
    """G61, G61.1, G64 P Q."""
    mode = _PATH_MODES[block.g["path control"]]
    tolerance = block.values.get("p", 0.0)
    if mode == "continuous" and tolerance <= 0.0:
        c.notice(
            "G64 without P names no tolerance: where motion is planned, corners are rounded as far as the feed asks for"
        )
    if mode != "continuous":
        say_path_control(c, mode, c.tolerance, c.naive_tolerance)
    else:
        say_path_control(c, mode, tolerance, block.values.get("q", tolerance))


def say_path_control(c: Controller, mode: PathModeName, tolerance: float, naive: float) -> None:
    """How blocks are joined."""
    c.path_mode, c.tolerance, c.naive_tolerance, c.path_mode_said = mode, tolerance, naive, True
    c.out.append(PathControl(mode, tolerance, c.line, c.number))
    if mode == "continuous":
        c.out.append(NaiveTolerance(naive, c.line, c.number))


def saved(c: Controller) -> Saved:
    """The modes as they are now."""
    s, w = c.spindle, c.switches
    switches = tuple((code, getattr(w, switch)) for code, (switch, *_) in auxiliary.SWITCHES.items())
    return Saved(
        c.inch, c.plane, c.feed_mode, c.feed, s.speed, s.turning, s.surface_limit, w.mist, w.flood, switches,
        c.offsets.system, tuple(c.offsets.tool), c.incremental, c.arc_absolute, c.retract_to_start,
        (c.path_mode, c.tolerance, c.naive_tolerance), c.compensation is not None, bool(c.numbers.get(5210)),
    )  # fmt: skip


def restore(c: Controller, to: Saved) -> None:
    """Take up saved modes again; what has not changed is left alone."""
    if c.compensation is not None and not to.compensated:
        compensation.switch_off(c)
    if c.compensation is not None and _moves_the_contour(c, to):
        raise BlockFault("the saved modes have another plane or other offsets, which cannot change with cutter "
                         "compensation; write G40 before", 0)  # fmt: skip
    if to.inch != c.inch:
        set_units(c, to.inch)
    if to.feed_mode != c.feed_mode:
        set_feed_mode(c, to.feed_mode)
    if to.feed != c.feed:
        say_feed(c, to.feed)
    _restore_spindle(c, to)
    if to.plane != c.plane:
        select_plane(c, to.plane)
    if to.system != c.offsets.system:
        offsets.select_system(c, 530 + 10 * to.system if to.system < 7 else 584 + to.system)
    if to.axis_offset != bool(c.numbers.get(5210)):
        offsets.reset_axis_offset(c, 923 if to.axis_offset else 922)
    if to.tool_offset != tuple(c.offsets.tool):
        offsets.use_tool_offset(c, list(to.tool_offset))
    if to.path_control != (c.path_mode, c.tolerance, c.naive_tolerance):
        say_path_control(c, *to.path_control)
    c.incremental, c.arc_absolute, c.retract_to_start = to.incremental, to.arc_absolute, to.retract_to_start
    for kind, on in (("mist", to.mist), ("flood", to.flood)):
        if on != getattr(c.switches, kind):
            auxiliary.set_coolant(c, "mist" if kind == "mist" else "flood", on)
    for code, on in to.switches:
        if on != getattr(c.switches, auxiliary.SWITCHES[code][0]):
            auxiliary.set_switch(c, code, on)


def _moves_the_contour(c: Controller, to: Saved) -> bool:
    """Whether taking up saved modes changes what the compensated contour stands in."""
    return (
        to.plane != c.plane or to.system != c.offsets.system or to.tool_offset != tuple(c.offsets.tool)
        or to.axis_offset != bool(c.numbers.get(5210))
    )  # fmt: skip


def _restore_spindle(c: Controller, to: Saved) -> None:
    if to.surface_limit != c.spindle.surface_limit:
        say_spindle_mode(c, to.surface_limit)
    if to.speed != c.spindle.speed:
        say_speed(c, to.speed)
    if to.turning != c.spindle.turning:
        auxiliary.turn(c, to.turning)


def keep(c: Controller, block: Block) -> None:
    """M70 saves the modes of this level of calls, M73 also restores them at its end, M72 now; M71 forgets them."""
    code = block.m["spindle"]
    if code == 71:
        c.saves[-1], c.restores[-1] = None, False
    elif code == 72:
        to = c.saves[-1]
        if to is None:
            raise block.fault("M72 restores what M70 saved, but nothing was saved at this level of calls", "m.spindle")
        restore(c, to)
    else:
        c.saves[-1] = saved(c)
        c.restores[-1] = code == 73
