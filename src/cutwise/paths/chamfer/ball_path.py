r"""Centre path of a ball that leaves a chamfer of constant width along an edge.

Three tiers: *tangent* puts the two chamfer borders on the tangent planes, *surface* on the true surfaces in the normal
plane of the edge, *envelope* also lets the ball of every other place touch the borders and not cross them. In the
normal plane the axes are the bisector :math:`b_0` into the air and :math:`k` from the second surface to the first; with
the half wedge angle :math:`\eta = \varphi / 2` the surfaces leave the edge along :math:`u_{1,2} = -\cos\eta\, b_0
\pm \sin\eta\, k` with the outward normals :math:`n_{1,2} = \sin\eta\, b_0 \pm \cos\eta\, k`.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.later import later
from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray, segment
from cutwise.maths.edges import EdgeFrames, reversed_edge, swapped_sides
from cutwise.maths.surfaces import IntArray, section_height

if TYPE_CHECKING:
    from scipy import interpolate
else:
    interpolate = later("scipy.interpolate")

TANGENT = 0
SURFACE = 1
ENVELOPE = 2
TIERS = {"tangent": TANGENT, "surface": SURFACE, "envelope": ENVELOPE}

_STEPS = 25
_TRUST = 0.1  # of the width: an envelope centre farther than this from the surface centre is a stray root


class Chamfer(NamedTuple):
    """What is to be cut."""

    width: float  # [m] chord between the chamfer borders, or the leg if ``leg``
    leg: bool = False  # the width is the distance of both borders from the edge
    tilt: float = 0.0  # [rad] delta: turns the chamfer towards the second surface, the chord stays
    tier: int = ENVELOPE


class ChamferPath(NamedTuple):
    """Centre path of the ball, with what it touches; n samples as in the frames."""

    frames: EdgeFrames
    centre: FloatArray  # [m] of the ball, shape (n, 3)
    contact: FloatArray  # [m] borders of the chamfer on both surfaces, shape (n, 2, 3)
    leg: FloatArray  # [m] distance of the borders from the edge, shape (n, 2)
    air: FloatArray  # unit, at right angles to the chord, out of the material, shape (n, 3)
    tier: IntArray  # tier that each sample reached: the envelope falls back to the surface, shape (n,)


def path_of(path: ChamferPath, frames: EdgeFrames, keep: NDArray[np.int64] | slice) -> ChamferPath:
    """Some samples of a path, with the frames of the same samples."""
    return ChamferPath(frames, *(np.ascontiguousarray(a[keep]) for a in path[1:]))  # type: ignore[arg-type]


def reversed_path(path: ChamferPath) -> ChamferPath:
    """The same path run the other way."""
    return path_of(path, reversed_edge(path.frames), slice(None, None, -1))


def swapped_path(path: ChamferPath) -> ChamferPath:
    """The same path with the two surfaces exchanged."""
    return path._replace(
        frames=swapped_sides(path.frames), contact=np.ascontiguousarray(path.contact[:, ::-1]),
        leg=np.ascontiguousarray(path.leg[:, ::-1]),
    )  # fmt: skip


class NoPathError(ValueError):
    """No ball position leaves this chamfer; the message says where and why."""


def stand_off(width: float, ball_radius: float, wedge: FloatArray) -> FloatArray:
    r"""Distance of the ball centre from the edge, :math:`d = \sqrt{R_B^2 - w^2/4} - \tfrac{w}{2} \cot(\varphi/2)` [m].

    Symmetric chamfer between tangent planes; its legs are :math:`w / (2 \sin(\varphi/2))`.

    ``width`` w [m], ``ball_radius`` :math:`R_B` [m], ``wedge`` :math:`\varphi` [rad].
    Valid for :math:`w < 2 R_B` and plane faces. Derived here, after Sato et al. 2016, sec. 3.

    Examples
    --------
    A ball of 5 mm and a right angle, 6 mm wide: 4 - 3 mm.

    >>> round(1e3 * float(stand_off(6e-3, 5e-3, 0.5 * math.pi)), 9)
    1.0
    """
    return np.sqrt(ball_radius**2 - width**2 / 4.0) - 0.5 * width / np.tan(0.5 * wedge)


def width_slope(width: float, ball_radius: float, wedge: FloatArray) -> FloatArray:
    r"""Change of chamfer width with the stand-off of the ball, planar wedge; derived here.

    .. math:: \frac{dw}{dd} = -2 \sin\frac{\varphi}{2} \, \frac{d + a \cos(\varphi/2)}{a + d \cos(\varphi/2)}

    Parameters
    ----------
    width, ball_radius : float
        Chord w and ball radius [m].
    wedge : array
        Wedge angle [rad].

    Examples
    --------
    The chamfer of :func:`stand_off`, -1 / (1/2 + 3/8):

    >>> round(float(width_slope(6e-3, 5e-3, 0.5 * math.pi)), 6)
    -1.142857
    """
    d = stand_off(width, ball_radius, wedge)
    a = 0.5 * width / np.sin(0.5 * wedge)
    c = np.cos(0.5 * wedge)
    return -2.0 * np.sin(0.5 * wedge) * (d + a * c) / (a + d * c)


def planar_legs(cut: Chamfer, wedge: FloatArray) -> FloatArray:
    r"""Legs on the tangent planes, :math:`a_{1,2} = w \cos(\varphi/2 \pm \delta) / \sin\varphi` [m]; shape (n, 2).

    ``cut``: with its width w and tilt, below 90° - :math:`\varphi/2`; ``wedge``:
    :math:`\varphi` [rad], shape (n,). Derived here.

    Examples
    --------
    >>> (1e3 * planar_legs(Chamfer(2e-3), np.array([0.5 * math.pi]))).round(6).tolist()
    [[1.414214, 1.414214]]
    """
    if cut.leg:
        return np.full((len(wedge), 2), cut.width)
    half = 0.5 * wedge
    return cut.width * np.stack([np.cos(half + cut.tilt), np.cos(half - cut.tilt)], axis=1) / np.sin(wedge)[:, None]


def chamfer_path(
    frames: EdgeFrames, cut: Chamfer, ball_radius: float, *, nodes: EdgeFrames | None = None
) -> ChamferPath:
    """Centre path of a ball along an edge.

    Parameters
    ----------
    frames : EdgeFrames
        Where the path is wanted.
    cut : Chamfer
        Width, definition, tilt and tier.
    ball_radius : float
        :math:`R_B` [m].
    nodes : EdgeFrames, optional
        Samples of the same edge and parameter from which the borders are interpolated for the envelope tier; needed
        when ``frames`` are coarse. Default: ``frames``.

    Raises
    ------
    NoPathError
        The chord does not fit the ball, a leg is not positive, or the surfaces end before the chamfer does.

    Examples
    --------
    At the side of a cross hole faces are square, and the ball on its tangent planes that of :func:`stand_off`:

    >>> from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge
    >>> edge = pipe_edge(PipeHole(50e-3, 20e-3, 20e-3), one_turn(8), inner=False)
    >>> path = chamfer_path(edge, Chamfer(6e-3, tier=TANGENT), 5e-3)
    >>> round(1e3 * float(np.linalg.norm(path.centre[2] - edge.point[2])), 6)
    1.0

    References
    ----------
    After Sato et al. 2016, sec. 3; its sections on the path are lost, the construction here is derived.
    """
    _check(frames, cut, ball_radius)
    if cut.tier != ENVELOPE:
        return _in_normal_planes(frames, cut, ball_radius)
    if nodes is None:
        return _envelope(frames, _in_normal_planes(frames, cut, ball_radius), ball_radius)
    _check(nodes, cut, ball_radius)
    return _envelope(frames, _in_normal_planes(nodes, cut, ball_radius), ball_radius)


def possible(frames: EdgeFrames, cut: Chamfer, ball_radius: float) -> NDArray[np.bool_]:
    """At which samples of an edge the ball can leave this chamfer, as far as the two surfaces go; shape (n,)."""
    half = 0.5 * frames.wedge
    chord = 2.0 * cut.width * np.sin(half) if cut.leg else np.full(len(half), cut.width)
    fits = (half + abs(cut.tilt) < 0.5 * math.pi - 1e-3) & (chord < 2.0 * ball_radius) & (half > 1e-2)
    legs = np.where(fits[:, None], planar_legs(cut, np.where(fits, frames.wedge, 1.0)), np.nan)
    _legs_on_surfaces(frames, cut.width, cut.leg, cut.tilt, legs, np.zeros_like(legs))
    return fits & np.isfinite(legs[:, 0])


def _check(frames: EdgeFrames, cut: Chamfer, ball_radius: float) -> None:
    half = 0.5 * float(frames.wedge.max())
    if cut.leg and cut.tilt:
        raise NoPathError(
            "a tilt keeps the chord and changes the legs: it does not go with a width defined by the legs"
        )
    if half >= 0.5 * math.pi - 1e-6:
        raise NoPathError("the surfaces are tangent to one another somewhere along the edge: nothing to chamfer there")
    if half + abs(cut.tilt) >= 0.5 * math.pi:
        room = math.degrees(0.5 * math.pi - half)
        raise NoPathError(
            f"a tilt of {math.degrees(cut.tilt):.3g} deg leaves no leg: less than {room:.3g} deg is possible"
        )
    chord = 2.0 * cut.width * math.sin(half) if cut.leg else cut.width
    if chord >= 2.0 * ball_radius:
        raise NoPathError(
            f"a chamfer {chord * 1e3:.4g} mm wide is larger than the ball, {2e3 * ball_radius:.4g} mm in diameter"
        )


def _in_normal_planes(frames: EdgeFrames, cut: Chamfer, ball_radius: float) -> ChamferPath:
    """The tangent and the surface tier."""
    n = len(frames.point)
    legs = planar_legs(cut, frames.wedge)
    heights = np.zeros((n, 2))
    if cut.tier != TANGENT:
        _legs_on_surfaces(frames, cut.width, cut.leg, cut.tilt, legs, heights)
        failed = np.flatnonzero(np.isnan(legs[:, 0]))
        if failed.size:
            x, y, z = 1e3 * frames.point[failed[0]]
            raise NoPathError(
                f"no chamfer of this width at ({x:.3f}, {y:.3f}, {z:.3f}) mm: the surfaces bend away before it ends"
            )
    along, normal = frames.into, frames.normal
    contact = frames.point[:, None, :] + legs[:, :, None] * along + heights[:, :, None] * normal
    chord = contact[:, 0] - contact[:, 1]
    length = np.linalg.norm(chord, axis=1)
    air = np.cross(frames.tangent, chord / length[:, None])
    air *= np.sign(np.einsum("ij,ij->i", air, frames.air))[:, None]
    rise = np.sqrt(ball_radius**2 - 0.25 * length**2)
    centre = contact.mean(axis=1) + rise[:, None] * air
    tier = np.full(n, min(cut.tier, SURFACE), np.int64)
    return ChamferPath(frames, centre, contact, np.hypot(legs, heights), air, tier)


@compiled
def _legs_on_surfaces(
    frames: EdgeFrames, width: float, leg: bool, tilt: float, legs: FloatArray, heights: FloatArray
) -> None:
    r"""Newton's method for the legs on the true surfaces; NaN at samples that have no solution.

    Chord: :math:`|Q_1 - Q_2| = w` and :math:`(Q_1 - Q_2) \cdot b = 0`, :math:`b = \cos\delta\, b_0 - \sin\delta\, k`.
    Leg: :math:`a_i^2 + g_i^2 = a^2` for each surface.
    """
    b1, b2 = math.cos(tilt), -math.sin(tilt)
    for i in range(frames.point.shape[0]):
        ch, sh = math.cos(0.5 * frames.wedge[i]), math.sin(0.5 * frames.wedge[i])
        p1, p2 = legs[i, 0], legs[i, 1]
        g1 = g2 = 0.0
        legs[i, 0] = legs[i, 1] = math.nan
        change = math.inf
        for _ in range(_STEPS):
            g1, s1 = section_height(
                frames.surfaces, frames.face[i, 0], frames.section[i, 0], frames.point[i], frames.into[i, 0],
                frames.normal[i, 0], p1, g1,
            )  # fmt: skip
            g2, s2 = section_height(
                frames.surfaces, frames.face[i, 1], frames.section[i, 1], frames.point[i], frames.into[i, 1],
                frames.normal[i, 1], p2, g2,
            )  # fmt: skip
            if leg:
                d1 = (p1 * p1 + g1 * g1 - width * width) / (2.0 * (p1 + g1 * s1))
                d2 = (p2 * p2 + g2 * g2 - width * width) / (2.0 * (p2 + g2 * s2))
            else:
                db = -(p1 - p2) * ch + (g1 - g2) * sh  # chord along the bisector
                dk = (p1 + p2) * sh + (g1 + g2) * ch  # and across
                f1 = db * db + dk * dk - width * width
                f2 = db * b1 + dk * b2
                db1, dk1 = -ch + s1 * sh, sh + s1 * ch
                db2, dk2 = ch - s2 * sh, sh + s2 * ch
                j11, j12 = 2.0 * (db * db1 + dk * dk1), 2.0 * (db * db2 + dk * dk2)
                j21, j22 = db1 * b1 + dk1 * b2, db2 * b1 + dk2 * b2
                det = j11 * j22 - j12 * j21
                d1 = (f1 * j22 - f2 * j12) / det
                d2 = (f2 * j11 - f1 * j21) / det
            change = abs(d1) + abs(d2)
            if not change < 10.0 * width:
                break
            p1 -= d1
            p2 -= d2
            if change < 1e-13 * width + 1e-17:
                break
        if change < 1e-9 * width and p1 > 0.0 and p2 > 0.0:
            legs[i, 0], legs[i, 1] = p1, p2
            heights[i, 0], heights[i, 1] = g1, g2


def _envelope(frames: EdgeFrames, nodes: ChamferPath, ball_radius: float) -> ChamferPath:
    """The envelope tier at ``frames`` from the borders at the nodes of the surface tier."""
    edge = nodes.frames
    table = np.hstack([nodes.contact[:, 0], nodes.contact[:, 1], nodes.centre, nodes.leg])
    at = edge.parameter
    if edge.closed:
        at = np.append(at, at[0] + edge.period)
        table = np.vstack([table, table[:1]])
    spline = interpolate.CubicSpline(at, table, bc_type="periodic" if edge.closed else "not-a-knot")
    at_frames = spline(frames.parameter)
    contact = np.ascontiguousarray(at_frames[:, :6].reshape(-1, 2, 3))
    centre = np.ascontiguousarray(at_frames[:, 6:9])
    trust = _TRUST * float(np.linalg.norm(nodes.contact[:, 0] - nodes.contact[:, 1], axis=1).mean())
    coefficients = np.ascontiguousarray(spline.c[:, :, :6].transpose(1, 2, 0))
    reached = np.empty(len(centre), np.int64)
    _ball_between_tubes(
        np.ascontiguousarray(spline.x), coefficients, edge.period, frames.parameter, frames.air,
        frames.across, ball_radius, trust, centre, reached,
    )  # fmt: skip
    chord = contact[:, 0] - contact[:, 1]
    middle = centre - contact.mean(axis=1)
    air = middle - np.einsum("ij,ij->i", middle, frames.tangent)[:, None] * frames.tangent
    air -= (np.einsum("ij,ij->i", air, chord) / np.einsum("ij,ij->i", chord, chord))[:, None] * chord
    air /= np.linalg.norm(air, axis=1, keepdims=True)
    return ChamferPath(frames, centre, contact, at_frames[:, 9:], air, reached)


@compiled
def _border(at: FloatArray, c: FloatArray, column: int, t: float) -> tuple[float, ...]:
    """Point, first and second derivative of a border at a parameter, nine numbers."""
    i = segment(at, t)
    d = t - at[i]
    a0, a1, a2, a3 = c[i, column, 0], c[i, column, 1], c[i, column, 2], c[i, column, 3]
    b0, b1, b2, b3 = c[i, column + 1, 0], c[i, column + 1, 1], c[i, column + 1, 2], c[i, column + 1, 3]
    e0, e1, e2, e3 = c[i, column + 2, 0], c[i, column + 2, 1], c[i, column + 2, 2], c[i, column + 2, 3]
    return (
        ((a0 * d + a1) * d + a2) * d + a3, ((b0 * d + b1) * d + b2) * d + b3, ((e0 * d + e1) * d + e2) * d + e3,
        (3.0 * a0 * d + 2.0 * a1) * d + a2, (3.0 * b0 * d + 2.0 * b1) * d + b2, (3.0 * e0 * d + 2.0 * e1) * d + e2,
        6.0 * a0 * d + 2.0 * a1, 6.0 * b0 * d + 2.0 * b1, 6.0 * e0 * d + 2.0 * e1,
    )  # fmt: skip


@compiled
def _ball_between_tubes(
    at: FloatArray, coefficients: FloatArray, period: float, parameter: FloatArray,
    bisector: FloatArray, across: FloatArray, ball_radius: float, trust: float, centre: FloatArray, reached: IntArray,
) -> None:  # fmt: skip
    r"""Centres at the ball radius from both borders as curves: the exact envelope, pointwise by Newton's method.

    .. math:: |S - Q_i(t_i)| = R_B, \quad (S - Q_i) \cdot Q_i'(t_i) = 0, \quad S \in \text{normal plane}

    The two :math:`t_i` are eliminated, which leaves a 2 by 2 system. ``centre`` comes in as the surface tier and is
    replaced where the iteration ends closer to it than ``trust``; elsewhere the surface tier stays.
    """
    first, last = at[0], at[-1]
    for i in range(parameter.size):
        sx, sy, sz = centre[i, 0], centre[i, 1], centre[i, 2]
        t = np.array([parameter[i], parameter[i]])
        f = np.empty(2)
        jb = np.empty(2)
        jk = np.empty(2)
        good = False
        for _ in range(_STEPS):
            move = np.empty(2)
            gt = np.empty(2)
            gb = np.empty(2)
            gk = np.empty(2)
            for m in range(2):
                place = t[m]
                if period > 0.0:
                    place = first + (place - first) % period
                else:
                    place = min(max(place, first), last)
                qx, qy, qz, vx, vy, vz, ax, ay, az = _border(at, coefficients, 3 * m, place)
                rx, ry, rz = sx - qx, sy - qy, sz - qz
                g = rx * vx + ry * vy + rz * vz
                gt[m] = -(vx * vx + vy * vy + vz * vz) + rx * ax + ry * ay + rz * az
                gb[m] = bisector[i, 0] * vx + bisector[i, 1] * vy + bisector[i, 2] * vz
                gk[m] = across[i, 0] * vx + across[i, 1] * vy + across[i, 2] * vz
                move[m] = g / gt[m]
                fb = bisector[i, 0] * rx + bisector[i, 1] * ry + bisector[i, 2] * rz
                fk = across[i, 0] * rx + across[i, 1] * ry + across[i, 2] * rz
                f[m] = 0.5 * (rx * rx + ry * ry + rz * rz - ball_radius * ball_radius) + g * move[m]
                jb[m] = fb + g * gb[m] / gt[m]
                jk[m] = fk + g * gk[m] / gt[m]
            det = jb[0] * jk[1] - jb[1] * jk[0]
            db = -(f[0] * jk[1] - f[1] * jk[0]) / det
            dk = -(f[1] * jb[0] - f[0] * jb[1]) / det
            change = abs(db) + abs(dk)
            if not change < 10.0 * trust:
                break
            sx += db * bisector[i, 0] + dk * across[i, 0]
            sy += db * bisector[i, 1] + dk * across[i, 1]
            sz += db * bisector[i, 2] + dk * across[i, 2]
            for m in range(2):
                t[m] -= move[m] + (gb[m] * db + gk[m] * dk) / gt[m]
            if change < 1e-14 + 1e-13 * ball_radius:
                good = True
                break
        away = math.sqrt((sx - centre[i, 0]) ** 2 + (sy - centre[i, 1]) ** 2 + (sz - centre[i, 2]) ** 2)
        reached[i] = SURFACE
        if good and away < trust:
            reached[i] = ENVELOPE
            centre[i, 0], centre[i, 1], centre[i, 2] = sx, sy, sz
