"""The histories and maps of a pass on a machine as labelled arrays, and what is to be said about them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from cutwise import units
from cutwise.later import later
from cutwise.physics.surface import budget
from cutwise.process import stock_moves
from cutwise.process.chain_compliance import off_part
from cutwise.process.machine import MachinePass, VolumeMap
from cutwise.process.machine_pass import MachineRun
from cutwise.process.stock_moves import collisions
from cutwise.programs.block_text import block_named, blocks_named
from cutwise.results import Finding, Place, Remedy, Said, warned
from cutwise.spec.machine_scenario import MachineScenario

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

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


def _array(dims: tuple[str, ...], values: np.ndarray, unit: str, name: str) -> tuple[tuple[str, ...], np.ndarray, dict]:
    return dims, np.asarray(values), {"units": unit, "long_name": name}


def stages(found: MachinePass | None, volume: VolumeMap | None) -> xr.DataTree:
    """One group per stage; f1 ... f5 are the relations of Demeč and Madáč."""
    groups: dict[str, xr.Dataset] = {}
    if found is not None:
        groups |= _pass_groups(found)
    if volume is not None:
        groups["volume"] = _volume_group(volume)
    return xr.DataTree.from_dict(groups)


def _pass_groups(found: MachinePass) -> dict[str, xr.Dataset]:
    run, cell, way = found.run, found.run.cell, found.run.cell.way
    time = {"time": _array(("time",), way.time, "s", "time of feed")}
    bodies = time | {"body": list(cell.names), "axis": _AXES}
    vector, per_body = ("time", "axis"), ("time", "body", "axis")
    groups = {
        "motion": xr.Dataset({
            "travel": _array(("time",), way.travel, "m", "way along the pass"),
            "command": _array(("time", "joint"), way.commands, "m, rad", "command of each joint"),
            "program_line": _array(("time",), way.line, "1", "line of the program, 0 for a path"),
            "cuts": _array(("time",), way.cuts.astype(float), "1", "whether the tool cuts"),
            "position": _array(vector, run.ideal, "m", "ideal tool point in the part, r_0"),
            "tool_vector": _array(per_body, run.reach, "m", "tool point in each body's frame, r_i"),
            "body_origin": _array(per_body, run.at.origins, "m", "origins of the bodies in the part"),
            "geometric_error": _array(("time", "body", "component"), run.geometric, "m, rad", "geometric errors"),
        }, bodies | {"component": _COMPONENTS, "joint": list(cell.names[1:])}),
        "cutting": xr.Dataset({
            "force": _array(vector, cell.cut.force, "N", "cutting force on the tool"),
        }, time | {"axis": _AXES}),
        "structure": xr.Dataset({
            "twist": _array(("time", "body", "component"), run.twists, "m, rad", "error of each body in its frame"),
            "f1": _array(per_body, run.local, "m", "error of the tool point by a body, in its frame"),
            "f2": _array(per_body, run.body, "m", "error of the tool point by a body, in the part"),
            "f3": _array(vector, run.body[:, 0], "m", "deformation of the part"),
            "work_of_loads": _array(("time",), run.external, "J", "sum of loads times displacements"),
            "work_of_elements": _array(("time",), run.internal, "J", "sum of W C W"),
        }, bodies | {"component": _COMPONENTS}),
        "surface": _surface_group(found),
        "budget": _budget_group(found),
    }  # fmt: skip
    if cell.cut.immersion is not None:
        groups["engagement"] = xr.Dataset({
            "immersion": _array(("time",), cell.cut.immersion, "rad", "immersion angle"),
        }, time)  # fmt: skip
    if found.chances is not None:
        groups["uncertainty"] = xr.Dataset({
            "variance_share": _array(("body",), found.chances.shares, "1", "share of the body in the variance"),
            "deviation": _array(("axis",), found.chances.deviation, "m", "standard deviation"),
        }, {"body": list(cell.names), "axis": _AXES})  # fmt: skip
    return groups


def _surface_group(found: MachinePass) -> xr.Dataset:
    run = found.run
    coordinates = {"time": _array(("time",), run.cell.way.time, "s", "time of feed"), "axis": _AXES}
    variables = {
        "f4": _array(("time", "axis"), run.deviation, "m", "error of the tool point in the part"),
        "f5": _array(("time", "axis"), run.ideal + run.deviation, "m", "tool point as machined"),
        "exact": _array(("time", "axis"), run.exact, "m", "the same error by exact composition"),
        "tilt": _array(("time", "axis"), run.rotation, "rad", "error of the tool's direction"),
    }
    if found.wall is not None:
        coordinates["height"] = _array(("height",), found.wall.height, "m", "height above the tool point")
        variables["wall_error"] = _array(("time", "height"), found.wall.error, "m", "error along the wall's normal")
    way = run.cell.way
    if np.ptp(way.direction[way.cuts], axis=0).max(initial=0.0) > _TURNED:
        seen = run.size if found.wall is None else found.wall.error[:, 0]
        variables["error_on_path"] = _array(
            ("time",), np.where(way.cuts, seen, np.nan), "m", "length of the error" if found.wall is None
            else "error of the wall at the tool point",
        )  # fmt: skip
    return xr.Dataset(variables, coordinates)


def _budget_group(found: MachinePass) -> xr.Dataset:
    run, worst = found.run, found.run.worst
    shares = budget.signed_shares(run.contributions[worst], run.deviation[worst])
    body = budget.signed_shares(run.body[worst], run.deviation[worst])
    return xr.Dataset({
        "contribution": _array(("element", "axis"), run.contributions[worst], "m", "error by an element, worst place"),
        "share": _array(("element",), shares, "m", "signed share along the error, worst place"),
        "stiffening_gain": _array(("element",), found.gain, "m", "change of the error with 10 % more stiffness"),
        "body_contribution": _array(("body", "axis"), run.body[worst], "m", "error by a body, worst place"),
        "body_share": _array(("body",), body, "m", "signed share of a body, worst place"),
    }, {"element": list(run.element_names), "axis": _AXES, "body": list(run.cell.names)})  # fmt: skip


def _volume_group(volume: VolumeMap) -> xr.Dataset:
    grid = ("X", "Y", "Z")
    return xr.Dataset({
        "error": _array((*grid, "axis"), volume.error, "m", "geometric error of the tool point in the part"),
        "position": _array((*grid, "axis"), volume.position, "m", "ideal tool point in the part"),
        "diagonal_error": _array(("diagonal", "point"), volume.along, "m", "error along the body diagonal"),
        "diagonal_distance": _array(("diagonal", "point"), volume.distance, "m", "distance along the body diagonal"),
    }, {
        **{name: _array((name,), at, "m", f"command of axis {name}") for name, at in zip(grid, volume.at, strict=True)},
        "axis": _AXES,
        "diagonal": ["+++", "-++", "+-+", "--+"],
    })  # fmt: skip


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
