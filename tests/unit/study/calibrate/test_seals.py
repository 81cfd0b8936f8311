"""Piston force and friction of a compliant spindle, against an independent reference program."""

import math

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.notices import notices
from cutwise.study.calibrate.outcome import calibrated

TITLES = "pressure [bar], loading_plateau [N], unloading_plateau [N], breakaway [N], return_breakaway [N]"
SPINDLE = [
    "spindle.piston_arm=80 mm",
    "spindle.tool_reach=150 mm",
    "spindle.pistons=7",
    "spindle.reference_pressure=5 bar",
]


def travel(tmp_path, noise, pressures=(2, 3, 4, 5, 6), digits=2, order=slice(None)):
    p = np.repeat(np.array(pressures, dtype=float), 3)
    g, kappa = 80 / 150 * 7 / math.pi, 0.3 + 0.7 * p / 5.0
    clean = g * np.column_stack([1.54 * p + s * f * kappa for s, f in ((1, 2.8), (-1, 2.8), (1, 3.9), (-1, 3.9))])
    forces = clean + noise * np.random.default_rng(2).normal(size=clean.shape)
    file = tmp_path / "travel.csv"
    rows = [
        ", ".join([f"{a:g}", *(f"{v:.{digits}f}" for v in row)]) for a, row in zip(p, forces[:, order], strict=True)
    ]
    file.write_text("\n".join([TITLES, *rows]))
    return file


def test_the_example(tmp_path):
    found = calibrated("spindle-seals", travel(tmp_path, 0.15), SPINDLE)
    told = {v.name: (v.value, v.standard_error) for v in found.finding.values}
    assert told["A"] == pytest.approx((1.542817e-5, 0.003762e-5), rel=1e-4)
    assert told["F_s"] == pytest.approx((3.921080, 0.026947), rel=2e-5)
    assert told["F_d"] == pytest.approx((2.763091, 0.026220), rel=2e-5)
    assert told["alpha"] == pytest.approx((0.324652, 0.014737), rel=4e-5)
    fit = found.finding.fit
    assert (fit.scale, fit.degrees_of_freedom) == (pytest.approx(0.146921, abs=1e-6), 56)
    assert not found.reasons


def test_noise_free_travel_gives_the_truth(tmp_path):
    found = calibrated("spindle-seals", travel(tmp_path, 0.0, digits=12), SPINDLE)
    assert [v.value for v in found.finding.values] == pytest.approx([1.54e-5, 3.9, 2.8, 0.3], rel=1e-8)


def test_one_pressure_does_not_tell_the_share(tmp_path):
    found = calibrated("spindle-seals", travel(tmp_path, 0.1, pressures=(5,)), SPINDLE)
    verdicts = {v.name: v.verdict for v in found.finding.values}
    assert verdicts["alpha"] == "not identified"
    assert verdicts["A"] == "identified"
    assert any("second pressure" in text for text in found.advice)
    assert found.reasons


def test_an_entry_completes_that_of_the_library_and_runs(tmp_path, examples):
    found = calibrated("spindle-seals", travel(tmp_path, 0.15), ["spindle.library=berselli2016"])
    entry = tmp_path / "my_spindle.yaml"
    entry.write_text(found.entry("my_spindle"))
    scenario = load(examples / "deburr_compliant_spindle.yaml", {"spindle.library": str(entry)})
    assert scenario.spindle.piston_force == pytest.approx(1.542817e-5 * 5e5, rel=1e-4)
    assert scenario.spindle.friction_static == pytest.approx(3.92108, rel=1e-5)
    assert scenario.origins["spindle.friction_static"].status == "measured"
    assert scenario.origins["spindle.inertia"].status == "assumed"


def test_exchanged_columns_are_refused(tmp_path):
    with pytest.raises(ScenarioFault, match="exchanged"):
        calibrated("spindle-seals", travel(tmp_path, 0.1, order=[1, 0, 2, 3]), SPINDLE)


def test_a_model_is_refused_where_there_is_one(tmp_path):
    with pytest.raises(ScenarioFault, match=r'fit.model.*"joints" is not a model of spindle-seals; it has one'):
        calibrated("spindle-seals", travel(tmp_path, 0.1), [*SPINDLE, "fit.model=joints"])


def test_a_pressure_that_was_not_travelled_at_is_told(tmp_path, examples):
    found = calibrated("spindle-seals", travel(tmp_path, 0.15), ["spindle.library=berselli2016"])
    entry = tmp_path / "my_spindle.yaml"
    entry.write_text(found.entry("my_spindle"))
    given = {"spindle.library": str(entry)}
    inside = load(examples / "deburr_compliant_spindle.yaml", {**given, "spindle.pressure": "5 bar"})
    assert not any("was measured at" in text for text in notices(inside))
    beyond = load(examples / "deburr_compliant_spindle.yaml", {**given, "spindle.pressure": "6.5 bar"})
    (text,) = (text for text in notices(beyond) if "was measured at" in text)
    assert text.startswith("spindle.pressure: 6.5 bar is outside of what")
    assert "2 bar to 6 bar" in text


def raw(tmp_path, sides=(1.0, -1.0), noise=0.0, sign=1.0, samples=120):
    """Loops of force over travel: breakaway at the start of each way, then the plateau."""
    g = 80 / 150 * 7 / math.pi
    rng, rows = np.random.default_rng(4), []
    for p in (2.0, 4.0, 6.0):
        kappa = 0.3 + 0.7 * p / 5.0
        for side in (*sides, *sides):
            out = np.linspace(0.0, 2.0, samples)
            peak = np.exp(-((out - 0.08) ** 2) / 2e-3)
            loading = g * (1.54 * p + (2.8 + 1.1 * peak) * kappa)
            unloading = g * (1.54 * p - (2.8 + 1.1 * peak) * kappa)
            for travel, force in ((out, loading), (out[::-1], unloading)):
                scatter = noise * rng.normal(size=samples)
                wave = 0.002 * rng.normal(size=samples)
                rows += [
                    (p, side * (t + w), sign * side * (f + e))
                    for t, f, w, e in zip(travel, force, wave, scatter, strict=True)
                ]
    file = tmp_path / "loops.csv"
    file.write_text(
        "\n".join(["pressure [bar], travel [mm], force [N]", *(f"{a}, {b:.5f}, {c:.4f}" for a, b, c in rows)])
    )
    return file


def test_raw_loops_on_both_sides(tmp_path):
    found = calibrated("spindle-seals", raw(tmp_path), SPINDLE)
    values = {v.name: v.value for v in found.finding.values}
    assert values["A"] == pytest.approx(1.54e-5, rel=1e-3)
    assert values["F_d"] == pytest.approx(2.8, rel=1e-3)
    assert values["F_s"] == pytest.approx(3.9, rel=5e-3)
    assert values["alpha"] == pytest.approx(0.3, abs=5e-3)
    assert found.finding.fit.degrees_of_freedom == 4 * 12 - 4
    assert any("is assumed" in text for text in found.finding.cannot_tell)
    assert not found.reasons
    noisy = calibrated("spindle-seals", raw(tmp_path, sides=(1.0,), noise=0.1), SPINDLE)
    assert {v.name: v.value for v in noisy.finding.values}["F_d"] == pytest.approx(2.8, rel=0.02)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("pressure [bar], travel [mm]\n2, 0\n2, 1\n", "lacks travel \\[mm\\] and force"),
        ("pressure [bar], loading_plateau [N]\n2, 0\n2, 1\n", "lacks unloading_plateau"),
        ("pressure [bar], travel [mm], force [N]\n2, 0, 1\n2, 1, 2\n2, 2, 3\n", "no whole loop"),
        ("pressure [bar], travel [mm], force [N], breakaway [N]\n2, 0, 1, 1\n2, 1, 1, 2\n", "one kind in a file"),
        ("pressure [bar], travel [mm], force [N]\n2, 0, 1\n0, 1, 1\n", "must be above zero"),
    ],
)
def test_raw_files_that_hold_too_little(tmp_path, text, said):
    file = tmp_path / "loops.csv"
    file.write_text(text)
    with pytest.raises(ScenarioFault, match=said):
        calibrated("spindle-seals", file, SPINDLE)


def test_a_turned_force_is_refused(tmp_path):
    with pytest.raises(ScenarioFault, match="a sign is turned"):
        calibrated("spindle-seals", raw(tmp_path, sign=-1.0), SPINDLE)
