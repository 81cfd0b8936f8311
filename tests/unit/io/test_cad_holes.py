"""Holes: walls that close and are in one piece. Edges: split where their kind changes, in any pose and unit."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from cutwise.io import cad, cad_edges, cad_mesh, cad_parts, cad_select, step
from cutwise.io.occ import occ

STEP = Path(__file__).parents[2] / "data" / "step"


def model(file):
    return cad.topology(step.read_step(file))


def holes(shape, folder):
    """Diameter, depth and middle of each hole [mm], sorted."""
    found = model(step.write_step(shape, folder / "part.step")).holes
    return sorted(
        (round(2e3 * h.radius, 6), round(1e3 * h.depth, 6), *np.round(1e3 * np.array(h.middle), 6)) for h in found
    )


def box(x, y, z, at=(0.0, 0.0, 0.0)):
    return occ("BRepPrimAPI").BRepPrimAPI_MakeBox(occ("gp").gp_Pnt(*at), x, y, z).Shape()


def rod(origin, axis, radius, height, turn=2.0 * math.pi):
    gp = occ("gp")
    frame = gp.gp_Ax2(gp.gp_Pnt(*origin), gp.gp_Dir(*axis))
    return occ("BRepPrimAPI").BRepPrimAPI_MakeCylinder(frame, radius, height, turn).Shape()


def cut(body, *tools):
    for tool in tools:
        body = occ("BRepAlgoAPI").BRepAlgoAPI_Cut(body, tool).Shape()
    return body


def moved(shape, scale=1.0):
    """In another pose, and larger."""
    gp = occ("gp")
    turn, shift, size = gp.gp_Trsf(), gp.gp_Trsf(), gp.gp_Trsf()
    turn.SetRotation(gp.gp_Ax1(gp.gp_Pnt(3, -7, 11), gp.gp_Dir(1, 2, -0.7)), 0.83)
    shift.SetTranslation(gp.gp_Vec(1234.5, -678.9, 42.0))
    size.SetScale(gp.gp_Pnt(0, 0, 0), scale)
    return occ("BRepBuilderAPI").BRepBuilderAPI_Transform(shape, shift.Multiplied(turn).Multiplied(size), True).Shape()


def clevis():
    return cut(box(30, 40, 40), box(30, 24, 32, (0, 8, 8)), rod((15, -1, 26), (0, 1, 0), 5, 50))


def test_both_ears_of_a_clevis_have_a_hole_of_their_own():
    """Version 0.1: one hole, 40 mm deep, its middle in the air."""
    found = sorted(model(STEP / "clevis.step").holes, key=lambda h: h.middle[1])
    assert [(2e3 * h.radius, 1e3 * h.depth) for h in found] == [pytest.approx((10.0, 8.0))] * 2
    np.testing.assert_allclose([h.middle for h in found], [(0.015, 0.004, 0.026), (0.015, 0.036, 0.026)], atol=1e-12)


@pytest.mark.parametrize("scale", [1.0, 25.4, 0.1])
def test_a_clevis_in_any_pose_and_size(tmp_path, scale):
    found = holes(moved(clevis(), scale), tmp_path)
    assert [(d, depth) for d, depth, *_ in found] == [pytest.approx((10.0 * scale, 8.0 * scale))] * 2


@pytest.mark.parametrize("unit", ["INCH", "M"])
def test_a_clevis_in_another_unit(tmp_path, unit):
    control = occ("Interface").Interface_Static
    control.SetCVal_s("write.step.unit", unit)
    try:
        file = step.write_step(clevis(), tmp_path / "part.step")
    finally:
        control.SetCVal_s("write.step.unit", "MM")
    found = model(file)
    assert found.part.unit == {"INCH": "inch", "M": "metre"}[unit]
    assert [h.depth for h in found.holes] == pytest.approx([0.008, 0.008])


@pytest.mark.parametrize("apart", ["", "1e-9", "1e-7", "1e-5"])
def test_half_walls_are_one_hole_within_the_tolerance(tmp_path, apart):
    """Axes of both halves a little apart; version 0.1 rounded to 1e-3 mm and fell into two boxes."""
    text = (STEP / "half_cylinder_hole_1e-9.step").read_text()
    if apart:
        name = re.search(r"CYLINDRICAL_SURFACE\('',(#\d+),", text)[1]
        place = re.search(rf"{name} = AXIS2_PLACEMENT_3D\('',(#\d+),", text)[1]
        point = re.search(rf"{place} = CARTESIAN_POINT\('',\(([-\d.E]+),", text)
        text = text[: point.start(1)] + repr(float(point[1]) + float(apart)) + text[point.end(1) :]
    file = tmp_path / "part.step"
    file.write_text(text)
    (hole,) = model(file).holes
    assert len(hole.faces) == 2
    assert (2e3 * hole.radius, 1e3 * hole.depth) == pytest.approx((7.9375, 10.0), abs=1e-6)


def test_outer_selects_the_rims_of_a_hole_in_two_halves():
    chains = cad_edges.sharp_chains(model(STEP / "half_cylinder_hole_1e-9.step"), spacing=1e-3)
    assert len(cad_select.select(chains, "outer")) == 2


def test_walls_that_were_never_sewn_are_joined_by_distance(tmp_path):
    """Two half tubes as surfaces only, each with its own edges along the joint."""
    whole = occ("TopoDS").TopoDS_Compound()
    builder = occ("BRep").BRep_Builder()
    builder.MakeCompound(whole)
    gp = occ("gp")
    frame = gp.gp_Ax3(gp.gp_Pnt(5, 5, 0), gp.gp_Dir(0, 0, 1))
    for start in (0.0, math.pi):
        make = occ("BRepBuilderAPI").BRepBuilderAPI_MakeFace(
            gp.gp_Cylinder(frame, 4.0), start, start + math.pi, 0.0, 9.0
        )
        builder.Add(whole, make.Face().Reversed())
    assert holes(whole, tmp_path) == [pytest.approx((8.0, 9.0, 5.0, 5.0, 4.5))]


@pytest.mark.parametrize("joined", [True, False])
def test_a_wall_in_two_halves_at_other_heights_is_no_hole(tmp_path, joined):
    """Half a turn on each side of one axis adds up to a full turn that is nowhere closed."""
    block = box(20, 20, 20)
    low, high = (
        rod((10, 10, -1), (0, 0, 1), 4, 9, math.pi),
        rod((10, 10, 12), (0, 0, -1), 4, 8 if joined else 2, math.pi),
    )
    found = holes(cut(block, low, high, rod((10, 10, 12), (0, 0, 1), 4, 9, math.pi)), tmp_path)
    assert found == []


def test_slots_fillets_and_keyways_are_no_holes(tmp_path):
    slot = cut(
        box(40, 20, 10),
        rod((10, 10, -1), (0, 0, 1), 3, 12),
        rod((20, 10, -1), (0, 0, 1), 3, 12),
        box(10, 6, 12, (10, 7, -1)),
    )
    keyway = cut(box(40, 20, 10), rod((20, 10, -1), (0, 0, 1), 6, 12), box(3, 8, 12, (18.5, 10, -1)))
    assert holes(slot, tmp_path) == []
    assert holes(keyway, tmp_path) == []


def test_holes_of_all_kinds(tmp_path):
    """Through, blind, stepped, slanted through a thin plate, crossed by a smaller and by a larger bore."""
    thin = cut(box(40, 40, 1), rod((20, 20, 0), (0, 0.8, 0.6), 4, 30), rod((20, 20, 0), (0, -0.8, -0.6), 4, 30))
    assert [h[0] for h in holes(thin, tmp_path)] == [8.0]
    steps = cut(box(40, 40, 20), rod((20, 20, -1), (0, 0, 1), 3, 22), rod((20, 20, 12), (0, 0, 1), 5, 10))
    assert holes(steps, tmp_path) == [pytest.approx((6, 12, 20, 20, 6)), pytest.approx((10, 8, 20, 20, 16))]
    groove = cut(box(40, 40, 20), rod((20, 20, -1), (0, 0, 1), 3, 22), rod((20, 20, 9), (0, 0, 1), 4, 2))
    assert [(d, depth) for d, depth, *_ in holes(groove, tmp_path)] == [
        pytest.approx((6, 9)),
        pytest.approx((6, 9)),
        pytest.approx((8, 2)),
    ]
    small = cut(box(40, 40, 20), rod((20, 20, -1), (0, 0, 1), 5, 22), rod((-1, 20, 10), (1, 0, 0), 2, 50))
    assert sorted(d for d, *_ in holes(small, tmp_path)) == [4, 4, 10]
    large = cut(box(40, 40, 20), rod((20, 20, -1), (0, 0, 1), 3, 22), rod((-1, 20, 10), (1, 0, 0), 5, 50))
    assert sorted(d for d, *_ in holes(large, tmp_path)) == [6, 6, 10]
    pipe = cad_parts.drilled_pipe(0.015, 0.002, 0.004, 0.06)
    assert [h[0] for h in holes(pipe, tmp_path)] == [8, 26]


def test_an_edge_is_split_where_its_kind_changes():
    """Convex by 40 degrees at one end, concave by 45 at the other; version 0.1 called all of it concave."""
    found = model(STEP / "roof_convex40_concave45.step")
    (pieces,) = found.split
    assert [piece.kind for piece in pieces] == [cad.CONVEX, cad.CONCAVE]
    chains = cad_edges.sharp_chains(found, spacing=5e-4)
    (ridge,) = [c for c in chains if c.edges == (pieces[0].index,)]
    half = (
        60e-3 * math.tan(math.radians(40)) / (math.tan(math.radians(40)) + 1.0)
    )  # the slope is linear along the ridge
    assert ridge.length == pytest.approx(half, rel=1e-3)
    np.testing.assert_allclose(
        np.degrees([ridge.frames.wedge.min(), ridge.frames.wedge.max()]), [140.0, 180.0], atol=1e-3
    )
    assert "convex, then concave: it is split at (27.38, 15, 10) mm" in found.notices[0]
    assert found.whole_edges == 15


def test_an_edge_that_only_fades_stays_whole():
    found = model(STEP / "fading_ridge_4mm.step")
    assert found.split == ()
    assert found.count(cad.CONVEX) == 15


def placed(mirror=None, scale=None, by=(0.0, 0.0, 0.0)):
    gp = occ("gp")
    trsf, away = gp.gp_Trsf(), gp.gp_Trsf()
    if mirror is not None:
        trsf.SetMirror(gp.gp_Ax2(gp.gp_Pnt(0.0, 0.0, 0.0), gp.gp_Dir(*mirror)))
    if scale is not None:
        trsf.SetScale(gp.gp_Pnt(0.0, 0.0, 0.0), scale)
    away.SetTranslation(gp.gp_Vec(*by))
    return occ("TopLoc").TopLoc_Location(away.Multiplied(trsf))


def together(*shapes):
    whole, builder = occ("TopoDS").TopoDS_Compound(), occ("BRep").BRep_Builder()
    builder.MakeCompound(whole)
    for shape in shapes:
        builder.Add(whole, shape)
    return whole


def test_bodies_placed_mirrored_or_scaled_are_as_good_as_any(tmp_path):
    plate = cut(box(40, 30, 10), rod((10, 8, -1), (0, 0, 1), 4, 12))
    pair = together(plate, plate.Moved(placed(by=(0, 0, 50))))
    whole = together(
        plate, plate.Moved(placed(mirror=(1, 0, 0), by=(-20, 0, 0))), plate.Moved(placed(scale=2.0, by=(100, 0, 0))),
        pair.Moved(placed(mirror=(0, 1, 0), by=(0, -20, 0))),
    )  # fmt: skip
    with_placements("1")
    try:
        file = step.write_step(whole, tmp_path / "whole.step")
    finally:
        with_placements("0")
    assert "CARTESIAN_TRANSFORMATION_OPERATOR_3D" in file.read_text()  # what a body is mirrored or scaled with
    found = model(file)
    assert {edge.kind for edge in found.edges} == {cad.CONVEX, cad.SEAM}
    middles = sorted(tuple(np.round(1e3 * np.array(h.middle), 6)) for h in found.holes)
    assert middles == [(-30, 8, 5), (10, -28, 5), (10, -28, 55), (10, 8, 5), (120, 16, 10)]
    assert sorted(round(2e3 * h.radius, 6) for h in found.holes) == [8, 8, 8, 8, 16]
    assert sorted(round(1e3 * h.depth, 6) for h in found.holes) == [10, 10, 10, 10, 20]
    volume = step.mass_properties(found.part, 1e9).mass  # of 1 g/mm3, mm3 in g
    assert volume == pytest.approx((4 + 8) * (12000 - 160 * math.pi), rel=1e-9)


def with_placements(on):
    occ("Interface").Interface_Static.SetCVal_s("write.step.assembly", on)


@pytest.mark.parametrize("many", [10, 10_000])
def test_the_skin_of_a_part_of_many_edges_is_whole(tmp_path, monkeypatch, many):
    """Both ways to triangulate: the one that is quick for many edges, and the usual one."""
    monkeypatch.setattr(cad_mesh, "_MANY", many)
    plate = cut(
        box(60, 60, 10), *(rod((15 + 15 * i, 15 + 15 * j, -1), (0, 0, 1), 4, 12) for i in range(3) for j in range(3))
    )
    found = model(step.write_step(plate, tmp_path / "plate.step"))
    mesh = cad_mesh.cad_mesh(found)
    corner = mesh.corner[:, :9].reshape(-1, 3, 3)
    sides = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    exact = 2 * (3600 - 9 * 16 * math.pi) + 2400 + 9 * 80 * math.pi
    assert set(mesh.face) == {face.index for face in found.faces}
    assert 0.5e6 * np.linalg.norm(sides, axis=1).sum() == pytest.approx(exact, rel=5e-4)


@pytest.mark.parametrize("splines", [False, True], ids=["cylinders", "splines"])
@pytest.mark.parametrize("pose", [lambda s: s, moved], ids=["straight", "turned"])
def test_a_hole_is_its_wall_whatever_surface_it_is_written_as(splines, pose, tmp_path):
    """A tilted hole through a plate of 10: 10/cos + 2 r tan along its axis, its middle in the middle of the plate.

    The ends that OpenCascade states for a tilted wall lie 0.08 mm outside of it, and a rational spline was no wall.
    """
    tilt = 0.3
    plate = cut(box(40, 30, 10), rod((12, 15, -1), (0, 0, 1), 4, 12), rod((28, 15, -1), (tilt, 0, 1), 3, 14))
    shape = pose(plate)
    if splines:
        shape = occ("BRepBuilderAPI").BRepBuilderAPI_NurbsConvert(shape, True).Shape()
    found = sorted(model(step.write_step(shape, tmp_path / "part.step")).holes, key=lambda h: -h.radius)
    assert [round(2e3 * hole.radius, 6) for hole in found] == [8.0, 6.0]
    assert found[0].depth == pytest.approx(10e-3, abs=1e-9)
    assert found[1].depth == pytest.approx((10 * math.hypot(1, tilt) + 6 * tilt) * 1e-3, abs=2e-8)
    apart = math.dist(found[0].middle, found[1].middle)
    assert apart == pytest.approx((28 + 6 * tilt - 12) * 1e-3, abs=2e-8)


def test_a_free_form_fillet_and_a_boss_are_no_holes(tmp_path):
    boss = occ("BRepAlgoAPI").BRepAlgoAPI_Fuse(box(30, 30, 5), rod((15, 15, 5), (0, 0, 1), 4, 6)).Shape()
    slot = cut(box(30, 30, 5, (40, 0, 0)), rod((55, 0, -1), (0, 0, 1), 6, 7))
    for shape in (boss, slot):
        free = occ("BRepBuilderAPI").BRepBuilderAPI_NurbsConvert(shape, True).Shape()
        assert holes(free, tmp_path) == []
