"""Posture candidates per second: all branches, Jacobian, compliance, skating; beside a loop of Pinocchio calls.

Run: ``python benchmarks/postures.py`` (the ratio needs ``pip install pin``).
"""

import time

import numpy as np

from cutwise.io.scenario import load
from cutwise.process.drilling import robot_arm
from cutwise.process.postures import candidates, tool_axes

POSES = 100_000


def cutwise_seconds(arm, positions, poses) -> tuple[float, int]:
    """CPU seconds for all poses, and how many candidates are within the limits."""
    candidates(arm, positions[:10], poses[:10])  # compile
    start = time.process_time()
    found = candidates(arm, positions, poses)
    return time.process_time() - start, int(found.within.sum())


def pinocchio_seconds(arm, postures) -> float:
    """CPU seconds of one Jacobian and one 6x6 compliance per posture in a Python loop; no inverse kinematics."""
    import pinocchio

    model = pinocchio.Model()
    parent = 0
    for k in range(6):
        axis = arm.chain.axes[k]
        placement = pinocchio.SE3(arm.chain.rotations[k], arm.chain.origins[k])
        parent = model.addJoint(parent, pinocchio.JointModelRevoluteUnaligned(axis), placement, f"j{k}")
    offset = pinocchio.SE3(np.eye(3), arm.tool_tip)
    frame = model.addFrame(pinocchio.Frame("tip", parent, 0, offset, pinocchio.FrameType.OP_FRAME))
    data, flexibility = model.createData(), 1.0 / arm.stiffness
    start = time.process_time()
    for q in postures:
        j = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED)
        (j * flexibility) @ j.T
    return time.process_time() - start


def main() -> None:
    """Print the times and the ratio per candidate."""
    arm, _ = robot_arm(load("examples/drill_robot.yaml").robot)
    angles = np.linspace(-np.pi, np.pi, POSES)
    positions = np.tile([1.9, 0.3, 0.8], (POSES, 1))
    poses = tool_axes(np.array([0.0, 0.0, -1.0]), angles)
    seconds, count = min(cutwise_seconds(arm, positions, poses) for _ in range(3))
    print(f"{POSES} poses, {8 * POSES} branches, {count} candidates within limits: {seconds:.3f} CPU s")
    try:
        peer = pinocchio_seconds(arm, np.random.default_rng(1).uniform(-1, 1, (POSES, 6)))
    except ImportError:
        print("Pinocchio is not installed: no ratio")
        return
    print(f"Pinocchio loop, one Jacobian and compliance for each of {POSES} given postures: {peer:.3f} CPU s")
    print(
        f"ratio per candidate, with inverse kinematics here and without there: {peer / POSES / (seconds / count):.2f}"
    )


if __name__ == "__main__":
    main()
