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

    Raises ``ValueError`` for an immersion outside of that. Valid for a straight cut, feed per tooth small against D.

    Examples
    --------
    >>> [round(math.degrees(angle), 6) for angle in (*arc_of(0.5, "up"), *arc_of(0.25, "down"))]
    [0.0, 90.0, 120.0, 180.0]

    References
    ----------
    Altintas 2012, chapter 2.
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

    Valid for straight teeth (or a helix that lags little over the depth) and small vibrations.

    Examples
    --------
    One tooth across the feed: a displacement along it (first column) gives radial and tangential force.

    >>> directional_matrix(0.5 * math.pi, Milling(1, 0.0, math.pi, 1000.0, 300.0))[:, 0].round(6).tolist()
    [300.0, -1000.0]

    References
    ----------
    Altintas and Budak 1995, directional coefficients, in the axes of :class:`Milling`.
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
    r"""Chebyshev-Lobatto nodes on [-1, 1], ascending, shape (n+1,), and their differentiation matrix.

    .. math:: x_k = -\cos(\pi k / n), \qquad D_{jk} = \frac{c_j}{c_k} \frac{(-1)^{j+k}}{x_j - x_k}, \qquad c_0 = c_n = 2

    Exact for polynomials up to the order n, at least 1.

    Examples
    --------
    >>> x, d = chebyshev(2)
    >>> (d @ x**2)[[0, 2]].round(9).tolist()  # 2 x
    [-2.0, 2.0]

    References
    ----------
    Trefethen 2000, Spectral Methods in MATLAB, chapter 6.
    """
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


class _Element(NamedTuple):
    """A stretch of time with one set of teeth in cut, n nodes; the r directions are those that the tip can move along."""

    free_nodes: FloatArray  # displacement at the nodes per state at the start, shape (n r, 2m)
    free_end: FloatArray  # state at the end per state at the start, shape (2m, 2m)
    forced_nodes: FloatArray  # displacement at the nodes per force there [m/N], shape (n r, n r)
    forced_end: FloatArray  # state at the end per force at the nodes, shape (2m, n r)
    chip_force: FloatArray  # force at the nodes per chip displacement and depth [N/m^2], shape (n r, n r)


def multipliers(
    depths: FloatArray, spindle: float, case: Milling, tip: Tip, free: FreeMotion, nodes: int = 0
) -> FloatArray:
    r"""Largest characteristic multiplier per tooth period; the cut is stable below one.

    .. math:: \ddot q + \ldots = -a_p M^{-1} P^T W(t) P\,[q(t) - q(t-\tau)]

    collocated at Chebyshev nodes of the time in cut. What a tooth period hands on is the displacement of the tip at the
    nodes and the state at the end of the cut. The modes are solved for unit forces once for a spindle speed, so that a
    depth costs an inverse of the size of the nodes; the largest multiplier then comes from a Krylov space.

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

    Notes
    -----
    Valid for small vibrations about a steady cut and teeth whose helix lags little over the depth.

    Examples
    --------
    Without depth the free motion is left, :math:`e^{-\zeta\omega\tau}`: 5 % of 1000 rad/s over 10 ms.

    >>> from scipy.linalg import expm
    >>> tip = Tip(np.array([1000.0]), np.array([0.05]), np.array([1.0]), np.array([[0.0, 1.0]]))
    >>> case = Milling(2, 0.0, 1.0, 1e9, 3e8)
    >>> free = lambda time: expm(np.array([[0.0, 1.0], [-1e6, -100.0]]) * time)
    >>> multipliers(np.zeros(1), 100 * math.pi, case, tip, free).round(6).tolist()  # exp(-1/2)
    [0.606531]

    References
    ----------
    Bueler 2007 (Chebyshev collocation of delay equations); free flight as in Bayly et al. 2003.
    """
    period = 2.0 * math.pi / (case.teeth * spindle)
    parts = _elements(case)
    elements = [_element(part, spindle, case, tip, free, nodes) for part in parts]
    flight = free(max(period - (parts[-1][1] - parts[0][0]) / spindle, 0.0))
    deep = np.asarray(depths, dtype=np.float64)[:, None, None]
    left = [np.linalg.inv(np.eye(e.forced_nodes.shape[0]) + deep * (e.forced_nodes @ e.chip_force)) for e in elements]
    sizes = [e.forced_nodes.shape[0] for e in elements]
    ends = np.cumsum([0, *sizes])

    def next_period(x: FloatArray) -> FloatArray:
        """One tooth period on vectors (depths, carried): displacements a period ago, state at the end of the cut."""
        out = np.empty_like(x)
        state = x[:, ends[-1] :] @ flight.T
        for e, inverse, first, last in zip(elements, left, ends[:-1], ends[1:], strict=True):
            before = x[:, first:last]
            gap = (inverse @ (before - state @ e.free_nodes.T)[:, :, None])[:, :, 0]  # old minus new displacement
            out[:, first:last] = before - gap
            state = state @ e.free_end.T + deep[:, :, 0] * (gap @ e.chip_force.T) @ e.forced_end.T
        out[:, ends[-1] :] = state
        return out

    return _spectral_radius(next_period, len(deep), int(ends[-1]) + 2 * tip.frequency.size)


def _element(
    part: tuple[float, float, float], spindle: float, case: Milling, tip: Tip, free: FreeMotion, nodes: int
) -> _Element:
    begin, end, inside = part
    time, m = (end - begin) / spindle, tip.frequency.size
    n = nodes or _nodes(time, tip)
    x, derivative = chebyshev(n)
    derivative = derivative * 2.0 / time
    directions = _used_directions(tip)
    use, r = tip.direction @ directions.T, directions.shape[0]  # (m, r): tip along the r directions per mode
    free_all = np.array([free(0.5 * (place + 1.0) * time) for place in x[1:]])  # (n, 2m, 2m)
    forced_nodes, forced_end = np.zeros((n, r, n, r)), np.zeros((2 * m, n, r))
    for i in range(m):  # the first node is where the state comes in; the equation holds at the others
        w, z, mass = tip.frequency[i], tip.damping[i], tip.mass[i]
        own = np.kron(derivative[1:, 1:], np.eye(2)) - np.kron(np.eye(n), [[0.0, 1.0], [-w * w, -2.0 * z * w]])
        unit = np.linalg.solve(own, np.kron(np.eye(n), [[0.0], [1.0 / mass]]))  # states per unit force at a node
        forced_nodes += np.einsum("kj,a,b->kajb", unit[::2], use[i], use[i])
        forced_end[i], forced_end[m + i] = np.outer(unit[-2], use[i]), np.outer(unit[-1], use[i])
    chip_force = np.zeros((n, r, n, r))
    for k in range(n):
        w_k = _matrix_within(begin + 0.5 * (x[k + 1] + 1.0) * (end - begin), inside, case)
        chip_force[k, :, k, :] = directions @ w_k @ directions.T
    free_nodes = np.einsum("ia,kij->kaj", use, free_all[:, :m])
    return _Element(
        free_nodes.reshape(n * r, 2 * m), free_all[-1], forced_nodes.reshape(n * r, n * r),
        forced_end.reshape(2 * m, n * r), chip_force.reshape(n * r, n * r),
    )  # fmt: skip


_KRYLOV = 40
_RITZ = 1e-9  # residual of the largest Ritz value, relative, that counts as converged


def _spectral_radius(apply: Callable[[FloatArray], FloatArray], count: int, size: int) -> FloatArray:
    """Largest magnitude of the eigenvalues of ``count`` linear maps on vectors of ``size``, all iterated together.

    Arnoldi from a fixed start; a map whose largest Ritz value has not settled is solved by its whole matrix.
    """
    k = min(_KRYLOV, size)
    basis, hessenberg = np.zeros((count, k + 1, size)), np.zeros((count, k + 1, k))
    start = np.random.default_rng(0).standard_normal(size)
    basis[:, 0] = start / np.linalg.norm(start)
    for j in range(k):
        new = apply(basis[:, j])
        before = np.linalg.norm(new, axis=1)
        for _ in range(2):  # twice is enough for orthogonality
            parts = np.einsum("cks,cs->ck", basis[:, : j + 1], new)
            hessenberg[:, : j + 1, j] += parts
            new = new - np.einsum("cks,ck->cs", basis[:, : j + 1], parts)
        after = np.linalg.norm(new, axis=1)
        after[after <= 1e-13 * before] = 0.0  # the space is complete: what is left is rounding
        hessenberg[:, j + 1, j] = after
        basis[:, j + 1] = np.divide(new, after[:, None], out=np.zeros_like(new), where=after[:, None] > 0.0)
    values, vectors = np.linalg.eig(hessenberg[:, :k])
    top = np.argmax(np.abs(values), axis=1)
    largest = np.abs(values[np.arange(count), top])
    residual = hessenberg[:, k, k - 1] * np.abs(vectors[np.arange(count), k - 1, top])
    for c in np.flatnonzero(residual > _RITZ * largest) if k < size else ():
        whole = np.zeros((size, size))
        for column in range(size):
            probe = np.zeros((count, size))
            probe[c, column] = 1.0
            whole[:, column] = apply(probe)[c]
        largest[c] = np.abs(np.linalg.eigvals(whole)).max()
    return np.asarray(largest)


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

    ``spindle`` [rad/s], ``case``, ``tip``, ``free`` as for :func:`multipliers`; found to 1e-7 of ``deepest`` [m].

    References
    ----------
    As :func:`multipliers`.
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
