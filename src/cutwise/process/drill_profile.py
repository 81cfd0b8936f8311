"""Thrust, torque and lateral force of a drill over depth: entry, full cut and breakthrough, mean over a turn.

Engagement (which radii of a lip are in the work) and cutting (what they cost) meet here.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.physics.cutting.drill import DrillPoint, ZoneStress, lip_force, margin_torque
from cutwise.physics.cutting.drill_elements import LipElements, elements_force
from cutwise.physics.engagement.lip import lip_contact


class TurnMean(NamedTuple):
    """Forces at one depth over a revolution, on the tool, in drill axes (z feed, surface tilted about y)."""

    thrust: float  # [N] against the feed
    torque: float  # [N m] against the rotation, with the margins
    lateral_x: float  # [N]
    lateral_y: float  # [N]
    ripple: float  # [N] largest deviation of the lateral force from its mean


class DepthProfile(NamedTuple):
    """Forces at nominal feed on an even grid of tip depths that starts at zero."""

    spacing: float  # [m]
    thrust: FloatArray  # [N], shape (n,)
    torque: FloatArray  # [N m], shape (n,)
    lateral: FloatArray  # [N] along x and y of the drill axes, shape (n, 2)

    @property
    def depth(self) -> FloatArray:
        """Tip depths [m], shape (n,)."""
        return np.asarray(self.spacing * np.arange(len(self.thrust)), dtype=float)


@compiled
def _lateral(tangential: float, inward: float, azimuth: float) -> tuple[float, float]:
    r""":math:`F_x = F_t\sin\varphi - F_r\cos\varphi,\; F_y = -F_t\cos\varphi - F_r\sin\varphi`."""
    c, s = math.cos(azimuth), math.sin(azimuth)
    return tangential * s - inward * c, -tangential * c - inward * s


@compiled
def turn_mean(
    point: DrillPoint,
    stress: ZoneStress,
    elements: LipElements,
    margin_stress: float,
    feed: float,
    depth: float,
    thickness: float,
    inclination: float,
    azimuths: int,
) -> TurnMean:
    r"""Mean forces of both lips over a revolution.

    Parameters
    ----------
    point, stress, elements
        Drill and its stresses; ``elements`` with no entries means the closed form.
    margin_stress : float
        Rubbing stress of the margins [Pa].
    feed, depth, thickness : float
        Feed per revolution, depth of the tip below the entry surface, thickness along the axis [m].
    inclination : float
        Slope of the surfaces [rad]; zero needs one azimuth only.
    azimuths : int
        Even number of azimuths over the revolution.
    """
    flat = inclination == 0.0
    count = 2 if flat else azimuths
    half = count // 2
    x, y = np.zeros(count), np.zeros(count)
    thrust, torque = 0.0, 0.0
    for k in range(count):
        azimuth = 2.0 * math.pi * (k + 0.5) / count
        inner, outer = lip_contact(depth, thickness, point.radius, point.half_point_angle, inclination, azimuth)
        if elements.thrust.size > 0:
            force = elements_force(elements, feed, inner, outer)
        else:
            force = lip_force(point, stress, feed, inner, outer)
        thrust += 2.0 * force.thrust / count
        torque += 2.0 * force.torque / count
        fx, fy = _lateral(force.tangential, force.inward, azimuth)
        x[k] += fx
        y[k] += fy
        x[(k + half) % count] += fx  # the other lip, half a turn on
        y[(k + half) % count] += fy
    torque += margin_torque(point, margin_stress, depth, thickness)
    if flat:
        return TurnMean(thrust, torque, 0.0, 0.0, 0.0)
    mean_x, mean_y, ripple = np.mean(x), np.mean(y), 0.0
    for k in range(count):
        ripple = max(ripple, math.hypot(x[k] - mean_x, y[k] - mean_y))
    return TurnMean(thrust, torque, mean_x, mean_y, ripple)  # type: ignore[arg-type]  # floats once compiled


@compiled
def _fill_profile(
    point: DrillPoint,
    stress: ZoneStress,
    elements: LipElements,
    margin_stress: float,
    feed: float,
    thickness: float,
    inclination: float,
    azimuths: int,
    spacing: float,
    rows: FloatArray,
) -> None:
    for k in range(len(rows)):
        mean = turn_mean(point, stress, elements, margin_stress, feed, k * spacing, thickness, inclination, azimuths)
        rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3] = mean.thrust, mean.torque, mean.lateral_x, mean.lateral_y


def no_elements() -> LipElements:
    """An empty set of elements: the closed form is meant."""
    return LipElements(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0))


def depth_profile(
    point: DrillPoint,
    stress: ZoneStress,
    elements: LipElements,
    *,
    margin_stress: float,
    feed: float,
    thickness: float,
    inclination: float = 0.0,
    azimuths: int = 360,
    spacing: float = 2e-6,
) -> DepthProfile:
    """Forces on a grid of depths from first contact until the drill point is through.

    Parameters
    ----------
    spacing : float
        Of the grid [m]. Between the grid points the loop interpolates linearly; the kinks where chisel edge and corner
        enter and leave are off by at most the change within one spacing (0.1 N at 2 µm).
    azimuths : int
        Even number of azimuths over the revolution; only an inclined surface needs them.
    """
    through = thickness + point.radius / math.tan(point.half_point_angle)
    if inclination != 0.0:
        through += point.radius * abs(math.tan(inclination))
        spacing = max(spacing, 1e-5)
    rows = np.zeros((math.ceil((through + 3e-3) / spacing) + 2, 4))
    _fill_profile(point, stress, elements, margin_stress, feed, thickness, inclination, azimuths, spacing, rows)
    return DepthProfile(spacing, rows[:, 0].copy(), rows[:, 1].copy(), rows[:, 2:].copy())


@compiled
def profile_at(profile: DepthProfile, depth: float) -> tuple[float, float, float, float]:
    """Thrust, torque and the two lateral forces at a depth [m]; zero above the surface, held beyond the end."""
    if not depth > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    last = len(profile.thrust) - 1
    place = min(depth / profile.spacing, float(last))  # before it becomes an index: a run that diverges has no bounds
    k = min(int(place), last - 1)
    part = place - k
    return (
        profile.thrust[k] + part * (profile.thrust[k + 1] - profile.thrust[k]),
        profile.torque[k] + part * (profile.torque[k + 1] - profile.torque[k]),
        profile.lateral[k, 0] + part * (profile.lateral[k + 1, 0] - profile.lateral[k, 0]),
        profile.lateral[k, 1] + part * (profile.lateral[k + 1, 1] - profile.lateral[k, 1]),
    )
