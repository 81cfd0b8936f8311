"""The legal matrix of the cell: every term of a structure behind every process that it goes with, and why the others do not.

Each legal pair runs, and its share or deflection is there and not zero; each illegal one is refused (exit 2) with the
physical reason and what can be used instead.
"""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome
from cutwise.results import SOUNDNESS
from cutwise.spec.faults import ScenarioFault

FREE = "requirements={}"
PISTONS = "spindle={library: berselli2016}"
MODES = "tool.modes=[{direction: y, frequency: 1020 Hz, damping: 0.035, stiffness: 20 N/um}]"
DRIVES = "machine={library: fadal2216, reading: kp_ki_swapped}"
BODIES = "machine={library: demec_mill}"
DRIVEN = "machine={library: demec_mill, drives: {library: fadal2216, reading: kp_ki_swapped}}"
BASE = "robot.base_compliance=[0.01 um/N, 0.01 um/N, 0.01 um/N]"
ARM = (
    "robot={library: kr270_r2700, redundancy_angle: 0 deg, joint_angles: [6 deg, -82 deg, 117 deg, 10 deg, -35 deg, -8 deg], "
    "dynamics: static, sag: ignored}"
)

SHORT_ARM = ("path.line.from=[1900 mm, -10 mm, 800 mm]", "path.line.to=[1900 mm, 10 mm, 800 mm]", FREE)
ON_ARM = ("deburr_on_robot", *SHORT_ARM, "operation.lead_in_time=0.05 s")
ON_TABLE = ("deburr_rigid_on_machine", "path.line.from=[-10 mm, -40 mm, 295 mm]", "path.line.to=[10 mm, -40 mm, 295 mm]",
            "operation.lead_in_time=0.05 s", FREE)  # fmt: skip
STEPPED = (*ON_TABLE, "numerics={}", "tool.stiffness=null", "part.block=null")
ROUND = ("deburr_arc", "path.arc.sweep=20 deg", "path.orientation=fixed", "operation.preset=0 mm", "spindle=rigid",
         "numerics={mode: still}", FREE)  # fmt: skip
MILL = ("mill_on_machine", "path.line.length=8 mm", "path.cut_from=2 mm", "numerics.settling_time=0.05 s",
        "numerics.substeps=4", FREE)  # fmt: skip
FED = (*MILL[:3], BODIES, "tool.modes=[]", "numerics={mode: still}", FREE)
MILL_ARM = ("mill_on_robot", *SHORT_ARM)
SPUN = ("mill_on_robot", *SHORT_ARM, PISTONS, "numerics={force: averaged}", "operation.radial_depth=2 mm",
        "operation.axial_depth=2 mm", "operation.lead_in_time=0.1 s")  # fmt: skip
PIPE = ("chamfer_on_robot", "path.points=48", "robot=null", "placement=null", FREE)
PIPE_ARM = ("chamfer_on_robot", "path.points=48", FREE)
SOFT = ("chamfer_compliant_spindle", "path.points=96", FREE)
TABLE = "placement={origin: [0 mm, 0 mm, 280 mm]}"
PASS = ("machine_error_budget", "uncertainty=null", "path.samples=3", FREE)
PASS_ARM = (*PASS, "machine=null", ARM, "placement={origin: [1900 mm, 0 mm, 500 mm]}", "load.weights=false",
            "path.points=[{X: -50 mm, Z: 300 mm}, {X: 50 mm, Z: 300 mm}]")  # fmt: skip

LEGAL = {
    "deburr x pistons": ((*ON_ARM, "robot=null", "path=null", "operation.length=20 mm"), "tip_deflection_y"),
    "deburr x pistons, arc": (("deburr_arc", "path.arc.sweep=20 deg", FREE), "tip_deflection_y"),
    "deburr x tip": ((*ON_ARM, "tool.stiffness=5 N/um"), "share_tip"),
    "deburr x tip, rigid": (ON_TABLE, "share_tip"),
    "deburr x tip, arc": ((*ROUND, "tool.stiffness=5 N/um"), "share_tip"),
    "deburr x tip modes": ((*ON_ARM, MODES), "share_tip"),
    "deburr x arm": (ON_ARM, "share_arm"),
    "deburr x arm, rigid": ((*ON_ARM, "spindle=rigid", "operation.preset=0.05 mm"), "share_arm"),
    "deburr x arm, swinging": ((*ON_ARM, "robot.dynamics=modal", "spindle=rigid", "operation.preset=0.05 mm"), "share_arm"),
    "deburr x links": ((*ON_ARM, "robot.dynamics=links", "robot.library=kr270_r2700_masses"), "share_arm"),
    "deburr x base": ((*ON_ARM, BASE), "share_base"),
    "deburr x bodies": ((*STEPPED, PISTONS, "operation.preset=2 mm"), "share_bodies"),
    "deburr x bodies, rigid": (ON_TABLE, "share_bodies"),
    "deburr x drives": ((*STEPPED, DRIVES), "share_drives"),
    "deburr x drives, pistons, bodies": ((*STEPPED, DRIVEN, PISTONS, "operation.preset=2 mm"), "share_drives"),
    "deburr x part": ((*ON_ARM, "part.stiffness=20 N/um"), "share_part_stiffness"),
    "deburr x part, arc": ((*ROUND, "part.stiffness=20 N/um"), "share_part_stiffness"),
    "chamfer x pistons": (SOFT, "tip_deflection_max"),
    "chamfer x tip": ((*PIPE, "tool.stiffness=5 N/um"), "share_tip"),
    "chamfer x tip modes, pistons": ((*SOFT, MODES), "share_tip"),
    "chamfer x arm": (PIPE_ARM, "share_arm"),
    "chamfer x base": ((*PIPE_ARM, BASE), "share_base"),
    "chamfer x bodies": ((*PIPE, BODIES, TABLE), "share_bodies"),
    "chamfer x bodies, pistons": ((*SOFT, BODIES, TABLE), "share_bodies"),
    "chamfer x drives": ((*PIPE, DRIVES), "share_drives"),
    "chamfer x drives, pistons, bodies": ((*SOFT, DRIVEN, TABLE), "share_drives"),
    "chamfer x part": ((*PIPE, "part.stiffness=20 N/um"), "share_part_stiffness"),
    "mill x pistons": (SPUN, "share_pistons"),
    "mill x pistons, drives": (
        (*MILL[:4], DRIVES, PISTONS, "part=null", "operation.radial_depth=2 mm", "operation.axial_depth=2 mm", FREE),
        "share_pistons",
    ),
    "mill x tip": ((*MILL_ARM, "tool.stiffness=18 N/um"), "share_tip"),
    "mill x tip modes": (MILL, "share_tip"),
    "mill x tip modes, drives alone, tooth by tooth": (
        (*MILL, DRIVES, "part=null", "numerics.force=tooth_resolved"), "tip_deflection_max",
    ),
    "mill x arm": (MILL_ARM, "share_arm"),
    "mill x base": ((*MILL_ARM, BASE), "share_base"),
    "mill x bodies": (MILL, "share_bodies"),
    "mill x bodies, programmed": (FED, "share_bodies"),
    "mill x bodies, programmed, stepped": ((*FED, "numerics={force: averaged}"), "share_bodies"),
    "mill x drives": ((*MILL, DRIVES, "part=null"), "share_drives"),
    "mill x part": ((*MILL_ARM, "part={stiffness: 20 N/um}"), "share_part_stiffness"),
    "mill x part, drives": ((*MILL, DRIVES, "part={stiffness: 20 N/um}"), "share_part_stiffness"),
    "drill x arm": (("drill_robot", FREE), "share_arm"),
    "drill x base": (("drill_robot", BASE, FREE), "share_base"),
    "drill x bodies": (("drill_on_machine", FREE), "share_bodies"),
    "drill x part": (("drill_robot", "part.stiffness=20 N/um", FREE), "share_part_stiffness"),
    "machine x tip": ((*PASS, "tool.stiffness=20 N/um"), "share_spindle"),
    "machine x arm": (PASS_ARM, "share_joint_a1"),
    "machine x base": ((*PASS_ARM, BASE), "share_base"),
    "machine x bodies": (PASS, "share_table"),
    "machine x part": (PASS_ARM, "share_part"),
    "machine x part, one stiffness": ((*PASS, "part={stiffness: 20 N/um}"), "share_part"),
}  # fmt: skip

ILLEGAL = {
    "drill x pistons": (("drill_robot", PISTONS), "a spindle tilting on pistons cannot guide a drill"),
    "drill x tip modes": (("drill_robot", MODES), "bending modes of a free drill do not hold once the hole guides it"),
    "drill x drives": (
        ("drill_on_machine", "machine.drives={library: fadal2216}"), "drives hold still while a drill feeds along z",
    ),
    "machine x pistons": ((*PASS, PISTONS), "pistons remember how they were loaded, machine is still; use process: deburr or mill"),
    "machine x drives": (
        (*PASS, "machine.drives={library: fadal2216}"), "drives need time stepping; use process: mill",
    ),
    "deburr x two carriers": ((*ON_ARM, BODIES), "the tool has one carrier: write robot or machine"),
    "mill x two carriers": ((*MILL, ARM), "the tool has one carrier: write robot or machine"),
    "mill x drives under a robot": (
        (*MILL_ARM, "machine.drives={library: fadal2216}"), "the tool has one carrier: write robot or machine",
    ),
    "a part of two kinds": (
        ("machine_pocket", "part.stiffness=20 N/um"), "part.height: does not go together with stiffness of part",
    ),
    "chamfer x two carriers": ((*PIPE_ARM, DRIVES), "the tool has one carrier: write robot or machine"),
    "drill x two carriers": (("drill_robot", BODIES), "the tool has one carrier: write robot or machine"),
    "machine x two carriers": ((*PASS, ARM), "the tool has one carrier: write robot or machine"),
    "deburr x pistons at rest": ((*ON_ARM, "numerics={mode: still}"), "pistons remember how they were loaded"),
    "mill x pistons at rest": ((*SPUN, "numerics={mode: still}"), "pistons remember how they were loaded"),
    "mill x pistons, tooth by tooth": ((*SPUN, "numerics={force: tooth_resolved}"), "pistons in milling answer to the mean force"),
    "mill x drives at rest": ((*MILL, "numerics={mode: still}"), "drives need time stepping"),
    "deburr x drives at rest": ((*STEPPED, DRIVES, "numerics={mode: still}"), "drives need time stepping"),
    "deburr x a machine that turns": (
        (*ROUND, BODIES, "path.orientation=follow"), "a machine does not turn its spindle with the edge: write fixed",
    ),
    "robot without a path": ((*ON_ARM, "path=null"), "a robot needs to know where the edge is"),
    "arm without stiffness": (
        (*ON_ARM, "robot.library=irb6640_185_280"), "in its place; fanuc_r2000ic, kr240_2, kr270_2f, kr270_r2700",
    ),
    "arm without masses": ((*ON_ARM, "robot.dynamics=links"), "kr270_r2700_masses has them"),
    "choice of drilling": ((*ON_ARM, "robot.redundancy_angle=least_skating"), "is not one of best_constant, along_path"),
    "contact law in time": (
        (*MILL, "machine.chain[1].elements[0]={name: pads, at: [0 mm, 0 mm, 0 mm], contact: {points: [[90 mm, 100 mm, 0 mm], "
         "[90 mm, -100 mm, 0 mm], [-90 mm, 0 mm, 0 mm]], normal: +z, tangential: [50 N/um, 50 N/um, 0 N/um], area: 5000 mm^2, "
         "coefficient: 10 um, exponent: 0.5, preload: 4 bar, closed_guide: true}}"),
        "still mode only",
    ),
}  # fmt: skip


@pytest.mark.parametrize("pair", LEGAL)
def test_a_legal_pair_runs_and_its_term_matters(pair, examples):
    (name, *overrides), measure = LEGAL[pair]
    outcome = quick_outcome(load(examples / f"{name}.yaml", overrides), coarse=True)
    assert not outcome.infeasible
    assert {finding.code for finding in outcome.findings} & set(SOUNDNESS) <= {
        "unsettled",
        "contact_lost",
    }  # short passes
    assert abs(outcome.measures[measure]) > 1e-12


@pytest.mark.parametrize("pair", ILLEGAL)
def test_an_illegal_pair_is_refused_with_its_reason(pair, examples):
    (name, *overrides), why = ILLEGAL[pair]
    with pytest.raises(ScenarioFault) as caught:
        load(examples / f"{name}.yaml", overrides)
    assert why in str(caught.value)
    assert caught.value.faults


@pytest.mark.parametrize("pair", ["mill x pistons", "mill x pistons, drives"])
def test_a_mill_on_pistons_is_held_against_the_rating_of_its_motor(pair, examples):
    (name, *overrides), _ = LEGAL[pair]

    def told(rating):
        said = quick_outcome(load(examples / f"{name}.yaml", [*overrides, f"spindle.power_rating={rating}"])).warnings
        return [words for words in said if words.startswith("cutting takes")]

    assert not told("5 kW")
    assert "more than the motor's 10 W" in told("10 W")[0]
