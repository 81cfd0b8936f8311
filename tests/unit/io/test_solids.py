"""STL in and out, columns of closed surfaces, samples of STEP faces, and the machined stock as a solid."""

import math

import numpy as np
import pytest

from cutwise.io import solid_files, stl
from cutwise.io.cad_parts import drilled_block
from cutwise.io.occ import CadFault
from cutwise.io.part_samples import moved, part_samples
from cutwise.io.solid_mesh import solid_triangles
from cutwise.io.step import write_step
from cutwise.maths.rays import columns

MM = 1e-3


def cube(size=10.0):
    """Triangles of a cube [m], by the solid of one cell."""
    corners = MM * np.array([0.0, size])
    flat = np.full((2, 2), MM * size)
    point, triangle, _ = solid_files.closed(corners, corners, flat, np.zeros((2, 2)), np.ones((1, 1), bool))
    return point[triangle]


def volume(triangles):
    return float(np.einsum("ij,ij->i", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum() / 6)


def test_binary_and_text_stl_are_read_back(tmp_path):
    file = tmp_path / "cube.stl"
    file.write_bytes(stl.stl_bytes(cube()))
    assert volume(stl.read_stl(file)) == pytest.approx(1e-6)
    text = (
        "solid x\n"
        + "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x} {y} {z}\n" for x, y, z in 1e3 * t)
            + "endloop\nendfacet\n"
            for t in cube()
        )
        + "endsolid x\n"
    )
    file.write_text(text)
    assert volume(stl.read_stl(file)) == pytest.approx(1e-6)


def test_an_open_or_damaged_stl_is_refused(tmp_path):
    file = tmp_path / "open.stl"
    file.write_bytes(stl.stl_bytes(cube()[:-1]))
    with pytest.raises(CadFault, match="not closed"):
        stl.read_stl(file)
    file.write_bytes(stl.stl_bytes(cube())[:200])
    with pytest.raises(CadFault, match="cut short"):
        stl.read_stl(file)
    file.write_bytes(b"")
    with pytest.raises(CadFault, match="no STL"):
        stl.read_stl(file)


def test_columns_through_a_cube_and_through_two():
    x = MM * np.arange(-2.5, 13.0, 1.0)
    found = columns(cube(), x, x)
    inside = (x > 0) & (x < 10 * MM)
    assert np.array_equal(found.thickness > 0, np.outer(inside, inside))
    assert found.top[5, 5] == pytest.approx(10 * MM)
    both = columns(np.concatenate([cube(), cube() + np.array([0, 0, 15 * MM])]), x, x)
    assert both.top[5, 5] - both.bottom[5, 5] == pytest.approx(25 * MM)
    assert both.thickness[5, 5] == pytest.approx(20 * MM)


def test_the_solid_of_a_map_is_closed_and_has_its_volume():
    draw = np.random.default_rng(4)
    solid = draw.random((7, 9)) > 0.3
    top = draw.uniform(1.0, 2.0, (8, 10))
    point, triangle, _ = solid_files.closed(np.arange(10.0), np.arange(8.0), top, np.zeros((8, 10)), solid)
    assert stl.open_edges(1e3 * point[triangle]) == 0
    assert volume(point[triangle]) == pytest.approx(
        sum(
            (t[0] + t[1] + t[2]) / 6 + (t[0] + t[2] + t[3]) / 6
            for j, i in np.argwhere(solid)
            for t in [(top[j, i], top[j, i + 1], top[j + 1, i + 1], top[j + 1, i])]
        )
    )


def test_colours_have_their_ends():
    told = solid_files.colours(np.array([-1.0, -2.0, 0.0, 1.0, np.nan]), 1.0)
    assert told.tolist() == [[33, 102, 172], [33, 102, 172], [247, 247, 247], [178, 24, 43], [150, 150, 150]]


@pytest.fixture(scope="module")
def drilled(tmp_path_factory):
    file = tmp_path_factory.mktemp("step") / "block.step"
    write_step(drilled_block(40 * MM, 30 * MM, 10 * MM, [(20 * MM, 15 * MM, 5 * MM, 0.0)]), file)
    return file


def test_samples_lie_on_the_faces_and_weigh_their_area(drilled):
    found = part_samples(drilled, None, 20_000, 5e-6)
    assert abs(len(found.weight) - 20_000) < 100
    area = 2 * (40 * 30 - math.pi * 25) + 2 * 10 * (40 + 30) + 2 * math.pi * 5 * 10
    assert 1e6 * found.weight.sum() == pytest.approx(area, rel=1e-9)
    bore = np.array([name.endswith("(cylinder)") for name in found.names])[found.face]
    away = np.hypot(found.point[bore, 0] - 20 * MM, found.point[bore, 1] - 15 * MM)
    assert away == pytest.approx(np.full(bore.sum(), 5 * MM), abs=1e-12)
    inward = np.einsum("ij,ij->i", found.normal[bore, :2], found.point[bore, :2] - [20 * MM, 15 * MM])
    assert inward == pytest.approx(np.full(bore.sum(), -5 * MM), abs=1e-12)  # out of the material, into the hole
    up = found.normal[:, 2] > 0.5
    assert found.point[up, 2] == pytest.approx(np.full(up.sum(), 10 * MM), abs=1e-12)


def test_a_part_is_turned_by_roll_pitch_yaw_then_shifted(drilled):
    found = part_samples(drilled, None, 500, 5e-6)
    placed = moved(found, (0.1, 0.2, 0.3), (math.pi / 2, 0.0, math.pi / 2))
    # roll takes (x, y, z) to (x, -z, y), yaw takes that to (z, x, y)
    assert placed.point == pytest.approx(found.point[:, [2, 0, 1]] + [0.1, 0.2, 0.3], abs=1e-12)
    assert placed.normal == pytest.approx(found.normal[:, [2, 0, 1]], abs=1e-12)


def test_triangles_of_a_step_solid_are_closed(drilled):
    triangles = solid_triangles(drilled, None, 1e-5)
    assert stl.open_edges(1e3 * triangles) == 0
    assert volume(triangles) == pytest.approx(1e-9 * 10 * (1200 - math.pi * 25), rel=1e-4)


def test_a_solid_that_is_not_there_is_refused(drilled):
    with pytest.raises(CadFault, match="has no solid 2; it has 1"):
        part_samples(drilled, 2, 100, 5e-6)
