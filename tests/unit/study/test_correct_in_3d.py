"""Feeds of a program in a stock in 3D: several tools, plunge and ramp, held to what their own contact allows."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.io.scenario import load, read_document
from cutwise.physics.cutting.affine_limits import CHIP, MEAN, PEAK, POWER, Bounds, intervals_of
from cutwise.physics.cutting.feed_limits import feed_intervals
from cutwise.process.edges import edges_alike
from cutwise.process.recipes import quick_outcome
from cutwise.process.stock_contact import contact_at
from cutwise.process.stock_setups import jobs_of, planned_of, stock_of
from cutwise.spec.correct import Correction
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct.ends import missed, told
from cutwise.study.correct.feed import limits_of, prepared, schedule_of, static_before
from cutwise.study.correct.limits import asked
from cutwise.study.correct.loads import NAMES, allowed
from cutwise.study.correct.schedule import planned_time

EXAMPLE = "examples/correct_part.yaml"
FAR = {"x": ["200 mm", "210 mm"], "y": ["200 mm", "210 mm"], "z": ["-20 mm", "-10 mm"]}
START = {"x": "0 mm", "y": "0 mm", "z": "50 mm"}
NONE = Bounds(math.inf, math.inf, math.inf, math.inf, math.inf, 0.0, -math.inf, math.inf, math.inf)


@pytest.fixture(scope="module")
def found():
    return cutwise.correct(load(EXAMPLE))


@pytest.fixture(scope="module")
def ready():
    scenario = load(EXAMPLE)
    return prepared(scenario, scenario.correct)


def test_the_part_is_quicker_under_the_same_force_and_its_surface_stays(found):
    assert found.good, found.reasons
    before, after = ({name: one.value for name, one in run.measures.items()} for run in (found.before, found.after))
    assert after["cycle_time"] < 0.65 * before["cycle_time"]
    assert before["force_xy_peak"] * 0.99 < after["force_xy_peak"] <= 1.01 * before["force_xy_peak"]
    assert after["chip_thickness_max"] <= 1.5 * before["chip_thickness_max"] * (1.0 + 1e-3)
    assert after["plunge_force_max"] == pytest.approx(450.0, abs=0.5)
    heights = [np.asarray(run["stock"]["height"].values) for run in (found.before, found.after)]
    np.testing.assert_allclose(*heights, atol=2e-9)


def test_only_feeds_and_splits_are_new(found):
    """Every line of the program is there in its order with all of its words but F; what is between them are parts of a move."""
    old = found.before.scenario.program.text.split("\n")
    new = iter(found.program.split("\n"))
    for line in old:
        words = [word for word in line.split() if not word.startswith("F")]
        if words[:1] == ["G1"]:  # its end is the last part's
            words = words[1:]
        assert any(set(words) <= set(one.split()) for one in new), line
    path = [run.measures["path_length"].value for run in (found.before, found.after)]
    assert path[0] == pytest.approx(path[1], rel=1e-6)


def test_correcting_twice_moves_the_time_by_less_than_a_percent(found):
    limit = {"correct.limits.force_xy_peak": {"max": f"{found.before.measures['force_xy_peak'].value} N"}}
    limit |= {
        "correct.limits.chip_thickness_max": {"max": f"{1.5e3 * found.before.measures['chip_thickness_max'].value} mm"}
    }
    scenario = load(EXAMPLE, limit)
    program = scenario.program.model_copy(update={"text": found.program})
    again = cutwise.correct(scenario.model_copy(update={"program": program}))
    time = [one.after.measures["cycle_time"].value for one in (found, again)]
    assert time[1] == pytest.approx(time[0], rel=0.01)


def test_without_limits_the_feed_is_that_of_the_machine(ready):
    room = allowed(ready.scenario, ready.path, ready.cells, ready.cutting, {})
    arc = room.each[:, NAMES.index("arc")]
    np.testing.assert_array_equal(room.own, np.minimum(room.each[:, NAMES.index("machine")], arc))
    assert (room.helpless < 0).all()


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("force_xy_peak", (300.0, 400.0, 500.0)), ("cutting_power_max", (1500.0, 1800.0, 2200.0)),
        ("spindle_torque_max", (2.2, 2.6, 3.1)), ("chip_thickness_max", (4e-5, 6e-5, 9e-5)),
        ("removal_rate_max", (5e-7, 8e-7, 2e-6)), ("plunge_force_max", (420.0, 450.0, 480.0)),
    ],
)  # fmt: skip
def test_a_wider_limit_is_never_slower(ready, name, values):
    times = []
    for value in values:
        room = allowed(ready.scenario, ready.path, ready.cells, ready.cutting, {name: value})
        feed = schedule_of(ready, room, np.full(ready.cells.size, math.inf), ready.scenario.correct).feed
        times.append(planned_time(ready.path, ready.cells, ready.bed, feed, ready.scenario.drives))
    assert times[0] > times[1] * (1.0 + 1e-6) > times[2] * (1.0 - 1e-6)


def test_every_tool_has_its_own_teeth_and_speed(ready):
    """A full chip: 3 teeth at 8000 rpm and 2 at 12000 rpm take the same feed; the ball's chip is thinner low on its sphere."""
    room = allowed(ready.scenario, ready.path, ready.cells, ready.cutting, {"chip_thickness_max": 5e-5})
    chip, tool = room.each[:, NAMES.index("chip_thickness_max")], ready.path.tool[ready.cells.block]
    for number, teeth, speed in ((1, 3, 8000.0), (2, 2, 12000.0)):
        cells = (tool == number) & ready.cells.cuts & ~ready.cells.plunges
        fed = chip[cells] * 60.0 / (teeth * speed)
        np.testing.assert_allclose(fed * ready.cutting.chips[cells], 5e-5, rtol=1e-9)
    assert set(ready.cutting.flutes[ready.cells.cuts].tolist()) == {2, 3}


def test_the_cells_come_to_what_the_run_has(ready, found):
    static = static_before(ready)
    for name in ("force_xy_peak", "cutting_power_max", "chip_thickness_max", "plunge_force_max"):
        assert static[name] == pytest.approx(found.before.measures[name].value, rel=0.01)
    limits = limits_of(ready, asked(ready.scenario, ready.scenario.correct, walls=False), static)
    assert limits["plunge_force_max"] == 450.0


def test_a_clearance_leaves_the_feed_before_contact(found):
    assert "G1 Z0 F300\n" in found.program  # the last half millimetre of the plunge in air
    assert "G1 Z0.5 F10159\n" in found.program


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"correct.change": ["speed"]}, "chatter is not looked at in a stock in 3D"),
        ({"correct.objective": "error"}, "error is not there in a stock in 3D"),
        ({"correct.limits": {"wall_error_min": {"min": "-10 um"}}}, "deviation_min"),
        ({"correct.limits": {"tip_deflection_max": {"max": "10 um"}}}, "tool_offset_max"),
        ({"correct.limits": {"chatter_growth_corner": {"max": 1}}}, "chatter is not looked at"),
        ({"numerics.stock.engagement": "coarse"}, "does not tell the peak force"),
        ({"machine": None}, "a machine with feed drives"),
        ({"material": None}, "no force is known"),
    ],
)  # fmt: skip
def test_what_a_stock_in_3d_does_not_have_is_refused_by_name(changes, words):
    with pytest.raises(ScenarioFault, match=words):
        cutwise.correct(load(EXAMPLE, changes))


def test_set_ups_are_corrected_one_by_one():
    one = {"program": "correct_part.nc", "axis": [0, 0, 1]}
    with pytest.raises(ScenarioFault, match="correct a set-up by itself"):
        cutwise.correct(load(EXAMPLE, {"program": None, "setups": [one]}))


@pytest.fixture(scope="module")
def pocket():
    """Limits of the specification's pocket by exact arcs and by maps of two grids, at the middles of its cells."""
    own = {"tool.stiffness": None, "program": {"file": "mill_pocket.nc", "start": START}, "requirements": {}}
    arcs = prepared(load("examples/correct_pocket.yaml", own), Correction(station="1 mm"))
    met = np.flatnonzero(arcs.cells.cuts)
    fed, turns, none = np.full(met.size, 1e-4), arcs.cutting.spindle[met], np.zeros((met.size, 2))
    bounds = NONE._replace(peak=562.174, mean=461.0, power=4000.0, chip=1.5e-4)
    exact = feed_intervals(
        arcs.cells.patches[met], none, arcs.cells.heading[met], fed, turns, arcs.cutting.teeth, np.zeros((2, 2)), bounds
    )
    maps = []
    for grid in ("2 mm", "0.5 mm"):
        scenario = load("examples/correct_pocket.yaml", own | {
            "fixtures": [FAR], "numerics.stock": {"grid": grid, "sweep": "ideal"}, "correct": None,
        })  # fmt: skip
        job, (raw, earlier) = jobs_of(scenario)[0], stock_of(scenario)
        law = edges_alike(scenario.material).linear
        seen = contact_at(scenario, planned_of(job, raw), job, earlier, arcs.cells.way[met], fed, [law])
        place, flutes = np.arange(met.size), np.full(met.size, 3)
        maps.append(intervals_of(seen.loads, seen.rows, seen.sums, place, fed, float(turns[0]), flutes, bounds))
    return exact, maps


@pytest.mark.parametrize("column", [MEAN, POWER, CHIP])
def test_limits_of_a_pocket_are_those_of_the_exact_arcs(pocket, column):
    """All but a few cells on links of 2 mm, where a map sees the tool's own arc less well: a twentieth of what is there."""
    exact, maps = pocket
    there = np.isfinite(exact[0][:, column])
    for one in maps:
        off = np.abs(one[0][there, column] / exact[0][there, column] - 1.0)
        assert np.quantile(off, 0.99) < 1e-5
        assert off.max() < 0.1


def test_the_peak_of_a_pocket_is_that_of_finer_positions(pocket):
    """Exact arcs look at 120 positions of a tooth, maps closer round the largest: no smaller force, and no more than 1 % larger."""
    exact, maps = pocket
    for one in maps:
        ratio = one[2][:, PEAK] / exact[2][:, PEAK]
        assert np.quantile(ratio, 0.01) > 0.9995
        assert np.quantile(ratio, 0.95) < 1.012


def test_a_flute_at_the_depth_of_an_earlier_move_is_no_contact(tmp_path):
    """A plunge to the floor of what was cleared, from heights that round otherwise, has no force and no chip."""
    (tmp_path / "twice.nc").write_text(
        "G21 G90 S8000 M3\nG0 X-10 Y10 Z-4.97\nG1 X50 F1200\nG0 Z5.3\nG0 X20\nG1 Z-4.97 F8000\nG0 Z5\nM2\n",
        encoding="utf-8",
    )
    (tmp_path / "twice.yaml").write_text(
        "process: mill\nprogram: twice.nc\nstock: {x: [0 mm, 40 mm], y: [0 mm, 20 mm], z: [-10 mm, 0 mm]}\n"
        "tools: [{number: 1, shape: flat, diameter: 10 mm, flutes: 3, helix: 30 deg, end_core: 0 mm}]\n"
        "material: {library: al7075t6}\nnumerics: {stock: {grid: 0.5 mm, check: 0}}\n", encoding="utf-8",
    )  # fmt: skip
    measures = quick_outcome(load(tmp_path / "twice.yaml")).measures
    assert measures["chip_thickness_max"] == pytest.approx(5e-5, rel=1e-9)
    assert "plunge_force_max" not in measures


def _one_tool(text, tool, limits):
    """Cells, rooms and feeds of a small program with one tool."""
    document = load(EXAMPLE).document()
    program = {"file": "ends.nc", "text": text, "start": {"x": "0 mm", "y": "0 mm", "z": "50 mm"}}
    tools = [
        {
            "number": 1,
            "shape": "flat",
            "diameter": "10 mm",
            "flutes": 3,
            "helix": "30 deg",
            "flute_length": "20 mm",
            **tool,
        }
    ]
    tools.append(
        {"number": 2, "shape": "ball", "diameter": "6 mm", "flutes": 2, "helix": "30 deg", "flute_length": "12 mm"}
    )
    correct = {"air_clearance": "0.5 mm", "limits": limits}
    one = read_document({**document, "program": program, "tools": tools, "correct": correct}, "ends")
    ready = prepared(one, one.correct)
    static = static_before(ready)
    held = limits_of(ready, asked(one, one.correct, walls=False), static)
    room = allowed(one, ready.path, ready.cells, ready.cutting, held)
    return ready, held, schedule_of(ready, room, np.full(ready.cells.size, math.inf), one.correct)


DOWN = "G21 G17 G90 G94\nT1 M6\nS8000 M3\nG0 X10 Y10 Z5\nG1 Z-4 F300\nG0 Z5\nG0 X20\nG1 X21 Z-4 F300\nG1 X30 F1200\nG0 Z5\nM2\n"


@pytest.mark.parametrize("limits", [{}, {"plunge_force_max": {"max": "900 N"}}])
def test_an_end_without_a_force_goes_down_in_the_stock_no_quicker_than_programmed(limits):
    text = DOWN.replace("M2", "T2 M6\nS9000 M3\nG0 X5 Y5\nG1 Z-1 F200\nG0 Z5\nM2") if limits else DOWN
    ready, _, done = _one_tool(text, {}, limits)
    line = ready.path.source[ready.cells.block]
    height = ready.path.curve.start[ready.cells.block, 2] + ready.path.curve.along[ready.cells.block, 2] * (
        ready.cells.begin + ready.cells.length
    )
    for number in (5, 8):
        inside = (line == number) & (height < -1e-9)
        assert inside.sum() >= 16
        assert (done.feed[inside] <= 0.005 * (1 + 1e-9)).all()
    assert done.feed[line == 5].max() > 0.1  # above the stock it is quick


def test_a_ramp_pushes_no_harder_than_a_plunge_may():
    limits = {"plunge_force_max": {"max": "440 N"}, "force_xy_peak": {"max": "900 N"}}
    ready, held, done = _one_tool(DOWN, {"end_core": "0 mm"}, limits)
    force = ready.cutting.plunge_forces(np.where(np.isfinite(done.feed), done.feed, 0.0))
    ramp = ready.cutting.sinks & (ready.path.source[ready.cells.block] == 8)
    assert 425.0 < force[ramp].max() <= 440.0 * (1 + 1e-9)
    assert not list(missed(ready, done.feed, held))
    assert "line 8" in next(missed(ready, np.where(ramp, 4.0, 1.0) * done.feed, held))


def test_a_force_up_that_nothing_holds_is_told():
    ready, held, _ = _one_tool(DOWN, {"end_core": "0 mm"}, {})
    slow = np.where(np.isfinite(ready.path.feed[ready.cells.block]), 0.005, 0.0)
    assert "rises from 430.6 N to 588.9 N" in next(told(ready, slow, 6.0 * slow, held))  # 3 (K_rc f + K_re) R
    assert not list(told(ready, slow, slow, held))
