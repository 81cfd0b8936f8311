import numpy as np
import pytest

from cutwise.physics.structure import pads

FOUR = np.array([[0.1, 0.2, 0.0], [-0.1, 0.2, 0.0], [0.1, -0.2, 0.0], [-0.1, -0.2, 0.0]])
UP = np.array([0.0, 0.0, 1.0])


def group(*, closed: bool = False, exponent: float = 0.5, preload: float = 4e5) -> pads.ContactPads:
    tangential = np.tile([4e7, 4e7, 0.0], (4, 1))
    return pads.ContactPads(FOUR, UP, tangential, 5e-3, 1e-8, exponent, preload, closed)


def test_pitch_stiffness_is_the_sum_of_squared_arms():
    stiffness = pads.stiffness_matrix(FOUR, [1e8, 2e8, 3e8])
    expected = [4e8, 8e8, 12e8, 4 * 3e8 * 0.04, 4 * 3e8 * 0.01, 4 * (1e8 * 0.04 + 2e8 * 0.01)]
    assert stiffness == pytest.approx(np.diag(expected), rel=1e-14, abs=1e-3)
    assert pads.pad_compliance(FOUR, [1e8, 2e8, 3e8]) == pytest.approx(np.diag(1 / np.array(expected)), abs=1e-20)


@pytest.mark.parametrize("points", [FOUR[:1], np.array([[0.1, 0, 0], [-0.1, 0, 0], [0.3, 0, 0]])])
def test_pads_that_leave_a_motion_free_are_refused(points):
    with pytest.raises(ValueError, match="leave a motion free"):
        pads.pad_compliance(points, [1e8, 1e8, 1e8])


def test_positive_definite_does_not_depend_on_units():
    scale = np.diag([1, 1, 1, 1e6, 1e6, 1e6])
    good = scale @ (np.eye(6) + 0.5) @ scale
    bad = good.copy()
    bad[0, 1] = bad[1, 0] = 2.0
    assert pads.is_positive_definite(good)
    assert pads.is_positive_definite(good * 1e-30)
    assert not pads.is_positive_definite(bad)
    assert not pads.is_positive_definite(good + np.triu(np.ones((6, 6)), 1))
    assert not pads.is_positive_definite(np.diag([1, 1, 1, 1, 1, 0.0]))


def test_contact_law_is_the_preloaded_power_law():
    law = group()
    rest = law.coefficient * law.preload**law.exponent
    delta = np.array([0.0, 2e-6])
    force, stiffness, work = pads.contact_force(law, delta)
    pressure = law.preload + force / law.area
    assert law.coefficient * pressure**law.exponent - rest == pytest.approx(delta, abs=1e-18)
    assert stiffness == pytest.approx(law.area / (law.coefficient * law.exponent) * pressure ** (1 - law.exponent))
    steps = np.linspace(0, delta[1], 20_001)
    assert work[1] == pytest.approx(np.trapezoid(pads.contact_force(law, steps)[0], steps), rel=1e-8)


def test_exponent_one_is_a_linear_spring():
    law = group(exponent=1.0, preload=1e7)._replace(coefficient=1e-11)
    stiff = law.area / law.coefficient
    load = np.array([100.0, -50.0, -800.0, 20.0, -30.0, 10.0])
    twist, work = pads.contact_equilibrium(law, load)
    linear = pads.pad_compliance(FOUR, [4e7, 4e7, stiff]) @ load
    assert twist == pytest.approx(linear, rel=1e-10)
    assert 2 * work == pytest.approx(load @ linear, rel=1e-9)


@pytest.mark.parametrize("closed", [False, True])
def test_equilibrium_balances_the_load_and_work_is_the_load_path(closed):
    law = group(closed=closed)
    load = np.array([500.0, -200.0, -4000.0, 60.0, -80.0, 30.0])
    twist, work = pads.contact_equilibrium(law, load)
    b = pads.mobility(FOUR)
    moved = b @ twist
    force = moved * law.tangential
    force[:, 2] -= pads.contact_force(law, -moved[:, 2])[0]
    assert np.einsum("kai,ka->i", b, force) == pytest.approx(load, rel=1e-9)
    parts = np.linspace(0.0, 1.0, 401)
    path = np.array([pads.contact_equilibrium(law, part * load)[0] for part in parts])
    assert np.trapezoid(parts, path @ load) == pytest.approx(work, rel=1e-5)


def test_contact_stiffens_under_pressure():
    law = group()
    down = pads.contact_equilibrium(law, [0, 0, -6000.0, 0, 0, 0])[0][2]
    up = pads.contact_equilibrium(law, [0, 0, 6000.0, 0, 0, 0])[0][2]
    assert up > 1.5 * -down > 0.0


def test_open_guide_that_lifts_is_an_error_and_a_closed_one_holds():
    load = np.array([0.0, 0.0, 0.0, 0.0, 4000.0, 0.0])
    with pytest.raises(pads.PadLostError, match="lift off"):
        pads.contact_equilibrium(group(), load)
    twist = pads.contact_equilibrium(group(closed=True), load)[0]
    assert twist[4] > 0.0
