"""Warnings, limits and notes of milling with CNC drives."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from cutwise import units
from cutwise.process import carriers, milling_wall, part_cost, stock_moves, walls
from cutwise.process.assemble_mill import read_program
from cutwise.process.loops_drives import NO_FORCE
from cutwise.process.milling import MillRun, tip_limit
from cutwise.process.milling_measures import SETTLED
from cutwise.process.milling_stability import TipStability, stable_settings
from cutwise.process.stock_moves import collisions
from cutwise.programs.block_text import block_named
from cutwise.results import Finding, Place, Remedy, Said, warned
from cutwise.spec.drives import READINGS
from cutwise.spec.milling import MillingScenario

_LAST = 0.25  # of the time at the end point, in which a tool that has settled moves no more
_CREEP = 0.5e-6  # [m]
_WATCHED = 0.2  # [s] at least, before a tool that stands off its end point counts as held there by friction
_LISTED = 8  # joints named in the report
_THIN_MARGIN = math.radians(30.0)
_STOPS = 0.1  # share of the cycle time that full stops may cost without a warning

_COMMANDED = "The immersion is that of the commanded position; the chip load follows the actual velocity."
_RIGID = "The part is rigid, and so is the tool unless tool.modes are given; then the tip swings in the loop, tooth by tooth."
LIMITS = (
    _COMMANDED,
    "Without a stock the previous pass has the same shape, offset by the radial depth, and a cut is taken wherever a feed "
    "move runs below z = 0. With a stock contact is what earlier moves have left; what a ramp leaves stands in steps of "
    "height, and the end of the mill does not cut.",
    _RIGID,
    "The lobe diagram leaves the helix out; Kienzle's law is taken by its slope at the mean chip thickness there.",
    "No in-position wait at stops: the next block starts at once, so that a machine that waits takes longer.",
    "Drives: rigid transmission, ideal current loop; a z axis without a drive follows exactly.",
    "Linear-edge coefficients of one source; those of aluminium 7075 differ by ±40 % between sources.",
)


_OF_RIGID = frozenset({_COMMANDED, _RIGID})


def limits(done: MillRun) -> tuple[str, ...]:
    """What the model leaves out."""
    return LIMITS if done.wall is None else (*milling_wall.LIMITS, *(line for line in LIMITS if line not in _OF_RIGID))


def warnings(scenario: MillingScenario, done: MillRun, found: Mapping[str, float]) -> Iterator[Said]:
    """What should make the engineer doubt or change something."""
    machine = scenario.drives
    yield from part_cost.warnings(scenario, done)
    if found.get("saturation_time", 0.0) > 0.0:
        yield warned(
            "saturated", f"a controller is at its limit of {units.show(machine.control.saturation, 'voltage')} for "
            f"{units.show(found['saturation_time'], 'time', 3)}; lower feed, acceleration or jerk", found["saturation_time"], 0.0,
            "time",
        )  # fmt: skip
    for axis, figures in zip("xyz", done.loops, strict=False):
        if figures.sampled_phase_margin < _THIN_MARGIN:
            yield warned(
                "thin_margin",
                f"the position loop of {axis} has a phase margin of {math.degrees(figures.sampled_phase_margin):.1f}° "
                f"only (gain margin {20 * math.log10(figures.sampled_gain_margin):.1f} dB); usual is "
                f"{math.degrees(_THIN_MARGIN):.0f}° or more", figures.sampled_phase_margin, _THIN_MARGIN, "angle",
                where=Place(axis),
            )  # fmt: skip
    yield from _feeds(scenario, done)
    yield from _joints(done)
    yield from _stock(scenario, done)
    if done.wall is not None:
        yield from carriers.warnings(scenario, [done.wall.carriage], scenario.block)
        yield from walls.overload(scenario, done.wall.tangential[done.wall.counted])
    if "settling_overshoot" in found and "settling_time" not in found:
        yield warned(
            "not_settled", f"the tool does not stay within {units.show(SETTLED, 'small_length')} of the end point within "
            f"{units.show(scenario.numerics.settling_time, 'time')}: there is no settling_time (friction that sticks, encoder "
            "and backlash may hold it off for good; or lengthen numerics.settling_time)", found["settling_overshoot"],
            SETTLED, "small_length", remedy=Remedy("numerics.settling_time", "longer"),
        )  # fmt: skip


def _feeds(scenario: MillingScenario, done: MillRun) -> Iterator[Finding]:
    """A feed that the machine does not reach, and a path that is mostly stops."""
    path = done.path
    above = path.cuts & (path.feed > done.feed * (1.0 + 1e-9))
    if above.any():
        worst = int(np.argmax(np.where(above, path.feed / done.feed, 0.0)))
        yield warned(
            "feed_not_reached",
            f"the feed of {units.show(path.feed[worst], 'speed')} is above {scenario.drives_key}.limits.velocity: no more than "
            f"{units.show(done.feed[worst], 'speed')} is run, and the forces of the straight and the corner are those of it",
            float(path.feed[worst]), float(done.feed[worst]), "speed", where=Place(line=int(path.source[worst])),
        )  # fmt: skip
    share, corners, asked = done.stop_cost
    if share > _STOPS:
        parts = [f"{corners} at corners between blocks"] * (corners > 0)
        parts += [f"{asked} by exact stop (G61.1) or for a change of tool"] * (asked > 0)
        yield warned(
            "stops", f"full stops cost {share:.0%} of the cycle time, which goes into braking and starting again: "
            f"{' and '.join(parts)}; blend corners within a tolerance, for example path_mode: {{blend: 0.01 mm}} (G64 P)",
            share, _STOPS, remedy=Remedy("path_mode", "{blend: 0.01 mm}"),
        )  # fmt: skip


def _stock(scenario: MillingScenario, done: MillRun) -> Iterator[Finding]:
    """Moves that run into the stock as they should not, and contact above the flutes."""
    met, length = done.contact, scenario.tool.flute_length
    yield from stock_moves.said(met.into, _text(scenario), bottom=scenario.tool.end_core is not None)
    if scenario.stock is not None and length is not None and met.depth > length * (1 + 1e-9):
        yield warned(
            "shank_rubs", f"the stock stands {units.show(met.depth, 'length', 3)} above the tip, more than the flutes are long "
            f"({units.show(length, 'length', 3)}): the shank rubs", met.depth, length, "length",
        )  # fmt: skip


def _joints(done: MillRun) -> Iterator[Finding]:
    """Joints at which the jerk limit is exceeded, because the curvature jumps there."""
    steps = done.plan.curvature_steps / done.drives[0].law.sample_time
    over = np.flatnonzero(done.plan.curvature_steps > 1e-9)
    if over.size == 0:
        return
    knots = done.path.curve.knots
    listed = "; ".join(
        f"{units.show(steps[i], 'jerk', 3)} at {units.show(knots[i + 1], 'length', 4)}" for i in over[:_LISTED]
    )
    more = f" and {over.size - _LISTED} more" if over.size > _LISTED else ""
    yield warned(
        "jerk_exceeded",
        f"the normal acceleration jumps at {over.size} joint{'s' if over.size > 1 else ''} of line and arc, beyond the "
        f"jerk limit there (over one sample: {listed}{more})", float(steps[over].max()), dimension="jerk",
        where=Place(position=float(knots[over[0] + 1])),
    )  # fmt: skip


def notes(scenario: MillingScenario, done: MillRun) -> dict[str, str]:
    """The reading of the gains, margins of the loops, and where the worst place is."""
    machine = scenario.drives
    told = {"reading": f"{scenario.drives_key}.reading {machine.reading}: {READINGS[machine.reading]}."}
    told |= {
        f"loop_{axis}": f"{axis}: phase margin {math.degrees(f.phase_margin):.1f}° continuous, "
        f"{math.degrees(f.sampled_phase_margin):.1f}° sampled; "
        f"gain margin {_decibels(f.sampled_gain_margin)} up, {_decibels(f.least_gain)} down; "
        f"bandwidth {f.bandwidth:.1f} Hz continuous, {f.sampled_bandwidth:.1f} Hz sampled; "
        f"resonance {f.resonance:.2f}; damping {f.damping:.3f}; largest pole |z| {f.largest_pole:.5f}."
        for axis, f in zip("xyz", done.loops, strict=False)
    }
    if done.lost is None and np.isfinite(done.contour_error).any():
        worst = int(np.nanargmax(np.abs(done.contour_error)))
        x, y = done.history.position[worst, :2]
        line = int(done.path.source[done.reference.block[worst]])
        place = f", {block_named(_text(scenario), line)}" if line else ""
        side = "into the wall" if done.contour_error[worst] > 0 else "away from the wall"
        told["worst"] = (
            f"The path is left most at x = {units.show(x, 'length')}, y = {units.show(y, 'length')}{place}, "
            f"t = {units.show(done.reference.time[worst], 'time', 4)}, {side}."
        )
    feed, path = scenario.operation.feed, done.path
    if feed is not None and scenario.program is not None:
        others = int((np.isfinite(path.feed) & (path.feed != feed)).sum())
        told["feed"] = (
            f"operation.feed {units.show(feed, 'speed')} replaces the F of the moves that cut; {others} other feed "
            f"move{'s' * (others != 1)} (plunges, moves above the material) keep theirs."
        )
    if done.wall is not None:
        told |= milling_wall.notes(scenario, done.wall, done.reference, done.history)
    if done.path.cut_short:
        count = done.path.cut_short
        told["blends"] = (
            f"{count} blend{'s take' if count > 1 else ' takes'} half of a block, and not all that the tolerance allows: the "
            "blocks are short."
        )
    tolerance, at = done.path.kept_feed
    if tolerance > 0.0:
        told["kept_feed"] = (
            "G64 without P keeps the feed: each corner is rounded by the smallest arc over which acceleration and jerk allow "
            "the lower feed of its blocks, by a quarter of the shorter one at most; here by up to "
            f"{units.show(tolerance, 'small_length', 3)} (behind line {at} of the program)."
        )
    program = read_program(scenario)
    if program is not None and program.notices:
        told["program"] = "; ".join(program.notices)
    return told


def _text(scenario: MillingScenario) -> str:
    return "" if scenario.program is None else scenario.program.text


def _decibels(factor: float) -> str:
    """A factor on the gain; none if no factor that was looked at changes the stability."""
    return f"{20 * math.log10(factor):.1f} dB" if 0.0 < factor < math.inf else "without bound"


def unsound(
    scenario: MillingScenario, run: MillRun, steady: TipStability | None, *, helped: bool = True
) -> Iterator[Finding]:
    """Chatter, a tip that has swung away, a mill that cuts nothing, rapid moves through the stock, a tool still moving.

    ``helped``: what would be stable is looked for and run.
    """
    if steady is not None:
        yield from _chatter(scenario, steady, helped=helped)
    if run.lost is not None:
        yield Finding("tip_lost", Place(time=run.lost), limit=tip_limit(scenario), dimension="length")
    asked = run.cut.law != NO_FORCE or scenario.stock is not None
    if asked and not run.contact.immersion.any():
        yield Finding("untouched")
    yield from collisions(run.contact.into.collisions)
    if run.wall is not None:
        yield from milling_wall.findings(scenario, run.wall)
    yield from _moving(run)


def _chatter(scenario: MillingScenario, steady: TipStability, *, helped: bool) -> Iterator[Finding]:
    growing = {name: case.chatter.growth for name, case in steady.cases.items() if not case.chatter.stable}
    remedy = stable_settings(scenario, steady) if growing and helped else None
    for name, growth in growing.items():
        yield Finding("unstable", Place(name), growth, 1.0, measure=f"chatter_growth_{name}", remedy=remedy)


def _moving(run: MillRun) -> Iterator[Finding]:
    """A tool that is not at the end point when the run ends, and moves or was not watched long enough to be stuck."""
    after = run.reference.time >= run.reference.end
    if run.lost is not None or not after.any():
        return
    place = run.history.position[after, :2]
    last = place[int((1.0 - _LAST) * len(place)) :]
    away = float(np.hypot(*(last - run.reference.point[-1, :2]).T).max())
    watched = float(run.reference.time[-1]) - run.reference.end
    if away > SETTLED and (watched < _WATCHED or float(np.ptp(last, axis=0).max()) > _CREEP):
        yield Finding("unsettled", Place("the end point"), away, SETTLED, "small_length")
