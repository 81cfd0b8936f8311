"""A drilled pipe: the two edges that a round hole has with the outer and the inner cylinder of a pipe.

The pipe runs along y, the hole is drilled from outside about z; the edge taken is the one on the drill's side. The
drill axis may pass the pipe axis at a distance e along x, and lean by alpha in the y-z plane: two skew lines have no
other freedom.
"""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import EdgeFrames, edge_frames
from cutwise.maths.surfaces import CYLINDER, surfaces

PIPE_SURFACE = 0  # the first surface of the frames
HOLE_SURFACE = 1


class PipeHole(NamedTuple):
    """A pipe with a drilled hole."""

    radius: float  # [m] outer radius R of the pipe
    wall: float  # [m] wall thickness t
    hole_radius: float  # [m] r
    eccentricity: float = 0.0  # [m] e, distance of drill axis and pipe axis
    inclination: float = 0.0  # [rad] alpha, of the drill axis from the normal of the pipe axis

    def surface_radius(self, *, inner: bool) -> float:
        """Radius of the inner or outer cylinder of the pipe [m]."""
        return self.radius - self.wall if inner else self.radius

    @property
    def drill_axis(self) -> FloatArray:
        """Unit vector along the drill, out of the pipe; shape (3,)."""
        return np.array([0.0, np.sin(self.inclination), np.cos(self.inclination)])


class NoEdgeError(ValueError):
    """The hole does not make a closed edge with the cylinder; the message gives the margin."""

    def __init__(self, message: str, margin: float) -> None:
        super().__init__(message)
        self.margin = margin  # [m], negative


def edge_margin(part: PipeHole, *, inner: bool) -> float:
    r"""How far the hole stays inside the cylinder, :math:`\rho - |e| - r` [m]; a closed edge needs more than zero.

    Examples
    --------
    >>> round(1e3 * edge_margin(PipeHole(20e-3, 2e-3, 5e-3, 1e-3), inner=True), 9)
    12.0

    References
    ----------
    Derived here; Sato et al. 2016 have e = 0.
    """
    return part.surface_radius(inner=inner) - abs(part.eccentricity) - part.hole_radius


def height_along_hole(part: PipeHole, theta: FloatArray, *, inner: bool) -> FloatArray:
    r"""Height :math:`\tau` of the edge along the drill axis, :math:`\tau \cos\alpha = h + r \sin\theta \sin\alpha` [m].

    With :math:`h = \sqrt{\rho^2 - x^2}`, :math:`x = e + r \cos\theta`; h is 0 where the hole is beside the cylinder.

    Examples
    --------
    >>> (1e3 * height_along_hole(PipeHole(13e-3, 1e-3, 5e-3), np.array([0.0]), inner=False)).round(9).tolist()
    [12.0]

    References
    ----------
    Sato et al. 2016, Eqs. (4) and (5), with an eccentric and oblique hole.
    """
    x = part.eccentricity + part.hole_radius * np.cos(theta)
    h = np.sqrt(np.maximum(0.0, part.surface_radius(inner=inner) ** 2 - x**2))
    rise = h + part.hole_radius * np.sin(theta) * np.sin(part.inclination)
    return np.asarray(rise / np.cos(part.inclination))


def pipe_edge(part: PipeHole, theta: FloatArray, *, inner: bool) -> EdgeFrames:
    r"""Frames of the inner or outer edge at angles about the drill axis.

    .. math:: C = (e, 0, 0) + r (\cos\theta\, e_1 + \sin\theta\, e_2) + \tau a, \qquad C_x^2 + C_z^2 = \rho^2,\ C_z > 0

    with :math:`e_1 = x`, :math:`e_2 = (0, \cos\alpha, -\sin\alpha)`, :math:`a = (0, \sin\alpha, \cos\alpha)`. Outward
    normals: hole :math:`-(\cos\theta\, e_1 + \sin\theta\, e_2)`, pipe :math:`\pm (C_x, 0, C_z) / \rho`. For
    :math:`e = \alpha = 0` the wedge angle is :math:`\cos\varphi = \pm (r / \rho) \cos^2\theta`, plus outside.

    Parameters
    ----------
    part : PipeHole
        The drilled pipe.
    theta : array
        Angles over one turn, rising, the start not repeated [rad], shape (n,).
    inner : bool
        The edge at the bore of the pipe, else at its outside.

    Raises
    ------
    NoEdgeError
        The hole is not inside the cylinder, :math:`|e| + r \ge \rho`.

    Examples
    --------
    >>> edge = pipe_edge(PipeHole(13e-3, 1e-3, 5e-3), one_turn(8), inner=False)
    >>> (1e3 * edge.point[0]).round(9).tolist(), round(float(np.degrees(edge.wedge[2])), 6)
    ([5.0, 0.0, 12.0], 90.0)

    References
    ----------
    Sato et al. 2016, Eqs. (1)-(6) and (12); the normal of Eq. (12) points into the material and is turned here.
    Eccentric and oblique holes are an extension.
    """
    rho, r = part.surface_radius(inner=inner), part.hole_radius
    margin = edge_margin(part, inner=inner)
    if margin <= 0.0:
        where = "bore" if inner else "outside"
        raise NoEdgeError(
            f"the hole (radius {r * 1e3:g} mm, {abs(part.eccentricity) * 1e3:g} mm off the axis) makes no closed edge "
            f"with the {where} of the pipe (radius {rho * 1e3:g} mm)", margin,
        )  # fmt: skip
    c, s = np.cos(theta)[:, None], np.sin(theta)[:, None]
    sin_a, cos_a = np.sin(part.inclination), np.cos(part.inclination)
    e1, e2, axis = np.array([1.0, 0.0, 0.0]), np.array([0.0, cos_a, -sin_a]), part.drill_axis
    x = part.eccentricity + r * c
    h = np.sqrt(rho**2 - x**2)
    radial = c * e1 + s * e2
    rise = height_along_hole(part, theta, inner=inner)[:, None]
    rise_slope = (x * r * s / h + r * c * sin_a) / cos_a
    point = np.array([part.eccentricity, 0.0, 0.0]) + r * radial + rise * axis
    tangent = r * (c * e2 - s * e1) + rise_slope * axis
    side = -1.0 if inner else 1.0
    pipe_normal = side * np.hstack([x, np.zeros_like(x), h]) / rho
    return edge_frames(
        theta, point, tangent, np.stack([pipe_normal, -radial], axis=1), period=2.0 * np.pi,
        surfaces=surfaces([
            (CYLINDER, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), rho, 0.0),
            (CYLINDER, (part.eccentricity, 0.0, 0.0), tuple(axis), r, 0.0),
        ]),
        face=np.tile(np.array([PIPE_SURFACE, HOLE_SURFACE]), (len(theta), 1)),
    )  # fmt: skip


def one_turn(count: int) -> FloatArray:
    r"""Angles :math:`2 \pi i / n`, the start not repeated [rad].

    Examples
    --------
    >>> np.degrees(one_turn(4)).tolist()
    [0.0, 90.0, 180.0, 270.0]
    """
    return 2.0 * np.pi * np.arange(count) / count
