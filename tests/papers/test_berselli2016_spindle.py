"""Berselli et al. 2016, sec. 3.3 and 4: the reference case R0, its sweeps, the static curve, and misprints there.

The paper gives no geometry and no numbers; the values come from an independent reference program with the same
assumed geometry (docs/theory/deburring.md).
"""

import numpy as np
import pytest

from cutwise.physics.structure.seals import NO_FRICTION, PRESLIDING, REGULARISED
from cutwise.physics.structure.statics import characteristic
from cutwise.process.loops import run_compliant_edge
from cutwise.process.plateaus import band
from peers.cells import MM, end_error, error_at_tool, r0, ring


def close(reference):
    """3 % or 2 µm, in mm."""
    return pytest.approx(reference, rel=0.03, abs=0.002)


@pytest.fixture(scope="module")
def history():
    return run_compliant_edge(r0(), 5e-6)


def test_r0_error(history):
    assert error_at_tool(r0(), history)[-1] / MM == pytest.approx(-0.009452, abs=2e-5)


def test_r0_forces(history):
    steady = history.motion.time >= 0.45
    assert history.burr_force.mean[steady].mean(0) == pytest.approx([5.7024, 9.3843, 3.8197], rel=1e-3)
    assert np.sqrt(history.burr_force.square[steady].mean(0)) == pytest.approx([5.7024, 9.3843, 3.8197], rel=1e-3)
    assert history.burr_force.peak.max(0) == pytest.approx([9.893, 10.355, 4.792], rel=2e-3)
    assert history.work_force.mean[steady].mean(0) == pytest.approx([0.877, 0.582, 0.361], abs=2e-3)


def test_r0_deflection_and_settling(history):
    error = error_at_tool(r0(), history)
    assert history.response.tilt[-1] * 149.5 == pytest.approx([1.5874, 1.9905], rel=1e-3)  # mm at point A
    moving = np.flatnonzero(np.abs(error - error[-1]) > 5e-6)
    assert history.motion.time[moving[-1]] == pytest.approx(0.1923, abs=5e-4)


def test_r0_frictionless_differs():
    assert end_error(law=NO_FRICTION) == pytest.approx(0.1774, abs=2e-4)


@pytest.mark.parametrize(
    ("pressure", "expected"),
    [(2, (6.35, 5.59, 3.66, 1.73, 0.97)), (3, (8.83, 7.89, 5.49, 3.09, 2.15)), (4, (11.31, 10.18, 7.32, 4.46, 3.33)),
     (5, (13.78, 12.48, 9.15, 5.82, 4.52)), (6, (16.26, 14.77, 10.98, 7.19, 5.70))],
)  # fmt: skip
def test_static_curve(pressure, expected):
    curve = characteristic(ring(pressure), 0.150)
    found = (*curve.loading, curve.frictionless, curve.unloading.plateau, curve.unloading.breakaway)
    assert found == pytest.approx(expected, rel=0.01)
    assert curve.stop == pytest.approx(9.4e-3, rel=0.01)


def test_band_between_the_plateaus():
    loaded, unloaded, frictionless = band(r0(), 1 * MM, 1 * MM)
    assert loaded.error / MM == close(-0.0138)
    assert unloaded.error / MM == close(0.486)
    assert frictionless.error / MM == pytest.approx(end_error(law=NO_FRICTION), abs=1e-4)


SWEEPS = {
    "pressure": {2: 0.544, 3: 0.357, 4: 0.170, 5: -0.009, 6: -0.030},
    "feed": {20 * MM: -0.199, 40 * MM: -0.098, 60 * MM: -0.043, 80 * MM: -0.009, 120 * MM: 0.291, 160 * MM: 0.460},
    "preset": {0.01 * MM: -0.01, 0.05 * MM: -0.012, 1 * MM: -0.011, 2 * MM: -0.0095, 3 * MM: 0.004, 5 * MM: 0.048,
               -1.2 * MM: 1.0},
    "burr": {0.0: -0.112, 0.25 * MM: -0.086, 0.5 * MM: -0.060, 0.75 * MM: -0.035, 1 * MM: -0.009, 1.25 * MM: 0.236,
             1.5 * MM: 0.492, 2 * MM: 1.004},
    "edge": {0.0: -0.009, 500.0: 0.104, 1000.0: 0.213, 2000.0: 0.390, 3000.0: 0.524, 5000.0: 0.700},
}  # fmt: skip


@pytest.mark.parametrize(
    ("key", "value", "expected"), [(key, value, e) for key, row in SWEEPS.items() for value, e in row.items()]
)
def test_sweep(key, value, expected):
    assert end_error(**{key: value}) == close(expected)


@pytest.mark.parametrize(("pressure", "expected"), [(4, 0.345), (5, 0.177), (6, 0.006), (7, -0.017)])
def test_sweep_frictionless(pressure, expected):
    assert end_error(pressure=pressure, law=NO_FRICTION) == close(expected)


@pytest.mark.parametrize(("lead_in", "expected"), [(0.2, -0.0095), (0.4, -0.0127), (0.8, -0.0135)])
def test_lead_in(lead_in, expected):
    assert end_error(lead_in=lead_in, duration=lead_in + 0.4) == close(expected)


@pytest.mark.parametrize(("lead_in", "expected"), [(0.05, 0.379), (0.1, 0.146)])
def test_short_lead_in_latches(lead_in, expected):
    assert end_error(lead_in=lead_in, duration=lead_in + 0.4) == pytest.approx(expected, rel=0.05)


def test_up_milling_drags_the_tool_to_the_stop():
    cell = r0(up=True)
    history = run_compliant_edge(cell, 50e-6)
    assert history.response.tilt[-1, 0] * 149.5 == pytest.approx(-10.0, rel=0.03)  # mm
    assert history.response.travel.max() == pytest.approx(cell.ring.piston.stroke)


def test_hn_as_printed_contradicts_the_error_definition():
    """Misprint: h_r = h_n - h_b; with p_r = h_r - h_pci and e = h_pci - h_n, only h_r = h_n + h_b makes p_r = h_b ideal."""
    nominal, burr = 5 * MM, 1 * MM
    lowest = nominal  # ideal: the mill just reaches the nominal edge, e = 0
    assert (nominal + burr) - lowest == pytest.approx(burr)
    assert (nominal - burr) - lowest == pytest.approx(-burr)  # as printed: no contact at all


@pytest.mark.parametrize(
    ("frequency", "peak_to_peak"), [(0.5, 0.400), (2, 0.400), (5, 0.400), (10, 0.330), (20, 0.142)]
)
def test_path_error_with_friction(frequency, peak_to_peak):
    """Friction takes the compliance away on the retreat side: 0.2 mm up to 5 Hz comes through whole."""
    found, mean = _wave(frequency)
    assert found == pytest.approx(peak_to_peak, rel=0.03, abs=0.002)
    if frequency <= 5:
        assert mean == pytest.approx(0.5 * (-0.014 + 0.386), abs=0.005)  # from -0.014 to +0.386, rigid -0.206 to +0.194
    if frequency == 20:
        assert mean == close(0.199)


@pytest.mark.parametrize(("frequency", "peak_to_peak"), [(0.5, 0.011), (2, 0.041), (10, 0.126)])
def test_path_error_without_friction(frequency, peak_to_peak):
    assert _wave(frequency, law=NO_FRICTION)[0] == pytest.approx(peak_to_peak, rel=0.03, abs=0.002)


def _wave(frequency, **changes):
    cell = r0(amplitude=0.2 * MM, frequency=frequency, duration=0.2 + 4.0 / frequency, **changes)
    history = run_compliant_edge(cell, 50e-6)
    error = error_at_tool(cell, history)[history.motion.time >= 0.2 + 2.0 / frequency] / MM
    return np.ptp(error), error.mean()


@pytest.mark.parametrize(
    ("travel", "expected"), [(5e-6, -0.0102), (10e-6, -0.0107), (50e-6, -0.0124), (100e-6, -0.0129)]
)
def test_presliding_rows(travel, expected):
    assert end_error(law=PRESLIDING, travel=travel) == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize(("speed", "expected"), [(0.1e-3, -0.011), (1e-3, -0.014), (10e-3, -0.023)])
def test_presliding_with_stribeck(speed, expected):
    """The middle row moves with the step (weakening friction sticks and slips): it is the value of 20 µs steps."""
    assert end_error(time_step=20e-6, law=PRESLIDING, travel=10e-6, stribeck=speed) == close(expected)


@pytest.mark.parametrize(("speed", "expected"), [(10e-3, 0.177), (1e-3, 0.133), (0.1e-3, 0.017)])
def test_regularised_friction_creeps(speed, expected):
    assert end_error(time_step=20e-6, law=REGULARISED, stribeck=speed) == pytest.approx(expected, rel=0.03, abs=0.002)


def test_regularised_friction_is_still_moving_at_the_end():
    cell = r0(law=REGULARISED, stribeck=1e-3)
    error = error_at_tool(cell, run_compliant_edge(cell, 50e-6)) / MM
    assert error[-1] - error[-2000] > 0.005  # in the last 0.1 s


@pytest.mark.parametrize(("travel", "expected"), [(5e-6, 0.389), (10e-6, 0.379), (50e-6, 0.305), (100e-6, 0.222)])
def test_presliding_takes_up_a_path_error(travel, expected):
    assert _wave(2, law=PRESLIDING, travel=travel)[0] == pytest.approx(expected, rel=0.03, abs=0.002)
