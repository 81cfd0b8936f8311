"""Warnings, limits and notes of a program in a stock in 3D."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from cutwise import units
from cutwise.maths.solid import CELLS
from cutwise.process.nominal_part import tolerance_of
from cutwise.process.stock_deviation import Deviation, Judged, cut_off
from cutwise.process.stock_material import room_for
from cutwise.process.stock_measures import aside, checked
from cutwise.process.stock_milling import StockRunDone
from cutwise.process.stock_real import YIELDING, Cut, Real
from cutwise.process.stock_setups import Done
from cutwise.process.stock_stations import events, station_moves, station_places, time_beside
from cutwise.programs.block_text import block_named, blocks_named
from cutwise.results import Finding, Place, Remedy, Said, named, warned
from cutwise.spec.milling import MillingScenario
from cutwise.spec.notices import notices

_IDEAL = (
    "Tool, machine and part are rigid, and the planned path is swept: nothing in the scenario has drives or yields, or "
    "numerics.stock.sweep is ideal."
)
_REAL = (
    "The surface is that of the moved tool: drives under the mean force of the planned path, structures at rest under the mean "
    "force at the tip from what the moved tool has left; tilt, vibration and the ripple of the teeth "
    "are left out. Loads are those of the planned path."
)
_SEVERAL = (
    "Where several set-ups cut along different axes, the flutes are looked at in 16 layers; shank, holder and rapid moves are held "
    "against the highest material of each column, hollow below or not."
)
LIMITS = (
    "The stock is a height map seen along the tool axis: undercuts cannot be held.",
    "Forces are means over a revolution of a sharp tool at the programmed feed, no more than the machine allows; peaks are those "
    "of the teeth, with run-out but without vibration.",
    "Bottom edges cut with the coefficients of the flutes; measured ones depend on the radial engagement.",
    "Deviation of faces seen from behind along the tool axis is not judged.",
)
_DEEP_ENOUGH = 1e-13  # [m^3] that count as removed
_OFFSET = 0.5  # of the rms that a shift and turn take: then the part looks misplaced
_INCH = 25.4
_FIT = 0.02  # of the largest compliance
_STAND_OUT = 1e-6  # [m]


def limits(done: Done) -> tuple[str, ...]:
    """What the model leaves out."""
    several = len(done.cuts) + (len(done.earlier.sweeps) if done.earlier is not None else 0) > 1
    return (*LIMITS, _REAL if done.moved else _IDEAL, *((_SEVERAL,) if several else ()))


def findings(done: Done) -> Iterator[Finding]:
    """What leaves nothing to be judged."""
    if not any((cut.ideal.volume > _DEEP_ENOUGH).any() for cut in done.cuts):
        yield Finding("untouched")
    for line in [line for cut in done.cuts for line in cut.ideal.planned.path.still][:1]:
        yield Finding("at_rest", Place(line=line))


_EVENT = {
    "rapid": "rapid moves run through the stock",
    "shank": "shank or holder runs into the stock",
    "fixture": "the tool runs into a fixture",
    "core": "a tool that does not cut over centre goes down into material",
}


def warnings(scenario: MillingScenario, done: Done, off: Judged | None) -> Iterator[Said]:
    """What should make the engineer doubt or change something."""
    yield from notices(scenario)
    yield from dict.fromkeys(
        named(said, f"set-up {job.number}") if job.number else said
        for job, cut in zip(done.jobs, done.cuts, strict=True) for said in _of_setup(job.scenario, cut)
    )  # fmt: skip
    if off is not None:
        yield from _part_warnings(off.left)


def _of_setup(scenario: MillingScenario, cut: Cut) -> Iterator[Finding]:
    """Events, extents, grid and tools of one set-up."""
    done = cut.ideal
    text = done.planned.program.text
    happened = events(done)
    for kind, words in _EVENT.items():
        some = [event for event in happened if event.kind == kind]
        if some:
            worst = max(some, key=lambda event: event.depth)
            named = blocks_named(text, [event.line for event in some])
            deep = f", {_mm(worst.depth)} deep in line {worst.line} at {_at(worst.place)}" if worst.depth > 0.0 else ""
            where = Place(line=worst.line)
            yield warned(f"{kind}_in_stock", f"{words}: {named}{deep}", worst.depth, 0.0, "length", where=where)
    if done.start[1] > _STAND_OUT:
        depth = float(done.start[1])
        words = f"the tool stands in the stock where the program begins, {_mm(depth)} deep at {_at(done.start[2:5])}"
        yield warned("begins_in_stock", words, depth, _STAND_OUT, "length")
    yield from _extents(done)
    yield from _grid(scenario, done)
    yield from _no_shank(scenario)
    if done.filled > _DEEP_ENOUGH:
        words = (
            f"the stock has hollows that are closed from above ({units.show(done.filled, 'volume', 3)}): the map fills them up, so "
            "that the removed volume and the contact count them as material"
        )
        yield warned("hollows_filled", words, done.filled, _DEEP_ENOUGH, "volume")
    if cut.real is not None:
        yield from _real_warnings(scenario, cut.real)


def _real_warnings(scenario: MillingScenario, real: Real) -> Iterator[Finding]:
    """What makes the moved tool uncertain."""
    allowed = 0.1 * tolerance_of(scenario)
    if real.change is not None and real.change > allowed:
        words = (
            f"with pieces of {_mm(real.spacing)} instead of twice that the tool stands up to "
            f"{units.show(real.change, 'small_length', 3)} elsewhere, more than a tenth of the tolerance: write a shorter "
            "numerics.stock.station"
        )
        remedy = Remedy("numerics.stock.station", "shorter")
        yield warned("pieces_too_long", words, real.change, allowed, "small_length", remedy=remedy)
    if real.carrier is not None and real.carrier.missed > _FIT:
        words = (
            f"how {real.carrier.names[0]} yield along the program is no smooth function of the place: taken as one it is missed "
            f"by up to {100.0 * real.carrier.missed:.2g} %"
        )
        yield warned("not_smooth", words, real.carrier.missed, _FIT)
    if real.change is None and YIELDING & set(real.terms):
        yield warned("no_forces", "there are no forces of the cut: what yields stays where it is")


def _extents(done: StockRunDone) -> Iterator[Finding]:
    """A program that never meets the stock, or goes through its bottom."""
    moves, raw = done.moves, done.planned.raw
    cuts = done.volume > _DEEP_ENOUGH
    feed = ~moves.rapid[np.searchsorted(moves.path.first, np.arange(len(moves.start)), side="right") - 1]
    if not cuts.any():
        ends = np.concatenate([moves.start[feed], moves.end[feed]]) if feed.any() else moves.end
        low, high = ends.min(axis=0), ends.max(axis=0)
        said = ", ".join(
            f"{axis} {_span(low[k], high[k])} (stock {_span(*raw.box[k])})" for k, axis in enumerate("xyz")
        )
        yield warned("never_meets", f"the program never meets the stock: its feed moves reach {said}")
        ratio = max(high[:2] - low[:2]) / max(b - a for a, b in raw.box[:2])
        if 0.3 < ratio * _INCH < 3.0 or 0.3 < ratio / _INCH < 3.0:
            words = (
                "the sizes of program and stock differ by a factor near 25.4: one of them may be in inches (G20, G21)"
            )
            yield warned("inches", words, float(ratio))
        return
    bottom = raw.box[2][0]
    lowest = np.minimum.reduceat(np.minimum(moves.start[:, 2], moves.end[:, 2]), moves.path.first[:-1])
    through = np.flatnonzero(cuts & (lowest < bottom - _STAND_OUT))
    if through.size:
        lines = np.unique(moves.line[through]).tolist()
        deepest = int(through[np.argmin(lowest[through])])
        below, line = bottom - float(lowest[deepest]), int(moves.line[deepest])
        words = (
            f"moves go below the bottom of the stock, by {_mm(below)} in line {line} (is there a table?): "
            f"{blocks_named(done.planned.program.text, lines)}"
        )
        yield warned("below_stock", words, below, 0.0, "length", where=Place(line=line))


def _grid(scenario: MillingScenario, done: StockRunDone) -> Iterator[Finding]:
    allowed = 0.1 * tolerance_of(scenario)
    if done.coarsened:
        words = (
            f"the grid of {_mm(done.grid)} is wider than a quarter of the smallest tool radius and a hundredth of the stock: "
            "memory allows no more (numerics.stock.memory_limit)"
        )
        yield warned("grid_coarse", words, done.grid, dimension="length", where=Place("numerics.stock.memory_limit"))
    if done.check is not None and done.check.largest > allowed:
        x, y = done.check.x, done.check.y
        words = (
            f"the surface between cells is up to {units.show(done.check.largest, 'small_length', 3)} too high at "
            f"({1e3 * x:.4g}, {1e3 * y:.4g}) mm, more than a tenth of the tolerance: contact and force near there are uncertain; "
            f"write a finer grid (numerics.stock.grid, now {_mm(done.grid)})"
        )
        remedy = Remedy("numerics.stock.grid", "finer")
        yield warned("grid_coarse", words, done.check.largest, allowed, "small_length", remedy=remedy)


def _no_shank(scenario: MillingScenario) -> Iterator[Finding]:
    blind = [
        str(tool.number)
        for tool in scenario.tools
        if tool.flute_length is None or (not tool.holder and tool.shank_diameter is None)
    ]
    if blind:
        words = (
            f"of tool{'s' * (len(blind) > 1)} {', '.join(blind)} nothing is known above the edges (flute_length, shank_diameter, "
            f"holder): {'their' if len(blind) > 1 else 'its'} shank is not looked at"
        )
        yield warned("not_looked_at", words, where=Place(f"tool {', '.join(blind)}"))
    if scenario.tool is not None:
        words = (
            "nothing is known of the tool above its edges: shank and holder are not looked at (write it under tools)"
        )
        yield warned("not_looked_at", words, where=Place("tool"))


def _part_warnings(off: Deviation) -> Iterator[Said]:
    yield from off.samples.notices
    away, place = off.outside
    if away > max(off.tolerance or 0.0, _STAND_OUT):
        words = f"the part stands out of the stock by {_mm(away)} at {_at(place)}: check part.origin and part.rotation"
        yield warned("part_outside", words, away, dimension="length", where=Place("part.origin"))
    fit = off.fit
    if fit is not None and fit.before > 1e-7 and fit.after < (1.0 - _OFFSET) * fit.before:
        shift = ", ".join(f"{1e3 * v:.3g}" for v in fit.shift)
        turn = math.degrees(float(np.linalg.norm(fit.turn)))
        turned = f", turned by {turn:.2g}°" if turn > 1e-3 else ""
        words = (
            f"the deviation looks like an offset of ({shift}) mm{turned} of the machined surface, which takes "
            f"{100 * (1 - fit.after / fit.before):.0f} % of its rms: check part.origin and the work offset (G54)"
        )
        yield warned("looks_offset", words, fit.before - fit.after, dimension="length", where=Place("part.origin"))
    raw = [face.name for face in off.faces if not face.cut and max(abs(face.least), abs(face.most)) > _STAND_OUT]
    if raw:
        yield warned("not_machined", f"not machined, but off the part: {', '.join(raw)}", where=Place(", ".join(raw)))
    worst = max((abs(v) for face in off.faces for v in (face.least, face.most)), default=0.0)
    if cut_off(worst):
        words = "distances of more than 1 mm are told as 1 mm: gouge and excess volumes are too small there"
        yield warned("cut_off", words, worst, 1e-3, "length")


def notes(done: Done, off: Judged | None) -> dict[str, str]:
    """What the report says beside the numbers."""
    said: dict[str, str] = {}
    for job, cut in zip(done.jobs, done.cuts, strict=True):
        own = _setup_notes(job.scenario, cut)
        if job.number:
            own = {f"{name}, set-up {job.number}": f"set-up {job.number}: {text}" for name, text in own.items()}
        said |= own
    if done.earlier is not None:
        sweeps = f"{len(done.earlier.sweeps)} set-up(s), swept anew"
        said["earlier run"] = f"the stock is what {done.earlier.name} has left, {sweeps}"
    if off is not None:
        said |= _part_notes(off.left)
        if off.ideal is not None:
            value = off.ideal.value[off.ideal.judged_samples]
            said["ideal surface"] = (
                f"as planned the surface would deviate by {units.show(float(value.min()), 'small_length', 4)} to "
                f"{units.show(float(value.max()), 'small_length', 4)}, rms {units.show(off.ideal.rms, 'small_length', 4)}"
            )
    return said


def _setup_notes(scenario: MillingScenario, cut: Cut) -> dict[str, str]:
    """Method, grid, checks and the heaviest places of one set-up."""
    done = cut.ideal
    grid = done.solid.map.layout
    said = {
        "method": "the stock is a map in 3D: "
        + (
            "tools are given by their profiles"
            if scenario.tools
            else "a nominal part, another form of stock or fixtures ask for it"
        ),
        "grid": f"grid {_mm(grid.dx)} x {_mm(grid.dy)}, {grid.across} x {grid.along} cells"
        + f", about {_megabytes(scenario, done):.0f} MB with moves and samples"
        + (f" (halved once: the surface check at {_mm(done.grids[0])} was too large)" if len(done.grids) > 1 else ""),
        "sampling of the program": f"stations every {_mm(scenario.numerics.stock.station)}, {scenario.numerics.stock.elements} "
        f"elements below the cylinder, chords within {units.show(0.1 * tolerance_of(scenario), 'small_length', 3)}",
    }
    if done.planned.raw.kind == CELLS:
        half = _mm(0.5 * max(grid.dx, grid.dy))
        said["outline"] = f"the outline of the stock, from a file, holds to half a cell ({half})"
    said |= checked(done)
    if done.planned.said:
        said["taken for granted"] = "; ".join(done.planned.said)
    if done.planned.program.notices:
        said["program"] = "; ".join(done.planned.program.notices)
    said |= _heaviest(done)
    if any(tool.modes for tool in scenario.tools):
        said["vibration"] = (
            "not counted in a stock in 3D: the modes of a tool do not vibrate, they only bend it, by F/k"
        )
    if cut.real is not None:
        said |= _real_notes(cut.real)
    return said


def _real_notes(real: Real) -> dict[str, str]:
    """Where the tool stands beside its path most while it cuts, and what is sure of it."""
    words = {
        "drives": "feed drives",
        "runout": "run-out",
        "tip": "its bending at rest",
        "bodies": "bodies of the machine",
        "arm": "robot",
    }
    said = {"real surface": f"the tool is moved by {', '.join(words[name] for name in real.terms)}; pieces of "
            f"{_mm(real.spacing)} at the most"}  # fmt: skip
    if real.driven is not None:
        said["real surface"] += (
            f", what drives do is missed between them by up to {units.show(real.missed, 'small_length', 3)}"
        )
    if real.change is not None:
        said["real surface"] += (
            f"; with pieces twice as long it stands up to {units.show(real.change, 'small_length', 3)} elsewhere"
        )
    where = aside(real)
    if where.size:
        at = int(np.flatnonzero(real.done.stations("contact") > 0.0)[np.argmax(where)])
        segment = int(real.done.run.segment[at])
        off, known = (1e6 * one[segment, 0] for one in (real.off, real.known))
        line = block_named(real.done.planned.program.text, int(real.done.moves.line[station_moves(real.done)[at]]))
        said["tool beside its path"] = (
            f"the tool stands farthest beside its path at {_at(station_places(real.done)[at])}, {line}: "
            f"({off[0]:.3g}, {off[1]:.3g}, {off[2]:.3g}) µm, of which ({known[0]:.3g}, {known[1]:.3g}, {known[2]:.3g}) µm are "
            "known beforehand (drives, sag)"
        )
    return said


def _megabytes(scenario: MillingScenario, done: StockRunDone) -> float:
    """Memory of map, moves and samples."""
    samples = scenario.nominal.samples if scenario.nominal is not None else 0
    return 1e-6 * room_for(done.planned.raw, done.grid, done.moves.number, samples)


def _heaviest(done: StockRunDone) -> dict[str, str]:
    """Where the load is largest."""
    said, move = {}, station_moves(done)
    for name, column, dimension in (
        ("largest torque", "torque", "moment"), ("largest force in the plane", "force_xy_peak", "force"),
        ("thickest chip", "chip_thickness", "small_length"),
    ):  # fmt: skip
        values = done.stations(column)
        if values.size and values.max() > 0.0:
            at = int(np.argmax(values))
            line = block_named(done.planned.program.text, int(done.moves.line[move[at]]))
            said[name] = (
                f"{name} {units.show(float(values[at]), dimension, 3)} at {_at(station_places(done)[at])}, {line}"
            )
    return said


def _part_notes(off: Deviation) -> dict[str, str]:
    said = {
        "samples of the part": f"the part is looked at in {len(off.value)} points, about {_mm(off.samples.step)} apart; "
        f"judged area {1e6 * off.judged:.6g} mm²; positive is material left",
    }
    for name, gouge in (("deepest gouge", True), ("most material left", False)):
        at = off.worst(gouge)
        value = float(off.value[at])
        if (value < 0.0) if gouge else (value > 0.0):
            said[name] = f"{name}: {units.show(value, 'small_length', 4)} {made_by(off, at)}"
    if off.fit is not None:
        shift = ", ".join(f"{1e3 * v:.4g}" for v in off.fit.shift)
        turn = ", ".join(f"{math.degrees(v):.3g}" for v in off.fit.turn)
        before, after = (units.show(rms, "small_length", 3) for rms in (off.fit.before, off.fit.after))
        said["best fit"] = (
            f"best fit: shift ({shift}) mm, turn ({turn})° of the machined surface; rms {before} before, {after} after "
            "(nothing was aligned)"
        )
    return said


def made_by(off: Deviation, sample: int) -> str:
    """Where a sample is and which line, tool and time made the surface there."""
    place = f"at {_at(off.samples.point[sample])} on {off.samples.names[off.samples.face[sample]]}"
    if off.segment[sample] < 0:
        return f"{place}: the stock as it was"
    run, own = (int(found[0]) for found in off.owners.of(off.segment[sample : sample + 1]))
    if run < 0:
        return f"{place}: an earlier run"
    done, segment = off.owners.runs[run], own
    if len(off.owners.runs) > 1:
        place += f", set-up {run + 1}"
    line = int(done.planned.path.source[done.moves.block[segment]])
    move = int(np.searchsorted(done.moves.path.first, segment, side="right") - 1)
    tool = done.planned.tools.numbers
    named = f", T{tool[int(done.moves.tool[move])]}" if tool else ""
    frame = off.owners.frames[run]
    time = time_beside(done, segment, (off.samples.point[sample] - frame.zero) @ frame.axes)
    return f"{place}: {block_named(done.planned.program.text, line)}{named}, {units.show(time, 'time', 4)}"


def _mm(value: float) -> str:
    return units.show(value, "length", 3)


def _span(low: float, high: float) -> str:
    return f"{1e3 * low:.4g} to {1e3 * high:.4g} mm"


def _at(place: Any) -> str:
    return "(" + ", ".join(f"{1e3 * float(v) + 0.0:.4g}" for v in place) + ") mm"
