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
    """Stribeck friction of a turning axis.

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

    Notes
    -----
    Valid for steady sliding at the load and temperature of the measurement; viscous friction is apart (B).

    Examples
    --------
    At the speed of both decays, :math:`2/e + 1 - 1/e`:

    >>> plant = Plant(6.5, 0.48, 0.008, 0.02, 0.0016, 2.0, -2.0, 1.0, -1.0, 5.0, -5.0, 5.0, -5.0, 0.0)
    >>> [round(friction_torque(w, plant), 6) for w in (5.0, -5.0)]
    [1.367879, -1.367879]

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

    Parameters
    ----------
    rate : float
        :math:`\lambda = B/J` [1/s], not negative.
    time : float
        t [s], not negative.

    Returns
    -------
    tuple
        :math:`\varphi_1` [s] and :math:`\varphi_2` [s^2], to 1e-12 of their size.

    Notes
    -----
    Valid for rates and times that are not negative.

    Examples
    --------
    :math:`(1 - 1/e)/10` and :math:`1/(100 e)`; without damping :math:`t` and :math:`t^2/2`.

    >>> [round(part, 12) for part in response_integrals(10.0, 0.1)]
    [0.063212055883, 0.003678794412]
    >>> response_integrals(0.0, 2.0)
    (2.0, 2.0)

    References
    ----------
    Derived here: the response of a first-order lag, e.g. Altintas 2012, Manufacturing Automation, ch. 6.
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

    Notes
    -----
    Valid for a stiff transmission and steps in which friction changes little; exact where it is constant.

    Examples
    --------
    1.5 N m against 1 N m of stiction turn 0.01 kg m^2 at 50 rad/s^2: 5 rad/s and 0.25 rad after 0.1 s. 0.9 N m do not.

    >>> plant = Plant(6.5, 0.48, 0.01, 0.0, 0.002, 1.0, -1.0, 1.0, -1.0, 5.0, -5.0, 5.0, -5.0, 0.0)
    >>> [[round(v, 9) for v in advance(0.0, 0.0, t, 0.1, 0.1, 0.005, plant)] for t in (1.5, 0.9)]
    [[0.0005, 5.0], [0.0, 0.0]]

    References
    ----------
    Ozcan et al. 2017, sec. 2.2 and Fig. 1 (the equation); sticking and the exact step are derived here.
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

    Parameters
    ----------
    reference, velocity, acceleration : float
        Set point r [m] and its derivatives [m/s], [m/s^2].
    x : float
        Position of the motor side [m], rounded to the quantum of the encoder before it is used.
    integral, last_error : float
        I [m s] and :math:`e_{k-1}` [m] of the last sample.
    law : Controller
        Gains, sample time, saturation and encoder.

    Returns
    -------
    tuple
        Voltage after clipping [V], integral [m s], error [m], and whether the output was clipped.

    Notes
    -----
    Valid once a sample. The derivative is that of the error, unfiltered: one quantum of the encoder is a step of
    :math:`K_d q/T_s`.

    Examples
    --------
    1 mm at 5000 V/m; 4 mm would be 20 V, are clipped to 10 V, and the integral waits.

    >>> law = Controller(5000.0, 0.0, 0.0, 0.0, 0.0, 0.001, 10.0, 0.0, 0.0)
    >>> [control(r, 0.0, 0.0, 0.0, 0.0, 0.0, law) for r in (0.001, 0.004)]
    [(5.0, 1e-06, 0.001, False), (10.0, 0.0, 0.004, True)]

    References
    ----------
    Ozcan et al. 2017, sec. 2.3, Fig. 2 and Table 3; conditional integration: Åström & Hägglund 1995, PID Controllers, sec. 3.5.
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
    r"""Position of the load behind a play [m]: it moves only when the motor side pushes it.

    .. math:: x' = \min(\max(x, m - b/2), m + b/2)

    Parameters
    ----------
    output : float
        x, where the load is [m].
    motor_side : float
        m, position of the motor side [m].
    play : float
        b, whole play [m], not negative.

    Returns
    -------
    float
        x' [m].

    Notes
    -----
    Valid for a load that friction keeps where it is while nothing pushes it, also against the cutting force.

    Examples
    --------
    3 mm of way at 2 mm of play: half of the play stays behind. Half a millimetre back moves nothing.

    >>> played(0.0, 3.0, 2.0), played(2.0, 2.5, 2.0)
    (2.0, 2.0)

    References
    ----------
    Play operator, Krasnosel'skii and Pokrovskii 1989, Systems with Hysteresis.
    """
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
    """One sample of the controller of axis ``a``: what it applies until the next; True where it was clipped.

    Parameters
    ----------
    axis : Axis
        The drive.
    state : array (axes, 8)
        Changed in place: voltages, integral and last error.
    a : int
        Row of the axis.
    reference, velocity, acceleration : float
        Set point of this sample [m], [m/s], [m/s^2].

    Returns
    -------
    bool
        Whether :func:`control` was at its limit.

    Notes
    -----
    Valid at the sample instants. With a delay the voltage of the sample before is applied.

    Examples
    --------
    >>> plant = Plant(1.0, 0.5, 0.01, 0.0, 0.001, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 0.0)
    >>> law = Controller(5000.0, 0.0, 0.0, 0.0, 0.0, 0.001, 10.0, 0.0, 0.0)
    >>> state = at_rest(np.zeros(1))
    >>> served(Axis(plant, law, 0.001, 0.001, 5e-7), state, 0, 0.001, 0.0, 0.0), float(state[0, APPLIED])
    (False, 5.0)

    References
    ----------
    Ozcan et al. 2017, sec. 2.3, Fig. 2.
    """
    new, state[a, INTEGRAL], state[a, LAST], clipped = control(
        reference, velocity, acceleration, state[a, MOTOR], state[a, INTEGRAL], state[a, LAST], axis.law
    )
    state[a, APPLIED] = state[a, OUTPUT] if axis.law.delay > 0.5 else new
    state[a, OUTPUT] = new
    return clipped


@inlined_stepping
def fed(axis: Axis, state: FloatArray, a: int, force: float) -> None:
    """One step of axis ``a`` under the applied voltage and a force along it on the tool [N].

    .. math:: T = K_a K_t u + r_g F

    Parameters
    ----------
    axis : Axis
        The drive and its step.
    state : array (axes, 8)
        Changed in place: motor side, speed, load side now and before.
    a : int
        Row of the axis.
    force : float
        F [N], positive along the axis.

    Notes
    -----
    Valid for an amplifier that gives its current at once, and for a rigid transmission but for its play.

    Examples
    --------
    2 V give 1 N m and 100 rad/s^2; 500 N the other way at 1 mm/rad take half of it: 0.5 rad/s after 10 ms.

    >>> plant = Plant(1.0, 0.5, 0.01, 0.0, 0.001, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 0.0)
    >>> law = Controller(5000.0, 0.0, 0.0, 0.0, 0.0, 0.01, 10.0, 0.0, 0.0)
    >>> state = at_rest(np.zeros(1))
    >>> state[0, APPLIED] = 2.0
    >>> fed(Axis(plant, law, 0.01, 0.01, 5e-5), state, 0, -500.0)
    >>> round(float(state[0, SPEED]), 9), round(1e3 * float(state[0, LOAD]), 9)
    (0.5, 0.0025)

    References
    ----------
    Ozcan et al. 2017, sec. 2.2, Fig. 1: the cutting force is the disturbance torque.
    """
    plant = axis.plant
    gain = plant.current_gain * plant.torque_constant
    x, state[a, SPEED] = advance(
        state[a, MOTOR], state[a, SPEED], gain * state[a, APPLIED] + force * plant.transmission, axis.step, axis.phi1,
        axis.phi2, plant,
    )  # fmt: skip
    state[a, MOTOR] = x
    state[a, BEFORE] = state[a, LOAD]
    state[a, LOAD] = played(state[a, LOAD], x, plant.backlash)
