"""The force over a whole turn of a mill with run-out."""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, mean_force
from cutwise.physics.cutting.uneven import even_edges, uneven_tooth_force, whole_turn_force

EDGES = even_edges(EdgeCoefficients(767e6, 168e6, 222e6, 27.7e3, 26.6e3, 2.2e3))


@pytest.mark.parametrize(
    ("flutes", "lo", "hi", "runout"), [(3, 2.21, math.pi, 10e-6), (2, 0.0, math.pi, 30e-6), (4, 0.0, 1.1, 4e-6)]
)
def test_it_is_the_mean_of_the_teeth_whatever_the_direction(flutes, lo, hi, runout):
    """Of the teeth as they stand, over all directions of the run-out."""
    mill, chip, depth = Mill(10e-3, flutes, math.radians(30)), 0.1e-3, 5e-3
    turns = np.linspace(0.0, 2.0 * math.pi, 180, endpoint=False)
    teeth = [
        uneven_tooth_force(turn, lo, hi, chip, 0.0, 0.0, depth, mill, EDGES._replace(runout=runout, runout_angle=angle))
        for angle in np.linspace(0.0, 2.0 * math.pi, 24, endpoint=False)
        for turn in turns
    ]
    for angle in (0.0, 0.9):
        edges = EDGES._replace(runout=runout, runout_angle=angle)
        found = np.array(whole_turn_force(lo, hi, chip, 0.0, depth, mill, edges))
        assert found == pytest.approx(np.mean(teeth, axis=0), rel=5e-3, abs=0.1)


def test_without_run_out_it_is_the_closed_form():
    mill = Mill(10e-3, 3, math.radians(30))
    wanted = mean_force(2.21, math.pi, 0.1e-3, 0.0, 5e-3, 3, EDGES.linear)
    assert tuple(whole_turn_force(2.21, math.pi, 0.1e-3, 0.0, 5e-3, mill, EDGES)) == pytest.approx(
        tuple(wanted), rel=1e-9
    )
