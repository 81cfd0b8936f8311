import numpy as np
import pytest
from scipy.integrate import solve_bvp

from cutwise.physics.structure import beams

BOX = beams.box_section(0.22, 0.26, 0.015, shear_factor=0.5)
E, G, L = 1.2e11, 4.8e10, 0.5


def test_tip_force_in_x_agrees_with_the_beam_equations():
    """Timoshenko: M' = -Q, EI theta' = M, w' = theta + Q/(k G A), integrated numerically."""
    shear = 1 / (BOX.shear_factor * G * BOX.area)

    def rates(z, y):
        return np.array([y[1] + shear + 0 * z, (L - z) / (E * BOX.second_moment_y)])

    solved = solve_bvp(rates, lambda a, _: a, np.linspace(0, L, 11), np.zeros((2, 11)), tol=1e-10)
    compliance = beams.cantilever(BOX, L, E, G)
    assert compliance[0, 0] == pytest.approx(solved.y[0, -1], rel=1e-8)
    assert compliance[4, 0] == pytest.approx(solved.y[1, -1], rel=1e-8)


def test_two_halves_are_the_whole():
    """The upper half on the lower one: compliances add once they are moved to one point."""
    half = beams.cantilever(BOX, L / 2, E, G)
    carry = np.eye(6)  # displacement of the top by a twist of the middle
    carry[:3, 3:] = [[0, L / 2, 0], [-L / 2, 0, 0], [0, 0, 0]]
    assert half + carry @ half @ carry.T == pytest.approx(beams.cantilever(BOX, L, E, G), rel=1e-12, abs=1e-24)


def test_a_hanging_beam_is_the_standing_one_mirrored():
    standing, hanging = beams.cantilever(BOX, L, E, G), beams.cantilever(BOX, L, E, G, downward=True)
    assert hanging[0, 0] == standing[0, 0]
    assert hanging[0, 4] == -standing[0, 4]
    assert np.linalg.eigvalsh(hanging).min() > 0.0


def test_torsion_of_a_square_block_against_the_series():
    side = 0.1
    odd = np.arange(1, 40, 2)
    series = side**4 * (1 / 3 - 64 / np.pi**5 * np.sum(np.tanh(odd * np.pi / 2) / odd**5))
    assert beams.block_section(side, side).torsion == pytest.approx(series, rel=5e-3)
    assert beams.block_section(0.26, 0.09).torsion == beams.block_section(0.09, 0.26).torsion


def test_thin_round_wall_and_bar():
    bar = beams.round_section(0.01)
    assert bar.torsion == pytest.approx(np.pi * 0.01**4 / 32)
    assert beams.round_section(0.01, filling=0.8).area == pytest.approx(0.8 * bar.area)


@pytest.mark.parametrize("faulty", [
    lambda: beams.box_section(0.1, 0.1, 0.06, shear_factor=0.5),
    lambda: beams.block_section(0.0, 0.1),
    lambda: beams.round_section(-1.0),
    lambda: beams.cantilever(BOX, 0.0, E, G),
])  # fmt: skip
def test_impossible_sizes_are_refused(faulty):
    with pytest.raises(ValueError):
        faulty()
