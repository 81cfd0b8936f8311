"""Laws of a turned shaft: no compliance, energy, mirror, scaling, stations."""

import numpy as np
import pytest

from cutwise.process.recipes import quick_outcome
from cutwise.process.turning import run, setup
from peers.turned import scenario, turned


@pytest.mark.parametrize("material", [None, {"k_c11": "1500 N/mm^2", "m_c": 0.22, "k_r11": "375 N/mm^2", "m_r": 0.22}])
def test_a_shaft_that_does_not_yield_comes_out_to_size(material):
    stiff = {"part__youngs_modulus": "1e12 kN/mm^2"} | ({"material": material} if material else {})
    (done,) = turned(**stiff)
    assert np.abs(done.error).max() < 1e-12
    (bent,) = turned(**({"material": material} if material else {}))
    assert bent.rest.total[-1, :3] == pytest.approx(done.rest.total[-1, :3])  # at the chuck nothing bends
    assert bent.rest.total[0, 1] < done.rest.total[0, 1]  # a bar that gives way is cut less deep


def test_stations_are_exact():
    """Convergence: a station does not feel how near its neighbours are."""
    coarse, fine = (turned(numerics__station=step, operation__passes=2)[-1] for step in ("30 mm", "7.5 mm"))
    there = np.isin(np.round(fine.z, 9), np.round(coarse.z, 9))
    assert fine.error[there] == pytest.approx(coarse.error, rel=1e-6, abs=1e-13)


def test_energy_and_shares():
    case = scenario(
        lathe__headstock_stiffness="100 N/um", lathe__headstock_angular_stiffness="1e6 N m/rad", lathe__tailstock="centre",
        lathe__tailstock_stiffness="30 N/um", lathe__steady_position="120 mm", lathe__steady_stiffness="20 N/um",
        tool__stiffness="40 N/um", part__poisson_ratio=0.3,
    )  # fmt: skip
    found = quick_outcome(case).measures
    assert found["energy_balance"] < 1e-12
    (done,) = run(setup(case))
    worst = int(np.argmax(np.abs(done.error)))
    total = done.rest.state.reshape(len(done.z), 2, 6).sum(axis=1)[worst, 1]
    shares = sum(found[f"share_{name}"] for name in ("work", "headstock", "tailstock", "steady", "tool"))
    assert shares == pytest.approx(total, rel=1e-12)


def test_between_equal_centres_the_way_of_the_feed_is_mirrored():
    held = {"lathe__headstock": "centre", "lathe__tailstock": "centre"}
    (one,), (other,) = turned(**held), turned(**held, operation__towards="tailstock")
    assert one.error == pytest.approx(other.error, rel=1e-9, abs=1e-15)
    assert one.z == pytest.approx(0.3 - other.z)


def test_stiffness_and_forces_scale_together():
    (one,) = turned()
    (other,) = turned(
        part__youngs_modulus="420 kN/mm^2",
        material={"K_tc": "4000 N/mm^2", "K_rc": "1800 N/mm^2", "K_te": "60 N/mm", "K_re": "50 N/mm"},
    )
    assert other.error == pytest.approx(one.error, rel=1e-9)
    assert other.rest.total == pytest.approx(2.0 * one.rest.total, rel=1e-9)


def test_a_rigid_support_changes_no_bit():
    """Lathe without compliance: the parts of its supports are not there, and the shaft stands as on infinite springs."""
    (one,) = turned(lathe__tailstock="centre")
    (other,) = turned(lathe__tailstock="centre", lathe__tailstock_stiffness="1e12 N/um")
    assert "tailstock" not in one.parts
    assert other.error == pytest.approx(one.error, rel=1e-6, abs=1e-12)


def test_lengths_scale_with_the_forces_they_make():
    """All lengths twice as large, the edge forces per length too: forces four times, errors twice (no edge knows its size)."""
    (one,) = turned()
    (other,) = turned(
        part__stock_diameter="44 mm", part__sections=[{"length": "600 mm", "diameter": "40 mm"}],
        tool={"nose_radius": "0.8 mm", "lead_angle": "45 deg", "trail_angle": "30 deg"}, operation__feed="0.4 mm/rev",
        material__K_te="60 N/mm", material__K_re="50 N/mm", numerics__station="40 mm",
    )  # fmt: skip
    assert other.rest.total[:, :3] == pytest.approx(4.0 * one.rest.total[:, :3], rel=1e-9)
    assert other.error == pytest.approx(2.0 * one.error, rel=1e-9, abs=1e-15)
