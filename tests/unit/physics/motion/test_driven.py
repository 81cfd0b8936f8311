"""Feed drives of any number of axes, by themselves and as what moves the tool of a cell."""

import math

import numpy as np
import pytest

from cutwise.loop import Cell, march
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.flutes import MeanFlutes
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import AVERAGED
from cutwise.physics.engagement.arc import immersion_half_angle
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.shoulder import SEEN, Shoulder
from cutwise.physics.engagement.wall import wall_patches
from cutwise.physics.motion.driven import SetPoints, driven_tool, machine_parts, process_parts
from cutwise.physics.motion.drives import Controller, Drive, axes_of
from cutwise.physics.motion.reference import central_difference
from cutwise.physics.structure.terms import Rigid
from cutwise.process.loops_drives import NO_FORCE, STANDSTILL, Cut, run_drives
from peers.corner import AL7075, OMEGA, X, Y

LAW = Controller(70e3, 500e3, 300.0, 0.0, 0.0, 1e-3, 10.0, 0.0, 0.0)
DRIVES = (Drive(X, LAW), Drive(Y, LAW))
MILL = Mill(0.01, 3, math.radians(30))
WIDTH, DEPTH, STEPS = 4e-3, 5e-3, 400


def straight(angle: float):
    """Set points of a line at 40 mm/s after a soft start, with the contact of a shoulder."""
    t = np.arange(STEPS) * 1e-3
    along = 0.04 * (t - 0.05 * (1.0 - np.exp(-t / 0.05)))
    point = np.outer(along, [math.cos(angle), math.sin(angle)])
    velocity = central_difference(point, 1e-3)
    return SetPoints(point, velocity, central_difference(velocity, 1e-3), np.full(STEPS, angle), along)


def alone(drives, order, law=NO_FORCE):
    arcs = np.full(STEPS, immersion_half_angle(WIDTH, MILL.radius))
    cut = Cut(law, MILL, discs(0.01, MILL.helix, DEPTH, 3, 1), even_edges(AL7075), OMEGA)
    return run_drives(order, wall_patches(arcs, DEPTH), drives, cut, 10)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_an_axis_knows_nothing_of_how_many_there_are(count):
    order = straight(0.6)
    more = [np.column_stack([one, *[one[:, 1]] * (count - 2)]) for one in order[:3]]
    if count > 3:  # a force acts along x, y and z
        with pytest.raises(ValueError, match="along x, y and z"):
            alone((*DRIVES, *[DRIVES[1]] * (count - 2)), SetPoints(*more, *order[3:]))
        return
    many = alone((*DRIVES, *[DRIVES[1]] * (count - 2)), SetPoints(*more, *order[3:]))
    two = alone(DRIVES, order)
    assert np.array_equal(many.position[:, :2], two.position)
    for extra in range(2, count):
        assert np.array_equal(many.position[:, extra], two.position[:, 1])
        assert np.array_equal(many.voltage[:, extra], two.voltage[:, 1])


def test_a_z_axis_is_pulled_by_the_helix_and_held_by_friction():
    order = straight(0.6)
    level = [np.column_stack([one, np.zeros(STEPS)]) for one in order[:3]]
    run = alone((*DRIVES, DRIVES[1]), SetPoints(*level, *order[3:]), AVERAGED)
    assert run.force[-1, 2] < -20.0
    assert np.ptp(run.position[:, 2]) == 0.0
    smooth = X._replace(stiction_plus=0.0, stiction_minus=0.0, coulomb_plus=0.0, coulomb_minus=0.0)
    loose = alone((*DRIVES, Drive(smooth, LAW)), SetPoints(*level, *order[3:]), AVERAGED)
    assert loose.position[:, 2].min() < -5e-8


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_process_axes_and_back(side):
    along, off = process_parts(0.3, -0.7, 0.4, side)
    assert machine_parts(along, off, 0.4, side) == pytest.approx((0.3, -0.7), abs=1e-15)
    assert process_parts(-math.sin(0.4), math.cos(0.4), 0.4, 1.0) == pytest.approx((0.0, 1.0))


@pytest.mark.parametrize("angle", [0.0, 0.6, 2.5, -1.2])
def test_drives_in_a_cell_are_the_drives_alone_under_the_same_force(angle):
    """Where the cell cuts a little less by what the drives deviate, the positions differ by some nanometres."""
    order = straight(angle)
    motion = driven_tool(axes_of(DRIVES, 10), order, 10, 1.0, -WIDTH)
    engagement = Shoulder(Round(0.01, 3, OMEGA), DEPTH, standstill=STANDSTILL)
    cell = Cell(motion, engagement, (), MeanFlutes(MILL, even_edges(AL7075), OMEGA, False), Rigid(0.0))
    march(cell, (), duration=STEPS * 1e-3, time_step=1e-4, seen=SEEN, state=0, layers=1, contacts=1, stride=10)
    by_itself = alone(DRIVES, order, AVERAGED)
    assert motion.log.force == pytest.approx(by_itself.force, abs=0.5)
    assert motion.log.position == pytest.approx(by_itself.position, abs=2e-8)
    assert np.abs(motion.log.voltage - by_itself.voltage).max() < 2e-2


def test_drives_in_a_cell_without_a_cut_are_the_drives_alone_to_the_last_bit():
    order = straight(0.6)
    motion = driven_tool(axes_of(DRIVES, 10), order, 10, 1.0, -WIDTH)
    engagement = Shoulder(Round(0.01, 3, OMEGA), DEPTH, begins=1.0, standstill=STANDSTILL)
    cell = Cell(motion, engagement, (), MeanFlutes(MILL, even_edges(AL7075), OMEGA, False), Rigid(0.0))
    march(cell, (), duration=STEPS * 1e-3, time_step=1e-4, seen=SEEN, state=0, layers=1, contacts=1, stride=10)
    by_itself = alone(DRIVES, order)
    for name in ("position", "speed", "voltage", "clipped"):
        assert np.array_equal(getattr(motion.log, name), getattr(by_itself, name))
