"""Programs in a stock in 3D: the part of the worked example d, events, and how it agrees with the exact arcs."""

import json
import math
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cutwise.io.scenario import load, parse
from cutwise.io.solid_files import closed
from cutwise.io.stl import stl_bytes
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import contact_patches, immersion
from cutwise.process import stock_deviation, stock_findings, stock_measures, stock_setups, stock_stations
from cutwise.process.recipes import prepare, simulate
from cutwise.process.stock_loop import PIECES, STATION
from cutwise.process.stock_milling import all_contact
from cutwise.process.stock_moves import stock_of
from cutwise.results import SolverFailure, in_words
from cutwise.spec.faults import ScenarioFault

EXAMPLES = Path(__file__).parents[3] / "examples"
PART = EXAMPLES / "mill_part.yaml"

HEAD = """process: mill
stock: {x: [0 mm, 40 mm], y: [-10 mm, 10 mm], z: [-20 mm, 0 mm]}
"""
FLAT = "{number: 1, shape: flat, diameter: 6 mm, flutes: 2, helix: 30 deg, flute_length: 6 mm, shank_diameter: 8 mm}"


def scenario(program: str, tools: str = FLAT, more: str = "", head: str = HEAD):
    text = f"{head}tools: [{tools}]\n{more}\nprogram: {{file: test.nc, text: {json.dumps(program)}}}\n"
    return parse(text, overrides={"numerics.stock.check": 0})


def box(x, y, z):
    """Triangles of a box in mm [m]."""
    x, y, z = (1e-3 * np.array(side, float) for side in (x, y, z))
    point, triangle, _ = closed(x, y, np.full((2, 2), z[1]), np.full((2, 2), z[0]), np.ones((1, 1), bool))
    return point[triangle]


def planned_run(given):
    """The one set-up of a scenario, its path swept as planned."""
    return stock_setups.run(given).cuts[0].ideal


def told(given, off=None):
    return " | ".join(in_words(stock_findings.warnings(given, stock_setups.run(given), off)))


def ran(*arguments, **named):
    given = scenario(*arguments, **named)
    return given, planned_run(given)


@cache
def part_d(*overrides):
    given = load(PART, ("numerics.stock.engagement=none", "part.samples=1000000", "requirements={}", *overrides))
    done = stock_setups.run(given)
    return given, done, stock_deviation.judged(given, done)


FACES = {  # area, min, max, mean, rms, gouge, excess; mm
    "slope": (851.3422, -0.046985, 0.010435, 0.0017620, 0.0089148, 1.32735, 2.82741),
    "floor": (1398.9381, 0.0, 0.03, 0.0299657, 0.0299772, 0.0, 41.92010),
    "wall": (502.6548, -0.02, 0.03, -0.0198750, 0.0199792, 10.01288, 0.02262),
    "top": (201.0619, -0.02, 0.0, -0.0000500, 0.000816, 0.01004, 0.0),
}


@pytest.mark.parametrize("name", FACES)
def test_worked_example_d_face_by_face(name):
    off = part_d()[2].left
    area, least, most, mean, rms, gouge, excess = FACES[name]
    face = min(off.faces, key=lambda one: abs(1e6 * one.area - area))
    assert 1e6 * face.area == pytest.approx(area, rel=1e-6)
    rough = {"slope": 2e-5, "floor": 1e-3, "wall": 2e-4, "top": 2e-3}[name]  # extremes: of the samples, not of the face
    assert 1e3 * face.least == pytest.approx(least, abs=rough)
    assert 1e3 * face.most == pytest.approx(most, abs=2e-5 if name != "wall" else 2e-4)
    share = 0.1 if name == "top" else 2e-3
    assert 1e3 * face.mean == pytest.approx(mean, rel=share)
    assert 1e3 * face.rms == pytest.approx(rms, rel=share)
    assert 1e9 * face.gouge == pytest.approx(gouge, rel=share, abs=1e-9)
    assert 1e9 * face.excess == pytest.approx(excess, rel=0.06 if name == "wall" else share, abs=1e-9)


def test_worked_example_d_together():
    _, done, both = part_d()
    off = both.left
    found = stock_measures.measures(done, both)
    assert 1e3 * found["deviation_min"] == pytest.approx(-0.046985, abs=2e-5)
    assert 1e3 * found["deviation_max"] == pytest.approx(0.03, abs=1e-6)
    assert 1e3 * found["deviation_rms"] == pytest.approx(0.0227253, rel=2e-3)
    assert 1e9 * found["gouge_volume"] == pytest.approx(11.35028, rel=2e-3)
    assert 1e9 * found["excess_volume"] == pytest.approx(44.77013, rel=2e-3)
    assert 1e3 * found["scallop_max"] == pytest.approx(0.01041, rel=0.01)
    assert 1e9 * found["removed_volume"] == pytest.approx(24867.7333, rel=5e-4)
    assert found["fraction_in_tolerance"] == 1.0
    worst = stock_findings.made_by(off, off.worst(True))
    assert "line 162" in worst  # the pass that was lowered
    assert "T2" in worst


def test_a_tolerance_of_the_part_is_a_requirement():
    for tolerance, verdict in (("50 um", "pass"), ("40 um", "fail")):
        coarse = ("numerics.stock={engagement: none, grid: 0.4 mm, check: 0}", "part.samples=20000", "requirements={}")
        result = simulate(load(PART, (*coarse, f"part.tolerance={tolerance}")))
        assert result.verdict == verdict
        assert {check.measure for check in result.checks} == {"deviation_min", "deviation_max"}
    written = "requirements={deviation_min: {min: -60 um}}"
    own = simulate(load(PART, (*coarse[:2], "part.tolerance=40 um", written)))
    assert own.verdict == "pass"  # the written one wins


@pytest.mark.parametrize("shift", [(0.05, -0.08, 0.03), (0.1, 0.0, 0.0)])
def test_a_misplaced_part_is_told(shift):
    given, _, off = part_d()
    plain = off.left.fit.shift
    moved = part_d("part.origin=[" + ", ".join(f"{v} mm" for v in shift) + "]")[2]
    change = moved.left.fit.shift - plain
    assert 1e3 * change == pytest.approx(-np.array(shift), abs=0.03 * np.linalg.norm(shift))
    assert any("offset" in text for text in in_words(stock_findings.warnings(given, part_d()[1], moved)))


def test_the_deviation_does_not_depend_on_the_grid():
    one, other = (part_d(f"numerics.stock.grid={grid} mm", "part.samples=20000")[2].left for grid in ("0.43", "0.27"))
    assert one.value[one.judged_samples] == pytest.approx(other.value[other.judged_samples], abs=1e-9)


def test_flat_mills_at_levels_agree_with_the_exact_arcs():
    """The pocket of the example: volume of the arcs 29034.29 less the plunge that they leave out; arcs to 0.001 degrees."""
    pocket = EXAMPLES / "mill_pocket_stock.yaml"
    exact = load(pocket, {"path_mode": "exact_path"})
    box = exact.stock
    sides = ", ".join(
        f"{a}: [{1e3 * low} mm, {1e3 * high} mm]" for a, (low, high) in zip("xyz", (box.x, box.y, box.z), strict=True)
    )
    tools = "{number: 1, shape: flat, diameter: 20 mm, flutes: 3, helix: 30 deg, end_core: 0 mm}"
    given = scenario(
        exact.program.text, tools, "numerics: {stock: {grid: 0.25 mm}}", f"process: mill\nstock: {{{sides}}}\n"
    )
    done = planned_run(given)
    assert 1e9 * done.volume.sum() == pytest.approx(29034.29, rel=1e-3)
    level = ~stock_measures.plunging(done) & (done.stations("contact") > 0)
    segment = done.run.segment[level]
    share = done.stations("share")[level]
    curve = done.planned.path.curve
    block = done.moves.block[segment]
    way = curve.knots[block] + share * curve.length[block]
    point = stock_stations.station_places(done)[level]
    row = done.moves.path.row[segment]
    angle = row[:, 13] + share * row[:, 14] + np.copysign(math.pi / 2, row[:, 14])
    heading = np.where(row[:, 0] == 0.0, np.arctan2(row[:, 6], row[:, 5]), angle)
    inner = (share > 1e-3) & (share < 1 - 1e-3)
    told = immersion(contact_patches(point[inner], heading[inner], way[inner], swept_path(curve, 10e-3), stock_of(box)))
    off = np.degrees(np.abs(told - done.stations("angle")[level][inner]))
    assert np.quantile(off, 0.99) < 1e-3


def test_contact_balances_what_the_map_loses():
    """Removal at stations summed along the program is the volume; elements and stations finer, closer."""
    program = "G21 G90 T1 M6 S8000 M3\nG0 X-8 Y0 Z5\nG1 Z-1 F600\nG1 X20 Y3 Z-4\nG1 X45 Y-2 Z-2\n"
    tool = "{number: 1, shape: bull_nose, corner_radius: 1.5 mm, diameter: 10 mm, flutes: 2, helix: 30 deg, end_core: 0 mm}"
    errors = []
    for elements, grid in ((10, 0.3), (40, 0.1)):
        _, done = ran(program, tool, f"numerics: {{stock: {{grid: {grid} mm, elements: {elements}, station: 0.2 mm}}}}")
        rate, where = done.stations("removal"), stock_stations.station_places(done)
        move = stock_stations.station_moves(done)
        step = np.linalg.norm(np.diff(where, axis=0), axis=1) * (np.diff(move) == 0)
        errors.append(float((0.5 * (rate[1:] + rate[:-1]) * step).sum() / done.volume.sum() - 1.0))
    assert abs(errors[0]) < 0.01
    assert abs(errors[1]) < 0.002


def test_torque_times_speed_is_the_removal_and_the_edges():
    program = "G21 G90 T1 M6 S8000 M3\nG0 X-8 Y0 Z5\nG1 Z-2 F600\nG1 X20 Y0\n"
    _, done = ran(program, "{number: 1, shape: ball, diameter: 6 mm, flutes: 2, helix: 30 deg}",
                  "material: {K_tc: 800 N/mm^2, K_rc: 200 N/mm^2, K_te: 0 N/mm, K_re: 0 N/mm}")  # fmt: skip
    power = done.stations("torque") * 8000 * 2 * math.pi / 60
    removal = done.stations("removal") * done.moves.feed[stock_stations.station_moves(done)]
    assert power.max() > 1.0
    assert power == pytest.approx(800e6 * removal, rel=1e-6, abs=1e-9)


def test_worked_example_h_a_shank_in_a_slot():
    _, done = ran("G21 G90 T1 M6\nG0 X-10 Y0 Z5\nG0 Z-10\nG1 X50 F600\n")
    found = [event for event in stock_stations.events(done) if event.kind == "shank"]
    assert [event.line for event in found] == [4]
    assert 1e3 * found[0].depth == pytest.approx(4.0, abs=1e-6)
    assert 1e9 * found[0].volume == pytest.approx(8 * 40, rel=0.08)


def test_rapids_starts_fixtures_and_bottoms_are_told():
    given, done = ran(
        "G21 G90 T1 M6\nG0 X-10 Y0 Z5\nG0 X20 Z-3\nG1 X30 Z-21 F600\nG0 Z5\n", more="fixtures: [{x: [28 mm, 34 mm], y: "
        "[-3 mm, 3 mm], z: [-20 mm, 3 mm]}]",
    )  # fmt: skip
    said = told(given)
    kinds = {(event.kind, event.line) for event in stock_stations.events(done)}
    assert ("rapid", 3) in kinds
    assert ("fixture", 4) in kinds
    assert ("rapid", 2) not in kinds
    assert "below the bottom of the stock, by 1 mm" in said
    inside = parse(
        HEAD
        + f'tools: [{FLAT}]\nprogram: {{file: a.nc, text: "G21 G90 T1 M6 G1 X30 F100", start: {{x: 20 mm, y: 0 mm, z: -3 mm}}}}'
    )
    assert "stands in the stock where the program begins, 3 mm deep" in told(inside)


def test_a_tool_that_does_not_cut_over_centre_is_told():
    core = FLAT.replace("}", ", end_core: 1 mm}")
    _, done = ran("G21 G90 T1 M6\nG0 X20 Y0 Z5\nG1 Z-3 F600\n", core)
    assert [(event.kind, event.line) for event in stock_stations.events(done)] == [("core", 3)]


def test_a_program_that_misses_is_told_with_both_extents():
    given = scenario("G20 G90 T1 M6\nG0 X100 Y90 Z1\nG1 X130 Y91 F60\n")
    said = told(given)
    for words in ("never meets the stock", "(stock 0 to 40 mm)", "25.4"):
        assert words in said
    assert [finding.code for finding in stock_findings.findings(stock_setups.run(given))] == ["untouched"]


def test_an_unknown_start_is_taken_above_the_stock():
    """Otherwise the first move would come out of the machine's zero, through the stock."""
    _, done = ran("G21 G90 T1 M6\nG0 X20 Y0\nG0 Z5\nG1 X30 F600\n")
    assert done.volume.sum() == 0.0
    assert "program.start is not given" in done.planned.said[0]


def test_every_fault_at_once():
    with pytest.raises(ScenarioFault) as caught:
        parse("process: mill\nprogram: {file: a.nc, text: G1 X1 F1}\npart: {file: none.step}\n"
              "tools: [{number: 1, shape: bull_nose, diameter: 6 mm, flutes: 2, helix: 30 deg}, {number: 1, shape: taper, "
              "diameter: 6 mm, flutes: 2, helix: 30 deg, half_angle: 95 deg, tip_diameter: 7 mm}]\n")  # fmt: skip
    told = str(caught.value)
    for words in ("none.step: no such file", "corner_radius: missing", "half_angle"):
        assert words in told, told


@pytest.mark.parametrize(
    ("tool", "words"),
    [
        ("{number: 1, shape: bull_nose, corner_radius: 4 mm, diameter: 6 mm, flutes: 2, helix: 0 deg}", "half the diameter"),
        ("{number: 1, shape: flat, corner_radius: 1 mm, diameter: 6 mm, flutes: 2, helix: 0 deg}", "does not belong to shape flat"),
        ("{number: 1, shape: ball_taper, half_angle: 5 deg, diameter: 6 mm, flutes: 2, helix: 0 deg}", "ball_radius: missing"),
        ("{number: 1, shape: lollipop, diameter: 6 mm, flutes: 2, helix: 0 deg}", "shape"),
        ("{number: 2, shape: flat, diameter: 6 mm, flutes: 2, helix: 0 deg}", "T1"),
    ],
)  # fmt: skip
def test_tools_that_cannot_be(tool, words):
    with pytest.raises(ScenarioFault) as caught:
        prepare(scenario("G21 G90 T1 M6\nG0 X20 Y0 Z5\nG1 Z-3 F600\n", tool))
    assert words in str(caught.value)


def test_a_grid_that_memory_does_not_hold_names_one_that_fits():
    with pytest.raises(ScenarioFault, match="fits, or write memory_limit"):
        prepare(scenario("G21 G90 T1 M6\nG0 X20 Y0 Z5\nG1 Z-3 F600\n", more="numerics: {stock: {grid: 1 um}}"))


def test_a_round_bar_and_a_file_as_stock(tmp_path):
    program = "G21 G90 T1 M6\nG0 X-40 Y0 Z5\nG1 Z-2 F600\nG1 X80\n"
    bar = "process: mill\nstock: {cylinder: {diameter: 30 mm, axis: [0 mm, 0 mm], z: [-10 mm, 0 mm]}}\n"
    _, done = ran(program, head=bar, more="numerics: {stock: {grid: 0.1 mm, engagement: none}}")
    chord = 2 * (3 * math.sqrt(225 - 9) + 225 * math.asin(3 / 15))  # of the round outline within the slot
    assert 1e9 * done.volume.sum() == pytest.approx(2 * chord, rel=1e-3)
    (tmp_path / "raw.stl").write_bytes(stl_bytes(box((0, 40), (-10, 10), (-20, 0))))
    text = f"process: mill\nstock: {{file: raw.stl}}\ntools: [{FLAT}]\nprogram: {{file: t.nc, text: {json.dumps(program)}}}\n"
    given = parse(text, folder=tmp_path, overrides={"numerics.stock.grid": "0.25 mm"})
    done = planned_run(given)
    assert 1e9 * done.volume.sum() == pytest.approx(6 * 2 * 40, rel=1e-3)
    assert done.stations("angle").max() == pytest.approx(math.pi)


@pytest.mark.parametrize("entry", ["", "diameter: 8 mm"])
def test_cutter_compensation_takes_the_diameter_of_the_tool(entry):
    """Along a wall at y = 5 the centre runs a radius away from it; an entry of program.tools wins."""
    text = "G21 G90 G17 T1 M6\nG0 X-20 Y-8 Z5\nG1 Z-2 F600\nG42 D1 G1 X-10 Y5\nG1 X50\nG40 G1 X60 Y-8\n"
    listed = f", tools: [{{number: 1, {entry}}}]" if entry else ""
    given = parse(f"{HEAD}tools: [{FLAT}]\nprogram: {{file: t.nc, text: {json.dumps(text)}{listed}}}\n")
    done = planned_run(given)
    y = (
        1e3
        * done.moves.start[
            done.moves.line[np.searchsorted(done.moves.path.first, np.arange(len(done.moves.start)), "right") - 1] == 5
        ]
    )
    assert y[0, 1] == pytest.approx(5 - (4 if entry else 3), abs=1e-9)


def test_a_contact_in_more_pieces_than_there_is_room_for_is_no_result():
    found = np.zeros((3, len(STATION)))
    all_contact(SimpleNamespace(found=found))
    found[1, STATION.index("contact")] = PIECES
    with pytest.raises(SolverFailure, match="1 stations is in more than 4096 pieces"):
        all_contact(SimpleNamespace(found=found))


@pytest.mark.parametrize("under", [0.5, 1.5])
def test_flutes_below_the_stock_cut_nothing(under):
    """A slot through a plate, the tip below it: contact, torque and volume are those of the plate."""
    head = "process: mill\nstock: {x: [0 mm, 40 mm], y: [-10 mm, 10 mm], z: [-4 mm, 0 mm]}\n"
    _, done = ran(f"G21 G90 T1 M6 S8000 M3\nG0 X-10 Y0 Z5\nG1 Z{-4 - under} F600\nG1 X50\n", head=head)
    rate = done.stations("removal")
    assert 1e6 * rate.max() == pytest.approx(6 * 4, rel=1e-6)


def test_what_contact_takes_is_told_beside_what_cells_say():
    """Twelve elements of a bull-nose miss part of a shallow ramp, 200 do not: the note says so."""
    program = "G21 G90 T1 M6 S5000 M3\nG0 X5 Y0 Z0\nG1 X30 Z-2 F600\nG0 Z5\n"
    tool = (
        "{number: 1, shape: bull_nose, diameter: 10 mm, corner_radius: 2 mm, flutes: 3, helix: 30 deg, end_core: 0 mm}"
    )
    off = []
    for elements in (6, 200):
        more = f"numerics: {{stock: {{grid: 0.25 mm, station: 0.5 mm, elements: {elements}}}}}"
        done = planned_run(scenario(program, tool, more))
        along, cells = stock_measures.contact_volume(done)
        off.append(abs(along / cells - 1.0))
        assert f"{along / cells:.4f}" in stock_measures.checked(done)["balance of contact"]
    assert off[0] > 3 * off[1]
    assert off[1] < 5e-3


@pytest.mark.parametrize("core", [0.0, 1.7])
@pytest.mark.parametrize("law", ["linear", "kienzle"])
def test_force_and_torque_of_a_plunge_in_closed_form(law, core):
    """F = N (K_rc f + K_re) (R - r_0), T = N (K_tc f + K_te) (R^2 - r_0^2) / 2; by Kienzle's law k f^(1-m) in their place."""
    feed, speed, teeth, radius = 137.0, 2900.0, 4, 6.0
    chip = feed / (teeth * speed)
    if law == "linear":
        material = (
            "{K_tc: 903 N/mm^2, K_rc: 311 N/mm^2, K_ac: 147 N/mm^2, K_te: 21 N/mm, K_re: 33 N/mm, K_ae: 1.9 N/mm}"
        )
        across, down = 903 * chip + 21, 311 * chip + 33
    else:
        material = "{k_c11: 1420 N/mm^2, m_c: 0.23, k_r11: 610 N/mm^2, m_r: 0.41, k_a11: 290 N/mm^2, m_a: 0.3}"
        across, down = 1420 * chip**0.77, 610 * chip**0.59
    tool = f"{{number: 1, shape: flat, diameter: 12 mm, flutes: {teeth}, helix: 38 deg, end_core: {core} mm}}"
    program = f"G21 G90 T1 M6 S{speed} M3\nG0 X13.7 Y0.3 Z2\nG1 Z-4.4 F{feed}\nG0 Z5\n"
    done = stock_setups.run(scenario(program, tool, f"material: {material}\nnumerics: {{stock: {{grid: 0.5 mm}}}}"))
    found = stock_measures.measures(done, None)
    assert found["plunge_force_max"] == pytest.approx(teeth * down * (radius - core), rel=1e-8)
    assert found["spindle_torque_max"] == pytest.approx(1e-3 * teeth * across * (radius**2 - core**2) / 2, rel=1e-8)


def test_a_place_has_the_time_at_which_the_tool_was_beside_it():
    """The deepest gouge was told with the time at which its line begins, seconds before the tool came there."""
    _, done = ran("G21 G90 T1 M6 S5000 M3\nG0 X0 Y0 Z5\nG1 Z-1 F600\nG1 X30 F600\nG3 X30 Y8 I0 J4 F600\nG0 Z5\n")
    line = done.moves.line[np.searchsorted(done.moves.path.first, np.arange(len(done.moves.way)), side="right") - 1]
    along, turn = int(np.flatnonzero(line == 4)[0]), int(np.flatnonzero(line == 5)[0])
    times = done.planned.block_time[done.moves.block[[along, turn]]]
    assert stock_stations.time_beside(done, along, np.array([21e-3, 2e-3])) == pytest.approx(times[0] + 2.1, abs=1e-6)
    assert stock_stations.time_beside(done, along, np.array([99e-3, 2e-3])) == pytest.approx(times[0] + 3.0, abs=1e-6)
    quarter = 0.5 * math.pi * 4e-3 / 10e-3
    assert stock_stations.time_beside(done, turn, np.array([33e-3, 4e-3])) == pytest.approx(
        times[1] + quarter, abs=1e-6
    )
    assert stock_stations.time_beside(done, turn, np.array([29e-3, -1e-3])) == pytest.approx(times[1], abs=1e-6)
