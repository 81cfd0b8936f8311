"""Ten minutes of machining: two drives with friction and tooth-resolved forces; a lobe diagram.

Every figure is CPU seconds and its ratio to a peer of this run: linear drives stepped by SciPy and
semi-discretisation with NumPy's matrices. Run: OPENBLAS_NUM_THREADS=1 python benchmarks/milling_drives.py
"""

import math
import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm
from scipy.signal import dlsim, dlti

from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.stability import Milling, Tip, arc_of, lobes
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import AVERAGED, DISCS, FLUTES
from cutwise.physics.engagement.wall import wall_patches
from cutwise.physics.motion.driven import SetPoints
from cutwise.physics.motion.drives import Controller, Drive, Plant
from cutwise.physics.motion.loop import sampled_loop
from cutwise.physics.motion.reference import central_difference
from cutwise.physics.structure.modes import free_motion, modes
from cutwise.process.loops_drives import NO_FORCE, Cut, run_drives

FRICTION = (2.6256, -1.8672, 2.1529, -1.4730, 3.88, -3.51, 4.20, -3.52)
METAL = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
MINUTES = 10.0
FloatArray = npt.NDArray[np.float64]


def job(seconds: float) -> tuple[SetPoints, FloatArray, tuple[Drive, ...]]:
    """Round and round a circle of 60 mm at 40 mm/s, which makes both drives reverse."""
    t = np.arange(round(seconds / 1e-3)) * 1e-3
    phase = 40.0 / 30.0 * t
    point = 0.03 * np.column_stack((np.cos(phase) - 1.0, np.sin(phase)))
    velocity = central_difference(point, 1e-3)
    acceleration = central_difference(velocity, 1e-3)
    order = SetPoints(point, velocity, acceleration, phase + 0.5 * math.pi, np.zeros(t.size))
    patches = wall_patches(np.full(t.size, 0.927), 5e-3)
    x = Plant(6.4898, 0.4769, 0.0077736, 0.019811, 1.5915e-3, *FRICTION, 0.0)
    y = Plant(7.5768, 0.4769, 0.0098109, 0.28438, 1.5915e-3, *FRICTION, 0.0)
    law = Controller(70e3, 500e3, 300.0, 0.0, 0.0, 1e-3, 10.0, 0.0, 0.0)
    return order, patches, (Drive(x, law), Drive(y, law))


def main() -> None:
    """Print the times."""
    warm, warm_patches, pair = job(0.1)
    order, patches, _ = job(60.0 * MINUTES)
    mill = Mill(0.01, 3, math.radians(30))
    sliced = discs(0.01, mill.helix, 5e-3, 3, 20)
    peer = _linear_drives(order, pair)
    print(f"{MINUTES:g} minutes of machining, 2 axes, 1 ms, 10 substeps; CPU seconds (SciPy, linear, no force = 1)")
    print(f"  {'SciPy dlsim':15s} {peer:6.2f}")
    for name, law in (
        ("drives alone", NO_FORCE),
        ("averaged force", AVERAGED),
        ("closed form", FLUTES),
        ("20 discs", DISCS),
    ):
        cut = Cut(law, mill, sliced, even_edges(METAL), 837.758)
        run_drives(warm, warm_patches, pair, cut, 10)
        taken = _cpu(lambda cut=cut: run_drives(order, patches, pair, cut, 10))
        print(f"  {name:15s} {taken:6.2f} ({taken / peer:.3f})")
    _lobe_diagram()


def _cpu(job: Callable[[], object]) -> float:
    start = time.process_time()
    job()
    return time.process_time() - start


def _linear_drives(order: SetPoints, pair: tuple[Drive, ...]) -> float:
    """Both closed loops without friction or force, sample by sample."""
    loops = []
    for plant, law in pair:
        numerator, denominator = sampled_loop(plant, law)
        loops.append(dlti(numerator, np.polyadd(numerator, denominator), dt=law.sample_time))
    return _cpu(lambda: [dlsim(loop, order.point[:, i]) for i, loop in enumerate(loops)])


def _lobe_diagram() -> None:
    tip = modes([922 * 2 * math.pi] * 2, [0.011] * 2, [1.34005e6] * 2, [[1, 0], [0, 1]])
    case = Milling(2, *arc_of(0.5, "down"), 600e6, 200e6)
    speeds, depths = np.linspace(5000, 25000, 60) * math.pi / 30, np.linspace(0.05e-3, 2e-3, 40)
    diagram: list[FloatArray] = []
    taken = _cpu(lambda: diagram.append(lobes(speeds, depths, case, Tip(*tip), lambda t: free_motion(tip, t))))
    some = slice(None, None, 6)
    other: list[FloatArray] = []
    peer = _cpu(lambda: other.append(_semi_discretised(speeds[some], depths[some], case, Tip(*tip), 40)))
    points, some_points = speeds.size * depths.size, other[0].size
    apart = np.abs(diagram[0][some, some] / other[0] - 1.0).max()
    print(f"lobe diagram of {points} points, two modes: {taken:.2f} CPU s; a point of semi-discretisation in 40 steps")
    print(
        f"  costs {peer / some_points * points / taken:.0f} times one of these; the multipliers differ by {100.0 * apart:.1g} %"
    )


def _semi_discretised(speeds: FloatArray, depths: FloatArray, case: Milling, tip: Tip, steps: int) -> FloatArray:
    """Largest multiplier by Insperger and Stepan's method, first order in the delayed term, shape (speeds, depths)."""
    out = np.empty((speeds.size, depths.size))
    m = tip.frequency.size
    spring, damper = np.diag(tip.frequency**2), np.diag(2.0 * tip.damping * tip.frequency)
    pull = tip.direction / tip.mass[:, None]
    for i, speed in enumerate(speeds):
        step = 2.0 * math.pi / case.teeth / speed / steps
        for j, depth in enumerate(depths):
            whole = np.eye(2 * m + m * steps)
            for k in range(steps):
                angle = (k + 0.5) * step * speed
                force = _force_matrix(angle, case) * depth
                cut = pull @ force @ tip.direction.T
                a = np.block([[np.zeros((m, m)), np.eye(m)], [-spring - cut, -damper]])
                propagator = expm(a * step)
                response = np.linalg.solve(a, propagator - np.eye(2 * m))[:, m:] @ cut
                forward = np.zeros_like(whole)
                forward[: 2 * m, : 2 * m] = propagator
                forward[: 2 * m, -m:] += 0.5 * response
                forward[: 2 * m, -2 * m : -m] += 0.5 * response
                forward[2 * m : 3 * m, :m] = np.eye(m)
                forward[3 * m :, 2 * m : -m] = np.eye(m * (steps - 1))
                whole = forward @ whole
            out[i, j] = np.abs(np.linalg.eigvals(whole)).max()
    return out


def _force_matrix(angle: float, case: Milling) -> FloatArray:
    """Force per chip displacement and depth of the teeth in cut, one of which stands at ``angle`` [N/m^2]."""
    out = np.zeros((2, 2))
    for tooth in range(case.teeth):
        phi = (angle + 2.0 * math.pi * tooth / case.teeth) % (2.0 * math.pi)
        if case.entry < phi < case.exit:
            n, t = np.array([math.sin(phi), math.cos(phi)]), np.array([math.cos(phi), -math.sin(phi)])
            out += case.tangential * np.outer(t, n) + case.radial * np.outer(n, n)
    return out


if __name__ == "__main__":
    main()
