"""Ball-end forces by discs: the numbers of a 90 degree edge, the power balance, the cylinder limit, and burrs."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from cutwise.physics.cutting.ball import disc_coefficients, disc_force
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.uneven import Kienzle, even_edges, kienzle_edges
from cutwise.physics.engagement.ball import burr_sides, pass_frames, wedge_sides
from cutwise.process.chamfer_loop import BallEnd, ball_cut

K = EdgeCoefficients(2000e6, 1200e6, 800e6, 0.0, 0.0, 0.0)
BALL = BallEnd(0.002, 20, 40000 * 2 * math.pi / 60, even_edges(K))
FEED = 0.08


def stand_off(width):
    return math.sqrt(0.002**2 - 0.25 * width**2) - 0.5 * width


def place(width=0.3e-3, side=-1.0):
    """Edge from the ball centre, the ball on the bisector of the hole wall (+y) and a face below (-1) or above (+1)."""
    y = -stand_off(width) / math.sqrt(2)
    return np.array([[0.0, y, side * y]])


def edge(side, width=0.3e-3):
    """The wedge of a 90 degree edge."""
    return wedge_sides(place(width, side), np.array([[[0.0, 0.0, side], [0.0, 1.0, 0.0]]]))[0]


def on_wall(height, width, side=-1.0):
    """A burr on the wall, whose material lies above an inner edge (-1) and below an outer one (+1)."""
    along, off = np.array([[0.0, 0.0, -side]]), np.array([[0.0, 1.0, 0.0]])
    return burr_sides(place(side=side), along, off, np.array([height]), np.array([width]))[0]


def level(material, ball=BALL, slices=48):
    return ball_cut(material, ball, FEED, 0.0, 0.0, slices)


@pytest.mark.parametrize(
    ("side", "force"), [(-1.0, (0.468, 0.602, -0.078)), (1.0, (0.566, 0.273, 0.440))]
)  # fmt: skip
def test_forces_of_a_square_edge(side, force):
    """The reference's own slices err by 0.4 % in power; ours by less than 1e-5, so they agree within that."""
    cut = level(edge(side), slices=400)
    assert (cut.force.x, cut.force.y, cut.force.z) == pytest.approx(force, rel=0.01)
    assert cut.area == pytest.approx(0.02363e-6, rel=5e-4)
    assert cut.power == pytest.approx(K.K_tc * cut.area * FEED, rel=1e-12)


def segment(side=0.3e-3, radius=0.002):
    """Section of a square edge that the ball takes off [m^2]: the triangle less the bulge of the ball."""
    half = math.asin(0.5 * side / radius)
    return 0.25 * side**2 + radius**2 * (half - math.sin(half) * math.cos(half))


def turned(vectors, angle):
    """Vectors of a level pass as a rod sees them that leans forward: about y, the pass plunges."""
    c, s = math.cos(angle), math.sin(angle)
    return vectors @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


@pytest.mark.parametrize("plunge", [-80.0, -45.0, 0.0, 15.0, 30.0, 60.0, 85.0, 90.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_section_and_power_do_not_depend_on_how_the_rod_leans(plunge, side):
    """The same edge run at the same speed: what is taken off across the edge is the same, and so is the power."""
    angle = math.radians(plunge)
    normal = turned(np.array([[0.0, 0.0, side], [0.0, 1.0, 0.0]]), angle)
    material = wedge_sides(turned(place(side=side), angle), normal[None])[0]
    v = FEED * turned(np.array([1.0, 0.0, 0.0]), angle)
    cut = ball_cut(material, BALL, *v, 400)
    assert cut.area == pytest.approx(segment(), rel=2e-4)
    assert cut.power == pytest.approx(K.K_tc * segment() * FEED, rel=2e-4)


def test_forces_converge_with_the_second_order_of_the_discs():
    """48 discs, as used: power within 1.1e-5 of K_tc A v, which holds for any edge."""
    exact = K.K_tc * segment() * FEED
    error = [abs(level(edge(-1.0), slices=n).power / exact - 1.0) for n in (12, 24, 48)]
    assert [math.log2(a / b) for a, b in pairwise(error)] == pytest.approx([2.0, 2.0], abs=0.05)
    assert error[-1] < 1.1e-5


@pytest.mark.parametrize(("force", "width"), [(1.73, 0.45), (5.59, 0.80), (5.82, 0.81), (12.48, 1.18)])
def test_lateral_force_meets_the_plateaus_at_the_widths_of_the_reference(force, width):
    """Plateaus of the spindle at 2 bar (1.73 to 5.59 N) and 5 bar (5.82 to 12.48 N) over the width of the chamfer."""

    def lateral(w):
        f = level(edge(-1.0, w), slices=200).force
        return math.hypot(f.x, f.y)

    assert 1e3 * brentq(lambda w: lateral(w) - force, 0.1e-3, 1.5e-3) == pytest.approx(width, abs=0.01)
    assert lateral(0.3e-3) == pytest.approx(0.76, abs=0.005)


def test_a_disc_at_the_equator_is_a_cylinder():
    assert disc_coefficients(math.pi / 2, K) == pytest.approx(K, rel=1e-12)


def test_a_burr_is_cut_with_the_power_of_its_section():
    """A strip 0.2 mm high and 0.1 mm wide on the wall, all of it inside the ball, adds K_tc v times its 0.02 mm^2."""
    cut = level(on_wall(0.2e-3, 0.1e-3), slices=400)
    assert cut.area == pytest.approx(0.02e-6, rel=1e-9)
    assert cut.power == pytest.approx(K.K_tc * cut.area * FEED, rel=1e-12)


def test_burrs_that_stand_nowhere_take_no_force():
    for height in (0.0, -1e-6):
        none = level(on_wall(height, 0.1e-3))
        assert abs(none.power) + abs(none.area) < 1e-12
    small = level(on_wall(1e-9, 0.1e-3)).force
    assert abs(small.x) + abs(small.y) < 1e-5


@pytest.mark.parametrize("lean", [0.0, 30.0, 77.0])
def test_burr_on_a_leaning_face_is_its_rectangle(lean):
    c, s = math.cos(math.radians(lean)), math.sin(math.radians(lean))
    one = np.array([0.2e-3]), np.array([0.4e-3])
    strip = burr_sides(np.array([[0.0, -1e-3, 0.5e-3]]), np.array([[0.0, s, c]]), np.array([[0.0, c, -s]]), *one)[0]
    assert level(strip, slices=4000).area == pytest.approx(0.08e-6, rel=1e-6)


def test_feed_directions_where_the_edge_plunges_are_those_of_their_neighbours():
    tangent = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    found = pass_frames(tangent, np.array([0.0, 0.0, 1.0]))
    assert found.plunge.tolist() == [0.0, 1.0, 0.0]
    assert found.feed[1].tolist() in ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(np.linalg.norm(found.off, axis=1), 1.0)


KIENZLE = Kienzle(700e6, 0.25, 175e6, 0.25, 90e6, 0.3)


def brute(lo, hi, chi, chip, thick, theta, length, k=KIENZLE, panels=5000):
    """The integral of the force over an arc as the equations read, by the midpoint rule."""
    phi = lo + (np.arange(panels) + 0.5) * (hi - lo) / panels
    h = chip * np.sin(phi - theta) + thick
    law = lambda k11, m: np.where(h > 0.0, k11 * (np.maximum(h, 1e-7) * 1e3) ** -m * h, 0.0)  # noqa: E731
    ft, fn, fm = law(k.k_c11, k.m_c), law(k.k_r11, k.m_r), law(k.k_a11, k.m_a)
    fr, fa = fn * math.sin(chi) + fm * math.cos(chi), fm * math.sin(chi) - fn * math.cos(chi)
    x, y = -ft * np.cos(phi) - fr * np.sin(phi), ft * np.sin(phi) - fr * np.cos(phi)
    return [length * float(part.mean()) for part in (x, y, fa, ft)]


@pytest.mark.parametrize(("lo", "rise"), [(0.4, 1e-7), (0.0, 0.0), (0.2, 4e-6)])
def test_disc_by_kienzle_is_its_integral(lo, rise):
    z, height, radius, flutes = -0.0008, 1e-5, 0.002, 3
    found = disc_force(lo, 1.7, z, height, radius, 20e-6, 0.0, rise, flutes, kienzle_edges(KIENZLE))
    chi = math.acos(z / radius)
    s = math.sin(chi)
    length = flutes * height / s * (1.7 - lo) / (2.0 * math.pi)
    expected = brute(lo, 1.7, chi, 20e-6 * s, rise * math.cos(chi), 0.0, length)
    assert list(found) == pytest.approx(expected, rel=3e-4)


def test_kienzle_without_exponent_is_the_linear_law_without_edge_force():
    flat = kienzle_edges(Kienzle(K.K_tc, 0.0, K.K_rc, 0.0, K.K_ac, 0.0))
    for side in (-1.0, 1.0):
        linear, power_law = level(edge(side)), level(edge(side), BALL._replace(edges=flat))
        assert power_law.force == pytest.approx(linear.force, rel=1e-6)
        assert power_law.power == pytest.approx(linear.power, rel=1e-6)
