"""A feed drive from its log: made with the drive of cutwise itself, whose parameters are known."""

import numpy as np
import pytest

from cutwise import load
from cutwise.io import library
from cutwise.physics.motion.drives import Controller, Plant, advance, control, response_integrals
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate.outcome import calibrated

PLANT = Plant(
    6.4898, 0.4769, 7.7736e-3, 0.019811, 1.5915e-3, 2.6256, -1.8672, 2.1529, -1.4730, 3.88, -3.51, 4.20, -3.52, 0.0
)
LAW = Controller(70e3, 500e3, 0.3e3, 0.0, 0.0, 1e-3, 10.0, 1e-6, 0.0)
DRIVE = ["drive.r_g=1.5915 mm/rad", "drive.axis=x", "drive.saturation=10 V"]
TITLES = "time [s], command [mm], position [mm], output [V], torque [N m]"


def logged(noise=0.02, delay=0, encoder=1e-6):
    """Rows of a log (4001, 5): two sines, start at rest."""
    t = 1e-3 * np.arange(4001)
    command = 1e-3 * (15.0 * (1.0 - np.cos(np.pi * t)) + 3.0 * (1.0 - np.cos(6.0 * np.pi * t)))
    law = LAW._replace(encoder=encoder)
    step = 1e-4
    phi1, phi2 = response_integrals(PLANT.viscous / PLANT.inertia, step)
    x = w = integral = last = before = 0.0
    gain = PLANT.current_gain * PLANT.torque_constant
    rows = np.empty((len(t), 4))
    for k, r in enumerate(command):
        seen = np.floor(x / encoder + 0.5) * encoder if encoder else x
        u, integral, last, _ = control(r, 0.0, 0.0, x, integral, last, law)
        rows[k] = r, seen, u, gain * u
        applied, before = (before if delay else u), u
        for _ in range(10):
            x, w = advance(x, w, gain * applied, step, phi1, phi2, PLANT)
    rows[:, 3] += noise * np.random.default_rng(3).normal(size=len(t))
    return np.column_stack([t, rows])


@pytest.fixture(scope="module")
def log():
    return logged()


def written(tmp_path, rows, titles=TITLES):
    file = tmp_path / "log.csv"
    scale = [1.0, 1e3, 1e3, 1.0, 1.0][: rows.shape[1]]
    file.write_text("\n".join([titles, *(", ".join(repr(float(v)) for v in row) for row in rows * scale)]))
    return file


def told(found):
    return {v.name: v for v in found.finding.values}


def test_the_log_is_that_of_the_example(log):
    assert np.abs(log[:, 1] - log[:, 2]).max() == pytest.approx(45.361e-6, abs=1e-6)
    assert np.abs(log[:, 3]).max() == pytest.approx(4.00547, abs=0.05)
    assert log[[500, 1000], 2] == pytest.approx([21.021e-3, 29.985e-3], abs=1.1e-6)


def test_the_plant_comes_back(tmp_path, log):
    """Within one standard error of the reference program, which the loop with its encoder step allows no more than."""
    found = calibrated("feed-drive", written(tmp_path, log), DRIVE)
    values = told(found)
    expected = {
        "J": (7.777e-3, 0.0050e-3), "B": (0.0199, 0.00015), "coulomb_plus": (2.150, 0.0064), "coulomb_minus": (-1.471, 0.0064)
    }  # fmt: skip
    for name, (value, se) in expected.items():
        assert values[name].value == pytest.approx(value, abs=se)
        assert values[name].standard_error == pytest.approx(se, rel=0.1)
    assert len(found.finding.fit.residual) == 132
    assert found.finding.fit.correlation()[1, 2] == pytest.approx(-0.868, abs=0.01)
    for name, gain in (("K_p", 70e3), ("K_i", 500e3), ("K_d", 300.0)):
        assert values[name].value == pytest.approx(gain, rel=1e-9)
    assert not found.reasons


def test_without_noise_the_truth_comes_back(tmp_path):
    values = told(calibrated("feed-drive", written(tmp_path, logged(0.0, encoder=0.0)), DRIVE))
    assert values["J"].value == pytest.approx(PLANT.inertia, rel=1e-3)
    assert values["B"].value == pytest.approx(PLANT.viscous, rel=1e-2)
    assert values["coulomb_plus"].value == pytest.approx(PLANT.coulomb_plus, rel=5e-3)


def test_a_late_output_is_seen(tmp_path):
    found = calibrated("feed-drive", written(tmp_path, logged(delay=1)), DRIVE)
    rms = {row[0]: float(row[1].split()[0]) for row in found.finding.compared[1:]}
    assert rms["1"] < rms["0"]
    assert told(found)["J"].value == pytest.approx(PLANT.inertia, rel=5e-3)


def test_current_and_its_constant(tmp_path, log):
    rows = log.copy()
    rows[:, 4] /= 0.4769
    titles = TITLES.replace("torque [N m]", "current [A]")
    found = calibrated("feed-drive", written(tmp_path, rows, titles), [*DRIVE, "drive.K_t=0.4769 N m/A"])
    assert told(found)["J"].value == pytest.approx(7.777e-3, abs=0.005e-3)
    with pytest.raises(ScenarioFault, match="torque per ampere"):
        calibrated("feed-drive", written(tmp_path, rows, titles), DRIVE)


def test_the_entry_is_a_part_of_a_machine(tmp_path, log):
    file = tmp_path / "my_axis.yaml"
    file.write_text(calibrated("feed-drive", written(tmp_path, log), DRIVE).entry("my_axis"))
    keys = {key: origin for key, _, origin in library.read_entry(file, str(file), "machines").origins()}
    assert keys["x.J"].status == "measured"
    assert keys["x.friction.coulomb_plus"].source == "log.csv, 4001 rows"


def test_logs_that_cannot_be_used(tmp_path, log):
    uneven = log.copy()
    uneven[2000:, 0] += 0.1
    saturated = log.copy()
    saturated[:, 3] = 10.0
    slow = log.copy()
    slow[:, 1:3] *= 0.05
    for rows, said in (
        (uneven, "log.csv:2002: time is not uniform"),
        (saturated, "saturated"),
        (slow, "further or faster"),
    ):
        with pytest.raises(ScenarioFault, match=said):
            calibrated("feed-drive", written(tmp_path, rows), DRIVE)
    with pytest.raises(ScenarioFault, match="saturated"):  # its limit need not be known: it stands at its largest
        calibrated("feed-drive", written(tmp_path, saturated), [one for one in DRIVE if "saturation" not in one])
    with pytest.raises(ScenarioFault, match="needs a column torque"):
        calibrated("feed-drive", written(tmp_path, log[:, :4], TITLES.rpartition(",")[0]), DRIVE)


def test_an_entry_completes_that_of_a_machine(tmp_path, log, examples):
    """New values of one axis in the machine of the library, the rest of it as it was; a run has their scatter."""
    whole = library.entry("machines", "fadal2216").file.read_text().replace("value: kp_ki_swapped", "value: as_printed")
    (tmp_path / "machine.yaml").write_text(whole)
    given = [*DRIVE, f"machine.library={tmp_path / 'machine.yaml'}", "drive.axis=x"]
    file = tmp_path / "mine.yaml"
    file.write_text(calibrated("feed-drive", written(tmp_path, log), given).entry("mine"))
    scenario = load(examples / "mill_pocket_corner.yaml", {"machine.library": str(file), "requirements": "{}"})
    assert pytest.approx(7.777e-3, rel=0.01) == scenario.machine.x.J
    assert scenario.machine.x.K_a == 6.4898
    assert scenario.machine.x.friction.coulomb_plus == pytest.approx(2.15, rel=0.02)
    assert scenario.machine.x.friction.stiction_plus == 2.6256
    assert scenario.machine.y.J == 0.0098109
    assert {block.of[0] for block in scenario.covariances.values()} == {"machine.x.J", "machine.x.K_p"}


def test_gains_that_are_read_in_another_way_are_not_mixed_with_fitted_ones(tmp_path, log):
    with pytest.raises(ScenarioFault, match="are read as kp_ki_swapped"):
        calibrated("feed-drive", written(tmp_path, log), [*DRIVE, "machine.library=fadal2216"])
