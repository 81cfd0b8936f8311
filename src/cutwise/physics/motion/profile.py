"""Jerk-limited speed profiles: seven phases per stretch, any speeds at its ends."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]


class Limits(NamedTuple):
    """What the motion may do along the path."""

    speed: float  # [m/s]
    acceleration: float  # [m/s^2]
    jerk: float  # [m/s^3]


class Profile(NamedTuple):
    """Motion along the path in phases of constant jerk, ``n`` of them; the state holds at the start of each phase."""

    time: FloatArray  # [s], shape (n+1,), the last is the end
    position: FloatArray  # [m], shape (n+1,)
    speed: FloatArray  # [m/s], shape (n+1,)
    acceleration: FloatArray  # [m/s^2], shape (n+1,)
    jerk: FloatArray  # [m/s^3], shape (n,)

    @property
    def duration(self) -> float:
        """Time from the first to the last instant [s]."""
        return float(self.time[-1] - self.time[0])


@compiled
def ramp_time(change: float, acceleration: float, jerk: float) -> float:
    r"""Shortest time to change the speed, from and to zero acceleration.

    .. math:: T = \Delta v / a + a / j \;\text{ for } \Delta v\, j \ge a^2, \qquad T = 2\sqrt{\Delta v / j} \text{ else}

    Parameters
    ----------
    change : float
        Change of speed [m/s], of either sign.
    acceleration, jerk : float
        Limits [m/s^2], [m/s^3], positive.

    Returns
    -------
    float
        Time [s].

    Notes
    -----
    Valid for one limit of acceleration either way, and a drive that follows the jerk at once.

    Examples
    --------
    2 m/s at 2 m/s^2 and 4 m/s^3, and 0.25 m/s, which do not reach that acceleration:

    >>> ramp_time(2.0, 2.0, 4.0), ramp_time(-0.25, 2.0, 4.0)
    (1.5, 0.5)

    References
    ----------
    Standard seven-phase profile, e.g. Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    change = abs(change)
    if change * jerk >= acceleration * acceleration:
        return change / acceleration + acceleration / jerk
    return 2.0 * math.sqrt(change / jerk)


@compiled
def ramp_distance(v0: float, v1: float, acceleration: float, jerk: float) -> float:
    """Distance run during the shortest change of speed, :math:`(v_0+v_1)T/2` [m].

    Parameters
    ----------
    v0, v1 : float
        Speeds at both ends [m/s].
    acceleration, jerk : float
        Limits [m/s^2], [m/s^3], positive.

    Returns
    -------
    float
        Distance [m]. Valid for ramps between states without acceleration: their speed is odd about the middle.

    Examples
    --------
    >>> ramp_distance(0.0, 2.0, 2.0, 4.0)
    1.5

    References
    ----------
    Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    return 0.5 * (v0 + v1) * ramp_time(v1 - v0, acceleration, jerk)


@compiled
def reachable_speed(v0: float, length: float, ceiling: float, acceleration: float, jerk: float) -> float:
    """Highest speed [m/s], at most ``ceiling``, that a ramp from ``v0`` reaches within ``length`` [m].

    Solves :math:`(v_0 + v) T(v - v_0)/2 = s` by bisection, to the last bit.

    Parameters
    ----------
    v0, ceiling : float
        Speed at the start, and highest [m/s].
    length : float
        s [m].
    acceleration, jerk : float
        Limits [m/s^2], [m/s^3], positive.

    Returns
    -------
    float
        Speed [m/s]; the ceiling where it is not above ``v0``. Valid for a ramp that ends without acceleration.

    Examples
    --------
    >>> round(reachable_speed(0.0, 1.5, 9.0, 2.0, 4.0), 9)
    2.0

    References
    ----------
    Derived here from :func:`ramp_distance`, which rises with the speed.
    """
    if ceiling <= v0 or ramp_distance(v0, ceiling, acceleration, jerk) <= length:
        return ceiling
    low, high = v0, ceiling
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if ramp_distance(v0, middle, acceleration, jerk) <= length:
            low = middle
        else:
            high = middle
    return low


@compiled
def peak_speed(length: float, v0: float, v1: float, ceiling: float, acceleration: float, jerk: float) -> float:
    """Highest speed [m/s] of a stretch entered at ``v0`` and left at ``v1``; NaN if it is too short for that.

    Solves :math:`s(v_0, v) + s(v, v_1) = L` with :func:`ramp_distance`, by bisection, to the last bit.

    Parameters
    ----------
    length : float
        L [m].
    v0, v1, ceiling : float
        Speeds at the ends, without acceleration, and highest [m/s].
    acceleration, jerk : float
        Limits [m/s^2], [m/s^3], positive.

    Returns
    -------
    float
        Speed [m/s], not below either end. Valid for limits that hold over the whole stretch.

    Examples
    --------
    Twice 1.5 m up to 2 m/s and down; 1 m is too short to stop from there.

    >>> round(peak_speed(3.0, 0.0, 0.0, 9.0, 2.0, 4.0), 9), peak_speed(1.0, 2.0, 0.0, 9.0, 2.0, 4.0)
    (2.0, nan)

    References
    ----------
    Biagiotti & Melchiorri 2008, sec. 3.4; the root is taken by bisection, for any speeds at the ends.
    """
    low = max(v0, v1)
    if ramp_distance(v0, v1, acceleration, jerk) > length * (1.0 + 1e-12) + 1e-15:
        return math.nan
    high = max(ceiling, low)
    needed = ramp_distance(v0, high, acceleration, jerk) + ramp_distance(high, v1, acceleration, jerk)
    if needed <= length:
        return high
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if ramp_distance(v0, middle, acceleration, jerk) + ramp_distance(middle, v1, acceleration, jerk) <= length:
            low = middle
        else:
            high = middle
    return low


def stretch(length: float, v0: float, v1: float, limits: Limits) -> list[tuple[float, float]]:
    """Phases (duration [s], jerk [m/s^3]) of the quickest motion over ``length`` [m], from ``v0`` to ``v1``.

    Raises
    ------
    ValueError
        The stretch is too short for the change of speed, or a limit is not positive.

    References
    ----------
    Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    if min(limits) <= 0.0:
        raise ValueError(f"motion limits must be positive, got {limits}")
    peak = peak_speed(length, v0, v1, limits.speed, limits.acceleration, limits.jerk)
    if math.isnan(peak):
        raise ValueError(f"{length} m is too short to go from {v0} to {v1} m/s")
    before, after = ramp(v0, peak, limits), ramp(peak, v1, limits)
    run = ramp_distance(v0, peak, limits.acceleration, limits.jerk)
    run += ramp_distance(peak, v1, limits.acceleration, limits.jerk)
    cruise = max(length - run, 0.0) / peak if peak > 0.0 else 0.0
    return [phase for phase in (*before, (cruise, 0.0), *after) if phase[0] > 0.0]


def ramp(v0: float, v1: float, limits: Limits) -> list[tuple[float, float]]:
    """Phases (duration [s], jerk [m/s^3]) of the quickest change of speed from and to zero acceleration.

    References
    ----------
    Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    total = float(ramp_time(v1 - v0, limits.acceleration, limits.jerk))
    if total == 0.0:
        return []
    jerk = math.copysign(limits.jerk, v1 - v0)
    rise = min(0.5 * total, limits.acceleration / limits.jerk)
    hold = total - 2.0 * rise
    return [(rise, jerk), (hold, 0.0), (rise, -jerk)]


def chain(
    phases: Sequence[tuple[float, float]], speed: float = 0.0, anchors: Sequence[tuple[int, float, float]] = ()
) -> Profile:
    """The phases run one after the other from position zero.

    ``anchors`` pins the state at the start of phases: (phase number, position [m], speed [m/s], zero acceleration),
    so that rounding does not add up over a long program.

    References
    ----------
    Biagiotti & Melchiorri 2008, sec. 3.4: integrals of constant jerk.
    """
    n = len(phases)
    time, position = np.zeros(n + 1), np.zeros(n + 1)
    v, a = np.zeros(n + 1), np.zeros(n + 1)
    jerk = np.array([phase[1] for phase in phases], dtype=np.float64)
    v[0] = speed
    pinned = {number: (place, rate) for number, place, rate in anchors}
    for i, (duration, j) in enumerate(phases):
        time[i + 1] = time[i] + duration
        position[i + 1] = position[i] + duration * (v[i] + duration * (a[i] / 2.0 + duration * j / 6.0))
        v[i + 1] = v[i] + duration * (a[i] + duration * j / 2.0)
        a[i + 1] = a[i] + duration * j
        if i + 1 in pinned:
            position[i + 1], v[i + 1] = pinned[i + 1]
            a[i + 1] = 0.0
    return Profile(time, position, v, a, jerk)


def at(profile: Profile, instants: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position [m], speed [m/s] and acceleration [m/s^2] at the instants [s]; at rest before and after the profile.

    References
    ----------
    Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    n = profile.jerk.shape[0]
    if n == 0:
        return np.zeros_like(instants), np.zeros_like(instants), np.zeros_like(instants)
    i = np.clip(np.searchsorted(profile.time, instants, side="right") - 1, 0, n - 1)
    dt = np.clip(instants, profile.time[0], profile.time[-1]) - profile.time[i]
    a0, v0, j = profile.acceleration[i], profile.speed[i], profile.jerk[i]
    position = profile.position[i] + dt * (v0 + dt * (a0 / 2.0 + dt * j / 6.0))
    speed, acceleration = v0 + dt * (a0 + dt * j / 2.0), a0 + dt * j
    over = (instants >= profile.time[-1]) | (instants < profile.time[0])
    ends = np.where(instants >= profile.time[-1], profile.position[-1], profile.position[0])
    return np.where(over, ends, position), np.where(over, 0.0, speed), np.where(over, 0.0, acceleration)
