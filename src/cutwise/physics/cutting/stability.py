"""Chatter stability of milling: Chebyshev collocation of the delay equation in the cut, exact free motion between.

The modes of the tool tip come in as bare matrices, so that this stage knows nothing of how they were found.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class Milling(NamedTuple):
    """Straight-toothed milling in steady state; angles run clockwise from +y (the normal), feed along +x."""

    teeth: int
    entry: float  # angle at which a tooth enters [rad]
    exit: float  # angle at which it leaves [rad]
    tangential: float  # K_tc [N/m^2]
    radial: float  # K_rc [N/m^2]


class Tip(NamedTuple):
    r"""Tool-tip dynamics :math:`\ddot q = -\omega^2 q - 2\zeta\omega\dot q + M^{-1} P^T F`, tip at :math:`P q`."""

    frequency: FloatArray  # [rad/s], shape (m,)
    damping: FloatArray  # [-], shape (m,)
    mass: FloatArray  # [kg], shape (m,)
    direction: FloatArray  # P^T, unit vectors in the xy plane, shape (m, 2)


FreeMotion = Callable[[float], FloatArray]


def arc_of(radial_immersion: float, milling: str) -> tuple[float, float]:
    r"""Entry and exit angle [rad] for a radial immersion :math:`a_e/D` (0 to 1), ``"up"`` or ``"down"``.

    .. math:: \text{up: } 0 \ldots \arccos(1 - 2 a_e/D), \qquad \text{down: } \arccos(2 a_e/D - 1) \ldots \pi
    """
    if not 0.0 < radial_immersion <= 1.0:
        raise ValueError(f"radial immersion must be above 0 and at most 1 of the diameter, got {radial_immersion}")
    if milling == "up":
        return 0.0, math.acos(1.0 - 2.0 * radial_immersion)
    return math.acos(2.0 * radial_immersion - 1.0), math.pi


def directional_matrix(angle: float, case: Milling) -> FloatArray:
    r"""Force per chip displacement and depth, :math:`\sum (K_t\,t n^T + K_r\,n n^T)` over the teeth in cut [N/m^2].

    ``angle`` is that of the tooth that entered last, at least the entry angle; :math:`n = (\sin\phi, \cos\phi)`,
    :math:`t = (\cos\phi, -\sin\phi)`.
    """
    out = np.zeros((2, 2))
    pitch = 2.0 * math.pi / case.teeth
    phi = angle
    while phi <= case.exit + 1e-12:
        n, t = np.array([math.sin(phi), math.cos(phi)]), np.array([math.cos(phi), -math.sin(phi)])
        out += case.tangential * np.outer(t, n) + case.radial * np.outer(n, n)
        phi += pitch
    return out


def chebyshev(n: int) -> tuple[FloatArray, FloatArray]:
    """Chebyshev-Lobatto nodes on [-1, 1], ascending, shape (n+1,), and their differentiation matrix."""
    x = -np.cos(np.pi * np.arange(n + 1) / n)
    weight = np.ones(n + 1)
    weight[0] = weight[-1] = 2.0
    weight *= (-1.0) ** np.arange(n + 1)
    gap = x[:, None] - x[None, :] + np.eye(n + 1)
    matrix = np.outer(weight, 1.0 / weight) / gap
    matrix -= np.diag(matrix.sum(axis=1))
    return x, matrix


def _elements(case: Milling) -> list[tuple[float, float, float]]:
    """Parts of a tooth period with one set of teeth in cut: (angle from entry, its end, angle inside)."""
    pitch, arc = 2.0 * math.pi / case.teeth, case.exit - case.entry
    if arc < pitch * (1.0 - 1e-9):
        return [(0.0, arc, 0.5 * arc)]
    rest = arc % pitch
    if rest < 1e-9 * pitch or rest > pitch * (1.0 - 1e-9):
        return [(0.0, pitch, 0.5 * pitch)]
    return [(0.0, rest, 0.5 * rest), (rest, pitch, 0.5 * (rest + pitch))]


def _matrix_within(angle: float, inside: float, case: Milling) -> FloatArray:
    """:func:`directional_matrix` with the teeth that cut at ``inside``: the ends of an element count as inside."""
    pitch, arc = 2.0 * math.pi / case.teeth, case.exit - case.entry
    out = np.zeros((2, 2))
    lag = 0.0
    while inside + lag < arc:
        out += directional_matrix(case.entry + angle + lag, case._replace(exit=case.entry + angle + lag))
        lag += pitch
    return out


def multipliers(
    depths: FloatArray, spindle: float, case: Milling, tip: Tip, free: FreeMotion, nodes: int = 0
) -> FloatArray:
    r"""Largest characteristic multiplier per tooth period; the cut is stable below one.

    .. math:: \ddot q + \ldots = -a_p M^{-1} P^T W(t) P\,[q(t) - q(t-\tau)]

    collocated at Chebyshev nodes of the time in cut; the state carried over is the displacement at the nodes one
    tooth period ago and the state at the end of the cut.

    Parameters
    ----------
    depths : ndarray
        Axial depths :math:`a_p` [m], shape (n,).
    spindle : float
        [rad/s].
    case : Milling
        Teeth, arc and coefficients.
    tip : Tip
        Dynamics of the tool tip.
    free : callable
        Matrix of the free motion over a time [s] on (displacements, velocities).
    nodes : int
        Nodes per element; 0 lets the wave length decide.

    Returns
    -------
    ndarray
        :math:`|\mu|` [-], shape (n,).

    References
    ----------
    Bueler 2007 (Chebyshev collocation of delay equations); free flight as in Bayly et al. 2003.
    """
    period = 2.0 * math.pi / (case.teeth * spindle)
    m = tip.frequency.size
    directions = _used_directions(tip)
    use = tip.direction @ directions.T  # (m, r): displacement of the tip along the r directions that it can move
    parts = _elements(case)
    sizes = [nodes or _nodes((b - a) / spindle, tip) for a, b, _ in parts]
    total = sum(size + 1 for size in sizes)
    state, rank = 2 * m, directions.shape[0]
    fixed, per_depth = np.zeros((total * state, total * state)), np.zeros((total * state, total * state))
    old = np.zeros((total * state, total * rank))
    entry = np.zeros((total * state, state))
    own = np.zeros((state, state))
    own[:m, m:] = np.eye(m)
    own[m:, :m] = -np.diag(tip.frequency**2)
    own[m:, m:] = -np.diag(2.0 * tip.damping * tip.frequency)
    row = 0
    gap_before = 0.0
    for (a, b, inside), n in zip(parts, sizes, strict=True):
        x, derivative = chebyshev(n)
        derivative = derivative * 2.0 * spindle / (b - a)
        block = slice(row * state, (row + n + 1) * state)
        fixed[block, block] = np.kron(derivative, np.eye(state)) - np.kron(np.eye(n + 1), own)
        for i in range(n + 1):
            at = (row + i) * state
            w = _matrix_within(a + 0.5 * (x[i] + 1.0) * (b - a), inside, case)
            stiff = (tip.direction @ w @ directions.T) / tip.mass[:, None]  # (m, r)
            per_depth[at + m : at + state, at : at + m] = stiff @ use.T
            old[at + m : at + state, (row + i) * rank : (row + i + 1) * rank] = stiff
        head = slice(row * state, row * state + state)
        fixed[head], per_depth[head], old[head] = 0.0, 0.0, 0.0
        fixed[head, head] = np.eye(state)
        if row == 0:
            entry[head] = np.eye(state)
        else:
            fixed[head, (row - 1) * state : row * state] = -free(gap_before)
        row += n + 1
    rest = period - (parts[-1][1] - parts[0][0]) / spindle
    flight = free(max(rest, 0.0))
    return _largest(depths, fixed, per_depth, old, entry @ flight, use, total, state, rank)


def _largest(
    depths: FloatArray, fixed: FloatArray, per_depth: FloatArray, old: FloatArray, entry: FloatArray, use: FloatArray,
    total: int, state: int, rank: int,
) -> FloatArray:  # fmt: skip
    m = use.shape[0]
    carried = total * rank + state
    matrices = np.empty((len(depths), carried, carried))
    pick = np.kron(np.eye(total), np.hstack((use.T, np.zeros((rank, m)))))
    for k, depth in enumerate(depths):
        solved = np.linalg.solve(fixed + depth * per_depth, np.hstack((depth * old, entry)))
        matrices[k, : total * rank] = pick @ solved
        matrices[k, total * rank :] = solved[-state:]
    return np.asarray(np.max(np.abs(np.linalg.eigvals(matrices)), axis=1))


def _used_directions(tip: Tip) -> FloatArray:
    """Orthonormal directions of the plane in which the tip can move at all, shape (1 or 2, 2)."""
    _, size, rows = np.linalg.svd(tip.direction, full_matrices=False)
    return np.asarray(rows[size > 1e-9 * size[0]])


def _nodes(time: float, tip: Tip) -> int:
    """Enough nodes for the quickest mode: 0.8 a radian beyond sixteen (six digits in the reference cases)."""
    return 16 + math.ceil(0.8 * float(np.max(tip.frequency)) * time)


def limit_depth(spindle: float, case: Milling, tip: Tip, free: FreeMotion, deepest: float, grid: int = 80) -> float:
    """Least axial depth [m] that is unstable, met from below on a grid of ``deepest/grid`` and then bisected.

    Infinite if nothing up to ``deepest`` is unstable; islands of instability thinner than the grid are missed.
    """
    depths = np.linspace(deepest / grid, deepest, grid)
    unstable = np.nonzero(multipliers(depths, spindle, case, tip, free) > 1.0)[0]
    if unstable.size == 0:
        return math.inf
    high = float(depths[unstable[0]])
    low = high - deepest / grid
    while high - low > 1e-7 * deepest:
        middle = 0.5 * (low + high)
        if multipliers(np.array([middle]), spindle, case, tip, free)[0] > 1.0:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def lobes(spindles: FloatArray, depths: FloatArray, case: Milling, tip: Tip, free: FreeMotion) -> FloatArray:
    """:func:`multipliers` over a grid of spindle speeds [rad/s] and depths [m]; shape (speeds, depths)."""
    return np.array([multipliers(depths, float(spindle), case, tip, free) for spindle in spindles])
