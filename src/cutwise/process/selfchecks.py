"""Reference cases that a user can compute on his own machine: what is known, from where, and how close we come.

Each process adds a list; ``CHECKS`` is what ``cutwise selftest`` runs.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from cutwise.io.scenario import read_document
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import LINEAR, NO_KIENZLE, Edges, uneven_tooth_force
from cutwise.physics.engagement.arc import layer_arcs
from cutwise.process.recipes import quick_measures, simulate
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


@lru_cache(maxsize=8)
def _reference_pass(*overrides: str) -> Result:
    return simulate(read_document(_BERSELLI2016, "selftest", overrides))


def _measured(name: str, *overrides: str) -> Callable[[], float]:
    return lambda: _reference_pass(*overrides).measures[name].value


def _once_per_turn(runout: float) -> float:
    """Force off the work that turns with the mill, at the immersion of the reference case with no edge error."""
    mill = Mill(4e-3, 20, math.radians(20.0))
    edges = Edges(LINEAR, EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 0.0, 0.0, 0.0), NO_KIENZLE, runout, 0.0)
    arcs = layer_arcs(1e-3, 0.0, 0.0, mill.radius)
    turn = np.arange(500) * 2.0 * np.pi / 500
    force = [uneven_tooth_force(a, arcs.front_lo, arcs.front_hi, 6e-6, 0.0, 0.0, 1e-3, mill, edges).y for a in turn]
    return float(2.0 * abs(np.exp(1j * turn) @ np.array(force)) / turn.size)


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
    SelfCheck(
        "edge error, seals that give 50 µm", f"{_CASE}; presliding", "small_length", -12.4e-6, 0.1e-6,
        _measured("surface_error_mean", "spindle.friction=presliding", "spindle.breakaway_travel=50 um"),
    ),
    SelfCheck(
        "edge error, surface with memory", f"{_CASE}; step to 0: -9.452 µm", "small_length", -9.452e-6, 0.1e-6,
        _measured("surface_error_mean", "numerics.engagement=swept"),
    ),
    *(
        SelfCheck(f"force once per turn, run-out {um} µm", f"{_CASE}; tooth by tooth", "force", known, 0.06,
                  partial(_once_per_turn, um * 1e-6))
        for um, known in ((5, 5.7), (10, 9.8), (20, 13.9))
    ),
]  # fmt: skip

_DEMEC = {
    "name": "selftest",
    "process": "machine",
    "machine": {"library": "demec_mill"},
    "tool": {"library": "demec", "flexible": False},
    "part": {
        "width_x": "260 mm", "width_y": "90 mm", "height": "300 mm", "weight": "540 N", "flexible": True,
        "youngs_modulus": "210 kN/mm^2", "poisson_ratio": 0.3, "shear_factor": 5.0 / 6.0,
    },
    "path": {"points": [{"X": "0 mm"}, {"X": "260 mm"}], "feed": "400 mm/min", "samples": 27},
    "load": {"force": ["4000 N", "4000 N", "2000 N"], "weights": True},
    "surface": {"normal": [0, 1, 0], "depth": "5 mm"},
}  # fmt: skip


@lru_cache(maxsize=1)
def _mill() -> Result:
    return simulate(read_document(_DEMEC, "selftest"))


_MILL = "Demeč and Madáč, compliances assumed"
MACHINE = [
    *(
        SelfCheck(f"error of a loaded mill along {axis}, start", f"{_MILL}; superposition of displacements",
                  "small_length", known, 4e-10, partial(lambda name: _mill().measures[name].value, f"deviation_{axis}_start"))
        for axis, known in (("x", 337.62845386e-6), ("y", 276.93305676e-6), ("z", 47.61099844e-6))
    ),
    SelfCheck("energy balance of a loaded mill", f"{_MILL}; Clapeyron", "dimensionless", 0.0, 1e-12,
              lambda: _mill().measures["energy_balance"].value),
]  # fmt: skip

_REFERENCE_HOLE = {
    "name": "selftest",
    "process": "drill",
    "operation": {"feed_per_rev": "0.1 mm/rev", "spindle_speed": "3000 rpm"},
    "hole": {"position": ["1900 mm", "300 mm", "800 mm"], "axis": [0, 0, -1]},
    "part": {"thickness": "5 mm"},
    "tool": {"library": "twist_6mm"},
    "material": {"library": "al2024"},
    "contact": {"friction": 0.2, "wall_stiffness": "5 N/um", "wander_length": "6 mm"},
    "robot": {
        "library": "kr270_r2700", "redundancy_angle": "26 deg",
        "joint_angles": ["-18 deg", "39 deg", "-115 deg", "45 deg", "80 deg", "-10 deg"],
    },
}  # fmt: skip


@lru_cache(maxsize=2)
def _drilled(*overrides: str) -> Result:
    return simulate(read_document(_REFERENCE_HOLE, "selftest", overrides))


def _of_hole(name: str, *overrides: str) -> Callable[[], float]:
    return lambda: _drilled(*overrides).measures[name].value


_HOLE = "after Garnier et al. 2017, gaps filled; two independent programs"
DRILLING = [
    SelfCheck("thrust of the lips", f"{_HOLE}; closed form", "force", 87.5726733, 1e-6, _of_hole("thrust_lips")),
    SelfCheck(
        "thrust of the chisel edge", f"{_HOLE}; closed form", "force", 76.3216934, 1e-6, _of_hole("thrust_chisel"),
    ),
    SelfCheck(
        "axial compliance of the arm", f"{_HOLE}; 26 degrees", "compliance", 0.768923e-6, 1e-12,
        _of_hole("compliance_axial"),
    ),
    SelfCheck("skating ratio", f"{_HOLE}; 26 degrees", "dimensionless", 0.115890, 1e-6, _of_hole("skating_ratio")),
    SelfCheck(
        "hole position error at entry", f"{_HOLE}; step to 0", "small_length", 1.0208e-6, 0.01e-6,
        _of_hole("hole_position_error_entry"),
    ),
    SelfCheck(
        "perpendicularity error", f"{_HOLE}; step to 0", "small_angle", 0.3620e-3, 0.0036e-3,
        _of_hole("perpendicularity_error"),
    ),
    SelfCheck(
        "redundancy angle that skates least", f"{_HOLE}; continuous search", "angle", 0.429246, 1e-5,
        _of_hole("redundancy_angle", "robot.redundancy_angle=least_skating"),
    ),
]  # fmt: skip


_OZCAN2017 = {
    "name": "selftest",
    "process": "mill",
    "path": {"corner": "sharp", "lead": "30 mm"},
    "operation": {"feed": "40 mm/s", "spindle_speed": "8000 rpm", "axial_depth": "5 mm", "radial_depth": "4 mm"},
    "tool": {"library": "endmill_20_3"},
    "material": {"library": "al7075t6"},
    "machine": {"library": "fadal2216", "reading": "kp_ki_swapped"},
    "numerics": {"discs": 20},
}


@lru_cache(maxsize=8)
def _corner(name: str, *overrides: str) -> float:
    return quick_measures(read_document(_OZCAN2017, "selftest", overrides))[name]


_CORNER = "Ozcan et al. 2017, reference corner by an independent program"
_FILLET = "path.corner=2 mm"
MILLING = [
    SelfCheck("time through a sharp corner", _CORNER, "time", 1.6131370850, 1e-9, partial(_corner, "cycle_time")),
    SelfCheck("contour error, sharp corner", _CORNER, "small_length", 3.578e-6, 0.01e-6,
              partial(_corner, "contour_error_max")),
    SelfCheck("contour error, fillet of 2 mm", _CORNER, "small_length", 37.94e-6, 0.01e-6,
              partial(_corner, "contour_error_max", _FILLET)),
    SelfCheck("contour error, fillet, gains as printed", _CORNER, "small_length", 7.682e-6, 0.01e-6,
              partial(_corner, "contour_error_max", _FILLET, "machine.reading=as_printed")),
    SelfCheck("contour error, fillet, matched gains", _CORNER, "small_length", 34.894e-6, 0.01e-6,
              partial(_corner, "contour_error_max", _FILLET, "machine.reading=matched")),
    SelfCheck("peak force in the sharp corner", _CORNER, "force", 562.11, 0.6, partial(_corner, "force_xy_peak")),
    SelfCheck("overshoot at the end", _CORNER, "small_length", 30.982e-6, 0.01e-6,
              partial(_corner, "settling_overshoot")),
]  # fmt: skip

CHECKS: list[SelfCheck] = [*DEBURRING, *MACHINE, *DRILLING, *MILLING]
