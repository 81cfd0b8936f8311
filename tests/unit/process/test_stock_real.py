"""The surface of a moved tool: known offsets, springs, drives and carriers against closed forms and the loop of drives."""

import json
import math

import numpy as np
import pytest

from cutwise.io.scenario import load, parse
from cutwise.process import (
    milling,
    stock_deviation,
    stock_findings,
    stock_measures,
    stock_plan,
    stock_real,
    stock_setups,
)
from cutwise.process.recipes import prepare
from cutwise.process.stock_carrier import carrier_of, driven, terms_at
from cutwise.process.stock_material import raw_of
from cutwise.process.stock_path import moves_of
from cutwise.process.stock_pieces import Known, pieces_of
from cutwise.spec.faults import ScenarioFault
from peers.maps import MM, heights

HEAD = "process: mill\nstock: {x: [0 mm, 40 mm], y: [-15 mm, 15 mm], z: [-20 mm, 0 mm]}\n"
SLOT = "G21 G90 G17 T1 M6 S8000 M3\nG0 X-12 Y0 Z5\nG1 Z-3 F2400\nG1 X52\nG0 Z5\n"
TOOL = "number: 1, shape: flat, diameter: 10 mm, flutes: 3, helix: 30 deg, end_core: 0 mm"
MATERIAL = (
    "material: {K_tc: 800 N/mm^2, K_rc: 300 N/mm^2, K_ac: 100 N/mm^2, K_te: 20 N/mm, K_re: 15 N/mm, K_ae: 1 N/mm}\n"
)


def scenario(program=SLOT, tool="", more="", numerics="grid: 0.5 mm, check: 200", material=MATERIAL):
    return parse(
        f"{HEAD}tools: [{{{TOOL}{tool}}}]\n{material}numerics: {{stock: {{{numerics}}}}}\n"
        f"program: {{file: t.nc, text: {json.dumps(program)}}}\n{more}"
    )


def cut(given):
    return stock_setups.run(given).cuts[0]


def wall(solid, x, low, high):
    """Where the floor of a slot ends between two y in mm."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if heights(solid, (x, middle))[0] < -1.0 else (low, middle)
    return low


def test_worked_example_f_is_of_second_order():
    """A flat mill of R5 along y = 5 displaced by 0.02 sin(2 pi x / 40): the wall against the exact envelope, poses every 40/n."""
    told = {10: 9.79e-4, 20: 2.43e-4, 40: 6.15e-5, 80: 1.54e-5}
    x = np.linspace(-10, 50, 60_001)
    y = 5 + 0.02 * np.sin(2 * math.pi * x / 40)
    at = np.linspace(3, 37, 200)
    exact = np.array([(y + np.sqrt(np.maximum(25 - (x - p) ** 2, 0.0)))[np.abs(x - p) <= 5].max() for p in at])
    program = "G21 G90 T1 M6\nG0 X-10 Y5 Z0\nG1 X50 F600\n"
    given = scenario(program)
    planned = stock_plan.planned(given, raw_of(given.stock, ("stock",)))
    moves = moves_of(planned.path, planned.tool, planned.feed, 1e-6, 1.0)
    line = int(np.argmax(moves.way))
    begin = moves.along[line, 0]
    for n, error in told.items():
        s = np.linspace(0.0, 60.0, 60 * n // 40 + 1)
        known = Known(begin + MM * s, np.column_stack([0 * s, MM * 0.02 * np.sin(2 * math.pi * (s - 10) / 40), 0 * s]))
        pieces, _ = pieces_of(moves, MM * 40 / n, 1.0, 1.0, known)
        of = pieces.along[:, 0] >= begin - 1e-12
        a, b = ((p + known.at(pieces.along[:, k]))[of, :2] / MM for k, p in enumerate((pieces.start, pieces.end)))
        found = np.full(at.size, -np.inf)
        for p, q in zip(a, b, strict=True):
            way = np.linspace(0.0, 1.0, 400)[:, None]
            point = p + way * (q - p)
            reach = 25 - (point[:, :1] - at) ** 2
            found = np.maximum(
                found, np.where(reach >= 0, point[:, 1:] + np.sqrt(np.maximum(reach, 0.0)), -np.inf).max(axis=0)
            )
        assert np.abs(found - exact).max() == pytest.approx(error, rel=0.1)


def test_pieces_follow_what_is_known_within_the_distance_asked_for():
    given = scenario()
    planned = stock_plan.planned(given, raw_of(given.stock, ("stock",)))
    moves = moves_of(planned.path, planned.tool, planned.feed, 1e-6, 5e-4)
    s = np.linspace(0.0, moves.along[-1, 1], 20_001)
    known = Known(s, 3e-5 * np.column_stack([np.sin(900 * s), np.cos(700 * s), 0 * s]))
    _, rough = pieces_of(moves, 1.0, 1.0, 5e-4, known)
    pieces, missed = pieces_of(moves, 1.0, 1e-6, 5e-4, known)
    assert rough > 2e-5
    assert missed <= 1e-6
    assert pieces.way.sum() == pytest.approx(moves.way.sum())
    assert (np.diff(pieces.along[:, 0]) >= 0).all()


@pytest.mark.parametrize("stiffness", [5, 20])
def test_a_spring_moves_the_walls_of_a_slot_by_its_mean_force(stiffness):
    """N a K / 4 and edges 0: -K_rc along the feed, K_tc to its left; the axial force does not bend the tool."""
    material = (
        "material: {K_tc: 800 N/mm^2, K_rc: 300 N/mm^2, K_ac: 100 N/mm^2, K_te: 0 N/mm, K_re: 0 N/mm, K_ae: 0 N/mm}\n"
    )
    done = cut(scenario(tool=f", stiffness: {stiffness} N/um", material=material))
    chip = 40 / (8000 / 60 * 3)
    force = 3 * 3 * chip * np.array([-300, 800]) / 4
    middle = np.argmin(np.abs(done.real.done.moves.start[:, 0] - 20 * MM) + (done.real.done.moves.start[:, 2] > 0))
    off = done.real.off[middle, 0]
    assert 1e6 * off[:2] == pytest.approx(force / stiffness, rel=1e-6)
    assert off[2] == 0.0
    shift = force[1] / stiffness * 1e-3
    assert wall(done.left.solid, 20, 0, 9) == pytest.approx(5 + shift, abs=1e-7)
    assert -wall(done.left.solid, 20, 0, 9) + 2 * shift == pytest.approx(-5 + shift, abs=1e-7)
    assert done.real.change < 5e-8
    assert wall(done.ideal.solid, 20, 0, 9) == pytest.approx(5, abs=1e-9)


def test_modes_count_by_their_stiffness_and_directions_apart():
    modes = ", modes: [{direction: y, frequency: 900 Hz, damping: 0.03, stiffness: 10 N/um}, {direction: y, frequency: 2000 Hz, "
    modes += "damping: 0.03, stiffness: 10 N/um}, {direction: x, frequency: 900 Hz, damping: 0.03, stiffness: 20 N/um}]"
    both, spring = cut(scenario(tool=modes)).real, cut(scenario(tool=", stiffness: 5 N/um")).real
    at = np.argmin(np.abs(both.done.moves.start[:, 0] - 20 * MM))
    assert both.off[at, 0, 1] == pytest.approx(spring.off[at, 0, 1], rel=1e-3)
    assert both.off[at, 0, 0] == pytest.approx(0.25 * spring.off[at, 0, 0], rel=1e-3)


@pytest.mark.parametrize("numerics", ["grid: 1 mm, check: 0", "grid: 1 mm, check: 0, engagement: none"])
def test_modes_that_do_not_vibrate_are_told(numerics):
    modal = ", modes: [{direction: y, frequency: 900 Hz, damping: 0.03, stiffness: 10 N/um}]"
    modes, none = (scenario(tool=tool, numerics=numerics) for tool in (modal, ""))
    told, silent = (stock_findings.notes(stock_setups.run(one), None) for one in (modes, none))
    assert "do not vibrate" in told["vibration"]
    assert "vibration" not in silent


def test_nothing_moves_a_rigid_tool_and_ideal_is_the_planned_path():
    assert cut(scenario()).real is None
    for more in ("", "machine: {library: fadal2216, reading: kp_ki_swapped}\n"):
        given = scenario(tool=", stiffness: 5 N/um", more=more, numerics="grid: 0.5 mm, check: 200, sweep: ideal")
        assert cut(given).real is None


def test_drives_do_what_they_do_on_the_exact_arcs():
    """The same drives, set points and no force: to the last bit; forces then change them."""
    program = "G21 G17 G90 G61\nT1 M6\nS8000 M3\nG0 X-12 Y0 Z5\nG1 Z-3 F2400\nG1 X20\nG1 Y30\n"
    machine = "machine: {library: fadal2216, reading: kp_ki_swapped}\n"
    arcs = parse(
        f"{HEAD}tool: {{diameter: 10 mm, flutes: 3, helix: 30 deg}}\n{MATERIAL}{machine}operation: {{spindle_speed: 8000 rpm}}\n"
        f"numerics: {{force: none, settling_time: 0 s}}\nprogram: {{file: t.nc, text: {json.dumps(program)}, start: {{x: -12 mm, "
        "y: 0 mm, z: 5 mm}}\n"
    )
    history = milling.run(arcs, arcs.numerics.substeps)
    given = parse(
        f"{HEAD}tools: [{{{TOOL}}}]\n{MATERIAL}{machine}program: {{file: t.nc, text: {json.dumps(program)}, start: {{x: -12 mm, "
        "y: 0 mm, z: 5 mm}}\nnumerics: {stock: {grid: 0.5 mm, check: 200}}\n"
    )
    planned = stock_plan.planned(given, raw_of(given.stock, ("stock",)))
    still = driven(given, planned.path, planned.plan, np.zeros(1), np.zeros((1, 3)))
    order = milling.set_points(history.reference, 1e-3, 2).point
    assert (still.known.off[:, :2] == history.history.position - order)[: len(still.time)].all()
    pushed = cut(given).real
    assert np.abs(pushed.driven.known.off - still.known.off).max() > 1e-7
    assert np.abs(pushed.driven.force).max() > 50
    aside = stock_measures.aside(pushed)
    assert 1e-6 < aside.max() < 1e-4


def test_bodies_and_springs_add():
    more = "machine: {library: demec_mill}\nplacement: {origin: [0 mm, 0 mm, 300 mm]}\n"
    machine, tool = cut(scenario(more=more)).real, cut(scenario(tool=", stiffness: 10 N/um")).real
    both = cut(scenario(tool=", stiffness: 10 N/um", more=more)).real
    assert both.terms == ("tip", "bodies")
    at = np.argmin(np.abs(both.done.moves.start[:, 0] - 20 * MM))
    assert both.off[at, 0] == pytest.approx(machine.off[at, 0] + tool.off[at, 0], rel=2e-3, abs=1e-9)
    assert machine.carrier.missed < 1e-3


ROBOT = (
    "robot: {library: kr270_r2700, redundancy_angle: 0 deg, joint_angles: [6 deg, -82 deg, 117 deg, 10 deg, -35 deg, -8 deg]}\n"
    "placement: {origin: [1900 mm, 0 mm, 800 mm]}\n"
)


def test_a_robot_yields_as_its_compliance_says():
    given = scenario(more=ROBOT, numerics="grid: 0.5 mm, check: 200, station: 0.2 mm")
    done = cut(given)
    at = np.argmin(np.abs(done.real.done.moves.start[:, 0] - 20 * MM) + (done.real.done.moves.start[:, 2] > 0))
    force = stock_real.station_forces(done.real.done)
    near = np.argmin(np.abs(done.real.done.run.segment - at))
    carrier = carrier_of(given, done.ideal.planned.path, force[near])
    place = done.real.done.moves.start[at : at + 1] - done.real.off[at : at + 1, 0]
    matrix = np.einsum("nt,tij->nij", terms_at(carrier, place), carrier.matrix)[0]
    assert done.real.off[at, 0] == pytest.approx(matrix @ force[near], rel=1e-3)
    assert np.abs(done.real.off[at, 0]).max() > 1e-5


def test_a_path_out_of_reach_or_beyond_travel_is_told():
    with pytest.raises(ScenarioFault, match="beyond its travel"):
        prepare(scenario(more="machine: {library: demec_mill}\n"))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (ROBOT.replace("0 deg, joint", "along_path, joint"), "along_path turns the tool"),
        (ROBOT + "machine: {library: fadal2216, reading: kp_ki_swapped}\n", "one carrier"),
        ("placement: {origin: [1 mm, 0 mm, 0 mm]}\n", "places a program before a robot"),
        ("spindle: {library: berselli2016}\n", r"in a stock in 3D yield tools \(stiffness or modes\)"),
    ],
)
def test_carriers_that_cannot_be(more, words):
    with pytest.raises(ScenarioFault, match=words):
        scenario(more=more)


def test_memory_that_the_moved_tool_does_not_find_is_told():
    given = scenario(
        tool=", stiffness: 5 N/um",
        numerics="grid: 1 mm, check: 0, station: 0.001 mm, memory_limit: 20",
    )
    with pytest.raises(ScenarioFault, match=r"sweep: ideal|do not hold"):
        cut(given)


def test_the_ideal_surface_stands_beside_the_real_one(examples):
    machine = {"machine": {"library": "fadal2216", "reading": "kp_ki_swapped"}}
    coarse = {"numerics.stock": {"grid": "0.6 mm", "engagement": "none", "check": 0}, "part.samples": 20000}
    plain = load(examples / "mill_part.yaml", coarse)
    moved = load(examples / "mill_part.yaml", {**coarse, **machine})
    one, other = (stock_setups.run(given) for given in (plain, moved))
    ideal, real = stock_deviation.judged(plain, one), stock_deviation.judged(moved, other)
    assert ideal.ideal is None
    assert real.ideal.rms == pytest.approx(ideal.left.rms, rel=1e-9)
    assert real.left.rms != pytest.approx(ideal.left.rms, rel=1e-3)
    found = stock_measures.measures(other, real)
    assert found["deviation_max_ideal"] == pytest.approx(stock_measures.measures(one, ideal)["deviation_max"])


@pytest.mark.parametrize("angle", [0, 25])
def test_run_out_widens_what_the_outermost_tooth_sweeps(angle):
    """Of three teeth the outermost stands out by rho times the largest cosine of its angle from the run-out."""
    done = cut(scenario(tool=f", runout: 20 um, runout_angle: {angle} deg"))
    out = 0.02 * max(math.cos(math.radians(angle - 120 * k)) for k in range(3))
    assert wall(done.left.solid, 20, 0, 9) == pytest.approx(5 + out, abs=1e-8)
    assert wall(done.ideal.solid, 20, 0, 9) == pytest.approx(5, abs=1e-9)
    assert done.real.terms == ("runout",)


def test_kienzle_with_small_exponents_is_the_linear_law_and_run_out_keeps_the_mean():
    linear = (
        "material: {K_tc: 800 N/mm^2, K_rc: 300 N/mm^2, K_te: 0 N/mm, K_re: 0 N/mm, K_ac: 100 N/mm^2, K_ae: 0 N/mm}\n"
    )
    kienzle = linear.replace("K_tc", "k_c11").replace("K_rc", "k_r11").replace("K_ac", "k_a11")
    for edge, exponent in (("K_te", "m_c"), ("K_re", "m_r"), ("K_ae", "m_a")):
        kienzle = kienzle.replace(f"{edge}: 0 N/mm", f"{exponent}: 0")
    told = [
        stock_measures.measures(stock_setups.run(scenario(tool=tool, material=material)), None)
        for tool in ("", ", runout: 10 um") for material in (linear, kienzle)
    ]  # fmt: skip
    for name in ("spindle_torque_max", "cutting_power_max", "force_xy_peak", "chip_thickness_max"):
        assert told[1][name] == pytest.approx(told[0][name], rel=1e-6)
        assert told[3][name] == pytest.approx(told[2][name], rel=1e-3)
    assert told[2]["spindle_torque_max"] == pytest.approx(told[0]["spindle_torque_max"], rel=1e-3)
    assert told[2]["force_xy_peak"] > 1.1 * told[0]["force_xy_peak"]
