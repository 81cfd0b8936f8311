"""Sharp corners of a shifted path: where both of its sides meet."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import block_tangent, turn_angles
from cutwise.process.program_path import ProgramPath
from cutwise.study.correct.level import cut_level

OVER = 0.1e-3  # [m] of way before a corner, over which the path is led to where both sides meet
_STRAIGHT = math.radians(18.0)  # of a turn, below which, and as near to a reversal, sides do not meet anywhere near


def sharp_corners(path: ProgramPath) -> npt.NDArray[np.int64]:
    """Joints of two cuts at one height that turn, neither nearly straight on nor back."""
    cut, turn = cut_level(path), np.abs(turn_angles(path.curve))
    return np.flatnonzero(cut[:-1] & cut[1:] & (turn > _STRAIGHT) & (turn < math.pi - _STRAIGHT))


def meeting(path: ProgramPath, joint: int, before: float, behind: float) -> FloatArray:
    r"""How far a corner moves when its sides are shifted to their right [m], shape (2,).

    .. math:: d \cdot n_1 = \delta_1, \qquad d \cdot n_2 = \delta_2

    Parameters
    ----------
    path : ProgramPath
        The wanted path.
    joint : int
        Of :func:`sharp_corners`.
    before, behind : float
        Shifts of the sides, :math:`\delta_1` and :math:`\delta_2` [m].
    """
    curve = path.curve
    first = np.asarray(block_tangent(curve, joint, float(curve.length[joint])))[:2]
    second = np.asarray(curve.along[joint + 1])[:2]
    normals = np.array([[first[1], -first[0]], [second[1], -second[0]]])
    return np.asarray(np.linalg.solve(normals, np.array([before, behind])))
