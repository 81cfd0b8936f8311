"""``change: offset`` of drilled holes: the tool is led beside the hole and tilted, so that the hole is where it is wanted."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cutwise import units
from cutwise.io.revision import revisions
from cutwise.io.scenario import read_document
from cutwise.process.drilling import (
    NOT_LED,
    DrillCell,
    DrilledHole,
    Led,
    drill_cell,
    drill_one,
    drilled,
    hole_ends,
    led,
    led_to,
    place,
    targets,
)
from cutwise.process.posture import posture_at
from cutwise.spec.correct import Correction
from cutwise.spec.drilling import DrillingScenario
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.band import simulate
from cutwise.study.correct.outcome import Change, Proposal, Task
from cutwise.study.correct.uncertain import Draw, draws_of, share_80

_ENOUGH = 1e-9  # [m] of error that is not worth another repetition
_NOTHING = 1e-7  # [m]
_MOVED = ("hole.", "part.", "placement.", "robot.redundancy_angle", "robot.joint_angles")
"""Keys that say where an arm has to stand."""


def corrected(task: Task) -> Proposal:
    """Shift and tilt of every hole from what the process does to it, repeated in the posture that follows.

    Raises
    ------
    ScenarioFault
        No hole is drilled, or none is off.
    """
    scenario = task.scenario
    assert isinstance(scenario, DrillingScenario)
    before = holes_of(scenario)
    if not any(hole.outcome is not None for hole in before):
        raise ScenarioFault(
            [Fault(("correct", "change"), "offset: no hole can be drilled in this posture (cutwise run says why)")]
        )
    cell = drill_cell(scenario)
    worst = max(_errors(cell, hole)[0] for hole in before if hole.outcome is not None)
    if worst < _NOTHING:
        raise ScenarioFault(
            [Fault(("correct", "change"), f"offset: nothing is off: {units.show(worst, 'small_length', 3)}")]
        )
    _, judging = draws_of(scenario, task.said, 0)
    found = [_compensated(scenario, cell, hole, task.said) for hole in before]
    best = _with(scenario, found)
    after = holes_of(best)
    residuals = [_drawn(best, after, draw) for draw in judging]
    before_drawn = [_drawn(scenario, before, draw) for draw in judging]
    return Proposal(
        best,
        tuple(_changes(cell, before, after, found)),
        _measures(task.said, cell, before, after, found, residuals, before_drawn),
        tuple(_told(scenario, residuals, before_drawn)),
        tuple(_kept(scenario, task.said, cell, before, after)),
        after=simulate(best, None),
    )


def holes_of(scenario: DrillingScenario) -> list[DrilledHole]:
    """Every hole as a run drills it."""
    cell = drill_cell(scenario)
    moved = place(scenario, cell)[0]
    return [
        drill_one(scenario, cell, one._replace(position=one.position + moved), scenario.numerics.time_step, to)
        for one, to in zip(targets(scenario.hole), led_to(scenario.hole), strict=True)
    ]


def _errors(cell: DrillCell, hole: DrilledHole) -> tuple[float, float, float]:
    """Errors at entry and exit [m], and the tilt of the hole [rad]; infinite where the drill does not come."""
    assert hole.outcome is not None
    entry, out = hole_ends(cell, hole)
    first = float(np.hypot(*entry)) if hole.outcome.entered else math.inf
    last = float(np.hypot(*out)) if hole.outcome.through else math.inf
    tilt = float(np.hypot(*(out - entry))) / cell.cycle.thickness if hole.outcome.through else math.inf
    return first, last, tilt


def _compensated(scenario: DrillingScenario, cell: DrillCell, hole: DrilledHole, said: Correction) -> Led:
    """Where the tool has to be led: minus the error at the entry, and minus the slope of the hole; the same branch."""
    to, here = hole.led, hole
    if hole.posture is None:
        return to
    nominal = _nominal_posture(scenario, cell, hole)
    for _ in range(said.iterations):
        assert here.outcome is not None
        entry, out = hole_ends(cell, here)
        if not here.outcome.through or max(np.hypot(*entry), np.hypot(*out)) < _ENOUGH:
            break
        new = _step(scenario, cell, here)
        size = math.hypot(*new.shift)
        if size > said.shift_max:
            x, y = (part * said.shift_max / size for part in new.shift)
            new = new._replace(shift=(x, y))
        posture = led(scenario, cell, hole.target, nominal, new)
        if posture is None:
            break
        again = drilled(cell, here._replace(posture=posture, led=new), scenario.numerics.time_step)
        if _size(cell, again) >= _size(cell, here):
            break
        to, here = new, again
    return to


def _step(scenario: DrillingScenario, cell: DrillCell, hole: DrilledHole) -> Led:
    """Where the tool is led next: what a hole is off, taken from where it was led."""
    entry, out = hole_ends(cell, hole)
    upright = scenario.machine is not None
    slope = np.zeros(2) if upright else (out - entry) / cell.cycle.thickness
    shift = np.array(hole.led.shift) - (0.5 * (entry + out) if upright else entry)
    tilt = np.array(hole.led.tilt) - slope
    return Led((float(shift[0]), float(shift[1])), (float(tilt[0]), float(tilt[1])))


def _nominal_posture(scenario: DrillingScenario, cell: DrillCell, hole: DrilledHole) -> Any:
    """The posture at the hole itself, from which corrections are counted."""
    if hole.led == NOT_LED:
        return hole.posture
    return drill_one(scenario, cell, hole.target, scenario.numerics.time_step).posture


def _size(cell: DrillCell, hole: DrilledHole) -> float:
    return max(_errors(cell, hole)[:2])


def _with(scenario: DrillingScenario, found: Sequence[Led]) -> DrillingScenario:
    """The scenario with a correction for every hole."""
    document: dict[str, Any] = scenario.document()
    document["hole"] = {**document["hole"], "corrections": [
        {"shift": [units.text(x, "length") for x in one.shift], "tilt": [units.text(x, "angle") for x in one.tilt]}
        for one in found
    ]}  # fmt: skip
    new = read_document(document, scenario.name)
    assert isinstance(new, DrillingScenario)
    return new


def _drawn(scenario: DrillingScenario, holes: Sequence[DrilledHole], draw: Draw) -> tuple[float, float]:
    """Largest errors at entry and exit on another machine that runs the same program [m]; infinite: not through.

    An arm stands as the program has it, also where another posture would be the best of that other machine.
    """
    one = revisions(scenario)(draw)
    assert isinstance(one, DrillingScenario)
    cell = drill_cell(one)
    if scenario.robot is not None and not any(key.startswith(_MOVED) for key in draw):
        found = [_redrilled(cell, hole, one.numerics.time_step) for hole in holes]
    else:
        found = holes_of(one)
    ends = [(math.inf, math.inf) if hole.outcome is None else _errors(cell, hole)[:2] for hole in found]
    return max(end[0] for end in ends), max(end[1] for end in ends)


def _redrilled(cell: DrillCell, hole: DrilledHole, step: float) -> DrilledHole:
    """A hole drilled by another arm that stands alike."""
    if hole.posture is None:
        return hole
    assert cell.arm is not None
    return drilled(cell, hole._replace(posture=posture_at(cell.arm, hole.posture.angle, hole.posture.q)), step)


def _measures(
    said: Correction, cell: DrillCell, before: Sequence[DrilledHole], after: Sequence[DrilledHole], found: Sequence[Led],
    residuals: Sequence[tuple[float, float]], before_drawn: Sequence[tuple[float, float]],
) -> dict[str, tuple[float, str]]:  # fmt: skip
    done = [hole for hole in after if hole.outcome is not None]
    size = max(_size(cell, hole) for hole in before if hole.outcome is not None)
    left = max((_size(cell, hole) for hole in done), default=math.inf)
    values = {
        "residual_max": (left, "small_length"),
        "residual_ratio": (left / size, "dimensionless"),
        "shift_max": (max(math.hypot(*one.shift) for one in found), "small_length"),
        "tilt_max": (max(math.hypot(*one.tilt) for one in found), "angle"),
        "holes_corrected": (float(len(done)), "dimensionless"),
    }
    if residuals:
        values["residual_p80"] = (share_80([one[0] for one in residuals]), "small_length")
        values["residual_p80_exit"] = (share_80([one[1] for one in residuals]), "small_length")
        values["error_p80_before"] = (share_80([one[0] for one in before_drawn]), "small_length")
        values["probability_within"] = (
            float(np.mean([max(one) <= said.residual * size for one in residuals])), "dimensionless",
        )  # fmt: skip
    return {name: value for name, value in values.items() if math.isfinite(value[0])}


def _changes(
    cell: DrillCell, before: Sequence[DrilledHole], after: Sequence[DrilledHole], found: Sequence[Led]
) -> list[Change]:  # fmt: skip
    changes = []
    for number, (old, new, to) in enumerate(zip(before, after, found, strict=True), 1):
        if old.outcome is None or new.outcome is None or to == old.led:
            continue
        shift = ", ".join(units.show(x, "small_length", 5) for x in to.shift)
        tilt = ", ".join(f"{1e3 * x:.4f} mrad" for x in to.tilt)
        sizes = [" and ".join(units.show(x, "small_length", 4) for x in _errors(cell, one)[:2]) for one in (old, new)]
        changes.append(Change(
            f"hole {number}", f"{sizes[0]} off at entry and exit", sizes[1], f"led to ({shift}) and tilted by ({tilt}) in tool axes"
        ))  # fmt: skip
    return changes


def _told(
    scenario: DrillingScenario, residuals: Sequence[tuple[float, float]], before: Sequence[tuple[float, float]]
) -> list[str]:  # fmt: skip
    told = []
    if scenario.machine is not None:
        told.append("a machine does not tilt its spindle: entry and exit are centred, the slope of the hole stays")
    if residuals:
        old, new = (units.show(share_80([one[0] for one in some]), "small_length", 3) for some in (before, residuals))
        told.append(
            f"of {len(residuals)} machines that may be the true one four of five leave at most {new} at the entry ({old} before)"
        )
    else:
        told.append("nothing is said to vary (correct.vary, or correct.draws with a table): the residual is that of the nominal "
                    "machine alone")  # fmt: skip
    if scenario.robot is not None and not isinstance(scenario.robot.redundancy_angle, str):
        told.append("another posture may leave less without any shift: try robot.redundancy_angle: best first")
    if scenario.robot is not None and scenario.robot.errors is not None:
        told.append(
            "the geometric errors of the arm (robot.errors) are not in the shift; hole_position_error_total counts them"
        )
    return told


def _floor(scenario: DrillingScenario, said: Correction, cell: DrillCell, old: DrilledHole, new: DrilledHole) -> str:
    """What keeps a hole from being led further."""
    if math.hypot(*new.led.shift) >= said.shift_max * (1.0 - 1e-9):
        return f"; the shift is at correct.shift_max ({units.show(said.shift_max, 'small_length', 3)})"
    wanted = _step(scenario, cell, new)
    posture = _nominal_posture(scenario, cell, old)
    if scenario.robot is not None and led(scenario, cell, old.target, posture, wanted) is None:
        return "; led further, a joint would be beyond its limit, or the arm too near a singularity"
    return ""


def _kept(
    scenario: DrillingScenario, said: Correction, cell: DrillCell, before: Sequence[DrilledHole],
    after: Sequence[DrilledHole],
) -> list[str]:  # fmt: skip
    kept = []
    for number, (old, new) in enumerate(zip(before, after, strict=True), 1):
        if new.outcome is None:
            kept.append(f"hole {number} cannot be drilled")
            continue
        if not new.outcome.through:
            kept.append(f"hole {number}: the tip never comes through, there is no exit to correct")
            continue
        assert old.outcome is not None
        left, size = _size(cell, new), _size(cell, old)
        if left > said.residual * size and size > _NOTHING:
            shown = units.show(left, "small_length", 3), units.show(size, "small_length", 3)
            kept.append(
                f"hole {number}: {shown[0]} of {shown[1]} are left, more than correct.residual ({said.residual:g})"
                f"{_floor(scenario, said, cell, old, new)}"
            )
    return kept
