"""Findings in words: the only place where a record becomes a sentence, the same for console, report and JSON."""

from collections.abc import Callable, Mapping

from cutwise import units
from cutwise.results import SOUNDNESS, Finding, Result

_CONTACTS = {"straight": "on the straight", "corner": "in the heaviest contact"}
_OVER_LIMIT = {"arm": "the arm chatters: the axial depth", "shaft": "shaft or tool chatters: the depth of cut"}


def _shown(finding: Finding, value: float | None, digits: int = 3) -> str:
    return "" if value is None else units.show(value, finding.dimension, digits)


def _where(finding: Finding) -> str:
    """A place behind a sentence: `` (outer edge, t = 0.2 s)``, or nothing."""
    at = finding.where
    parts = [at.name] if at.name else []
    parts += [f"line {at.line} of the program"] if at.line else []
    parts += [f"t = {units.show(at.time, 'time', 4)}"] if at.time is not None else []
    parts += [f"w = {units.show(at.position, 'length', 4)}"] if at.position is not None else []
    return f" ({', '.join(parts)})" if parts else ""


def _unstable(finding: Finding, result: Result) -> str:
    del result
    if finding.where.name in _OVER_LIMIT:
        return f"{_OVER_LIMIT[finding.where.name]} is {finding.value:.3g} times its limit"
    where = _CONTACTS.get(finding.where.name, finding.where.name)
    return f"the tool chatters {where} (growth {finding.value:.3g} per tooth)"


def _untouched(finding: Finding, result: Result) -> str:
    where = _where(finding)
    if result.scenario.process == "deburr":
        return f"the mill does not touch the edge in the part of the pass that is judged{where}"
    return f"the tool touches no material at all{where}: look at depths, stock and the zero of the program"


def _contact_lost(finding: Finding, result: Result) -> str:
    where = _where(finding)
    if result.scenario.process == "drill":
        return f"the tip is pushed back faster than it is fed: the drill stops cutting for a while at entry{where}"
    return (
        f"the mill loses the edge along {finding.value:.1%} of the pass and leaves more than the tolerance there, the first "
        f"time at{where}"
    )


def _tip_lost(finding: Finding, result: Result) -> str:
    if result.scenario.process == "chamfer":
        return (
            f"the cut drags the ball aside, {_shown(finding, finding.value)} round the bends of its path{_where(finding)}: "
            "widths under deflection are not to be believed and are left out"
        )
    return (
        f"the tip swings by more than {_shown(finding, finding.limit)}{_where(finding)}: from there on the tool is not "
        "where its contact is taken, so that errors, forces and voltages of this run are left out"
    )


def _at_stop(finding: Finding, result: Result) -> str:
    said = f"the tool is dragged to the stop of the spindle: a piston used its whole stroke{_where(finding)}"
    if result.scenario.process == "chamfer":
        return f"{said}; widths under deflection are not to be believed and are left out"
    return said


def _unsettled(finding: Finding, result: Result) -> str:
    if result.scenario.process == "mill":
        return (
            f"the tool has not settled when the run ends: it is {_shown(finding, finding.value)} from the end point "
            f"({_shown(finding, finding.limit)} is settled); lengthen numerics.settling_time"
        )
    if finding.dimension == "time":
        return (
            f"the lead-in lasts {_shown(finding, finding.value)}, into the last quarter of the run, which is judged from "
            f"{_shown(finding, finding.limit)} on; lengthen the run or shorten the lead-in"
        )
    return (
        f"the edge has not settled: it still moves by {_shown(finding, finding.value)} over the last quarter of the run, "
        "which is judged; lengthen the run"
    )


def _moved(finding: Finding, result: Result) -> str:
    measure = result.measures.get(finding.measure)
    value = measure.value if measure is not None else 0.0
    moved = abs(finding.value or 0.0)
    share = f" ({100 * moved / abs(value):.2g} %)" if moved < 10.0 * abs(value) else ""
    return f"{finding.measure} moves by {_shown(finding, finding.value)}{share} when the step is halved"


def _unconverged(finding: Finding, result: Result) -> str:
    return (
        f"{_moved(finding, result)}, and its limit is {_shown(finding, finding.limit)} away: the verdict depends on the "
        "step; use a smaller one"
    )


def _unsolved(finding: Finding, result: Result) -> str:
    if result.scenario.process == "drill":
        return (
            f"the time step is too long for this speed and wall stiffness{_where(finding)}; use at most "
            f"{_shown(finding, finding.limit, 2)}"
        )
    count = int(finding.value or 0)
    return (
        f"the forces of pistons and structure were not found in {count} steps{_where(finding)}; use a smaller time step"
    )


def _edge_stands(finding: Finding, result: Result) -> str:
    del result
    how = " with the spindle yielding" if "deflected" in finding.measure else ""
    return f"somewhere along the path no complete chamfer is left{how}: the edge still stands there"


def _collides(finding: Finding, result: Result) -> str:
    del result
    count = int(finding.value or 0)
    return f"{count} rapid move{'s run' if count > 1 else ' runs'} through the stock, the first in line {finding.where.line}"


def _at_rest(finding: Finding, result: Result) -> str:
    del result
    return f"the spindle does not turn in a move that would cut{_where(finding)}: the mill is dragged through the stock"


def _rubs(finding: Finding, result: Result) -> str:
    del result
    return f"the rod is carried {_shown(finding, -(finding.value or 0.0))} into the part: it would rub there"


def _unreached(finding: Finding, result: Result) -> str:
    check = next((check for check in result.checks if check.measure == finding.measure), None)
    if check is not None and check.value is not None and check.probability is not None and not check.whole_band:
        asked = f"{finding.measure} is required with a probability of {check.probability:.4g}"
        if result.band is None:
            return f"{asked}, but the run has no band: no value that it uses has a standard error"
        return f"{asked}, but it has no {result.band.method} band; --set band.method=sampled makes one by draws"
    if check is not None and check.value is not None:
        return f"{finding.measure} is required over its whole band, but the run knows no end of it"
    return f"{finding.measure} is required, but this run has no such measure"


def _weight(finding: Finding, result: Result) -> str:
    del result
    force, limit = _shown(finding, finding.value), _shown(finding, finding.limit)
    said = f"the weight of the motor pushes the tip with {force}{_where(finding)}"
    ends = {
        "weight_moves": f", more than the {limit} at which the spindle yields: it alone moves the tip (spindle.gravity)",
        "weight_stays": f", more than the {limit} with which the pistons re-centre it: the motor droops (spindle.gravity)",
    }
    return said + ends.get(finding.code, f", of the {limit} at which the spindle yields (spindle.gravity)")


_WORDS: Mapping[str, Callable[[Finding, Result], str]] = {
    "unstable": _unstable,
    "untouched": _untouched,
    "contact_lost": _contact_lost,
    "tip_lost": _tip_lost,
    "at_stop": _at_stop,
    "unsettled": _unsettled,
    "unconverged": _unconverged,
    "unsolved": _unsolved,
    "edge_stands": _edge_stands,
    "collides": _collides,
    "at_rest": _at_rest,
    "rubs": _rubs,
    "unreached": _unreached,
    "moves": _moved,
    "weight_moves": _weight,
    "weight_stays": _weight,
    "weight_leans": _weight,
}


def said(finding: Finding, result: Result) -> str:
    """One sentence about a finding, with its remedy where one was tried."""
    if finding.words:
        return finding.words
    words = _WORDS[finding.code](finding, result)
    if finding.code == "unstable" and finding.where.name not in _OVER_LIMIT:
        if finding.remedy is None:
            return f"{words}; no speed of the lobe diagram and no smaller depth that was run is stable"
        return f"{words}; {finding.remedy.key} {finding.remedy.value} was run and is stable"
    return words


def reasons(result: Result) -> list[str]:
    """Why the run is not sound, in words; empty if it is."""
    return list(dict.fromkeys(said(finding, result) for finding in result.unsound))


def notices(result: Result) -> list[str]:
    """The findings that do not decide, in words; with those that the scenario sets aside.

    Those that are among the warnings of the result have their words there.
    """
    unsound = {id(finding) for finding in result.findings if finding.words} | set(map(id, result.unsound))
    told = [
        f"{said(finding, result)} (set aside: stability: ignore)" if finding.code in SOUNDNESS else said(finding, result)
        for finding in result.findings if id(finding) not in unsound
    ]  # fmt: skip
    return list(dict.fromkeys(told))
