"""The piston law: one step against its convex program, energy, symmetry, and the limits of friction."""

import numpy as np
import pytest
from scipy.optimize import minimize

from cutwise.physics.structure import pistons, seals
from peers.cells import MM, end_error, ring


def potential(ring_, state, q, free, dt):
    """1/2 I |q - q_f|^2 / dt^2 + sum_i min over x of F_p x + F_f |x - x_old|, the program that a step minimises."""
    p = ring_.piston
    face = ring_.arm * ring_.direction @ q
    value = 0.5 * ring_.inertia / dt**2 * ((q - free) ** 2).sum()
    for s, old, speed in zip(face, state.travel, state.speed, strict=True):
        limit = 0.0
        if p.law == seals.SET_VALUED:
            limit = p.friction_static if abs(speed) < seals.STUCK_SPEED else p.friction_dynamic
        grid = [x for x in (0.0, old, max(s, 0.0)) if max(s, 0.0) <= x <= p.stroke]
        value += min(p.pressure_force * x + limit * abs(x - old) for x in grid) if grid else 1e6 * (s - p.stroke + 1)
    return value


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("law", [seals.NO_FRICTION, seals.SET_VALUED])
def test_a_step_minimises_its_convex_program(seed, law):
    rng = np.random.default_rng(seed)
    dt = 5e-5
    ring_ = ring(law=law, pressure=rng.uniform(2.0, 6.0))._replace(tolerance=1e-12)
    q = rng.normal(0.0, 0.01, 2)
    rate = rng.normal(0.0, 0.3, 2)
    state = pistons.at_rest(ring_)
    state.travel[:] = np.clip(ring_.arm * ring_.direction @ q, 0.0, ring_.piston.stroke)
    state.speed[:] = rng.choice([0.0, 1e-3], 7)
    moment = rng.normal(0.0, 2.0, 2)
    free = q + dt * rate + dt**2 / ring_.inertia * moment
    before = pistons.RingState(*(a.copy() for a in state))
    qx, qy, *_ = pistons.step(ring_, state, *q, *rate, *moment, dt)
    found = np.array([qx, qy])
    least = potential(ring_, before, found, free, dt)
    rough = minimize(lambda u: potential(ring_, before, free + 1e-6 * u, free, dt), np.zeros(2), method="Nelder-Mead",
                     options={"xatol": 1e-9, "fatol": 1e-16, "maxiter": 4000})  # fmt: skip
    assert least <= rough.fun + 1e-12 * abs(rough.fun)
    for step in rng.normal(0.0, 1e-7, (200, 2)):
        assert potential(ring_, before, found + step, free, dt) >= least


def test_nothing_moves_below_breakaway():
    ring_ = ring()
    state = pistons.at_rest(ring_)
    q = np.zeros(4)
    limit = ring_.arm * (ring_.piston.pressure_force + ring_.piston.friction_static) * 2.19
    for _ in range(2000):
        q[:] = pistons.step(ring_, state, *q, 0.0, 0.98 * limit, 5e-5)[:4]
    assert np.abs(q).max() < 1e-15  # rigid below breakaway, no creep
    for _ in range(2000):
        q[:] = pistons.step(ring_, state, *q, 0.0, 1.05 * limit, 5e-5)[:4]
    assert q[1] > 1e-3


@pytest.mark.parametrize("law", [seals.NO_FRICTION, seals.SET_VALUED, seals.PRESLIDING, seals.REGULARISED])
def test_free_motion_never_gains_energy(law):
    """Kinetic energy plus pressure work falls, by friction, inelastic stops and seats."""
    ring_ = ring(law=law, stribeck=1e-3 if law == seals.REGULARISED else 0.0)
    state = pistons.at_rest(ring_)
    q = np.array([0.0, 0.0, 0.7, 0.4])

    def energy():
        spring = 0.0
        if law == seals.PRESLIDING:
            stiffness = ring_.piston.friction_static / ring_.piston.breakaway_travel
            spring = 0.5 * stiffness * ((state.travel - state.seal) ** 2).sum()
        return 0.5 * ring_.inertia * (q[2:] ** 2).sum() + ring_.piston.pressure_force * state.travel.sum() + spring

    levels = [energy()]
    for _ in range(4000):
        q[:] = pistons.step(ring_, state, *q, 0.0, 0.0, 2e-5)[:4]
        levels.append(energy())
    assert np.diff(levels).max() <= 1e-9 * levels[0]
    assert levels[-1] < 0.9 * levels[0]


def test_stop_is_hard_and_inelastic():
    ring_ = ring(law=seals.NO_FRICTION)
    state = pistons.at_rest(ring_)
    q = np.zeros(4)
    for _ in range(20000):
        q[:] = pistons.step(ring_, state, *q, 0.0, 5.0, 5e-5)[:4]
    assert state.travel.max() == pytest.approx(ring_.piston.stroke, abs=1e-12)
    assert np.abs(q[2:]).max() < 1e-9


def test_a_piston_without_force_stays_back():
    """Below about 1.2 bar friction outweighs pressure: pushed in, the pistons do not return."""
    ring_ = ring(pressure=0.8)
    state = pistons.at_rest(ring_)
    q = np.zeros(4)
    for moment in (2.0, 0.0):
        for _ in range(4000):
            q[:] = pistons.step(ring_, state, *q, 0.0, moment, 5e-5)[:4]
    assert state.travel.max() > 1 * MM
    back = ring()
    state = pistons.at_rest(back)
    q = np.zeros(4)
    for moment in (2.2, 0.0):
        for _ in range(4000):
            q[:] = pistons.step(back, state, *q, 0.0, moment, 5e-5)[:4]
    assert state.travel.max() < 1e-9


def test_zero_friction_is_the_frictionless_law():
    assert end_error(law=seals.SET_VALUED, pressure=5.0) != pytest.approx(0.1774, abs=0.1)
    free = ring(law=seals.SET_VALUED)
    free = free._replace(piston=free.piston._replace(friction_static=0.0, friction_dynamic=0.0))
    state, other = pistons.at_rest(free), pistons.at_rest(free)
    a = b = (0.0, 0.0, 0.3, 0.2)
    for _ in range(500):
        a = pistons.step(free, state, *a, 0.5, 1.8, 5e-5)[:4]
        b = pistons.step(ring(law=seals.NO_FRICTION), other, *b, 0.5, 1.8, 5e-5)[:4]
    assert a == pytest.approx(b, rel=1e-9)


@pytest.mark.parametrize("law", [seals.SET_VALUED, seals.PRESLIDING])
def test_damping_of_a_moving_piston_is_its_viscous_force(law):
    """Pushed at constant speed, each piston answers with pressure, friction and damping times its speed."""
    speed, dt = 0.02, 5e-5
    forces = []
    for damping in (0.0, 200.0):
        ring_ = ring(law=law, damping=damping, count=3)._replace(inertia=1e4)  # a motor that hardly slows
        state = pistons.at_rest(ring_)
        q = (0.0, 0.0, 0.0, speed / ring_.arm)
        for _ in range(1000):
            q = pistons.step(ring_, state, *q, 0.0, 0.0, dt)[:4]
        forces.append(state.force[0])  # piston 0 stands at +y and is met head on
    assert forces[1] - forces[0] == pytest.approx(200.0 * speed, rel=1e-3)
