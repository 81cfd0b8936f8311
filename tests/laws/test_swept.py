"""The surface with memory: what is removed, and the limit of a smooth path, in which it is the arcs."""

import numpy as np
import pytest

from cutwise.maths.curves import constant
from cutwise.physics.cutting.flute import EdgeCoefficients, mean_force
from cutwise.physics.cutting.uneven import LINEAR, NO_KIENZLE, Edges
from cutwise.physics.engagement.arc import layer_arcs
from cutwise.physics.engagement.swept import stand
from cutwise.process.loops import run_compliant_edge, run_swept_edge
from peers.cells import MM, error_at_tool, r0
from peers.strip import strip_force


@pytest.fixture(scope="module")
def passed():
    """What :func:`rigid_pass` gives for 0.8 mm."""
    return rigid_pass(0.8 * MM)


def rigid_pass(depth, speed=0.08, length=8 * MM, dt=10e-6, climb=0.0):
    """Mean force and removed area of a rigid mill over a burr of 1 mm, and the columns it leaves."""
    cell = r0()
    columns = stand(constant(1 * MM), -5 * MM, length + 5 * MM, 10e-6, 1, 0)
    before = columns.height.sum() * columns.pitch
    steps = int(length / speed / dt)
    forces = np.zeros((steps, 4))
    for k in range(steps):
        strip_force(cell.cutter.edges, cell.cutter, columns, 0, speed * k * dt,
                    4 * MM + 1 * MM - depth + climb * k * dt, 1 * MM, dt, 1 * MM, forces[k])  # fmt: skip
    return forces, before - columns.height.sum() * columns.pitch, columns


def test_power_is_specific_energy_of_the_removed_volume(passed):
    forces, removed, _ = passed
    omega, radius = 40_000 * 2 * np.pi / 60, 4 * MM
    assert forces[:, 3].sum() * 10e-6 * omega * radius == pytest.approx(2.0e9 * removed * 1 * MM, rel=1e-9)


def test_straight_pass_is_the_arcs(passed):
    forces, _, columns = passed
    arcs = layer_arcs(0.8 * MM, 0.0, 0.0, 4 * MM)
    k = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 0.0, 0.0, 0.0)
    expected = np.array(mean_force(arcs.front_lo, arcs.front_hi, 6e-6, 0.0, 1 * MM, 20, k))
    assert forces[len(forces) // 2 :].mean(0) == pytest.approx(expected, rel=2e-3)
    behind = columns.height[0, (columns.start + np.arange(columns.height.shape[1]) * columns.pitch < 4 * MM)
                            & (columns.start + np.arange(columns.height.shape[1]) * columns.pitch > 1 * MM)]  # fmt: skip
    assert behind == pytest.approx(np.full(behind.size, 0.2 * MM), abs=1e-9)


def test_a_second_pass_in_the_same_place_cuts_nothing():
    cell = r0()
    columns = stand(constant(1 * MM), -5 * MM, 10 * MM, 10e-6, 1, 0)
    first, second = np.zeros(4), np.zeros(4)
    for force in (first, second):
        strip_force(cell.cutter.edges, cell.cutter, columns, 0, 2 * MM, 4.2 * MM, 1 * MM, 1e-5, 1 * MM, force)
    assert first[3] > 0
    assert second == pytest.approx(np.zeros(4))


def test_columns_of_burr_end_at_the_work():
    cell = r0()
    columns = stand(constant(1 * MM), 0.0, 10 * MM, 10e-6, 1, 1)
    force = np.zeros(4)
    for strip in range(2):
        strip_force(cell.cutter.edges, cell.cutter, columns, strip, 5 * MM, 3.5 * MM, 1 * MM, 1e-5, 1 * MM, force)
    assert columns.height[0].min() == 0.0
    assert columns.height[1].min() == pytest.approx(-0.5 * MM, abs=1e-8)


@pytest.mark.parametrize("frequency", [None, 5.0])
def test_coupled_pass_agrees_with_the_arcs_on_smooth_paths(frequency):
    path = {"amplitude": 0.2 * MM, "frequency": frequency} if frequency else {}
    cell = r0(**path)
    arcs, memory = (error_at_tool(cell, run(cell, 20e-6)) / MM for run in (run_compliant_edge, run_swept_edge))
    assert memory[-1] == pytest.approx(arcs[-1], abs=2e-4)
    assert np.abs(memory - arcs)[len(arcs) // 2 :].max() < 1e-3


def test_at_twice_the_memory_limit_the_arcs_still_give_the_mean():
    """0.2 mm at 20 Hz, index 1.97: force within 0.33 N, mean error within 0.3 um."""
    cell = r0(amplitude=0.2 * MM, frequency=20.0, duration=0.8)
    histories = [run(cell, 20e-6) for run in (run_compliant_edge, run_swept_edge)]
    steady = histories[0].motion.time >= 0.6
    a, b = ((error_at_tool(cell, h) / MM)[steady].mean() for h in histories)
    assert a == pytest.approx(b, abs=5e-4)
    force = [h.burr_force.mean[steady] for h in histories]
    assert np.abs(force[0] - force[1]).max() < 0.4


@pytest.mark.slow
def test_column_pitch_and_step_do_not_matter():
    cell = r0()
    fine = error_at_tool(cell, run_swept_edge(cell, 10e-6, column=5e-6))[-1] / MM
    assert fine == pytest.approx(-0.009452, abs=2e-5)
    assert error_at_tool(cell, run_swept_edge(cell, 20e-6, column=20e-6))[-1] / MM == pytest.approx(fine, abs=2e-5)


def test_edges_without_a_chip_carry_no_force():
    edges = Edges(LINEAR, EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 1e3, 1e3, 1e3), NO_KIENZLE, 0.0, 0.0)
    cell = r0()
    columns = stand(constant(0.1 * MM), 0.0, 10 * MM, 10e-6, 1, 0)
    force = np.zeros(4)
    strip_force(edges, cell.cutter, columns, 0, 5 * MM, 4.2 * MM, 1 * MM, 1e-5, 0.1 * MM, force)
    assert force == pytest.approx(np.zeros(4))
