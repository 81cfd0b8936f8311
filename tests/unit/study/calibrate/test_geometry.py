"""Geometric errors of an arm: 2,773 poses of a UR10, held against an independent reference program."""

from pathlib import Path

import numpy as np
import pytest

from cutwise.io.measurements import read_measurement
from cutwise.maths.chains import jacobian
from cutwise.physics.motion.arm_errors import Errors, Load, corrected_angles, moments, none, poses
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate import geometry
from cutwise.study.calibrate.arm import joint_angles
from cutwise.study.calibrate.outcome import calibrated

UR10 = Path(__file__).parents[4] / "examples" / "measured" / "ur10"
ARM = f"robot.library={UR10 / 'arm.yaml'}"


@pytest.fixture(scope="module")
def found():
    return calibrated("robot-geometry", UR10 / "random_poses.csv", [ARM, "fit.hold_out=0.5"])


@pytest.fixture(scope="module")
def arm(found):
    return geometry._arm(found.settings, "rigid+joints")


def test_held_out_poses_of_the_ur10(found):
    """Mean, rms, 95 % and largest error; nominal and rigid within 1 %, the rest 5 %; cover within 1 %."""
    expected = {
        "nominal": (908.1, 992.3, 1582.5, 2236), "rigid": (441.7, 495.3, 857.8, 1545), "rigid+joints": (86.5, 98.9, 177.8, 354)
    }  # fmt: skip
    for row in found.finding.compared[1:]:
        within = 0.05 if row[0] == "rigid+joints" else 0.01
        assert [float(cell.split()[0]) for cell in row[1:5]] == pytest.approx(expected[row[0]], rel=within)
        if row[0] != "nominal":
            assert 88.0 <= float(row[5].split()[0]) <= 91.0
    assert found.finding.left_out_error == pytest.approx(86.5e-6, rel=0.01)
    assert not found.reasons


def test_joints_yield_under_the_links(found):
    values = {value.name: value for value in found.finding.values}
    for k, se in ((1, 1.6e-6), (2, 2.5e-6)):
        one = values[f"errors.gravity_compliance[{k}]"]
        assert one.value == pytest.approx(9.4e-6, abs=2 * se)


def seen_of(data):
    return geometry.Seen(joint_angles(data, 6), data.matrix([f"position_{axis}" for axis in "xyz"]))


@pytest.mark.parametrize(
    ("model", "gravity", "mean"),
    [
        ("nominal", False, 0.721e-3),
        ("rigid", False, 0.692e-3),
        ("rigid+joints", False, 0.877e-3),
        ("rigid+joints", True, 0.338e-3),
    ],
)
def test_corrections_hold_only_inside_the_ranges(found, arm, model, gravity, mean):
    """Base and target fitted again on poses of which 65 in 632 lie inside: without gravity corrections do harm there."""
    cubes = seen_of(read_measurement(UR10 / "iso_cubes.csv", geometry.channels(found.settings), 3))
    own = arm if gravity else arm._replace(load=None)
    seen, rows = seen_of(found.data), np.arange(found.data.rows)
    fit = geometry.fitted(own, seen, rows, model, 60, geometry._nominal(found.data, own, seen, rows))
    assert geometry.figures_of(geometry.refitted(own, cubes, fit))[0] == pytest.approx(mean, rel=0.01)
    ranges = geometry.joint_ranges(seen.angles)
    inside = [np.mod(cubes.angles[:, k] - low, 2 * np.pi) <= high - low for k, (low, high) in enumerate(ranges)]
    assert np.sum(np.all(inside, axis=0)) == 65


def test_what_the_unknowns_move_the_place_by(arm, found):
    """The Jacobian against differences, at errors that are not 0."""
    seen = seen_of(found.data)
    own = geometry.Seen(seen.angles[:7], seen.places[:7])
    layout = geometry.Layout(6, True, 6, 3, True)
    placed = geometry._superposed(arm, own)
    given = (moments(arm.links, own.angles, arm.load), geometry.waves(own.angles, 3))
    x = np.random.default_rng(3).normal(size=layout.unknowns) * layout.prior(given[0]) * 0.1
    at = geometry._linearised(arm, own, placed, layout, given, x)
    for k in range(layout.unknowns):
        step = 1e-4 * layout.prior(given[0])[k]
        up, down = (
            geometry._linearised(arm, own, placed, layout, given, x + s * step * (np.arange(len(x)) == k))
            for s in (1, -1)
        )
        difference = -(up.residual - down.residual) / (2 * step)
        scale = np.abs(difference).max()
        assert at.jacobian[:, :, k] == pytest.approx(difference, abs=max(5e-3 * scale, 5e-4)), (
            k
        )  # of first order in the twists


def test_a_chain_without_errors_is_that_of_the_machine(arm):
    q = np.random.default_rng(0).uniform(-3, 3, size=(5, 6))
    target = np.array([0.01, 0.02, 0.1])
    at = poses(arm.links, q, np.zeros((6, 6)), target)
    assert np.moveaxis(np.cross(at.axes, at.reach), 1, 2) == pytest.approx(
        jacobian(arm.links, q, target)[:, :3], abs=1e-12
    )


def test_a_moment_is_the_change_of_height_energy(arm):
    """Weights behind a joint: their moment is minus the change of the energy with its angle."""
    q = np.random.default_rng(1).uniform(-3, 3, size=(4, 6))
    load = Load(
        np.array([5.0, 4, 3, 2, 1, 0.5]), np.random.default_rng(2).normal(size=(6, 3)), np.array([0.0, 0.0, -1.0])
    )

    def energy(q):
        total = 0.0
        for k in range(6):
            links = arm.links._replace(**{f: getattr(arm.links, f)[: k + 1] for f in arm.links._fields})
            at = poses(links, q[:, : k + 1], np.zeros((k + 1, 6)), load.centres[k])
            total = total + 9.80665 * load.masses[k] * at.place[:, 2]
        return total

    found = moments(arm.links, q, load)
    for k in range(6):
        step = 1e-6 * (np.arange(6) == k)
        assert found[:, k] == pytest.approx(-(energy(q + step) - energy(q - step)) / 2e-6, abs=1e-5)


def made_up(tmp_path, arm, noise, rows=400, sign=1.0):
    """Poses of an arm with known errors."""
    rng = np.random.default_rng(4)
    errors = Errors(
        rng.normal(size=(6, 6)) * ([5e-4] * 3 + [5e-4] * 3), *(1e-4 * rng.normal(size=(6, 2)) for _ in range(2)),
        none(6, 0).gravity_compliance,
    )  # fmt: skip
    q = rng.uniform(-2.5, 2.5, size=(rows, 6))
    place = poses(
        arm.links, corrected_angles(q, errors, np.zeros_like(q)), errors.bodies, np.array([0.05, 0.02, 0.15])
    ).place
    seen = place[:, [1, 0, 2]] * [1, -1, sign] + [2.0, -1.0, 0.3] + noise * rng.normal(size=place.shape)
    titles = [f"joint{k} [rad]" for k in range(1, 7)] + [f"position_{a} [mm]" for a in "xyz"]
    lines = [",".join(repr(float(v)) for v in row) for row in np.hstack([q, 1e3 * seen])]
    file = tmp_path / "poses.csv"
    file.write_text("\n".join([", ".join(titles), *lines]))
    return file


def test_errors_made_up_come_back(tmp_path, arm):
    """Held-out places to little more than the noise of 0.05 mm a component; a share of 90 % inside their interval."""
    got = calibrated("robot-geometry", made_up(tmp_path, arm, 5e-5), [ARM, "fit.harmonics=2", "fit.gravity=false"])
    row = got.finding.compared[-1]
    assert got.finding.left_out_error == pytest.approx(5e-5 * np.sqrt(8 / np.pi), rel=0.15)
    assert 85.0 <= float(row[5].split()[0]) <= 95.0
    exact = calibrated("robot-geometry", made_up(tmp_path, arm, 0.0), [ARM, "fit.harmonics=2"])
    assert exact.finding.left_out_error < 1e-5  # of errors of 1 mm: the priors pull a little
    assert not got.reasons


def test_left_handed_places_are_refused(tmp_path, arm):
    with pytest.raises(ScenarioFault, match="left-handed"):
        calibrated("robot-geometry", made_up(tmp_path, arm, 0.0, rows=30, sign=-1.0), [ARM, "fit.harmonics=2"])


def test_too_few_poses(tmp_path, arm):
    with pytest.raises(ScenarioFault, match="twelve poses"):
        calibrated("robot-geometry", made_up(tmp_path, arm, 0.0, rows=5), [ARM])


def test_ranges_are_modulo_a_turn():
    found = geometry.joint_ranges(np.array([[3.0, 0.1], [-3.0, -0.2], [3.2, 0.4]]))
    assert found[0] == pytest.approx((3.0, 2 * np.pi - 3.0))
    assert found[1] == pytest.approx((-0.2, 0.4))


def test_the_entry_holds_the_corrections(found):
    text = found.entry("my_ur10")
    for words in ("gravity_compliance", "cosine", "ranges", "kind: robot-geometry", "status: measured"):
        assert words in text
    assert "link_weights" in text  # of the entry that it completes, with their status
    assert found.data.sha256 in text


def test_leaving_out_poses_one_by_one_is_refused():
    with pytest.raises(ScenarioFault, match=r"fit\.hold_out: leave_one_out is too much"):
        calibrated("robot-geometry", UR10 / "iso_cubes.csv", [ARM, "fit.hold_out=leave_one_out"])
