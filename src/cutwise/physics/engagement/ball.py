r"""Immersion of a ball in the wedge of material along an edge, and in a burr on it, by axial discs.

Local frame of the pass: x along the feed, z along the rod toward the motor, y off the work; down milling. The disc at
height z of the ball has the radius :math:`\rho = \sqrt{R_B^2 - z^2}`; at that height the two faces of the wedge bound
the material to :math:`y_{lo} \le y \le y_{hi}`. A point at the immersion angle :math:`\phi` from +y stands at
:math:`y = \rho \cos\phi`, so material is met between :math:`\arccos(y_{hi}/\rho)` and :math:`\arccos(y_{lo}/\rho)`,
and on the leading half, :math:`0 \le \phi \le \pi`, only.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray


class PassFrames(NamedTuple):
    """Local frames along a path."""

    feed: FloatArray  # x: unit, along the edge at right angles to the rod, shape (n, 3)
    off: FloatArray  # y = z cross x: from the work to the tool in down milling, shape (n, 3)
    plunge: FloatArray  # component of the edge tangent along the rod, shape (n,)


def pass_frames(tangent: FloatArray, axis: FloatArray) -> PassFrames:
    r"""Frames of a pass from edge tangents and the rod direction k: :math:`x = t - (t \cdot k) k`, normalised.

    Where the edge runs along the rod there is no feed across it (:math:`|t \cdot k| = 1`, a plunge): x is then that of
    the nearest place that has one, or any direction across the rod if there is none.
    """
    plunge = tangent @ axis
    x = tangent - plunge[:, None] * axis
    length = np.linalg.norm(x, axis=1)
    known = np.flatnonzero(length > 1e-6)
    if not known.size:
        x = np.tile(np.eye(3)[int(np.argmin(np.abs(axis)))], (len(tangent), 1))
        x -= (x @ axis)[:, None] * axis
    elif known.size < len(x):
        place = np.arange(len(x))
        after = np.clip(np.searchsorted(known, place), 0, known.size - 1)
        before = np.maximum(after - 1, 0)
        nearer = np.abs(known[after] - place) <= np.abs(known[before] - place)
        x = x[np.where(nearer, known[after], known[before])]
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    return PassFrames(x, np.cross(axis, x), plunge)


class Wedge(NamedTuple):
    """The wedge of material in the (y, z) plane of a pass, from the ball centre."""

    y: float  # [m] of the edge
    z: float  # [m] of the edge
    normal1_y: float  # outward normal of the first face
    normal1_z: float
    normal2_y: float
    normal2_z: float


@compiled
def wedge_bounds(wedge: Wedge, z: float) -> tuple[float, float]:
    r"""Material between the faces at a height: :math:`n_i \cdot (p - C) \le 0` for both; (lo, hi) in y [m]."""
    low, high = -math.inf, math.inf
    for m in range(2):
        ny = wedge.normal1_y if m == 0 else wedge.normal2_y
        nz = wedge.normal1_z if m == 0 else wedge.normal2_z
        depth = nz * (z - wedge.z)
        if abs(ny) < 1e-12:
            if depth > 0.0:
                return 0.0, 0.0
        elif ny > 0.0:
            high = min(high, wedge.y - depth / ny)
        else:
            low = max(low, wedge.y - depth / ny)
    return low, high


class Burr(NamedTuple):
    """A burr on the edge: a strip of rectangular section on one face, from the edge on, in the (y, z) plane."""

    height: float  # [m] off the face; not positive: no burr
    width: float  # [m] along the face
    along_y: float  # direction along the face, away from the edge
    along_z: float
    normal_y: float  # outward normal of the face
    normal_z: float


NO_BURR = Burr(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def burr_bounds(wedge: Wedge, burr: Burr, z: float) -> tuple[float, float]:
    """Burr at a height: the cut through its rectangle, (lo, hi) in y [m]; empty where it is not that high or low."""
    low, high = math.inf, -math.inf
    y0, z0 = wedge.y, wedge.z
    for corner in range(4):
        a = 1.0 if corner in (0, 1) else 0.0  # the next corner is along the face, then off it, back, and down
        b = 1.0 if corner in (1, 2) else 0.0
        y1 = wedge.y + a * burr.width * burr.along_y + b * burr.height * burr.normal_y
        z1 = wedge.z + a * burr.width * burr.along_z + b * burr.height * burr.normal_z
        if (z0 <= z <= z1) or (z1 <= z <= z0):
            share = (z - z0) / (z1 - z0) if z1 != z0 else 0.0
            y = y0 + share * (y1 - y0)
            low, high = min(low, y), max(high, y)
            if z1 == z0:
                low, high = min(low, y1), max(high, y1)
        y0, z0 = y1, z1
    return low, high


@compiled
def burr_limits(wedge: Wedge, burr: Burr, ball_radius: float) -> tuple[float, float]:
    """Heights between which the ball may meet the burr [m]; empty if there is none."""
    if burr.height <= 0.0:
        return 0.0, 0.0
    along, off = burr.width * burr.along_z, burr.height * burr.normal_z
    low = wedge.z + min(0.0, along) + min(0.0, off)
    high = wedge.z + max(0.0, along) + max(0.0, off)
    return max(low, -ball_radius), min(high, ball_radius)


@compiled
def disc_arc(low: float, high: float, ball_radius: float, z: float) -> tuple[float, float]:
    """Immersion arc of the disc at height z in material between two y [m]; empty arcs are (0, 0) [rad]."""
    square = ball_radius * ball_radius - z * z
    if square <= 0.0 or high <= low:
        return 0.0, 0.0
    rho = math.sqrt(square)
    if high <= -rho or low >= rho:
        return 0.0, 0.0
    return math.acos(min(1.0, high / rho)), math.acos(max(-1.0, low / rho))


@compiled
def height_limits(wedge: Wedge, ball_radius: float) -> tuple[float, float]:
    """Heights between which the ball may meet the wedge: ends of both borders and the edge, on the ball [m].

    The borders are where a face leaves the ball; between the faces the ball is cut at heights between those two and
    the height of the edge only if its surface has no summit inside the wedge, so the pole heights are added then.
    """
    low, high = wedge.z, wedge.z
    for m in range(2):
        ny = wedge.normal1_y if m == 0 else wedge.normal2_y
        nz = wedge.normal1_z if m == 0 else wedge.normal2_z
        oy = wedge.normal2_y if m == 0 else wedge.normal1_y
        oz = wedge.normal2_z if m == 0 else wedge.normal1_z
        uy, uz = -nz, ny  # along the face, away from the other normal
        if uy * oy + uz * oz > 0.0:
            uy, uz = -uy, -uz
        b = wedge.y * uy + wedge.z * uz
        c = wedge.y * wedge.y + wedge.z * wedge.z - ball_radius * ball_radius
        root = b * b - c
        if root <= 0.0:
            continue
        s = -b + math.sqrt(root)
        low, high = min(low, wedge.z + s * uz), max(high, wedge.z + s * uz)
    for pole in (-ball_radius, ball_radius):
        inside1 = wedge.normal1_y * -wedge.y + wedge.normal1_z * (pole - wedge.z) < 0.0
        inside2 = wedge.normal2_y * -wedge.y + wedge.normal2_z * (pole - wedge.z) < 0.0
        if inside1 and inside2:
            low, high = min(low, pole), max(high, pole)
    return max(low, -ball_radius), min(high, ball_radius)


@compiled
def chip_area(wedge: Wedge, burr: Burr, ball_radius: float, slices: int) -> float:
    """Cross-section that the ball takes off wedge and burr in the plane across the feed, by slices [m^2]."""
    area = 0.0
    for part in range(2):
        low, high = height_limits(wedge, ball_radius) if part == 0 else burr_limits(wedge, burr, ball_radius)
        dz = (high - low) / slices
        for k in range(slices if dz > 0.0 else 0):
            z = low + (k + 0.5) * dz
            square = ball_radius * ball_radius - z * z
            lo, hi = wedge_bounds(wedge, z) if part == 0 else burr_bounds(wedge, burr, z)
            if square > 0.0 and hi > lo:
                rho = math.sqrt(square)
                area += max(0.0, min(hi, rho) - max(lo, -rho)) * dz
    return area
