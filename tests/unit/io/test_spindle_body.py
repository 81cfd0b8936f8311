"""The compliant spindle as a solid: closed form against OpenCascade, and what a scenario makes of it."""

import json
import math

import numpy as np
import pytest

import cutwise
from cutwise.io import cad_parts, spindle_body, step
from cutwise.io.scenario import revised
from cutwise.maths.solids import Cylinder, coaxial
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.notices import notices

PROTOTYPE = ("spindle.library=prototype",)


@pytest.fixture(scope="module")
def load(examples):
    def of(*overrides, example="deburr_compliant_spindle"):
        return cutwise.load(examples / f"{example}.yaml", overrides)

    return of


@pytest.fixture(scope="module")
def spindle(load):
    return load(*PROTOTYPE).spindle


def size_of(spindle):
    return cad_parts.SpindleSize(
        spindle.solid, spindle.tool_reach, spindle.piston_arm, spindle.pistons, spindle.piston_azimuth
    )


def test_a_rod_and_a_tube():
    rod = coaxial([Cylinder(0.0, 0.2, 1e-6, 7850.0)])
    assert rod.inertia == pytest.approx(rod.mass * 0.2**2 / 3.0, rel=1e-8)
    tube = coaxial([Cylinder(-0.05, 0.1, 0.02, 1000.0, 0.01)])
    assert tube.mass == pytest.approx(1000.0 * math.pi * (4e-4 - 1e-4) * 0.1)
    assert tube.centre == pytest.approx(0.0, abs=1e-15)
    assert tube.axial_inertia == pytest.approx(tube.mass * (4e-4 + 1e-4) / 2.0)


def test_mass_properties_are_those_of_opencascade(spindle):
    """Every cylinder of the moving body as a solid, with its own density, about the joint."""
    bodies = cad_parts.compliant_spindle(size_of(spindle))
    densities = [one.density for one in spindle_body.cylinders(spindle.solid, spindle.tool_reach).values()]
    mass = moment = inertia = 0.0
    for shape, density in zip(bodies.moving, densities, strict=True):
        found = step.mass_properties(step.part_from_shape(shape, "body"), density)
        about = spindle_body.about_joint(found, np.zeros(3), np.array([0.0, 0.0, -1.0])).found
        mass, moment, inertia = mass + about.mass, moment + about.mass * about.centre, inertia + about.inertia
    assert (spindle.mass, spindle.centre_of_mass, spindle.inertia) == pytest.approx(
        (mass, moment / mass, inertia), rel=1e-9
    )


def test_a_solid_replaces_what_the_library_assumes(load):
    plain, solid = load(), load(*PROTOTYPE)
    assert plain.origins["spindle.inertia"].status == "assumed"
    for key in ("mass", "centre_of_mass", "inertia"):
        assert solid.origins[f"spindle.{key}"].status == "derived"
    assert solid.spindle.mass == pytest.approx(0.6418, abs=1e-4)
    assert solid.spindle.inertia == pytest.approx(3.1535e-3, abs=1e-7)
    assert "spindle.solid.motor_density" in {k for k, o in solid.origins.items() if o.status == "assumed"}


def test_a_written_value_wins_and_the_contradiction_is_named(load):
    scenario = load(*PROTOTYPE, "spindle.inertia=4.1e-3 kg m^2")
    assert scenario.spindle.inertia == 4.1e-3
    assert scenario.spindle.mass == pytest.approx(0.6418, abs=1e-4)
    assert any("inertia as written (4.1e-3 kg m^2) is +30 % off" in line for line in notices(scenario))
    close = load(*PROTOTYPE, "spindle.inertia=3.16e-3 kg m^2")
    assert not any("off what the solid gives" in line for line in notices(close))


def test_a_changed_size_changes_the_mass_also_in_a_read_back_scenario(load):
    scenario = load(*PROTOTYPE)
    heavier = revised(scenario, ["spindle.solid.motor_density=7200 kg/m^3"])
    assert heavier.spindle.mass - scenario.spindle.mass == pytest.approx(0.5 * 0.5988, abs=1e-4)
    assert revised(scenario, []) == scenario


@pytest.mark.parametrize(
    ("override", "words"),
    [("motor_length=140 mm", "motor, collet and flutes are 170 mm long, tool_reach only 150 mm"),
     ("collet_diameter=50 mm", "is larger than the motor")],
)  # fmt: skip
def test_sizes_that_do_not_fit(load, override, words):
    with pytest.raises(ScenarioFault, match=words) as caught:
        load(*PROTOTYPE, f"spindle.solid.{override}")
    assert not any("inertia: missing" in str(fault) for fault in caught.value.faults)


def test_the_users_own_step_file_gives_the_same(load, spindle, tmp_path):
    """The moving body at one density, written as STEP, shifted and lying on its side."""
    gp, api = step.occ("gp"), step.occ("BRepBuilderAPI")
    bodies = cad_parts.compliant_spindle(size_of(spindle))
    lie = gp.gp_Trsf()
    lie.SetRotation(gp.gp_Ax1(gp.gp_Pnt(0, 0, 0), gp.gp_Dir(0, 1, 0)), math.pi / 2)  # -z becomes -x
    shift = gp.gp_Trsf()
    shift.SetTranslation(gp.gp_Vec(10, 20, 30))
    whole = bodies.moving[0]
    for body in bodies.moving[1:]:
        whole = step.occ("BRepAlgoAPI").BRepAlgoAPI_Fuse(whole, body).Shape()
    placed = api.BRepBuilderAPI_Transform(api.BRepBuilderAPI_Transform(whole, lie, True).Shape(), shift, True).Shape()
    file = step.write_step(placed, tmp_path / "moving.step")
    found = load(
        f"spindle.solid={{step: {file}, density: 5000 kg/m^3, joint: [10 mm, 20 mm, 30 mm], axis: [-1, 0, 0]}}"
    ).spindle
    same = [c._replace(density=5000.0) for c in spindle_body.cylinders(spindle.solid, spindle.tool_reach).values()]
    expected = coaxial(same)
    assert (found.mass, found.centre_of_mass, found.inertia) == pytest.approx(expected[:3], rel=1e-9)
    assert found.solid_remarks == ()


def test_a_lopsided_step_body_is_remarked_upon(load, tmp_path):
    box = step.occ("BRepPrimAPI").BRepPrimAPI_MakeBox(60.0, 10.0, 100.0).Shape()
    file = step.write_step(box, tmp_path / "box.step")
    scenario = load(
        f"spindle.solid={{step: {file}, density: 7850 kg/m^3, joint: [30 mm, 9 mm, 100 mm], axis: [0, 0, -1]}}"
    )
    told = "\n".join(scenario.spindle.solid_remarks)
    assert "4 mm beside the axis" in told
    assert "lopsided" in told
    backwards = load(
        f"spindle.solid={{step: {file}, density: 7850 kg/m^3, joint: [30 mm, 5 mm, 120 mm], axis: [0, 0, 1]}}",
        "spindle.centre_of_mass=70 mm", "spindle.inertia=5e-3 kg m^2",
    )  # fmt: skip
    assert any("behind the joint" in text for text in backwards.spindle.solid_remarks)


def test_a_missing_step_file_is_a_fault(load):
    with pytest.raises(ScenarioFault, match="no such file"):
        load("spindle.solid={step: nothing.step, density: 7850 kg/m^3, joint: [0 mm, 0 mm, 0 mm], axis: [0, 0, -1]}")


@pytest.mark.parametrize("example", ["deburr_compliant_spindle", "chamfer_compliant_spindle"])
def test_runs_take_the_solid(load, example):
    """Mass and inertia reach the loop: lighter about the joint, the result moves a little and stays sound."""
    measure = "surface_error_mean" if example.startswith("deburr") else "width_deflected_min"
    library = load(example=example)
    sizes = (
        "spindle.solid={motor_diameter: 38 mm, motor_length: 110 mm, motor_density: 4800 kg/m^3, "
        "collet_diameter: 16 mm, collet_length: 20 mm, collet_density: 7850 kg/m^3, shank_diameter: 6 mm, "
        "mill_diameter: 8 mm, mill_length: 10 mm, mill_density: 14500 kg/m^3, piston_diameter: 4.43 mm, "
        "housing_gap: 8 mm, housing_wall: 4 mm}"
    )
    solid = cutwise.simulate(revised(library, [sizes]))
    assert solid.scenario.spindle.inertia == pytest.approx(3.1535e-3, abs=1e-7)
    before, after = cutwise.simulate(library).measures[measure].value, solid.measures[measure].value
    assert before != after
    assert after == pytest.approx(before, abs=5e-5)


def test_the_spindle_as_step_file_deflected(spindle, tmp_path):
    straight = cad_parts.compliant_spindle(size_of(spindle))
    tilted = cad_parts.compliant_spindle(size_of(spindle), (1.5e-3 / spindle.tool_reach, 2e-3 / spindle.tool_reach))
    tips = []
    for bodies in (straight, tilted):
        part = step.part_from_shape(bodies.moving[-1], "mill")
        tips.append(np.array(step.mass_properties(part, 1.0).centre))
    arm = spindle.tool_reach - 0.5 * spindle.solid.mill_length
    moved = (tips[1] - tips[0])[:2] / arm * spindle.tool_reach
    np.testing.assert_allclose(moved, [1.5e-3, 2e-3], rtol=2e-4)
    file = step.write_step(cad_parts.spindle_assembly(tilted), tmp_path / "spindle.step")
    assert step.read_step(file).solids == 4 + spindle.pistons + 1


def test_command_shows_and_writes_the_spindle(examples, tmp_path, capsys):
    from cutwise.app import cli

    def call(*words):
        with pytest.raises(SystemExit) as left:
            cli.main([str(w) for w in words])
        return left.value.code, capsys.readouterr()

    file, out = examples / "deburr_compliant_spindle.yaml", tmp_path / "s.step"
    code, said = call("spindle", file, "--set", PROTOTYPE[0], "--json", "-o", out, "--deflection", "1 mm, 0 mm")
    assert code == 0
    assert json.loads(said.out)["mass"] == pytest.approx(0.6418, abs=1e-4)
    assert out.exists()
    assert call("spindle", file, "-o", out)[0] == 2  # no sizes
    assert call("spindle", file, "--set", PROTOTYPE[0], "-o", out, "--deflection", "90 mm, 0 mm")[0] == 2
    assert call("spindle", examples / "chamfer_pipe_hole.yaml")[0] == 2
