"""How near a tool comes to a part: against brute clouds of surface points, which can only find less."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import KDTree

from cutwise.maths.lines import line, thinned_line
from cutwise.maths.surface_mesh import boxes
from cutwise.paths.chamfer.ball_path import Chamfer, chamfer_path
from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge
from cutwise.paths.pipe_mesh import own_faces, pipe_mesh
from cutwise.paths.reach import BallCutter, rod_wall_clearance
from cutwise.physics.surface.approach import Wanted, cut_places, deepest_cut, moving_ball, moving_rod, rod_distance
from cutwise.physics.surface.sweep import ZONE_SHARE, ZONE_SLACK
from cutwise.physics.surface.zones import Zone, zones

PIPE = PipeHole(0.015, 0.002, 0.004)
LENGTH = 0.06


def path_of(part=PIPE, *, inner=False, ball=0.002, tier=1, points=360):
    frames = pipe_edge(part, one_turn(points), inner=inner)
    nodes = pipe_edge(part, one_turn(512), inner=inner)
    return chamfer_path(frames, Chamfer(0.3e-3, tier=tier), ball, nodes=nodes)


def zone(path, *, inner=False):
    radius = ZONE_SHARE * float(path.leg.max()) + ZONE_SLACK
    owners = np.tile(np.array(own_faces(inner=inner)), (len(path.centre), 1))
    return zones([Zone(path.frames.point, owners, True, radius, radius)]), radius


def cloud(part, spacing, half):
    """Points on all surfaces of a drilled pipe, plainly, up to a distance along it."""
    axis, foot = part.drill_axis, np.array([part.eccentricity, 0.0, 0.0])
    e2 = np.array([0.0, axis[2], -axis[1]])
    found = []
    y = part.radius * np.tan(part.inclination) + np.arange(-half, half, spacing)
    for radius in (part.radius, part.radius - part.wall):
        psi = np.arange(0.0, 2.0 * np.pi, spacing / radius)
        grid = np.stack(np.broadcast_arrays(radius * np.sin(psi)[:, None], y, radius * np.cos(psi)[:, None]), -1)
        p = grid.reshape(-1, 3)
        found.append(p[(np.hypot((p - foot)[:, 0], (p - foot) @ e2) >= part.hole_radius) | (p @ axis < 0.0)])
    theta = np.arange(0.0, 2.0 * np.pi, spacing / part.hole_radius)
    depth = np.arange(0.0, 0.05, spacing)
    wall = foot + part.hole_radius * (np.cos(theta)[:, None] * np.eye(3)[0] + np.sin(theta)[:, None] * e2)
    p = (wall[:, None, :] + depth[None, :, None] * axis).reshape(-1, 3)
    rho = np.hypot(p[:, 0], p[:, 2])
    found.append(p[(rho <= part.radius) & (rho >= part.radius - part.wall)])
    return np.vstack(found)


def dense(path, count=20):
    loop = np.vstack([path.centre, path.centre[:1]])
    share = np.linspace(0.0, 1.0, count, endpoint=False)[:, None]
    return np.concatenate([a + share * (b - a) for a, b in pairwise(loop)])


@pytest.mark.parametrize(
    ("ball", "part"),
    [(0.006, PIPE), (0.0054, PIPE), (0.0055, PIPE._replace(eccentricity=0.003)),
     (0.0052, PIPE._replace(inclination=np.radians(20.0)))],
)  # fmt: skip
def test_deepest_cut_is_that_of_a_dense_cloud_and_a_little_more(ball, part):
    path = path_of(part, ball=ball)
    table, radius = zone(path)
    found = deepest_cut(pipe_mesh(part, 0.02), moving_ball(path.centre, ball, closed=True), table)
    points = cloud(part, 1e-4, 0.014)
    points = points[KDTree(path.centre).query(points)[0] < 1.05 * ball]
    edge = pipe_edge(part, one_turn(6000), inner=False).point
    points = points[KDTree(edge).query(points)[0] > radius]
    brute = ball - KDTree(dense(path)).query(points)[0].min()
    assert brute - 1e-9 <= found.value <= brute + 7e-5
    assert found.value <= found.bound <= found.value + max(2e-7, 0.021 * found.value)
    assert ball - np.linalg.norm(dense(path) - found.place, axis=1).min() == pytest.approx(found.value, abs=1e-7)


def test_a_ball_of_six_millimetres_gouges_the_far_side():
    """The reference finds 0.37 mm on a cloud of about 10 um; the truth is a little deeper."""
    path = path_of(ball=0.006, points=2880)
    found = deepest_cut(pipe_mesh(PIPE, 0.02), moving_ball(path.centre, 0.006, closed=True), zone(path)[0])
    assert 0.370e-3 < found.value < 0.385e-3


@pytest.mark.parametrize(("ball", "cuts"), [(0.005, False), (0.0052, True)])
def test_gouging_starts_between_five_and_five_point_two_millimetres(ball, cuts):
    path = path_of(ball=ball)
    found = deepest_cut(pipe_mesh(PIPE, 0.02), moving_ball(path.centre, ball, closed=True), zone(path)[0])
    assert (found.value > 2e-6) == cuts
    assert found.bound <= 2e-7 or cuts


def test_rod_in_its_hole_is_the_closed_form():
    path = path_of(inner=True, tier=2)
    mesh = pipe_mesh(PIPE, LENGTH)
    found = rod_distance(
        mesh, boxes(mesh), moving_rod(path.centre, PIPE.drill_axis, 0.002, LENGTH, closed=True), Wanted(5e-6)
    )
    exact = rod_wall_clearance(path, PIPE, BallCutter(0.002, 0.0, 0.0))
    assert found.value == pytest.approx(exact, abs=1e-10)
    assert exact - 5.1e-6 <= found.bound <= exact


@pytest.mark.parametrize(
    ("part", "inner", "axis"),
    [(PIPE._replace(eccentricity=0.008), False, None), (PIPE._replace(inclination=np.radians(30.0)), False, None),
     (PIPE._replace(hole_radius=0.008), False, (1.0, 0.0, 0.0)), (PIPE, True, (0.0, 1.0, 0.0))],
)  # fmt: skip
def test_rod_distance_is_that_of_a_dense_cloud(part, inner, axis):
    axis = part.drill_axis if axis is None else np.array(axis)
    path = path_of(part, inner=inner, points=48)
    mesh = pipe_mesh(part, LENGTH)
    found = rod_distance(mesh, boxes(mesh), moving_rod(path.centre, axis, 0.002, LENGTH, closed=True), Wanted(1e-5))
    points = cloud(part, 2.5e-4, 0.03)
    least = np.inf
    for centre in dense(path, 3):
        arm = points - centre
        up, square = arm @ axis, np.einsum("ij,ij->i", arm, arm)
        beside = (up > 0.0) & (up <= LENGTH) & (square >= 0.002**2)
        if beside.any():
            least = min(least, float(np.sqrt(np.maximum(0.0, square - up**2)[beside].min())))
    assert found.bound - 1e-9 <= found.value <= least + 1e-9
    assert found.value > least - 3e-4


def test_nothing_stands_beside_a_rod_above_the_pipe():
    path = path_of(tier=2)
    mesh = pipe_mesh(PIPE, LENGTH)
    found = rod_distance(
        mesh, boxes(mesh), moving_rod(path.centre, PIPE.drill_axis, 0.002, LENGTH, closed=True), Wanted(5e-6)
    )
    assert found.value == np.inf
    assert found.face == -1


def test_places_of_cuts_are_cut_and_outside_of_the_zone():
    path = path_of(ball=0.006)
    table, radius = zone(path)
    place, face = cut_places(pipe_mesh(PIPE, 0.02), moving_ball(path.centre, 0.006, closed=True), table, 2e-6, 2e-4)
    assert len(place) > 50
    assert set(face) <= {0, 2}
    assert (0.006 - KDTree(dense(path)).query(place)[0] > 1.9e-6).all()
    edge = pipe_edge(PIPE, one_turn(6000), inner=False).point
    assert (KDTree(edge).query(place)[0] > radius - 1e-6).all()


def test_thinned_lines_stay_within_their_sag():
    turn = np.linspace(0.0, np.pi, 2001)
    arc = 0.01 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    keep = thinned_line(arc, 1e-6)
    assert 100 < len(keep) < 120  # chords of sqrt(8 s R)
    chords = line([arc[keep]])
    middle = 0.5 * (chords.point[1:] + chords.point[:-1])
    assert (0.01 - np.linalg.norm(middle, axis=1)).max() < 1.2e-6
    straight = np.column_stack([np.linspace(0.0, 1.0, 500), np.zeros(500), np.zeros(500)])
    assert thinned_line(straight, 1e-6).tolist() == [0, 499]
