"""Canned drilling cycles, resolved into moves."""

from dataclasses import replace
from typing import Literal

from cutwise import units
from cutwise.io.programs.blocks import Word
from cutwise.io.programs.state import Run, State, moved, new_move, target


def drill(values: dict[str, Word], first: Word, state: State, run: Run) -> State:
    """Canned drilling cycles G73, G81-G83 in the xy plane, resolved into moves."""
    scale = units.factor(state.unit, "length")
    if state.plane != "G17":
        run.fault("drilling cycles are supported in the plane G17 only", first)
        return state
    base = 0.0 if state.absolute else state.at[2]
    if "R" in values:
        state = replace(state, cycle_r=base + values["R"].value * scale)
    if "Z" in values:
        reference = 0.0 if state.absolute else (state.cycle_r if state.cycle_r is not None else 0.0)
        state = replace(state, cycle_z=reference + values["Z"].value * scale)
    if "Q" in values:
        state = replace(state, cycle_q=values["Q"].value * scale)
    if "P" in values:
        state = replace(state, cycle_p=values["P"].value)
    if state.cycle_z is None or state.cycle_r is None:
        run.fault(f"G{state.motion:g} needs Z and R", first)
        return state
    if state.motion in (73, 83) and state.cycle_q <= 0.0:
        run.fault(f"G{state.motion:g} needs a positive peck Q", first)
        return state
    if state.feed <= 0.0:
        run.fault("drilling without a feed; write F before it or in its block", first)
    x, y, _ = target({k: w for k, w in values.items() if k in "XY"}, state)
    top, bottom, before = state.cycle_r, state.cycle_z, state.at[2]
    stops: list[tuple[Literal["rapid", "feed"], float]] = [("rapid", top)]
    depth = top
    clear = min(0.25e-3, state.cycle_q)
    while state.motion in (73, 83) and depth - state.cycle_q > bottom:
        depth -= state.cycle_q
        back = top if state.motion == 83 else depth + clear
        stops += [("feed", depth), ("rapid", back)]
        if state.motion == 83:
            stops.append(("rapid", depth + clear))
    stops.append(("feed", bottom))
    if before < top:
        state = moved(state, "rapid", (state.at[0], state.at[1], top), first.line, run)
    state = moved(state, "rapid", (x, y, state.at[2]), first.line, run)
    for kind, z in stops:
        state = moved(state, kind, (x, y, z), first.line, run)
    if state.motion == 82:
        run.moves.append(new_move(state, "dwell", state.at, first.line, dwell=state.cycle_p))
    return moved(state, "rapid", (x, y, max(before, top) if state.retract_to_start else top), first.line, run)
