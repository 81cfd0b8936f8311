"""Volumetric error of a serial machine: where the tool really is, over the whole working space.

The sum :math:`\\sum_i R_{0i}(\\delta_i + \\varepsilon_i \\times r_i)` is taken from the tool inward, so that a point of
a million needs no stored frames: :math:`r_{i-1} = d_i + R_i r_i`, and the error collected so far turns with it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.chains import FIXED, PRISMATIC, Chain, Frames, exact_error, frames, linear_error
from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray, fill_rotation_about, twist_after_motion
from cutwise.physics.motion.geometry import AxisErrors, OutsideTableError, motion_twist

_MOST_INTERVALS = 1 << 15


class ErrorTables(NamedTuple):
    """Errors of all joints on equal steps of their commands, ready for the compiled map."""

    start: FloatArray  # first command of each joint, shape (n,)
    per_step: FloatArray  # 1 / step, shape (n,)
    inner: FloatArray  # twist in frame i (after the chain's motion) at each step, shape (n, k, 6)
    outer: FloatArray  # twist in frame i-1 (before it) at each step, shape (n, k, 6)
    has_inner: np.ndarray  # whether a joint has any, bool, shape (n,)
    has_outer: np.ndarray  # bool, shape (n,)


class Axes(NamedTuple):
    """The moving joints of a machine and their errors; the errors are those of the body that moves."""

    chain: Chain  # displacements as seen along the chain, part to tool
    sense: FloatArray  # +1 or -1: chain displacement per command, shape (n,)
    of_table: np.ndarray  # whether a part-side error is that of the table (else of the tool against it), bool, (n,)
    errors: tuple[AxisErrors | None, ...]  # per joint
    low: FloatArray  # least command of each joint [m or rad], shape (n,)
    high: FloatArray  # greatest, shape (n,)


def _slots(axes: Axes, joint: int, command: FloatArray) -> tuple[FloatArray, FloatArray]:
    # A table's error is that of body i-1 against i: inverted, and "after its motion" lies before the chain's motion.
    errors = axes.errors[joint]
    if errors is None:
        none = np.zeros((*command.shape, 6))
        return none, none
    motion = motion_twist(errors, command)
    constant = np.broadcast_to(errors.location, motion.shape)
    after, before = (np.zeros_like(motion), constant + motion) if errors.before else (motion, constant)
    if axes.chain.sides[joint] > 0:
        return after, before
    sign = -1.0 if axes.of_table[joint] else 1.0
    return sign * before, sign * after


class ChainErrors(NamedTuple):
    """Geometric errors of a posture, one after the other in frame i after the motion; their sum counts to first order.

    Shapes (..., n + 1, 6).
    """

    carried: FloatArray  # what acts before the motion, carried over it
    own: FloatArray  # what acts after it

    @property
    def twists(self) -> FloatArray:
        """Both together, to first order."""
        return self.carried + self.own


def chain_errors(axes: Axes, at: Frames, commands: ArrayLike) -> ChainErrors:
    r"""Geometric errors as twists of the chain bodies, in frame i after the motion.

    Tool side: :math:`E = H \exp[\mathrm{Ad}(H^{-1})\,\xi_\text{before}]^\wedge \exp[\xi]^\wedge`. A table moves against
    the chain, :math:`E^{-1}`: what acts after its motion is carried, with the motion (R, d) of the chain,
    :math:`\varepsilon_i = -R^T \varepsilon`, :math:`\delta_i = -R^T(e + \varepsilon \times d)`, and what acts before
    it comes last. Both are exact; a location error and an error motion that both act before the motion count as one
    twist, their sum.

    Parameters
    ----------
    axes : Axes
        Chain and errors.
    at : Frames
        Frames of the commands.
    commands : array (..., n)
        Of each joint [m or rad]; fixed joints are ignored.

    Raises
    ------
    OutsideTableError
        A command leaves its table.

    References
    ----------
    Demeč and Madáč, Eqs. (2), (6) and (7); names of ISO 230-1 and 230-7; the carrying over is derived here.
    """
    u = np.asarray(commands, dtype=float)
    shape = (*u.shape[:-1], u.shape[-1] + 1, 6)
    found = ChainErrors(np.zeros(shape), np.zeros(shape))
    for joint in range(u.shape[-1]):
        if axes.errors[joint] is None:
            continue
        found.own[..., joint + 1, :], outer = _slots(axes, joint, u[..., joint])
        back = np.swapaxes(at.rotations[..., joint, :, :], -1, -2)
        step = np.einsum("...ij,...j->...i", back, at.origins[..., joint + 1, :] - at.origins[..., joint, :])
        turn = back @ at.rotations[..., joint + 1, :, :]
        found.carried[..., joint + 1, :] = twist_after_motion(outer, turn, step)
    return found


def tabulate(axes: Axes, *, tolerance: float = 1e-10, reach: float = 1.0) -> ErrorTables:
    """Tables on equal steps, refined until straight lines between them miss no joint's error by the tolerance.

    Parameters
    ----------
    axes : Axes
        With the travels over which to tabulate.
    tolerance : float
        [m] of each displacement, and of each rotation times ``reach``.
    reach : float
        Largest distance from an axis to the tool point [m].

    Notes
    -----
    Halved steps are compared at the middles, where a line misses a smooth function most. A measured table has corners
    between the steps: 32768 intervals are the end there, and :func:`interpolation_error` says what is left.

    References
    ----------
    Derived here: a straight line misses a smooth function by :math:`h^2 f''/8`, a quarter at half the step.
    """
    count = len(axes.errors)
    weight = np.array([1.0, 1.0, 1.0, reach, reach, reach])
    intervals = 64
    while True:
        worst = 0.0
        parts = np.linspace(0.0, 1.0, 2 * intervals + 1)
        inner, outer = np.zeros((count, 2 * intervals + 1, 6)), np.zeros((count, 2 * intervals + 1, 6))
        for joint in range(count):
            command = axes.low[joint] + parts * (axes.high[joint] - axes.low[joint])
            inner[joint], outer[joint] = _slots(axes, joint, np.clip(command, axes.low[joint], axes.high[joint]))
            for values in (inner[joint], outer[joint]):
                between = 0.5 * (values[:-2:2] + values[2::2])
                worst = max(worst, float(np.abs((between - values[1::2]) * weight).max()))
        if worst <= 4.0 * tolerance or 2 * intervals >= _MOST_INTERVALS:  # the halved step is kept: a quarter of it
            break
        intervals *= 2
    width = axes.high - axes.low
    per_step = np.divide(2.0 * intervals, width, out=np.zeros(count), where=width > 0.0)
    has = [np.array([bool(np.any(values[joint])) for joint in range(count)]) for values in (inner, outer)]
    return ErrorTables(axes.low.copy(), per_step, inner, outer, has[0], has[1])


@compiled
def _fill_map(
    kinds: np.ndarray,
    chain_axes: FloatArray,
    plain: np.ndarray,
    rotations: FloatArray,
    origins: FloatArray,
    sense: FloatArray,
    start: FloatArray,
    per_step: FloatArray,
    inner: FloatArray,
    outer: FloatArray,
    has_inner: np.ndarray,
    has_outer: np.ndarray,
    commands: FloatArray,
    tip: FloatArray,
    deviation: FloatArray,
) -> int:
    # returns the first point outside a table, or -1
    turn, scratch = np.empty((3, 3)), np.empty((3, 3))
    last = inner.shape[1] - 2
    outside = -1
    for k in range(commands.shape[0]):
        rx, ry, rz = tip[0], tip[1], tip[2]
        ex = ey = ez = 0.0
        for joint in range(len(kinds) - 1, -1, -1):
            u = commands[k, joint]
            cell, part = 0, 0.0
            if has_inner[joint] or has_outer[joint]:
                place = (u - start[joint]) * per_step[joint]
                if not (-1e-9 <= place <= last + 1 + 1e-9):
                    if outside < 0:
                        outside = k
                    place = 0.0
                cell = min(max(int(place), 0), last)
                part = place - cell
            if has_inner[joint]:
                low, high = inner[joint, cell], inner[joint, cell + 1]
                a = low[3] + part * (high[3] - low[3])
                b = low[4] + part * (high[4] - low[4])
                c = low[5] + part * (high[5] - low[5])
                ex += low[0] + part * (high[0] - low[0]) + b * rz - c * ry
                ey += low[1] + part * (high[1] - low[1]) + c * rx - a * rz
                ez += low[2] + part * (high[2] - low[2]) + a * ry - b * rx
            q = sense[joint] * u
            if plain[joint]:
                rx += origins[joint, 0]
                ry += origins[joint, 1]
                rz += origins[joint, 2]
                if kinds[joint] == PRISMATIC:
                    rx += chain_axes[joint, 0] * q
                    ry += chain_axes[joint, 1] * q
                    rz += chain_axes[joint, 2] * q
            else:
                if kinds[joint] == PRISMATIC:
                    rx += chain_axes[joint, 0] * q
                    ry += chain_axes[joint, 1] * q
                    rz += chain_axes[joint, 2] * q
                elif kinds[joint] != FIXED:
                    fill_rotation_about(chain_axes[joint], q, scratch)
                    rx, ry, rz = _turned(scratch, rx, ry, rz)
                    ex, ey, ez = _turned(scratch, ex, ey, ez)
                turn = rotations[joint]
                rx, ry, rz = _turned(turn, rx, ry, rz)
                ex, ey, ez = _turned(turn, ex, ey, ez)
                rx += origins[joint, 0]
                ry += origins[joint, 1]
                rz += origins[joint, 2]
            if has_outer[joint]:
                low, high = outer[joint, cell], outer[joint, cell + 1]
                a = low[3] + part * (high[3] - low[3])
                b = low[4] + part * (high[4] - low[4])
                c = low[5] + part * (high[5] - low[5])
                ex += low[0] + part * (high[0] - low[0]) + b * rz - c * ry
                ey += low[1] + part * (high[1] - low[1]) + c * rx - a * rz
                ez += low[2] + part * (high[2] - low[2]) + a * ry - b * rx
        deviation[k, 0], deviation[k, 1], deviation[k, 2] = ex, ey, ez
    return outside


@compiled
def _turned(rotation: FloatArray, x: float, y: float, z: float) -> tuple[float, float, float]:
    return (
        rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2] * z,
        rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2] * z,
        rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2] * z,
    )


def volumetric_error(axes: Axes, tables: ErrorTables, commands: ArrayLike, tip: ArrayLike) -> FloatArray:
    r"""First-order error of the tool point [m] at scattered points, from tables.

    Parameters
    ----------
    axes, tables
        The machine, and its errors from :func:`tabulate`.
    commands : array (..., n)
        Command of each joint [m or rad].
    tip : array (3,)
        Tool point in the last frame [m].

    Returns
    -------
    array (..., 3)
        In frame 0 (the workpiece).

    Raises
    ------
    OutsideTableError
        A command leaves the travel that was tabulated.

    References
    ----------
    Demeč and Madáč, Eqs. (2) and (5) with the product up to i; taken from the tool inward.
    """
    given = np.asarray(commands, dtype=float)
    flat = np.ascontiguousarray(given.reshape(-1, given.shape[-1]))
    deviation = np.empty((len(flat), 3))
    chain = axes.chain
    plain = np.array([kind in (FIXED, PRISMATIC) for kind in chain.kinds]) & (chain.rotations == np.eye(3)).all((1, 2))
    outside = _fill_map(
        chain.kinds, chain.axes, plain, chain.rotations, chain.origins, axes.sense, *tables, flat,
        np.asarray(tip, dtype=float), deviation,
    )  # fmt: skip
    if outside >= 0:
        raise OutsideTableError(f"point {outside + 1} is beyond the travel of an axis: {flat[outside].tolist()} (SI)")
    return deviation.reshape(*given.shape[:-1], 3)


def diagonals(low: ArrayLike, high: ArrayLike, count: int) -> FloatArray:
    """The four body diagonals of a box of linear travels, ``count`` points each, shape (4, count, 3).

    References
    ----------
    ISO 230-6, diagonal displacement tests.
    """
    least, greatest = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]])
    middle, half = 0.5 * (least + greatest), 0.5 * (greatest - least)
    parts = np.linspace(-1.0, 1.0, count)
    return middle + parts[None, :, None] * (signs * half)[:, None, :]


def along(points: ArrayLike, deviation: ArrayLike) -> FloatArray:
    r"""Error along straight lines of points, from zero at their start [m], shape (..., k).

    .. math:: e_k = (\Delta_k - \Delta_1) \cdot (p_K - p_1)/|p_K - p_1|

    Parameters
    ----------
    points : array (..., k, 3)
        Ideal tool points [m].
    deviation : array (..., k, 3)
        Errors there [m].

    References
    ----------
    ISO 230-6, diagonal displacement tests.
    """
    p, error = np.asarray(points, dtype=float), np.asarray(deviation, dtype=float)
    direction = p[..., -1, :] - p[..., 0, :]
    direction = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    return np.einsum("...ki,...i->...k", error - error[..., :1, :], direction)


def direct_error(axes: Axes, commands: ArrayLike, tip: ArrayLike, *, exact: bool = False) -> FloatArray:
    """The same with every function evaluated at every point, first-order or exact; slower, and the reference.

    References
    ----------
    Demeč and Madáč, Eqs. (2) and (5) with the product up to i.
    """
    u = np.asarray(commands, dtype=float)
    at = frames(axes.chain, u * axes.sense)
    errors = chain_errors(axes, at, u)
    return exact_error(at, errors.carried, tip, errors.own) if exact else linear_error(at, errors.twists, tip)


def interpolation_error(axes: Axes, tables: ErrorTables, tip: ArrayLike, *, points: int = 4096, seed: int = 1) -> float:
    """Largest distance between map and direct evaluation over random points of the working space [m].

    References
    ----------
    Derived here.
    """
    commands = np.random.default_rng(seed).uniform(axes.low, axes.high, (points, len(axes.errors)))
    missed = volumetric_error(axes, tables, commands, tip) - direct_error(axes, commands, tip)
    return float(np.linalg.norm(missed, axis=1).max())
