"""Linear analysis of a position loop without friction: frequency response, margins, bandwidth, poles."""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.later import later
from cutwise.physics.motion.drives import Controller, Plant, response_integrals

if TYPE_CHECKING:
    from scipy import optimize
else:
    optimize = later("scipy.optimize")

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


class LoopFigures(NamedTuple):
    """What the linear loop says about an axis."""

    phase_margin: float  # of the continuous loop [rad], the least over all gain crossings
    bandwidth: float  # of the continuous closed loop, -3 dB [Hz]
    resonance: float  # largest magnitude of the continuous closed loop [-]
    damping: float  # ratio of the dominant oscillating poles [-], 1 without such
    sampled_phase_margin: float  # with zero-order hold, sample time and delay [rad]
    sampled_gain_margin: float  # to instability by more gain, sampled [-]; infinite if none
    least_gain: (
        float  # factor down to which the gain of the stable sampled loop may fall [-]; 0 if it may fall to nothing
    )
    sampled_bandwidth: float  # [Hz], 0 if the sampled loop is unstable
    largest_pole: float  # largest |z| of the sampled loop [-]: stable below 1
    poles: ComplexArray  # of the continuous closed loop [1/s], shape (3,)

    @property
    def stable(self) -> bool:
        """Whether the sampled loop is stable."""
        return self.largest_pole < 1.0


def _gain(plant: Plant) -> float:
    return plant.current_gain * plant.torque_constant * plant.transmission


def open_loop(omega: FloatArray, plant: Plant, law: Controller) -> ComplexArray:
    r"""Continuous loop gain from position error to position.

    .. math:: L(s) = \left(K_p + \frac{K_i}{s} + K_d s\right) \frac{K_a K_t r_g}{s (J s + B)}, \qquad s = i\omega

    ``omega`` in rad/s, any shape; the result has that shape.

    Valid without friction, play, saturation and sampling.

    References
    ----------
    Ozcan et al. 2017, Figs. 1 and 2.
    """
    s = 1j * np.asarray(omega, dtype=np.float64)
    pid = law.proportional + law.integral / s + law.derivative * s
    return np.asarray(pid * _gain(plant) / (s * (plant.inertia * s + plant.viscous)))


def held_plant(plant: Plant, sample_time: float) -> tuple[FloatArray, FloatArray]:
    r"""Zero-order-hold equivalent of :math:`K/(s(Js+B))`: numerator and denominator in z, highest power first.

    .. math:: G(z) = \frac{K}{J}\,\frac{\varphi_2 z + (T\varphi_1 - \varphi_2)}{z^2 - (1+E) z + E},
              \qquad E = e^{-BT/J},\ \varphi_1 = \int_0^T e^{-Bt/J} dt,\ \varphi_2 = \int_0^T \varphi_1 dt

    with the integrals over one sample; the constant term follows from the state equation.

    Valid for a voltage that is held over the sample time [s].

    References
    ----------
    Åström and Wittenmark 1997, Computer-Controlled Systems, sec. 2.3.
    """
    rate = plant.viscous / plant.inertia
    e = math.exp(-rate * sample_time)
    phi1, phi2 = response_integrals(rate, sample_time)
    k = _gain(plant) / plant.inertia
    return np.array([k * phi2, k * (phi1 * phi1 - e * phi2)]), np.array([1.0, -(1.0 + e), e])


def sampled_loop(plant: Plant, law: Controller) -> tuple[FloatArray, FloatArray]:
    r"""Loop gain of the sampled controller with the held plant: numerator and denominator in z.

    .. math:: C(z) = K_p + K_i T \frac{z}{z-1} + \frac{K_d}{T}\frac{z-1}{z}

    Valid for small motion about a place without friction, in volt, metre and second.

    References
    ----------
    Åström and Wittenmark 1997, Computer-Controlled Systems, sec. 8.5 (digital PID); Ozcan et al. 2017, Fig. 2.
    """
    t = law.sample_time
    controller = np.polyadd(
        np.polyadd(law.proportional * np.array([1.0, -1.0, 0.0]), law.integral * t * np.array([1.0, 0.0, 0.0])),
        law.derivative / t * np.array([1.0, -2.0, 1.0]),
    )
    numerator, denominator = held_plant(plant, t)
    delay = np.array([1.0, 0.0]) if law.delay > 0.5 else np.array([1.0])
    whole = np.polymul(np.polymul(np.array([1.0, -1.0, 0.0]), denominator), delay)
    return np.polymul(controller, numerator), whole  # type: ignore[return-value]


def sampled_response(omega: FloatArray, plant: Plant, law: Controller) -> ComplexArray:
    """Sampled loop gain at angular frequencies [rad/s] below half the sample rate.

    References
    ----------
    Åström and Wittenmark 1997, Computer-Controlled Systems, ch. 3.
    """
    numerator, denominator = sampled_loop(plant, law)
    z = np.exp(1j * np.asarray(omega) * law.sample_time)
    return np.asarray(np.polyval(numerator, z) / np.polyval(denominator, z))


def discrete_poles(plant: Plant, law: Controller) -> ComplexArray:
    """Poles z of the sampled closed loop, without friction.

    References
    ----------
    Derived here: the roots of :math:`1 + L(z) = 0`.
    """
    numerator, denominator = sampled_loop(plant, law)
    return np.asarray(np.roots(np.polyadd(numerator, denominator)))


def continuous_poles(plant: Plant, law: Controller) -> ComplexArray:
    """Poles s [1/s] of the continuous closed loop :math:`J s^3 + (B + K K_d) s^2 + K K_p s + K K_i`.

    References
    ----------
    Derived here: the roots of :math:`1 + L(s) = 0` for :func:`open_loop`.
    """
    k = _gain(plant)
    return np.asarray(
        np.roots([plant.inertia, plant.viscous + k * law.derivative, k * law.proportional, k * law.integral])
    )


def largest_pole(plant: Plant, law: Controller) -> float:
    """Largest magnitude of a pole z of the sampled loop; below 1 the loop is stable.

    References
    ----------
    Åström and Wittenmark 1997, Computer-Controlled Systems, ch. 3.
    """
    return float(np.max(np.abs(discrete_poles(plant, law))))


@lru_cache(maxsize=64)
def loop_figures(plant: Plant, law: Controller) -> LoopFigures:
    """Margins, bandwidth and poles of one axis; friction, saturation and encoder are left out.

    References
    ----------
    Åström and Hägglund 1995, PID Controllers, ch. 4 (margins); the search for them is derived here.
    """
    poles = continuous_poles(plant, law)
    swinging = poles[np.abs(poles.imag) > 1e-9 * np.abs(poles)]
    damping = float(np.min(-swinging.real / np.abs(swinging))) if swinging.size else 1.0
    grid = np.geomspace(0.1, 1e5, 4000)

    def loop(w: FloatArray) -> ComplexArray:
        return open_loop(w, plant, law)

    nyquist = math.pi / law.sample_time
    sampled_grid = np.geomspace(0.1, nyquist * (1.0 - 1e-9), 4000)

    def sampled(w: FloatArray) -> ComplexArray:
        return sampled_response(w, plant, law)

    largest = largest_pole(plant, law)
    margin = _gain_change(plant, law, 1e4 if largest < 1.0 else 1e-4)
    closed = np.abs(loop(grid) / (1.0 + loop(grid)))
    return LoopFigures(
        phase_margin=_phase_margin(loop, grid),
        bandwidth=_bandwidth(loop, grid),
        resonance=float(np.max(closed)),
        damping=damping,
        sampled_phase_margin=_phase_margin(sampled, sampled_grid),
        sampled_gain_margin=margin,
        least_gain=_gain_change(plant, law, 1e-4) if largest < 1.0 else 0.0,
        sampled_bandwidth=_bandwidth(sampled, sampled_grid) if largest < 1.0 else 0.0,
        largest_pole=largest,
        poles=poles,
    )


def _phase_margin(loop, grid: FloatArray) -> float:  # type: ignore[no-untyped-def]
    """Least phase margin over all gain crossings [rad]; pi if the gain never crosses one."""
    level = np.log(np.abs(loop(grid)))
    margins = []
    for i in np.nonzero(level[:-1] * level[1:] < 0.0)[0]:
        cross = optimize.brentq(lambda w: math.log(abs(complex(loop(w)))), grid[i], grid[i + 1], xtol=1e-12, rtol=1e-14)
        margins.append(_wrapped(math.pi + float(np.angle(loop(cross)))))
    return min(margins, default=math.pi)


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def _bandwidth(loop, grid: FloatArray) -> float:  # type: ignore[no-untyped-def]
    """First frequency [Hz] at which the closed loop falls below -3 dB; the end of the grid if it does not."""

    def level(w: FloatArray) -> FloatArray:
        return np.asarray(np.abs(loop(w) / (1.0 + loop(w))) - math.sqrt(0.5))

    values = level(grid)
    falls = np.nonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))[0]
    if falls.size == 0:
        return float(grid[-1] / (2.0 * math.pi))
    i = int(falls[0])
    return float(optimize.brentq(level, grid[i], grid[i + 1], xtol=1e-12, rtol=1e-14)) / (2.0 * math.pi)


def _gain_change(plant: Plant, law: Controller, farthest: float) -> float:
    """First factor on the loop gain, from 1 to ``farthest``, at which the sampled loop turns stable or unstable.

    Infinite or 0 if there is none on the way up or down.
    """
    numerator, denominator = sampled_loop(plant, law)

    def excess(factors: FloatArray) -> FloatArray:
        """Largest magnitude of z less one at each factor, from the companion matrices of all of them at once."""
        characteristic = np.array([np.polyadd(factor * numerator, denominator) for factor in factors])
        companion = np.repeat(np.eye(characteristic.shape[1] - 1, k=-1)[np.newaxis], factors.size, axis=0)
        companion[:, 0] = -characteristic[:, 1:] / characteristic[:, :1]
        return np.asarray(np.abs(np.linalg.eigvals(companion)).max(axis=1) - 1.0)

    stable_now = bool(excess(np.ones(1))[0] < 0.0)
    factors = np.geomspace(1.0, farthest, 400)
    changes = np.flatnonzero((excess(factors) < 0.0) != stable_now)
    if changes.size == 0:
        return math.inf if farthest > 1.0 else 0.0
    first = int(changes[0])
    return float(optimize.brentq(lambda factor: excess(np.array([factor]))[0], factors[first - 1], factors[first]))
