"""The chamfer recipe from scenario to result and program."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial import KDTree

import cutwise
from cutwise.maths.edges import lengths
from cutwise.paths.chamfer.ball_path import Chamfer, chamfer_path
from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge
from cutwise.physics.engagement.ball import pass_frames
from cutwise.physics.structure.statics import characteristic
from cutwise.physics.surface.sweep import swept_chamfer
from cutwise.process import chamfer
from cutwise.process.chamfer_cell import ball_cut, sections
from cutwise.process.chamfer_cut import ball_end, material_along, mounted, ring_on
from cutwise.process.chamfer_program import program_of
from cutwise.programs import post
from cutwise.spec.faults import ScenarioFault

EXAMPLE = Path(__file__).parents[3] / "examples" / "chamfer_pipe_hole.yaml"
COMPLIANT = EXAMPLE.with_name("chamfer_compliant_spindle.yaml")
COARSE = ("path.points=360",)
STIFF = ("chamfer.width=0.3 mm", "spindle.pressure=5 bar", "operation.preset=0 mm", "operation.part_error=0 mm",
         "requirements={}")  # fmt: skip


def run(*overrides):
    return cutwise.simulate(cutwise.load(EXAMPLE, (*COARSE, *overrides)))


@pytest.mark.parametrize(
    ("overrides", "code"),
    [
        (("chamfer.width=0.5 mm", "chamfer.tilt=0 deg"), "rod_clears_wall"),
        (("tool.knife_limit_angle=45 deg", "chamfer.tilt=0 deg"), "knife_covers_contact"),
        (("tool.ball_radius=4.2 mm", "tool.rod_radius=2 mm"), "ball_enters_hole"),
        (("part.edges=outer", "chamfer.tier=surface", "tool.ball_radius=6 mm", "tool.rod_radius=2 mm"), "no_gouge"),
        (("part.pipe.eccentricity=10 mm",), "no_edge"),
    ],
)
def test_infeasible_for_the_right_reason(overrides, code):
    result = run(*overrides)
    assert result.verdict == "fail"
    assert any(line.startswith(code) for line in result.infeasible)
    assert result.advice
    assert result.notes["remedies"].startswith("1. ")


BASE = ("requirements={}", "setup=null")


@pytest.mark.parametrize(
    ("case", "first"),
    [
        (("part.pipe.inclination=30 deg", "chamfer.tilt=0 deg"), "tilt the chamfer by 13 deg (chamfer.tilt: auto)"),
        (("part.pipe.eccentricity=4 mm", "chamfer.tilt=0 deg"), "tilt the chamfer by 0.4495 deg (chamfer.tilt: auto)"),
        (("part.edges=outer", "chamfer.width=3.9 mm"), "a chamfer of 2.35 mm or less (chamfer.width)"),
        (("tool.axis=-z",), "another tool axis (tool.axis: auto or +y or -y or +z)"),
    ],
)  # fmt: skip
def test_every_remedy_works(case, first):
    """What is advised is run: oblique and eccentric holes have other limits than the upright central one."""
    advice = [text for text in run(*BASE, *case).advice if not text.startswith("not worked out")]
    assert advice[0].startswith(first)
    for text in advice:
        changes = [f"{key}={value}" for key, value in re.findall(r"\(([\w.]+): (\S+?)[ )]", text)]
        for number, unit, key in re.findall(r"([\d.]+) (mm|deg)[^\d]*?\(([a-z._]+)\)", text):
            changes.append(f"{key}={number} {unit}")
        assert changes, text
        assert run(*BASE, *case, *changes).infeasible == (), text


def test_limits_of_an_eccentric_hole_are_its_own():
    """A rod of 1.2377 mm just goes, by an independent program; 1.304 mm is the upright central hole's."""
    advice = run(*BASE, "part.pipe.eccentricity=4 mm", "chamfer.tilt=0 deg").advice
    rod = next(float(re.search(r"a rod of ([\d.]+) mm", text).group(1)) for text in advice if text.startswith("a rod"))
    assert 1.225 < rod <= 1.2377


def test_tilt_cures_what_it_can():
    result = run("tool.knife_limit_angle=45 deg")
    assert not result.infeasible
    assert np.degrees(result.measures["tilt"].value) == pytest.approx(4.301222, abs=1e-5)
    assert result.verdict == "pass"


def test_gcode_read_back_leaves_the_width():
    """Parsed from its text alone, the program sweeps the chamfer that was wanted, within rounding and chords."""
    program = program_of(run())
    text = post.gcode(program, decimals=5)
    tips = np.array([[float(v) for v in re.findall(r"[XYZ](-?[\d.]+)", line)]
                     for line in text.splitlines() if line.startswith("G1")])  # fmt: skip
    centre = tips * 1e-3 + np.array([0.0, 0.0, 2e-3])
    at = pipe_edge(PipeHole(0.015, 0.002, 0.004), 2 * np.pi * (np.arange(40) + 0.37) / 40, inner=True)
    width = swept_chamfer(at, centre, 0.002, 0.5e-3, closed=False).width
    assert width == pytest.approx(0.3e-3, abs=0.4e-6)
    feeds = [float(f) for f in re.findall(r"F([\d.]+)", text)]
    assert 109 < min(feeds) < max(feeds) < 140
    assert tips[:, 2].max() < 14.0 < float(re.findall(r"G0 .* Z([\d.]+)", text)[0])


def test_poses_are_rotations_against_the_tool():
    program = program_of(run())
    frames = post.pose_frames(program)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-12)
    np.testing.assert_allclose(frames[:, :, 2], -program.axis, atol=1e-12)
    assert len(re.findall(r"^\d", post.poses_csv(program), re.MULTILINE)) == len(program.position)
    assert post.apt(program).count("GOTO/") == len(program.position)


def test_a_spindle_that_is_not_pushed_past_breakaway_does_not_move():
    spindle = ("operation.contact_feed=20 mm/s", "spindle.library=berselli2016", "spindle.pressure=5 bar")
    result = run(*spindle)
    assert result.measures["tip_deflection_max"].value < 1e-9
    for end in ("min", "max"):
        rigid, yielding = (result.measures[f"width{k}_{end}"].value for k in ("", "_deflected"))
        assert yielding == pytest.approx(rigid, abs=1e-12)
    path = result["motion"].dataset["centre"].values
    assert lengths(path, closed=True).sum() == pytest.approx(result.measures["path_length"].value)


def test_at_two_bar_a_wide_chamfer_moves_the_spindle():
    """Force above the 6.35 N breakaway: the tip gives way, and the chamfer is narrower than the rigid tool's."""
    result = cutwise.simulate(cutwise.load(COMPLIANT, ("operation.preset=0 mm", "operation.part_error=0 mm")))
    assert result.measures["breakaway_force"].value == pytest.approx(6.35, abs=0.01)
    assert result.measures["lateral_force_max"].value > result.measures["breakaway_force"].value
    assert result.measures["tip_deflection_max"].value > 0.3e-3
    assert result.measures["width_deflected_min"].value < 0.8e-3


def value(result, name):
    return result.measures[name].value


def yielding(*overrides):
    return cutwise.simulate(cutwise.load(COMPLIANT, ("path.points=360", *STIFF, *overrides)))


def test_the_base_chamfer_does_not_move_the_spindle_and_says_so():
    """Of the specification: 0.76 N across the rod against 13.78 N breakaway at 5 bar; coupled is rigid."""
    result = yielding("part.edges=inner")
    assert value(result, "lateral_force_max") == pytest.approx(0.76, abs=0.01)
    assert value(result, "breakaway_force") == pytest.approx(13.78, abs=0.01)
    assert value(result, "tip_deflection_max") < 1e-15
    for end in ("min", "max"):
        assert value(result, f"width_deflected_{end}") == pytest.approx(value(result, f"width_{end}"), abs=1e-15)
    said = [text for text in result.warnings if "does not move" in text]
    assert len(said) == 1
    assert "0.761 N of 13.8 N" in said[0]


def test_a_preset_acts_along_minus_y_of_the_pass():
    """dw = (dw/dd)(b . y_l) dy: -1.315 per unit where the wedge is square; the spindle stays below breakaway."""
    scenario = cutwise.load(COMPLIANT, ("path.points=720", *STIFF, "operation.part_error=1 um"))
    done = chamfer.run(scenario)
    change = (done.deflected[0].width - done.paths[0].found.width) / 1e-6
    angle = done.paths[0].at.parameter
    square = np.abs(np.degrees(angle) - 90.0).argmin()
    assert change[square] == pytest.approx(1.315, abs=2e-3)
    assert np.abs(done.deflected[0].moves.tip).max() < 1e-9


def test_a_burr_along_the_edge_loads_the_tool_and_moves_the_spindle():
    bare = yielding("spindle.pressure=2 bar", "chamfer.width=0.6 mm")
    burr = yielding(
        "spindle.pressure=2 bar", "chamfer.width=0.6 mm", "part.burr={height: 0.5 mm, width: 0.3 mm, on: wall}"
    )
    assert value(bare, "tip_deflection_max") < 1e-9
    assert "burr_force_mean_x" not in bare.measures
    assert value(burr, "tip_deflection_max") > 0.1e-3
    assert value(burr, "width_deflected_min") < value(bare, "width_deflected_min") - 0.1e-3
    work = value(bare, "force_mean_x")
    assert value(burr, "force_mean_x") == pytest.approx(work + value(burr, "burr_force_mean_x"), rel=1e-9)
    # the whole strip of 0.5 mm by 0.3 mm
    assert value(burr, "chip_area") - value(bare, "chip_area") == pytest.approx(0.15e-6, rel=0.01)


def test_a_burr_on_one_part_of_the_edge_loads_that_part(tmp_path):
    """The table runs along the edge from its start at theta = 0."""
    table = tmp_path / "burr.csv"
    table.write_text("w [mm],height [mm]\n0,0.5\n5,0.5\n5.001,0\n40,0\n", encoding="utf-8")
    edges, burr = "  edges: outer\n", "  burr: {height: {table: burr.csv}, width: 0.2 mm, on: wall}\n"
    text = COMPLIANT.read_text(encoding="utf-8").replace(edges, edges + burr)
    (tmp_path / "case.yaml").write_text(text, encoding="utf-8")
    done = chamfer.run(cutwise.load(tmp_path / "case.yaml", ("path.points=360",)))
    loaded = np.linalg.norm(done.forces[0].burr_force, axis=1) > 0.0
    way = np.concatenate([[0.0], np.cumsum(lengths(done.paths[0].path.frames.point, closed=True))[:-1]])
    np.testing.assert_array_equal(loaded, way < 5.001e-3)
    table.write_text("w [mm],height [mm]\n0,0.5\n5,0.5\n", encoding="utf-8")
    with pytest.raises(ScenarioFault, match=r"the table ends at 5 mm, the edge at 25\.18 mm"):
        cutwise.simulate(cutwise.load(tmp_path / "case.yaml", ("path.points=360",)))


def test_both_edges_of_a_hole_at_once():
    both, outer, inner = (run(f"part.edges={edges}", "setup=null") for edges in ("all", "outer", "inner"))
    assert value(both, "edge_length") == pytest.approx(value(outer, "edge_length") + value(inner, "edge_length"))
    assert value(both, "rod_clearance_min") == value(inner, "rod_clearance_min")
    assert value(both, "width_min") == min(value(outer, "width_min"), value(inner, "width_min"))
    assert {0, 1} == set(program_of(both).path)


def test_two_chamfers_that_meet_in_the_wall_are_refused():
    wide = ("part.edges=all", "part.pipe.wall=1 mm", "chamfer.width=0.8 mm", "tool.rod_radius=0.5 mm",
            "tool.knife_limit_angle=20 deg", "requirements={}")  # fmt: skip
    result = run(*wide)
    assert any("legs of both chamfers" in text for text in result.infeasible)
    assert run(*wide, "part.pipe.wall=1.3 mm").infeasible == ()


def test_walls_are_compared_with_the_legs_at_the_same_place():
    """Thinnest wall and longest leg are not at the same place: 0.45 mm are enough for both chamfers."""
    thin = run("part.edges=all", "part.pipe.wall=0.45 mm", *BASE)
    assert thin.infeasible == ()
    tight = run("part.edges=all", "part.pipe.wall=0.42 mm", *BASE)
    assert tight.infeasible[0].startswith("legs_within_wall")


def test_one_edge_that_does_not_close_leaves_the_other():
    result = run("part.edges=all", "part.pipe.eccentricity=10 mm", "setup=null", "requirements={}")
    assert [text[: len("inner edge: no_edge")] for text in result.infeasible] == ["inner edge: no_edge"]
    assert value(result, "width_min") > 0.2998e-3


def test_a_tool_along_the_bore_reaches_the_inner_edge():
    """At theta = 90 degrees the wedge is square: the rod is as near to the bore as it is to the hole wall on the drill axis."""
    result = run("tool.axis=+y", "requirements={}")
    assert result.infeasible == ()
    assert value(result, "rod_clearance_min") == pytest.approx(0.054164e-3, abs=1e-8)
    wrong = run("tool.axis=-z", "requirements={}")
    assert [text.split(":")[0] for text in wrong.infeasible] == ["rod_clears_part"]
    assert "tool axis" in wrong.advice[0]


def test_leads_on_a_pipe_are_proven_or_said_not_to_be():
    assert not [text for text in run().warnings if "may touch" in text]
    assert [text for text in run("tool.axis=+y", "requirements={}").warnings if "may touch" in text]


LINEAR = ("material={K_tc: 2000 N/mm^2, K_rc: 1200 N/mm^2, K_ac: 800 N/mm^2, K_te: 0 N/mm, K_re: 0 N/mm, K_ae: 0 N/mm}",
          "tool.flutes=20", "operation.spindle_speed=40000 rpm", "operation.contact_feed=80 mm/s")  # fmt: skip


@pytest.mark.parametrize(
    ("edges", "inclination", "eccentricity", "close"),
    [("inner", 0, 0, 0.006), ("outer", 0, 0, 0.006), ("outer", 30, 0, 0.01), ("outer", 20, 3, 0.012),
     ("inner", 30, 0, 0.03)],
)  # fmt: skip
def test_section_and_power_of_an_edge_that_rises_and_falls(edges, inclination, eccentricity, close):
    """Against points of the normal plane, inside the true surfaces, that the swept ball takes away; faces bend a little."""
    case = (f"part.edges={edges}", f"part.pipe.inclination={inclination} deg", "path.points=720",
            f"part.pipe.eccentricity={eccentricity} mm", "requirements={}", "setup=null")  # fmt: skip
    result = run(*case, *LINEAR)
    area, power = result["engagement"].dataset["chip_area"].values, result["cutting"].dataset["power"].values
    centre, feed = (result["motion"].dataset[name].values for name in ("centre", "contact_feed"))
    part = PipeHole(0.015, 0.002, 0.004, eccentricity * 1e-3, np.radians(inclination))
    frames = pipe_edge(part, one_turn(720), inner=edges == "inner")
    foot = np.array([part.eccentricity, 0.0, 0.0])
    step = 2.5e-6
    side = np.arange(-0.4e-3, 0.4e-3, step) + 0.5 * step
    u, v = (grid.ravel()[:, None] for grid in np.meshgrid(side, side))
    c, s = np.cos(0.3), np.sin(0.3)  # no face runs along or across the grid
    for i in (0, 90, 180, 270, 450, 630):
        air, aside = frames.air[i], np.cross(frames.tangent[i], frames.air[i])
        point = frames.point[i] + u * (c * air + s * aside) + v * (c * aside - s * air)
        arm = point - foot
        from_axis = np.linalg.norm(arm - (arm @ part.drill_axis)[:, None] * part.drill_axis, axis=1)
        radius = np.hypot(point[:, 0], point[:, 2])
        solid = (from_axis > part.hole_radius) & (radius > 0.013) & (radius < 0.015)
        near = centre[np.arange(i - 15, i + 16) % 720]
        gone = KDTree(refined(near)).query(point[solid])[0] < 0.002
        exact = gone.sum() * step**2
        assert area[i] == pytest.approx(exact, rel=close)
        assert power[i] == pytest.approx(2000e6 * exact * feed[i], rel=close)


def refined(line, between=40):
    """More points on a polyline."""
    at = np.arange(len(line))
    fine = np.linspace(0, len(line) - 1, between * (len(line) - 1) + 1)
    return np.column_stack([np.interp(fine, at, column) for column in line.T])


def test_halved_steps_are_in_the_result():
    """Twice the points move the width by three quarters of the error of second order; twice the discs hardly the force."""
    changes = run("setup=null").convergence
    assert changes["width_min"] == pytest.approx(0.75 * 0.163e-6, rel=0.05)
    assert abs(changes["force_mean_x"]) < 1e-4
    assert set(changes) >= {"width_max", "chip_area", "cutting_power_mean"}


def moved(wedge, depth):
    """A wedge as a ball sees it that stands off the work by more."""
    return np.column_stack([wedge[:, :3], wedge[:, 3] - depth * wedge[:, 1]])


def test_a_dragged_ball_meets_the_material_where_it_is():
    """A hole in a plate: the force is that of the depth and of the speed that the ball has on its own circle."""
    scenario = cutwise.load(COMPLIANT, ("path.points=720", "part.pipe.radius=100 m", "requirements={}"))
    done = chamfer.run(scenario)
    path, moves = done.paths[0], done.deflected[0].moves
    assert moves.tip[:, 0].min() > 0.5e-3  # dragged forward, three quarters of a millimetre on a circle of three
    nominal, real = path.path.centre[:, :2], (path.path.centre + moves.offset)[:, :2]
    depth = np.linalg.norm(nominal, axis=1) - np.linalg.norm(real, axis=1)
    time = path.feeds.time / len(real)
    speed = (np.roll(real, -1, axis=0) - np.roll(real, 1, axis=0)) / (2.0 * time)
    out = real / np.linalg.norm(real, axis=1, keepdims=True)
    along, off = -(out[:, 0] * speed[:, 1] - out[:, 1] * speed[:, 0]), -np.einsum("ij,ij->i", speed, out)
    along *= np.sign(along.mean())
    section, ball = material_along(scenario, path), ball_end(scenario)
    turn = along / np.linalg.norm(real, axis=1)  # [rad/s]: the contact goes round with the ball, on a larger circle
    contact = turn * np.linalg.norm(nominal, axis=1) * section.speed / path.feeds.centre
    errors = []
    for i in range(60, 660, 5):
        force = ball_cut(moved(section.wedge[i], depth[i]), ball, contact[i], off[i], 0.0, 48).force
        errors.append(np.abs(moves.force[i] - [force.x, force.y, force.z]).max())
    assert np.median(errors) < 0.03  # of up to 5 N, which change by 0.5 N from one point to the next
    assert max(errors) < 0.5


def test_along_a_straight_edge_friction_holds_the_tool_within_its_band():
    """Between the forces at which the spindle comes back and goes on, at the width that takes this force."""
    changes = ("requirements={}", "part.edges=edge:4", "spindle.library=berselli2016", "spindle.pressure=2 bar",
               "tool.flutes=20", "operation.spindle_speed=40000 rpm", "operation.contact_feed=80 mm/s",
               "chamfer.width=0.9 mm", "material.library=berselli2016", "operation.preset=0.1 mm")  # fmt: skip
    scenario = cutwise.load(EXAMPLE.with_name("chamfer_step_part.yaml"), changes)
    done = chamfer.run(scenario)
    path, found = done.paths[0], done.deflected[0]
    ring = ring_on(scenario, mounted(path, [path]))
    back, on = (getattr(characteristic(ring, scenario.spindle.tool_reach), k).plateau for k in ("unloading", "loading"))
    lateral = np.hypot(*found.moves.force[:, :2].T)
    assert np.ptp(lateral) < 1e-6
    assert back < lateral[0] < on
    section = material_along(scenario, path)
    depth = float(np.einsum("ij,ij->i", found.moves.offset, path.local.off)[0])
    force = ball_cut(moved(section.wedge[0], depth), ball_end(scenario), section.speed[0], 0.0, 0.0, 48).force
    assert np.hypot(force.x, force.y) == pytest.approx(lateral[0], rel=1e-6)
    assert np.ptp(found.width) < 1e-9


def test_a_tool_that_is_dragged_to_its_stop_is_not_believed():
    result = cutwise.simulate(cutwise.load(COMPLIANT, ("operation.contact_feed=200 mm/s",)))
    assert value(result, "stroke_margin") == pytest.approx(0.0, abs=1e-9)
    assert next(finding.code for finding in result.unsound) == "at_stop"
    assert "width_deflected_max" not in result.measures
    assert result.verdict == "fail"


def test_a_dragged_ball_meets_an_edge_that_rises_where_it_is():
    """On the pipe: wedge, depth and height at the foot of the ball, found on the exact edge by bisection."""
    scenario = cutwise.load(COMPLIANT, ("path.points=720", "requirements={}"))
    done = chamfer.run(scenario)
    path, moves, part = done.paths[0], done.deflected[0].moves, PipeHole(0.015, 0.002, 0.004)
    nodes = pipe_edge(part, one_turn(512), inner=False)
    real = path.path.centre + moves.offset

    def at(theta):
        frames = pipe_edge(part, np.array([theta]), inner=False)
        return chamfer_path(frames, Chamfer(0.9e-3), 0.002, nodes=nodes)

    def feed(one):
        return pass_frames(one.frames.tangent, path.axis)

    def foot(i):
        def behind(theta):
            one = at(theta)
            return (real[i] - one.centre[0]) @ feed(one).feed[0]

        start = path.path.frames.parameter[i]
        return at(brentq(behind, start - 1.2, start + 1.2))

    errors = []
    for i in range(55, 700, 40):
        before, here, after = (foot(j) for j in (i - 1, i, i + 1))
        local = feed(here)
        duration = 2.0 * float(
            path.feeds.centre[i] ** -1 * np.linalg.norm(np.diff(path.path.centre[i : i + 2], axis=0))
        )
        speed = np.linalg.norm(after.contact.mean(axis=1) - before.contact.mean(axis=1)) / duration
        off = (real[i + 1] - real[i - 1]) / duration @ local.off[0]
        section = sections(here._replace(centre=real[[i]]), local, path.axis, np.array([speed]))
        nominal = [one.centre[0] @ path.axis for one in (before, after)]
        sinks = (real[i + 1] - real[i - 1]) @ path.axis - (nominal[1] - nominal[0])
        rise = section.rise[0] + sinks / duration
        force = ball_cut(section.wedge[0], ball_end(scenario), section.speed[0], off, rise, 48).force
        errors.append(np.abs(moves.force[i] - [force.x, force.y, force.z]).max())
    assert np.median(errors) < 0.15  # of up to 8 N
    assert max(errors) < 0.5


def test_cast_aluminium_by_kienzles_law():
    """Power is what the law says of the chips: between those of the thinnest and the thickest disc."""
    scenario = cutwise.load(COMPLIANT, ("path.points=90", "material.library=kienzle_cast_al", "spindle=null",
                                        "requirements={}"))  # fmt: skip
    result = cutwise.simulate(scenario)
    found = {name: measure.value for name, measure in result.measures.items()}
    energy = found["cutting_power_mean"] / (found["chip_area"] * scenario.operation.contact_feed)
    thickest = 2.0 * np.pi * scenario.operation.contact_feed / (scenario.operation.spindle_speed * scenario.tool.flutes)
    least, most = (700e6 * (1e3 * h) ** -0.25 for h in (thickest, 1e-7))
    assert least < energy < most
    assert any("the coefficients hold for chips of 20 µm" in said for said in result.warnings)


def test_a_set_up_warning_offers_no_spindle_to_one_who_has_it():
    said = [
        text for text in cutwise.simulate(cutwise.load(COMPLIANT, ("path.points=90",))).warnings if "set-up" in text
    ]
    assert said
    assert not any("use a compliant spindle" in text for text in said)
