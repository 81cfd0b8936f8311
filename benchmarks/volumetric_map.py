"""What a map of a 21-parameter machine costs for a million scattered points, beside plain NumPy in the same run.

Run from the repository: ``python benchmarks/volumetric_map.py``. All times are CPU seconds of this process, best of
several repeats, after compilation. The peer is the same formula written for the three linear axes in NumPy, on the same
tables (``numpy.interp``), and with every sine evaluated; all three are compared in the error that they give.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "src"))

import numpy as np

from cutwise.io.scenario import load
from cutwise.physics.motion import volumetric
from cutwise.physics.motion.geometry import motion_twist
from cutwise.process.machine_assemble import machine_axes

SCENARIO = Path(__file__).resolve().parent.parent / "examples" / "machine_volumetric_map.yaml"


def timed(run: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """Least CPU time of some repeats [s], and what the last gave."""
    least, found = np.inf, None
    for _ in range(repeats):
        start = time.process_time()
        found = run()
        least = min(least, time.process_time() - start)
    return float(least), found


def numpy_map(commands: np.ndarray, tip: np.ndarray, twists: list[Callable[[np.ndarray], np.ndarray]]) -> np.ndarray:
    """Error of w X Y b Z t, the tables inverted, in plain NumPy: from the tool inward."""
    reach = np.broadcast_to(tip, commands.shape).copy()
    error = np.zeros_like(reach)
    for axis, sign in ((2, 1.0), (1, -1.0), (0, -1.0)):
        twist = twists[axis](commands[:, axis])
        if sign > 0:
            error += twist[:, :3] + np.cross(twist[:, 3:], reach)
        reach[:, axis] += sign * commands[:, axis]
        if sign < 0:
            error -= twist[:, :3] + np.cross(twist[:, 3:], reach)
    return error


def interpolated(axes: volumetric.Axes, joint: int, count: int) -> Callable[[np.ndarray], np.ndarray]:
    """Errors of an axis by ``numpy.interp`` on as many points as the compiled tables have."""
    at = np.linspace(axes.low[joint], axes.high[joint], count)
    values = motion_twist(axes.errors[joint], at)
    return lambda u: np.stack([np.interp(u, at, values[:, k]) for k in range(6)], axis=-1)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    scenario = load(SCENARIO)
    axes, tip = machine_axes(scenario), np.array(scenario.tool.tip)
    commands = np.random.default_rng(1).uniform(axes.low, axes.high, (given.points, 3))
    tables = volumetric.tabulate(axes)
    count = tables.inner.shape[1]
    volumetric.volumetric_error(axes, tables, commands[:10], tip)  # compiles
    own, found = timed(lambda: volumetric.volumetric_error(axes, tables, commands, tip), given.repeats)
    by_table = [interpolated(axes, joint, count) for joint in range(3)]
    plain, expected = timed(lambda: numpy_map(commands, tip, by_table), given.repeats)
    by_sines = [lambda u, joint=joint: motion_twist(axes.errors[joint], u) for joint in range(3)]
    direct, exact = timed(lambda: numpy_map(commands, tip, by_sines), 1)
    print(f"{given.points} scattered points, 21 parameters, tables of {count} points per axis")
    print(f"{'way':<34}{'CPU s':>10}{'ratio':>8}{'largest miss':>16}")
    for name, cost, error in (
        ("cutwise, tables", own, found),
        ("plain NumPy, same tables", plain, expected),
        ("plain NumPy, sines at every point", direct, exact),
    ):
        miss = np.linalg.norm(error - exact, axis=1).max() * 1e6
        print(f"{name:<34}{cost:>10.4f}{cost / own:>8.1f}{miss:>13.2e} µm")


if __name__ == "__main__":
    main()
