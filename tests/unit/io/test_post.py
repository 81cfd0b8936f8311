"""Written programs say where the path is: G-code read back by plain words, APT and poses row by row."""

import re

import numpy as np
import pytest

from cutwise.io.programs.interpreter import interpret
from cutwise.io.programs.post import apt, gcode, pose_frames, poses_csv
from cutwise.io.scenario import load
from cutwise.process.chamfer_program import program_of
from cutwise.process.recipes import simulate


@pytest.fixture(scope="module")
def program(examples):
    overrides = ["path.points=360", "setup=null"]
    return program_of(simulate(load(examples / "chamfer_pipe_hole.yaml", overrides)))


def test_gcode_gives_the_tips_back(program):
    text = gcode(program)
    points = np.array([[float(v) for v in m] for m in re.findall(r"^G[01] X(\S+) Y(\S+) Z(\S+)", text, re.MULTILINE)])
    tips = (program.position - program.ball_radius * program.axis) * 1e3
    assert points == pytest.approx(tips, abs=6e-5)  # four decimals


def test_gcode_is_read_by_our_own_interpreter(program):
    assert interpret(gcode(program)) is not None


def test_apt_and_poses_have_a_row_a_move(program):
    assert len(re.findall(r"^GOTO", apt(program), re.MULTILINE)) == len(program.position)
    assert len(poses_csv(program).splitlines()) == len(program.position) + 1


def test_pose_frames_are_right_handed(program):
    frames = pose_frames(program)
    assert np.linalg.det(frames) == pytest.approx(np.ones(len(frames)))
