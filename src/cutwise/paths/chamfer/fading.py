r"""Edges that fade into tangency: how close their points must be, and where a chamfer on them has to stop.

In a wedge :math:`\varphi` a ball that is off by :math:`\varepsilon` leaves a width that is off by
:math:`|dw/dd|\, \varepsilon`, nearly :math:`2 \tan(\varphi / 2)\, \varepsilon`: 2 at 90 degrees, 11 at 160, 57 at 176.
The blunter the wedge, the closer the points of the path; and where even the closest do not keep the width, or the
chamfer would be less deep than what counts as a cut at all, the path stops.
"""

import math

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames
from cutwise.paths.chamfer.ball_path import ChamferPath, width_slope
from cutwise.paths.chamfer.proof import GOUGE_LIMIT
from cutwise.paths.chamfer.task import ChamferTask
from cutwise.physics.surface.sweep import SweptChamfer

BLUNT = math.radians(120.0)  # only wedges blunter than this are spoken of here
_KEPT = 0.7  # of that tolerance for the chords of the path
_CLOSEST = 1e-7  # [m] chord error below which points are put no closer
_SHARPER = 0.8  # share of tan(half the wedge) to which a path is taken back where its width was off
_RISES = 1e-9  # [rad] by which the wedge changes at least from one sample to the next where an edge fades


def chord_tolerance(task: ChamferTask, path: ChamferPath) -> FloatArray:
    """The chord tolerance of a task, at each sample of a path: tighter in blunt wedges [m], shape (n,)."""
    given = task.chord_tolerance
    assert given is not None
    wedge = path.frames.wedge
    width = min(task.cut.width, 1.9 * task.tool.ball_radius)
    slope = np.abs(width_slope(width, task.tool.ball_radius, np.minimum(wedge, math.pi - 1e-4)))
    local = np.maximum(_KEPT * task.width_tolerance / slope, _CLOSEST)
    return np.asarray(np.where(wedge > BLUNT, np.minimum(given, local), given))


def too_shallow(task: ChamferTask, frames: EdgeFrames) -> NDArray[np.bool_]:
    """Samples of an edge in whose wedge the chamfer would be less deep than what counts as a cut; shape (n,)."""
    half = np.clip(0.5 * frames.wedge, 1e-3, 0.5 * math.pi)
    width = task.cut.width
    depth = width * np.cos(half) if task.cut.leg else 0.5 * width / np.tan(half)
    return np.asarray(depth < GOUGE_LIMIT)


def shallow_reason(frames: EdgeFrames, samples: NDArray[np.int64]) -> str:
    """Why samples of an edge are left out whose chamfer would be too shallow."""
    sharpest = samples[int(np.argmin(frames.wedge[samples]))]
    return (
        f"the edge fades into tangency at {place(frames.point[sharpest])}: beyond a wedge of "
        f"{math.degrees(frames.wedge[sharpest]):.1f}° the chamfer would be less than {1e6 * GOUGE_LIMIT:.0f} µm deep"
    )


def place(point: FloatArray) -> str:
    """A point [m] in words."""
    return "(" + ", ".join(f"{1e3 * x + 0.0:.2f}" for x in point) + ") mm"


def faded(
    task: ChamferTask, dense: ChamferPath, kept: NDArray[np.int64], at: NDArray[np.int64], found: SweptChamfer
) -> dict[int, str]:  # fmt: skip
    """Samples of a path at which its width is off because the wedge is too blunt, and all that are blunter beyond.

    Parameters
    ----------
    task : ChamferScenario
        Width and its tolerance.
    dense : ChamferPath
        The path at all samples of its edge.
    kept, at : array of int
        Samples that are its points, and those at which the width was measured.
    found : SweptChamfer
        What the sweep left there.

    Returns
    -------
    dict
        Why, by the number of the sample.
    """
    tolerance, wedge = task.width_tolerance, dense.frames.wedge
    off = np.abs(found.width - task.cut.width)
    bad = at[~(off <= tolerance) & (wedge[at] > BLUNT)]
    if not bad.size or task.cut.leg:
        return {}
    count, closed = len(wedge), dense.frames.closed
    gone: set[int] = set()
    for i in bad:
        after = int(np.searchsorted(kept, i))
        low, high = kept[max(after - 1, 0)], kept[after] if after < len(kept) else count
        gone |= set(range(int(low) + 1, int(high)))
        for step in (-1, 1):
            gone |= _beyond(wedge, int(i), step, closed=closed)
    numbers = np.array(sorted(gone))
    sharpest = int(numbers[np.argmin(wedge[numbers])])
    why = (
        f"the edge fades at {place(dense.frames.point[sharpest])}: in a wedge blunter than "
        f"{math.degrees(wedge[sharpest]):.1f}° the width is not kept within {1e3 * tolerance:.3g} mm"
    )
    return dict.fromkeys(numbers.tolist(), why)


def _beyond(wedge: FloatArray, start: int, step: int, *, closed: bool) -> set[int]:
    """Samples from one on, in one direction, over which the wedge opens; or closes, until it is clearly sharper."""
    count = len(wedge)
    opening = math.tan(0.5 * float(wedge[start]))
    gone, j, way = {start}, start, 0.0
    for _ in range(count - 1):
        if not closed and not 0 <= j + step < count:
            break
        change = float(wedge[(j + step) % count] - wedge[j % count])
        if abs(change) <= _RISES or change * way < 0.0 or math.tan(0.5 * float(wedge[j % count])) < _SHARPER * opening:
            break
        way = change
        j += step
        gone.add(j % count)
    return gone
