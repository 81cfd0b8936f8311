"""Modal interpreter for G-code of the RS274/NGC dialect: blocks of words into moves in SI."""

import math
from dataclasses import replace
from typing import NamedTuple

from cutwise import units
from cutwise.io.programs.blocks import Line, Word, blocks
from cutwise.io.programs.cycles import drill
from cutwise.io.programs.state import Move, Point, Run, State, new_move, target
from cutwise.spec.faults import Fault, ScenarioFault

# modal groups: one word of each in a block
_MOTION = {0, 1, 2, 3, 73, 80, 81, 82, 83}
_GROUPS: dict[str, set[float]] = {
    "motion": {float(g) for g in _MOTION},
    "plane": {17, 18, 19},
    "units": {20, 21},
    "distance": {90, 91},
    "arc distance": {90.1, 91.1},
    "feed mode": {94},
    "cutter compensation": {40},
    "tool length": {43, 49},
    "work coordinates": {54, 55, 56, 57, 58, 59, 59.1, 59.2, 59.3},
    "path mode": {61, 61.1, 64},
    "return": {98, 99},
    "once": {4},
}
_M_CODES = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 30}
_KNOWN_M_REASON = "unknown or unsupported M code; known are M0-M9 and M30"
_AXES = {"G17": (0, 1, 2), "G18": (2, 0, 1), "G19": (1, 2, 0)}
_LETTERS = set("ABCDFGHIJKLMNPQRSTXYZ")
_RADIUS_SLACK = (2.828e-3, 0.02828e-3, 1e-3)  # [m], [m], share: RS274/NGC limits between start and end radius


class Interpreted(NamedTuple):
    """The moves of a program, and what was noticed."""

    moves: tuple[Move, ...]
    tools: tuple[int, ...]
    notices: tuple[str, ...]


def interpret(text: str, name: str = "program") -> Interpreted:
    """The moves of a G-code program.

    Understood are G0-G4, G17-G19, G20/21, G40, G43/49, G54-G59.3, G61, G61.1, G64, G73, G80-G83, G90/91, G90.1/91.1,
    G94, G98/99, M0-M9, M30 and the words F S T H N; anything else is a fault with line and column, never skipped. Work
    coordinate systems are taken as one and the same, the tool length as contained in z.

    Raises
    ------
    ScenarioFault
        With everything in the program that cannot be run.
    """
    run = Run(name)
    state = State()
    for block in blocks(text, name, run.faults):
        state = _block(block, state, run)
        if state.ended:
            break
    if run.faults:
        raise ScenarioFault(sorted(run.faults, key=lambda fault: (fault.line or 0, fault.column or 0)))
    if not any(move.kind in ("feed", "arc") for move in run.moves):
        raise ScenarioFault([Fault((), "has no feed move: nothing would be cut", file=name)])
    return Interpreted(tuple(run.moves), tuple(run.tools), tuple(run.notices))


def _block(block: Line, state: State, run: Run) -> State:
    g, values = _sorted_words(block, run)
    if g is None:
        return state
    state = _modes(g, values, state, run)
    if "dwell" in values:  # set by _modes for G4
        return state
    axes = [letter for letter in "XYZ" if letter in values]
    if "motion" in g:
        state = replace(state, motion=g["motion"].value)
        if state.motion == 80:
            return replace(state, cycle_z=None, cycle_r=None) if not axes else _no_motion(values[axes[0]], state, run)
    offsets = [letter for letter in "IJKR" if letter in values]
    if not axes and not (state.motion in (2, 3) and offsets):
        if "motion" in g and state.motion not in (0, 1):
            run.fault(f"G{state.motion:g} needs axis words", g["motion"])
        return _after(values, state)
    first = values[(axes or offsets)[0]]
    if state.motion == 80:
        return _no_motion(first, state, run)
    if state.motion in (0, 1):
        return _after(values, _straight(values, first, state, run))
    if state.motion in (2, 3):
        return _after(values, _arc(values, first, state, run))
    return _after(values, drill(values, first, state, run))


def _no_motion(word: Word, state: State, run: Run) -> State:
    run.fault("axis words while motion is cancelled (G80); write G0 or G1", word)
    return state


def _after(values: dict[str, Word], state: State) -> State:
    """M2 and M30 take effect after the motion of their block."""
    return replace(state, ended=True) if "end" in values else state


def _sorted_words(block: Line, run: Run) -> tuple[dict[str, Word] | None, dict[str, Word]]:
    """G words by modal group, all others by letter (M words are acted on as they come)."""
    g: dict[str, Word] = {}
    values: dict[str, Word] = {}
    good = True
    for word in block.words:
        if word.letter == "G":
            group = next((name for name, codes in _GROUPS.items() if word.value in codes), None)
            if group is None:
                run.fault(f"{word} is unknown or not supported", word)
                good = False
            elif group in g:
                run.fault(f"{word} and {g[group]} are of one modal group ({group}); one of them per block", word)
                good = False
            else:
                g[group] = word
        elif word.letter == "M":
            if word.value not in _M_CODES:
                run.fault(f"{word}: {_KNOWN_M_REASON}", word)
                good = False
            elif word.value in (2, 30):
                values["end"] = word
            else:
                values[f"M{word.value:g}"] = word
        elif word.letter not in _LETTERS or word.letter in "ABC":
            what = "rotary axes are not supported" if word.letter in "ABC" else "unknown word"
            run.fault(f"{word}: {what}", word)
            good = False
        elif word.letter in values:
            run.fault(f"word {word.letter} twice in one block", word)
            good = False
        else:
            values[word.letter] = word
    return (g if good else None), values


def _modes(g: dict[str, Word], values: dict[str, Word], state: State, run: Run) -> State:
    """Everything but motion, in the order of execution of RS274/NGC."""
    if "units" in g:
        state = replace(state, unit="inch" if g["units"].value == 20 else "mm")
    scale = units.factor(state.unit, "length")
    if "F" in values:
        if values["F"].value <= 0.0:
            run.fault("feed must be positive", values["F"])
        state = replace(state, feed=values["F"].value * units.factor(f"{state.unit}/min", "speed"))
    if "S" in values:
        state = replace(state, speed=values["S"].value * units.factor("rpm", "angular_speed"))
    if "T" in values:
        run.tools.append(int(values["T"].value))
    for code, turning in (("M3", 1), ("M4", -1), ("M5", 0)):
        if code in values:
            state = replace(state, turning=turning)
    if "plane" in g:
        state = replace(state, plane=f"G{g['plane'].value:g}")
    if "distance" in g:
        state = replace(state, absolute=g["distance"].value == 90)
    if "arc distance" in g:
        state = replace(state, arc_absolute=g["arc distance"].value == 90.1)
    if "return" in g:
        state = replace(state, retract_to_start=g["return"].value == 98)
    if "path mode" in g:
        mode = {61.0: "exact_path", 61.1: "exact_stop", 64.0: "blend"}[g["path mode"].value]
        tolerance = values["P"].value * scale if mode == "blend" and "P" in values else 0.0
        if mode == "blend" and tolerance == 0.0:
            run.notices.append(
                f"line {g['path mode'].line}: G64 without P has no tolerance; corners are run as exact path here"
            )
            mode = "exact_path"
        state = replace(state, mode=mode, tolerance=tolerance)
    if "once" in g:
        if "P" not in values:
            run.fault("G4 needs a time P in seconds", g["once"])
        else:
            run.moves.append(new_move(state, "dwell", state.at, g["once"].line, dwell=values["P"].value))
        values["dwell"] = g["once"]
    return state


def _straight(values: dict[str, Word], first: Word, state: State, run: Run) -> State:
    end = target(values, state)
    for letter in "IJKRQLD":
        if letter in values:
            run.fault(f"{letter} has no meaning with G{state.motion:g}", values[letter])
    if state.motion == 1 and state.feed <= 0.0:
        run.fault("feed move without a feed; write F before it or in its block", first)
    if end != state.at:
        run.moves.append(new_move(state, "rapid" if state.motion == 0 else "feed", end, first.line))
    return replace(state, at=end)


def _arc(values: dict[str, Word], first: Word, state: State, run: Run) -> State:
    end = target(values, state)
    if state.feed <= 0.0:
        run.fault("feed move without a feed; write F before it or in its block", first)
    u, v, w = _AXES[state.plane]
    found = _centre(values, first, end, state, run)
    if found is None:
        return replace(state, at=end)
    cu, cv, turns = found
    a0 = math.atan2(state.at[v] - cv, state.at[u] - cu)
    a1 = math.atan2(end[v] - cv, end[u] - cu)
    sweep = (a1 - a0) % (2.0 * math.pi)
    if state.motion == 2:
        sweep -= 2.0 * math.pi if sweep > 1e-12 else 0.0
    if abs(sweep) < 1e-12:
        sweep = 2.0 * math.pi if state.motion == 3 else -2.0 * math.pi
    sweep += math.copysign(2.0 * math.pi * (turns - 1), sweep)
    centre = list(state.at)
    centre[u], centre[v] = cu, cv
    axis = [0.0, 0.0, 0.0]
    axis[w] = 1.0
    run.moves.append(
        new_move(state, "arc", end, first.line, centre=(centre[0], centre[1], centre[2]), axis=(axis[0], axis[1], axis[2]),
              sweep=sweep)
    )  # fmt: skip
    return replace(state, at=end)


def _centre(
    values: dict[str, Word], first: Word, end: Point, state: State, run: Run
) -> tuple[float, float, int] | None:
    """Centre in the plane [m] and number of turns; None after a fault."""
    scale = units.factor(state.unit, "length")
    u, v, _ = _AXES[state.plane]
    turns = int(values["P"].value) if "P" in values else 1
    if "R" in values:
        if any(letter in values for letter in "IJK"):
            run.fault("arc with both R and a centre; keep one", values["R"])
            return None
        return _centre_from_radius(values["R"], end, state, run, turns)
    letters = ["IJK"[u], "IJK"[v]]
    if not any(letter in values for letter in letters):
        run.fault(f"arc without a centre; write {letters[0]}, {letters[1]} or R", first)
        return None
    for letter in "IJK":
        if letter in values and letter not in letters:
            run.fault(f"{letter} is not in the plane of the arc ({state.plane})", values[letter])
            return None
    given = [values[letter].value * scale if letter in values else 0.0 for letter in letters]
    if state.arc_absolute and not all(letter in values for letter in letters):
        run.fault(f"with G90.1 an arc needs both {letters[0]} and {letters[1]}", first)
        return None
    cu, cv = given if state.arc_absolute else (state.at[u] + given[0], state.at[v] + given[1])
    r0, r1 = math.hypot(state.at[u] - cu, state.at[v] - cv), math.hypot(end[u] - cu, end[v] - cv)
    gap = abs(r0 - r1)
    far, near, share = _RADIUS_SLACK
    if r0 <= 0.0:
        run.fault("arc with its centre on its start", first)
        return None
    if gap > far or (gap > near and gap > share * max(r0, r1)):
        shown = f"{units.show(r0, 'length')} at the start, {units.show(r1, 'length')} at the end"
        run.fault(f"the end of the arc is not on its circle: radius {shown}", first)
        return None
    return cu, cv, turns


def _centre_from_radius(word: Word, end: Point, state: State, run: Run, turns: int) -> tuple[float, float, int] | None:
    u, v, _ = _AXES[state.plane]
    radius = word.value * units.factor(state.unit, "length")
    du, dv = end[u] - state.at[u], end[v] - state.at[v]
    chord = math.hypot(du, dv)
    if chord <= 0.0 or radius == 0.0:
        run.fault(
            "an arc by R needs a radius and an end apart from its start; write a full circle with its centre", word
        )
        return None
    left = radius * radius - 0.25 * chord * chord
    if left < -1e-3 * radius * radius:
        run.fault(
            f"the end is {units.show(chord, 'length')} from the start, more than twice the radius "
            f"{units.show(abs(radius), 'length')}",
            word,
        )
        return None
    height = math.sqrt(max(left, 0.0))
    side = 1.0 if (state.motion == 3) == (radius > 0.0) else -1.0  # short arc for positive R
    cu = state.at[u] + 0.5 * du - side * height * dv / chord
    cv = state.at[v] + 0.5 * dv + side * height * du / chord
    return cu, cv, turns
