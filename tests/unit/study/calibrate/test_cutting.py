"""Cutting coefficients from mean forces of slots, against an independent reference program; recovery and cover."""

import math

import numpy as np
import pytest

from cutwise.io import library
from cutwise.spec.calibration import MeanForces
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate import cutting
from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.outcome import calibrated

SLOT = ["tool.flutes=2", "operation.axial_depth=3 mm", "cut.arc=[0 deg, 180 deg]"]
ROWS = """feed_per_tooth [mm], force_x [N], force_y [N], force_z [N]
0.025, -47.19, 61.45, -21.61
0.05, -59.76, 89.19, -27.34
0.075, -64.96, 124.58, -35.50
0.1, -76.68, 152.03, -44.36
0.125, -82.78, 177.77, -50.75
"""


@pytest.fixture
def slots(tmp_path):
    file = tmp_path / "slots.csv"
    file.write_text(ROWS)
    return file


def values(found):
    return {v.name: (v.value, v.standard_error) for v in found.finding.values}


def test_linear_law(slots):
    found = calibrated("cutting", slots, SLOT)
    expected = {
        "K_tc": (787.9467e6, 24.7036e6), "K_rc": (234.9333e6, 17.5066e6), "K_ac": (157.7080e6, 6.3088e6),
        "K_te": (16.94366e3, 1.60874e3), "K_re": (20.86227e3, 1.14006e3), "K_ae": (4.44067e3, 0.33302e3),
    }  # fmt: skip
    for name, (value, se) in values(found).items():
        assert value == pytest.approx(expected[name][0], rel=1e-6)
        assert se == pytest.approx(expected[name][1], rel=2e-5)  # five digits printed
    fit = found.finding.fit
    k_tc = found.finding.values[0]
    assert 0.5 * (k_tc.high - k_tc.low) == pytest.approx(58.1366e6, rel=1e-6)
    c = fit.correlation()
    assert [c[k, k + 3] for k in range(3)] == pytest.approx([-0.904534] * 3, abs=1e-6)
    assert fit.scatter[:3] == pytest.approx([2.07603, 2.92949, 0.95255], abs=1e-5)
    assert fit.condition == pytest.approx(4.4665, abs=1e-4)
    assert not found.reasons


def test_kienzle_law(slots):
    found = calibrated("cutting", slots, [*SLOT, "fit.model=kienzle"])
    expected = [472.347e6, 98.8957e6, 77.1566e6, 0.303603, 0.645565, 0.410785]
    assert [v.value for v in found.finding.values] == pytest.approx(expected, rel=1e-5)
    rms = [np.sqrt(np.mean(found.finding.fit.residual[k::3] ** 2)) for k in range(3)]
    assert rms == pytest.approx([1.6920, 2.5972, 1.5069], abs=1e-4)


def test_the_entry_is_a_material(slots, tmp_path):
    file = tmp_path / "my_alloy.yaml"
    for model in ("linear", "kienzle"):
        file.write_text(calibrated("cutting", slots, [*SLOT, f"fit.model={model}"]).entry("my_alloy"))
        entry = library.read_entry(file, str(file), "materials")
        keys = {key: origin.status for key, _, origin in entry.origins()}
        assert set(keys) - {"chip_thickness_min", "chip_thickness_max"} == set(
            cutting.LINEAR if model == "linear" else cutting.KIENZLE
        )
        assert set(keys.values()) == {"measured"}


def settings(arc=(0.0, math.pi)):
    return MeanForces.model_validate({
        "tool": {"flutes": 3}, "operation": {"axial_depth": "2 mm"}, "cut": {"arc": [f"{a} rad" for a in arc]}
    })  # fmt: skip


TRUTH = np.array([800e6, 240e6, 150e6, 16e3, 20e3, 5e3])


@pytest.mark.parametrize("arc", [(0.0, math.pi), (0.0, 1.2), (2.0, math.pi), (0.6, 2.9)])
def test_noise_free_forces_give_the_truth(arc):
    feeds = np.array([0.04, 0.08, 0.12, 0.2]) * 1e-3
    posed = cutting._linear(feeds, np.ones((4, 3)), settings(arc))
    again = cutting._linear(feeds, posed.model(TRUTH).reshape(-1, 3), settings(arc))
    assert fitted(again).x == pytest.approx(TRUTH, rel=1e-8)
    power = cutting._kienzle(feeds, posed.model(TRUTH).reshape(-1, 3), settings(arc), fitted(again))
    truth = np.array([700e6, 200e6, 90e6, 0.25, 0.4, 0.3])
    given = cutting._posed(power.unknowns, power.model(truth).reshape(-1, 3), power.model, power.jacobian, linear=False)
    assert fitted(given).x == pytest.approx(truth, rel=1e-8)


def test_mean_forces_are_those_of_teeth_that_turn():
    """The integrals against a sum over many angles, up to the rule's own error."""
    arc, feeds = (0.4, 2.3), np.array([0.1e-3])
    phi = np.linspace(0.4, 2.3, 20001)
    h = feeds[0] * np.sin(phi)
    t, r, a = (2e-3 * (TRUTH[k] * h + TRUTH[3 + k]) for k in range(3))
    mean = [
        3 / (2 * math.pi) * np.trapezoid(f, phi)
        for f in (-t * np.cos(phi) - r * np.sin(phi), t * np.sin(phi) - r * np.cos(phi), -a)
    ]
    posed = cutting._linear(feeds, np.ones((1, 3)), settings(arc))
    assert posed.model(TRUTH) == pytest.approx(mean, rel=1e-7)


def test_intervals_cover_and_are_not_biased():
    """400 repeats with noise of each axis: 85 to 95 % cover, the mean within 0.15 standard deviations."""
    feeds = np.array([0.025, 0.05, 0.075, 0.1, 0.125]) * 1e-3
    clean = cutting._linear(feeds, np.ones((5, 3)), settings()).model(TRUTH).reshape(-1, 3)
    rng, inside, z = np.random.default_rng(5), [], []
    for _ in range(400):
        fit = fitted(cutting._linear(feeds, clean + rng.normal(size=(5, 3)) * [2.0, 3.0, 1.0], settings()))
        inside.append(np.abs(fit.x - TRUTH) < fit.quantile * fit.standard_errors)
        z.append(fit.x - TRUTH)
    assert np.all(np.abs(np.mean(inside, axis=0) - 0.9) < 0.05)
    assert np.all(np.abs(np.mean(z, axis=0)) < 0.15 * np.std(z, axis=0))


def shuffled(tmp_path, order, signs):
    lines = ROWS.splitlines()
    rows = np.array([[float(c) for c in line.split(",")] for line in lines[1:]])
    forces = rows[:, 1:][:, order] * signs
    file = tmp_path / "channels.csv"
    text = [", ".join(repr(float(v)) for v in (row[0], *force)) for row, force in zip(rows, forces, strict=True)]
    file.write_text("\n".join([lines[0], *text]))
    return file


def test_channels_are_found(tmp_path):
    """A sensor turned by 90 degrees: its x is our y, its y our -x."""
    file = shuffled(tmp_path, [1, 0, 2], [1, -1, 1])
    auto = calibrated("cutting", file, [*SLOT, "data.axes=auto"])
    named = calibrated("cutting", file, [*SLOT, "data.axes=[-y, x, z]"])
    assert any("[-y, x, z]" in text for text in auto.warnings)
    for found in (auto, named):
        assert values(found)["K_tc"][0] == pytest.approx(787.9467e6, rel=1e-6)


def test_a_turned_channel_is_refused_or_told(tmp_path):
    with pytest.raises(ScenarioFault, match="left-handed"):
        calibrated("cutting", shuffled(tmp_path, [0, 1, 2], [-1, 1, 1]), [*SLOT, "data.axes=auto"])
    found = calibrated("cutting", shuffled(tmp_path, [0, 1, 2], [-1, 1, 1]), SLOT)
    assert any("K_rc came out negative" in text for text in found.warnings)
    assert found.reasons
    work = calibrated("cutting", shuffled(tmp_path, [0, 1, 2], [-1, -1, -1]), [*SLOT, "data.forces_on=work"])
    assert values(work)["K_tc"][0] == pytest.approx(787.9467e6, rel=1e-6)


def test_too_few_feeds(tmp_path):
    file = tmp_path / "slots.csv"
    file.write_text("\n".join(ROWS.splitlines()[:3]))
    with pytest.raises(ScenarioFault, match="2 feeds give a line but no error; cut at least 3"):
        calibrated("cutting", file, SLOT)
    lines = ROWS.splitlines()
    file.write_text("\n".join([lines[0], *(["0.05" + line[line.index(",") :] for line in lines[1:]])]))
    with pytest.raises(ScenarioFault, match="all rows have one feed"):
        calibrated("cutting", file, SLOT)
    file.write_text("\n".join([lines[0], *lines[3:]]))
    found = calibrated("cutting", file, SLOT)
    assert any("told apart by little" in text for text in found.reasons)
    assert any("per tooth as well" in text for text in found.advice)


def test_settings_that_cannot_be(slots):
    with pytest.raises(ScenarioFault) as caught:
        calibrated(
            "cutting", slots, ["tool.flutes=0", "cut.arc=[180 deg, 0 deg]", "data.axes=[x, x, z]", "measured.date=May"]
        )
    text = str(caught.value)
    for said in ("tool.flutes", "operation", "enters before it leaves", "each of x, y, z once", "is not a date"):
        assert said in text
