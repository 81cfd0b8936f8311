r"""Chip thickness from where the tool really was when earlier teeth passed: vibration, run-out and any force law.

A tooth at the angle :math:`\theta` now stands where the tooth before it stood one tooth period :math:`\tau` ago. With the
positions :math:`r` of the tool axis, motion, vibration and run-out together, it removes what all earlier teeth have left,

.. math:: h = \max\bigl(0,\ \min_{k \ge 1} n(\theta) \cdot [\,r(t) - r(t - k\tau)\,]\bigr) ,

so that a tooth which jumps out of the cut leaves its chip to the next (multiple delays). In a steady cut this is the
surface that :mod:`cutwise.physics.cutting.regenerative` records; here the arc of the cut may turn and change.
"""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.discs import Discs, first_disc
from cutwise.physics.cutting.uneven import Edges, force_per_length

FloatArray = npt.NDArray[np.float64]


@compiled
def delayed_disc_forces(
    angle: float, wall: float, arc: float, lowest: int, highest: int, moved: FloatArray, mill: Discs, edges: Edges
) -> tuple[float, float, float]:
    r"""Force on a mill that turns clockwise, disc by disc, seen against the spindle axis.

    .. math::
        h = \max\bigl(0,\ \min_k n(\vartheta) \cdot [\,r(t) - r(t - k\tau)\,]\bigr), \qquad
        F_{xy} = -F_t(\sin\vartheta, -\cos\vartheta) - F_r(\cos\vartheta, \sin\vartheta), \qquad F_z = -\sum F_a

    Parameters
    ----------
    angle : float
        Angle of flute 0 at the tip in machine axes [rad], falling with time; flute i is :math:`2\pi i/N` behind.
    wall, arc : float
        Angle at which the cut leaves the wall side, and the arc from there [rad].
    lowest, highest : int
        Discs that take part, from ``lowest`` to below ``highest``.
    moved : array (k, 2)
        :math:`r(t) - r(t - k\tau)` for k = 1, 2, ... [m].
    mill : Discs
        The mill.
    edges : Edges
        Force law; its run-out is part of ``moved``.

    Returns
    -------
    tuple
        Force on the tool x, y, z in machine axes [N].

    Notes
    -----
    Valid for :math:`0 \le` arc :math:`\le 2\pi`, displacements small against the mill radius (the normal is that of the
    undisplaced tooth), and as many delays as teeth that may have missed in a row. The midpoint of a disc stands for it.

    Examples
    --------
    A straight tooth across the feed whose forerunner stood 0.3 mm back and the one before 0.1 mm: the chip is 0.1 mm.

    >>> from cutwise.physics.cutting.discs import discs
    >>> from cutwise.physics.cutting.uneven import EdgeCoefficients, even_edges
    >>> edges = even_edges(EdgeCoefficients(1e9, 5e8, 2e8, 0.0, 0.0, 0.0))
    >>> moved, mill = np.array([[3e-4, 0.0], [1e-4, 0.0]]), discs(5e-3, 0.0, 1e-3, 1, 1)
    >>> [round(f, 6) for f in delayed_disc_forces(0.0, -0.5 * math.pi, math.pi, 0, 1, moved, mill, edges)]
    [-50.0, 100.0, -20.0]

    References
    ----------
    Derived here; that the least of several delays counts is the multiple regeneration of Tlusty and Ismail 1981.
    """
    turn = 2.0 * math.pi
    fx, fy, fz = 0.0, 0.0, 0.0
    for tooth in range(mill.teeth):
        base = angle - turn * tooth / mill.teeth
        past = (base - wall) % turn  # of the tip, from the wall side
        for start in (-past, turn - past):  # lags of the discs that stand in the arc
            first = first_disc(start, mill.step, lowest, highest)
            last = first_disc(start + arc, mill.step, lowest, highest)
            if last <= first:
                continue
            x, y, z = _edge_forces(base + (first + 0.5) * mill.step, first, last, moved, mill, edges)
            fx, fy, fz = fx + x, fy + y, fz + z
    return fx, fy, fz


@compiled
def _edge_forces(
    theta: float, first: int, last: int, moved: FloatArray, mill: Discs, edges: Edges
) -> tuple[float, float, float]:
    """Force of discs of one flute; ``theta`` is the angle of the first [rad]."""
    c, s = math.cos(theta), math.sin(theta)
    turn_c, turn_s = math.cos(mill.step), math.sin(mill.step)
    fx, fy, fz = 0.0, 0.0, 0.0
    for _ in range(first, last):
        h = moved[0, 0] * c + moved[0, 1] * s
        for k in range(1, moved.shape[0]):
            h = min(h, moved[k, 0] * c + moved[k, 1] * s)
        if h > 0.0:
            ft, fr, fa = force_per_length(edges, h)
            fx -= ft * s + fr * c
            fy += ft * c - fr * s
            fz -= fa
        c, s = c * turn_c - s * turn_s, s * turn_c + c * turn_s
    return fx * mill.thickness, fy * mill.thickness, fz * mill.thickness
