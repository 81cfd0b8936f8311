"""Warnings, limits and notes of milling with CNC drives."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from cutwise import units
from cutwise.process.milling import MillRun
from cutwise.spec.drives import READINGS
from cutwise.spec.milling import MillingScenario

_LISTED = 8  # joints named in the report
_THIN_MARGIN = math.radians(20.0)
_MOVED = 0.05e-6  # [m] change of the contour error with twice the substeps that is worth a warning

LIMITS = (
    "The immersion is that of the commanded position; the chip load follows the actual velocity.",
    "Without a stock the previous pass has the same shape, offset by the radial depth, and a cut is taken wherever a feed "
    "move runs below z = 0. With a stock contact is what earlier moves have left; ramps clear by steps of height, and the "
    "end of the mill does not cut.",
    "The part is rigid, and so is the tool unless tool.modes are given; then the tip swings in the loop, tooth by tooth.",
    "The lobe diagram leaves the helix out; Kienzle's law is taken by its slope at the mean chip thickness there.",
    "No in-position wait at stops: the next block starts at once, so that a machine that waits takes longer.",
    "Drives: rigid transmission, ideal current loop; the z axis follows exactly.",
    "Linear-edge coefficients of one source; those of aluminium 7075 differ by ±40 % between sources.",
)


def warnings(scenario: MillingScenario, done: MillRun, found: Mapping[str, float]) -> Iterator[str]:
    """What should make the engineer doubt or change something."""
    if found["saturation_time"] > 0.0:
        yield (
            f"a controller is at its limit of {units.show(scenario.machine.control.saturation, 'voltage')} for "
            f"{units.show(found['saturation_time'], 'time', 3)}; lower feed, acceleration or jerk"
        )
    for axis, figures in zip("xy", done.loops, strict=True):
        if figures.sampled_phase_margin < _THIN_MARGIN:
            yield (
                f"the position loop of {axis} has a phase margin of {math.degrees(figures.sampled_phase_margin):.1f}° "
                f"only (gain margin {20 * math.log10(figures.sampled_gain_margin):.1f} dB); usual is 30° or more"
            )
    yield from _joints(done)
    yield from _stock(scenario, done)
    for where, name in (("on the straight", "straight"), ("in the heaviest contact", "corner")):
        growth, stable = found.get(f"chatter_growth_{name}", 0.0), found.get(f"stable_depth_{name}")
        if growth >= 1.0:
            limit = f" (stable below {units.show(stable, 'length', 3)})" if stable is not None else ""
            yield (
                f"the tool chatters {where}: vibration grows by {growth:.3g} per tooth; reduce the axial depth{limit} or "
                "change the spindle speed"
            )


def _stock(scenario: MillingScenario, done: MillRun) -> Iterator[str]:
    """Moves that run into the stock as they should not, and contact above the flutes."""
    met, length = done.contact, scenario.tool.flute_length
    if met.collisions:
        yield f"rapid moves run through the stock: {_listed_lines(met.collisions)}"
    if met.plunges:
        yield f"plunges straight into the stock have no force here (end cutting is not modelled): {_listed_lines(met.plunges)}"
    if scenario.stock is not None and length is not None and met.depth > length * (1 + 1e-9):
        yield (
            f"the stock stands {units.show(met.depth, 'length', 3)} above the tip, more than the flutes are long "
            f"({units.show(length, 'length', 3)}): the shank rubs"
        )


def _listed_lines(lines: tuple[int, ...]) -> str:
    shown = ", ".join(str(line) for line in lines[:_LISTED])
    more = f" and {len(lines) - _LISTED} more" if len(lines) > _LISTED else ""
    return f"line{'s' if len(lines) > 1 else ''} {shown}{more} of the program"


def _joints(done: MillRun) -> Iterator[str]:
    """Joints at which the jerk limit is exceeded, because the curvature jumps there."""
    steps = done.plan.curvature_steps / done.drives.law_x.sample_time
    over = np.flatnonzero(done.plan.curvature_steps > 1e-9)
    if over.size == 0:
        return
    knots = done.path.curve.knots
    listed = "; ".join(
        f"{units.show(steps[i], 'jerk', 3)} at {units.show(knots[i + 1], 'length', 4)}" for i in over[:_LISTED]
    )
    more = f" and {over.size - _LISTED} more" if over.size > _LISTED else ""
    yield (
        f"the normal acceleration jumps at {over.size} joint{'s' if over.size > 1 else ''} of line and arc, beyond the "
        f"jerk limit there (over one sample: {listed}{more})"
    )


def changed(change: Mapping[str, float]) -> Iterator[str]:
    """A result that still moves with more substeps."""
    moved = change.get("contour_error_max", 0.0)
    if abs(moved) > _MOVED:
        shown = units.show(moved, "small_length", 3)
        yield f"contour_error_max moves by {shown} with twice the substeps; use more of them"


def notes(scenario: MillingScenario, done: MillRun, program_notices: tuple[str, ...]) -> dict[str, str]:
    """The reading of the gains, margins of the loops, and where the worst place is."""
    machine = scenario.machine
    told = {"reading": f"machine.reading {machine.reading}: {READINGS[machine.reading]}."}
    told["loops"] = " ".join(
        f"{axis}: phase margin {math.degrees(f.phase_margin):.1f}° continuous, "
        f"{math.degrees(f.sampled_phase_margin):.1f}° sampled; "
        f"gain margin {20 * math.log10(f.sampled_gain_margin):.1f} dB; "
        f"bandwidth {f.bandwidth:.1f} Hz continuous, {f.sampled_bandwidth:.1f} Hz sampled; "
        f"resonance {f.resonance:.2f}; damping {f.damping:.3f}; largest pole |z| {f.largest_pole:.5f}."
        for axis, f in zip("xy", done.loops, strict=True)
    )
    if np.isfinite(done.contour_error).any():
        worst = int(np.nanargmax(np.abs(done.contour_error)))
        x, y = done.history.position[worst]
        line = int(done.path.source[done.reference.block[worst]])
        place = f" (line {line} of the program)" if line else ""
        side = "into the wall" if done.contour_error[worst] > 0 else "away from the wall"
        told["worst"] = (
            f"The path is left most at x = {units.show(x, 'length')}, y = {units.show(y, 'length')}{place}, "
            f"t = {units.show(done.reference.time[worst], 'time', 4)}, {side}."
        )
    if program_notices:
        told["program"] = "; ".join(program_notices)
    return told
