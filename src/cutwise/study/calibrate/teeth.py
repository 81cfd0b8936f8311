r"""Forces of a mill with run-out over time, on the tool: x feed, y normal, z to the motor.

Tooth j of N stands at the height z at :math:`\varphi_j = \varphi_0 + \Omega t + 2\pi j/N - \kappa z`,
:math:`\kappa = 2\tan\beta/D`. It meets what the last N teeth left,

.. math:: h_j = \max(0, \min_{m=1..N}[m c \sin\varphi_j + R_j - R_{j+m}]), \qquad R_j = \rho\cos(\lambda - 2\pi j/N)

and cuts with :math:`K_c h + K_e` along, across and up, while it is in the arc and :math:`h > 0`. Integrated over z without
slices: h is a chain of :math:`m c \sin\varphi + d` whose joints sit at constant :math:`\sin\varphi`, each with an integral
of its own.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.study.calibrate.posed import FloatArray

_STRAIGHT = 1e-9  # [rad] of lag over the depth, below which the teeth are straight


class Mill(NamedTuple):
    """The mill and its cut."""

    teeth: int
    feed: float  # per tooth [m]
    depth: float  # axial [m]
    lag: float  # of the flutes over the height [rad/m]
    arc: tuple[float, float]  # [rad]


class Shape(NamedTuple):
    """What the forces depend on besides the coefficients."""

    angle: float  # of tooth 0 at time 0 [rad]
    speed: float  # [rad/s]
    runout: float  # [m]
    direction: float  # of the run-out [rad]


def basis(mill: Mill, shape: Shape, time: FloatArray) -> FloatArray:
    r"""Integrals over all teeth and the depth of h cos, h sin, h, cos, sin and 1 while they cut, shape (6, n) [m^2, m]."""
    total = np.zeros((6, len(time)))
    numbers = np.arange(mill.teeth)
    radius = shape.runout * np.cos(shape.direction - 2.0 * math.pi * numbers / mill.teeth)
    for j in numbers:
        behind = radius[j] - radius[(j + 1 + numbers) % mill.teeth]  # of the tooth m = 1 ... N before it
        pieces = _pieces(mill, behind)
        turned = shape.angle + shape.speed * time + 2.0 * math.pi * j / mill.teeth
        if mill.lag * mill.depth < _STRAIGHT:
            total += mill.depth * _direct(pieces, turned)
        else:
            total += (_summed(pieces, turned) - _summed(pieces, turned - mill.lag * mill.depth)) / mill.lag
    return total


class Pieces(NamedTuple):
    """Chip thickness of a tooth over a turn: m c sin + d between angles that rise."""

    start: FloatArray  # [rad]
    end: FloatArray
    slope: FloatArray  # m c [m]
    gap: FloatArray  # d [m]


def _pieces(mill: Mill, behind: FloatArray) -> Pieces:
    """The lower envelope of the lines m c s + d over s = sin phi, where it is above 0, on both sides of a quarter turn."""
    slopes = mill.feed * np.arange(1, mill.teeth + 1)
    crossings = {0.0, 1.0}
    for a in range(mill.teeth):
        crossings.add(-behind[a] / slopes[a])
        for b in range(a):
            crossings.add((behind[a] - behind[b]) / (slopes[b] - slopes[a]))
    edges = np.array(sorted(s for s in crossings if 0.0 <= s <= 1.0))
    low, high = edges[:-1], edges[1:]
    middle = 0.5 * (low + high)
    values = slopes[:, None] * middle + behind[:, None]
    least = np.argmin(values, axis=0)
    cuts = values[least, np.arange(len(middle))] > 0.0
    low, high, least = low[cuts], high[cuts], least[cuts]
    rising = (np.arcsin(low), np.arcsin(high))
    start = np.concatenate([rising[0], math.pi - rising[1][::-1]])
    end = np.concatenate([rising[1], math.pi - rising[0][::-1]])
    which = np.concatenate([least, least[::-1]])
    start, end = np.maximum(start, mill.arc[0]), np.minimum(end, mill.arc[1])
    kept = end > start
    return Pieces(start[kept], end[kept], slopes[which[kept]], behind[which[kept]])


def _integrals(slope: FloatArray, gap: FloatArray, phi: FloatArray) -> FloatArray:
    """Integrals from 0 of h cos, h sin, h, cos, sin, 1 with h = slope sin + gap, shape (6, ...)."""
    s, c = np.sin(phi), np.cos(phi)
    return np.stack([
        0.5 * slope * s * s + gap * s, slope * (0.5 * phi - 0.5 * s * c) - gap * c, -slope * c + gap * phi, s, -c, phi,
    ])  # fmt: skip


def _summed(pieces: Pieces, phi: FloatArray) -> FloatArray:
    """Integrals over all pieces up to angles, turns counted; shape (6, n)."""
    turns = np.floor(phi / (2.0 * math.pi))
    inside = phi - 2.0 * math.pi * turns
    if not len(pieces.start):
        return np.zeros((6, len(phi)))
    whole = _integrals(pieces.slope, pieces.gap, pieces.end) - _integrals(pieces.slope, pieces.gap, pieces.start)
    before = np.concatenate([np.zeros((6, 1)), np.cumsum(whole, axis=1)], axis=1)
    at = np.searchsorted(pieces.start, inside, side="right") - 1
    known = np.maximum(at, 0)
    slope, gap, start = pieces.slope[known], pieces.gap[known], pieces.start[known]
    reached = np.minimum(inside, pieces.end[known])
    part = _integrals(slope, gap, reached) - _integrals(slope, gap, start)
    return before[:, -1:] * turns + before[:, known] + np.where(at >= 0, part, 0.0)


def _direct(pieces: Pieces, phi: FloatArray) -> FloatArray:
    """The integrands themselves: straight flutes."""
    inside = np.mod(phi, 2.0 * math.pi)
    if not len(pieces.start):
        return np.zeros((6, len(phi)))
    at = np.maximum(np.searchsorted(pieces.start, inside, side="right") - 1, 0)
    cuts = (inside >= pieces.start[at]) & (inside < pieces.end[at])
    s, c = np.sin(inside), np.cos(inside)
    h = pieces.slope[at] * s + pieces.gap[at]
    return np.where(cuts, np.stack([h * c, h * s, h, c, s, np.ones_like(h)]), 0.0)


def columns(mill: Mill, shape: Shape, time: FloatArray, cutting: FloatArray) -> FloatArray:
    """What a unit of each coefficient, offset and slope adds to the three channels, shape (3 n, 12)."""
    hc, hs, h, c, s, one = basis(mill, shape, time) * cutting
    zero, ones = np.zeros_like(time), np.ones_like(time)
    coefficients = [
        (-hc, hs, zero), (-hs, -hc, zero), (zero, zero, -h), (-c, s, zero), (-s, -c, zero), (zero, zero, -one),
    ]  # fmt: skip
    drift = [tuple(value if k == axis else zero for k in range(3)) for value in (ones, time) for axis in range(3)]
    return np.stack([np.stack(each, axis=1).reshape(-1) for each in (*coefficients, *drift)], axis=1)


def chip(mill: Mill, shape: Shape) -> float:
    """Thickest chip that any tooth takes [m]."""
    numbers = np.arange(mill.teeth)
    radius = shape.runout * np.cos(shape.direction - 2.0 * math.pi * numbers / mill.teeth)
    top = 0.0
    for j in numbers:
        pieces = _pieces(mill, radius[j] - radius[(j + 1 + numbers) % mill.teeth])
        for phi in (pieces.start, pieces.end):
            top = max(top, float(np.max(pieces.slope * np.sin(phi) + pieces.gap, initial=0.0)))
    return top
