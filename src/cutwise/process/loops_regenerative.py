"""The coupled loop of tool-tip modes and regenerative cutting, compiled, and its verdict on stability."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled_sums
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.regenerative import ToothGrid, cut_station, fed_surface, tooth_grid
from cutwise.physics.structure.modes import Modes, transition

FloatArray = npt.NDArray[np.float64]

CHUNK = 2_000_000  # steps between two looks at the keyboard
KICK = 1e-30  # [m] first deviation of the linear run
LARGE = 1e30  # [m] no deviation of the linear run gets here
_FEWEST = 3  # periods that make a slope


class SteadyCut(NamedTuple):
    """A cut of constant immersion with a mill whose tip may vibrate; feed along +x, angles clockwise from +y."""

    teeth: int
    spindle: float  # [rad/s]
    entry: float  # [rad]
    exit: float  # [rad]
    feed_per_tooth: float  # [m]
    depth: float  # axial [m]
    lag_per_depth: float  # helix lag, tan(beta) / R [rad/m]
    discs: int
    coefficients: EdgeCoefficients


class Chatter(NamedTuple):
    """What the tip did, at every step."""

    time: FloatArray  # [s], shape (n,)
    tip: FloatArray  # vibration of the tool centre [m], shape (n, 2)
    force: FloatArray  # on the tool [N], shape (n, 2)
    growth: float  # factor per tooth period of small deviations from the periodic cut [-]; stable below 1

    @property
    def stable(self) -> bool:
        """Whether small deviations die out."""
        return self.growth < 1.0


@compiled_sums
def _step_all(
    first: int, last: int, grid: ToothGrid, surface: FloatArray, feed: float, cutting: FloatArray, steps: FloatArray,
    along: FloatArray, state: FloatArray, memory: FloatArray, tip: FloatArray, force: FloatArray,
) -> None:  # fmt: skip
    revolution = surface.shape[0]
    teeth, modes = revolution // grid.tooth, along.shape[0]
    kt, kr, et, er, least_chip = cutting[0], cutting[1], cutting[2], cutting[3], cutting[4]
    normal_x, normal_y, any_inside = grid.normal_x, grid.normal_y, grid.any_inside
    fx, fy, old_fx, old_fy = 0.0, 0.0, memory[0], memory[1]
    for k in range(first, last):
        ux, uy = 0.0, 0.0
        for m in range(modes):
            ux += state[m, 0] * along[m, 0]
            uy += state[m, 0] * along[m, 1]
        x = ux + feed * k
        hx, hy, ex, ey = 0.0, 0.0, 0.0, 0.0
        q = k % revolution
        for _ in range(teeth):
            if any_inside[q]:
                a, b, c, d = cut_station(x, uy, q, normal_x, normal_y, surface, least_chip)
                hx, hy, ex, ey = hx + a, hy + b, ex + c, ey + d
            q -= grid.tooth
            if q < 0:
                q += revolution
        fx = -(kt * hy + et * ey) - (kr * hx + er * ex)
        fy = (kt * hx + et * ex) - (kr * hy + er * ey)
        ahead_x, ahead_y = 1.5 * fx - 0.5 * old_fx, 1.5 * fy - 0.5 * old_fy  # at the middle of the coming step
        old_fx, old_fy = fx, fy
        for m in range(modes):
            f = ahead_x * along[m, 0] + ahead_y * along[m, 1]
            z, v = state[m, 0], state[m, 1]
            state[m, 0] = steps[m, 0, 0] * z + steps[m, 0, 1] * v + steps[m, 0, 2] * f
            state[m, 1] = steps[m, 1, 0] * z + steps[m, 1, 1] * v + steps[m, 1, 2] * f
        tip[k - first, 0], tip[k - first, 1] = ux, uy
        force[k - first, 0], force[k - first, 1] = fx, fy
    memory[0], memory[1] = old_fx, old_fy


def run_regenerative(
    cut: SteadyCut, modes: Modes, periods: int, *, steps: int = 0, progress: Callable[[float], None] | None = None
) -> Chatter:
    r"""Vibration of the tool tip in a steady cut, with the chip measured from the surface that was really left.

    The modes are stepped exactly under a force that is held over the step at its value extrapolated to the middle
    (second order in the step). The run starts from rest beside a rigid tool's surface. Growth is measured on the
    deviation from the periodic cut: the same loop without feed and edge force, linear (teeth do not lose contact),
    kicked at the start.

    Parameters
    ----------
    cut : SteadyCut
        The cut.
    modes : Modes
        Tool-tip modes.
    periods : int
        Tooth periods to run.
    steps : int
        Steps per tooth period; 0 takes 120 for each oscillation of the quickest mode, at least 120.
    progress : callable, optional
        Called with the share done.
    """
    period = 2.0 * math.pi / (cut.spindle * cut.teeth)
    steps = steps or max(120, math.ceil(120.0 * period * float(np.max(modes.frequency)) / (2.0 * math.pi)))
    tip, force = _simulate(cut, modes, periods, steps, progress=progress)
    time = np.arange(tip.shape[0]) * (period / steps)
    return Chatter(np.asarray(time, dtype=float), tip, force, growth_per_tooth(cut, modes, periods, steps))


def growth_per_tooth(cut: SteadyCut, modes: Modes, periods: int, steps: int) -> float:
    """Factor per tooth period by which a small deviation from the periodic cut grows, by time stepping [-].

    The slope of the logarithm of the deviation's r.m.s. over each period, the first third left out; ``LARGE`` where it
    grows out of all bounds within a few periods.
    """
    k = cut.coefficients
    smooth = cut._replace(feed_per_tooth=0.0, coefficients=k._replace(K_te=0.0, K_re=0.0))
    deviation, _ = _simulate(smooth, modes, periods, steps, kick=KICK, least_chip=-LARGE)
    with np.errstate(over="ignore", invalid="ignore"):
        size = np.sqrt(np.mean(np.sum(deviation.reshape(periods, steps, 2) ** 2, axis=2), axis=1))
    usable = np.nonzero((size > 1e-250) & (size < 1e-3 * LARGE))[0]
    part = usable[usable.size // 3 :]
    if part.size < _FEWEST:
        return LARGE
    return float(np.exp(np.polyfit(part, np.log(size[part]), 1)[0]))


def _simulate(
    cut: SteadyCut, modes: Modes, periods: int, steps: int, *, kick: float = 0.0, least_chip: float = 0.0,
    progress: Callable[[float], None] | None = None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    thickness = cut.depth / cut.discs
    lag = (np.arange(cut.discs) + 0.5) * thickness * cut.lag_per_depth
    grid = tooth_grid(cut.teeth, steps, np.asarray(lag, dtype=float), cut.entry, cut.exit)
    surface = fed_surface(grid, cut.feed_per_tooth)
    k = cut.coefficients
    forces = thickness * np.array([k.K_tc, k.K_rc, k.K_te, k.K_re])
    dt = 2.0 * math.pi / (cut.spindle * cut.teeth * steps)
    exact = np.array([transition(float(w), float(z), float(m), dt) for w, z, m, _ in zip(*modes, strict=True)])
    state, memory = np.zeros((modes.frequency.size, 2)), np.zeros(2)
    state[:, 1] = kick * modes.frequency
    n = periods * steps
    tip, force = np.empty((n, 2)), np.empty((n, 2))
    for first in range(0, n, CHUNK):
        last = min(first + CHUNK, n)
        _step_all(
            first, last, grid, surface, cut.feed_per_tooth / steps, np.append(forces, least_chip), exact,
            modes.direction, state, memory, tip[first:last], force[first:last],
        )  # fmt: skip
        if progress is not None:
            progress(last / n)
    return tip, force
