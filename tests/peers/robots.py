"""The reference cell of the drilling tests: arm, drill, postures; and a robot of another make."""

import math

import numpy as np

from cutwise.maths.chains import chain, frames, jacobian
from cutwise.maths.frames import rotation_about
from cutwise.physics.cutting.drill import DrillPoint, ZoneLaw, cone_height, stress_at_feed
from cutwise.physics.structure.joint_compliance import cartesian_compliance
from cutwise.process.drill_profile import depth_profile, no_elements
from cutwise.process.hole_balance import DrillCycle
from cutwise.process.loops_drilling import arm_dynamics
from cutwise.process.postures import Arm, arm_with

MPA, MICRO = 1e6, 1e-6
STIFFNESS = np.array([3.8e6, 6.6e6, 3.9e6, 5.6e5, 6.6e5, 4.7e5])
KUKA_AXES = [(0, 0, -1), (0, 1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0), (-1, 0, 0)]
KUKA_ORIGINS = [(0, 0, 0.675), (0.35, 0, 0), (1.15, 0, 0), (1.2, 0, -0.041), (0, 0, 0), (0.24, 0, 0)]
ABB_AXES = [(0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0)]
ABB_ORIGINS = [(0, 0, 0.78), (0.32, 0, 0), (0, 0, 1.075), (1.392, 0, 0.2), (0, 0, 0), (0.2, 0, 0)]
KUKA_LIMITS = np.radians([(-170, 170), (-195, 40), (-115, 150), (-185, 185), (-120, 120), (-350, 350)])
ABB_LIMITS = np.radians([(-170, 170), (-65, 85), (-180, 70), (-300, 300), (-120, 120), (-360, 360)])


def kuka():
    """KR270 R2700."""
    return chain([2] * 6, KUKA_AXES, KUKA_ORIGINS)


def abb():
    """IRB 6640-185/2.80: upper arm standing at zero, axes the other way round."""
    return chain([2] * 6, ABB_AXES, ABB_ORIGINS)


def arm() -> Arm:
    """The reference arm with its drill."""
    serial = kuka()
    tip = np.array([0.2, 0.0, -0.3])
    return arm_with(serial, KUKA_LIMITS, STIFFNESS, np.diag([1.0, -1.0, -1.0]), tip)


HOLE, DOWN = np.array([1.9, 0.3, 0.8]), np.array([0.0, 0.0, -1.0])
POSTURES = {
    "stiffest": np.radians([-0.143627, 23.163902, -72.066940, -129.785778, 119.169256, 30.339604]),
    "least skating": np.radians([-18.138764, 39.154638, -114.590131, 45.074347, 79.602941, -10.256001]),
    "worst": np.radians([169.556367, -129.312350, -75.417019, -15.108211, 25.503906, -166.305769]),
}


def compliance(posture: str) -> np.ndarray:
    """Compliance at the drill tip in tool axes."""
    given, q = arm(), POSTURES[posture]
    axes = frames(given.chain, q).rotations[-1] @ given.tool_rotation
    return cartesian_compliance(jacobian(given.chain, q, given.tool_tip), given.stiffness, axes)


MATERIALS = {  # k_c11, m_c, mu, feed [m], speed [rpm]
    "Al": (650 * MPA, 0.25, 0.60, 1e-4, 3000),
    "Ti": (1400 * MPA, 0.23, 0.55, 0.6e-4, 800),
}
POINT = DrillPoint(3e-3, 0.5e-3, 0.45e-3, math.radians(59), math.radians(30), 4e-4, 3e-3)


def law(friction: float) -> ZoneLaw:
    """Reference zones."""
    return ZoneLaw(friction, math.radians(15), 1.3, 0.3, math.radians(-50), 0.5 * MPA)


def cycle(material: str, *, wall: float = 5e6, inclination: float = 0.0):
    """Cycle and force profile of the reference hole."""
    kc11, exponent, friction, feed, rpm = MATERIALS[material]
    stress = stress_at_feed(law(friction), kc11, exponent, POINT, feed)
    profile = depth_profile(
        POINT, stress, no_elements(), margin_stress=0.5 * MPA, feed=feed, thickness=5e-3, inclination=inclination
    )
    return DrillCycle(feed, rpm / 60, 5e-3, cone_height(POINT), exponent, 0.2, wall, 6e-3), profile


def dynamics(posture: str, *, with_torque: bool = False):
    """The arm at the tip: 150 kg, 5 % damping."""
    return arm_dynamics(compliance(posture), 150.0, 0.05, with_torque=with_torque)


def _by_dh(rows):
    """A chain from Denavit and Hartenberg's a, alpha, d of every joint; its last frame is that of joint 6."""
    origins, rotations = [np.zeros(3)], [np.eye(3)]
    for a, alpha, d in rows[:-1]:
        origins.append(np.array([a, 0.0, d]))
        rotations.append(rotation_about((1, 0, 0), alpha))
    return chain([2] * 6, [(0, 0, 1)] * 6, origins, rotations=rotations)


def _ur(d1, a2, a3, d4, d5, d6):
    """Universal Robots and alike: axes 2, 3 and 4 parallel."""
    right = math.pi / 2
    return _by_dh([(0, right, d1), (a2, 0, 0), (a3, 0, 0), (0, right, d4), (0, -right, d5), (0, 0, d6)])


def _offset_wrist(height, upper, fore, beside, hand):
    """A cobot whose axis 6 misses axis 4 by an offset along axis 5."""
    origins = [(0, 0, height), (0, 0, 0), (0, 0, upper), (fore, 0, 0), (0, beside, 0), (hand, 0, 0)]
    return chain([2] * 6, ABB_AXES, origins)


_SKEW = np.random.default_rng(3)
OTHER_ARMS = {
    "UR5": _ur(0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
    "UR10": _ur(0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    "CR5": _ur(0.147, -0.427, -0.357, 0.141, 0.116, 0.105),
    "CRX": _offset_wrist(0.245, 0.71, 0.54, 0.15, 0.16),
    "HC10": _offset_wrist(0.275, 0.7, 0.5, -0.162, 0.13),
    "missed wrist": chain([2] * 6, KUKA_AXES, [*KUKA_ORIGINS[:5], (0.24, 0.03, 0)]),
    "skew shoulder": chain([2] * 6, [*KUKA_AXES[:2], (0, 0.8, 0.6), *KUKA_AXES[3:]], KUKA_ORIGINS),
    "skew": chain([2] * 6, _SKEW.normal(size=(6, 3)), _SKEW.uniform(-0.5, 0.5, (6, 3))),
}
"""Arms without the usual closed form."""
