"""Variables of Fanuc macro B: local ones of each level of calls, common ones, and those of the control."""

from collections.abc import Callable
from dataclasses import dataclass, field

from cutwise.programs.controller import Controller, to_machine
from cutwise.programs.expressions import BlockFault

LOCAL = 33  # #1 to #33 belong to a level of macro calls
_COMMON = (range(100, 500), range(500, 1000))
_KEPT = range(500, 1000)  # keep their values when the power is off

_POSITIONS = (5001, 5041)  # end of the block before, present position: in work coordinates
_MACHINE = 5021
_OFFSETS = range(5221, 5327)  # origins of G54 to G59, 20 apart
_REFUSED = (  # what the control knows and a program alone does not say
    (range(1000, 1200), "tells of signals of the machine"),
    (range(2001, 2401), "is a tool offset"),
    (range(2500, 2800), "is a work offset"),
    (range(3000, 3001), "raises an alarm; it is only assigned"),
    (range(3001, 3003), "counts the time that the machine has run"),
    (range(3005, 3006), "is a setting of the control"),
    (range(3006, 3007), "stops with a message; it is only assigned"),
    (range(3007, 3009), "tells of mirror images"),
    (range(3011, 3013), "is the date or the time of day"),
    (range(3901, 3903), "counts parts"),
    (range(5061, 5081), "is where a probe has touched (G31)"),
    (range(5081, 5101), "is a tool offset in force"),
    (range(5101, 5121), "is a servo error"),
    (range(5201, 5221), "is the external work offset"),
    (range(7001, 7961), "is an additional work offset (G54.1)"),
    (range(10001, 14000), "is a tool offset"),
)


@dataclass(slots=True)
class MacroMemory:
    """All variables, as expressions see them from where the program is."""

    controller: Controller
    local: dict[int, float] = field(default_factory=dict)
    common: dict[int, float] = field(default_factory=dict)
    words: dict[str, float] = field(default_factory=dict)  # last values of D, H, M, T, and of N and O
    changes: int = 0  # how often a variable has changed

    def number(self, index: int, place: int) -> float | None:
        """A variable; None if it is vacant.

        Raises
        ------
        BlockFault
            There is none of that number, or its value is known to the machine only.
        """
        if index <= LOCAL:
            return self.local.get(index)
        if any(index in numbers for numbers in _COMMON):
            if index in _KEPT and index not in self.common:
                self.controller.notice(f"#{index} keeps its value from earlier programs; it is taken as vacant here")
            return self.common.get(index)
        known = self._state(index)
        if known is None:
            raise BlockFault(_why(index), place)
        return known

    def _state(self, index: int) -> float | None:
        c = self.controller
        for first in _POSITIONS:
            if first <= index < first + 6:
                return c.at[index - first]
        if _MACHINE <= index < _MACHINE + 6:
            return to_machine(c.offsets, c.at)[index - _MACHINE]
        if index in _OFFSETS and (index - _OFFSETS.start) % 20 < 6:
            return c.numbers.get(index, 0.0) / (c.machine_units() if (index - _OFFSETS.start) % 20 < 3 else 1.0)
        modal = _MODAL.get(index)
        return None if modal is None else modal(self)

    def assign(self, index: int, value: float | None, place: int) -> None:
        """Give a variable a value, or leave it vacant (None).

        Raises
        ------
        BlockFault
            It cannot be assigned.
        """
        if index == 0:
            raise BlockFault("#0 is always vacant; it cannot be assigned", place)
        if index in (3003, 3004):
            self.controller.notice(f"#{index} (single block, feed hold, exact stop) changes no path; it is left out")
            return
        if index <= LOCAL:
            known = self.local
        elif any(index in numbers for numbers in _COMMON):
            known = self.common
        else:
            remedy = "; write G10 L2 to set an origin" if 5201 <= index < 5327 else ""
            raise BlockFault(f"{_why(index)}; it cannot be assigned here{remedy}", place)
        if known.get(index) != value:
            self.changes += 1
        if value is None:
            known.pop(index, None)
        else:
            known[index] = value


def _why(index: int) -> str:
    for numbers, reason in _REFUSED:
        if index in numbers:
            return f"system variable #{index} {reason}, which is not known before the program runs on the machine"
    if index in _OFFSETS or 4001 <= index <= 4330 or 5001 <= index <= 5049:
        return f"system variable #{index} tells of the control's state"
    return f"there is no variable #{index}; programs use #1 to #{LOCAL} and #100 to #999"


def _cycle(m: MacroMemory) -> float:
    return m.controller.motion / 10 if m.controller.motion >= 730 else 80.0


def _word(letter: str) -> Callable[[MacroMemory], float]:
    return lambda m: m.words.get(letter, 0.0)


def _compensation(m: MacroMemory) -> float:
    on = m.controller.compensation
    return 40.0 if on is None else 41.0 if on.left else 42.0


_MODAL: dict[int, Callable[[MacroMemory], float]] = {
    4001: lambda m: m.controller.motion / 10 if m.controller.motion < 730 else 0.0,
    4002: lambda m: {"XY": 17.0, "XZ": 18.0, "YZ": 19.0}[m.controller.plane],
    4003: lambda m: 91.0 if m.controller.incremental else 90.0,
    4005: lambda m: float(m.controller.feed_mode),
    4006: lambda m: 20.0 if m.controller.inch else 21.0,
    4007: _compensation,
    4008: lambda m: 43.0 if any(m.controller.offsets.tool) else 49.0,
    4009: _cycle,
    4010: lambda m: 98.0 if m.controller.retract_to_start else 99.0,
    4014: lambda m: 53.0 + m.controller.offsets.system,
    4107: _word("d"),
    4109: lambda m: m.controller.feed,
    4111: _word("h"),
    4113: _word("m"),
    4114: _word("n"),
    4115: _word("o"),
    4119: lambda m: m.controller.spindle.speed,
    4120: _word("t"),
}
