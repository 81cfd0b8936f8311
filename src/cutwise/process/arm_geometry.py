"""Where an arm with geometric errors really is, against where its program leads it."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion.arm_errors import Errors, Load, corrected_angles, moments, poses
from cutwise.process.postures import Arm
from cutwise.results import Finding, Place, warned
from cutwise.spec.robot import Robot
from cutwise.spec.uncertain import Fitted


class Misplaced(NamedTuple):
    """Errors of postures, n of them."""

    twist: FloatArray  # of the tip, as it is less as it was led, base axes [m, rad] (n, 6)
    outside: np.ndarray  # which joints are outside the ranges in which the errors are known (n, joints)
    angles: FloatArray  # of the joints [rad] (n, joints)


def misplaced(robot: Robot, arm: Arm, q: FloatArray) -> Misplaced:
    """Twist of the tip by the geometric errors of an arm, at angles of its motors (n, 6).

    Outside the ranges of the measurement periodic errors are not known: the nominal chain stands there, unless the
    joints' yielding under the links was fitted, with which corrections hold elsewhere too.
    """
    given, count = robot.errors, len(robot.joints)
    angles = np.atleast_2d(arm.drives.joints(np.atleast_2d(q)))
    if given is None:
        return Misplaced(np.zeros((len(angles), 6)), np.zeros((len(angles), count), dtype=bool), angles)
    outside = _outside(given.ranges, angles)
    errors = errors_of(robot)
    moment = np.zeros_like(angles)
    if given.of_gravity:
        moment = moments(arm.chain, angles, load_of(robot))
    real = poses(arm.chain, corrected_angles(angles, errors, moment), errors.bodies, arm.tool_tip)
    led = poses(arm.chain, angles, np.zeros((count, 6)), arm.tool_tip)
    turned = real.rotations[:, -1] @ np.swapaxes(led.rotations[:, -1], -1, -2)
    spin = 0.5 * np.stack([
        turned[:, 2, 1] - turned[:, 1, 2], turned[:, 0, 2] - turned[:, 2, 0], turned[:, 1, 0] - turned[:, 0, 1]
    ], axis=1)  # fmt: skip
    twist = np.concatenate([real.place - led.place, spin], axis=1)
    known = np.asarray(~outside.any(axis=1) | given.of_gravity)
    left = np.asarray(known & (not given.compensated))
    return Misplaced(np.where(left[:, None], twist, 0.0), outside, angles)


def errors_of(robot: Robot) -> Errors:
    """The errors as arrays."""
    given, count = robot.errors, len(robot.joints)
    assert given is not None
    orders = max((len(one.sine) for one in given.joints), default=0)
    sine, cosine = np.zeros((count, orders)), np.zeros((count, orders))
    for k, one in enumerate(given.joints):
        sine[k, : len(one.sine)], cosine[k, : len(one.cosine)] = one.sine, one.cosine
    bodies = np.array(given.bodies, dtype=float).reshape(-1, 6) if given.bodies else np.zeros((count, 6))
    yielding = np.array(given.gravity_compliance) if given.gravity_compliance else np.zeros(count)
    return Errors(bodies, sine, cosine, yielding)


def load_of(robot: Robot) -> Load:
    """Weights of the links and which way is down."""
    return Load(
        np.array([link.mass for link in robot.link_weights]), np.array([link.centre for link in robot.link_weights]),
        np.array(robot.down),
    )  # fmt: skip


def _outside(ranges: tuple[tuple[float, float], ...], angles: FloatArray) -> np.ndarray:
    """Which angles are in none of the turns of their range."""
    if not ranges:
        return np.zeros(angles.shape, dtype=bool)
    low, high = np.array(ranges).T
    return np.asarray(np.mod(angles - low, 2.0 * np.pi) > high - low + 1e-9)


def warnings(robot: Robot, found: Misplaced, measured: Fitted | None = None) -> Iterator[Finding]:
    """Joints outside of what was measured: their errors, or with ``measured`` their stiffness."""
    yield from _stiffness_beyond(robot, found, measured)
    if robot.errors is None or not found.outside.any():
        return
    for k in np.flatnonzero(found.outside.any(axis=0)):
        low, high = (units.show(end, "angle", 4) for end in robot.errors.ranges[k])
        what = (
            "the errors count all the same, since the joints' yielding under the links is among them; how good they are there "
            "is not known"
            if robot.errors.of_gravity
            else "the nominal chain stands there, and no accuracy can be told"
        )
        yield warned("beyond_data", f"joint {robot.names[k]} leaves the range in which its errors were measured ({low} to {high}, "
                     f"modulo a turn): {what}", where=Place(f"joint {robot.names[k]}"))  # fmt: skip


def _stiffness_beyond(robot: Robot, found: Misplaced, measured: Fitted | None) -> Iterator[Finding]:
    """Postures other than those at which the springs of the arm were found."""
    if measured is None or measured.kind != "robot-stiffness":
        return
    beyond = []
    for k, name in enumerate(robot.names):
        ends = measured.ends(f"joint{k + 1}", "angle")
        if ends is not None and _outside((ends,), found.angles[:, k, None]).any():
            beyond.append(f"{name} ({units.show(ends[0], 'angle', 4)} to {units.show(ends[1], 'angle', 4)})")
    if beyond:
        yield warned(
            "beyond_data",
            f"the arm stands outside of the postures at which {measured.library} was measured: joint {', '.join(beyond)}; its "
            "stiffness, and the band, are carried on beyond their data", where=Place(", ".join(beyond)),
        )  # fmt: skip
