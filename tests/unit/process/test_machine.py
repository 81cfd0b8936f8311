"""A machine scenario from its text to its measures."""

import math
import re

import numpy as np
import pytest
from scipy.linalg import expm

from cutwise.io.scenario import load, parse, read_document
from cutwise.physics.motion.volumetric import chain_errors
from cutwise.process import machine, machine_assemble, machine_pass
from cutwise.process.recipes import collect, quick_outcome, simulate
from cutwise.results import SolverFailure
from cutwise.spec.faults import ScenarioFault
from cutwise.study.advice import advise
from cutwise.study.sweep import sweep

UM = 1e-6


@pytest.fixture(scope="module")
def budget(examples):
    return simulate(load(examples / "machine_error_budget.yaml"))


def deviation(result, where):
    return np.array([result.measures[f"deviation_{axis}_{where}"].value for axis in "xyz"]) / UM


def test_example_gives_the_reference_results(budget):
    expected = {
        "start": (337.62845386, 276.93305676, 47.61099844),
        "middle": (333.12888529, 266.77848476, 21.79980066),
        "end": (328.62931673, 285.95934298, 3.94306496),
    }
    for where, reference in expected.items():
        size = np.linalg.norm(reference)
        assert np.linalg.norm(deviation(budget, where) - reference) < 1e-6 * size
    value = {name: measure.value for name, measure in budget.measures.items()}
    assert value["deviation_norm_max"] / UM == pytest.approx(439.26267535, rel=1e-6)
    assert value["deviation_norm_max_at"] == pytest.approx(-0.130, abs=1e-12)
    shares = [value[f"share_{name}"] for name in ("part", "table", "saddle", "bed", "column", "head", "spindle")]
    assert np.array(shares) / UM == pytest.approx(
        [11.2420, 12.1071, 125.6264, 88.8348, 119.8755, 41.3958, 40.1811], abs=1e-4
    )
    assert sum(shares) == pytest.approx(value["deviation_norm_max"], rel=1e-12)
    assert [value[f"position_start_{axis}"] for axis in "xyz"] == pytest.approx([-0.130, -0.040, 0.295], abs=1e-12)
    assert value["deviation_p95"] / UM == pytest.approx(450.83, abs=0.4)
    assert value["deviation_random_p95"] / UM == pytest.approx(36.30, abs=0.25)
    assert value["energy_balance"] < 1e-12
    assert value["work_convexity"] > 0.0
    assert budget.verdict == "pass"
    assert max(abs(change) for change in budget.convergence.values()) < 1e-9


def test_groups_hold_the_relations_of_the_paper(budget):
    structure, surface, motion = (budget[name] for name in ("structure", "surface", "motion"))
    assert structure["f1"].dims == ("time", "body", "axis")
    assert structure["f2"].sum("body").values == pytest.approx(surface["f4"].values, abs=1e-18)
    assert structure["f2"].sel(body="part").values == pytest.approx(structure["f3"].values, abs=0)
    assert (surface["f5"] - surface["f4"]).values == pytest.approx(motion["position"].values, abs=1e-15)


def test_result_survives_its_file(budget, tmp_path):
    path = budget.save(tmp_path / "run.nc")
    again = type(budget).from_file(path, load(path))
    assert again.scenario.model_dump() == budget.scenario.model_dump()
    assert simulate(again.scenario).measures == budget.measures
    assert read_document(budget.scenario.document()).model_dump() == budget.scenario.model_dump()


@pytest.mark.parametrize(
    ("changes", "y", "z"),
    [
        (
            ["machine.chain[4].elements[0].springs.angular_stiffness=[2e6 N m/rad, 2e6 N m/rad, 2e6 N m/rad]"],
            (438.093, 427.938, 447.119), (-66.705, -92.516, -110.373),
        ),
        (
            ["machine.chain[2].elements[0].travels_with=saddle", "machine.chain[2].elements[0].at=[0 mm, 0 mm, 0 mm]"],
            (270.676, 266.778, 274.141), (23.751, 21.800, 20.848),
        ),
        (
            [
                "machine.chain[4].elements[0].springs.angular_stiffness=[2e6 N m/rad, 2e6 N m/rad, 2e6 N m/rad]",
                "convention=paper_literal", "load.feed_moment=false", "load.force=[4000 N, 4000 N, -2000 N]",
            ],
            (269.383, 282.513, 266.308), (-329.165, -332.325, -327.530),
        ),
    ],
    ids=["soft foot", "carriages on the saddle", "figure 4 demo"],
)  # fmt: skip
def test_variants_by_set(examples, changes, y, z):
    scenario = load(examples / "machine_error_budget.yaml", changes)
    found = np.array([deviation(simulate(scenario), where) for where in ("start", "middle", "end")])
    assert found[:, 1] == pytest.approx(y, abs=6e-4)
    assert found[:, 2] == pytest.approx(z, abs=6e-4)


def test_demo_options_are_called_demos(examples):
    result = simulate(load(examples / "machine_error_budget.yaml", ["convention=paper_literal"]))
    assert "energy_balance" not in result.measures
    assert "work_convexity" not in result.measures
    assert "not applicable" in result.notes["energy"]


def test_flexible_tool_by_its_library_values(examples):
    result = simulate(load(examples / "machine_error_budget.yaml", ["tool.flexible=true"]))
    assert deviation(result, "middle") == pytest.approx([479.98931955, 413.63891902, 24.83132339], abs=1e-6)
    assert not any("does not bend" in warning for warning in result.warnings)


def test_force_of_a_full_slot(examples):
    """Mean over a turn, closed form: N b/4 K c on each axis plus edge forces N b/pi K_e (Altintas 2012, Eq. 2.31)."""
    changes = ["material.library=al7075t6", "load.force={axial_depth: 5 mm, spindle_speed: 500 rpm}"]
    scenario = load(examples / "machine_error_budget.yaml", changes)
    cell = machine_assemble.machine_cell(scenario)
    m, flutes, depth, chip = scenario.material, 4, 5e-3, 0.2e-3
    across = flutes * depth / 4 * m.K_tc * chip + flutes * depth / math.pi * m.K_te
    along = flutes * depth / 4 * m.K_rc * chip + flutes * depth / math.pi * m.K_re
    assert np.abs(cell.cut.force[:, :2]) == pytest.approx(np.tile([along, across], (27, 1)), rel=1e-9)
    axial = flutes * depth / math.pi * (m.K_ac or 0.0) * chip + flutes * depth / 2 * (m.K_ae or 0.0)
    assert cell.cut.force[:, 2] == pytest.approx(-axial, rel=1e-9)  # a right-hand helix pulls the tool down
    assert cell.cut.force[0, 0] < 0.0  # against the feed


def test_force_of_a_full_slot_by_kienzles_law(examples):
    """Mean over a turn of k_c1.1 h^(1-m), h = c sin phi: N b / 2 pi times the integral over half a turn."""
    changes = ["material.library=kienzle_cast_al", "load.force={axial_depth: 5 mm, spindle_speed: 500 rpm}"]
    scenario = load(examples / "machine_error_budget.yaml", changes)
    cell = machine_assemble.machine_cell(scenario)
    m, flutes, depth, chip = scenario.material, 4, 5e-3, 0.2e-3
    phi = (np.arange(200_000) + 0.5) * math.pi / 200_000
    h = chip * np.sin(phi)
    tangential, radial = (k * (1e3 * h) ** -e * h for k, e in ((m.k_c11, m.m_c), (m.k_r11, m.m_r)))
    scale = flutes * depth / 2.0
    along, across = scale * (radial * np.sin(phi)).mean(), scale * (tangential * np.sin(phi)).mean()
    assert np.abs(cell.cut.force[:, :2]) == pytest.approx(np.tile([along, across], (27, 1)), rel=1e-4)


def with_contact(preload: float, exponent: float) -> str:
    """The x guide with the contact law; its tangent at rest is the linear spring, half from each side of the guide."""
    points = "[[90 mm, 100 mm, 0 mm], [90 mm, -100 mm, 0 mm], [-90 mm, 100 mm, 0 mm], [-90 mm, -100 mm, 0 mm]]"
    coefficient = 5e-3 * preload ** (1 - exponent) / (exponent * 150e6)  # from k = A p^(1 - m) / (c m)
    return (
        f"machine.chain[2].elements[0].contact={{points: {points}, normal: +z, area: 5000 mm^2, "
        "tangential: [0 N/um, 200 N/um, 0 N/um], drive: {direction: x, stiffness: 100 N/um}, "
        f"coefficient: {coefficient * 1e6**exponent * 1e6!r} um, exponent: {exponent}, preload: {preload / 1e5} bar, "
        "closed_guide: true}"
    )


def test_contact_law_instead_of_springs(examples):
    """Under a high preload any exponent is a spring; m = 1/2 with opposed pads is one at every preload."""
    linear = machine_pass.run_pass(machine_assemble.machine_cell(load(examples / "machine_error_budget.yaml")))

    def middle(preload: float, exponent: float) -> np.ndarray:
        scenario = load(examples / "machine_error_budget.yaml", [with_contact(preload, exponent)])
        result = simulate(scenario)
        assert "energy_balance" not in result.measures
        return deviation(result, "middle") - linear.deviation[13] / UM

    assert np.abs(middle(1e8, 0.35)).max() < 1e-3
    assert np.abs(middle(3e6, 0.5)).max() < 1e-9
    assert np.abs(middle(3e5, 0.35)).max() > 0.1


def test_pad_that_lifts_off_is_said_in_words(examples):
    """The operation is infeasible as it stands; a study goes on, and finds the preload that it takes."""
    changes = [with_contact(3e4, 0.5).replace("closed_guide: true", "closed_guide: false")]
    lost = load(examples / "machine_error_budget.yaml", changes)
    result = simulate(lost)
    assert result.verdict == "fail"
    assert re.search(r"x guide: pads? .* off under the load.*tool point at", result.infeasible[0])
    preload = "machine.chain[2].elements[0].contact.preload"
    table = sweep(lost, {preload: ["0.03 N/mm^2", "30 N/mm^2"]})
    assert table.deviation_norm_max.notnull().values.tolist() == [False, True]
    found = advise(lost, limits={preload: ("0.03 N/mm^2", "30 N/mm^2")})
    assert any("preload" in said for said in found)


def test_a_rigid_part_needs_no_modulus(examples):
    text = (examples / "machine_error_budget.yaml").read_text()
    start = text.index("part:")
    of_part = re.sub(r"\n  (youngs_modulus|poisson_ratio|shear_factor):[^\n]*", "", text[start:], count=3)
    rigid = simulate(parse(text[:start] + of_part, overrides=["part.flexible=false"], folder=examples))
    assert "part" not in rigid["budget"]["element"].values
    with pytest.raises(ScenarioFault, match="3 faults"):
        parse(text[:start] + of_part, folder=examples)


def test_a_wall_along_the_feed_and_units_that_slipped_are_told(examples):
    along = simulate(load(examples / "machine_error_budget.yaml", ["surface.normal=[1, 0, 0]"])).warnings
    assert any("surface.normal is 0° from the feed" in said for said in along)
    soft = ["machine.chain[2].elements[0].pads.stiffness=[0 N/um, 0.1 N/um, 0.1 N/um]"]
    loose = simulate(load(examples / "machine_error_budget.yaml", soft)).warnings
    assert any("look at the units" in said for said in loose)


FIVE_AXES = """
process: machine
machine:
  gravity: [0, 0, -1]
  chain:
    - {name: work}
    - name: turntable
      parent: work
      joint: {kind: revolute, side: part, positive: table, axis: [0, 0, 1], command: C, turn: [-360 deg, 360 deg],
              offset: [0 mm, 0 mm, -50 mm]}
      elements: [{name: c bearing, at: [0 mm, 0 mm, 0 mm], springs: {stiffness: [300 N/um, 300 N/um, 500 N/um],
                  angular_stiffness: [2e6 N m/rad, 2e6 N m/rad, 1e6 N m/rad]}}]
      weight: 300 N
      weight_at: [10 mm, 0 mm, 0 mm]
    - name: cradle
      parent: turntable
      joint: {kind: revolute, side: part, positive: table, axis: [1, 0, 0], command: A, turn: [-110 deg, 110 deg],
              offset: [5 mm, -20 mm, -80 mm]}
      elements: [{name: a bearing, at: [0 mm, 0 mm, 0 mm], springs: {stiffness: [300 N/um, 300 N/um, 500 N/um],
                  angular_stiffness: [2e6 N m/rad, 2e6 N m/rad, 1e6 N m/rad]}}]
    - name: bed
      parent: cradle
      joint: {kind: prismatic, side: part, positive: table, axis: [1, 0, 0], command: X, travel: [-200 mm, 200 mm],
              offset: [-120 mm, 60 mm, -30 mm]}
      elements: [{name: x guide, at: [0 mm, 0 mm, 0 mm], springs: {stiffness: [100 N/um, 800 N/um, 900 N/um],
                  angular_stiffness: [5e6 N m/rad, 5e6 N m/rad, 5e6 N m/rad]}}]
    - name: column
      parent: bed
      joint: {kind: prismatic, side: tool, axis: [0, 1, 0], command: Y, travel: [-200 mm, 200 mm],
              offset: [10 mm, 300 mm, 450 mm]}
    - name: head
      parent: column
      joint: {kind: prismatic, side: tool, axis: [0, 0, 1], command: Z, travel: [-200 mm, 200 mm],
              offset: [0 mm, 0 mm, 0 mm]}
      elements: [{name: ram, at: [0 mm, 0 mm, 0 mm], compliance: [[1e-8, 0, 0, 0, 2e-9, 0], [0, 1e-8, 0, 0, 0, 0],
                  [0, 0, 5e-9, 0, 0, 0], [0, 0, 0, 1e-7, 0, 0], [2e-9, 0, 0, 0, 1e-7, 0], [0, 0, 0, 0, 0, 1e-7]]}]
tool: {diameter: 10 mm, tip: [0 mm, 0 mm, -140 mm], flexible: false}
path: {points: [{X: -50 mm, C: 0 deg, A: 0 deg}, {X: 50 mm, C: 90 deg, A: -35 deg}], feed: 1000 mm/min, samples: 11}
load: {force: [300 N, -200 N, 500 N]}
geometry_errors:
  XOC: 8 um
  AOC: 20 urad
  BOA: -30 urad
  EAC: {deviation: 10 urad, period: 360 deg, orders: 3, seed: 4}
  EXX: {polynomial: [0 um, 5 um, 2 um], scale: 200 mm}
  EBZ: {columns: {"position [mm]": [-200, 0, 200], "error [urad]": [0, 5, -5]}}
volume: {points: 5, at: {C: 30 deg}}
"""


def test_five_axis_machine_from_its_text():
    scenario = parse(FIVE_AXES)
    result = simulate(scenario)
    value = {name: measure.value for name, measure in result.measures.items()}
    assert value["energy_balance"] < 1e-12
    assert "work_convexity" not in value  # axes turn
    assert value["linear_residual_max"] < 1e-3 * value["deviation_norm_max"]
    assert value["map_interpolation_error"] < 1e-9
    axes, tip = machine_assemble.machine_axes(scenario), np.array(scenario.tool.tip)
    commands = np.array([[math.radians(30), 0.0, 0.2, -0.2, 0.1]])
    volume = result["volume"]["error"].sel(X=0.2, Y=-0.2, Z=0.1, method="nearest").values
    from cutwise.physics.motion.volumetric import direct_error

    assert volume == pytest.approx(direct_error(axes, commands, tip)[0], abs=1e-9)


def _turn(axis, angle):
    """Rotation about x or z by hand."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]] if axis == "x" else [[c, -s, 0], [s, c, 0], [0, 0, 1]])


def test_five_axis_pass_by_superposition_in_the_part():
    """Every error by itself, in absolute coordinates: no chain recursion, no frames of the program."""
    scenario = parse(FIVE_AXES)
    run = machine_pass.run_pass(machine_assemble.machine_cell(scenario))
    k = 7
    share = run.cell.way.travel[k] / 0.1
    x, c, a = -0.05 + 0.1 * share, math.radians(90) * share, math.radians(-35) * share
    # a table that turns by +c shows the tool turning by -c, and so on for A and X
    work, turntable = np.eye(3), _turn("z", -c)
    cradle = turntable @ _turn("x", -a)
    o = {"work": np.zeros(3), "turntable": np.array([0, 0, -0.05])}
    o["cradle"] = o["turntable"] + turntable @ [0.005, -0.02, -0.08]
    o["bed"] = o["cradle"] + cradle @ [-0.12 - x, 0.06, -0.03]
    o["column"] = o["bed"] + cradle @ [0.01, 0.3, 0.45]
    p = o["column"] + cradle @ [0, 0, -0.14]
    np.testing.assert_allclose(run.ideal[k], p, atol=1e-15)

    force, down = np.array([300.0, -200.0, 500.0]), cradle @ [0, 0, -1]  # gravity in the frame of the bed
    weight = (300.0 * down, o["turntable"] + turntable @ [0.01, 0, 0])
    on_part, on_table, on_tool = (-force, p), weight, (force, p)

    def moved(at, axes, compliance, loads):
        """Displacement of the tool point by one element under loads, all seen from the side they act on."""
        wrench = np.concatenate([sum(f for f, _ in loads), sum(np.cross(q - at, f) for f, q in loads)])
        big = np.kron(np.eye(2), axes)
        twist = big @ compliance @ big.T @ wrench
        return twist[:3] + np.cross(twist[3:], p - at)

    bearing = np.diag([1 / 300e6, 1 / 300e6, 1 / 500e6, 5e-7, 5e-7, 1e-6])
    guide = np.diag([1 / 100e6, 1 / 800e6, 1 / 900e6, 2e-7, 2e-7, 2e-7])
    ram = np.diag([1e-8, 1e-8, 5e-9, 1e-7, 1e-7, 1e-7])
    ram[0, 4] = ram[4, 0] = 2e-9
    elastic = (
        -moved(o["turntable"], turntable, bearing, [on_part]) - moved(o["cradle"], cradle, bearing, [on_part, on_table])
        - moved(o["bed"], cradle, guide, [on_part, on_table]) + moved(o["column"], cradle, ram, [on_tool])
    )  # fmt: skip
    given = scenario.errors()
    wobble = machine_assemble.machine_axes(scenario).errors[0].motion[3](np.array([c]))[0]
    assert given["XOC"] == 8e-6
    geometric = (  # of a table: taken off; location errors in the frame that stands, motions in the one that moves
        -np.array(turntable @ [8e-6, 0, 0]) - np.cross(turntable @ [20e-6, 0, 0], p - o["turntable"])
        - np.cross(work @ [wobble, 0, 0], p - o["work"]) + np.cross(cradle @ [0, 30e-6, 0], p - o["cradle"])
        + np.cross(cradle @ [0, 5e-6, 0], p - o["column"])
        - turntable @ _turn("x", -a) @ [5e-6 * (x / 0.2) + 2e-6 * (x / 0.2) ** 2, 0, 0]
    )  # fmt: skip
    np.testing.assert_allclose(run.deviation[k], elastic + geometric, rtol=1e-10, atol=1e-17)


def test_exact_error_of_a_pass_is_the_product_of_its_matrices():
    """E = H exp(carried) exp(own) exp(elastic) for every body, multiplied out by hand."""
    run = machine_pass.run_pass(machine_assemble.machine_cell(parse(FIVE_AXES)))
    errors = chain_errors(run.cell.axes, run.at, run.cell.way.commands)
    k, whole = 9, np.eye(4)
    for i in range(len(run.cell.names)):
        step = np.eye(4)
        if i:
            back = run.at.rotations[k, i - 1].T
            step[:3, :3] = back @ run.at.rotations[k, i]
            step[:3, 3] = back @ (run.at.origins[k, i] - run.at.origins[k, i - 1])
        elastic = run.twists[k, i] - run.geometric[k, i]
        for twist in (errors.carried[k, i], errors.own[k, i], elastic):
            generator = np.zeros((4, 4))
            generator[:3, :3], generator[:3, 3] = np.cross(np.eye(3), twist[3:]), twist[:3]
            step = step @ expm(generator)
        whole = whole @ step
    point = whole @ np.append(run.cell.tip, 1.0)
    np.testing.assert_allclose(run.exact[k], point[:3] - run.ideal[k], rtol=1e-7)


def test_wall_on_the_left_is_the_wall_on_the_right_seen_from_behind(examples):
    right, left = (
        machine.evaluate_pass(load(examples / "machine_error_budget.yaml", [f"surface={{side: {side}, depth: 5 mm}}"]))
        for side in ("right", "left")
    )
    np.testing.assert_array_equal(right.wall.error, -left.wall.error)


def test_wall_of_a_tilted_tool_is_along_its_axis():
    """Height by height: the error of a point of the tool, by its own displacement and rotation."""
    found = machine.evaluate_pass(parse(FIVE_AXES, overrides=["surface={side: right, depth: 8 mm}"]))
    run, k = found.run, 10
    axis = run.at.rotations[k, -1, :, 2]
    normal = np.cross(axis, run.cell.way.direction[k])
    point = run.deviation[k] + np.cross(run.rotation[k], 0.008 * axis)
    assert found.wall.error[k, -1] == pytest.approx(point @ normal / np.linalg.norm(normal), rel=1e-12)


def test_worst_body_and_element_are_named(budget):
    shares = {name: budget.measures[f"share_{name}"].value for name in ("part", "table", "saddle", "bed", "column")}
    assert f"{max(shares, key=shares.get)} costs most of it" in budget.notes["worst"]
    gain = budget["budget"]["stiffening_gain"]
    assert f"Making {gain['element'].values[int(np.argmin(gain.values))]} 10 % stiffer" in budget.notes["remedy"]


def test_numbers_out_of_scale_are_no_result():
    with pytest.raises(ScenarioFault, match="1e300 N is out of scale"):
        parse(FIVE_AXES, overrides=["load.force=[1e300 N, 0 N, 0 N]"])
    with pytest.raises(SolverFailure, match="no finite number came out for deviation_norm_max"):
        collect(parse(FIVE_AXES), {"deviation_norm_max": math.inf})


def test_energy_is_of_the_loads_whatever_the_geometric_errors_are():
    scenario = parse(FIVE_AXES)
    bare = scenario.model_copy(update={"geometry_errors": None})
    one, other = (machine_pass.run_pass(machine_assemble.machine_cell(s)) for s in (scenario, bare))
    assert one.internal == pytest.approx(other.internal, rel=1e-14)
    assert one.deviation - other.deviation == pytest.approx(
        np.einsum(
            "mbij,mbj->mi", one.at.rotations, machine_pass.chains.local_errors(one.at, one.geometric, one.cell.tip)
        ),
        abs=1e-18,
    )


def test_errors_of_the_scenario_replace_those_of_the_machine(examples):
    scenario = load(
        examples / "machine_volumetric_map.yaml", ["geometry_errors.EXX={deviation: 0 um, wavelength: 1 m, seed: 1}"]
    )
    plain = load(examples / "machine_volumetric_map.yaml")
    changed, kept = machine_assemble.machine_axes(scenario), machine_assemble.machine_axes(plain)
    u = np.array([0.1])
    assert changed.errors[0].motion[0](u) == 0.0
    assert kept.errors[0].motion[0](u) != 0.0
    assert (changed.errors[0].motion[1](u) == kept.errors[0].motion[1](u)).all()


def test_tool_signs_are_table_signs_turned_about(examples):
    """The same machine, its tables written as the tool against them: commands and errors change their sign."""
    plain = load(examples / "machine_volumetric_map.yaml")
    turned = load(examples / "machine_volumetric_map.yaml", ["machine.chain[1].joint.positive=tool"])
    one, other = machine_assemble.machine_axes(plain), machine_assemble.machine_axes(turned)
    assert one.sense.tolist() == [-1, -1, 1]
    assert other.sense.tolist() == [1, -1, 1]
    assert not other.of_table[0]


def test_volumetric_example_holds_the_reference_points(examples):
    scenario = load(examples / "machine_volumetric_map.yaml")
    found = machine.evaluate_volume(scenario)
    x, y, z = found.at
    i, j, k = (int(np.abs(a - v).argmin()) for a, v in ((x, 0.1), (y, 0.04), (z, 0.2)))
    from cutwise.physics.motion.volumetric import direct_error

    axes = machine_assemble.machine_axes(scenario)
    expected = direct_error(axes, [[x[i], y[j], z[k]]], np.array(scenario.tool.tip))[0]
    assert found.error[i, j, k] == pytest.approx(expected, abs=1e-9)
    assert direct_error(axes, [[0.1, 0.05, 0.2]], np.array(scenario.tool.tip))[0] / UM == pytest.approx(
        [23.403501, -19.252558, 1.316883], abs=1e-6
    )
    assert found.tables_miss < 1e-9


def test_measures_alone_are_those_of_the_run(budget):
    whole = {name: m.value for name, m in budget.measures.items()}
    assert quick_outcome(budget.scenario, ["deviation_p95"]).measures == whole
    assert (
        quick_outcome(budget.scenario).measures.items()
        == {k: whole[k] for k in whole.keys() - machine.MONTE_CARLO}.items()
    )
