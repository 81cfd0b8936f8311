"""M words: spindle, coolant, tools, inputs and outputs, override switches."""

from typing import Literal

from cutwise.programs import offsets
from cutwise.programs.block import Block
from cutwise.programs.canon import ChangeTool, Coolant, SelectTool, Signal, SpindleTurn
from cutwise.programs.controller import Controller


def select_tool(c: Controller, block: Block) -> None:
    """T."""
    number = block.whole("t")
    assert number is not None
    offsets.tool_of(c, number, block, "t")
    c.selected = number
    c.out.append(SelectTool(number, c.line, c.number))


def change_tool(c: Controller, block: Block) -> None:
    """M6 and M61."""
    code = block.m["tool change"]
    if c.compensation is not None:
        raise block.fault("tools cannot be changed with cutter compensation; write G40 before", "m.tool change")
    if code == 61:
        number = block.whole("q")
        if number is None:
            raise block.fault("M61 needs the number of a tool Q", "m.tool change")
        c.selected = number
        c.tool = offsets.tool_of(c, number, block, "q")
    else:
        turn(c, 0)
        c.tool = offsets.tool_of(c, c.selected, block, "m.tool change")
    c.slot = c.tool.number
    c.out.append(ChangeTool(c.tool.number, code == 61, c.line, c.number))


def turn_spindle(c: Controller, block: Block) -> None:
    """M3, M4, M5, and M19."""
    code = block.m["spindle"]
    if code == 19:
        _orient(c, block)
    elif code in (3, 4, 5):
        turn(c, 1 if code == 3 else -1 if code == 4 else 0)


def turn(c: Controller, turning: Literal[-1, 0, 1]) -> None:
    """Start or stop the spindle."""
    c.spindle.turning = turning
    c.out.append(SpindleTurn(turning, c.line, c.number))


def _orient(c: Controller, block: Block) -> None:
    angle = block.values.get("r", 0.0)
    if not 0.0 <= angle <= 360.0:
        raise block.fault("M19: the angle R must be from 0 to 360", "r")
    way = block.whole("p") or 0
    if way > 2:
        raise block.fault("M19: the direction P must be 0, 1 or 2", "p")
    c.spindle.turning = 0
    if "r" in block.values or "p" in block.values:
        c.out.append(Signal("ORIENT_SPINDLE", f"0, {angle:.4f}, {way}", c.line, c.number))
    if "q" in block.values:
        if block.values["q"] <= 0.0:
            raise block.fault("M19: the time Q must be positive", "q")
        c.out.append(Signal("SPINDLE.0.WAIT_ORIENT_COMPLETE", f"{block.values['q']:.4f}", c.line, c.number))


def cool(c: Controller, block: Block) -> None:
    """M7, M8, M9."""
    code = block.m["coolant"]
    if code != 8:
        set_coolant(c, "mist", code == 7)
    if code != 7:
        set_coolant(c, "flood", code == 8)


def set_coolant(c: Controller, kind: Literal["mist", "flood"], on: bool) -> None:
    """Turn mist or flood."""
    setattr(c.switches, kind, on)
    c.out.append(Coolant(kind, on, c.line, c.number))


SWITCHES = {  # M code: switch, its name in commands, and their arguments
    50: ("feed_override", "FEED_OVERRIDE", ""),
    51: ("speed_override", "SPEED_OVERRIDE", "0"),
    52: ("adaptive_feed", "ADAPTIVE_FEED", ""),
    53: ("feed_hold", "FEED_HOLD", ""),
}


def override(c: Controller, block: Block) -> None:
    """M48 to M53."""
    code = block.m["overrides"]
    if code < 50:
        for switch in (50, 51):
            set_switch(c, switch, code == 48)
    else:
        set_switch(c, code, block.values.get("p", 1.0) != 0.0)


def set_switch(c: Controller, code: int, on: bool) -> None:
    """Turn an override or hold switch."""
    switch, name, arguments = SWITCHES[code]
    setattr(c.switches, switch, on)
    c.out.append(Signal(f"{'ENABLE' if on else 'DISABLE'}_{name}", arguments, c.line, c.number))


_OUTPUTS = {
    62: "SET_MOTION_OUTPUT_BIT", 63: "CLEAR_MOTION_OUTPUT_BIT", 64: "SET_AUX_OUTPUT_BIT", 65: "CLEAR_AUX_OUTPUT_BIT",
    67: "SET_MOTION_OUTPUT_VALUE", 68: "SET_AUX_OUTPUT_VALUE",
}  # fmt: skip


def signal(c: Controller, block: Block) -> None:
    """M62 to M68: outputs, and waiting for an input, which is taken to come at once."""
    code = block.m["inputs and outputs"]
    key = "m.inputs and outputs"
    if code == 66:
        _wait(c, block)
    elif code in (67, 68):
        if "e" not in block.values or "q" not in block.values:
            raise block.fault(f"M{code} needs an output E and a value Q", key)
        arguments = f"{block.whole('e')},{block.values['q']:.6f}"
        c.out.append(Signal(_OUTPUTS[code], arguments, c.line, c.number))
    else:
        if "p" not in block.values:
            raise block.fault(f"M{code} needs the number of an output P", key)
        c.out.append(Signal(_OUTPUTS[code], f"{block.whole('p')}", c.line, c.number))


def _wait(c: Controller, block: Block) -> None:
    v = block.values
    mode = block.whole("l") or 0
    if ("p" in v) == ("e" in v):
        raise block.fault("M66 needs one input, digital (P) or analog (E)", "e", "m.inputs and outputs")
    if mode > 4:
        raise block.fault("M66: the mode L must be from 0 to 4", "l")
    if mode and "e" in v:
        raise block.fault("M66 cannot wait for an analog input; leave L out", "l")
    if mode and v.get("q", 0.0) <= 0.0:
        raise block.fault("M66 needs a positive time Q to wait for", "q", "l")
    c.numbers[5399] = 0.0
    c.notice("M66 waits for an input; it is taken to come at once, and its value to be 0")
