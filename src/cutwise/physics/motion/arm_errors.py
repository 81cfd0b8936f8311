r"""A serial arm with errors: a twist of each body, periodic errors of each joint, joints that yield under the links' weight.

.. math:: H_{i-1,i} = (R_i, K_i)\, \mathrm{Rot}(a_i, q_i + \Delta q_i)\, \exp(\xi_i), \qquad
          \Delta q_i = \sum_{h=1}^{n} (a_{ih} \sin h q_i + b_{ih} \cos h q_i) + c_i M_i(q)

with :math:`\xi_i = (\delta_i, \varepsilon_i)` in the frame of the joint after its turn, and :math:`M_i` the moment of the
weights of the links behind joint i about its axis, positive as the joint turns.
"""

from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import Chain, frames
from cutwise.maths.constants import GRAVITY
from cutwise.maths.frames import FloatArray, exp_twists


class Errors(NamedTuple):
    """Errors of an arm of n joints."""

    bodies: FloatArray  # twists [m, rad] (n, 6)
    sine: FloatArray  # [rad] (n, harmonics)
    cosine: FloatArray  # [rad] (n, harmonics)
    gravity_compliance: FloatArray  # [rad/(N m)] (n,)


class Load(NamedTuple):
    """Weights of the links and which way is down."""

    masses: FloatArray  # [kg] (n,)
    centres: FloatArray  # [m] in the frame of each joint (n, 3)
    down: FloatArray  # unit vector in the base frame (3,)


class Poses(NamedTuple):
    """Where a target of the last body is, and what moves it: rows m, joints n, base frame."""

    place: FloatArray  # [m] (m, 3)
    axes: FloatArray  # of the joints (m, n, 3)
    reach: FloatArray  # [m] of the target from the origins of the joints (m, n, 3)
    rotations: FloatArray  # of the bodies, with their errors (m, n, 3, 3)
    arms: FloatArray  # [m] of the target from the origins of the bodies, with their errors (m, n, 3)


def none(count: int, harmonics: int) -> Errors:
    """An arm without errors."""
    return Errors(np.zeros((count, 6)), np.zeros((count, harmonics)), np.zeros((count, harmonics)), np.zeros(count))


def waves(angles: FloatArray, harmonics: int) -> tuple[FloatArray, FloatArray]:
    """sin hq and cos hq of angles (m, n): both (m, n, harmonics)."""
    turned = angles[..., None] * np.arange(1, harmonics + 1)
    return np.sin(turned), np.cos(turned)


def moments(links: Chain, angles: FloatArray, load: Load) -> FloatArray:
    """Moment of the weights behind each joint about its axis [N m] (m, n), of the chain without errors."""
    at = frames(links, angles)
    count = len(load.masses)
    centres = at.origins[:, 1:] + np.einsum("mnij,nj->mni", at.rotations[:, 1:], load.centres)
    axes = np.einsum("mnij,nj->mni", at.rotations[:, 1:], links.axes)
    weight = GRAVITY * load.masses[:, None] * load.down
    found = np.zeros((len(angles), count))
    for k in range(count):
        arm = centres[:, k:] - at.origins[:, None, k + 1]
        found[:, k] = np.einsum("mi,mi->m", axes[:, k], np.cross(arm, weight[None, k:]).sum(axis=1))
    return found


def poses(links: Chain, angles: FloatArray, twists: FloatArray, target: FloatArray) -> Poses:
    """Places of a target (3,) of the last body at joint angles (m, n) that have their corrections in them."""
    count = angles.shape[1]
    turned, moved = exp_twists(twists)
    rotation = np.tile(np.eye(3), (len(angles), 1, 1))
    origin = np.zeros((len(angles), 3))
    axes, origins, rotations, bodies = [], [], [], []
    c, s = np.cos(angles)[..., None, None], np.sin(angles)[..., None, None]
    for k in range(count):
        origin = origin + rotation @ links.origins[k]
        rotation = rotation @ links.rotations[k]
        a = links.axes[k]
        cross = np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])
        axes.append(rotation @ a)
        origins.append(origin)
        rotation = rotation @ (np.eye(3) + s[:, k] * cross + (1.0 - c[:, k]) * (cross @ cross))
        origin = origin + rotation @ moved[k]
        rotation = rotation @ turned[k]
        rotations.append(rotation)
        bodies.append(origin)
    place = origin + rotation @ target
    stacked = np.stack(origins, axis=1)
    return Poses(
        place, np.stack(axes, axis=1), place[:, None] - stacked, np.stack(rotations, axis=1),
        place[:, None] - np.stack(bodies, axis=1),
    )  # fmt: skip


def corrected_angles(angles: FloatArray, errors: Errors, moment: FloatArray) -> FloatArray:
    """Joint angles that the arm really has (m, n)."""
    sine, cosine = waves(angles, errors.sine.shape[1])
    periodic = np.einsum("mnh,nh->mn", sine, errors.sine) + np.einsum("mnh,nh->mn", cosine, errors.cosine)
    return np.asarray(angles + periodic + errors.gravity_compliance * moment)
