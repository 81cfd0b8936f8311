"""``change: path``: coordinates moved against what drives and a bending tool make of the path."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.revision import revisions
from cutwise.maths.curves import FloatArray
from cutwise.process.assemble_mill import cut, feed_drives
from cutwise.process.milling import Commanded, commanded, followed
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import MillingScenario
from cutwise.study.band import simulate
from cutwise.study.correct import chance
from cutwise.study.correct.bent import bends, told_of, walls_of
from cutwise.study.correct.corners import sharp_corners
from cutwise.study.correct.level import cut_level, stretches
from cutwise.study.correct.outcome import Along, Change, Proposal, Task
from cutwise.study.correct.prove import chatters
from cutwise.study.correct.readings import other_readings
from cutwise.study.correct.shift import Learned, Plant, Seen, behind_stop, judged, learn, rule_of, seen, step_of, window
from cutwise.study.correct.uncertain import Draw, draws_of, share_80
from cutwise.study.correct.written import Written, as_program, chord_of, from_wanted, largest, written

_MEASURE = "contour_error_max"
_WALLS = ("wall_error_min", "wall_error_max")  # held too where the tool bends
_CUT = ("material.", "tool.stiffness", "tool.modes", "tool.runout")  # keys that change the force, and no path
_PROOFS = 3  # repetitions on the written program, which is read and planned again each time
_NOTHING = 0.1e-6  # [m] error that is not worth a shift
_SETS_OUT = 1e-3  # [m] behind the place at which a cut begins


class Before(NamedTuple):
    """What there is before a path is shifted."""

    seen: Seen  # of the nominal machine
    plant: Plant
    size: float  # largest error where a shift is judged [m]
    chance: chance.Left


def corrected(task: Task) -> Proposal:
    """A program whose chords make drives and tool follow the wanted path, proved by reading and running it.

    Raises
    ------
    ScenarioFault
        Nothing moves the tool off its path, a line cannot be written as chords, or an undecided reading of the machine's
        data decides how the path has to be shifted.
    """
    given = task.scenario
    assert isinstance(given, MillingScenario)
    _refuse(given, task.said)
    if bends(given) and chatters(task.before):
        raise ScenarioFault([Fault(("correct", "change"), "path: the tool chatters, and what it leaves of a wall is no error that "
                                   "a path could take away; change: [speed, feed] looks for a stable cut")])  # fmt: skip
    scenario = from_wanted(as_program(given))
    said = task.said
    told = commanded(scenario, scenario.numerics.substeps)
    nominal = Plant(scenario, told, walls_of(scenario, told))
    before = seen([nominal], told.order)
    size = largest(told, before.worst, whole=nominal.walls is not None)
    if size < _NOTHING:
        raise ScenarioFault([Fault(("correct", "change"), "path: nothing moves the tool off its path: the largest contour error "
                                   f"is {units.show(size, 'small_length', 3)}")])  # fmt: skip
    fitted, judging = draws_of(scenario, said)
    plants = [_drawn(nominal, draw) for draw in fitted] or [nominal]
    left = chance.left_alone(nominal, plants, fitted, _drawn)
    rule = rule_of(told, scenario.drives.limits.jerk, said.lead, said.smoothing)
    found = learn(plants, rule, said.iterations, said.shift_max, _part(task.progress, 0.2, 0.6), left.error)
    best, found = _proved(nominal, found, plants, said)
    undecided = other_readings(best, _tolerance(best.scenario, size, said))
    whole = best.walls is not None
    residuals = [
        largest(best.told, seen([_drawn(best.plant, one)], best.told.order).worst, whole=whole) for one in judging
    ]
    return _proposal(task, best, found, Before(before, nominal, size, left), residuals, undecided)


def _refuse(scenario: MillingScenario, said: Correction) -> None:
    walls = _WALLS if bends(scenario) else ()
    others = [] if "feed" in said.change else [name for name in said.limits if name not in (_MEASURE, *walls)]
    if others:
        raise ScenarioFault([
            Fault(("correct", "limits", name), f"is not held by change: path, which moves coordinates; "
                  f"{' and '.join((_MEASURE, *walls))} {'are' if walls else 'is'}")
            for name in others
        ])  # fmt: skip
    why = None
    if scenario.in_3d:
        why = (
            "what drives make of a path is learned for one flat mill in a block or without a stock; a stock in 3D (tools, nominal "
            "part, fixtures, set-ups, a map) is not covered yet"
        )
    elif scenario.programmed:
        why = (
            "a tool that goes as programmed leaves its path by no drives, and a straight wall (path.line) has no program that "
            "could be moved: write the wall as a program (G1), with a machine that has drives (x, y, control)"
        )
    elif scenario.line is not None:
        why = (
            "a straight line has nothing to follow, and no program that could be moved; give a program (of a wall: G1 with "
            "tool.stiffness) or path.corner"
        )
    if why is not None:
        raise ScenarioFault([Fault(("correct", "change"), f"path: {why}")])


def _drawn(like: Plant, draw: Draw) -> Plant:
    """The machine and cut of one draw; what is told to the drives stays, unless the draw changes the path itself."""
    scenario, told, walls = like
    one = revisions(scenario)(draw)
    assert isinstance(one, MillingScenario)
    drives = tuple(f"{scenario.drives_key}.{axis}." for axis in "xyz")
    if all(key.startswith((*drives, *_CUT)) for key in draw):
        return Plant(one, told._replace(
            drives=feed_drives(one.drives, one.drives_key), cut=cut(one, told.cut.spindle, told.contact.depth)
        ), walls)  # fmt: skip
    other = commanded(one, one.numerics.substeps)
    return Plant(one, other, walls_of(one, other))


def _proved(
    nominal: Plant, found: Learned, plants: Sequence[Plant], said: Correction
) -> tuple[Written, Learned]:  # fmt: skip
    """The best written program: the learned shift, and repetitions on what is read back from the text."""
    scenario, told, walls = nominal
    best = written(scenario, told, found, said, walls)
    kept = found
    last, shift = best, found
    tries = 2 if sharp_corners(told.wanted).size else 1  # what is led to a corner anew may at first be worse
    for _ in range(_PROOFS * tries):
        if best.residual <= 0.0 or last.chords == 0:
            break
        here = last.told
        one = seen(_told_alike(plants, last), here.order)
        active = window(here, whole=shift.whole)
        error = one.error.mean(axis=0) - shift.kept_at(here.place.travelled)
        moved = step_of(here, shift.at(here.place.travelled), error, one.bend.mean(axis=0), shift.rule, active)
        moved = np.clip(moved, -said.shift_max, said.shift_max)
        along, first = np.unique(here.place.travelled, return_index=True)
        shift = shift._replace(along=along, shift=moved[first], kept=shift.kept_at(along))
        last = written(scenario, told, shift, said, walls)
        if _mean_size(plants, last, shift) < 0.98 * _mean_size(plants, best, kept):
            best, kept = last, shift
            continue
        tries -= 1
        if not tries:
            break
    return best, kept


def _told_alike(plants: Sequence[Plant], made: Written) -> list[Plant]:
    """Plants that are told the written program."""
    return [
        one._replace(told=made.told._replace(drives=one.told.drives, cut=one.told.cut)) for one in plants
    ]  # fmt: skip


def _mean_size(plants: Sequence[Plant], made: Written, found: Learned) -> float:
    """Largest mean error of the plants that the shift is made for [m]."""
    error = seen(_told_alike(plants, made), made.told.order).error.mean(axis=0)
    return largest(made.told, error - found.kept_at(made.told.place.travelled), whole=found.whole)


def _proposal(
    task: Task, best: Written, found: Learned, first: Before, residuals: list[float], undecided: tuple[str, ...]
) -> Proposal:  # fmt: skip
    said, size, left, told = task.said, first.size, best.residual, first.plant.told
    after = simulate(best.scenario, None)
    whole = after.measures[_MEASURE].value
    most = float(np.abs(found.shift).max())
    values: dict[str, tuple[float, str]] = {
        "residual_max": (left, "small_length"),
        "residual_ratio": (left / size, "dimensionless"),
        "shift_max": (most, "small_length"),
        "convergence": (max(found.rule.convergence), "dimensionless"),
        "repetitions": (float(len(found.trail) - 1), "dimensionless"),
        "blocks_before": (float(told.path.curve.count), "dimensionless"),
        "blocks_after": (float(best.told.path.curve.count), "dimensionless"),
        **_wall_values(first, best, found),
        **first.chance.measures(),
    }
    if residuals:
        values["residual_p80"] = (share_80(residuals), "small_length")
        tolerance = _tolerance(best.scenario, size, said)
        values["probability_within"] = (float(np.mean(np.array(residuals) <= tolerance)), "dimensionless")
    return Proposal(
        best.scenario,
        (_change(best, found, size, left),),
        values,
        (
            *_told(found, best, size, residuals),
            *_bent(first, best, found),
            *first.chance.told(),
            *best.left,
            *_grown(best, said),
            *_elsewhere(best, whole),
            *undecided,
        ),
        tuple(_kept(task, best, found, size, left, whole, values)),
        (_along(best, first.seen.error[0], told),),
        after,
    )


def _change(best: Written, found: Learned, before: float, after: float) -> Change:
    most = units.show(float(np.abs(found.shift).max()), "small_length", 3)
    what, why = (_MEASURE, "the drives") if best.walls is None else ("error of path and walls", "drives and tool")
    return Change(
        what, units.show(before, "small_length", 4), units.show(after, "small_length", 4),
        f"the path is moved by up to {most} against what {why} make of it, in {best.chords} chords",
    )  # fmt: skip


def _told(found: Learned, best: Written, before: float, residuals: list[float]) -> list[str]:
    rule, step = found.rule, best.told.drives[0].law.sample_time
    each = " and ".join(f"{c:.3g} ({axis})" for axis, c in zip("xy", rule.convergence, strict=False))
    told = [
        f"learned in {len(found.trail) - 1} repetitions with a lead of {units.show(rule.lead * step, 'time', 3)} and a smoothing "
        f"of {units.show(rule.smoothing * step, 'time', 3)}; a repetition leaves at most c = {each} of a wave of the error"
    ]
    if max(rule.convergence) >= 1.0:
        told.append(
            "c is not below 1: more repetitions would make some waves of the error larger; the best one is kept"
        )
    if not residuals:
        told.append("nothing is said to vary (correct.vary, or correct.draws with a table): the residual is that of the "
                    "nominal machine alone")  # fmt: skip
    else:
        told.append(
            f"of {len(residuals)} machines that may be the true one four of five leave at most "
            f"{units.show(share_80(residuals), 'small_length', 3)} of {units.show(before, 'small_length', 3)}"
        )
    told.append("errors count from the program before (program.wanted)")
    return told


def _grown(best: Written, said: Correction) -> list[str]:
    """Chords that are longer than asked for."""
    spacing = chord_of(best.scenario, best.told, said)
    if spacing <= said.chord * (1.0 + 1e-9):
        return []
    shown = units.show(spacing, "length", 3), units.show(said.chord, "length", 3)
    return [f"chords are {shown[0]} long, not {shown[1]}: shorter ones would be less than machine.control.block_time"]


def _bent(first: Before, best: Written, found: Learned) -> Iterator[str]:
    """What the tool bends by, and what of it no path takes away."""
    if first.plant.walls is None:
        if bends(first.plant.scenario):
            yield "the tool bends, and leaves no wall that stays: nothing is moved for it"
        return
    yield from told_of(first.plant.scenario, first.plant.walls)
    yield f"a shift moves the walls by {1.0 / found.rule.gain:.4g} of itself: steps are {found.rule.gain:.4g} times the error"
    yield f"the path is off on purpose: {_MEASURE} counts the shift against the bend of the tool"
    half = largest(best.told, best.seen.half[0], whole=True)
    if half > _NOTHING:
        yield (f"what is bent differently over the height of a wall, or swings, is up to ± {units.show(half, 'small_length', 3)}: "
               "no shift of the path takes that away")  # fmt: skip


def _wall_values(first: Before, best: Written, found: Learned) -> dict[str, tuple[float, str]]:
    """Errors of walls that stay, into the part, before and after; a run of a tip that swings has its own."""
    if best.walls is None:
        return {}
    values: dict[str, tuple[float, str]] = {"wall_gain": (1.0 / found.rule.gain, "dimensionless")}
    for when, told, one in (("before", first.plant.told, first.seen), ("after", best.told, best.seen)):
        into = one.into[0][judged(told, whole=True)]
        if np.isfinite(into).any():
            values[f"wall_error_min_{when}"] = float(np.nanmin(into[:, 0])), "small_length"
            values[f"wall_error_max_{when}"] = float(np.nanmax(into[:, 1])), "small_length"
    return values


def _elsewhere(best: Written, whole: float) -> list[str]:
    """An error that is larger where nothing is shifted."""
    if best.walls is not None:  # a contour error there holds against the bend of the tool
        whole = float((best.seen.worst[0] * (best.told.contact.immersion > 0.0)).max(initial=0.0))
    if whole <= best.residual * (1.0 + 1e-9):
        return []
    error = best.seen.worst[0] * (best.told.contact.immersion > 0.0 if best.walls is not None else 1.0)
    worst = int(np.argmax(error))
    line = int(best.told.path.source[best.told.reference.block[worst]])
    return [
        f"the largest contour error of the run, {units.show(whole, 'small_length', 3)} at line {line} of the new program, is where "
        "nothing is shifted: a plunge, a rapid move, before the first bend, or where a cut stops"
    ]


def _kept(
    task: Task, best: Written, found: Learned, before: float, after: float, whole: float,
    values: Mapping[str, tuple[float, str]],
) -> list[str]:  # fmt: skip
    """Why the correction is not good enough."""
    said, kept = task.said, []
    show = lambda value: units.show(value, "small_length", 3)  # noqa: E731
    if after >= before:
        which = "contour error" if best.walls is None else "error of path and walls"
        kept.append(f"nothing is gained: the {which} is {show(after)} after {show(before)}")
    elif after > said.residual * before:
        kept.append(
            f"{show(after)} of {show(before)} are left, more than correct.residual ({said.residual:g}); {_floor(best, found, said)}"
        )
    bound = said.limits.get(_MEASURE)
    if bound == "equal":
        bound = None  # less is always left than before, or nothing is gained
    if bound is not None and not isinstance(bound, str) and bound.max is not None and whole > bound.max:
        kept.append(f"{_MEASURE} {show(whole)} is above its limit of {show(bound.max)}; {_floor(best, found, said)}")
    return [*kept, *_walls_kept(said, values)]


def _walls_kept(said: Correction, values: Mapping[str, tuple[float, str]]) -> Iterator[str]:
    """Limits on walls that the corrected path misses."""
    for name in _WALLS:
        bound, value = said.limits.get(name), values.get(f"{name}_after")
        if bound is None or value is None:
            continue
        ends = (bound.min, bound.max) if not isinstance(bound, str) else (
            (values[f"{name}_before"][0], None) if name == _WALLS[0] else (None, values[f"{name}_before"][0])
        )  # fmt: skip
        for end, beyond in zip(ends, (-1.0, 1.0), strict=True):
            if end is not None and beyond * (value[0] - end) > 0.0:
                shown = [units.show(one, "small_length", 3) for one in (value[0], end)]
                yield f"{name} is {shown[0]}, beyond its limit of {shown[1]}"


def _floor(best: Written, found: Learned, said: Correction) -> str:
    """What sets the error that is left."""
    if float(np.abs(found.shift).max()) >= said.shift_max * (1.0 - 1e-9):
        return f"the shift is at correct.shift_max ({units.show(said.shift_max, 'small_length', 3)})"
    error = best.seen.error[0]
    counts = judged(best.told, whole=found.whole)
    worst = int(np.argmax(np.where(counts, best.seen.worst[0], 0.0)))
    if best.seen.half[0][worst] > abs(error[worst]):
        return (
            "it is what the tool leaves differently over the height of the wall, or as it swings: a shorter tool, more flutes in "
            "the cut or a second pass help, no shift of the path"
        )
    begin = _set_out(best, worst) if found.whole else None
    if begin is not None:
        cut = cut_level(best.told.wanted)
        if begin > 0 and cut[begin - 1] and cut[begin]:
            return "it is worst where a cut is parted (a corner, a stop, another F): give it one feed there, or blend the corner"
        return "it is worst where a cut sets out in the material from rest, to where the move before brings it: begin in air"
    history_clipped = _saturated(best)
    if history_clipped:
        return "a controller is at its voltage limit (machine.control.saturation)"
    if behind_stop(best.told, best.error, whole=found.whole):
        return (
            "it is worst behind a corner that the drives run on beyond: blend the corner (G64 P), or come slower to it"
        )
    if found.rule.smoothing:
        ms = units.show(found.rule.smoothing * best.told.drives[0].law.sample_time, "time", 3)
        return f"what is left changes faster than the smoothing of {ms} lets pass, or does not repeat (friction, teeth)"
    return "what is left does not repeat (friction, teeth)"


def _set_out(best: Written, worst: int) -> int | None:
    """The block with which a cut began, no more than a millimetre before an instant; None: none did."""
    begins = np.array([low for low, _ in stretches(best.told.wanted)])
    way = best.told.place.travelled[worst] - begins
    near = np.flatnonzero((way >= 0.0) & (way < _SETS_OUT))
    if not near.size:
        return None
    return int(np.searchsorted(best.told.wanted.curve.knots, begins[near[-1]] + 1e-12, side="right")) - 1


def _saturated(best: Written) -> bool:
    return bool(followed(best.scenario, best.told, best.told.order).clipped.any())


def _along(best: Written, before: FloatArray, told: Commanded) -> Along:
    at, first = np.unique(told.place.travelled, return_index=True)
    places, own = np.unique(best.told.place.travelled, return_index=True)
    after = np.interp(at, places, best.error[own])
    return Along(
        at, before[first], after, np.full(len(at), math.inf), np.full(len(at), -1, np.int64), (), "small_length",
        "Contour error, positive to the right of the path" if best.walls is None
        else "Error of path and walls, positive to the right of the path",
    )  # fmt: skip


def _part(progress: Callable[[float], None] | None, low: float, high: float) -> Callable[[float], None] | None:
    return None if progress is None else lambda share: progress(low + (high - low) * share)


def _tolerance(scenario: MillingScenario, before: float, said: Correction) -> float:
    """How much error is allowed [m]: a limit or requirement, else the share of the error before."""
    bound = said.limits.get(_MEASURE)
    limit = scenario.requirements.get(_MEASURE)
    given = [bound.max if bound is not None and not isinstance(bound, str) else None, limit.max if limit else None]
    return min([float(one) for one in given if one is not None] or [said.residual * before])
