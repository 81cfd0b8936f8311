"""Chamfers on CAD parts: all edges together, corners, what is left out and why, the program's leads."""

import math
import re

import numpy as np
import pytest

import cutwise
from cutwise.io import cad, cad_edges, cad_mesh, cad_parts, cad_select, step
from cutwise.maths.edges import lengths
from cutwise.paths.chamfer.ball_path import Chamfer, chamfer_path
from cutwise.paths.chamfer.corners import Link, tours
from cutwise.paths.pipe import PipeHole
from cutwise.process import chamfer
from cutwise.process.chamfer_program import moves, program_of
from cutwise.process.chamfer_task import task_of

BASE = ("requirements={}",)


@pytest.fixture(scope="module")
def run(examples):
    def of(*overrides):
        return cutwise.simulate(cutwise.load(examples / "chamfer_step_part.yaml", (*BASE, *overrides)))

    return of


@pytest.fixture(scope="module")
def block(run):
    return run("part.edges=all")


def value(result, name):
    return result.measures[name].value


def test_every_edge_of_the_block_is_chamfered_up_to_its_corners(block):
    """25 edges: 12 straight ones between three faces each, holes through the top, where they cross, and bores."""
    assert value(block, "edges_chamfered") == 25
    assert value(block, "edges_refused") == 0
    assert value(block, "length_trimmed") == 0.0
    assert value(block, "gouge_max") == 0.0
    assert value(block, "gouge_bound") <= 2e-7
    assert 0.295e-3 < value(block, "width_min") <= value(block, "width_max") < 0.3001e-3
    assert value(block, "rod_clearance_bound") <= value(block, "rod_clearance_min")
    assert value(block, "rod_clearance_bound") > 0.0


def test_paths_go_on_round_convex_corners_at_the_distance_of_their_ends(examples):
    done = chamfer.run(cutwise.load(examples / "chamfer_step_part.yaml", (*BASE, "part.edges=all")))
    assert len(done.links) == 8
    paths = done.paths
    for link in done.links:
        corner = paths[link.first].path.frames.point[-1]
        np.testing.assert_allclose(corner, paths[link.second].path.frames.point[0], atol=1e-9)
        ends = [paths[link.first].path.centre[-1], paths[link.second].path.centre[0]]
        radius = np.linalg.norm(np.vstack([ends[0], link.centre, ends[1]]) - corner, axis=1)
        np.testing.assert_allclose(radius, radius[0], rtol=1e-9)
    program = moves(task_of(done_scenario(examples)), paths, done.links, done.members)
    assert program.unproven == ()


def done_scenario(examples):
    return cutwise.load(examples / "chamfer_step_part.yaml", (*BASE, "part.edges=all"))


def test_tours_follow_links_and_close_where_they_close():
    none = np.zeros((0, 3))
    assert tours(3, ()) == [[0], [1], [2]]
    assert tours(4, (Link(2, 0, none), Link(0, 3, none))) == [[1], [2, 0, 3]]
    assert tours(3, (Link(0, 1, none), Link(1, 2, none), Link(2, 0, none))) == [[0, 1, 2]]


def test_a_lone_edge_is_cut_up_to_its_square_corners(run):
    """The ball stands in the plane of the end face there: it takes no more off the neighbours than the chamfer."""
    result = run("part.edges=edge:4")
    assert value(result, "length_trimmed") == 0.0
    assert value(result, "gouge_max") == 0.0


def frustum(folder, lean):
    """A block whose one end leans outwards: the ball at the end of the long edge reaches over the corner."""
    gp, api = step.occ("gp"), step.occ("BRepBuilderAPI")
    polygon = api.BRepBuilderAPI_MakePolygon()
    for x, z in ((0, 0), (60 + 15 * math.tan(lean), 0), (60, 15), (0, 15)):
        polygon.Add(gp.gp_Pnt(x, 0, z))
    polygon.Close()
    face = api.BRepBuilderAPI_MakeFace(polygon.Wire()).Face()
    solid = step.occ("BRepPrimAPI").BRepPrimAPI_MakePrism(face, gp.gp_Vec(0, 30, 0)).Shape()
    return step.write_step(solid, folder / "frustum.step")


def test_a_lone_edge_stops_before_a_leaning_corner_and_says_at_which_edge(run, tmp_path):
    file = frustum(tmp_path, math.radians(80.0))
    chains = cad_edges.sharp_chains(cad.topology(step.read_step(file)))
    top = [c.number for c in chains if np.allclose(c.frames.point[:, 2], 0.015) and c.length > 0.05]
    alone = run(f"part.step={file}", f"part.edges=edge:{top[0]}", "chamfer.width=0.6 mm")
    assert 0.0 < value(alone, "length_trimmed") < 2.5e-3
    assert "which would be cut too: select it, or leave the corner" in alone.notes["left_out"]
    both = run(f"part.step={file}", "part.edges=all", "chamfer.width=0.6 mm")
    assert value(both, "length_trimmed") < value(alone, "length_trimmed")


def test_trimmed_and_chamfered_lengths_make_up_the_edge(examples):
    done = chamfer.run(
        cutwise.load(examples / "chamfer_step_part.yaml", (*BASE, "part.edges=edge:4", "tool.ball_radius=3 mm"))
    )
    plan = done.plans[0]
    whole = lengths(plan.work.nodes.point, closed=False).sum()
    cut = sum(lengths(path.path.frames.point, closed=False).sum() for path in plan.paths)
    assert cut + plan.trimmed == pytest.approx(whole, rel=1e-9)


def stepped(folder):
    """A block with a step: one of its edges runs into a wall."""
    gp, prim = step.occ("gp"), step.occ("BRepPrimAPI")
    low = prim.BRepPrimAPI_MakeBox(40.0, 30.0, 10.0).Shape()
    high = prim.BRepPrimAPI_MakeBox(gp.gp_Pnt(0.0, 0.0, 0.0), 15.0, 30.0, 20.0).Shape()
    return step.write_step(step.occ("BRepAlgoAPI").BRepAlgoAPI_Fuse(low, high).Shape(), folder / "step.step")


def test_an_edge_that_runs_into_a_wall_ends_where_the_ball_touches_it(run, tmp_path):
    """The wall begins beside the ball: sqrt(R_B^2 - (d / sqrt 2)^2) = 1.5 mm, less the chamfer on the wall's own edge."""
    result = run(f"part.step={stepped(tmp_path)}", "part.edges=all", "chamfer.width=0.3 mm")
    assert value(result, "edges_refused") == 0
    assert "concave corner with face" in result.notes["left_out"]
    walls = [line for line in result.notes["left_out"].splitlines() if "concave" in line]
    lost = float(walls[0].split("left out ")[1].split(" mm")[0])
    assert 1.2 < lost < 1.6
    assert value(result, "gouge_max") < 4e-6


def test_infeasible_edges_are_named_and_the_rest_is_done(run):
    """A ball of 4 mm does not go into the hole of 3 mm, and is too large for the bore of 7 mm where they cross."""
    result = run("part.edges=all", "tool.ball_radius=4 mm", "tool.rod_radius=1.5 mm", "chamfer.tilt=0 deg")
    assert result.verdict == "fail"
    assert value(result, "edges_chamfered") == 23
    assert [line.split(":")[0] for line in result.infeasible] == ["edge 21", "edge 24"]
    assert "the ball is too large" in result.infeasible[0]
    assert result.advice


def test_the_rod_stands_beside_the_wall_of_its_hole(run):
    """The inner rim of a straight hole: what remains of its radius beside path and rod."""
    result = run("part.edges=inner & hole:1", "part.block.holes=[{x: 15 mm, y: 20 mm, radius: 4 mm}]")
    path = result["motion"].dataset
    across = np.hypot(path["centre"].values[:, 0] - 15e-3, path["centre"].values[:, 1] - 20e-3)
    for number in np.unique(path["path"].values):
        mine = path["path"].values == number
        assert np.allclose(np.abs(path["tool_axis"].values[mine][:, 2]), 1.0)
    assert value(result, "rod_clearance_min") == pytest.approx(4e-3 - across.max() - 1e-3, abs=1e-8)


def test_programs_go_up_between_tours_and_never_rapid_through_the_part(block):
    program = program_of(block)
    top = 30e-3
    rapid = np.flatnonzero(program.feed == 0.0)
    for i in rapid[1:]:
        if program.feed[i - 1] == 0.0 and np.allclose(program.axis[i], program.axis[i - 1]):
            start, end = program.position[i - 1], program.position[i]
            across = np.linalg.norm((end - start) - ((end - start) @ program.axis[i]) * program.axis[i])
            level = min(start @ program.axis[i], end @ program.axis[i])
            assert across < 1e-9 or level > (top if program.axis[i][2] > 0.5 else 0.0)


def test_a_moved_and_turned_part_has_the_same_paths(tmp_path):
    gp = step.occ("gp")
    turn = gp.gp_Trsf()
    turn.SetRotation(gp.gp_Ax1(gp.gp_Pnt(3, 4, 5), gp.gp_Dir(1, 2, 3)), 0.7)
    straight = cad_parts.drilled_pipe(0.015, 0.002, 0.004, 0.06)
    turned = step.occ("BRepBuilderAPI").BRepBuilderAPI_Transform(straight, turn, True).Shape()
    found = []
    for name, shape in (("a", straight), ("b", turned)):
        model = cad.topology(step.read_step(step.write_step(shape, tmp_path / f"{name}.step")))
        chains = cad_edges.sharp_chains(model, spacing=5e-5)
        chain = next(c for c in chains if c.where == "inner" and len(c.edges) == 3)
        path = chamfer_path(chain.frames, Chamfer(0.3e-3), 0.002)
        found.append((chain.length, float(lengths(path.centre, closed=True).sum()), float(path.leg.max())))
    assert found[0] == pytest.approx(found[1], abs=1e-9)


def test_reversed_faces_are_turned_out_again(tmp_path):
    """A solid inside out has its normals mended by reading it, or is read the same: edges stay convex."""
    shape = cad_parts.drilled_block(0.02, 0.02, 0.02, [(0.01, 0.01, 0.004, 0.0)]).Reversed()
    model = cad.topology(step.read_step(step.write_step(shape, tmp_path / "r.step")))
    assert (model.count(cad.CONVEX), model.count(cad.CONCAVE)) in ((14, 0), (0, 14))


def test_free_form_faces_are_proved_too(run, tmp_path):
    """A lofted prism on a plate: its side faces are B-splines, its edges end at the concave root."""
    gp, api = step.occ("gp"), step.occ("BRepBuilderAPI")
    loft = step.occ("BRepOffsetAPI").BRepOffsetAPI_ThruSections(True, False, 1e-6)
    for k in range(3):
        polygon = api.BRepBuilderAPI_MakePolygon()
        for x, y in ((-8, -3), (8, -3), (8, 3), (-8, 3)):
            c, s = math.cos(0.15 * k), math.sin(0.15 * k)
            polygon.Add(gp.gp_Pnt(20 + c * x - s * y, 15 + s * x + c * y, 5 + 8 * k))
        polygon.Close()
        loft.AddWire(polygon.Wire())
    loft.Build()
    plate = step.occ("BRepPrimAPI").BRepPrimAPI_MakeBox(40.0, 30.0, 10.0).Shape()
    file = step.write_step(step.occ("BRepAlgoAPI").BRepAlgoAPI_Fuse(plate, loft.Shape()).Shape(), tmp_path / "l.step")
    model = cad.topology(step.read_step(file))
    assert len(model.splines.layout) >= 4
    mesh = cad_mesh.cad_mesh(model)
    assert mesh.error == cad_mesh.OUTLINE  # outlines of free-form faces are those of the mesh
    result = run(f"part.step={file}", "part.edges=all")
    assert value(result, "edges_refused") == 0
    assert value(result, "gouge_max") < 4e-6
    assert value(result, "width_min") > 0.29e-3


@pytest.mark.parametrize(
    ("wanted", "count"),
    [("all", 25), ("facing:+z & !outer", 4), ("longer:50mm", 5), ("edge:1-3", 3), ("closed, edge:1", 14),
     ("all & !all, edge:2", 1), ("sharper:80deg", 2), ("hole:2", 2), ("hole:2, hole:6", 4)],
)  # fmt: skip
def test_selectors(examples, wanted, count, block_chains):
    del examples
    assert len(cad_select.select(block_chains, wanted)) == count


@pytest.fixture(scope="module")
def block_chains(examples):
    from cutwise.process.chamfer_work import read_part

    scenario = cutwise.load(examples / "chamfer_step_part.yaml")
    return cad_edges.sharp_chains(cad.topology(read_part(scenario)))


@pytest.mark.parametrize(
    ("wanted", "words"),
    [("longer:5", "no unit"), ("top", "selects nothing: write all"), ("facing:up", "selects nothing"),
     ("hole:9", "there are edges 1 to 25 and holes"), ("edge:x", "selects nothing")],
)  # fmt: skip
def test_selectors_that_select_nothing(block_chains, wanted, words):
    with pytest.raises(step.CadFault, match=words):
        cad_select.select(block_chains, wanted)


def test_an_open_shell_is_worked_as_far_as_its_faces_go(run, tmp_path):
    shape = cad_parts.drilled_block(0.06, 0.04, 0.03, [(0.02, 0.02, 0.004, 0.0)])
    shell, builder = step.occ("TopoDS").TopoDS_Shell(), step.occ("BRep").BRep_Builder()
    builder.MakeShell(shell)
    for face in step.explored(shape, step.occ("TopAbs").TopAbs_ShapeEnum.TopAbs_FACE)[:-2]:
        builder.Add(shell, face)
    result = run(f"part.step={step.write_step(shell, tmp_path / 'open.step')}", "part.edges=all")
    assert any("open shell" in text for text in result.warnings)
    assert value(result, "edges_chamfered") >= 1


def test_pipe_as_step_and_as_formula_agree(run, examples, tmp_path):
    part = PipeHole(0.015, 0.002, 0.004)
    file = step.write_step(cad_parts.drilled_pipe(part.radius, part.wall, part.hole_radius, 0.06), tmp_path / "p.step")
    same = ("tool.ball_radius=2 mm", "tool.rod_radius=1.25 mm", "tool.knife_limit_angle=38.7 deg")
    by_cad = run(f"part.step={file}", "part.edges=inner", "path.chord_tolerance=0.5 um", *same)
    formula = cutwise.simulate(
        cutwise.load(examples / "chamfer_pipe_hole.yaml", ("setup=null", "path.chord_tolerance=0.5 um"))
    )
    for name in ("wedge_angle_max", "edge_length", "path_length"):
        assert value(by_cad, name) == pytest.approx(value(formula, name), rel=1e-3), name
    assert value(by_cad, "knife_margin_min") == pytest.approx(value(formula, "knife_margin_min"), abs=1e-4)
    # the two have other points, and a chord error of 0.5 um between them
    assert value(by_cad, "rod_clearance_min") == pytest.approx(value(formula, "rod_clearance_min"), abs=2e-7)


def plate(folder):
    """A plate with a hole of 7 mm and one of 10 mm."""
    solid = cad_parts.drilled_block(0.06, 0.04, 0.01, [(0.015, 0.02, 0.0035, 0.0), (0.04, 0.02, 0.005, 0.0)])
    return step.write_step(solid, folder / "plate.step")


def test_points_and_chord_tolerance_are_kept_on_cad_parts(run, tmp_path):
    file = plate(tmp_path)
    for points in (36, 1440, 2000):
        found = run(f"part={{step: {file}, edges: 'hole:1 & facing:+z'}}", f"path={{points: {points}}}")
        assert value(found, "points") == points
        assert value(found, "edge_length") == pytest.approx(2.0 * math.pi * 3.5e-3, rel=1e-7)
    errors = []
    for tolerance in (0.1, 2.0, 20.0):
        found = run(f"part={{step: {file}, edges: all}}", f"path={{chord_tolerance: {tolerance} um}}")
        errors.append(value(found, "chord_error") / (tolerance * 1e-6))
    assert max(errors) <= 1.0
    assert errors[1] > 0.5


def test_the_rod_margin_that_is_told_is_the_measure(run, tmp_path):
    """By hand: the rod in a hole of 3.5 mm."""
    found = run(f"part={{step: {plate(tmp_path)}, edges: hole:1}}", "tool.axis=+z")
    told = re.search(r"rod_clears_part: .*margin \+([\d.]+) mm", found.notes["margins"]).group(1)
    assert float(told) == pytest.approx(value(found, "rod_clearance_min") * 1e3, abs=6e-4)


def test_a_tilt_on_a_cad_part_is_the_smallest_that_is_needed(run, tmp_path):
    file = step.write_step(cad_parts.drilled_pipe(0.015, 0.002, 0.004, 0.06), tmp_path / "pipe.step")
    tool = "tool={ball_radius: 2 mm, rod_radius: 1.25 mm, knife_limit_angle: 30 deg}"
    found = run(f"part={{step: {file}, edges: inner}}", "chamfer.width=0.5 mm", tool.replace("30", "38.7"))
    exact = math.radians(0.8807558)
    assert exact - 1e-9 < value(found, "tilt") < exact + 1e-6


def test_holes_are_entered_from_the_side_on_which_less_rod_sticks_out(run):
    """The far end of a 60 mm bore was chamfered through all of it."""
    found = run()
    assert value(found, "rod_reach") < 3e-3
    assert not [text for text in found.warnings if "of rod above the ball centre" in text]
    through = run("part.edges=edge:13", "tool.axis=+x")
    assert value(through, "rod_reach") == pytest.approx(61.3e-3, abs=0.1e-3)
    assert any("61 times its radius" in text for text in through.warnings)
