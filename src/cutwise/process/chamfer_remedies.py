"""What helps where the chamfer of a pipe cannot be cut: one change at a time, planned again and found to work."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from cutwise.paths import reach
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.spec.chamfer import ChamferScenario, Pipe

Planned = Callable[[ChamferScenario], Sequence[EdgePath] | None]  # the paths of a case, or None if it is infeasible

_POINTS = 120  # of paths that are tried
_SPARE = 2e-3  # share by which a limit that was found is made smaller, for the points that were left out
_SMALLEST = 0.02  # of a width or radius that is tried
_BALLS = (1.05, 1.15, 1.3, 1.5, 1.75, 2.0, 2.5, 3.0)
_HALVINGS = 10
_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")


def changed(scenario: ChamferScenario, **sections: dict[str, Any]) -> ChamferScenario:
    """A scenario with some keys of some sections changed, in SI."""
    return scenario.model_copy(
        update={name: getattr(scenario, name).model_copy(update=keys) for name, keys in sections.items()}
    )


def remedies(scenario: ChamferScenario, failed: set[str], planned: Planned) -> tuple[str, ...]:
    """What helps, in the order in which to try it, with the key to change; each is planned before it is said.

    Parameters
    ----------
    scenario : ChamferScenario
        A pipe whose chamfer is infeasible.
    failed : set of str
        Codes of the inequalities that do not hold.
    planned : callable
        Paths of a changed case, or None.
    """
    tried = changed(scenario, path={"points": _POINTS, "chord_tolerance": None})

    def works(case: ChamferScenario) -> bool:
        return planned(case) is not None

    found: list[str] = []
    if reach.EDGE in failed:
        assert scenario.part.pipe is not None
        found += _closing(scenario.part.pipe, inner=scenario.part.edges != "outer")
    else:
        for way in (_tilt(tried, planned), _width(tried, works), _rod(tried, works), _ball(tried, works)):
            found += way
    found += _axis(tried, works)
    if scenario.part.edges == "all":
        alone = [side for side in ("outer", "inner") if works(changed(tried, part={"edges": side}))]
        found += [f"only the {side} edge (part.edges: {side})" for side in alone]
    if not found:
        found += _together(tried, works)
    if failed & {reach.ROD_WALL, reach.ROD_PART, reach.KNIFE}:
        found.append(
            "not worked out here: a tool axis that leans (5 axes), with the rod looked at again at the far edge"
        )
    return tuple(found)


def _closing(pipe: Pipe, *, inner: bool) -> Iterator[str]:
    rho = pipe.radius - (pipe.wall if inner else 0.0)
    hole, off = rho - abs(pipe.eccentricity), rho - pipe.hole_radius
    if hole > _SMALLEST * pipe.hole_radius:
        yield f"a hole of less than {_mm(hole)} radius (part.pipe.hole_radius): then its edge closes"
    if off > 0.0:
        yield f"a hole less than {_mm(off)} off the axis of the pipe (part.pipe.eccentricity)"


def _tilt(scenario: ChamferScenario, planned: Planned) -> Iterator[str]:
    if scenario.chamfer.tilt == "auto" or scenario.chamfer.definition == "leg":
        return
    paths = planned(changed(scenario, chamfer={"tilt": "auto"}))
    if paths:
        tilt = max((path.tilt for path in paths), key=abs)
        if not tilt:
            yield "no tilt is needed (chamfer.tilt: auto)"
            return
        yield f"tilt the chamfer by {math.degrees(tilt):.4g} deg (chamfer.tilt: auto): three axes, the width stays"


def _width(scenario: ChamferScenario, works: Callable[[ChamferScenario], bool]) -> Iterator[str]:
    found = _largest(lambda width: works(changed(scenario, chamfer={"width": width})), scenario.chamfer.width)
    if found:
        fixed = "" if scenario.chamfer.tilt == "auto" else " at this tilt"
        yield f"a chamfer of {_mm(found)} or less{fixed} (chamfer.width)"


def _rod(scenario: ChamferScenario, works: Callable[[ChamferScenario], bool]) -> Iterator[str]:
    """A thinner rod; if that is not enough, with a knife that begins nearer to it."""
    tool = scenario.tool

    def knife_for(rod: float) -> float:
        least = math.degrees(math.asin(min(1.0, rod / tool.ball_radius)))
        return min(tool.knife_limit_angle, math.radians(math.ceil(10.0 * least) / 10.0))

    found = _largest(lambda rod: works(changed(scenario, tool={"rod_radius": rod})), tool.rod_radius)
    if found:
        yield f"a rod of {_mm(found)} radius or less (tool.rod_radius)"
        return
    found = _largest(
        lambda rod: works(changed(scenario, tool={"rod_radius": rod, "knife_limit_angle": knife_for(rod)})),
        tool.rod_radius,
    )
    if found:
        thinner = f"a rod of {_mm(found)} radius or less (tool.rod_radius) with " if found < tool.rod_radius else ""
        knife = f"{math.degrees(knife_for(found)):.3g} deg"
        yield f"{thinner}a knife from {knife} or less (tool.knife_limit_angle)"


def _ball(scenario: ChamferScenario, works: Callable[[ChamferScenario], bool]) -> Iterator[str]:
    """The nearest larger ball and the nearest smaller one; with a smaller ball the rod shrinks if it has to."""
    tool = scenario.tool
    for larger in (True, False):
        for factor in _BALLS:
            ball = _three(tool.ball_radius * (factor if larger else 1.0 / factor))
            thick = tool.rod_radius > ball * math.sin(tool.knife_limit_angle)
            rod = _three(tool.rod_radius / factor) if thick else tool.rod_radius
            if works(changed(scenario, tool={"ball_radius": ball, "rod_radius": rod})):
                with_rod = f" with a rod of {_mm(rod)} (tool.rod_radius)" if thick else ""
                yield f"a ball of {_mm(ball)} radius (tool.ball_radius){with_rod}"
                break


def _axis(scenario: ChamferScenario, works: Callable[[ChamferScenario], bool]) -> Iterator[str]:
    now = scenario.tool.axis
    good = [axis for axis in ("auto", *_AXES) if axis != now and works(changed(scenario, tool={"axis": axis}))]
    if good:
        yield f"another tool axis (tool.axis: {' or '.join(good)})"


def _together(scenario: ChamferScenario, works: Callable[[ChamferScenario], bool]) -> Iterator[str]:
    """Changes of two keys, for what no single one mends."""
    for axis in (scenario.tool.axis, *_AXES):
        case = changed(scenario, tool={"axis": axis})
        if scenario.chamfer.definition == "chord":
            case = changed(case, chamfer={"tilt": "auto"})
        found = [text for way in (_width, _rod, _ball) for text in way(case, works)]
        if found:
            keys = [] if axis == scenario.tool.axis else [f"tool.axis: {axis}"]
            keys += ["chamfer.tilt: auto"] if scenario.chamfer.tilt not in ("auto", case.chamfer.tilt) else []
            yield from (f"{text}, with {' and '.join(keys)}" if keys else text for text in found)
            return
    yield "nothing that was tried helps: narrower chamfers, thinner rods, other balls, other tool axes"


def _largest(works: Callable[[float], bool], now: float) -> float | None:
    """The largest value up to now at which a case works, a little less of it; None if small ones do not either."""
    low, high = _SMALLEST * now, now
    if works(high):
        return high
    if not works(low):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if works(middle) else (low, middle)
    found = _three(low * (1.0 - _SPARE))
    return found if works(found) else None


def _three(value: float) -> float:
    """Rounded down to three figures."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return float(np.floor(value / step * (1.0 + 1e-12)) * step)


def _mm(value: float) -> str:
    return f"{value * 1e3:.4g} mm"
