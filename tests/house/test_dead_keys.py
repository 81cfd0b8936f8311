"""No key is accepted and then ignored: turned by itself it moves a result, is refused, or is told not to count.

Every key of every example is turned, with the values that it has and those that it may have. One that moves nothing
has to stand in the table below with its reason.
"""

from fnmatch import fnmatchcase

import numpy as np
import pytest
from pydantic import ValidationError

from cutwise.io import library
from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome, simulate
from cutwise.results import SolverFailure
from cutwise.spec.faults import ScenarioFault, dotted
from cutwise.spec.notices import notices
from cutwise.spec.scenario import Origin
from house import perturbation

_SAME = 1e-9  # of a measure, within rounding
# covariances and measured come with the entries; correct and compare are read by the commands of those names
_OF_THE_LOADER = ("name", "process", "requirements", "covariances", "measured", "correct", "compare")
_UNUSUAL = " is unusual; usual is "  # says nothing about whether the value is used

_SHORT = """G21 G17 G90 G94 G40 G61
T1 M6
S8000 M3
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
    "cell_robot_wall": (*_LINE, "numerics.station=8 mm"),
    "chamfer_compliant_spindle": ("path.points=24", "operation.contact_feed=150 mm/s", "part.pipe.hole_radius=2 mm"),
    "chamfer_on_robot": ("path.points=24",),
    "chamfer_on_machine": ("path.points=24", "operation.contact_feed=60 mm/s"),
    "chamfer_pipe_hole": ("path.points=48", "setup.samples=50"),
    "chamfer_step_part": (
        "part.block.holes=[{x: 20 mm, y: 20 mm, radius: 3 mm}]", "part.edges='hole:1'", "path.chord_tolerance=20 um",
    ),
    "compare_slot": ("pocket.x=[16 mm, 48 mm]", "numerics.settling_time=0.02 s", "numerics.substeps=4"),
    "correct_corner": ("path.lead=6 mm", "numerics.settling_time=0.02 s", "numerics.substeps=4"),
    "correct_deburr": ("operation.length=20 mm", "operation.lead_in_time=0.05 s", "numerics.time_step=100 us"),
    "correct_drill": (),
    "correct_part": ("numerics.stock={grid: 1 mm, station: 5 mm, elements: 4, check: 300, sweep: ideal}",),
    "correct_pocket": ("program={program}", _STOCK, "numerics.settling_time=0.02 s", "numerics.substeps=4"),
    "correct_wall": ("numerics.settling_time=0.02 s", "numerics.substeps=4"),
    "deburr_compliant_spindle": ("operation.duration=0.12 s", "operation.lead_in_time=0.05 s"),
    "deburr_on_robot": (*_LINE, "operation.lead_in_time=0.05 s", "numerics.station=8 mm"),
    "deburr_arc": ("path.arc.sweep=15 deg", "operation.lead_in_time=0.05 s"),
    "deburr_rigid_on_machine": ("numerics.station=100 mm",),
    "drill_on_machine": (),
    "drill_plate_pattern": (
        "hole.grid.columns=1", "part.placement.steps=2", "part.placement.y=[0 mm, 0 mm]", "numerics.angle_step=20 deg",
    ),
    "drill_robot": (),
    "machine_error_budget": ("uncertainty.samples=200",),
    "machine_five_axis": ("volume.points=3", "volume.diagonal_points=5", "path.samples=7", "uncertainty.samples=200"),
    "machine_on_robot": ("path.samples=3",),
    "machine_pocket": ("program.file={program}", _STOCK, "program.samples=20"),
    "machine_volumetric_map": ("volume.points=3", "volume.diagonal_points=5"),
    "mill_on_machine": ("path.line.length=4 mm", "path.cut_from=1 mm", "numerics.settling_time=0.02 s", "numerics.substeps=4"),
    "mill_on_robot": (*_LINE, "numerics.station=8 mm"),
    "mill_part": (
        "numerics.stock={grid: 1 mm, station: 5 mm, elements: 4, check: 300}", "part.samples=3000",
    ),
    "mill_pocket": ("program={program}", "numerics.settling_time=0.02 s", "numerics.substeps=4"),
    "mill_pocket_corner": (
        "path.lead=5 mm", "path.turn=120 deg", "path.compare=[2 mm]", "numerics.settling_time=0.02 s",
        "numerics.substeps=4",
    ),
    "mill_pocket_stock": (
        "program={program}", _STOCK, "numerics.settling_time=0.02 s", "numerics.substeps=4", "lobes.speeds=2",
        "lobes.depths=2",
    ),
    "turn_shaft": ("numerics.station=40 mm",),
}  # fmt: skip
ONLY = {  # keys that are turned where an example costs much; the others are turned in examples beside it
    "cell_robot_wall": ("cell*", "robot.base_compliance", "part*", "tool.stiffness"),
    "chamfer_on_robot": ("robot.*", "placement*", "spindle"),
    "chamfer_on_machine": (
        "machine.drives.[xyz]*",
        "machine.chain[[][1-3]]*",
        "placement*",
        "tool.[sm]*",
        "part.stiffness",
    ),
    "chamfer_step_part": ("part.*", "path.*", "chamfer.*", "tool.[abp]*"),
    "deburr_on_robot": ("path*", "placement", "robot.*", "numerics.[es]*"),
    "drill_plate_pattern": ("hole*", "part*", "numerics*", "robot.redundancy*", "robot.joint_[al]*"),
    "machine_five_axis": (
        "machine.chain*",
        "machine.geometry_errors.[XYZABC]*",
        "machine.geometry_errors.E?[AC]*",
        "[!m]*",
    ),
    "mill_on_machine": ("path*", "stability", "placement", "operation*", "load*", "numerics.[sm]*"),
    "correct_part": ("tools*",),
    "correct_pocket": ("tool.[ds]*",),
    "compare_slot": ("pocket*", "shop*", "wear*"),
    "correct_corner": ("path_mode*",),
    "correct_deburr": ("operation.feed*",),
    "correct_drill": ("hole*",),
    "correct_wall": ("tool.[ds]*",),
    "mill_on_robot": ("[ops]*", "tool*", "material*", "lobes*", "numerics*", "robot.[!ju]*", "robot.joint_*"),
    "mill_pocket": ("[!m]*", "material*"),
    "mill_pocket_stock": (
        "stock*",
        "stability",
        "tool.[mr]*",
        "path_mode*",
        "lobes.speeds",
        "operation*",
        "program.top",
    ),
}

STILL = {  # keys that may move nothing: example, key, and why that is right
    ("*", "*.library"): "the name of an entry, whose values are written out; see the test of entries below",
    ("*", "*.joints[[]*].name"): "a name, for messages",
    ("*", "*.chain[[]*].name"): "a name, for tables, messages and measures",
    ("*", "*.chain[[]0].elements"): "nothing can be put there: the first body has no joint that could yield",
    ("*", "robot.urdf"): "a file, whose joints are read when the scenario is",
    ("*", "robot.tip_link"): "chooses a link of the URDF when it is read",
    ("*", "robot.urdf_remarks"): "filled in when the URDF is read, and said then",
    ("*", "spindle.solid"): "sizes, from which mass and inertia follow when the scenario is read",
    ("*", "spindle.solid_remarks"): "filled in when the solid is read, and said then",
    ("*", "program.file"): "a name; what counts is the text",
    ("*", "cell"): "names what the sections fill; a name too many or too few is a fault: tests/app/test_cell.py",
    ("*", "program.subroutines"): "the program of the example calls none",
    ("*", "program.offsets"): "the program of the example stays in G54; a system that is not chosen shifts nothing",
    ("*", "program.default_tool"): "the program of the example calls its tool before it moves",
    ("*", "program.step_limit"): "a limit of patience",
    ("chamfer_*", "spindle"): "rigid says in a word what a spindle that is left out means",
    ("machine_volumetric_map", "tool.stiffness"): "a map has no cut: nothing bends the tool",
    ("*", "program.wanted"): "the program before a correction: tests/unit/study/test_correct_path.py turns it",
    ("*", "program.dialect"): "the program of the example reads the same in both",
    ("*", "program.tools"): "the program of the example corrects for no length and no radius of its tool",
    ("*", "*.control.block_time"): "of what cutwise correct writes; a run plans the blocks that there are",
    ("*", "*.control.ramp"): "of what cutwise correct writes; the look-ahead of a run changes its speed inside the faster block",
    ("correct_[pw]*", "tool.stiffness"): "cutwise correct holds walls to it; a run of a program takes the tool as rigid",
    ("mill_pocket", "program.top"): "the program of the example cuts far below the top",
    ("machine_pocket", "program.start"): "feed moves alone count, and the first one is not the first move",
    ("chamfer_compliant_spindle", "chamfer.clearance"): "nothing stands beside the rod at the outer edge of a pipe",
    ("chamfer_*", "tool.flutes"): "without edge forces (K_te = 0) the mean force is that of the removal rate",
    ("chamfer_on_robot", "robot.modal_mass"): "has to be there; robot.dynamics: static leaves the mass out",
    ("chamfer_on_robot", "robot.damping"): "has to be there; robot.dynamics: static leaves the damping out",
    ("chamfer_pipe_hole", "tool.pole_limit_angle"): "the chamfer is far from the pole of the ball",
    ("deburr_arc", "path.tool_axis"): "has to be written; without a robot only length and curvature of the edge count",
    ("deburr_arc", "path.arc.centre"): "has to be written; without a robot only length and curvature of the edge count",
    ("deburr_arc", "path.arc.from"): "has to be written; without a robot only length and curvature of the edge count",
    ("deburr_on_robot", "robot.modal_mass"): "has to be there; robot.dynamics: static leaves the mass out",
    ("deburr_on_robot", "robot.damping"): "has to be there; robot.dynamics: static leaves the damping out",
    ("drill_*", "tool.helix"): "has to be there; simple lips have one rake (tool.lip_model)",
    ("drill_*", "tool.web"): "has to be there; simple lips go through the axis (tool.lip_model)",
    ("[cd]*_on_machine", "machine.gravity"): "has to be there; weights do not count where bodies carry a foreign tool, as is said",
    ("[cd]*_on_machine", "machine.chain[[]*].weight*"): "weights do not count, which is said of machine.chain",
    ("[cd]*_on_machine", "machine.chain[[]*].joint.errors_act"): "of geometric errors, which this machine has none of",
    ("[cd]*_on_machine", "machine.chain[[]*].joint.travel"): "an axis that does not come near its ends",
    ("[cd]*_on_machine", "machine.chain[[]3].joint.positive"): "an axis that stands at zero",
    ("[cd]*_on_machine", "machine.chain[[]4].joint.side"): "the ground may be on either side of the bed",
    ("deburr_rigid_on_machine", "operation.clearance"): "has to be there; at rest nothing is led in",
    ("deburr_rigid_on_machine", "part.slices"): "strips count by the tilt of the tool, which is 1e-8 here",
    ("deburr_rigid_on_machine", "tool.helix"): "the mean force over a revolution is the same for every helix",
    ("d*_on_machine", "part.block.weight"): "has to be there; weights do not count, as is said of machine.chain",
    ("mill_part", "tools[[]*].shank_diameter"): "the flutes are longer than any cut of the example is deep",
    ("mill_part", "tools[[]*].holder"): "the holder stays far above the stock",
    ("mill_part", "part.solid"): "the file of the example has one solid",
    ("mill_part", "numerics.stock.memory_limit"): "a limit of memory that the example does not come near",
    ("mill_on_machine", "path.orientation"): "on an arc only, and for a robot",
    ("mill_on_robot", "tool.helix"): "the mean force over a revolution is the same for every helix",
    ("machine_on_robot", "robot.modal_mass"): "has to be there; a pass at rest knows no mass",
    ("machine_on_robot", "robot.damping"): "has to be there; a pass at rest knows no damping",
    ("machine_on_robot", "robot.singularity_margin"): "the wrist of the example is far from singular",
    ("machine_on_robot", "part.weight"): "has to be there; the part rests on the ground before a robot",
    ("*_on_robot", "operation.limit_feed"): "the joints follow the feed of the example everywhere",
    ("deburr_rigid_on_machine", "machine.drives"): "need time stepping, and are refused at rest",
    ("mill_pocket_stock", "stability"): "the tool of the example does not chatter",
    ("mill_pocket_corner", "machine.spindle_*"): "the curves that are tried have more than this corner takes",
    ("mill_pocket_corner", "machine.y.friction.*"): "y does not turn back in this corner",
    ("machine_*", "tool.diameter"): "has to be there; counts for the force of a cut and for a tool that bends",
    ("machine_error_budget", "machine.chain[[][35]].joint.*"): "axes that stand still at zero in this pass",
    ("machine_pocket", "machine.gravity"): "has to be there; load.weights is false",
    ("machine_pocket", "part.weight"): "has to be there; load.weights is false",
    ("machine_volumetric_map", "machine.chain[[]*].elements"): "there are none; one that is written is told not to count",
    ("machine_volumetric_map", "machine.gravity"): "has to be there; geometry alone has no weights",
}  # fmt: skip


class Refused(Exception):
    """The values do not fit each other; what is only out of the range of a key shows nothing."""


def _words(texts):
    return sorted(text for text in texts if _UNUSUAL not in text)


def quick(scenario):
    """What a study sees of a scenario: its measures, what is wrong with them, and what is said about its values."""
    found = quick_outcome(scenario, coarse=True)
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


def _reason(name, key):
    """Why a key of an example may move nothing; none if it may not."""
    return next(
        (why for (where, what), why in STILL.items() if fnmatchcase(name, where) and fnmatchcase(key, what)), ""
    )


def _turned_here(name, key):
    return any(fnmatchcase(key, pattern) for pattern in ONLY.get(name, ("*",)))


def _overrides(name, folder):
    program = folder / "short.nc"
    program.write_text(_SHORT, encoding="utf-8")
    return [text.format(program=program) if "{program}" in text else text for text in CASES[name]]


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_every_key_acts_is_refused_or_told(name, examples, tmp_path):
    example = Turning(examples / f"{name}.yaml", _overrides(name, tmp_path))
    dead = []
    for key in perturbation.keys(example.scenario):
        said = dotted(key.path)
        if key.path[0] in _OF_THE_LOADER or perturbation.holds_sections(key):
            continue
        if _turned_here(name, said) and not _reason(name, said) and not example.alive(key):
            dead.append(said)
    assert not dead, f"{name}: accepted and ignored, let them act, refuse them or tell it: {', '.join(dead)}"


def test_every_example_is_turned(examples):
    assert {path.stem for path in examples.glob("*.yaml")} == set(CASES)


def test_every_reason_is_of_an_example_that_is_turned():
    assert all(any(fnmatchcase(name, where) for name in CASES) and why for (where, _), why in STILL.items())


def _entries():
    shelves = {"deburr_compliant_spindle": ("tool", "material", "spindle"), "drill_robot": ("material", "robot")}
    return [(name, section) for name, sections in shelves.items() for section in sections]


@pytest.mark.parametrize(("name", "section"), _entries())
def test_another_entry_of_the_library_is_another_result(name, section, examples, tmp_path):
    path, overrides = examples / f"{name}.yaml", _overrides(name, tmp_path)
    scenario = load(path, overrides)
    before = quick(scenario)
    spec = type(getattr(scenario, section))
    for other in library.names(spec.library_shelf):
        if other == getattr(scenario, section).library:
            continue
        try:
            assert acts(before, load(path, [*overrides, f"{section}.library={other}"]), quick)
        except ScenarioFault:
            continue
        return
    pytest.fail("there is no other entry that fits")
