"""The way of a program through its corners: G61, G64 with and without a tolerance, rapids, arcs and helices."""

import itertools
import math
import tracemalloc

import numpy as np
import pytest

from cutwise.io.scenario import parse
from cutwise.maths.linearc import curvature_jumps, sample, turn_angles
from cutwise.physics.motion.lookahead import plan
from cutwise.physics.motion.profile import Limits
from cutwise.process.milling import run, stop_cost
from cutwise.process.program_path import Pace, moves_path
from cutwise.process.recipes import simulate
from cutwise.programs.interpreter import interpret
from cutwise.programs.move_table import Moves

LIMITS = Limits(0.169, 2.0, 50.0)
PACE = Pace(*LIMITS)
HEAD = "G21 G90 G17 M3 S1000\n"
ARC = "G0 X0 Y0\nG1 X50 F3000\nG2 X80 Y-8 R60\nG1 X120"
BEND = "G0 X0 Y0\nG1 X50 F3000\nG1 X80 Y-8\nG1 X120"
SCENARIO = """\
process: mill
program: {file: part.nc, text: "TEXT"}
operation: {axial_depth: 5 mm, radial_depth: 4 mm}
tool: {diameter: 20 mm, flutes: 3, helix: 30 deg}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
numerics: {settling_time: 0.1 s, force: none}
"""


def path_of(text, mode=None):
    return moves_path(interpret(text), feed=None, turning=True, mode=mode, top=0.0, pace=PACE)


def motion(path):
    return plan(path.curve, path.feed, LIMITS, path.stop_at, path.dwell_after)


def scenario(text, *changes):
    return parse(SCENARIO.replace("TEXT", text.replace("\n", "\\n")), overrides=changes)


def off(path):
    """Largest distance of the path that is driven from the programmed one, by dense sampling [m]."""
    s = np.linspace(0.0, path.curve.knots[-1], 20_001)
    driven = sample(path.curve, path.curve.knots, s)[0]
    t = np.linspace(0.0, path.programmed.knots[-1], 40_001)
    wanted = sample(path.programmed, path.programmed.knots, t)[0]
    worst = 0.0
    for part in np.array_split(driven, 60):
        low, high = part.min(axis=0) - 2e-3, part.max(axis=0) + 2e-3
        near = wanted[((wanted >= low) & (wanted <= high)).all(axis=1)]
        worst = max(worst, float(np.sqrt(((part[:, None] - near[None]) ** 2).sum(axis=2)).min(axis=1).max()))
    return worst


def test_line_and_arc_are_blended_as_line_and_line_are():
    """0.1 stopped twice, 2.618 s; with a line in place of the arc it took 2.484 s."""
    stopped = motion(path_of(HEAD + "G61\n" + ARC))
    assert (stopped.stops, stopped.profile.duration) == (2, pytest.approx(2.618, abs=1e-3))
    path = path_of(HEAD + "G64 P0.05\n" + ARC)
    found = motion(path)
    assert found.stops == 0
    assert found.profile.duration == pytest.approx(2.493, abs=2e-3)
    assert motion(path_of(HEAD + "G64 P0.05\n" + BEND)).profile.duration == pytest.approx(2.484, abs=1e-3)
    assert off(path) <= 0.05e-3 * 1.001 + 2e-6  # sampled every 3 um
    assert turn_angles(path.curve).max() < 1e-4


def test_rapids_plunges_and_helices_are_blended():
    text = HEAD + "G64 P0.05\nG0 X0 Y0 Z5\nG0 X10\nG1 Z-1 F600\nG3 X10 Y0 Z-3 I5 J0\nG1 X20\nG0 Z5\nG0 X30"
    path = path_of(text)
    assert motion(path).stops == 0
    assert off(path) <= 0.05e-3 * 1.001 + 2e-6
    rapid = np.isinf(path.feed)
    assert rapid.any()
    assert not (rapid & path.cuts).any()


def test_where_the_path_turns_back_every_mode_stops():
    assert motion(path_of(HEAD + "G64 P0.05\nG1 X10 F600\nG1 X0\nG1 X5 Y5")).stops == 1


def test_g64_without_a_tolerance_keeps_the_feed():
    """The smallest arc over which limits allow the feed: r = max(F^2/a, sqrt(F^3/j)); 0.1 stopped there."""
    path = path_of(HEAD + "G64\nG1 X20 F1200\nG1 Y20\nM2")
    found = motion(path)
    assert found.stops == 0
    assert found.joint_speed[1:-1] == pytest.approx(np.full(2, 0.02), rel=1e-9)
    radius = max(0.02**2 / 2.0, math.sqrt(0.02**3 / 50.0))
    assert path.curve.radius[1] == pytest.approx(radius, rel=1e-9)
    tolerance, line = path.kept_feed
    assert (tolerance, line) == (pytest.approx(radius * (math.sqrt(2.0) - 1.0), rel=1e-9), 3)
    short = path_of(HEAD + "G64\nG1 X0.1 F1200\nG1 Y0.1\nM2")
    assert short.kept_feed[0] == pytest.approx(0.025e-3)


def test_the_last_word_counts_and_no_word_is_exact_path():
    assert motion(path_of(HEAD + "G1 X20 F1200\nG1 Y20\nM2")).stops == 1
    assert motion(path_of(HEAD + "G64\nG1 X20 F1200\nG61\nG1 Y20\nG1 X0\nM2")).stops == 1
    assert motion(path_of(HEAD + "G64\nG1 X20 F1200\nG1 Y20\nM2", "exact_path")).stops == 1


def test_a_tool_is_changed_at_rest():
    assert motion(path_of(HEAD + "T1 M6\nG64 P0.05\nG1 X20 F1200\nT2 M6\nG1 X40\nG1 Y20\nM2")).stops == 1


def test_stops_that_cost_more_than_a_tenth_are_told():
    """Also few of them, or such as G61.1 asks for: 0.1 said nothing below half of the time and ten stops."""
    text = HEAD + "G1 X2 F3000\nG1 Y2\nG1 X0\nG1 Y0\nM2"
    said = [s for s in simulate(scenario(text)).warnings if "full stops cost" in s]
    assert len(said) == 1
    assert "3 at corners" in said[0]
    again = simulate(scenario(text, "path_mode=exact_stop")).warnings
    assert any("3 by exact stop" in s for s in again)
    long = HEAD + "G1 X200 F1200\nG1 Y200\nM2"
    assert not any("full stops" in s for s in simulate(scenario(long)).warnings)


def test_the_cost_of_stops_is_that_of_the_motion_without_them():
    one = scenario(HEAD + "G1 X2 F3000\nG1 Y2\nM2")
    done = run(one, 1)
    cost = stop_cost(done.path, done.plan, one)
    there = motion(path_of(HEAD + "G1 X4 F3000\nM2")).profile.duration
    assert cost.share == pytest.approx(1.0 - there / done.plan.profile.duration, rel=1e-6)
    assert (cost.corners, cost.asked) == (1, 0)


def test_the_rule_for_a_feed_that_is_kept_is_told():
    result = simulate(scenario(HEAD + "G64\nG1 X20 F1200\nG1 Y20\nM2"))
    assert "keeps the feed" in result.notes["kept_feed"]
    assert not any("full stops" in s for s in result.warnings)


def zigzag(count):
    x, y = 0.3 * np.arange(count), 0.15 * (np.arange(count) % 2)
    feed = np.where(np.arange(count) % 5, 300, 150)
    return HEAD + "\n".join(f"G1 X{a:.3f} Y{b:.3f} F{f}" for a, b, f in zip(x, y, feed, strict=True)) + "\nM2"


def test_many_short_lines_are_small():
    """67,426 lines took some 3 KB each."""
    path = path_of(zigzag(200), parse_mode())
    motion(path)  # compiled
    program = interpret(zigzag(20_000))
    tracemalloc.start()
    path = moves_path(program, feed=None, turning=True, mode=parse_mode(), top=0.0, pace=PACE)
    found = motion(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert path.curve.count > 2 * 20_000 - 4
    assert found.stops == 0
    assert peak / 20_000 < 1_500


def parse_mode():
    return scenario(HEAD + "G1 X1 F100", "path_mode={blend: 0.01 mm}").path_mode


def test_moves_in_columns_are_the_moves():
    text = (
        HEAD + "T3 M6 M8\nG0 X1 Z2\nG4 P1.5\nG2 X3 Y0 I1 J0 F100\nG1 A30\nM9\nG64 P0.1\nG1 X5 A40\nG3 X5 Z-2 I2\nG0 Z5"
    )
    found = interpret(text).moves
    assert isinstance(found, Moves)
    listed = list(found)
    assert [found[i] for i in range(len(found))] == listed
    assert found[-2:] == tuple(listed[-2:])
    assert Moves(listed) == found
    assert [m.kind for m in listed] == ["rapid", "dwell", "arc", "feed", "feed", "arc", "rapid"]
    assert listed[1].dwell == 1.5
    assert [m.coolant for m in listed[:4]] == ["flood"] * 4
    assert listed[4].rotary_start == pytest.approx((math.radians(30), 0, 0))
    assert listed[5].sweep == pytest.approx(2 * math.pi)
    assert all(a.end == b.start for a, b in itertools.pairwise(listed))
    with pytest.raises(IndexError):
        found[7]


def test_a_clothoid_blend_next_to_an_arc_tells_its_jump():
    """Between lines the curvature nowhere jumps; where an arc begins it does, and is listed."""
    mode = scenario(HEAD + "G1 X1 F100", "path_mode={blend: 0.05 mm, shape: clothoid}").path_mode
    bent = path_of(HEAD + ARC, mode)
    assert motion(bent).stops == 0
    assert motion(bent).curvature_steps.max() > 0.0
    assert curvature_jumps(path_of(HEAD + BEND, mode).curve).max() < 1e-6
