"""Ten minutes of machining: two drives with friction and tooth-resolved forces, CPU seconds, and a lobe diagram.

Run: python benchmarks/milling_drives.py
"""

import math
import time

import numpy as np

from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.stability import Milling, Tip, arc_of, lobes
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import AVERAGED, DISCS, FLUTES
from cutwise.physics.engagement.wall import wall_patches
from cutwise.physics.motion.drives import Controller, Plant
from cutwise.physics.motion.reference import central_difference
from cutwise.physics.structure.modes import free_motion, modes
from cutwise.process.loops_drives import NO_FORCE, Commands, Cut, DrivePair, run_drives

FRICTION = (2.6256, -1.8672, 2.1529, -1.4730, 3.88, -3.51, 4.20, -3.52)
METAL = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
MINUTES = 10.0


def job(seconds: float) -> tuple[Commands, DrivePair]:
    """Round and round a circle of 60 mm at 40 mm/s, which makes both drives reverse."""
    t = np.arange(round(seconds / 1e-3)) * 1e-3
    phase = 40.0 / 30.0 * t
    point = 0.03 * np.column_stack((np.cos(phase) - 1.0, np.sin(phase)))
    velocity = central_difference(point, 1e-3)
    acceleration = central_difference(velocity, 1e-3)
    commands = Commands(point, velocity, acceleration, phase + 0.5 * math.pi, wall_patches(np.full(t.size, 0.927), 5e-3))
    x = Plant(6.4898, 0.4769, 0.0077736, 0.019811, 1.5915e-3, *FRICTION, 0.0)
    y = Plant(7.5768, 0.4769, 0.0098109, 0.28438, 1.5915e-3, *FRICTION, 0.0)
    law = Controller(70e3, 500e3, 300.0, 0.0, 0.0, 1e-3, 10.0, 0.0, 0.0)
    return commands, DrivePair(x, law, y, law)


def main() -> None:
    """Print the times."""
    warm, pair = job(0.1)
    commands, _ = job(60.0 * MINUTES)
    mill = Mill(0.01, 3, math.radians(30))
    sliced = discs(0.01, mill.helix, 5e-3, 3, 20)
    print(f"{MINUTES:g} minutes of machining, 2 axes, 1 ms, 10 substeps; CPU seconds")
    for name, law in (
        ("drives alone", NO_FORCE),
        ("averaged force", AVERAGED),
        ("closed form", FLUTES),
        ("20 discs", DISCS),
    ):
        cut = Cut(law, mill, sliced, even_edges(METAL), 837.758)
        run_drives(warm, pair, cut, 10)
        start = time.process_time()
        run_drives(commands, pair, cut, 10)
        print(f"  {name:15s} {time.process_time() - start:6.2f}")
    _lobe_diagram()


def _lobe_diagram() -> None:
    tip = modes([922 * 2 * math.pi] * 2, [0.011] * 2, [1.34005e6] * 2, [[1, 0], [0, 1]])
    case = Milling(2, *arc_of(0.5, "down"), 600e6, 200e6)
    speeds, depths = np.linspace(5000, 25000, 60) * math.pi / 30, np.linspace(0.05e-3, 2e-3, 40)
    start = time.process_time()
    lobes(speeds, depths, case, Tip(*tip), lambda t: free_motion(tip, t))
    print(f"lobe diagram of {speeds.size * depths.size} points, two modes: {time.process_time() - start:.2f} CPU s")


if __name__ == "__main__":
    main()
