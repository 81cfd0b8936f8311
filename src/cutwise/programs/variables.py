"""Variables of a program: numbered, named, and those that tell of the controller's state."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from cutwise.programs.controller import LINEAR, Controller, to_machine
from cutwise.programs.expressions import LAST_VARIABLE, BlockFault, variable_number

LOCAL = 30  # variables #1 to #30 belong to a subroutine

_POSITION, _TOOL, _DIAMETER = 5420, 5400, 5410
_MACHINE = 5021
_READ_ONLY = frozenset((*range(5021, 5030), *range(5400, 5414), *range(5420, 5429)))


@dataclass(slots=True)
class Memory:
    """All variables, as expressions see them from where the program is."""

    controller: Controller
    named_globals: dict[str, float] = field(default_factory=dict)
    named_locals: dict[str, float] = field(default_factory=dict)
    returned: float | None = None  # value of the last subroutine
    level: int = 0  # of subroutine calls
    changes: int = 0  # how often a variable has changed

    def number(self, index: int) -> float:
        """A numbered variable."""
        if index in _READ_ONLY:
            return self._state(index)
        return self.controller.numbers.get(index, _PRESET.get(index, 0.0))

    def _state(self, index: int) -> float:
        c = self.controller
        if index < _TOOL:
            return to_machine(c.offsets, c.at)[index - _MACHINE]
        if index >= _POSITION:
            return c.at[index - _POSITION]
        if index == _TOOL:
            return float(c.tool.number)
        if index == _DIAMETER:
            return c.tool.diameter / c.unit() * c.machine_units()
        if index > _DIAMETER:
            angles = (math.degrees(c.tool.front_angle), math.degrees(c.tool.back_angle), float(c.tool.orientation))
            return angles[index - _DIAMETER - 1]
        i = index - _TOOL - 1
        value = c.tool.offset[i]
        return value / c.unit() * c.machine_units() if i in LINEAR else math.degrees(value)

    def named(self, name: str) -> float:
        """A named variable; raises KeyError where there is none."""
        known = _STATE.get(name)
        if known is not None:
            return float(known(self))
        return (self.named_globals if name.startswith("_") else self.named_locals)[name]

    def exists(self, key: int | str) -> bool:
        """Whether there is such a variable."""
        if isinstance(key, int):
            return 1 <= key <= LAST_VARIABLE
        return key in _STATE or key in (self.named_globals if key.startswith("_") else self.named_locals)

    def value(self, key: int | str) -> float | None:
        """A variable by number or name; None where there is none."""
        if not self.exists(key):
            return None
        return self.number(key) if isinstance(key, int) else self.named(key)

    def assign(self, key: float | str, value: float, place: int) -> None:
        """Give a variable a value.

        Raises
        ------
        BlockFault
            It tells of the controller's state, or there is none of that number.
        """
        if isinstance(key, str):
            if key in _STATE:
                raise BlockFault(f"#<{key}> tells of the machine; it cannot be assigned", place)
            known = self.named_globals if key.startswith("_") else self.named_locals
            self.changes += known.get(key) != value
            known[key] = value
            return
        index = variable_number(key, place)
        if index in _READ_ONLY:
            raise BlockFault(f"#{index} tells of the machine; it cannot be assigned", place)
        self.changes += self.controller.numbers.get(index, 0.0) != value
        self.controller.numbers[index] = value


_PRESET = {5220: 1.0, 5599: 1.0}


def _abs(i: int) -> Callable[[Memory], float]:
    return lambda m: to_machine(m.controller.offsets, m.controller.at)[i]


def _at(i: int) -> Callable[[Memory], float]:
    return lambda m: m.controller.at[i]


def _compensation(m: Memory) -> float:
    on = m.controller.compensation
    return 400.0 if on is None else 410.0 if on.left else 420.0


_STATE: dict[str, Callable[[Memory], float]] = {
    "_vmajor": lambda m: 2.9,  # noqa: ARG005
    "_vminor": lambda m: 0.0,  # noqa: ARG005
    "_line": lambda m: m.controller.file_line,
    "_motion_mode": lambda m: m.controller.motion,
    "_plane": lambda m: {"XY": 170, "XZ": 180, "YZ": 190}[m.controller.plane],
    "_ccomp": _compensation,
    "_metric": lambda m: not m.controller.inch,
    "_imperial": lambda m: m.controller.inch,
    "_absolute": lambda m: not m.controller.incremental,
    "_incremental": lambda m: m.controller.incremental,
    "_inverse_time": lambda m: m.controller.feed_mode == 93,
    "_units_per_minute": lambda m: m.controller.feed_mode == 94,
    "_units_per_rev": lambda m: m.controller.feed_mode == 95,
    "_coord_system": lambda m: 530 + 10 * m.controller.offsets.system if m.controller.offsets.system < 7 else
    584 + m.controller.offsets.system,
    "_tool_offset": lambda m: any(m.controller.offsets.tool),
    "_retract_r_plane": lambda m: not m.controller.retract_to_start,
    "_retract_old_z": lambda m: m.controller.retract_to_start,
    "_spindle_rpm_mode": lambda m: not m.controller.spindle.surface_limit,
    "_spindle_css_mode": lambda m: bool(m.controller.spindle.surface_limit),
    "_ijk_absolute_mode": lambda m: m.controller.arc_absolute,
    "_lathe_diameter_mode": lambda m: 0.0,  # noqa: ARG005
    "_lathe_radius_mode": lambda m: 1.0,  # noqa: ARG005
    "_spindle_on": lambda m: bool(m.controller.spindle.turning),
    "_spindle_cw": lambda m: m.controller.spindle.turning == 1,
    "_mist": lambda m: m.controller.switches.mist,
    "_flood": lambda m: m.controller.switches.flood,
    "_speed_override": lambda m: m.controller.switches.speed_override,
    "_feed_override": lambda m: m.controller.switches.feed_override,
    "_adaptive_feed": lambda m: m.controller.switches.adaptive_feed,
    "_feed_hold": lambda m: m.controller.switches.feed_hold,
    "_feed": lambda m: m.controller.feed,
    "_rpm": lambda m: m.controller.spindle.speed,
    "_current_tool": lambda m: m.controller.tool.number,
    "_current_pocket": lambda m: m.controller.tool.pocket,
    "_selected_tool": lambda m: m.controller.selected,
    "_selected_pocket": lambda m: m.controller.selected or -1,
    "_value": lambda m: m.returned or 0.0,
    "_value_returned": lambda m: m.returned is not None,
    "_task": lambda m: 0.0,  # noqa: ARG005
    "_call_level": lambda m: m.level,
    "_remap_level": lambda m: 0.0,  # noqa: ARG005
    **{f"_{axis}": _at(i) for i, axis in enumerate("xyzabcuvw")},
    **{f"_abs_{axis}": _abs(i) for i, axis in enumerate("xyzabcuvw")},
}  # fmt: skip
