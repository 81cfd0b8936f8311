"""Reference cases that a user can compute on his own machine: what is known, from where, and how close we come.

Each process adds a list; ``CHECKS`` is what ``cutwise selftest`` runs.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import NamedTuple

from cutwise.io.scenario import read_document
from cutwise.process.recipes import simulate
from cutwise.results import Result


class SelfCheck(NamedTuple):
    """A number that is known, and the computation that has to meet it."""

    name: str
    source: str
    dimension: str
    expected: float  # SI
    tolerance: float  # SI, largest absolute deviation that passes
    compute: Callable[[], float]


class Outcome(NamedTuple):
    """What a check came to."""

    check: SelfCheck
    found: float  # SI
    passed: bool

    @property
    def deviation(self) -> float:
        """Found minus expected, SI."""
        return self.found - self.check.expected


def outcomes(checks: Iterable[SelfCheck]) -> Iterator[Outcome]:
    """Compute the checks one after the other."""
    for check in checks:
        found = check.compute()
        yield Outcome(check, found, abs(found - check.expected) <= check.tolerance)


_BERSELLI2016 = {
    "name": "selftest",
    "process": "deburr",
    "operation": {
        "feed": "80 mm/s", "spindle_speed": "40000 rpm", "preset": "2 mm", "milling": "down", "duration": "0.6 s",
        "lead_in_time": "0.2 s", "clearance": "0.5 mm", "path_error": "none",
    },
    "part": {
        "burr": {"height": "1 mm", "width": "1 mm", "axial_start": "0 mm"},
        "contact_length": "10 mm", "axial_start": "0 mm",
    },
    "tool": {"library": "berselli2016"},
    "material": {"library": "berselli2016"},
    "spindle": {"library": "berselli2016"},
}  # fmt: skip


@lru_cache(maxsize=4)
def _reference_pass(*overrides: str) -> Result:
    return simulate(read_document(_BERSELLI2016, "selftest", overrides))


def _measured(name: str, *overrides: str) -> Callable[[], float]:
    return lambda: _reference_pass(*overrides).measures[name].value


_CASE = "Berselli et al. 2016, sec. 4, geometry assumed"
DEBURRING = [
    SelfCheck(
        "edge error, true stick", f"{_CASE}; step to 0: -9.452 µm", "small_length", -9.452e-6, 0.1e-6,
        _measured("surface_error_mean"),
    ),
    SelfCheck(
        "edge error without friction", f"{_CASE}; equilibrium", "small_length", 177.4e-6, 0.2e-6,
        _measured("surface_error_mean", "spindle.friction=none"),
    ),
    SelfCheck(
        "edge error, loading plateau", f"{_CASE}; quasi-static", "small_length", -13.8e-6, 0.2e-6,
        _measured("surface_error_loaded"),
    ),
    SelfCheck(
        "burr force along the feed", f"{_CASE}; step to 0", "force", 5.7024, 1e-3, _measured("burr_force_mean_x"),
    ),
    SelfCheck(
        "burr force off the work", f"{_CASE}; step to 0", "force", 9.3843, 1e-3, _measured("burr_force_mean_y"),
    ),
    SelfCheck(
        "burr force along the spindle", f"{_CASE}; closed form", "force", 3.8197, 1e-3, _measured("burr_force_mean_z"),
    ),
    SelfCheck(
        "breakaway force of the spindle at 5 bar", f"{_CASE}; support function", "force", 13.78, 0.01,
        _measured("breakaway_force"),
    ),
    SelfCheck(
        "loading plateau of the spindle at 5 bar", f"{_CASE}; support function", "force", 12.48, 0.01,
        _measured("loading_force"),
    ),
    SelfCheck(
        "unloading plateau of the spindle at 5 bar", f"{_CASE}; support function", "force", 5.82, 0.01,
        _measured("unloading_force"),
    ),
]  # fmt: skip

CHECKS: list[SelfCheck] = [*DEBURRING]
