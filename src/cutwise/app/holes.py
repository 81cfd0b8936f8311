"""Where holes come out: what the tool yields by along the depth, and where it was led instead of the hole."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from cutwise.results import Result

FloatArray = npt.NDArray[np.float64]


def off_place(result: "Result") -> FloatArray:
    r"""Place of each hole over time from where it is wanted, in the axes of the tool there.

    .. math:: o = d + s + \tau \, \min(\max(z - p, 0), t)

    Parameters
    ----------
    result : Result
        A run of drilling: displacement :math:`d` [m] and depth of the tip :math:`z` [m] over time; shift :math:`s` [m] and
        tilt :math:`\tau` [rad] of its corrections; height :math:`p` of the point and thickness :math:`t` of the part [m].

    Returns
    -------
    array, shape (hole, time, 2)
        In metres, at the depth that the corners of the drill have, which make the wall.
    """
    scenario, motion = result.scenario, result["motion"].dataset
    hole = scenario.hole  # type: ignore[attr-defined]
    off = np.array(result["surface"]["hole_position"].values, float)
    if not hole.corrections:
        return off
    led = [hole.corrections[int(number) - 1] for number in motion["hole"].values]
    shift, tilt = (np.array([getattr(one, name) for one in led])[:, None, :] for name in ("shift", "tilt"))
    made = motion["depth"].values - scenario.tool.cone_height  # type: ignore[attr-defined]
    deep = np.clip(made, 0.0, scenario.part.thickness)[:, :, None]  # type: ignore[attr-defined]
    return np.asarray(off + shift + tilt * deep)
