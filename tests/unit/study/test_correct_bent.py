"""Paths moved against a tool that bends: walls solved by hand, up and down, the loop tooth by tooth, the written program."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import cutwise
from cutwise.io.scenario import load
from cutwise.process import milling
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct import bent, path, shift

UM = 1e-6
R, N, DEPTH, STIFFNESS, CHIP = 6e-3, 4, 9.4248e-3, 10e6, 0.02 / (100.0 * 4)
STRAIGHT = "G21 G90 G17 G94 G61\nS6000 M3\nG0 Z-9.4248\nG1 X{} Y16 F1200\nM2\n"
QUICK = "numerics.settling_time=0.02 s"


def mean_force(depth, left=False):
    """Into the wall [N], the mean over a turn, of al7075t6: tangential and radial force over the arc, integrated."""

    def into(a):
        ft, fr = 767.01e6 * CHIP * math.sin(a) + 27.7e3, 168.8e6 * CHIP * math.sin(a) + 26.6e3
        return (ft if left else -ft) * math.sin(a) - fr * math.cos(a)

    return N * DEPTH / (2.0 * math.pi) * quad(into, 0.0, math.acos(1.0 - depth / R))[0]


def off(depth, shift=0.0, left=False):
    """Error of the wall into the part [m] of a tool that is led ``shift`` into it."""
    return brentq(
        lambda e: shift + mean_force(depth + e, left) / STIFFNESS - e, -0.2e-3, 0.2e-3, xtol=1e-15
    )  # fmt: skip


def straight(examples, *given, left=False):
    """Along the upper side of a block: to the right (climbing) or to the left (up milling), without a bend."""
    start, end = (36, 12) if left else (6, 30)
    text = STRAIGHT.format(end)
    scenario = load(examples / "correct_wall.yaml", [QUICK, *given])
    document = scenario.document()
    document["program"] |= {"text": text, "start": {"x": f"{start} mm", "y": "16 mm", "z": "5 mm"}}
    from cutwise.io.scenario import read_document

    return read_document(document)


def plant_of(scenario):
    told = milling.commanded(scenario, scenario.numerics.substeps)
    return shift.Plant(scenario, told, bent.walls_of(scenario, told))


def middle(plant, values):
    """Where the cut is steady."""
    way = plant.told.place.travelled
    return values[(way > way[-1] - 12e-3) & (way < way[-1] - 4e-3)]


@pytest.mark.parametrize("left", [False, True])
def test_a_straight_wall_is_off_as_solved_by_hand_and_led_back(examples, left):
    """Down and up milling: the stock is 0.5 mm beside the wall. The shift that is learned is F_n(a_e)/k, the arc's own depth."""
    plant = plant_of(straight(examples, left=left))
    side, depth = -1.0 if left else 1.0, 0.5e-3
    before = shift.seen([plant], plant.told.order)
    assert middle(plant, before.into[0]) == pytest.approx(off(depth, left=left), abs=0.01 * UM)
    assert middle(plant, before.error[0]) == pytest.approx(side * off(depth, left=left), abs=0.01 * UM)
    rule = shift.rule_of(plant.told, plant.scenario.drives.limits.jerk, None, None)
    found = shift.learn([plant], rule, 4)
    after = shift.seen([plant], shift.shifted(plant.told, found.at(plant.told.place.travelled)))
    led = middle(
        plant, (after.error - after.bend)[0]
    )  # where friction lets the axis stand; the shift itself may be beside it
    assert led == pytest.approx(-side * mean_force(depth, left) / STIFFNESS, rel=0.05)
    assert np.abs(middle(plant, after.error[0])).max() < 0.05 * abs(off(depth, left=left))


def test_a_small_shift_moves_the_wall_by_the_gain_of_a_following_arc(examples):
    """All of the path led 5 µm into the part: what the wall gains, by hand and in the run; the rule finds it by one secant."""
    plant = plant_of(straight(examples))
    still, moved = (
        shift.seen([plant], shift.shifted(plant.told, np.full(len(plant.told.place.time), d))) for d in (0.0, 5 * UM)
    )
    led, gained = (middle(plant, one) for one in ((moved.error - moved.bend - still.error + still.bend)[0],
                                                  (moved.into - still.into)[0, :, 0]))  # fmt: skip
    assert led.min() > 4 * UM
    by_hand = (off(0.5e-3, float(led[0])) - off(0.5e-3)) / led[0]
    assert gained / led == pytest.approx(by_hand, abs=1e-3)
    assert by_hand == pytest.approx(0.989, abs=1e-3)


@pytest.mark.parametrize("left", [False, True])
def test_the_tip_that_swings_in_the_loop_leaves_the_wall_that_the_balance_says(examples, left):
    """Damped modes of the same static stiffness, tooth by tooth: F_n(a_e)/k with the arc of the wanted path, its gain is 1."""
    modes = "[{direction: x, frequency: 2950 Hz, damping: 0.5, stiffness: 10 N/um}, "
    modes += "{direction: y, frequency: 3020 Hz, damping: 0.5, stiffness: 10 N/um}]"
    plant = plant_of(straight(examples, "tool.stiffness=null", f"tool.modes={modes}", "numerics.discs=40", left=left))
    seen = shift.seen([plant], plant.told.order)
    assert middle(plant, seen.into[0]).mean() == pytest.approx(mean_force(0.5e-3, left) / STIFFNESS, rel=0.02)
    assert middle(plant, seen.half[0]).max() < 0.2 * UM


def test_a_short_flute_leaves_a_slope_that_no_shift_takes_away(examples):
    """A quarter of the pitch deep: the last height is left with nothing in the cut, so half of the largest error stays."""
    plant = plant_of(straight(examples, "tool.helix=20 deg"))
    seen = shift.seen([plant], plant.told.order)
    into = middle(plant, seen.into[0])
    assert into[:, 0].max() < -5 * UM
    assert into[:, 1] == pytest.approx(0.0, abs=0.11 * np.abs(into[:, 0]).max())  # of the middle of the last disc
    assert middle(plant, seen.half[0]) == pytest.approx(0.5 * (into[:, 1] - into[:, 0]), rel=1e-9)


def test_an_inner_fillet_is_learned_drives_and_bend_as_one(examples):
    """41 µm, of which the drives make 38 without a bend: mirrored once, a fortieth is left."""
    plant = plant_of(
        load(
            examples / "correct_corner.yaml",
            ["correct={change: [path]}", "tool.stiffness=10 N/um", "numerics.force=averaged"],
        )
    )
    rule = shift.rule_of(plant.told, plant.scenario.drives.limits.jerk, None, None)
    found = shift.learn([plant], rule, 6)
    assert found.trail[0] > 40 * UM
    assert min(found.trail) < 0.05 * found.trail[0]
    alone = shift.seen([plant._replace(walls=None)], plant.told.order)
    assert np.abs(alone.error).max() == pytest.approx(37.96 * UM, abs=0.05 * UM)


@pytest.fixture(scope="module")
def proved(examples):
    return cutwise.correct(load(examples / "correct_wall.yaml"))


def test_the_example_is_left_within_a_tenth(proved):
    value = {name: one.value for name, one in proved.measures.items()}
    assert proved.good
    assert value["residual_ratio"] < 0.1
    assert value["wall_error_min_before"] < -20 * UM
    assert max(-value["wall_error_min_after"], value["wall_error_max_after"]) == pytest.approx(value["residual_max"])
    assert value["wall_gain"] == pytest.approx(0.989, abs=2e-3)


def test_the_text_leaves_what_was_told(proved):
    """Read again and run as any program: drives by the run's own contour error, the bend by the balance by hand."""
    scenario = proved.scenario
    run = milling.run(scenario, scenario.numerics.substeps)
    way = run.place.travelled
    steady = (way > way[0] + 45e-3) & (way < way[0] + 60e-3)  # along the upper side
    led = run.contour_error[steady]
    left = np.array([off(0.5e-3, float(d)) for d in led[::50]])
    assert np.abs(left).max() < 0.05 * abs(off(0.5e-3))


def test_a_rigid_tool_changes_nothing(examples):
    scenario = load(examples / "correct_wall.yaml", [QUICK, "tool.stiffness=null"])
    assert plant_of(scenario).walls is None


def test_a_wall_that_a_later_pass_takes_away_is_left_alone_and_told(examples):
    """A second pass 0.2 mm farther in: the first one's wall is gone, but for where it reaches beyond."""
    text = "G21 G90 G17 G94 G61\nS6000 M3\nG0 Z-9.4248\nG1 X30 Y16.2 F1200\nG0 Z5\nG0 X6 Y16\nG0 Z-9.4248\nG1 X30 F1200\nM2\n"
    document = straight(examples).document()
    document["program"] |= {"text": text, "start": {"x": "6 mm", "y": "16.2 mm", "z": "5 mm"}}
    from cutwise.io.scenario import read_document

    plant = plant_of(read_document(document))
    seen = shift.seen([plant], plant.told.order)
    first = plant.told.place.travelled < 24e-3
    assert plant.told.wanted.curve.knots[2] > 24e-3
    assert not np.isfinite(seen.into[0][first]).any()
    assert np.isfinite(seen.into[0][~first]).any()
    assert any("a later pass takes the wall away" in text for text in bent.told_of(plant.scenario, plant.walls))


def test_what_has_no_program_or_chatters_is_refused_in_words(examples):
    line = load(examples / "mill_on_machine.yaml", ["tool.modes=null", "tool.stiffness=10 N/um"])
    with pytest.raises(ScenarioFault, match="no program that could be moved"):
        cutwise.correct(line, ("path",))
    with pytest.raises(ScenarioFault, match=r"path.line.*has no program"):
        cutwise.correct(load(examples / "cell_robot_wall.yaml"), ("path",))
    soft = "[{direction: x, frequency: 300 Hz, damping: 0.005, stiffness: 1 N/um}]"
    scenario = straight(examples, "tool.stiffness=null", f"tool.modes={soft}")
    with pytest.raises(ScenarioFault, match="the tool chatters"):
        cutwise.correct(scenario, ("path",))


def test_a_bending_tool_along_a_corner_is_read_where_it_is_corrected(examples):
    with pytest.raises(ScenarioFault, match=r"write correct: \{change: \[path\]\}"):
        load(examples / "mill_pocket_corner.yaml", ["tool.stiffness=10 N/um"])


def test_limits_on_walls_are_held(examples):
    names = ("wall_error_min", "wall_error_max")
    values = {f"{name}_{when}": (value * UM, "small_length") for when, ends in (("before", (-8, -2)), ("after", (-1, 1)))
              for name, value in zip(names, ends, strict=True)}  # fmt: skip
    for limits, words in (
        ("{wall_error_min: {min: -2 um}, wall_error_max: {max: 2 um}}", []),
        (
            "{wall_error_min: {min: -0.5 um}, wall_error_max: equal}",
            ["wall_error_min is -1 µm", "wall_error_max is 1 µm"],
        ),
    ):
        said = load(examples / "correct_wall.yaml", [f"correct.limits={limits}"]).correct
        path._refuse(load(examples / "correct_wall.yaml"), said)
        told = list(path._walls_kept(said, values))
        assert len(told) == len(words)
        assert all(text.startswith(word) for text, word in zip(told, words, strict=True))
    rigid = load(examples / "correct_wall.yaml", ["tool.stiffness=null"])
    with pytest.raises(ScenarioFault, match="contour_error_max is"):
        path._refuse(rigid, said)
