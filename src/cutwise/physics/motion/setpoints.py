"""Commands of a machine's axes that bring the tool point to given places in the part."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.chains import PRISMATIC, frames, jacobian, tool_point
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion.volumetric import Axes

_FLAT = 1e-6  # least volume that the directions of three linear axes span


class DependentAxesError(ValueError):
    """The linear axes of the machine do not span space in some posture."""


class Beyond(NamedTuple):
    """A command outside the travel of its joint."""

    joint: int
    place: int  # row of the commands
    command: float  # [m or rad], the one farthest outside


def setpoints(axes: Axes, tip: ArrayLike, places: ArrayLike, rotary: ArrayLike) -> FloatArray:
    r"""Commands of all joints; those of rotary axes are given, those of linear ones follow.

    With the rotary axes at rest the tool point is affine in the linear displacements, so that one step is exact:

    .. math:: q = J_\text{lin}^{-1}\,\bigl(p - p(0, q_\text{rot})\bigr)

    Parameters
    ----------
    axes : Axes
        A machine with three linear axes.
    tip : array (3,)
        Tool point in the last frame [m].
    places : array (m, 3)
        Wanted tool points p in frame 0, the part [m].
    rotary : array (m, n)
        Commands of the rotary joints [rad]; those of the others are ignored.

    Returns
    -------
    array (m, n)
        [m or rad].

    Raises
    ------
    DependentAxesError
        Two linear axes are parallel, or all three in a plane.

    References
    ----------
    Derived here: Demeč and Madáč, Eq. (1), solved for the motions.
    """
    linear = np.flatnonzero(axes.chain.kinds == PRISMATIC)
    commands = np.array(rotary, dtype=float)
    commands[:, linear] = 0.0
    q = commands * axes.sense
    missing = np.asarray(places, dtype=float) - tool_point(frames(axes.chain, q), tip)
    directions = jacobian(axes.chain, q, tip)[:, :3, linear]
    if directions.shape[-1] != 3 or np.abs(np.linalg.det(directions)).min(initial=np.inf) < _FLAT:
        raise DependentAxesError("the linear axes of the machine do not span space")
    moved = np.linalg.solve(directions, missing[..., None])[..., 0]
    commands[:, linear] = moved * axes.sense[linear]
    return commands


def beyond(axes: Axes, commands: FloatArray, slack: float = 1e-9) -> list[Beyond]:
    """For every joint that is led outside its travel, the command that is farthest outside."""
    found = []
    for joint in np.flatnonzero(axes.high > axes.low):
        excess = np.maximum(axes.low[joint] - commands[:, joint], commands[:, joint] - axes.high[joint])
        worst = int(np.argmax(excess))
        if excess[worst] > slack:
            found.append(Beyond(int(joint), worst, float(commands[worst, joint])))
    return found
