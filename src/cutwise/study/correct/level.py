"""Where a path may be shifted: its cuts at one height, and where these begin and end."""

import numpy as np
import numpy.typing as npt

from cutwise.maths.linearc import turn_angles
from cutwise.process.program_path import ProgramPath

BEFORE_CURVE = 3e-3  # [m] before the first bend from which on a path may be shifted
_KINK = 1e-4  # [rad] at a joint: what is less runs through
_LEVEL = 1e-9  # vertical part of a direction: what is less is a move in the plane


def cut_level(path: ProgramPath) -> npt.NDArray[np.bool_]:
    """Blocks that cut at one height: those whose path may be shifted."""
    curve = path.curve
    return path.cuts & (np.abs(curve.along[:, 2]) < _LEVEL) & (np.abs(curve.climb[:, 2]) < _LEVEL)


def first_bend(path: ProgramPath) -> float | None:
    """Where the first cut block bends, or the first corner between two is [m]; None: nowhere."""
    curve, cut = path.curve, cut_level(path)
    places = curve.knots[:-1][cut & ~curve.straight]
    corners = np.flatnonzero((turn_angles(curve) > _KINK) & cut[:-1] & cut[1:])
    found = [*places[:1], *curve.knots[1:-1][corners[:1]]]
    return float(min(found)) if found else None


def stops(path: ProgramPath) -> npt.NDArray[np.bool_]:
    """Joints at which a cut at one height begins or ends: in a corner, a stop or another move, shape (n - 1,)."""
    cut = cut_level(path)
    parted = (turn_angles(path.curve) > _KINK) | path.stop_at
    return (cut[:-1] != cut[1:]) | (cut[:-1] & cut[1:] & parted)


def first_place(path: ProgramPath) -> float:
    """Where the shift may begin [m]."""
    bend = first_bend(path)
    return 0.0 if bend is None else max(bend - BEFORE_CURVE, 0.0)


def stretches(path: ProgramPath) -> list[tuple[float, float]]:
    """From where to where cuts at one height run through [m]: not beyond a corner, a pause or a change of feed."""
    curve, cut = path.curve, cut_level(path)
    parted = stops(path) | (path.feed[:-1] != path.feed[1:])
    found: list[tuple[float, float]] = []
    for i in np.flatnonzero(cut):
        low, high = float(curve.knots[i]), float(curve.knots[i + 1])
        if found and i > 0 and cut[i - 1] and not parted[i - 1]:
            found[-1] = (found[-1][0], high)
        else:
            found.append((low, high))
    return found
