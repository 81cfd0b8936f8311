"""Modes of a tool tip: the reference example, recovery, cover, and responses that cannot be fitted."""

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.spec.calibration import FrequencyResponse
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate import modal
from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.outcome import calibrated

F = np.arange(400.0, 3001.0, 4.0)
TRUTH = np.array([1243.0, 2.92e6, 0.0619, 1747.0, 1.2e7, 0.0288, 1.5e-8])
FLOOR = ["data.noise_floor=1e-9"]


def response(truth=TRUTH):
    modes = truth[:-1].reshape(-1, 3)
    return sum(1 / k / (1 - (F / f) ** 2 + 2j * z * F / f) for f, k, z in modes) + truth[-1]


def scattered(rng):
    g = response()
    s = np.sqrt(((0.01 * np.abs(g)) ** 2 + 1e-18) / 2.0)
    first = rng.normal(size=len(F))
    return g + s * (first + 1j * rng.normal(size=len(F)))


def written(
    tmp_path, g, titles="frequency [Hz], real [um/N], imaginary [um/N]", parts=lambda g: (1e6 * g.real, 1e6 * g.imag)
):
    file = tmp_path / "frf.csv"
    rows = (", ".join(repr(float(v)) for v in row) for row in zip(F, *parts(g), strict=True))
    file.write_text("\n".join([titles, *rows]))
    return file


def test_the_example(tmp_path):
    found = calibrated("modal", written(tmp_path, scattered(np.random.default_rng(5))), FLOOR)
    values = found.finding.values
    expected = [1243.0675, 2.921451e6, 0.0617888, 1747.0201, 1.201233e7, 0.0287370, 1.49520e-8]
    assert [v.value for v in values] == pytest.approx(expected, rel=1e-6)
    se = [0.0709, 1246, 6.3e-5, 0.0628, 7754, 4.0e-5, 0.95e-10]
    assert [v.standard_error for v in values] == pytest.approx(se, rel=1e-2)
    assert found.finding.fit.scale**2 == pytest.approx(0.9434, abs=5e-4)
    assert not found.reasons


def test_noise_free_modes_come_back_from_parts_and_from_magnitude(tmp_path):
    polar = ("frequency [Hz], magnitude [m/N], phase [deg]", lambda g: (np.abs(g), np.degrees(np.angle(g))))
    for file in (written(tmp_path, response()), written(tmp_path, response(), *polar)):
        found = calibrated("modal", file, FLOOR)
        assert [v.value for v in found.finding.values] == pytest.approx(TRUTH, rel=1e-8)


def test_what_the_unknowns_move_the_response_by():
    settings = FrequencyResponse()
    posed = modal._posed(F[::50], response()[::50], [tuple(TRUTH[:3]), tuple(TRUTH[3:6])], settings)
    for k, value in enumerate(TRUTH):
        step = 1e-6 * value * (np.arange(7) == k)
        difference = (posed.model(TRUTH + step) - posed.model(TRUTH - step)) / (2e-6 * value)
        assert posed.jacobian(TRUTH)[:, k] == pytest.approx(difference, abs=1e-7 * np.abs(difference).max())


def test_intervals_cover():
    """60 responses: 85 to 95 % of the intervals hold the truth."""
    rng, settings, inside = (
        np.random.default_rng(8),
        FrequencyResponse.model_validate({"data": {"noise_floor": 1e-9}}),
        [],
    )
    for _ in range(60):
        fit = fitted(modal._posed(F, scattered(rng), [tuple(TRUTH[:3]), tuple(TRUTH[3:6])], settings))
        inside.append(np.abs(fit.x - TRUTH) < fit.quantile * fit.standard_errors)
    assert 0.85 < np.mean(inside) < 0.95


def test_a_missing_mode_is_not_noise(tmp_path):
    found = calibrated("modal", written(tmp_path, scattered(np.random.default_rng(5))), [*FLOOR, "fit.modes=1"])
    assert any("a mode is missing" in text for text in found.reasons)


@pytest.mark.parametrize("loss", ["linear", "soft_l1"])
def test_a_gross_outlier_is_named(tmp_path, loss):
    g = scattered(np.random.default_rng(5))
    g[300] += 1e-6
    found = calibrated("modal", written(tmp_path, g), [*FLOOR, f"fit.loss={loss}"])
    assert 300 in {outlier.row for outlier in found.finding.outliers}


@pytest.mark.parametrize(
    ("g", "said"),
    [
        (np.full(len(F), 1e-8 - 1e-9j), "no peak"), (response().conj(), "imaginary part is positive"),
        (1e9 * response(), "more than 1 mm/N"),
    ],
)  # fmt: skip
def test_responses_that_cannot_be(tmp_path, g, said):
    with pytest.raises(ScenarioFault, match=said):
        calibrated("modal", written(tmp_path, g))


def test_columns_are_asked_for(tmp_path):
    file = tmp_path / "frf.csv"
    file.write_text("frequency [Hz], real [um/N]\n" + "\n".join(f"{k + 1}, 1" for k in range(9)))
    with pytest.raises(ScenarioFault, match="magnitude \\[um/N\\] and phase"):
        calibrated("modal", file)


def test_an_entry_gives_the_mill_its_modes(tmp_path, examples):
    found = calibrated("modal", written(tmp_path, scattered(np.random.default_rng(5))), [*FLOOR, "data.direction=y"])
    entry = tmp_path / "my_tool.yaml"
    entry.write_text(found.entry("my_tool"))
    scenario = load(examples / "mill_pocket_corner.yaml", {"tool.library": str(entry)})
    first = scenario.tool.modes[0]
    assert (first.direction, first.frequency) == ("y", pytest.approx(1243.0675, rel=1e-6))
    assert scenario.origins["tool.modes[0].frequency"].status == "measured"


def test_an_accelerance_is_the_compliance_over_minus_omega_squared(tmp_path):
    """Acceleration over force, told by its unit: the same modes; one part of each kind is refused."""
    a = response() * -((2 * np.pi * F) ** 2)
    titles = "frequency [Hz], real [mm/s^2/N], imaginary [m/(s^2 N)]"
    found = calibrated("modal", written(tmp_path, a, titles, lambda g: (1e3 * g.real, g.imag)), [])
    assert [value.value for value in found.finding.values] == pytest.approx(list(TRUTH), rel=1e-8)
    titles = "frequency [Hz], magnitude [m/s^2/N], phase [deg]"
    polar = written(tmp_path, a, titles, lambda g: (np.abs(g), np.degrees(np.angle(g))))
    assert [value.value for value in calibrated("modal", polar, []).finding.values] == pytest.approx(
        list(TRUTH), rel=1e-8
    )
    mixed = written(tmp_path, a, "frequency [Hz], real [m/s^2/N], imaginary [um/N]", lambda g: (g.real, 0.1 * g.real))
    with pytest.raises(ScenarioFault, match="one of both"):
        calibrated("modal", mixed, [])


def test_a_coherence_gives_the_scatter(tmp_path):
    """sigma^2 = (1 - gamma^2)/(2 n gamma^2) |G|^2 of each part: chi squared is 1 where the noise is that."""
    rng, g, averages = np.random.default_rng(3), response(), 12
    square = np.clip(1.0 - 0.3 * np.abs(F - 1500.0) / 1500.0, 0.1, 0.99)
    s = np.sqrt((1.0 - square) / (2.0 * averages * square)) * np.abs(g)
    noisy = g + s * (rng.normal(size=len(F)) + 1j * rng.normal(size=len(F)))
    titles = "frequency [Hz], real [um/N], imaginary [um/N], coherence []"
    file = written(tmp_path, noisy, titles, lambda g: (1e6 * g.real, 1e6 * g.imag, square))
    found = calibrated("modal", file, [f"data.averages={averages}"])
    assert found.finding.fit.scale**2 == pytest.approx(1.0, abs=0.1)
    assert any("data.averages" in text for text in calibrated("modal", file, []).warnings)
    bad = written(tmp_path, g, titles, lambda g: (1e6 * g.real, 1e6 * g.imag, 1.2 + 0 * F))
    with pytest.raises(ScenarioFault, match="coherence: must be above 0, and at most 1"):
        calibrated("modal", bad, [f"data.averages={averages}"])


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("fit.hold_out=0.9", ["0.9 is impossible; it must be at most 0.5"]),
        (
            "fit.hold_out=abc",
            ['"abc" is not one of leave_one_out', '"abc" is not a plain number; this one has no unit'],
        ),
    ],
)
def test_a_key_of_several_kinds_is_told_in_words(tmp_path, setting, said):
    """Not in the words of the validator: the key, without the alternative that it tried."""
    with pytest.raises(ScenarioFault) as caught:
        calibrated("modal", written(tmp_path, response()), [setting])
    assert [fault.path for fault in caught.value.faults] == [("fit", "hold_out")] * len(said)
    assert [fault.message for fault in caught.value.faults] == said
