"""Several set-ups: volumes, contact and deviation against plain points of the block, and an earlier run as stock."""

import json
import math

import numpy as np
import pytest

from cutwise.io.scenario import parse
from cutwise.maths import profiles
from cutwise.maths.workpiece import Frame, frame_of, under
from cutwise.physics.engagement.map_contact import Edge, contact_rows
from cutwise.physics.engagement.map_fan import fan_room
from cutwise.physics.engagement.map_rim import Place
from cutwise.physics.surface.map_deviation import deviations, shaped_by
from cutwise.process import stock_deviation, stock_measures, stock_setups, stock_stages, stock_stations
from cutwise.process.recipes import prepare, simulate
from cutwise.spec.faults import ScenarioFault
from peers.maps import MM

SLOT = "G21 G90 T1 M6 S8000 M3\nG0 X-10 Y10 Z5\nG1 Z-10 F600\nG1 X30\nG0 Z20\n"
BELOW = "G21 G90 T1 M6 S8000 M3\nG0 X-10 Y8 Z5\nG1 Z-12 F600\nG1 X30\nG0 Z20\n"
TOOL = "{number: 1, shape: flat, diameter: 6 mm, flutes: 2, helix: 30 deg}"
NUMERICS = "{grid: 0.2 mm, check: 300, station: 0.5 mm}"
COARSE = "{grid: 0.5 mm, check: 300, station: 5 mm, elements: 4}"  # for volumes, which a grid has exactly where walls lie on it
BLOCK = "{x: [0 mm, 20 mm], y: [0 mm, 20 mm], z: [-20 mm, 0 mm]}"


def two(second, where, stock=BLOCK, first=SLOT, more="", numerics=NUMERICS):
    """The slot from above, then another program along an axis."""
    return parse(
        f"process: mill\nstock: {stock}\ntools: [{TOOL}]\nnumerics: {{stock: {numerics}}}\nsetups:\n"
        f"  - {{program: {{file: a.nc, text: {json.dumps(first)}}}}}\n"
        f"  - {{program: {{file: b.nc, text: {json.dumps(second)}}}, {where}}}\n{more}"
    )


def left_of_points(done, point):
    """Whether points of the part are left after each set-up: outside of what the tool sweeps, line by line."""
    there = np.ones(len(point), bool)
    for job, cut in zip(done.jobs, done.cuts, strict=True):
        q, moves = (point - job.frame.zero) @ job.frame.axes, cut.ideal.moves
        radius = cut.ideal.planned.tools.cutting.radius[0]
        for a, b in zip(moves.start, moves.end, strict=True):
            d = b - a
            flat = float(d[:2] @ d[:2])
            s = np.clip((q[:, :2] - a[:2]) @ d[:2] / flat, 0.0, 1.0) if flat > 0.0 else np.zeros(len(q))
            z = a[2] + s * d[2] if flat > 0.0 else min(a[2], b[2])
            there &= (((q[:, :2] - a[:2] - s[:, None] * d[:2]) ** 2).sum(axis=1) > radius**2) | (q[:, 2] < z)
        yield there.copy()


def test_worked_example_g():
    """A slot along x, then one along x from the side: 1200 and 940 mm^3."""
    done = stock_setups.run(two(BELOW, "axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]", numerics=COARSE))
    assert [1e9 * cut.ideal.volume.sum() for cut in done.cuts] == pytest.approx([1200, 940], rel=1e-6)
    found = stock_measures.measures(done, None)
    assert 1e9 * found["removed_volume"] == pytest.approx(2140, rel=1e-6)
    assert found["cycle_time"] == pytest.approx(sum(cut.ideal.planned.block_time[-1] for cut in done.cuts))


def test_worked_example_g_contact():
    """The element 2 above the tip touches one arc of 48.189685 degrees, the one 7 above 180."""
    done = stock_setups.run(two(BELOW, "axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]", more="requirements: {}"))
    again = stock_setups.run(two(BELOW.replace("G1 X30", "G1 X-9"), "axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]"))
    first, second = done.cuts[0].ideal.solid, again.cuts[1].ideal.solid
    frames = [again.jobs[1].frame, again.jobs[0].frame]
    piece = under([second, first], frames, frames[0])
    rows = np.zeros((50, 5))
    arcs = {}
    for height in (2 * MM, 7 * MM):
        mer = profiles.meridian(profiles.flat(3 * MM), 0.0, 1)._replace(
            height=np.array([height]), radius=np.array([3 * MM]), sine=np.array([1.0]), cosine=np.array([0.0])
        )
        place = Place(10 * MM, 8 * MM, -12 * MM, 1.0, 0.0, 0.0, 3, 3, 0.5, 3)
        count = contact_rows(piece, place, Edge(mer, 3 * MM, 0.0, 0.0), fan_room(), rows, True)
        arcs[height] = np.degrees(rows[:count, 2] - rows[:count, 1]).tolist()
    assert arcs[2 * MM] == pytest.approx([48.189685], abs=1e-4)
    assert arcs[7 * MM] == pytest.approx([180.0], abs=1e-4)


def test_three_set_ups_leave_what_plain_points_say():
    """From above, from the side and from below, askew by no map: two earlier maps are asked."""
    heads = ("", ", axis: [1, 0, 0], zero: [20 mm, 10 mm, -10 mm]", ", axis: [0, 0, -1], zero: [0 mm, 20 mm, -20 mm]")
    texts = (SLOT, *(f"G21 G90 T1 M6 S8000 M3\n{text}\nG0 Z40\n" for text in (
        "G0 X-20 Y0 Z25\nG1 Z-4 F600\nG1 X20 Y3", "G0 X-5 Y5 Z5\nG1 Z-12 F600\nG1 X30 Y12",
    )))  # fmt: skip
    setups = "".join(
        f"  - {{program: {{file: a.nc, text: {json.dumps(text)}}}{where}}}\n"
        for text, where in zip(texts, heads, strict=True)
    )
    given = f"process: mill\nstock: {BLOCK}\ntools: [{TOOL}]\nnumerics: {{stock: {{grid: 0.5 mm}}}}\nsetups:\n{setups}"
    done = stock_setups.run(parse(given))
    point = MM * (np.array([0, 0, -20]) + 20 * np.random.default_rng(1).random((200_000, 3)))
    left = np.array([np.ones(len(point), bool), *left_of_points(done, point)])
    told = [1e9 * cut.ideal.volume.sum() for cut in done.cuts]
    assert told == pytest.approx(8000 * (left[:-1] & ~left[1:]).mean(axis=1), rel=0.02)
    solids = done.solids(0.5 * MM, True)
    shaped = shaped_by(under([s.solid for s in solids], [s.frame for s in solids], Frame(np.eye(3), np.zeros(3))))
    value, owner = np.empty(2000), np.empty(2000, np.int64)
    some = np.ascontiguousarray(point[:2000])
    deviations(shaped, some, np.tile([0.0, 0.0, 1.0], (2000, 1)), 1e-5, value, owner)
    assert not (((value > 0) != left[-1][:2000]) & (np.abs(value) > 0.3 * MM)).any()


@pytest.mark.parametrize(
    ("where", "second", "tolerance"),
    [
        ("axis: [0, 0, -1], zero: [0 mm, 20 mm, -20 mm]", "G0 X-5 Y5 Z5\nG1 Z-12 F600\nG1 X30 Y12", 0.02),
        ("axis: [1, 0, 0], zero: [20 mm, 10 mm, -10 mm]", "G0 X-20 Y0 Z25\nG1 Z-4 F600\nG1 X20 Y3", 0.02),
        ("zero: [10 mm, 10 mm, -1 mm], rotation: 30 deg", "G0 X-20 Y0 Z25\nG1 Z-4 F600\nG1 X20 Y3", 0.02),
        ("axis: [0, 1, 1], zero: [10 mm, 15 mm, 0 mm], rotation: 20 deg", "G0 X-20 Y0 Z25\nG1 Z-3 F600\nG1 X20 Y2", 0.03),
    ],
)  # fmt: skip
def test_volumes_contact_and_surface_are_those_of_plain_points(where, second, tolerance):
    done = stock_setups.run(two(f"G21 G90 T1 M6 S8000 M3\n{second}\nG0 Z40\n", where))
    draw = np.random.default_rng(3)
    point = MM * (np.array([0, 0, -20]) + 20 * draw.random((300_000, 3)))
    once, both = left_of_points(done, point)
    volume = 8000 * np.array([(~once).mean(), (once & ~both).mean()])
    told = np.array([1e9 * cut.ideal.volume.sum() for cut in done.cuts])
    assert told == pytest.approx(volume, rel=tolerance)
    run = done.cuts[1].ideal
    rate, place, move = run.stations("removal"), stock_stations.station_places(run), stock_stations.station_moves(run)
    step = np.linalg.norm(np.diff(place, axis=0), axis=1) * (np.diff(move) == 0)
    assert 1e9 * (0.5 * (rate[1:] + rate[:-1]) * step).sum() == pytest.approx(told[1], rel=0.03)
    solids = done.solids(0.2 * MM, True)
    shaped = shaped_by(under([s.solid for s in solids], [s.frame for s in solids], Frame(np.eye(3), np.zeros(3))))
    value, owner = np.empty(2000), np.empty(2000, np.int64)
    some = np.ascontiguousarray(point[:2000])
    deviations(shaped, some, np.tile([0.0, 0.0, 1.0], (2000, 1)), 1e-5, value, owner)
    wrong = ((value > 0) != both[:2000]) & (np.abs(value) > 0.3 * MM)  # a stock askew has an outline to half a cell
    assert not wrong.any()


def test_the_order_of_set_ups_changes_no_surface():
    one = stock_setups.run(two(BELOW, "axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]", numerics=COARSE))
    text = (
        f"process: mill\nstock: {BLOCK}\ntools: [{TOOL}]\nnumerics: {{stock: {COARSE}}}\nsetups:\n"
        f"  - {{program: {{file: b.nc, text: {json.dumps(BELOW)}}}, axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]}}\n"
        f"  - {{program: {{file: a.nc, text: {json.dumps(SLOT)}}}}}\n"
    )
    other = stock_setups.run(parse(text))
    whole = [sum(cut.ideal.volume.sum() for cut in done.cuts) for done in (one, other)]
    assert whole[0] == pytest.approx(whole[1], rel=1e-6)


def test_frames():
    assert frame_of(np.array([0, 0, 1.0]), np.zeros(3), 0.0).axes == pytest.approx(np.eye(3))
    along_x = frame_of(np.array([3.0, 0, 0]), np.zeros(3), 0.0).axes
    assert along_x[:, 0] == pytest.approx([0, 1, 0])
    turned = frame_of(np.array([0, 0, 1.0]), np.zeros(3), math.pi / 2).axes
    assert turned[:, 0] == pytest.approx([0, 1, 0])
    for axis in ((1.0, 2.0, 3.0), (0.0, -1.0, 0.2)):
        axes = frame_of(np.array(axis), np.zeros(3), 0.7).axes
        assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(axes) == pytest.approx(1.0)


def one(stock, program, more=""):
    return parse(
        f"process: mill\nstock: {stock}\ntools: [{TOOL}]\nnumerics: {{stock: {COARSE}}}\n"
        f"program: {{file: a.nc, text: {json.dumps(program)}}}\n{more}"
    )


def test_a_run_goes_on_from_what_an_earlier_one_has_left(tmp_path):
    simulate(one(BLOCK, SLOT)).save(tmp_path / "run.nc")
    across = SLOT.replace("X-10 Y10", "X10 Y-10").replace("Z-10", "Z-12").replace("X30", "Y30")
    for stock in (tmp_path, tmp_path / "run.nc"):
        found = simulate(one(f"{{run: {stock}}}", across))
        assert 1e9 * found.measures["removed_volume"].value == pytest.approx(6 * 20 * 12 - 36 * 10, rel=1e-5)
        assert "earlier run" in found.notes
    again = simulate(one(f"{{run: {tmp_path}}}", SLOT))
    assert again.measures["removed_volume"].value == 0.0
    found.save(tmp_path / "second.nc")
    third = simulate(
        two(
            BELOW,
            "axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]",
            f"{{run: {tmp_path / 'second.nc'}}}",
            across,
            numerics=COARSE,
        )
    )
    assert 1e9 * third.measures["removed_volume"].value == pytest.approx(1440 - 500 - 432 + 150, rel=1e-5)


def test_stages_of_set_ups_follow_one_another():
    given = two(BELOW, "axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]", numerics=COARSE)
    done = stock_setups.run(given)
    tree = stock_stages.stages(done, stock_deviation.judged(given, done))
    assert {"stock", "stock_2", "sweep_1", "sweep_2"} <= set(tree.children)
    assert set(tree["lines"]["setup"].values.tolist()) == {1, 2}
    assert (np.diff(tree["motion"]["time"].values) >= -1e-12).all()


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ("axis: [0, 0, 0]", "axis: is zero"),
        ("tools: [{number: 2, shape: flat, diameter: 6 mm, flutes: 2, helix: 0 deg}]", "the program calls T1"),
        ("fixtures: [{file: none.stl}]", "none.stl: no such file"),
        ("turn: 3", "unknown key"),
    ],
)
def test_set_ups_that_cannot_be(where, words):
    with pytest.raises(ScenarioFault, match=words.replace("[", "\\[")):
        prepare(two(BELOW, where))


@pytest.mark.parametrize(("content", "words"), [(None, "no such file"), (b"nothing", "is no run file")])
def test_runs_that_are_none(tmp_path, content, words):
    if content is not None:
        (tmp_path / "run.nc").write_bytes(content)
    with pytest.raises(ScenarioFault, match=words):
        prepare(one(f"{{run: {tmp_path / 'run.nc'}}}", SLOT))
