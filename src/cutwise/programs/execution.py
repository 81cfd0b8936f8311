"""A block is run: its parts in the order that RS274/NGC lays down, wherever they stand in the line."""

import contextlib

from cutwise.programs import arcs, auxiliary, compensation, cycles, modes, motions, offsets, splines
from cutwise.programs.block import Block
from cutwise.programs.canon import Coolant, Dwell, FeedMode, FeedRate, Plane, Signal, SpindleMode, SpindleTurn, Stop
from cutwise.programs.controller import Controller, Cycle
from cutwise.programs.expressions import BlockFault
from cutwise.programs.groups import CYCLES, PROBES

_FIXED_WITH_COMPENSATION = frozenset({100, 520, 920, 921, 922, 923})


def execute(c: Controller, block: Block) -> bool:
    """Run a block whose words are settled; whether the program ends with it.

    Raises
    ------
    BlockFault
        Something in it cannot be run.
    """
    g, m, values = block.g, block.m, block.values
    if "spindle mode" in g:
        modes.set_spindle_mode(c, block)
    if "feed mode" in g:
        modes.set_feed_mode(c, g["feed mode"] // 10)
    if "f" in values:
        modes.set_feed(c, block)
    if "s" in values:
        modes.set_speed(c, block)
    if "t" in values:
        auxiliary.select_tool(c, block)
    if m:
        _machine_words(c, block)
    if g:
        _modal_words(c, block)
    if block.left_in_force is not None:
        c.motion = block.left_in_force
    if block.motion is not None:
        _motion(c, block)
    if "stop" in m:
        return _stop(c, m["stop"])
    return False


def _machine_words(c: Controller, block: Block) -> None:
    m = block.m
    if "inputs and outputs" in m:
        auxiliary.signal(c, block)
    if "tool change" in m:
        auxiliary.change_tool(c, block)
    if "spindle" in m:
        (modes.keep if m["spindle"] >= 70 else auxiliary.turn_spindle)(c, block)
    if "coolant" in m:
        auxiliary.cool(c, block)
    if "overrides" in m:
        auxiliary.override(c, block)


def _modal_words(c: Controller, block: Block) -> None:
    g = block.g
    if g.get("non-modal") == 40:
        seconds = block.values.get("p", -1.0)
        if seconds < 0.0:
            raise block.fault("G4 needs a time P in seconds, not negative", "p", "g.non-modal")
        c.out.append(Dwell(seconds, c.line, c.number))
    if "plane" in g:
        modes.set_plane(c, block)
    if "units" in g:
        modes.set_units(c, g["units"] == 200, block.place("g.units"))
    if "cutter compensation" in g:
        if g["cutter compensation"] == 400:
            compensation.switch_off(c, block)
        else:
            compensation.switch_on(c, block, g["cutter compensation"])
    if "tool length" in g:
        _not_compensated(c, block, "tool length")
        offsets.set_tool_length(c, block, g["tool length"])
    if "work coordinates" in g:
        _not_compensated(c, block, "work coordinates")
        offsets.select_system(c, g["work coordinates"])
    if "path control" in g:
        modes.set_path_control(c, block)
    if "distance mode" in g:
        c.incremental = g["distance mode"] == 910
    if "arc distance mode" in g:
        c.arc_absolute = g["arc distance mode"] == 901
    if "return of cycles" in g:
        c.retract_to_start = g["return of cycles"] == 980
    if "non-modal" in g:
        _non_modal(c, block, g["non-modal"])


def _not_compensated(c: Controller, block: Block, group: str) -> None:
    if c.compensation is not None:
        raise block.fault(f"{group} cannot change with cutter compensation; write G40 before", f"g.{group}")


def _non_modal(c: Controller, block: Block, code: int) -> None:
    if code in _FIXED_WITH_COMPENSATION and c.compensation is not None and not (code == 100 and _about_tools(block)):
        raise block.fault("offsets cannot change with cutter compensation; write G40 before", "g.non-modal")
    if code == 100:
        offsets.set_data(c, block)
    elif code in (280, 300):
        motions.reference(c, block, code)
    elif code in (281, 301):
        offsets.store_home(c, code - 1)
    elif code == 520:
        offsets.set_local_origin(c, block)
    elif code == 530 and block.motion not in (0, 10):
        raise block.fault("G53 needs G0 or G1", "g.non-modal")
    elif code == 920:
        offsets.set_axis_offset(c, block)
    elif code in (921, 922, 923):
        offsets.reset_axis_offset(c, code)


def _about_tools(block: Block) -> bool:
    return block.values.get("l") in (1.0, 10.0, 11.0)


def _motion(c: Controller, block: Block) -> None:
    code, before = block.motion, c.motion
    assert code is not None
    c.motion = code
    if c.spline is not None and code not in (52, 53):
        c.spline = None
        raise block.fault("the NURBS block is not closed; write G5.3 before", "g.motion", *block.axes())
    if code not in (50,):
        c.spline_tangent = None
    if code in (0, 10):
        motions.straight(c, block)
    elif code in (20, 30):
        arcs.arc(c, block)
    elif code in CYCLES:
        if "motion" in block.g and not block.axes():
            raise block.fault("a canned cycle needs axis words", "g.motion")
        cycles.cycle(c, block, before=before)
    elif code == 800:
        c.cycle = Cycle(dwell=c.cycle.dwell)
    elif code in PROBES:
        motions.probe(c, block)
    elif code in (330, 331):
        motions.synchronised(c, block)
    elif code in (50, 51):
        c.motion = before  # a spline is not modal
        splines.spline(c, block)
    elif code == 52:
        splines.control_point(c, block)
    else:
        splines.close(c, block)


def _stop(c: Controller, code: int) -> bool:
    if code in (0, 1, 60):
        if code == 60:
            c.out.append(Stop("shuttle", c.line, c.number))
        c.out.append(Stop("optional" if code == 1 else "stop", c.line, c.number))
        return False
    end(c, shuttle=code == 30)
    return True


def go_on(c: Controller, block: Block) -> None:
    """After a fault: be where the block would have led, so that its consequences are not faults too."""
    if block.motion not in (0, 10, 20, 30, 50, 51):
        return
    c.motion = block.motion if block.motion < 50 else c.motion
    with contextlib.suppress(BlockFault):
        c.at[:] = motions.target(c, block)
    if c.compensation is not None:
        c.compensation.last = c.compensation.programmed = None


def close(c: Controller) -> None:
    """The program is over without an end of its own: what waits is final."""
    compensation.switch_off(c)


def end(c: Controller, *, shuttle: bool) -> None:
    """M2, M30: back to the initial modes, everything off."""
    compensation.switch_off(c)
    c.offsets.system = 1
    c.offsets.origin, c.offsets.rotation = offsets.system_of(c, 1)
    offsets.say_system(c)
    if c.plane != "XY":
        c.out.append(Plane("XY", c.line, c.number))
    c.out.append(FeedMode(False, c.line, c.number))
    c.out.append(FeedRate(0.0, c.line, c.number))
    if not c.switches.feed_override:
        c.out.append(Signal("ENABLE_FEED_OVERRIDE", "", c.line, c.number))
    c.out.append(SpindleTurn(0, c.line, c.number))
    c.out.append(SpindleMode(0.0, c.line, c.number))
    if c.switches.mist:
        c.out.append(Coolant("mist", False, c.line, c.number))
    if c.switches.flood:
        c.out.append(Coolant("flood", False, c.line, c.number))
    if shuttle:
        c.out.append(Stop("shuttle", c.line, c.number))
    c.out.append(Stop("end", c.line, c.number))
