"""At which depth a cut chatters, from what yields with its mass: the same for a mill on an arm and a turned shaft."""

import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.regeneration import Receptance
from cutwise.process import yielding
from cutwise.results import Finding, Place


def together(
    modes: Iterable[yielding.Mode], other: Receptance | None, axes: FloatArray | None = None
) -> Receptance | None:
    """Displacement at the tip for a force there, by the modes of a tool and something else; None where nothing has mass.

    ``axes``: directions x, y of the modes in those of the process, as rows.
    """
    given = tuple(modes)
    if other is None and not given:
        return None

    def receptance(omega: FloatArray) -> np.ndarray:
        total = yielding.mode_receptance(given, omega, axes)
        return np.asarray(total if other is None else total + other(omega))

    return receptance


def measures(depth: float, limit: float) -> dict[str, float]:
    """How much of the limit a depth of cut leaves [m]; without a limit, all of it."""
    known = {"stable_depth_min": limit} if math.isfinite(limit) else {}
    return {"depth_margin": 1.0 - depth / limit, **known}


def findings(found: Mapping[str, float], what: str) -> Iterator[Finding]:
    """A depth at which something chatters; the value is that depth over its limit."""
    if found.get("depth_margin", 1.0) <= 0.0:
        yield Finding("unstable", Place(what), 1.0 - found["depth_margin"], 1.0, measure="depth_margin")
