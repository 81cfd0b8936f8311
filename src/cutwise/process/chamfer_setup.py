"""Widths to expect when part and tool are not quite where and what they should be."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.paths.pipe import PipeHole, pipe_edge
from cutwise.physics.surface.sweep import swept_chamfer
from cutwise.spec.chamfer import ChamferScenario

_STEP = 1e-6  # [m] and [rad] of the difference quotients


class SetupBand(NamedTuple):
    """Widths under random set-up errors; linear in the errors, from sweeps of the perturbed case."""

    names: tuple[str, ...]
    slope: FloatArray  # width change per unit of each error, shape (m, errors)
    deviation: FloatArray  # standard deviation of each error, shape (errors,)
    low: float  # [m] 5 % of the set-ups have a smaller smallest width
    high: float  # [m] 5 % have a larger largest width
    low_along: FloatArray  # [m] the same place by place, shape (m,)
    high_along: FloatArray

    def __str__(self) -> str:
        order = np.argsort(-(np.abs(self.slope).max(axis=0) * self.deviation))
        worst = [
            f"{self.names[i]} {units.show(float(np.abs(self.slope[:, i]).max() * self.deviation[i]), 'length', 3)}"
            for i in order[:4] if self.deviation[i] > 0.0
        ]  # fmt: skip
        return (
            f"90 % of the set-ups stay within {units.show(self.low, 'length', 4)} to {units.show(self.high, 'length', 4)}; "
            f"one standard deviation counts most for {', '.join(worst)}: probe these first"
        )


def setup_band(scenario: ChamferScenario, part: PipeHole | None, paths: Sequence[EdgePath]) -> SetupBand | None:
    """Monte-Carlo widths for the set-up errors of a scenario; None if none of them is above zero."""
    setup = scenario.setup
    assert setup is not None
    errors = {
        "position x": setup.position, "position y": setup.position, "position z": setup.position,
        "ball radius": setup.ball_radius,
    }  # fmt: skip
    if part is not None:
        errors |= {
            "pipe radius": setup.radius, "hole radius": setup.radius, "wall": setup.wall,
            "inclination": setup.angle, "eccentricity": 0.0,
        }  # fmt: skip
    names = tuple(name for name, size in errors.items() if size > 0.0)
    if not names:
        return None
    width = np.concatenate([path.found.width for path in paths])
    slope = np.column_stack(
        [np.concatenate([_slope(scenario, part, path, name) for path in paths]) for name in names]
    )  # fmt: skip
    deviation = np.array([errors[name] for name in names])
    known = np.isfinite(slope).all(axis=1) & np.isfinite(width)
    random = np.random.default_rng(setup.seed).standard_normal((setup.samples, len(names))) * deviation
    smallest, largest = np.full(setup.samples, np.inf), np.full(setup.samples, -np.inf)
    for start in range(0, setup.samples, 500):
        some = slice(start, start + 500)
        found = width[known] + random[some] @ slope[known].T
        smallest[some], largest[some] = found.min(axis=1), found.max(axis=1)
    spread = 1.6449 * np.sqrt((slope**2) @ deviation**2)
    return SetupBand(
        names, slope, deviation, max(0.0, float(np.quantile(smallest, 0.05))), float(np.quantile(largest, 0.95)),
        width - spread, width + spread,
    )  # fmt: skip


def _slope(scenario: ChamferScenario, part: PipeHole | None, path: EdgePath, name: str) -> FloatArray:
    """Width change along a path per unit of one error, by sweeps at plus and minus a micrometre or microradian."""
    widths = [perturbed_width(scenario, part, path, name, sign * _STEP) for sign in (1.0, -1.0)]
    return (widths[0] - widths[1]) / (2.0 * _STEP)


def perturbed_width(
    scenario: ChamferScenario, part: PipeHole | None, path: EdgePath, name: str, size: float
) -> FloatArray:  # fmt: skip
    """Width along a path with one set-up error: the tool shifted, or the part or the ball another than planned [m]."""
    at: EdgeFrames = path.at
    centre, radius = path.path.centre, scenario.tool.ball_radius
    if name.startswith("position"):
        centre = centre + size * np.eye(3)["xyz".index(name[-1])]
    elif name == "ball radius":
        radius += size
    else:
        assert part is not None
        key = {"pipe radius": "radius", "hole radius": "hole_radius", "wall": "wall", "inclination": "inclination"}[
            name
        ]
        other = part._replace(**{key: getattr(part, key) + size})
        at = pipe_edge(other, at.parameter, inner=path.work.inner)
    reach = 2.5 * float(path.path.leg.max()) + 3.0 * abs(size)
    return swept_chamfer(at, centre, radius, reach, closed=path.path.frames.closed).width
