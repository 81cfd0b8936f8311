"""A feed drive against an exact filter, a stiff solver, and balances of momentum and energy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from cutwise.maths.linearc import join
from cutwise.paths.pocket import corner
from cutwise.physics.motion.contour import contour_errors
from cutwise.physics.motion.drives import Controller, advance, control, friction_torque, played, response_integrals
from cutwise.physics.motion.lookahead import plan
from cutwise.physics.motion.loop import sampled_loop
from cutwise.physics.motion.reference import sampled
from peers import corner as peer
from peers.corner import NO_FORCE, NO_FRICTION, X, Y, laws

SLICK = X._replace(**dict(zip(X._fields[5:13], NO_FRICTION, strict=True)))


def step(x, w, torque, time, plant):
    return advance(x, w, torque, time, *response_integrals(plant.viscous / plant.inertia, time), plant)


def test_step_without_friction_is_the_exact_response():
    x, w = step(0.0, 10.0, 0.7, 0.05, SLICK)
    exact = solve_ivp(
        lambda _, s: [SLICK.transmission * s[1], (0.7 - SLICK.viscous * s[1]) / SLICK.inertia],
        (0.0, 0.05), [0.0, 10.0], method="DOP853", rtol=1e-13, atol=1e-16,
    ).y[:, -1]  # fmt: skip
    assert (x, w) == pytest.approx(tuple(exact), rel=1e-12)


def test_speed_comes_to_zero_exactly_and_sticks():
    x, w = step(0.0, 1.0, 0.5, 0.1, X)
    assert w == 0.0
    assert 0.0 < x < X.transmission * 0.1
    assert step(x, 0.0, 2.6, 0.1, X) == (x, 0.0)
    assert step(x, 0.0, 2.7, 0.1, X)[1] > 0.0
    assert step(x, 0.0, -1.86, 0.1, X) == (x, 0.0)
    assert step(x, 0.0, -1.88, 0.1, X)[1] < 0.0


def test_reversal_within_a_step_goes_on_against_the_other_friction():
    """Stop at the zero instant, then break away with the stiction of the new sign."""
    _, w = step(0.0, 1.0, -8.0, 0.02, X)
    opposing = friction_torque(1.0, X)
    stop = -math.log1p(X.viscous * 1.0 / (-8.0 - opposing - X.viscous)) * X.inertia / X.viscous
    phi1, _ = response_integrals(X.viscous / X.inertia, 0.02 - stop)
    assert w == pytest.approx((-8.0 - X.stiction_minus) / X.inertia * phi1, rel=1e-12)


def test_response_integrals_join_their_series_smoothly():
    for time in (1e-9, 0.999e-3, 1.001e-3, 0.3):
        phi1, phi2 = response_integrals(1.0, time)
        assert phi1 == pytest.approx(-math.expm1(-time), rel=1e-12)
        assert phi2 == pytest.approx(time + math.expm1(-time), rel=1e-9)
    assert response_integrals(0.0, 2.0) == (2.0, 2.0)


def smooth_friction(w, plant, width):
    """Friction with a steep tanh through zero, for a stiff solver."""
    side = np.where(w >= 0.0, 1.0, -1.0)
    return np.tanh(w / width) * side * friction_torque.py_func(w if w != 0.0 else 1e-300, plant)


@pytest.mark.parametrize(("substeps", "allowed"), [(1, 1.5), (10, 0.2), (160, 0.08)])
def test_stick_slip_against_a_stiff_solver(substeps, allowed):
    """Open loop, four reversals, 1.8 mm of travel [µm]: 1.2 / 0.05 / 0.04 off, the last being the width of the tanh."""

    def torque(t):
        return 4.0 * math.sin(2.0 * math.pi * 4.0 * t)

    reference = solve_ivp(
        lambda t, s: [
            1e6 * X.transmission * s[1],
            (torque(t) - X.viscous * s[1] - smooth_friction(s[1], X, 1e-4)) / X.inertia,
        ],
        (0.0, 0.5), [0.0, 0.0], method="Radau", rtol=1e-8, atol=1e-9, max_step=1e-3,
    )  # fmt: skip
    dt = 1e-3 / substeps
    x, w = 0.0, 0.0
    for k in range(500 * substeps):
        x, w = step(x, w, torque((k + 0.5) * dt), dt, X)
    assert 1e6 * x == pytest.approx(reference.y[0, -1], abs=allowed)


@pytest.mark.parametrize("delay", [0.0, 1.0])
def test_the_sampled_loop_without_friction_is_a_digital_filter(delay):
    """The held plant and the controller as one transfer function in z give the same corner, delay included."""
    curve = join(corner(0.03, 0.5 * math.pi, 2e-3))
    planned = plan(curve, np.full(3, 0.04), peer.LIMITS)
    reference = sampled(curve, [planned.profile], 1e-3, 1.0)
    plants = tuple(p._replace(**dict(zip(p._fields[5:13], NO_FRICTION, strict=True))) for p in (X, Y))
    exact = []
    for axis, (plant, law) in enumerate(zip(plants, laws("kp_ki_swapped", delay=delay, k2=(0.0, 0.0)), strict=True)):
        top, bottom = sampled_loop(plant, law)
        top = np.concatenate((np.zeros(len(bottom) - len(top)), top))
        start = reference.point[0, axis]
        exact.append(start + lfilter(top, top + bottom, reference.point[:, axis] - start))
    error = contour_errors(curve, reference.block, np.column_stack(exact), True)
    ours = peer.run(2e-3, law=NO_FORCE, plants=plants, delay=delay, k2=(0.0, 0.0))
    assert ours["error"] == pytest.approx(error, abs=1e-12)


def test_friction_never_adds_energy():
    rng = np.random.default_rng(4)
    for _ in range(200):
        w, torque = rng.normal(0.0, 5.0), rng.normal(0.0, 5.0)
        x, after = step(0.0, w, torque, 1e-3, X)
        gained = 0.5 * X.inertia * (after**2 - w**2)
        supplied = torque * x / X.transmission
        assert gained <= supplied + 1e-12


def test_anti_windup_keeps_the_sum_unless_it_unwinds():
    law = Controller(1e3, 1e5, 0.0, 0.0, 0.0, 1e-3, 10.0, 0.0, 0.0)
    assert control(0.1, 0.0, 0.0, 0.0, 0.5e-3, 0.1, law) == (10.0, 0.5e-3, 0.1, True)
    assert control(-1e-4, 0.0, 0.0, 0.0, 5e-3, -1e-4, law)[1] == pytest.approx(5e-3 - 1e-7)
    u, _, error, clipped = control(1.4e-6, 0.0, 0.0, 0.0, 0.0, 0.0, law._replace(encoder=1e-6))
    assert (error, clipped) == (1.4e-6, False)
    assert u == pytest.approx(1e3 * 1.4e-6 + 1e5 * 1.4e-9)


def test_backlash_is_a_play():
    assert played(0.0, 1e-6, 3e-6) == 0.0
    assert played(0.0, 5e-6, 3e-6) == pytest.approx(3.5e-6)
    assert played(3.5e-6, 4e-6, 3e-6) == 3.5e-6
    found = peer.run(2e-3, plants=(X._replace(backlash=3e-6), Y._replace(backlash=3e-6)), law=NO_FORCE)
    still = peer.run(2e-3, law=NO_FORCE)
    assert 0.5 < abs(found["max"] - still["max"]) < 3.1 or abs(found["rms"] - still["rms"]) > 0.1
