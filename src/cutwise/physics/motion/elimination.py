r"""Every posture of any arm with six turning joints: elimination down to one eigenvalue problem.

With the joints as motions :math:`e_i = \exp(S_i q_i)` about their axes at zero, a pose is
:math:`e_1 e_2 e_3 e_4 e_5 e_6 = E`. Three neighbours and the axis of the fourth stand on one side, where they do not
feel the fourth; the other two joints on the other side, for example :math:`e_3 e_4 e_5\,\ell_6 = e_2^{-1} e_1^{-1}
E\,\ell_6`. For a line with direction :math:`l` through :math:`p` the 14 numbers

.. math:: p,\; l,\; p\cdot p,\; p\cdot l,\; p\times l,\; (p\cdot p)\,l - 2 (p\cdot l)\,p

and 1 turn under a motion by a matrix (15, 15) that holds the sine and cosine of a joint to first power only. Of the 14
equations linear algebra eliminates the two joints of one side (8 products of their sines and cosines), which leaves 6
in the three of the other. Written in half angles, and each once more times one of them, they are twelve equations
:math:`(M_0 + x M_1 + x^2 M_2)\,v = 0` for :math:`x = \tan` of half of the hidden joint: 24 eigenvalues, 8 of them
:math:`\pm i`, 16 the postures, real ones on the real axis. None is lost, whatever the geometry, as long as this pencil
is regular. Which three joints and which hidden one make it regular depends on the arm (parallel and meeting axes spoil
some of the choices); :func:`elimination` tries them on postures that it knows, and keeps the best.

References
----------
Raghavan and Roth 1993 (the 14 equations); Manocha and Canny 1994 (the eigenvalue problem).
"""

import functools
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import REVOLUTE, Chain, chain, frames
from cutwise.maths.frames import FloatArray, rotation_about, skew
from cutwise.physics.motion.inverse import polished

MOST = 16  # postures that six turning joints can have for one pose
_TRIED = 24  # known postures on which a formulation is tried
_KEPT = 3  # formulations: the best, and those that are asked when it may have lost something
_START = 0.25  # rad: imaginary part of an angle up to which a root is tried as a real posture; two that meet split so
_SURE = 1e-6  # rad: imaginary part below which a root is a real posture for certain
_REACHED = 1e-10  # of the arm's size: residual of a posture that is on its pose
_SAME = 1e-6  # rad: postures that differ by less are one
_MIXED = 1e-4  # roots that differ by less have vectors that are not to be trusted
_SINGULAR = 1e-9  # smallest over largest singular value of a pencil that is of no use
_SHIFTS = (0.7, -1.9, 2.4)  # rad: where the half angles begin, so that none of the usual postures lies at infinity

_SHAKES = (5e-4, -7e-4, 2e-3)  # rad, or parts of the size of the arm
_ASKEW = np.array([0.36, 0.48, 0.8])

_SAMPLES = (0.0, 2.0 * math.pi / 3.0, -2.0 * math.pi / 3.0)
_TO_AFFINE = np.linalg.inv([[1.0, math.cos(angle), math.sin(angle)] for angle in _SAMPLES])


class Formulation(NamedTuple):
    """One way to eliminate: which joints stand where, and what does not depend on the pose."""

    backwards: bool  # the chain is read from the tool to the base: joints 6 ... 1, angles reversed
    triple: tuple[int, int, int]  # three neighbours; the joint behind them drops out
    pair: tuple[int, int]  # the two joints that linear algebra eliminates
    hidden: int  # 0, 1 or 2: the one of the triple whose half angle is the eigenvalue
    side: FloatArray  # 14 equations in the half angles of the triple, hidden one first, shape (14, 27)
    left: FloatArray  # factors before the pose, shape (a, 15, 15)
    right: FloatArray  # and behind it, shape (b, 15); a b = 9 products of 1, cosine and sine of the pair


class Elimination(NamedTuple):
    """An arm with its formulations, from :func:`elimination`."""

    chain: Chain
    rotation: FloatArray  # of the last frame at zero, shape (3, 3)
    origin: FloatArray  # [m] of the last frame at zero, shape (3,)
    scale: float  # [m] what counts as one
    axes: FloatArray  # of the joints at zero, shape (6, 3)
    points: FloatArray  # [m] on the axes, shape (6, 3)
    formulations: tuple[Formulation, ...]
    proven: bool  # the best formulation found every known posture


def _carried(rotation: FloatArray, shift: FloatArray) -> FloatArray:
    """Matrices (..., 15, 15) by which motions (..., 3, 3), (..., 3) carry the 14 numbers of a line, and 1."""
    t, tx = shift, skew(shift)
    square, t_turned = np.sum(t * t, axis=-1), np.einsum("...i,...ij->...j", t, rotation)
    tx_turned = tx @ rotation
    m = np.zeros((*shift.shape[:-1], 15, 15))
    for block in (0, 3, 8, 11):
        m[..., block : block + 3, block : block + 3] = rotation
    m[..., 0:3, 14], m[..., 6, 0:3], m[..., 6, 14] = t, 2.0 * t_turned, square
    m[..., 7, 3:6], m[..., 8:11, 3:6] = t_turned, tx_turned
    m[..., 11:14, 8:11], m[..., 11:14, 7] = -2.0 * tx_turned, -2.0 * t
    m[..., 11:14, 3:6] = square[..., None, None] * rotation - 2.0 * t[..., :, None] * t_turned[..., None, :]
    m[..., 6, 6] = m[..., 7, 7] = m[..., 14, 14] = 1.0
    return m


def _numbers(point: FloatArray, axis: FloatArray) -> FloatArray:
    """The 14 numbers of a line, and 1."""
    pp, pl = point @ point, point @ axis
    return np.concatenate([point, axis, [pp, pl], np.cross(point, axis), pp * axis - 2.0 * pl * point, [1.0]])


def _joint(axis: FloatArray, point: FloatArray) -> FloatArray:
    """Matrices (3, 15, 15) of 1, cosine and sine of a turn about an axis."""
    turns = np.array([rotation_about(axis, angle) for angle in _SAMPLES])
    return np.einsum("ij,jab->iab", _TO_AFFINE, _carried(turns, point - turns @ point))


def _half_angles(shift: float) -> FloatArray:
    r"""1, cosine and sine of :math:`\theta` as :math:`C^2, CS, S^2` of half of :math:`\theta` - shift, (3, 3)."""
    c, s = math.cos(shift), math.sin(shift)
    return np.array([[1.0, 0.0, 1.0], [c, -2.0 * s, -c], [s, 2.0 * c, -s]])


def _formulation(axes: FloatArray, points: FloatArray, backwards: bool, first: int, hidden: int) -> Formulation:
    """The triple begins at joint ``first`` (0, 1 or 2) of the chain as it is read."""
    order = tuple(range(5, -1, -1)) if backwards else tuple(range(6))
    away = np.array([1.0, 1.0, -1.0])[:, None, None]  # the inverse of a turn: the sine reversed
    forth = [_joint(axes[i], points[i]) for i in order]
    back = [away * matrices for matrices in forth]
    line = _numbers(points[order[first + 3]], axes[order[first + 3]])
    turned = np.einsum("iab,jbc,kcd,d->ijka", *forth[first : first + 3], line, optimize=True)[..., :14]
    if first == 2:
        left = np.einsum("iab,jbc->ijac", back[1], back[0]).reshape(9, 15, 15)
        right, pair = line[None], (1, 0)
    elif first == 1:
        left, right, pair = back[0], back[5] @ line, (0, 5)
    else:
        left, pair = np.eye(15)[None], (5, 4)
        right = np.einsum("iab,jb->ija", back[5], back[4] @ line).reshape(9, 15)
    shifts = [_half_angles(shift) for shift in _SHIFTS]
    side = np.einsum("ijka,ix,jy,kz->axyz", turned, *shifts, optimize=True)
    side = np.moveaxis(side, hidden + 1, 1).reshape(14, 27)
    triple = (order[first], order[first + 1], order[first + 2])
    return Formulation(backwards, triple, (order[pair[0]], order[pair[1]]), hidden, side, left, right)


_SOME_ROOT = np.array([1.0, 0.4, 0.16])
_ONE = np.einsum("i,j,k->ijk", *[[1.0, 0.0, 1.0]] * 3).reshape(27)  # C^2 + S^2 of all three


def _pencils(f: Formulation, turned: FloatArray, moved: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Matrices (m, 3, 12, 12) of 1, x, x^2; what the pair is to be solved from, (m, 15, 9); how regular both are, (m,).

    Regular: smallest over largest singular value at some x that is no root.
    """
    if f.backwards:
        turned = np.swapaxes(turned, -1, -2)
        moved = -np.einsum("...ij,...j->...i", turned, moved)
    pose = _carried(turned, moved)
    carried = np.einsum("aij,mjk,bk->mabi", f.left, pose, f.right, optimize=True)
    pair = np.swapaxes(carried.reshape(len(pose), 9, 15), 1, 2)
    vectors, values, _ = np.linalg.svd(pair[:, :14, 1:])
    free = np.swapaxes(vectors[:, :, 8:], 1, 2)
    rows = free @ (f.side - pair[:, :14, :1] * _ONE)
    rows = rows.reshape(len(pose), 6, 3, 9)
    pencil = np.zeros((len(pose), 3, 12, 12))
    for power in range(3):
        pencil[:, power, :6, :9] = rows[:, :, power]
        pencil[:, power, 6:, 3:] = rows[:, :, power]
    size = np.linalg.svd(np.einsum("k,mkab->mab", _SOME_ROOT, pencil), compute_uv=False)
    return pencil, pair, np.minimum(size[:, -1] / size[:, 0], values[:, -1] / values[:, 0])


def _eigen(pencil: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues (m, 24) and vectors (m, 12, 24) of quadratic pencils; a singular one is moved off by rounding."""
    companion = np.zeros((len(pencil), 24, 24))
    companion[:, :12, 12:] = np.eye(12)
    right = np.concatenate([pencil[:, 0], pencil[:, 1]], axis=2)
    try:
        companion[:, 12:] = -np.linalg.solve(pencil[:, 2], right)
    except np.linalg.LinAlgError:
        noise = np.random.default_rng(0).normal(size=(12, 12))
        size = np.abs(pencil).max(axis=(1, 2, 3))[:, None, None] + 1e-300
        companion[:, 12:] = -np.linalg.solve(pencil[:, 2] + 1e-13 * size * noise, right)
    companion[~np.isfinite(companion).all(axis=(1, 2))] = 0.0
    values, vectors = np.linalg.eig(companion)
    return values, vectors[:, :12]


def _apart(roots: FloatArray) -> bool:
    """Whether real roots [rad] are single: postures that share a hidden angle share their vectors, which then mix."""
    gaps = np.abs(np.exp(1j * roots)[:, None] - np.exp(1j * roots)) + np.eye(len(roots))
    return bool(gaps[np.abs(roots.imag) < 10.0 * _MIXED].min(initial=1.0) > _MIXED)


def _ratio(vectors: FloatArray, axis: int) -> FloatArray:
    """Half angle [rad] of a joint from vectors (n, 4, 3): neighbouring powers, where they are largest."""
    count = vectors.shape[axis] - 1
    low = np.take(vectors, range(count), axis=axis).reshape(len(vectors), -1)
    high = np.take(vectors, range(1, count + 1), axis=axis).reshape(len(vectors), -1)
    at = np.argmax(np.abs(low) + np.abs(high), axis=1)[:, None]
    low, high = (np.take_along_axis(x, at, axis=1)[:, 0] for x in (low, high))
    return np.arctan2((high * np.conj(low)).real, np.abs(low) ** 2)


def _starts(
    arm: Elimination, f: Formulation, turned: FloatArray, moved: FloatArray
) -> Iterator[tuple[FloatArray, FloatArray, bool]]:
    """Per pose: postures near real roots (k, 6) [rad], how far each root is from a real one [rad], and regular or not."""
    pencil, pair, regularity = _pencils(f, turned, moved / arm.scale)
    values, vectors = _eigen(pencil)
    with np.errstate(all="ignore"):
        imaginary = np.abs(2.0 * np.arctan(values).imag)
    imaginary = np.where(np.isfinite(imaginary), imaginary, math.inf)
    others = [k for k in range(3) if k != f.hidden]
    for m in range(len(values)):
        near = np.flatnonzero(imaginary[m] < _START)
        if not len(near):
            yield np.empty((0, 6)), np.empty(0), bool(regularity[m] > _SINGULAR)
            continue
        v = np.swapaxes(vectors[m][:, near], 0, 1).reshape(len(near), 4, 3)
        angles = np.zeros((len(near), 3))
        angles[:, f.hidden] = 2.0 * np.arctan(values[m, near].real)
        angles[:, others[0]], angles[:, others[1]] = 2.0 * _ratio(v, 1), 2.0 * _ratio(v, 2)
        halves = 0.5 * np.moveaxis(angles, -1, 0)
        powers = [np.stack([np.cos(h) ** 2, np.cos(h) * np.sin(h), np.sin(h) ** 2], axis=1) for h in halves]
        powers.insert(0, powers.pop(f.hidden))
        terms = np.einsum("ni,nj,nk->nijk", *powers).reshape(len(near), 27)
        wanted = f.side @ terms.T - pair[m, :14, :1]
        products = np.linalg.lstsq(pair[m, :14, 1:], wanted, rcond=None)[0].T  # c2, s2, c1, ., ., s1, ., .
        q = np.zeros((len(near), 6))
        sign = -1.0 if f.backwards else 1.0
        q[:, list(f.triple)] = sign * (angles + np.array(_SHIFTS))
        q[:, f.pair[0]] = sign * np.arctan2(products[:, 5], products[:, 2])
        q[:, f.pair[1]] = sign * np.arctan2(products[:, 1], products[:, 0])
        clear = bool(regularity[m] > _SINGULAR) and _apart(2.0 * np.arctan(values[m, near]))
        yield _with_the_last(arm, f, q, turned[m]), imaginary[m, near], clear


def _with_the_last(arm: Elimination, f: Formulation, q: FloatArray, turned: FloatArray) -> FloatArray:
    """The joint that dropped out, from the turn that is left for it."""
    last = ({0, 1, 2, 3, 4, 5} - {*f.triple, *f.pair}).pop()
    for row in q:
        before, behind = np.eye(3), np.eye(3)
        for joint in range(last):
            before = before @ rotation_about(arm.axes[joint], row[joint])
        for joint in range(last + 1, 6):
            behind = behind @ rotation_about(arm.axes[joint], row[joint])
        left = before.T @ turned @ behind.T
        axis = arm.axes[last]
        row[last] = math.atan2(
            axis @ [left[2, 1] - left[1, 2], left[0, 2] - left[2, 0], left[1, 0] - left[0, 1]],
            np.trace(left) - axis @ left @ axis,
        )
    return q


class Postures(NamedTuple):
    """All postures of m poses."""

    q: FloatArray  # [rad] within half a turn of zero, shape (m, 16, 6), NaN where there are no more
    whole: np.ndarray  # nothing hints at a posture that was lost, bool, shape (m,)


def _found_by(
    arm: Elimination, f: Formulation, rotations: FloatArray, positions: FloatArray, shaken: float = 0.0
) -> Iterator[tuple[FloatArray, bool]]:
    """Per pose: postures (k, 6) from one formulation, each on the pose, and whether nothing hints at another one.

    ``shaken``: the roots are those of poses next to these, by so many radians and parts of the arm's size.
    """
    turned = rotations @ arm.rotation.T
    moved = positions - np.einsum("mij,j->mi", turned, arm.origin)
    if shaken:
        turned = turned @ rotation_about(_ASKEW, shaken)
        moved = moved + shaken * arm.scale * _ASKEW[::-1]
    for m, (starts, away, regular) in enumerate(_starts(arm, f, turned, moved)):
        q, error = polished(arm.chain, rotations[m], positions[m], starts, length=arm.scale)
        reached = error < _REACHED * arm.scale
        found = _distinct(q[reached])
        yield found, regular and len(found) % 2 == 0 and bool(np.all(reached[away < _SURE]))


def _distinct(*found: FloatArray) -> FloatArray:
    """Postures that differ by more than rounding, wrapped to half a turn of zero, shape (k, 6)."""
    kept: list[FloatArray] = []
    for q in _turned_off(np.concatenate(found)):
        if all(np.abs(_turned_off(q - other)).max() > _SAME for other in kept):
            kept.append(q)
    return np.array(kept).reshape(-1, 6)


def all_postures(arm: Elimination, rotations: FloatArray, positions: FloatArray) -> Postures:
    r"""Every posture that brings the last frame to poses (m, 3, 3), (m, 3); limits are not looked at.

    The roots of the best formulation are polished on the chain itself, to 1e-10 of its size. Postures of a pose come in
    pairs, and every real root is one, apart from the others: where that does not hold, or nothing was found, the other
    formulations are asked too. Poses at which none of them is sound, as many with right angles, take the roots of
    poses next to them.
    A pose with infinitely many postures, such as one that puts two axes in line, gives some of them.

    References
    ----------
    Raghavan and Roth 1993, J. Mech. Des. 115; Manocha and Canny 1994, IEEE Trans. Robot. Autom. 10.
    """
    count = len(positions)
    found, sound = [np.empty((0, 6)) for _ in range(count)], np.zeros(count, dtype=np.bool_)

    def ask(f: Formulation, which: np.ndarray, shaken: float) -> None:
        asked = _found_by(arm, f, rotations[which], positions[which], shaken)
        for k, (q, whole) in zip(which, asked, strict=True):
            found[k], before = _distinct(found[k], q), len(found[k])
            sound[k] |= whole if not shaken else len(found[k]) == before and before % 2 == 0

    open_ones = np.arange(count)
    for f in arm.formulations:
        ask(f, open_ones, 0.0)
        open_ones = np.flatnonzero([not sound[k] or not len(found[k]) for k in range(count)])
    for shaken in _SHAKES:
        open_ones = np.flatnonzero(~sound)
        for f in arm.formulations[:1]:
            ask(f, open_ones, shaken)
    result = np.full((count, MOST, 6), math.nan)
    for k, q in enumerate(found):
        result[k, : min(len(q), MOST)] = q[:MOST]
    return Postures(result, sound & arm.proven)


def elimination(serial: Chain) -> Elimination:
    """Find the formulations that suit an arm of six turning joints.

    Raises
    ------
    ValueError
        Not six turning joints.

    References
    ----------
    Raghavan and Roth 1993, J. Mech. Des. 115; which joints to eliminate is found by trial here.
    """
    if len(serial.kinds) != 6 or not np.all(serial.kinds == REVOLUTE):
        raise ValueError("the elimination needs six turning joints")
    return _elimination(*(array.tobytes() for array in (serial.axes, serial.rotations, serial.origins)))


@functools.lru_cache(maxsize=32)
def _elimination(axes: bytes, rotations: bytes, origins: bytes) -> Elimination:
    read = [np.frombuffer(text) for text in (axes, rotations, origins)]
    serial = chain([REVOLUTE] * 6, read[0], read[2], rotations=read[1].reshape(6, 3, 3))
    at = frames(serial, np.zeros(6))
    points, directions = at.origins[1:], np.einsum("kij,kj->ki", at.rotations[1:], serial.axes)
    scale = float(max(np.linalg.norm(np.diff(points, axis=0), axis=1).sum(), 1e-3))
    arm = Elimination(serial, at.rotations[-1], at.origins[-1], scale, directions, points, (), False)
    random = np.random.default_rng(11)
    q = random.uniform(-math.pi, math.pi, (_TRIED, 6))
    known = frames(serial, q)
    turned = known.rotations[:, -1] @ arm.rotation.T
    moved = known.origins[:, -1] - np.einsum("mij,j->mi", turned, arm.origin)
    rated = []
    for backwards, first, hidden in itertools.product((False, True), range(3), range(3)):
        f = _formulation(directions, points / scale, backwards, first, hidden)
        rated.append((_regularity(f, turned[:4], moved[:4] / scale), f))
    rated.sort(key=lambda pair: -pair[0])
    best = []
    for regularity, f in rated[: 2 * _KEPT]:
        if regularity < _SINGULAR:
            break
        found = list(_found_by(arm, f, known.rotations[:, -1], known.origins[:, -1]))
        lost = sum(not _among(one, postures) for one, (postures, _) in zip(q, found, strict=True))
        best.append((lost, sum(not sound for _, sound in found), -regularity, f))
    best.sort(key=lambda entry: entry[:3])
    kept = tuple(entry[3] for entry in best[:_KEPT])
    return arm._replace(formulations=kept, proven=bool(best) and best[0][0] == 0)


def _among(posture: FloatArray, found: FloatArray) -> bool:
    return any(np.abs(_turned_off(q - posture)).max() < _SAME for q in found)


def _turned_off(angles: FloatArray) -> FloatArray:
    """Angles without whole turns, within half a turn of zero."""
    return np.asarray((angles + math.pi) % (2.0 * math.pi) - math.pi)


def _regularity(f: Formulation, turned: FloatArray, moved: FloatArray) -> float:
    """Smallest over largest singular value of the pencil and of the pair's equations, over some poses; 0: useless."""
    return float(_pencils(f, turned, moved)[2].min())
