r"""Whether a ball cutter on a rod reaches an edge: inequalities with margins, the tilt that is needed, and remedies.

Angles on the ball are measured from the rod. The knife covers :math:`\beta \le \chi \le 180^\circ - \beta_p`: none
round the neck, and none, or no cutting speed, at the pole.
"""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.paths.chamfer.ball_path import Chamfer, ChamferPath, NoPathError
from cutwise.paths.pipe import HOLE_SURFACE, PipeHole, height_along_hole

if TYPE_CHECKING:
    from scipy import optimize
else:
    optimize = later("scipy.optimize")

_ROUNDING = 1e-9  # [m] or [rad] that does not break an inequality
LOPSIDED = 2.0  # ratio of the legs above which a chamfer of constant width is hardly useful

ROD_IN_BALL = "rod_smaller_than_ball"
NECK = "knife_reaches_neck"
BALL_ENTERS = "ball_enters_hole"
ROD_WALL = "rod_clears_wall"
ROD_PART = "rod_clears_part"
KNIFE = "knife_covers_contact"
WALL = "legs_within_wall"
GOUGE = "no_gouge"
EDGE = "no_edge"
PATH = "no_path"


class BallCutter(NamedTuple):
    """Ball on a rod."""

    ball_radius: float  # [m] R_B
    rod_radius: float  # [m] R_od
    knife_limit: float  # [rad] beta: the knife begins at this angle from the rod
    pole_limit: float = 0.0  # [rad] beta_p: no knife, or no use of it, this near to the pole


class Margin(NamedTuple):
    """An inequality that a path has to meet: it does if the margin is not negative."""

    code: str
    value: float  # [m] or [rad]
    angle: bool  # whether the margin is an angle
    meaning: str

    @property
    def met(self) -> bool:
        """Whether the inequality holds; rounding of a nanometre or a nanoradian does not break it."""
        return self.value >= -_ROUNDING

    def __str__(self) -> str:
        value = self.value if abs(self.value) > _ROUNDING else 0.0
        size = f"{math.degrees(value):+.4g} deg" if self.angle else f"{value * 1e3:+.4g} mm"
        return f"{self.code}: {self.meaning} (margin {size})"


def contact_angles(path: ChamferPath, axis: FloatArray) -> FloatArray:
    r"""Angle of both chamfer borders on the ball from the rod, :math:`\cos\chi_i = (Q_i - S) \cdot k / R_B` [rad].

    Where surfaces are planes in the normal plane and the rod lies in the second: :math:`\chi_{2,1} = \varphi / 2 +
    \delta \mp \arcsin(w / 2R_B)`. ``axis``: unit vector from the ball along the rod. Shape (n, 2).

    Examples
    --------
    A chamfer of 6 mm by a ball of 5 mm on a right angle, the rod along the hole: 45 degrees, arcsin 3/5 more and less.

    >>> from cutwise.paths.chamfer.ball_path import TANGENT, chamfer_path
    >>> from cutwise.paths.pipe import one_turn, pipe_edge
    >>> edge = pipe_edge(PipeHole(50e-3, 20e-3, 20e-3), one_turn(8), inner=True)
    >>> path = chamfer_path(edge, Chamfer(6e-3, tier=TANGENT), 5e-3)
    >>> np.degrees(contact_angles(path, np.array([0.0, 0.0, 1.0]))[2]).round(4).tolist()
    [81.8699, 8.1301]

    References
    ----------
    Derived here for the cutter of Sato et al. 2016, sec. 3.2.
    """
    arm = path.contact - path.centre[:, None, :]
    along = arm @ axis
    return np.arctan2(np.linalg.norm(np.cross(arm, axis), axis=2), along)


def knife_margin(path: ChamferPath, tool: BallCutter, axis: FloatArray) -> float:
    r""":math:`\min(\chi_{min} - \beta,\ 180^\circ - \beta_p - \chi_{max})` [rad]."""
    chi = contact_angles(path, axis)
    return float(min(chi.min() - tool.knife_limit, math.pi - tool.pole_limit - chi.max()))


def rod_wall_clearances(path: ChamferPath, part: PipeHole, tool: BallCutter) -> FloatArray:
    r"""Clearance of a rod along the drill axis in its hole at each place, :math:`r - |S_\perp| - R_{od}` [m]."""
    offset = path.centre - np.array([part.eccentricity, 0.0, 0.0])
    axis = part.drill_axis
    across = offset - (offset @ axis)[:, None] * axis
    return part.hole_radius - np.linalg.norm(across, axis=1) - tool.rod_radius


def rod_wall_clearance(path: ChamferPath, part: PipeHole, tool: BallCutter) -> float:
    r"""Clearance of a rod along the drill axis in its hole, :math:`r - \max|S_\perp| - R_{od}` [m]."""
    return float(rod_wall_clearances(path, part, tool).min())


def tool_margins(tool: BallCutter) -> list[Margin]:
    """What the cutter must be in itself.

    Examples
    --------
    A rod of half the ball: the neck ends at 30 degrees.

    >>> [round(m.value, 6) for m in tool_margins(BallCutter(2e-3, 1e-3, math.radians(45.0)))]  # 1 mm, 15 degrees
    [0.001, 0.261799]

    References
    ----------
    Derived here for the cutter of Sato et al. 2016, sec. 3.2.
    """
    neck = math.asin(min(1.0, tool.rod_radius / tool.ball_radius))
    return [
        Margin(ROD_IN_BALL, tool.ball_radius - tool.rod_radius, False, "the rod must be thinner than the ball"),
        Margin(NECK, tool.knife_limit - neck, True, "the knife cannot begin inside the rod, beta >= asin(R_od/R_B)"),
    ]


def entry_margin(part: PipeHole, tool: BallCutter, clearance: float) -> Margin:
    """The ball must pass the hole to get at the inner edge from outside.

    Examples
    --------
    >>> str(entry_margin(PipeHole(20e-3, 2e-3, 5e-3), BallCutter(2e-3, 1e-3, 0.0), 1e-3)).split(" (")[1]
    'margin +2 mm)'
    """
    room = part.hole_radius - clearance - tool.ball_radius
    return Margin(BALL_ENTERS, room, False, "the ball must pass through the hole, R_B + clearance < r")


def bore_margin(part: PipeHole, tool: BallCutter, clearance: float) -> Margin:
    """A tool that comes along the bore must fit into it.

    Examples
    --------
    >>> round(1e3 * bore_margin(PipeHole(20e-3, 2e-3, 5e-3), BallCutter(2e-3, 1e-3, 0.0), 1e-3).value, 9)
    15.0
    """
    room = part.radius - part.wall - clearance - tool.ball_radius
    return Margin(BALL_ENTERS, room, False, "the ball must fit into the bore of the pipe")


def knife_margin_of(path: ChamferPath, tool: BallCutter, axis: FloatArray) -> Margin:
    """The knife margin of a path as an inequality."""
    return Margin(KNIFE, knife_margin(path, tool, axis), True, "the contact must lie on the knife, off neck and pole")


def leg_margin(path: ChamferPath, part: PipeHole, *, inner: bool) -> Margin:
    """The chamfer must end before the other edge of the wall, all round; the margin is along the hole."""
    theta, height = _border_on_wall(path, part)
    above = height - height_along_hole(part, theta, inner=not inner)
    room = float((-above if inner else above).min())
    return Margin(WALL, room, False, "the leg in the hole must be shorter than the wall")


def shared_wall_margin(outer: ChamferPath, inner: ChamferPath, part: PipeHole) -> Margin:
    """The chamfers of both edges of a wall must leave some of it between them, all round; along the hole."""
    theta, top = _border_on_wall(outer, part)
    below, bottom = _border_on_wall(inner, part)
    room = float((top - np.interp(theta, below, bottom, period=2.0 * math.pi)).min())
    return Margin(WALL, room, False, "the legs of both chamfers in the hole must be shorter than the wall")


def _border_on_wall(path: ChamferPath, part: PipeHole) -> tuple[FloatArray, FloatArray]:
    """Angle about the drill axis [rad] and height along it [m] of the chamfer border on the wall of the hole."""
    arm = path.contact[:, HOLE_SURFACE] - np.array([part.eccentricity, 0.0, 0.0])
    e2 = np.array([0.0, math.cos(part.inclination), -math.sin(part.inclination)])
    return np.arctan2(arm @ e2, arm[:, 0]), arm @ part.drill_axis


def least_tilt(
    cut: Chamfer, shortest: Callable[[Chamfer], float], widest_wedge: float, *, step: float = math.radians(1.0),
    exact: float = 1e-14,
) -> float | None:  # fmt: skip
    """Smallest constant tilt at which the shortest margin of a path is not negative, or None.

    Parameters
    ----------
    cut : Chamfer
        Width and tier; its own tilt is not looked at.
    shortest : callable
        Smallest margin of the path of a chamfer; may raise NoPathError.
    widest_wedge : float
        Largest wedge angle along the edge [rad]: tilts stay below 90 degrees minus half of it.
    step : float
        Step in which the sign change is bracketed [rad].
    exact : float
        Accuracy to which Brent's method refines it [rad].

    Returns
    -------
    float or None
        [rad]

    Examples
    --------
    A margin that grows by 1 mm for each radian, 0.1 mm short without a tilt:

    >>> round(least_tilt(Chamfer(1e-3), lambda cut: 1e-3 * (cut.tilt - 0.1), 0.5 * math.pi), 9)
    0.1

    References
    ----------
    Derived here.
    """

    def at(tilt: float) -> float:
        try:
            return shortest(cut._replace(tilt=tilt))
        except NoPathError:
            return -1.0

    if at(0.0) >= 0.0:
        return 0.0
    end = 0.5 * math.pi - 0.5 * widest_wedge - 1e-6
    low = 0.0
    while low < end:
        high = min(end, low + step)
        if at(high) >= 0.0:
            found = float(optimize.brentq(at, low, high, xtol=exact, rtol=1e-14))
            return found if at(found) >= -1e-12 else min(high, found + 2.0 * exact)
        low = high
    return None
