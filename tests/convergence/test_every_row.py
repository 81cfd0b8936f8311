"""Order of every row of the structure that is stepped: one test, which a new row fails until it has a case here."""

import math

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.physics.structure.swings import linked, swinging
from cutwise.physics.structure.terms import Compliance, Pistons, Rigid, Series, relaxed
from cutwise.process.spindles import piston_ring
from cutwise.records import Load, Pose
from cutwise.stages import displaced, stepped

TIME = 0.02  # [s]
HERE = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
FORCE = np.array([30.0, -20.0, 10.0])


def swing(_):
    return swinging(np.zeros(1), np.diag([1.1e-6, 0.4e-6, 1.2e-6])[None], 20.0, 0.05)


def links(_):
    mass, arms = np.array([[[40.0, 5.0], [5.0, 15.0]]]), np.array([[[0.3, 0.1], [1.5, 0.7], [0.2, -0.4]]])
    turning = np.zeros((1, 3, 2))
    return linked(np.zeros(1), mass, np.array([3e6, 1e6]), 0.05, np.concatenate([arms, turning], axis=1))


def pistons(examples):
    """Without friction, so that what is seen is the order of the step and not where a seal began to slip."""
    spindle = load(examples / "deburr_compliant_spindle.yaml", ["spindle.friction=none"]).spindle
    return Pistons(piston_ring(spindle), spindle.tool_reach)


CASES = {
    "Swinging": (swing, 1.0),
    "Linked": (links, 1.0),
    "Pistons": (pistons, 1.0),
    "Series": (lambda examples: Series(swing(examples), Series(links(examples), Rigid(0.0))), 1.0),
    "Rigid": (lambda _: Rigid(0.0), math.inf),
    "Compliance": (lambda _: Compliance(np.zeros(1), 1e-6 * np.eye(6)[None]), math.inf),
}


def ends(structure, steps):
    """Displacement off the work after a time under a load that grows smoothly."""
    state, dt = relaxed(structure), TIME / steps
    for k in range(steps):
        force = math.sin(0.5 * math.pi * (k + 0.5) / steps) ** 2 * FORCE
        total = np.array([*force, 0.0, 0.2 * force[0], 0.2 * force[1]])
        stepped(structure, state, HERE, Load(np.zeros((1, 3)), total), dt)
    return displaced(structure, state, 0.0, 0.0).y


@pytest.mark.parametrize("name", sorted(row.__name__ for row in stepped.laws if row.__module__.startswith("cutwise.")))
def test_order_of_a_row_that_is_stepped(name, examples):
    row, order = CASES[name]
    structure = row(examples)
    found = np.array([ends(structure, steps) for steps in (100, 200, 400)])
    first, second = np.abs(np.diff(found))
    if math.isinf(order):
        assert first == second == 0.0
    else:
        assert abs(found[-1]) > 1e-6
        assert math.log2(first / second) == pytest.approx(order, abs=0.15)
