"""28 drilled holes of an R-2000iC that no simple law explains: the figures of docs/validation.md, from the file itself.

Breakthrough speed against posture. Nothing is tuned here: a law has one factor, found on other places or other holes.
"""

import numpy as np
import pytest

from cutwise.io.measurements import WORDS, Channel, read_measurement
from cutwise.io.scenario import load
from cutwise.process.posture import posture_at
from cutwise.process.robot_arms import robot_arm

ARM = {"robot.library": "fanuc_r2000ic", "requirements": "{}", "robot.joint_angles": "null"}


@pytest.fixture(scope="module")
def holes(examples):
    """Place, speed [m/s] and compliance along the drill axis [m/N] of each hole."""
    channels = (Channel("hole", WORDS), *(Channel(f"joint{k}", "angle", unit="deg") for k in range(1, 7)),
                Channel("breakthrough_speed", "speed", unit="mm/s"))  # fmt: skip
    data = read_measurement(examples / "measured" / "fanuc_r2000ic" / "holes.csv", channels, 28)
    arm = robot_arm(load(examples / "drill_robot.yaml", ARM).robot)[0]
    q = data.matrix([f"joint{k}" for k in range(1, 7)])
    axial = np.array([posture_at(arm, 0.0, row).compliance[2, 2] for row in q])
    _, posture = np.unique(np.round(q, 6), axis=0, return_inverse=True)
    names = zip(data.labels["hole"], posture.reshape(-1), strict=True)
    place = np.array(
        [name[0] if name[0] != "V" else f"V{k}" for name, k in names]
    )  # two holes at each of four postures
    return place, data.columns["breakthrough_speed"], axial


def rms(error):
    return 1e3 * float(np.sqrt(np.mean(np.square(error))))


def test_a_place_left_out(holes):
    place, speed, axial = holes
    mean, law = np.zeros(28), np.zeros(28)
    x = np.sqrt(axial)
    for one in np.unique(place):
        out, rest = place == one, place != one
        mean[out] = speed[rest].mean()
        law[out] = x[out] * (x[rest] @ speed[rest]) / (x[rest] @ x[rest])
    assert rms(speed - mean) == pytest.approx(46.7, abs=0.1)
    assert rms(speed - law) > 36.0


def test_inside_a_place(holes):
    place, speed, axial = (part[:20] for part in holes)  # A to D, five holes each
    mean, law = np.zeros(20), np.zeros(20)
    x = np.sqrt(axial)
    for k in range(20):
        rest = (place == place[k]) & (np.arange(20) != k)
        mean[k] = speed[rest].mean()
        law[k] = x[k] * (x[rest] @ speed[rest]) / (x[rest] @ x[rest])
    assert rms(speed - mean) == pytest.approx(17.9, abs=0.1)
    assert rms(speed - law) == pytest.approx(17.5, abs=0.1)  # 2 % better than no law at all
