"""The histories and maps of a pass on a machine as labelled arrays, and what is to be said about them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from cutwise import units
from cutwise.maths.frames import FloatArray
from cutwise.physics.surface import budget
from cutwise.process import stock_moves
from cutwise.process.chain_compliance import off_part
from cutwise.process.labels import Column, Coordinate, Group, Over
from cutwise.process.machine import MachineDone, MachinePass, VolumeMap
from cutwise.process.machine_pass import MachineRun
from cutwise.process.stock_moves import collisions
from cutwise.programs.block_text import block_named, blocks_named
from cutwise.results import Finding, Place, Remedy, Said, warned
from cutwise.spec.base import known
from cutwise.spec.machine_scenario import MachineScenario

_AXES = ["x", "y", "z"]
_COMPONENTS = ["x", "y", "z", "a", "b", "c"]
_TURNED = 1e-3  # a path whose direction changes by more is drawn in plan
_CHIPS = (5e-6, 0.4e-3)  # [m] usual feed per tooth
_TOO_FAR = 1e-3  # [m] an error of the tool point that hardly any machine has
_ALONG_FEED = 0.1  # share of a wall's normal along the feed
_FIRST_ORDER = 1e-3  # [rad] above it, exact and first-order errors part by more than 0.1 %

LIMITS = (
    "Static: no vibration, no thermal growth, no friction in the guides.",
    "First order: forces act at the undeformed points; the difference from the exact composition is told.",
    "Bodies are rigid but for the beams named; joints and guides are linear unless they have the contact law.",
    "Linear pads pull as well as push: guides must be closed (gibs, profiled rails); an open slideway may lift.",
    "The wall takes the error of the tool point and of the tool's direction; scallops and run-out are left out.",
)


def _commands(k: int, done: MachineDone) -> FloatArray:
    return known(done.volume).at[k]


_OVER: Over = {
    "time": Coordinate(lambda done: done.one_pass.run.cell.way.time, "s", "time of feed"),
    "body": lambda done: list(done.one_pass.run.cell.names),
    "joint": lambda done: list(done.one_pass.run.cell.names[1:]),
    "element": lambda done: list(done.one_pass.run.element_names),
    "height": Coordinate(lambda done: done.one_pass.wall.height, "m", "height above the tool point"),
    "axis": _AXES,
    "component": _COMPONENTS,
}
_GRID: Over = {
    **{name: Coordinate(partial(_commands, k), "m", f"command of axis {name}") for k, name in enumerate("XYZ")},
    "axis": _AXES,
    "diagonal": ["+++", "-++", "+-+", "--+"],
}


def _has_pass(done: MachineDone) -> bool:
    return done.one_pass is not None


def _run(read: Callable[[MachineRun], Any]) -> Callable[[MachineDone], Any]:
    """What is read of the pass itself."""
    return lambda done: read(done.one_pass.run)  # type: ignore[union-attr]


def _seen_along(done: MachineDone) -> FloatArray | None:
    """What a path that bends is drawn with in plan."""
    assert done.one_pass is not None
    run, wall = done.one_pass.run, done.one_pass.wall
    way = run.cell.way
    if np.ptp(way.direction[way.cuts], axis=0).max(initial=0.0) <= _TURNED:
        return None
    return np.where(way.cuts, run.size if wall is None else wall.error[:, 0], np.nan)


def _shares(read: Callable[[MachineRun], FloatArray]) -> Callable[[MachineDone], Any]:
    """Signed shares in the error at the worst place."""
    return _run(lambda run: budget.signed_shares(read(run)[run.worst], run.deviation[run.worst]))


GROUPS = {
    "motion": Group({
        "travel": Column("time", _run(lambda run: run.cell.way.travel), "m", "way along the pass"),
        "command": Column("time joint", _run(lambda run: run.cell.way.commands), "m, rad", "command of each joint"),
        "program_line": Column("time", _run(lambda run: run.cell.way.line), "1", "line of the program, 0 for a path"),
        "cuts": Column("time", _run(lambda run: run.cell.way.cuts.astype(float)), "1", "whether the tool cuts"),
        "position": Column("time axis", _run(lambda run: run.ideal), "m", "ideal tool point in the part, r_0"),
        "tool_vector": Column("time body axis", _run(lambda run: run.reach), "m", "tool point in each body's frame, r_i"),
        "body_origin": Column("time body axis", _run(lambda run: run.at.origins), "m", "origins of the bodies in the part"),
        "geometric_error": Column("time body component", _run(lambda run: run.geometric), "m, rad", "geometric errors"),
    }, _OVER, _has_pass),
    "cutting": Group({
        "force": Column("time axis", _run(lambda run: run.cell.cut.force), "N", "cutting force on the tool"),
    }, _OVER, _has_pass),
    "structure": Group({
        "twist": Column("time body component", _run(lambda run: run.twists), "m, rad", "error of each body in its frame"),
        "f1": Column("time body axis", _run(lambda run: run.local), "m", "error of the tool point by a body, in its frame"),
        "f2": Column("time body axis", _run(lambda run: run.body), "m", "error of the tool point by a body, in the part"),
        "f3": Column("time axis", _run(lambda run: run.body[:, 0]), "m", "deformation of the part"),
        "work_of_loads": Column("time", _run(lambda run: run.external), "J", "sum of loads times displacements"),
        "work_of_elements": Column("time", _run(lambda run: run.internal), "J", "sum of W C W"),
    }, _OVER, _has_pass),
    "surface": Group({
        "f4": Column("time axis", _run(lambda run: run.deviation), "m", "error of the tool point in the part"),
        "f5": Column("time axis", _run(lambda run: run.ideal + run.deviation), "m", "tool point as machined"),
        "exact": Column("time axis", _run(lambda run: run.exact), "m", "the same error by exact composition"),
        "tilt": Column("time axis", _run(lambda run: run.rotation), "rad", "error of the tool's direction"),
        "wall_error": Column("time height", lambda done: None if done.one_pass.wall is None else done.one_pass.wall.error,
                             "m", "error along the wall's normal"),
        "error_on_path": Column("time", _seen_along, "m", lambda done: (
            "length of the error" if done.one_pass.wall is None else "error of the wall at the tool point"
        )),
    }, _OVER, _has_pass),
    "budget": Group({
        "contribution": Column("element axis", _run(lambda run: run.contributions[run.worst]), "m",
                               "error by an element, worst place"),
        "share": Column("element", _shares(lambda run: run.contributions), "m", "signed share along the error, worst place"),
        "stiffening_gain": Column("element", lambda done: done.one_pass.gain, "m", "change of the error with 10 % more stiffness"),
        "body_contribution": Column("body axis", _run(lambda run: run.body[run.worst]), "m", "error by a body, worst place"),
        "body_share": Column("body", _shares(lambda run: run.body), "m", "signed share of a body, worst place"),
    }, _OVER, _has_pass),
    "engagement": Group({
        "immersion": Column("time", _run(lambda run: run.cell.cut.immersion), "rad", "immersion angle"),
    }, _OVER, _has_pass),
    "uncertainty": Group({
        "variance_share": Column("body", lambda done: done.one_pass.chances.shares, "1", "share of the body in the variance"),
        "deviation": Column("axis", lambda done: done.one_pass.chances.deviation, "m", "standard deviation"),
    }, _OVER, lambda done: _has_pass(done) and done.one_pass.chances is not None),
    "volume": Group({
        "error": Column("X Y Z axis", lambda done: done.volume.error, "m", "geometric error of the tool point in the part"),
        "position": Column("X Y Z axis", lambda done: done.volume.position, "m", "ideal tool point in the part"),
        "diagonal_error": Column("diagonal point", lambda done: done.volume.along, "m", "error along the body diagonal"),
        "diagonal_distance": Column("diagonal point", lambda done: done.volume.distance, "m", "distance along the body diagonal"),
    }, _GRID, lambda done: done.volume is not None),
}  # fmt: skip
"""One group per stage; f1 ... f5 are the relations of Demeč and Madáč."""


def warnings(scenario: MachineScenario, found: MachinePass | None) -> tuple[Said, ...]:
    """What the engineer should know before he trusts the numbers."""
    return () if found is None else tuple(_warnings(scenario, found))


def _warnings(scenario: MachineScenario, found: MachinePass) -> Iterator[Finding]:
    run = found.run
    tilt = float(np.abs(run.twists[..., 3:]).max())
    if tilt > _FIRST_ORDER:
        missed = units.show(float(np.linalg.norm(run.exact - run.deviation, axis=1).max()), "small_length", 3)
        yield warned(
            "beyond_first_order",
            f"a body turns by {tilt * 1e3:.3g} mrad: beyond 1 mrad the first-order sum is off; here by {missed} "
            "against the exact composition", tilt, _FIRST_ORDER, "small_angle",
        )  # fmt: skip
    largest = run.size[run.worst]
    if largest > _TOO_FAR:
        yield warned(
            "too_far",
            f"the tool point is off by {units.show(largest, 'length', 3)}: look at the units of stiffnesses and errors (a "
            "compliance is in m/N and rad/(N m))", float(largest), _TOO_FAR, "length",
        )  # fmt: skip
    yield from _cut_warnings(scenario, run)
    yield from _normal_warnings(scenario, run)
    rigid = not (scenario.tool.flexible or scenario.tool.stiffness or scenario.tool.modes)
    if rigid and run.cell.cut.force.any():
        words = (
            "the tool does not bend in this run (tool.flexible: false); a slender mill may add more than the machine"
        )
        yield warned("left_out", words, where=Place("tool"), remedy=Remedy("tool.flexible", "true"))


def _normal_warnings(scenario: MachineScenario, run: MachineRun) -> Iterator[Finding]:
    """A wall that the feed runs into."""
    normal = scenario.surface.normal if scenario.surface is not None else None
    if normal is not None and run.cell.way.cuts.any():
        across = np.array(normal) / np.linalg.norm(normal)
        along = float(np.abs(run.cell.way.direction[run.cell.way.cuts] @ across).max())
        if along > _ALONG_FEED:
            yield warned(
                "wall_across_feed",
                f"surface.normal is {np.degrees(np.arccos(min(along, 1.0))):.0f}° from the feed in places: a wall that the tool "
                "passes by is at right angles to it", along, _ALONG_FEED,
            )  # fmt: skip


def _cut_warnings(scenario: MachineScenario, run: MachineRun) -> Iterator[Finding]:
    """A spindle at rest, chips out of range, and a tool point that is nowhere near the part."""
    way, chips = run.cell.way, run.cell.cut.chip
    if way.still:
        named = blocks_named(_text(scenario), way.still)
        words = f"the spindle does not turn in moves that would cut, which have no force here: {named}"
        yield warned("still_spindle", words, where=Place(line=way.still[0]))
    yield from stock_moves.said(way.into, _text(scenario))
    if chips is not None and way.cuts.any():
        greatest = float(chips[way.cuts].max())
        if not _CHIPS[0] <= greatest <= _CHIPS[1]:
            words = f"the feed per tooth is {units.show(greatest, 'small_length', 4)}; usual is 5 to 400 µm"
            yield warned("unusual_chip", words, greatest, _CHIPS[1], "small_length")
        assert scenario.material is not None
        if beyond := scenario.material.beyond(greatest):
            yield warned("beyond_data", beyond, greatest, dimension="small_length", where=Place("material"))
    part = scenario.block
    if part is None:
        return
    yield from off_part(part, run.ideal[run.counted], 0.5 * scenario.tool.diameter)


def notes(scenario: MachineScenario, found: MachinePass | None, volume: VolumeMap | None) -> dict[str, str]:
    """The worst place and body, what to stiffen, what holds of the energy balance; the worst diagonal."""
    told: dict[str, str] = {}
    if found is not None:
        told |= _worst(found, _text(scenario))
        limit = scenario.requirements.get("deviation_norm_max")
        if limit is not None and limit.max is not None and found.gain.size:
            told["stiffness"] = _stiffness_for(found.run, limit.max)
        if found.chances is not None:
            told["probability"] = _probability(found, scenario)
        told["energy"] = (
            "Energy balance over all loads: not applicable (no loads, a contact law, or options that are not physical)."
            if found.balance is None
            else f"Energy balance over all loads: relative residual {found.balance:.1e}."
        )
        if found.convexity is None:
            told["convexity"] = (
                "Convexity of cutting force times error: not applicable (it holds for a constant force on a straight pass of "
                "linear axes, with linear elements)."
            )
        else:
            word = "convex" if found.convexity > -1e-9 else "NOT convex"
            told["convexity"] = (
                f"Cutting force times error is {word} along the pass (least second derivative {found.convexity:.2e} of "
                "its size over the travel squared), as constant compliances ask for."
            )
    told["chain"] = (
        f"At rest: {scenario.bodies[scenario.carrying.ground]}; what comes before it in the chain moves with the part, what comes "
        "after it with the tool."
    )
    if volume is not None:
        ranges = np.ptp(volume.along, axis=1)
        told["diagonals"] = "Range of the error along the body diagonals: " + ", ".join(
            units.show(float(value), "small_length", 4) for value in ranges
        )
    return told


def _text(scenario: MachineScenario) -> str:
    return "" if scenario.program is None else scenario.program.text


def _worst(found: MachinePass, text: str) -> dict[str, str]:
    run, worst = found.run, found.run.worst
    shares = budget.signed_shares(run.body[worst], run.deviation[worst])
    size, where = (units.show(run.size[worst], "small_length", 5), units.show(run.ideal[worst, 0], "length"))
    top = int(np.argmax(shares))
    line = int(run.cell.way.line[worst])
    place = f", {block_named(text, line)}" if line else ""
    told = {
        "worst": f"The error is largest, {size}, at x = {where}{place}; {run.cell.names[top]} costs most of it, "
        f"{units.show(shares[top], 'small_length', 4)}."
    }
    if found.gain.size:
        best = int(np.argmin(found.gain))
        told["remedy"] = (
            f"Making {run.element_names[best]} 10 % stiffer changes it by "
            f"{units.show(found.gain[best], 'small_length', 3)}, more than any other element."
        )
    return told


def _stiffness_for(run: MachineRun, limit: float) -> str:
    """By how much each element alone must be stiffer, or may be softer, for the error to keep its limit."""
    shown = units.show(limit, "small_length", 4)
    factors = budget.stiffness_for(run.contributions, run.deviation, limit)
    names = np.array(run.element_names)
    able = np.flatnonzero(np.isfinite(factors))
    if run.size[run.worst] <= limit:
        parts = ", ".join(f"{names[e]} {100 * factors[e]:.3g} %" for e in able[np.argsort(-factors[able])])
        return f"Stiffness that each element alone needs to keep the error below {shown}, of what it has: {parts}."
    if not able.size:
        return f"No single element brings the error below {shown}, even if it were rigid: stiffen several."
    parts = ", ".join(f"{names[e]} {factors[e]:.3g} times" for e in able[np.argsort(factors[able])])
    return f"To keep the error below {shown}, one of these alone must be stiffer: {parts}."


def _probability(found: MachinePass, scenario: MachineScenario) -> str:
    chances = found.chances
    assert chances is not None
    systematic = found.run.deviation[chances.place]
    spans = ", ".join(
        f"{axis} {units.show(mean, 'small_length', 4)} ± {units.show(1.95996 * spread, 'small_length', 3)}"
        for axis, mean, spread in zip("xyz", systematic, chances.deviation, strict=True)
    )
    where = "In the middle of the pass" if scenario.program is None else "At the worst place"
    laws = {given.distribution for given in scenario.uncertainty.bodies} if scenario.uncertainty else set()
    margin = "" if laws == {"normal"} else ", as for normal errors"
    text = f"{where}, in 95 of 100 cases{margin}: {spans}."
    if chances.within is not None and scenario.uncertainty is not None and scenario.uncertainty.tolerance:
        allowed = units.show(scenario.uncertainty.tolerance, "small_length", 4)
        text += f" The length of the error stays within {allowed} in {100 * chances.within:.3g} of 100 cases."
    return text


def unsound(run: MachinePass | None) -> Iterator[Finding]:
    """A program that cuts nothing, rapid moves through the stock, a spindle at rest in the cut."""
    if run is None:
        return
    cut, way = run.run.cell.cut, run.run.cell.way
    if cut.immersion is not None and not cut.immersion.any():
        yield Finding("untouched")
    yield from collisions(way.into.collisions)
    if way.still:
        yield Finding("at_rest", Place(line=way.still[0]), float(len(way.still)), 0.0)
