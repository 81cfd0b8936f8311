"""Kinematics against Pinocchio (a peer used in tests only) on 1,000 random postures of two robots, to 1e-9."""

import math

import numpy as np
import pytest

from cutwise.maths.chains import frames, jacobian, tool_point
from cutwise.physics.motion.wrist import fill_branches, spherical_wrist
from peers.robots import ABB_AXES, ABB_LIMITS, ABB_ORIGINS, KUKA_AXES, KUKA_LIMITS, KUKA_ORIGINS, abb, kuka

pinocchio = pytest.importorskip("pinocchio", reason="Pinocchio (pip install pin) is a peer for these tests only")

TIP = np.array([0.2, 0.03, -0.3])
ROBOTS = {
    "KR270 R2700": (kuka, KUKA_AXES, KUKA_ORIGINS, KUKA_LIMITS),
    "IRB 6640": (abb, ABB_AXES, ABB_ORIGINS, ABB_LIMITS),
}


def peer(axes, origins):
    """The same robot as Pinocchio reads it from a URDF."""
    links = "".join(f'<link name="l{k}"/>' for k in range(7))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/>'
        f'<origin xyz="{o[0]} {o[1]} {o[2]}" rpy="0 0 0"/><axis xyz="{a[0]} {a[1]} {a[2]}"/>'
        '<limit lower="-7" upper="7" effort="0" velocity="1"/></joint>'
        for k, (a, o) in enumerate(zip(axes, origins, strict=True))
    )
    model = pinocchio.buildModelFromXML(f'<robot name="peer">{links}{joints}</robot>')
    offset = pinocchio.SE3(np.eye(3), TIP)
    frame = model.addFrame(pinocchio.Frame("tip", 6, model.getFrameId("l6"), offset, pinocchio.FrameType.OP_FRAME))
    return model, model.createData(), frame


@pytest.mark.parametrize("name", ROBOTS)
def test_forward_kinematics_jacobian_and_inverse(name):
    make, axes, origins, limits = ROBOTS[name]
    serial, (model, data, frame) = make(), peer(axes, origins)
    arm = spherical_wrist(serial)
    postures = np.random.default_rng(11).uniform(limits[:, 0], limits[:, 1], (1000, 6))
    at, jacobians = frames(serial, postures), jacobian(serial, postures, TIP)
    tips = tool_point(at, TIP)
    solutions, n, work = np.empty((8, 6)), np.empty((3, 3)), np.empty((3, 3))
    for k, q in enumerate(postures):
        pinocchio.framesForwardKinematics(model, data, q)
        place = data.oMf[frame]
        assert np.abs(place.translation - tips[k]).max() < 1e-9
        assert np.abs(place.rotation - at.rotations[k, -1]).max() < 1e-9
        world = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED)
        assert np.abs(world - jacobians[k]).max() < 1e-9
        fill_branches(arm, place.rotation, place.translation - place.rotation @ TIP, solutions, n, work)
        found = solutions[~np.isnan(solutions[:, 0])]
        assert len(found) >= 4
        apart = np.abs((found - q + math.pi) % (2 * math.pi) - math.pi).max(axis=1)
        if abs(math.sin(q[4])) > 1e-3:  # at the singular wrist only the sum of axes 4 and 6 is defined
            assert apart.min() < 1e-9
        for solution in found:
            pinocchio.framesForwardKinematics(model, data, solution)
            assert np.abs(data.oMf[frame].translation - tips[k]).max() < 1e-9
            assert np.abs(data.oMf[frame].rotation - at.rotations[k, -1]).max() < 1e-9
