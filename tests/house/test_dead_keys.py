"""No key is accepted and then ignored: turned by itself it moves a result, is refused, or is told not to count.

Every key of every example is turned, with the values that it has and those that it may have. One that moves nothing
has to stand in the table below with its reason.
"""

from fnmatch import fnmatchcase

import numpy as np
from house import perturbation
import pytest
from pydantic import ValidationError

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome, simulate
from cutwise.results import SolverFailure
from cutwise.spec.faults import ScenarioFault, dotted
from cutwise.spec.notices import notices
from cutwise.spec.scenario import Origin

_SAME = 1e-9  # of a measure, within rounding
_UNUSUAL = " is unusual; usual is "  # says nothing about whether the value is used

_SHORT = """G21 G17 G90 G94 G40 G61
S8000 M3
T1 M6
G0 X40 Y26 Z5
G1 Z-5 F300
F2400
G1 X48
G3 X52 Y30 I0 J4
G1 Y33 X51
G0 Z5
M2
"""
_LINE = ("path.line.from=[1900 mm, -8 mm, 800 mm]", "path.line.to=[1900 mm, 8 mm, 800 mm]")
_STOCK = "stock={x: [35 mm, 56 mm], y: [15 mm, 45 mm], z: [-20 mm, 0 mm]}"
CASES = {  # the examples, short and coarse
    "chamfer_compliant_spindle": ("path.points=24", "operation.contact_feed=200 mm/s", "part.pipe.hole_radius=2 mm"),
    "chamfer_pipe_hole": ("path.points=48", "setup.samples=50"),
    "chamfer_step_part": (
        "part.block.holes=[{x: 20 mm, y: 20 mm, radius: 3 mm}]", "part.edges='hole:1'", "path.chord_tolerance=20 um",
    ),
    "deburr_compliant_spindle": ("operation.duration=0.12 s", "operation.lead_in_time=0.05 s"),
    "deburr_on_robot": (*_LINE, "operation.lead_in_time=0.05 s", "numerics.station=8 mm"),
    "deburr_arc": ("path.arc.sweep=15 deg", "operation.lead_in_time=0.05 s"),
    "drill_plate_pattern": (
        "hole.grid.columns=1", "part.placement.steps=2", "part.placement.y=[0 mm, 0 mm]", "numerics.angle_step=20 deg",
    ),
    "drill_robot": (),
    "machine_error_budget": ("uncertainty.samples=200",),
    "machine_five_axis": ("volume.points=3", "volume.diagonal_points=5", "path.samples=7", "uncertainty.samples=200"),
    "machine_pocket": ("program.file={program}", _STOCK, "program.samples=20"),
    "machine_volumetric_map": ("volume.points=3", "volume.diagonal_points=5"),
    "mill_on_robot": (*_LINE, "numerics.station=8 mm"),
    "mill_pocket": ("program={program}", "numerics.settling_time=0.02 s", "numerics.substeps=4"),
    "mill_pocket_corner": (
        "path.lead=5 mm", "path.turn=120 deg", "path.compare=[2 mm]", "numerics.settling_time=0.02 s",
        "numerics.substeps=4",
    ),
    "mill_pocket_stock": ("program={program}", _STOCK, "numerics.settling_time=0.02 s"),
}  # fmt: skip
STILL = {}


class Refused(Exception):
    """The values do not fit each other; what is only out of the range of a key shows nothing."""


def _words(texts):
    return sorted(text for text in texts if _UNUSUAL not in text)


def quick(scenario):
    """What a study sees of a scenario: its measures, what is wrong with them, and what is said about its values."""
    found = quick_outcome(scenario)
    return dict(found.measures), [finding.code for finding in found.findings], _words(notices(scenario))


def whole(scenario):
    """What a run says and keeps."""
    result = simulate(scenario)
    arrays = {
        f"{group.path}/{name}": np.asarray(variable.values)
        for group in result.stages.subtree
        for name, variable in group.dataset.variables.items()
    }
    measures = {name: measure.value for name, measure in result.measures.items()}
    words = [_words(result.warnings), list(result.infeasible), list(result.advice), dict(result.notes)]
    return measures, [finding.code for finding in result.findings], words, arrays


def same(one, other):
    """Whether two answers are the same within rounding."""
    if one.keys() != other.keys():
        return False
    return all(_alike(np.asarray(one[name]), np.asarray(other[name])) for name in one)


def _alike(one, other):
    if one.shape != other.shape or one.dtype.kind not in "fc":
        return one.shape == other.shape and bool((one == other).all())
    return bool(np.allclose(one, other, rtol=_SAME, atol=0.0, equal_nan=True))


def acts(before, scenario, look):
    """Whether something is another than before."""
    try:
        after = look(scenario)
    except (ScenarioFault, SolverFailure):
        return True
    if len(after) == 4 and not same(before[3], after[3]):
        return True
    return not same(before[0], after[0]) or before[1:3] != after[1:3]


class Turning:
    """An example whose keys are turned one by one."""

    def __init__(self, path, overrides):
        self.scenario = load(path, overrides)
        self.plain = self.scenario.model_dump(mode="json", exclude_unset=True, exclude_none=True)
        self.full = self.scenario.model_dump(mode="json")
        self.quick, self.whole = quick(self.scenario), None

    def turned(self, key, value):
        """The scenario with a key that its user wrote; None where the value is out of range."""
        plain = perturbation.with_value(self.plain, self.full, key.path, value)
        try:
            found = type(self.scenario).model_validate(plain)
        except ValidationError as fault:
            if {error["type"] for error in fault.errors()} == {"contradiction"}:
                raise Refused from None
            return None
        return found.with_origins({**self.scenario.origins, dotted(key.path): Origin("user")})

    def alive(self, key):
        """Whether some other value of a key is seen in a study, or, failing that, in a run."""
        if any(text.startswith(f"{dotted(key.path)}: is not used") for text in self.quick[2]):
            return True
        still, refused = [], False
        for value in perturbation.others(key):
            try:
                scenario = self.turned(key, value)
            except Refused:
                refused = True
                continue
            if scenario is None:
                continue
            if acts(self.quick, scenario, quick):
                return True
            still.append(scenario)
        if refused or not still:
            return refused
        self.whole = self.whole or whole(self.scenario)
        return any(acts(self.whole, scenario, whole) for scenario in still)


def listed(name, key):
    """Whether the table has the key of an example."""
    return any(fnmatchcase(name, where) and fnmatchcase(key, what) for where, what in STILL)
