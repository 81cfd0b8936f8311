"""One feed drive: position controller, amplifier, motor, and friction that truly sticks."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled, inlined_stepping
from cutwise.maths.curves import FloatArray


class Plant(NamedTuple):
    """Amplifier, motor and transmission of an axis; the friction parameters of w < 0 are negative."""

    current_gain: float  # K_a [A/V]
    torque_constant: float  # K_t [N m/A]
    inertia: float  # J [kg m^2], all reflected to the motor
    viscous: float  # B [N m s/rad]
    transmission: float  # r_g [m/rad]
    stiction_plus: float  # T_s+ [N m]
    stiction_minus: float  # T_s- [N m]
    coulomb_plus: float  # T_c+ [N m]
    coulomb_minus: float  # T_c- [N m]
    decay_plus: float  # W_1+ [rad/s]
    decay_minus: float  # W_1- [rad/s]
    rise_plus: float  # W_2+ [rad/s]
    rise_minus: float  # W_2- [rad/s]
    backlash: float  # whole play of the transmission [m]


class Controller(NamedTuple):
    """PID on the position error with feedforward, at its sample time."""

    proportional: float  # K_p [V/m]
    integral: float  # K_i [V/(m s)]
    derivative: float  # K_d [V s/m]
    acceleration_feedforward: float  # K_1 [V s^2/m]
    velocity_feedforward: float  # K_2 [V s/m]
    sample_time: float  # T_s [s]
    saturation: float  # largest output [V]
    encoder: float  # position quantum [m], 0 for none
    delay: float  # 0 or 1: the output of the last sample is applied


class Drive(NamedTuple):
    """A feed drive of one axis."""

    plant: Plant
    law: Controller


class Axis(NamedTuple):
    """A feed drive that is stepped by a fixed time; see :func:`axes_of`."""

    plant: Plant
    law: Controller
    step: float  # [s]
    phi1: float  # [s] :func:`response_integrals` of the step
    phi2: float  # [s^2]


MOTOR, SPEED, INTEGRAL, LAST, OUTPUT, LOAD, BEFORE, APPLIED = range(8)  # columns of the state of an axis
"""Motor side [m], its speed [rad/s], integral [m s] and last error [m] of the controller, its output and the voltage
that is applied [V], load side now and one step before [m]."""


@compiled
def friction_torque(w: float, plant: Plant) -> float:
    r"""Stribeck friction of a turning axis.

    .. math:: T_f = T_s e^{-w/W_1} + T_c (1 - e^{-w/W_2})

    with the parameters of the sign of :math:`w`. At rest the torque is whatever balances the others, up to
    :math:`T_s`; see :func:`advance`.

    Parameters
    ----------
    w : float
        Motor speed [rad/s], not zero.
    plant : Plant
        The axis.

    Returns
    -------
    float
        Friction torque [N m], of the sign of ``w``.

    References
    ----------
    Erkorkmaz & Altintas 2001, Int. J. Mach. Tools Manuf. 41 (form of the law).
    """
    if w > 0.0:
        return plant.stiction_plus * math.exp(-w / plant.decay_plus) + plant.coulomb_plus * (
            1.0 - math.exp(-w / plant.rise_plus)
        )
    return plant.stiction_minus * math.exp(-w / plant.decay_minus) + plant.coulomb_minus * (
        1.0 - math.exp(-w / plant.rise_minus)
    )


@compiled
def response_integrals(rate: float, time: float) -> tuple[float, float]:
    r"""Speed and angle gained per unit of initial acceleration, :math:`\int e^{-\lambda t}` and its integral.

    .. math:: \varphi_1 = (1 - e^{-\lambda t})/\lambda, \qquad \varphi_2 = (t - \varphi_1)/\lambda
    """
    x = rate * time
    if x < 1e-3:  # the series keeps the digits that the difference loses, and covers lambda = 0
        phi1 = time * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0))))
        phi2 = 0.5 * time * time * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0))))
        return phi1, phi2
    phi1 = -math.expm1(-x) / rate
    return phi1, (time - phi1) / rate


@compiled
def advance(
    x: float, w: float, drive_torque: float, time: float, phi1: float, phi2: float, plant: Plant
) -> tuple[float, float]:
    r"""Position and speed after a step of constant torque, with friction as at its start; zero speed is met exactly.

    .. math:: J \dot w + B w = T - T_f(w), \qquad \dot x = r_g w

    Where the speed comes to zero inside the step, the axis stops at that instant, and sticks for the rest of the step
    if :math:`T_{s-} \le T \le T_{s+}`; otherwise it breaks away with :math:`T_{s\pm}` opposing.

    Parameters
    ----------
    x : float
        Position of the motor side [m].
    w : float
        Motor speed [rad/s]; exactly zero means at rest.
    drive_torque : float
        Motor torque plus load torque :math:`T` [N m].
    time : float
        Step [s].
    phi1, phi2 : float
        :func:`response_integrals` of the step.
    plant : Plant
        The axis.

    Returns
    -------
    tuple
        Position [m] and speed [rad/s] at the end.
    """
    if w == 0.0:
        if plant.stiction_minus <= drive_torque <= plant.stiction_plus:
            return x, 0.0
        opposing = plant.stiction_plus if drive_torque > 0.0 else plant.stiction_minus
    else:
        opposing = friction_torque(w, plant)
    gain = (drive_torque - opposing - plant.viscous * w) / plant.inertia
    after = w + gain * phi1
    if w * after >= 0.0:
        return x + plant.transmission * (w * time + gain * phi2), after
    rate = plant.viscous / plant.inertia
    stop = -math.log1p(rate * w / gain) / rate if rate > 0.0 else -w / gain
    stop = min(max(stop, 0.0), time)
    part1, part2 = response_integrals(rate, stop)
    x += plant.transmission * (w * stop + gain * part2)
    if plant.stiction_minus <= drive_torque <= plant.stiction_plus:
        return x, 0.0
    opposing = plant.stiction_plus if drive_torque > 0.0 else plant.stiction_minus
    gain = (drive_torque - opposing) / plant.inertia
    part1, part2 = response_integrals(rate, time - stop)
    return x + plant.transmission * gain * part2, gain * part1


@compiled
def control(
    reference: float,
    velocity: float,
    acceleration: float,
    x: float,
    integral: float,
    last_error: float,
    law: Controller,
) -> tuple[float, float, float, bool]:
    r"""Output of the position controller, with conditional anti-windup.

    .. math:: u = K_p e + K_i I + K_d (e - e_{k-1})/T_s + K_1 \ddot r + K_2 \dot r, \qquad I = \sum e\,T_s

    The new sum is kept only if the output is within the saturation or the error drives it back.

    Returns
    -------
    tuple
        Voltage after clipping [V], integral [m s], error [m], and whether the output was clipped.
    """
    measured = x
    if law.encoder > 0.0:
        measured = math.floor(x / law.encoder + 0.5) * law.encoder
    error = reference - measured
    summed = integral + error * law.sample_time
    u = (
        law.proportional * error
        + law.integral * summed
        + law.derivative * (error - last_error) / law.sample_time
        + law.acceleration_feedforward * acceleration
        + law.velocity_feedforward * velocity
    )
    if abs(u) <= law.saturation:
        return u, summed, error, False
    kept = summed if u * error < 0.0 else integral
    return min(max(u, -law.saturation), law.saturation), kept, error, True


@compiled
def played(output: float, motor_side: float, play: float) -> float:
    """Position of the load behind a play [m]: it moves only when the motor side pushes it."""
    half = 0.5 * play
    return min(max(output, motor_side - half), motor_side + half)


def axes_of(drives: Sequence[Drive], substeps: int) -> tuple[Axis, ...]:
    """Axes that are stepped ``substeps`` times in a sample of their controllers.

    Raises
    ------
    ValueError
        The sample times differ, there are no substeps, or more axes than x, y and z.
    """
    if not 2 <= len(drives) <= 3:
        raise ValueError(f"a force acts along x, y and z; there are {len(drives)} drives")
    if len({drive.law.sample_time for drive in drives}) != 1:
        raise ValueError("all axes need the same sample time")
    if substeps < 1:
        raise ValueError("at least one substep per servo step is needed")
    found = []
    for plant, law in drives:
        step = law.sample_time / substeps
        found.append(Axis(plant, law, step, *response_integrals(plant.viscous / plant.inertia, step)))
    return tuple(found)


def at_rest(point: FloatArray) -> FloatArray:
    """The state of axes that stand at a point [m], integrals and last errors zero; shape (axes, 8)."""
    state = np.zeros((len(point), 8))
    state[:, MOTOR] = state[:, LOAD] = state[:, BEFORE] = point
    return state


@inlined_stepping
def served(
    axis: Axis, state: FloatArray, a: int, reference: float, velocity: float, acceleration: float
) -> bool:  # fmt: skip
    """One sample of the controller of axis ``a``: what it applies until the next; True where it was clipped."""
    new, state[a, INTEGRAL], state[a, LAST], clipped = control(
        reference, velocity, acceleration, state[a, MOTOR], state[a, INTEGRAL], state[a, LAST], axis.law
    )
    state[a, APPLIED] = state[a, OUTPUT] if axis.law.delay > 0.5 else new
    state[a, OUTPUT] = new
    return clipped


@inlined_stepping
def fed(axis: Axis, state: FloatArray, a: int, force: float) -> None:
    """One step of axis ``a`` under the applied voltage and a force along it on the tool [N]."""
    plant = axis.plant
    gain = plant.current_gain * plant.torque_constant
    x, state[a, SPEED] = advance(
        state[a, MOTOR], state[a, SPEED], gain * state[a, APPLIED] + force * plant.transmission, axis.step, axis.phi1,
        axis.phi2, plant,
    )  # fmt: skip
    state[a, MOTOR] = x
    state[a, BEFORE] = state[a, LOAD]
    state[a, LOAD] = played(state[a, LOAD], x, plant.backlash)
