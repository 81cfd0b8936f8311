"""Feeds of a pocket under limits: figures of an independent reference program, and laws that any schedule keeps."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.physics.cutting.affine_limits import CHIP, MEAN, PEAK, POWER, WALL
from cutwise.physics.engagement.stock import removal_area
from cutwise.process.milling import run
from cutwise.spec.correct import Correction
from cutwise.study.correct.feed import prepared, proposed, speeds_of, static_before
from cutwise.study.correct.loads import allowed, binding, values_at
from cutwise.study.correct.schedule import planned_time
from cutwise.study.correct.schedule import scheduled as schedule

FORCE, WALL_NOW = 562.1743, -8.2248e-6
SCENARIO = """process: mill
program: {{file: pocket.nc, start: {{x: 50 mm, y: 26 mm, z: -5 mm}}}}
stock: {{x: [-30 mm, 130 mm], y: [-30 mm, 90 mm], z: [-20 mm, 0 mm]}}
tool: {{diameter: 20 mm, flutes: 3, helix: 30 deg, flute_length: 40 mm, stiffness: 20 N/um}}
material: {{library: al7075t6}}
machine: {{library: fadal2216}}
numerics: {{discs: 20, settling_time: 0.02 s, substeps: 4}}
operation: {{spindle_speed: {speed} rpm}}
"""


def pocket(folder, speed=8000):
    """The passes of the pocket of the examples without its plunge: 870.2124 mm from rest to rest."""
    examples = next(p for p in [folder, *folder.parents] if (p / "examples").is_dir()) / "examples"
    text = (examples / "mill_pocket.nc").read_text(encoding="utf-8")
    text = text.replace("G0 X50 Y26 Z5\nG1 Z-5 F300\nF2400", "G1 F2400").replace("G0 Z5\n", "")
    return text, SCENARIO.format(speed=speed)


@pytest.fixture(scope="module")
def made(tmp_path_factory, request):
    folder = tmp_path_factory.mktemp("pocket")

    def scenario(speed=8000, **overrides):
        text, said = pocket(request.path.parent, speed)
        (folder / "pocket.nc").write_text(text, encoding="utf-8")
        (folder / "pocket.yaml").write_text(said, encoding="utf-8")
        return load(folder / "pocket.yaml", overrides)

    return scenario


def scheduled(scenario, limits, **said):
    given = Correction(**said)
    ready = prepared(scenario, given)
    room = allowed(scenario, ready.path, ready.cells, ready.cutting, {"chip_thickness_max": 1.5e-4, **limits})
    done, new = proposed(ready, room, np.full(ready.cells.size, math.inf), given)
    return ready, room, done, new, planned_time(ready.path, ready.cells, ready.bed, done.feed, scenario.drives)


def test_the_run_before_is_that_of_the_reference(made):
    scenario = made()
    ready = prepared(scenario, Correction())
    assert ready.path.curve.knots[-1] == pytest.approx(0.8702124, abs=1e-7)
    area = float((ready.cells.length * removal_area(ready.cells.patches, 10e-3)).sum())
    assert area / 5e-3 == pytest.approx(5492.74e-6, abs=0.01e-6)
    values = values_at(ready.cells, ready.cutting, speeds_of(ready))
    assert values[:, PEAK].max() == pytest.approx(562.174, abs=5e-4)
    assert values[0, MEAN] == pytest.approx(461.03, abs=0.05)  # the slot
    assert values[0, POWER] == pytest.approx(4808.5, abs=0.1)
    assert np.nanmin(values[:, WALL]) == pytest.approx(-8.2248e-6, abs=1e-10)
    last = np.flatnonzero(np.isfinite(values[:, WALL]))
    assert ready.cells.length[last].sum() == pytest.approx(0.2314, abs=5e-4)  # pass 5 and no other
    assert values[:, CHIP].max() == pytest.approx(1e-4)
    assert planned_time(
        ready.path, ready.cells, ready.bed, ready.path.feed[ready.cells.block], scenario.drives
    ) == pytest.approx(21.8119, abs=1e-4)


@pytest.mark.parametrize(
    ("speed", "limits", "bare", "time", "blocks"),
    [
        (8000, {"force_xy_peak": FORCE, "wall_error_min": WALL_NOW}, 18.148, 18.862, 186),
        (9700, {"force_xy_peak": FORCE, "wall_error_min": WALL_NOW}, 15.040, 15.724, 183),
        (8000, {"force_xy_peak": FORCE, "wall_error_min": -10e-6}, 16.788, 17.572, 228),
        (8000, {"force_xy_peak": 600.0, "wall_error_min": -10e-6}, 15.326, 16.140, 228),
    ],
)
def test_schedules_of_the_reference(made, speed, limits, bare, time, blocks):
    ready, room, done, _, planned = scheduled(made(speed), limits)
    assert float((ready.cells.length / room.own).sum()) == pytest.approx(bare, rel=1e-3)
    assert planned == pytest.approx(time, rel=5e-3)
    assert done.blocks == pytest.approx(blocks, rel=0.08)
    assert done.bound < planned


def test_what_binds_and_the_bound_are_those_of_the_reference(made):
    ready, room, done, _, _ = scheduled(made(), {"force_xy_peak": FORCE, "wall_error_min": WALL_NOW})
    which = binding(room.each)
    lengths = [1e3 * float(ready.cells.length[which == k].sum()) for k in range(room.each.shape[1])]
    force, _, _, _, chip, wall, _, _, _, arc, machine = lengths
    assert (force, wall, arc + machine) == pytest.approx((605, 215, 45), rel=0.03)
    assert chip == pytest.approx(5, abs=0.5)
    assert done.bound == pytest.approx(18.332, rel=5e-3)  # the last arc, in air, keeps its feed here


@pytest.mark.parametrize(("gain", "time", "blocks"), [(1e-4, 18.770, 384), (3e-3, 18.964, 135), (1e-2, 19.140, 99)])
def test_further_blocks_have_to_gain_their_time(made, gain, time, blocks):
    *_, done, _, planned = scheduled(
        made(), {"force_xy_peak": FORCE, "wall_error_min": WALL_NOW}, split_gain=f"{gain} s"
    )
    assert planned == pytest.approx(time, rel=5e-3)
    assert done.blocks == pytest.approx(blocks, rel=0.03)


@pytest.mark.parametrize(("station", "time"), [(0.5e-3, 18.912), (0.1e-3, 18.818)])
def test_smaller_cells_gain_little(made, station, time):
    *_, planned = scheduled(made(), {"force_xy_peak": FORCE, "wall_error_min": WALL_NOW}, station=f"{station} m")
    assert planned == pytest.approx(time, rel=5e-3)


def test_every_cell_keeps_its_limits_at_the_feeds_that_are_written(made):
    limits = {"force_xy_peak": FORCE, "wall_error_min": WALL_NOW}
    scenario = made()
    *_, new, _ = scheduled(scenario, limits)
    again = prepared(new, Correction())
    values = values_at(again.cells, again.cutting, speeds_of(again))
    assert values[:, PEAK].max() <= FORCE * (1 + 1e-5)
    assert np.nanmin(values[:, WALL]) >= WALL_NOW * (1 + 1e-3)  # places of cells are those of shorter blocks now
    assert values[:, CHIP].max() <= 1.5e-4 * (1 + 1e-6)
    assert static_before(again)["force_xy_peak"] >= 0.998 * FORCE  # and it is used


def test_without_limits_the_feed_is_that_of_the_machine(made):
    ready, _, done, _, _ = scheduled(made(), {"chip_thickness_max": math.inf})
    straight = ready.path.curve.straight[ready.cells.block]
    assert done.feed[straight].max() == pytest.approx(169.333e-3, rel=2e-4)
    assert np.median(done.feed[straight]) > 0.1


def test_a_wider_limit_is_never_slower(made):
    times = []
    for force in (450.0, 520.0, 562.17, 620.0, 800.0):
        *_, planned = scheduled(made(), {"force_xy_peak": force, "wall_error_min": -10e-6})
        times.append(planned)
    assert times == sorted(times, reverse=True)


def test_the_wall_that_no_feed_changes_is_the_edge_forces_share(made):
    ready = prepared(made(), Correction())
    zero = values_at(ready.cells, ready.cutting, np.zeros(ready.cells.size))
    wall = np.isfinite(zero[:, WALL])
    assert np.nanmin(zero[:, WALL]) == pytest.approx(-7.1756e-6, abs=1e-10)
    room = allowed(made(), ready.path, ready.cells, ready.cutting, {"wall_error_min": -7e-6})
    assert (room.helpless[wall] == 5).mean() > 0.9  # all of pass 5 but where it begins


def test_correcting_twice_moves_the_time_by_less_than_a_percent(made):
    first = cutwise.correct(made(**{"numerics.settling_time": "1 s"}))
    assert first.good
    assert first.measures["time_after"].value < 0.875 * first.measures["time_before"].value
    second = cutwise.correct(first.scenario)
    assert second.measures["time_after"].value == pytest.approx(first.measures["time_after"].value, rel=0.01)
    for name in ("force_xy_peak", "wall_error_min"):
        before, after = (first.measures[f"{name}_{end}"].value for end in ("before", "after"))
        assert abs(after) <= 1.01 * abs(before)


SIDE = """process: mill
program: side.nc
stock: {x: [0 mm, 30 mm], y: [-10 mm, 40 mm], z: [-20 mm, 0 mm]}
tool: {diameter: 12 mm, flutes: 2, helix: 0 deg, flute_length: 30 mm}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
correct: {limits: {force_xy_peak: {max: 260 N}}}
"""


def test_what_a_cutting_block_runs_in_air_keeps_its_feed_and_thin_chips_are_told(tmp_path):
    text = "G21 G90 G94 S6000 M3\nG0 X-12 Y-12 Z5\nG0 Z-3\nG1 X42 F600\nG0 Z5\nM2\n"
    (tmp_path / "side.nc").write_text(text, encoding="utf-8")
    (tmp_path / "side.yaml").write_text(SIDE, encoding="utf-8")
    found = cutwise.correct(load(tmp_path / "side.yaml", {"correct.limits.chip_thickness_min": {"min": "90 um"}}))
    told = [one for one in found.told if one.startswith("chips stay thinner than chip_thickness_min 90")]
    assert len(told) == 1
    ready = prepared(found.scenario, Correction())
    speed, air = speeds_of(ready), ~ready.cells.cuts & ~ready.bed.rapid
    assert air.any()
    assert speed[air].max() <= 0.01 + 1e-9  # an approach at the machine's speed is for air_clearance to allow
    assert speed[ready.cells.cuts].max() > 0.01


def test_a_peak_over_that_of_the_programmed_feed_is_the_overshoot_of_the_drives(tmp_path):
    """A reference program of drives, arcs and flutes: 224.30 N at 10 mm/s and 247.972 N at the 12.087 mm/s of the start."""
    text = "G21 G90 G94 S6000 M3\nG0 X-7 Y0 Z5\nG0 Z-3\nG1 X8 F600\nG1 Y4\nM2\n"
    (tmp_path / "side.nc").write_text(text, encoding="utf-8")
    (tmp_path / "side.yaml").write_text(SIDE.replace("x: [0 mm, 30 mm]", "x: [0 mm, 60 mm]"), encoding="utf-8")
    scenario = load(tmp_path / "side.yaml", {"numerics.settling_time": "0.05 s"})
    assert static_before(prepared(scenario, Correction()))["force_xy_peak"] == pytest.approx(224.30, abs=0.01)
    done = run(scenario, scenario.numerics.substeps)
    row = int(np.argmax(done.history.force_peak[:, 3]))
    assert done.history.force_peak[row, 3] == pytest.approx(247.971790683, abs=1e-6)
    assert np.hypot(*done.history.speed[row]) == pytest.approx(12.0874301e-3, abs=1e-9)
    assert done.reference.speed[row] == pytest.approx(10e-3)
    found = cutwise.correct(scenario.model_copy(update={"correct": Correction(split_gain="10 s")}))
    assert any("at line 5" in one and "the drives run" in one and "10 mm/s are told" in one for one in found.told)


LOOP = ["G1 X70", "G3 X74 Y30 J4", "G3 X70 Y34 I-4", "G1 X30", "G3 X26 Y30 J-4", "G3 X30 Y26 I4", "G1 X50"]


def trochoid(step):
    """Circles of 4 mm along a slot of 28 mm from the first, a full slot, on."""
    at = [min(30 + k * step, 70) for k in range(1, math.ceil(40 / step - 1e-9) + 1)]
    return ["G3 X30 Y26 I0 J4", *(line for x in at for line in (f"G1 X{x}", f"G3 X{x} Y26 I0 J4"))]


@pytest.mark.parametrize(
    ("lines", "start", "depth", "force", "time"),
    [
        (LOOP, 50, 5, FORCE, 2.47), (trochoid(2), 30, 5, FORCE, 9.6), (trochoid(3), 30, 5, FORCE, 7.5),
        (LOOP, 50, 15, 1000.0, 5.22), (trochoid(3), 30, 15, 1000.0, 11.8),
    ],
)  # fmt: skip
def test_a_slot_by_contour_and_by_circles_takes_the_times_of_the_reference(tmp_path, lines, start, depth, force, time):
    """Scheduled under the force, chips up to 0.15 mm, air as quick as arcs allow: the contour is quicker, also 15 deep in one."""
    (tmp_path / "slot.nc").write_text("\n".join(["G21 G90 G61", "G1 F2400", *lines, "M2", ""]), encoding="utf-8")
    said = SCENARIO.format(speed=8000).replace("pocket.nc, start: {x: 50 mm, y: 26 mm, z: -5 mm}", "slot.nc")
    said = said.replace("{file: slot.nc}", f"{{file: slot.nc, start: {{x: {start} mm, y: 26 mm, z: -{depth} mm}}}}")
    (tmp_path / "slot.yaml").write_text(said, encoding="utf-8")
    scenario, given = load(tmp_path / "slot.yaml"), Correction()
    ready = prepared(scenario, given)
    limits = {"force_xy_peak": force, "chip_thickness_max": 1.5e-4}
    room = allowed(scenario, ready.path, ready.cells, ready.cutting, limits)
    done = schedule(ready.path, ready.cells, ready.bed, room.own, scenario.drives, given, False)
    planned = planned_time(ready.path, ready.cells, ready.bed, done.feed, scenario.drives)
    assert planned == pytest.approx(time, rel=0.01)
