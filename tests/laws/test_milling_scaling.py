"""Units scale: the same corner in other units of length, mass and time gives the same answer in those units."""

import math

import numpy as np
import pytest

from cutwise.maths.linearc import join
from cutwise.paths.pocket import corner
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import FLUTES
from cutwise.physics.engagement.wall import path_contact, wall_patches
from cutwise.physics.motion.driven import SetPoints
from cutwise.physics.motion.drives import Drive
from cutwise.physics.motion.lookahead import plan
from cutwise.physics.motion.profile import Limits
from cutwise.physics.motion.reference import central_difference, sampled
from cutwise.process.loops_drives import STANDSTILL, Cut, run_drives
from peers.corner import AL7075, LIMITS, X, Y, laws


def scaled_run(length, mass, time):
    """Position of the fillet corner, in the scaled units, brought back to m."""
    force, torque = mass * length / time**2, mass * length**2 / time**2
    speed, rate = length / time, 1.0 / time

    def plant(p):
        return p._replace(
            torque_constant=p.torque_constant * torque, inertia=p.inertia * mass * length**2,
            viscous=p.viscous * torque * time, transmission=p.transmission * length,
            stiction_plus=p.stiction_plus * torque, stiction_minus=p.stiction_minus * torque,
            coulomb_plus=p.coulomb_plus * torque, coulomb_minus=p.coulomb_minus * torque,
            decay_plus=p.decay_plus * rate, decay_minus=p.decay_minus * rate, rise_plus=p.rise_plus * rate,
            rise_minus=p.rise_minus * rate,
        )  # fmt: skip

    def law(c):
        return c._replace(
            proportional=c.proportional / length, integral=c.integral / (length * time),
            derivative=c.derivative * time / length, velocity_feedforward=c.velocity_feedforward / speed,
            sample_time=c.sample_time * time,
        )  # fmt: skip

    limits = Limits(LIMITS.speed * speed, LIMITS.acceleration * speed / time, LIMITS.jerk * speed / time**2)
    curve = join(corner(0.03 * length, 0.5 * math.pi, 2e-3 * length))
    planned = plan(curve, np.full(3, 0.04 * speed), limits)
    step = 1e-3 * time
    reference = sampled(curve, [planned.profile], step, 0.1 * time)
    every = np.ones(curve.count, bool)
    arcs = path_contact(curve, every, reference.block, reference.travelled, 0.01 * length, 0.004 * length)
    point = np.ascontiguousarray(reference.point[:, :2])
    velocity = central_difference(point, step)
    heading = np.arctan2(reference.direction[:, 1], reference.direction[:, 0])
    patches = wall_patches(arcs, 0.005 * length)
    order = SetPoints(point, velocity, central_difference(velocity, step), heading, np.zeros(len(point)))
    x, y = (law(c) for c in laws("kp_ki_swapped"))
    stress = force / length**2
    metal = EdgeCoefficients(*(k * stress for k in AL7075[:3]), *(k * stress * length for k in AL7075[3:]))
    mill = Mill(0.01 * length, 3, math.radians(30))
    cut = Cut(
        FLUTES,
        mill,
        discs(mill.radius, mill.helix, 0.005 * length, 3, 1),
        even_edges(metal),
        837.758 / time,
        STANDSTILL * speed,
    )
    history = run_drives(order, patches, (Drive(plant(X), x), Drive(plant(Y), y)), cut, 10)
    return history.position / length, history.force / force, history.voltage


@pytest.mark.parametrize("units", [(4.0, 1.0, 1.0), (1.0, 8.0, 1.0), (2.0, 0.25, 0.5)])
def test_outputs_follow_the_units(units):
    position, force, voltage = scaled_run(*units)
    plain = scaled_run(1.0, 1.0, 1.0)
    assert position == pytest.approx(plain[0], abs=1e-12)
    assert voltage == pytest.approx(plain[2], abs=1e-6)
    assert force == pytest.approx(plain[1], abs=1e-3)
