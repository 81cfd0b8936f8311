"""Written programs say where the path is: G-code read back by plain words, APT and poses row by row."""

import re

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process.chamfer_program import program_of
from cutwise.process.recipes import simulate
from cutwise.programs.interpreter import interpret
from cutwise.programs.post import Program, SetupFault, apt, gcode, pose_frames, poses_csv


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


def placed(axes):
    """A short program with a move down and a cut on each of some tool axes."""
    count = 3 * len(axes)
    axis = np.repeat(np.array(axes, float), 3, axis=0)
    start = np.array([0.01, 0.02, 0.03])
    position = np.array([start + h * a for a in np.array(axes, float) for h in (0.05, 0.0, -0.001)])
    feed = np.tile([0.0, 0.0, 0.01], len(axes))
    across = np.cross(axis, [0.6, 0.64, 0.48])
    return Program(
        "p", 0.002, position, axis, feed, across, -axis, np.repeat(np.arange(len(axes)), 3), 1000.0
    )._replace(path=np.arange(count) // 3)


def test_every_tool_axis_is_a_set_up_with_a_stop_and_its_frame():
    text = gcode(placed([(0, 0, 1), (1, 0, 0), (0, 0.6, 0.8)]))
    heads = re.split(r"\(set-up \d of 3: ", text)
    assert [re.search(r"^G5\d", head, re.MULTILINE).group() for head in heads[1:]] == ["G54", "G55", "G56"]
    assert ["\nM5\nM0 (set the part up for G5" in head for head in heads[1:]] == [False, True, True]
    assert text.count("S9549 M3") == 3
    by_hand = gcode(placed([(0, 0, 1)])._replace(spindle_speed=None))
    assert "M0 (start the spindle to the right, M3: the scenario gives no operation.spindle_speed)" in by_hand
    assert text.endswith("M5\nM30\n%\n")
    assert "(G54 is the frame of the part)" in heads[1]
    rows = re.search(r"x; y; z in the part: (.*)\)", heads[3]).group(1)
    frame = np.array([[float(v) for v in row.split()] for row in rows.split("; ")])
    assert frame[2] == pytest.approx([0.0, 0.6, 0.8])
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert interpret(text) is not None


def test_rapids_from_an_unknown_place_go_along_z_first():
    lines = [line for line in gcode(placed([(0, 0, 1), (0, 0, 1)])).splitlines() if line.startswith("G")]
    assert lines[2:5] == ["G0 Z78.0000", "G0 X10.0000 Y20.0000", "G0 X10.0000 Y20.0000 Z78.0000"]
    assert len(lines) == 1 + 1 + 2 + 6  # the second path stands where the first does


def test_more_set_ups_than_work_offsets_are_refused():
    angle = np.linspace(0.0, 1.0, 10)
    with pytest.raises(SetupFault, match="10 set-ups"):
        gcode(placed([(0.0, np.sin(a), np.cos(a)) for a in angle]))


def test_apt_stops_where_the_axis_changes_and_turns_the_spindle():
    text = apt(placed([(0, 0, 1), (1, 0, 0)]))
    assert text.count("SPINDL/9549,RPM,CLW") == 2
    assert text.count("STOP") == 1
    assert text.endswith("SPINDL/OFF\nFINI\n")


def test_apt_and_poses_have_a_row_a_move(program):
    assert len(re.findall(r"^GOTO", apt(program), re.MULTILINE)) == len(program.position)
    rows = [line for line in poses_csv(program).splitlines() if not line.startswith("#")]
    assert len(rows) == len(program.position) + 1


def test_pose_frames_are_right_handed(program):
    frames = pose_frames(program)
    assert np.linalg.det(frames) == pytest.approx(np.ones(len(frames)))
