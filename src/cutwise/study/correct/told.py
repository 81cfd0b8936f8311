"""What is said of a schedule: what it is held to, where limits exclude one another, and what no feed keeps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from cutwise import units
from cutwise.process.assemble_mill import spindle_limits
from cutwise.process.stock_plan import cutters_of
from cutwise.programs.block_text import block_named
from cutwise.spec.correct import LIMITED
from cutwise.study.correct.cells import BoolArray, FloatArray
from cutwise.study.correct.limits import CHIP_GUARD, Asked
from cutwise.study.correct.loads import NAMES, Allowed, binding, chips_of
from cutwise.study.correct.meridians import OF_SPINDLE, Turning

if TYPE_CHECKING:
    from cutwise.study.correct.feed import Ready

LEAST_CHIP = "chip_thickness_min"
_ROUNDED = 0.01  # of a feed, by which rounding down may miss what a least chip takes
_STEADY = 1e-3  # of the thickest chip, by which that of a neighbour may differ in a steady contact
_LISTED = 4  # lines that are named one by one


def said(ready: Ready, wanted: Asked, limits: Mapping[str, float], static: Mapping[str, float]) -> Iterator[str]:
    if wanted.guarded and "chip_thickness_max" in limits:
        yield (
            f"chips are held to {units.show(limits['chip_thickness_max'], 'small_length', 4)}, {CHIP_GUARD:g} times the thickest "
            f"of {_guard(limits, static)} (correct.limits.chip_thickness_max says otherwise)"
        )
    same = [name for name in sorted(wanted.equal) if name in static]
    if same:
        shown = ", ".join(f"{name} {units.show(static[name], LIMITED[name], 5)}" for name in same)
        yield f"held to what the run before has, the tip at rest: {shown}"
    yield from _of_spindle(ready, wanted, limits)
    if ready.scenario.stock is None:
        yield "without stock the contact is only what operation.radial_depth says: feeds may fall and not rise"
    for line, why in list(ready.bed.repeated.items())[:_LISTED]:
        yield f"{block_named(ready.program.text, line)}: {why}, and gets the least feed of all of them"
    kept = {line: one.why for line, one in ready.known.items() if not one.change}
    for line, why in list(kept.items())[:_LISTED]:
        yield f"{block_named(ready.program.text, line)}: keeps its feed: {why}"
    if len(kept) > _LISTED:
        yield f"{len(kept) - _LISTED} more lines keep their feeds for such reasons"
    if ready.scenario.operation.feed is not None:
        yield "operation.feed is left out of the new scenario: the feeds are those of the new program"
    if ready.scenario.material.law != "linear":
        yield "Kienzle's law is taken by its slopes at the chip of the program before the new one is simulated with the law itself"
    if any(tool.runout for tool in cutters_of(ready.scenario)):
        yield "run-out is left out of the schedule; the simulation of the new program has it"
    if ready.scenario.drives.control.block_time is None:
        yield f"{ready.scenario.drives_key}.control.block_time is not given: blocks may be as short as gains"


def _of_spindle(ready: Ready, wanted: Asked, limits: Mapping[str, float]) -> Iterator[str]:
    """What is held to the curves of the spindle; in 3D at the speed of every tool."""
    if isinstance(ready.cutting, Turning):
        for speed, caps in ready.cutting.caps.items():
            for name, most in caps.items():
                held, has = (units.show(one, LIMITED[name], 4) for one in (OF_SPINDLE * most, most))
                yield f"{name} is held to {held} at {units.show(speed, 'angular_speed', 5)}: the spindle has {has} there"
        return
    for name, most in spindle_limits(ready.scenario.drives, float(ready.cutting.spindle[0])).items():
        if name not in wanted.limits or wanted.limits[name] > limits[name]:
            held, has = (units.show(one, LIMITED[name], 4) for one in (limits[name], most))
            yield f"{name} is held to {held}: the spindle has {has} at its speed"


def _guard(limits: Mapping[str, float], static: Mapping[str, float]) -> str:
    """What the guard of the chip counts from."""
    least = limits.get(LEAST_CHIP, 0.0)
    return LEAST_CHIP if least > static.get("chip_thickness_max", 0.0) else "the run before"


def thin(ready: Ready, room: Allowed, feed: FloatArray, limits: Mapping[str, float]) -> Iterator[str]:
    """Where the thickest chip of a steady contact stays below what is asked for: the program does not keep the limit."""
    least = limits.get(LEAST_CHIP)
    if least is None:
        return
    lines = ready.bed.line
    missed = _too_thin(ready, room, feed) & _steady(ready)
    for line in np.unique(lines[missed])[:_LISTED].tolist():
        k = int(np.flatnonzero(missed & (lines == line))[0])
        where = block_named(ready.program.text, line)
        shown = [units.show(float(one[k]), "speed", 4) for one in (room.least, room.own, feed)]
        asked_for = f"{LEAST_CHIP} {units.show(least, 'small_length', 4)}"
        if room.least[k] > room.own[k] * (1.0 + _ROUNDED):
            which = NAMES[int(binding(room.each)[k])]
            yield (
                f"{where}: limits exclude one another: at least {shown[0]} ({asked_for}) and at most {shown[1]} ({which}); the "
                "upper one wins"
            )
        else:
            yield f"{where}: {asked_for} takes {shown[0]}, and the line keeps {shown[2]}"
    more = np.unique(lines[missed]).size - _LISTED
    if more > 0:
        yield f"{more} more lines have chips thinner than {LEAST_CHIP}"


def passing_thin(ready: Ready, room: Allowed, feed: FloatArray, limits: Mapping[str, float]) -> Iterator[str]:
    """How far chips are thin in all: where the tool comes in and goes out they are with any feed."""
    if LEAST_CHIP not in limits:
        return
    here = _too_thin(ready, room, feed)
    if here.any():
        length = ready.cells.length
        way, whole = (float(length[which].sum()) for which in (here, ready.cells.cuts))
        yield (
            f"chips stay thinner than {LEAST_CHIP} {units.show(limits[LEAST_CHIP], 'small_length', 4)} on "
            f"{units.show(way, 'length', 4)} of {units.show(whole, 'length', 4)} in the cut, first at "
            f"{block_named(ready.program.text, int(ready.bed.line[np.flatnonzero(here)[0]]))}; where the contact grows or "
            "shrinks, at entries and exits, it does not count"
        )


def _too_thin(ready: Ready, room: Allowed, feed: FloatArray) -> BoolArray:
    return np.asarray((room.least > feed * (1.0 + _ROUNDED)) & ready.cells.cuts & ~ready.bed.rapid)


def _steady(ready: Ready) -> BoolArray:
    """Cells whose thickest chip is that of both neighbours: no entry, no exit."""
    sine = chips_of(ready.cells, ready.cutting)
    alike = np.abs(np.diff(sine)) <= _STEADY * sine[1:]
    return np.asarray(ready.cells.cuts & np.append(False, alike) & np.append(alike, False))


def helpless(ready: Ready, wanted: Asked, room: Allowed, limits: Mapping[str, float]) -> Iterator[str]:
    """Limits that no feed keeps, because of what is there without feed."""
    for place in np.unique(room.helpless[room.helpless >= 0]).tolist():
        cells = np.flatnonzero(room.helpless == place)
        line = int(ready.bed.line[cells[0]])
        names = [name for name in limits if name.startswith(NAMES[place])]
        written = [name for name in names if name in wanted.limits] or names
        asked_for = ", ".join(f"{name} {units.show(limits[name], LIMITED[name], 4)}" for name in written)
        yield (
            f"no feed keeps {asked_for or NAMES[place]} at {block_named(ready.program.text, line)}: what the edges do alone, "
            "without any chip, is more"
        )
