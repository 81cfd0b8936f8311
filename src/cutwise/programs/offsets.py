"""Work coordinates and tool lengths: G10, G28.1, G30.1, G43, G49, G52, G54 to G59.3, G92."""

import math

from cutwise.programs.block import Block
from cutwise.programs.canon import AxisOffset, Rotation, Signal, ToolLength, WorkOffset
from cutwise.programs.controller import (
    AXES,
    LINEAR,
    ZEROS,
    Controller,
    Offsets,
    from_machine,
    scaled,
    to_machine,
    turned,
)
from cutwise.programs.setup import Tool

HOMES = {280: 5161, 300: 5181}  # first variable of a home position (G28, G30)
_AXIS_OFFSET = 5211  # first variable; 5210: whether it holds
_SYSTEM = 5201  # first variable of system n, less 20 n; its rotation 9 behind


def home(c: Controller, first: int) -> list[float]:
    """A stored position in machine coordinates."""
    return scaled([c.numbers.get(first + i, 0.0) for i in range(9)], 1.0 / c.machine_units())


def store(c: Controller, first: int, values: list[float]) -> None:
    """Keep values of the nine axes in numbered variables, in units of the machine."""
    for i, value in enumerate(scaled(values, c.machine_units())):
        c.numbers[first + i] = value


def store_home(c: Controller, code: int) -> None:
    """G28.1 and G30.1: the present position is the one to return to."""
    store(c, HOMES[code], to_machine(c.offsets, c.at))


def system_of(c: Controller, number: int) -> tuple[list[float], float]:
    """Origin and rotation [degree] of a work coordinate system."""
    first = _SYSTEM + 20 * number
    return home(c, first), c.numbers.get(first + 9, 0.0)


def select_system(c: Controller, code: int) -> None:
    """G54 to G59.3."""
    number = code // 10 - 53 + code % 10
    o = c.offsets
    if number == o.system:
        return
    place = to_machine(o, c.at)
    o.system = number
    o.origin, o.rotation = system_of(c, number)
    c.numbers[5220] = float(number)
    c.at[:] = from_machine(o, place)
    c.out.append(WorkOffset(number, tuple(o.origin), c.line, c.number))
    c.out.append(AxisOffset(tuple(o.axis), c.line, c.number))
    c.out.append(Rotation(o.rotation, c.line, c.number))


def say_system(c: Controller) -> None:
    """Origin and rotation of the system in force, as commands."""
    c.out.append(WorkOffset(c.offsets.system, tuple(c.offsets.origin), c.line, c.number))
    c.out.append(Rotation(c.offsets.rotation, c.line, c.number))


def set_axis_offset(c: Controller, block: Block) -> None:
    """G92: the present position gets the coordinates of the axis words."""
    _no_polar(block)
    letters = block.axes()
    if not letters:
        raise block.fault("G92 needs axis words", "g.non-modal")
    for letter in letters:
        i = AXES.index(letter)
        c.offsets.axis[i] += c.at[i] - block.values[letter]
        c.at[i] = block.values[letter]
    _keep_axis_offset(c)


def set_local_origin(c: Controller, block: Block) -> None:
    """G52: an offset from the work coordinates, in the place of that of G92."""
    _no_polar(block)
    letters = block.axes()
    if not letters:
        raise block.fault("G52 needs axis words", "g.non-modal")
    for letter in letters:
        i = AXES.index(letter)
        c.at[i] += c.offsets.axis[i] - block.values[letter]
        c.offsets.axis[i] = block.values[letter]
    _keep_axis_offset(c)


def _keep_axis_offset(c: Controller) -> None:
    c.numbers[5210] = 1.0
    store(c, _AXIS_OFFSET, c.offsets.axis)
    c.out.append(AxisOffset(tuple(c.offsets.axis), c.line, c.number))


def reset_axis_offset(c: Controller, code: int) -> None:
    """G92.1 clears the offset of G92, G92.2 suspends it, G92.3 takes it up again."""
    new = home(c, _AXIS_OFFSET) if code == 923 else list(ZEROS)
    c.at[:] = [at + old - now for at, old, now in zip(c.at, c.offsets.axis, new, strict=True)]
    c.offsets.axis = new
    c.numbers[5210] = float(code == 923)
    if code == 921:
        store(c, _AXIS_OFFSET, new)
    c.out.append(AxisOffset(tuple(new), c.line, c.number))


def set_tool_length(c: Controller, block: Block, code: int) -> None:
    """G43, G43.1, G43.2, G49."""
    new = list(c.offsets.tool)
    h = block.whole("h")
    if code == 490:
        new = list(ZEROS)
    elif code == 430:
        tool = tool_of(c, h, block, "h") if h is not None else c.tool
        new = _in_program_units(c, tool.offset) if h != 0 else list(ZEROS)
    elif code == 431:
        for letter in block.axes():
            new[AXES.index(letter)] = block.values[letter]
    else:
        letters = block.axes()
        if h is None and not letters:
            raise block.fault("G43.2 needs the number of a tool (H) or axis words", "g.tool length")
        if h is not None and letters:
            raise block.fault("G43.2 takes a tool (H) or axis words, not both", letters[0])
        added = _in_program_units(c, tool_of(c, h, block, "h").offset) if h is not None else list(ZEROS)
        for letter in letters:
            added[AXES.index(letter)] = block.values[letter]
        new = [a + b for a, b in zip(new, added, strict=True)]
    _no_polar(block)
    use_tool_offset(c, new)


def use_tool_offset(c: Controller, new: list[float]) -> None:
    """Put a tool offset in force; the machine stands where it was."""
    place = to_machine(c.offsets, c.at)
    c.offsets.tool = new
    c.at[:] = from_machine(c.offsets, place)
    c.out.append(ToolLength(tuple(new), c.line, c.number))


def tool_of(c: Controller, number: int, block: Block, key: str) -> Tool:
    """A tool by its number; without a tool table every tool is there."""
    if number == 0:
        return Tool(0)
    if c.setup.tools is None:
        return c.tools.setdefault(number, Tool(number, number))
    if number not in c.tools:
        known = ", ".join(f"T{n}" for n in sorted(c.tools)) or "none"
        raise block.fault(f"tool {number} is not in the tool table (there: {known})", key)
    return c.tools[number]


def _in_program_units(c: Controller, offset: tuple[float, ...]) -> list[float]:
    """A tool offset [m, rad] in program units and degrees."""
    return [value / c.unit() if i in LINEAR else math.degrees(value) for i, value in enumerate(offset)]


def set_data(c: Controller, block: Block) -> None:
    """G10."""
    form = block.whole("l")
    _no_polar(block)
    if form in (2, 20):
        _set_system(c, block, form)
    elif form in (1, 10, 11):
        _set_tool(c, block, form)
    else:
        raise block.fault("G10 needs L1, L2, L10, L11 or L20", "l", "g.non-modal")


def _set_system(c: Controller, block: Block, form: int) -> None:
    number = block.whole("p") if "p" in block.values else -1
    assert number is not None
    if not 0 <= number <= 9:
        raise block.fault(f"G10 L{form} needs a coordinate system P, 1 (G54) to 9 (G59.3), or 0 for the one in force",
                          "p", "g.non-modal")  # fmt: skip
    number = number or c.offsets.system
    origin, rotation = system_of(c, number)
    if form == 2:
        rotation = block.values.get("r", rotation)
        for letter in block.axes():
            origin[AXES.index(letter)] = block.values[letter]
    else:
        if "r" in block.values:
            raise block.fault("G10 L20 does not take a rotation R; set it with G10 L2", "r")
        there = Offsets(number, origin, rotation, c.offsets.axis, c.offsets.tool)
        here = from_machine(there, to_machine(c.offsets, c.at))
        _shift(origin, rotation, here, block)
    store(c, _SYSTEM + 20 * number, origin)
    c.numbers[_SYSTEM + 20 * number + 9] = rotation
    if number == c.offsets.system:
        _replace_system(c, origin, rotation)


def _shift(offset: list[float], rotation: float, here: list[float], block: Block) -> None:
    """Change an offset so that the present coordinates become those of the axis words."""
    step = [0.0] * 9
    for letter in block.axes():
        i = AXES.index(letter)
        step[i] = here[i] - block.values[letter]
    step[0], step[1] = turned(step[0], step[1], rotation)
    for i in range(9):
        offset[i] += step[i]


def _replace_system(c: Controller, origin: list[float], rotation: float) -> None:
    """New data of the system in force; as the reference dialect has it, an axis offset does not turn with it."""
    o = c.offsets
    x, y = turned(c.at[0], c.at[1], o.rotation)
    c.at[:] = [at + old - new for at, old, new in zip((x, y, *c.at[2:]), o.origin, origin, strict=True)]
    c.at[0], c.at[1] = turned(c.at[0], c.at[1], -rotation)
    o.origin, o.rotation = origin, rotation
    say_system(c)


def _set_tool(c: Controller, block: Block, form: int) -> None:
    number = block.whole("p")
    if number is None or number < 1:
        raise block.fault(f"G10 L{form} needs the number of a tool P", "p", "g.non-modal")
    tool = tool_of(c, number, block, "p")
    offset = _in_program_units(c, tool.offset)
    if form == 1:
        for letter in block.axes():
            offset[AXES.index(letter)] = block.values[letter]
    else:
        _touch_off(c, block, form, offset)
    diameter = 2.0 * block.values["r"] * c.unit() if "r" in block.values else tool.diameter
    angles = [math.radians(block.values[x]) if x in block.values else old
              for x, old in (("i", tool.front_angle), ("j", tool.back_angle))]  # fmt: skip
    q = block.whole("q")
    tool = tool._replace(
        offset=tuple(v * c.unit() if i in LINEAR else math.radians(v) for i, v in enumerate(offset)), diameter=diameter,
        front_angle=angles[0], back_angle=angles[1], orientation=tool.orientation if q is None else q,
    )  # fmt: skip
    c.tools[number] = tool
    places = [list(c.tools).index(number) + 1]
    if number == c.slot:
        c.tool = tool
        places.append(0)
    for place in places:
        c.out.append(Signal("SET_TOOL_TABLE_ENTRY", _entry(c, place, tool, offset), c.line, c.number))


def _touch_off(c: Controller, block: Block, form: int, offset: list[float]) -> None:
    """L10: the present coordinates become those of the axis words; L11: those in G59.3, without an axis offset."""
    place = to_machine(c.offsets, c.at)
    if form == 10:
        there = Offsets(0, c.offsets.origin, c.offsets.rotation, c.offsets.axis, offset)
    else:
        origin, rotation = system_of(c, 9)
        there = Offsets(9, origin, rotation, list(ZEROS), offset)
    _shift(offset, there.rotation, from_machine(there, place), block)


def _entry(c: Controller, place: int, tool: Tool, offset: list[float]) -> str:
    """A line of the tool table, in units of the machine."""
    lengths = " ".join(f"{round(value, 4) + 0.0:.4f}" for value in scaled(offset, c.machine_units()))
    degrees = ", ".join(f"{math.degrees(angle):.4f}" for angle in (tool.front_angle, tool.back_angle))
    return f"{place}, {tool.number}, {lengths}, {degrees}, {tool.orientation}"


def _no_polar(block: Block) -> None:
    for letter in "@^":
        if letter in block.values:
            raise block.fault("polar words (@ ^) are for motions", letter)
