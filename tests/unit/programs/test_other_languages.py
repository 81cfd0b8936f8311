"""Programs in other languages: read back they are the same motion; poses of robots come back from their text."""

import math
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cutwise.maths.frames import rotation_from_rpy
from cutwise.programs import pocket, written_moves
from cutwise.programs.interpreter import interpret
from cutwise.programs.robot_moves import Frame, RobotMove, RobotProgram, abc_of, krl, quaternion_of, rapid

TWISTED = """G21 G90 G17
G0 X1 Y2 Z3
G1 X10 Y0 F100 S100 M3
G2 X10 Y0 I-5 J0 P3 Z-3
G18 G3 X20 Z-3 I5 K0
G19 G2 Y4 Z-3 J2 K0
G4 P0.5
G17 G2 I2 J2
M2
"""


def axes_of(a, b, c):
    """Axes as columns of angles A, B, C [degree] of a KUKA robot."""
    return rotation_from_rpy(*np.radians([c, b, a]))


def paths(text, name):
    """Where the tool goes: kind, end [mm], whole turn of arcs [rad] and feed; turns of one arc are added."""
    found = []
    for move in interpret(text, name).moves:
        sweep = move.sweep * (1.0 if sum(move.axis) > 0.0 else -1.0)
        centre = tuple(round(1e3 * c, 6) for c in move.centre[:2]) if move.kind == "arc" else ()
        row = [move.kind, np.array(move.end) * 1e3, sweep, move.feed, centre]
        if found and move.kind == "arc" and found[-1][0] == "arc" and found[-1][4] == centre and abs(sweep) > 6.28:
            found[-1][1], found[-1][2] = row[1], found[-1][2] + sweep
        else:
            found.append(row)
    return found


@pytest.mark.parametrize("write", [written_moves.fanuc, written_moves.apt], ids=["fanuc", "apt"])
@pytest.mark.parametrize("name", ["mill_pocket.nc", "mill_part.nc", "bracket.ngc", "twisted"])
def test_the_motion_is_the_same(examples, write, name):
    text = TWISTED if name == "twisted" else (examples / name).read_text()
    new = write("part (1)\x07", interpret(text, name).moves)
    old, again = paths(text, name), paths(new, "new.apt" if write is written_moves.apt else "new.nc")
    assert len(old) == len(again)
    for one, other in zip(old, again, strict=True):
        assert one[0] == other[0]
        assert one[1] == pytest.approx(other[1], abs=1e-6)
        assert one[2] == pytest.approx(other[2], abs=1e-6)
        assert one[3] == pytest.approx(other[3], rel=1e-6) or math.isinf(one[3]) == math.isinf(other[3])


def test_words_of_a_fanuc_program(examples):
    text = written_moves.fanuc("pocket", interpret((examples / "mill_pocket.nc").read_text(), "a.nc").moves, number=12)
    assert text.startswith("%\nO0012 (POCKET)\n")
    assert text.endswith("M30\n%\n")
    numbers = re.findall(r"[XYZIJKF](-?[\d.]+)", text)
    assert numbers
    assert all("." in number for number in numbers), "a number without a point counts least increments there"
    assert "G64 P" not in text
    assert "#" not in text


def test_a_program_that_begins_in_the_cut_says_where():
    moves = interpret("G21 G90 F100 S100 M3\nG1 X5 Z-1\nG1 X9\nM2\n", "a.nc").moves
    assert "G0 X0. Y0.\nG0 Z0.\nG1 X5. Z-1." in written_moves.fanuc("a", moves)


def test_what_a_language_has_no_words_for_is_refused():
    moves = interpret("G21 G90 F100\nG38.2 Z-5\nG1 X5\nM2\n", "a.nc").moves
    with pytest.raises(written_moves.Unwritten, match="line 2: a probing move"):
        written_moves.fanuc("a", moves)


@pytest.mark.parametrize(
    ("abc", "q"),
    [
        ((30, -40, 170), (0.00907553, -0.91193454, -0.21349156, -0.35030613)),
        ((26, 0, 180), (0, 0.97437007, 0.22495105, 0)),
    ],
)
def test_quaternions_of_the_reference(abc, q):
    assert quaternion_of(axes_of(*abc)) == pytest.approx(q, abs=1e-8)


def test_b_at_a_right_angle():
    assert abc_of(axes_of(15.0, 90.0, -20.0)) == pytest.approx((0.0, 90.0, -35.0), abs=1e-6)


def test_angles_and_quaternions_against_scipy():
    for turn in Rotation.random(50, random_state=1):
        axes = turn.as_matrix()
        assert axes_of(*abc_of(axes)) == pytest.approx(axes, abs=1e-12)
        assert Rotation.from_euler("ZYX", abc_of(axes), degrees=True).as_matrix() == pytest.approx(axes, abs=1e-12)
        q = quaternion_of(axes)
        assert Rotation.from_quat([*q[1:], q[0]]).as_matrix() == pytest.approx(axes, abs=1e-12)
        assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-12)
        assert q[0] >= 0.0


@pytest.fixture(scope="module")
def program():
    turns = Rotation.random(4, random_state=2).as_matrix()
    joints = np.radians([[10, -95, 100, 170, -30, 200]] * 4)
    moves = [
        RobotMove(Frame(np.array([1.9, 0.3, 0.8 + 0.01 * k]), turn), joints[k], 0.0 if k == 0 else 0.005 * k, k != 2)
        for k, turn in enumerate(turns)
    ]
    tool = Frame(np.array([0.2, 0.0, -0.3]), axes_of(0.0, 0.0, 180.0))
    return RobotProgram("drill\n;END 2", tool, Frame(np.zeros(3), np.eye(3)), moves, 1e-3, ("a\nEND",))


def test_poses_come_back_from_krl(program):
    text = krl(program)
    assert text.splitlines()[0] == "DEF drill__END_2 ( )"
    assert "\nEND\n" not in text[: -len("END\n") - 1], "no remark ends the program"
    found = re.findall(r"LIN \{X (\S+?),Y (\S+?),Z (\S+?),A (\S+?),B (\S+?),C (\S+?)\}( C_DIS)?", text)
    linear = program.moves[1:]
    assert len(found) == len(linear)
    for values, move in zip(found, linear, strict=True):
        assert np.array(values[:3], float) == pytest.approx(move.pose.origin * 1e3, abs=1e-4)
        assert axes_of(*map(float, values[3:6])) == pytest.approx(move.pose.rotation, abs=2e-6)
        assert bool(values[6]) != move.exact
    assert re.search(r"PTP \{A1 10.0000,A2 -95.0000,A3 100.0000,A4 170.0000,A5 -30.0000,A6 200.0000\}", text)
    assert "$TOOL = {X 200.0000,Y 0.0000,Z -300.0000,A 0.0000,B 0.0000,C 180.0000}" in text


def test_poses_come_back_from_rapid(program):
    text = rapid(program)
    found = re.findall(r"MoveL \[\[([^\]]*)\],\[([^\]]*)\],\[([^\]]*)\],", text)
    for (place, turn, configuration), move in zip(found, program.moves[1:], strict=True):
        assert np.array(place.split(","), float) == pytest.approx(move.pose.origin * 1e3, abs=1e-4)
        q = np.array(turn.split(","), float)
        assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-8)
        assert Rotation.from_quat([*q[1:], q[0]]).as_matrix() == pytest.approx(move.pose.rotation, abs=1e-9)
        assert configuration == "0,1,2,0"
    assert "MoveAbsJ [[10.0000,-95.0000,100.0000,170.0000,-30.0000,200.0000]" in text


RECTANGLE = pocket.Rectangle((0.0, 100.0), (0.0, 60.0), 5.0, 20.0, 4.0, 5.0, 2400.0, 300.0, 8000.0, 5.0)


def below(text):
    return [
        move
        for move in interpret(text, "a.nc").moves
        if move.kind in ("feed", "arc") and move.start[2] < 0.0 and move.end[2] < 0.0
    ]


def test_the_contour_is_the_pocket_of_the_reference(examples):
    made, given = below(pocket.contour(RECTANGLE)), below((examples / "mill_pocket.nc").read_text())
    assert len(made) == len(given) == 52
    for one, other in zip(made, given, strict=True):
        assert (*one.end, *one.centre, one.sweep) == pytest.approx((*other.end, *other.centre, other.sweep), abs=1e-12)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("strategy", pocket.STRATEGIES)
@pytest.mark.parametrize(
    ("x", "y", "step"),
    [((16.0, 84.0), (16.0, 44.0), 2.0), ((-7.0, 40.0), (3.0, 33.0), 3.3), ((0.0, 50.0), (0.0, 50.0), 4.0)],
)
def test_a_pocket_is_cleared_and_no_wall_is_cut(strategy, x, y, step, turned):
    """Points of the pocket that a mill of this radius can reach are within a radius of the path; the path stays inside."""
    if turned:
        x, y = y, x
    if strategy == "trochoid" and step == 4.0:
        pytest.skip("wider than two mills: refused by the scenario")
    given = RECTANGLE._replace(x=x, y=y, step=step, corner=0.0 if step < 4.0 else 5.0)
    points = []
    for move in below(pocket.STRATEGIES[strategy](given)):
        for share in np.linspace(0.0, 1.0, 60):
            start, end = np.array(move.start[:2]), np.array(move.end[:2])
            if move.kind == "arc":
                centre, a = np.array(move.centre[:2]), share * move.sweep
                turn = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
                points.append(centre + turn @ (start - centre))
            else:
                points.append(start + share * (end - start))
    path = np.array(points) * 1e3
    assert path[:, 0].min() >= x[0] + 10.0 - 1e-6
    assert path[:, 0].max() <= x[1] - 10.0 + 1e-6
    assert path[:, 1].min() >= y[0] + 10.0 - 1e-6
    assert path[:, 1].max() <= y[1] - 10.0 + 1e-6
    inside = [(u, v) for u in np.linspace(x[0] + 0.1, x[1] - 0.1, 40) for v in np.linspace(y[0] + 0.1, y[1] - 0.1, 40)]
    corner = 15.0 if step == 4.0 else 10.0
    corner = corner if strategy != "trochoid" else 0.5 * min(x[1] - x[0], y[1] - y[0])
    for u, v in inside:
        du, dv = max(x[0] + corner - u, u - x[1] + corner, 0.0), max(y[0] + corner - v, v - y[1] + corner, 0.0)
        if du > 0.0 and dv > 0.0 and math.hypot(du, dv) > corner - 0.05:
            continue  # the round corner that the mill leaves
        assert np.hypot(path[:, 0] - u, path[:, 1] - v).min() <= 10.05, (u, v)
