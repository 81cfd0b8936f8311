"""Every option of the edge loop has a limit in which it becomes the simpler model."""

import numpy as np
import pytest

from cutwise.physics.motion.edge import programmed_motion
from cutwise.physics.structure.seals import NO_FRICTION, PRESLIDING, REGULARISED, SET_VALUED
from cutwise.process.loops import TOOTH_RESOLVED, run_compliant_edge
from peers.cells import MM, end_error, error_at_tool, r0


def test_stiff_seals_are_coulomb():
    assert end_error(law=PRESLIDING, travel=0.1e-6) == pytest.approx(end_error(), abs=1e-4)


def test_stiff_seals_are_coulomb_with_a_stribeck_fall_too():
    """The fall from static to dynamic friction belongs to both laws, or presliding would not become the set-valued one."""
    coulomb = end_error(law=SET_VALUED, stribeck=1e-3)
    assert end_error(law=PRESLIDING, travel=0.1e-6, stribeck=1e-3) == pytest.approx(coulomb, abs=1e-4)


def test_slow_regularised_friction_is_no_friction():
    assert end_error(law=REGULARISED, stribeck=10.0) == pytest.approx(end_error(law=NO_FRICTION), abs=2e-3)


def test_steep_regularised_friction_tends_to_stick():
    """The law F_s tanh(v / v_s) tends to Coulomb friction that slides at its static limit."""

    def end(law, stribeck=0.0):
        cell = r0(law=law, stribeck=stribeck)
        piston = cell.ring.piston._replace(friction_dynamic=cell.ring.piston.friction_static)
        cell = cell._replace(ring=cell.ring._replace(piston=piston))
        return error_at_tool(cell, run_compliant_edge(cell, 20e-6))[-1] / MM

    stick = end(SET_VALUED)
    errors = [abs(end(REGULARISED, v) - stick) for v in (1e-3, 1e-4, 1e-5, 1e-6)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 2e-3


def test_fast_stribeck_fall_is_the_fall_at_once():
    slow = end_error(law=PRESLIDING, travel=50e-6, stribeck=0.05e-3)
    assert slow == pytest.approx(end_error(law=PRESLIDING, travel=50e-6), abs=5e-4)


def test_slices_of_a_mill_on_a_long_arm_are_one():
    """A long motor tilts little: with the lever ratio kept, slices change nothing."""
    long = {"reach": 15.0, "arm": 8.0}
    cells = [r0(slices=n, **long) for n in (1, 5)]
    cells = [c._replace(ring=c.ring._replace(inertia=c.ring.inertia * 1e4)) for c in cells]
    one, five = (error_at_tool(c, run_compliant_edge(c, 50e-6))[-1] / MM for c in cells)
    assert five == pytest.approx(one, abs=2e-3)


def test_slices_converge():
    errors = np.array([end_error(slices=n) for n in (4, 8, 16, 32, 64)])
    assert np.abs(np.diff(errors))[-1] < 2e-5
    assert np.abs(errors - errors[-1]).max() < 1e-3


@pytest.mark.slow
def test_tooth_resolved_statistics():
    """2.5 µs steps against 0.625 µs of the reference: means and rms within 2 %."""
    cell = r0(force=TOOTH_RESOLVED)
    history = run_compliant_edge(cell, 2.5e-6)
    steady = history.motion.time >= 0.45
    mean = history.burr_force.mean[steady].mean(0)
    rms = np.sqrt(history.burr_force.square[steady].mean(0))
    assert mean == pytest.approx([5.747, 9.348, 3.819], rel=0.02)
    assert rms == pytest.approx([5.766, 9.509, 3.867], rel=0.02)
    assert history.burr_force.peak.max(0) == pytest.approx([11.20, 13.88, 5.730], rel=0.03)


def test_weight_moves_the_error_as_its_moment():
    """Upright, gravity has no moment; sideways it leans on the tip with m g l / L_t."""
    upright = end_error()
    assert end_error(moment=(0.0, 0.0)) == upright
    down = end_error(moment=(0.0, -0.6 * 9.80665 * 0.075))
    up = end_error(moment=(0.0, 0.6 * 9.80665 * 0.075))
    assert down < upright < up


@pytest.mark.parametrize("scale", [(10.0, 1.0, 1.0), (1.0, 10.0, 1.0), (1.0, 1.0, 10.0), (0.1, 3.0, 7.0)])
def test_scaling_of_units(scale):
    """Rescale length, mass and time: the error follows as a length."""
    length, mass, time = scale
    force, stress = mass * length / time**2, mass / length / time**2
    cell = r0(duration=0.3)
    path, layers, cutter, ring, reach, *_ = cell
    k = cutter.edges.linear
    scaled = cell._replace(
        path=path._replace(feed=path.feed * length / time, duration=path.duration * time, lead_in=path.lead_in * time,
                           start_height=path.start_height * length, preset=path.preset * length),
        layers=layers._replace(
            burr_height=layers.burr_height._replace(value=layers.burr_height.value * length),
            burr_width=layers.burr_width._replace(value=layers.burr_width.value * length),
            strips=layers.strips._replace(work_width=layers.strips.work_width * length)),
        cutter=cutter._replace(
            mill=cutter.mill._replace(radius=cutter.mill.radius * length),
            spindle_speed=cutter.spindle_speed / time,
            edges=cutter.edges._replace(linear=type(k)(*(x * stress for x in k[:3]), *(x * stress * length for x in k[3:])))),
        ring=ring._replace(
            piston=ring.piston._replace(stroke=ring.piston.stroke * length,
                                        pressure_force=ring.piston.pressure_force * force,
                                        friction_static=ring.piston.friction_static * force,
                                        friction_dynamic=ring.piston.friction_dynamic * force),
            arm=ring.arm * length, inertia=ring.inertia * mass * length**2, tolerance=ring.tolerance * force),
        reach=reach * length,
    )  # fmt: skip
    a = run_compliant_edge(cell, 50e-6).response.tilt
    b = run_compliant_edge(scaled, 50e-6 * time).response.tilt
    assert b[-1] == pytest.approx(a[-1], rel=1e-4)  # the speed that counts as stuck is a fixed one


def test_seal_damping_changes_no_equilibrium():
    """Viscous seals slow the way to the equilibrium; where Coulomb friction leaves a band, they end elsewhere in it."""
    plain, damped = (end_error(law=NO_FRICTION, damping=c, duration=1.5) for c in (0.0, 100.0))
    assert damped == pytest.approx(plain, abs=1e-4)
    assert end_error(law=PRESLIDING, damping=1e-6) == pytest.approx(end_error(law=PRESLIDING), abs=1e-6)


def test_damped_seals_do_not_move_with_the_step():
    coarse, fine = (end_error(law=PRESLIDING, damping=100.0, arm=0.1, time_step=dt) for dt in (40e-6, 5e-6))
    assert coarse == pytest.approx(fine, abs=2e-4)


def test_without_lead_out_the_tool_stays_at_its_preset():
    """Tooth by tooth, forces are asked for beyond the last step: the programmed motion goes on there."""
    cell = r0()
    after = programmed_motion(cell.path, cell.path.duration + 1e-4)
    assert after.height == -cell.path.preset
    assert after.climb == 0.0
