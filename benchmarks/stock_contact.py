"""Contact with the stock along dense programs: what preparing the moves and finding the places costs, and how it grows.

python benchmarks/stock_contact.py
"""

import math
import time

import numpy as np

from cutwise.maths.linearc import LineArc, sample
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import Stock, contact_patches

ENDLESS = Stock(np.zeros((0, 3)), 1e-3, -1.0)


def polyline(points):
    """Lines through points [m], shape (n, 3)."""
    step = np.diff(points, axis=0)
    length = np.linalg.norm(step, axis=1)
    none, flat = np.zeros((len(length), 3)), np.ones(len(length))
    return LineArc(
        points[:-1], step / length[:, None], none, none, flat, np.full_like(flat, np.inf), length, 0.0 * flat
    )


def trochoid(moves):
    """Loops of 4 mm that go on by 0.2 mm a turn."""
    turn = np.linspace(0.0, moves / 64 * 2.0 * math.pi, moves + 1)
    return np.column_stack([2e-4 * turn / (2.0 * math.pi) + 4e-3 * np.cos(turn), 4e-3 * np.sin(turn), 0.0 * turn])


def wavy(moves):
    """A wavy surface in rows there and back."""
    n = math.isqrt(moves)
    x, y = np.meshgrid(np.linspace(0.0, 0.03, n), np.linspace(0.0, 0.03, n))
    x[1::2] = x[1::2, ::-1].copy()
    return np.column_stack([c.ravel() for c in (x, y, -3e-3 + 2e-3 * np.sin(300 * x) * np.cos(250 * y))])


def cost(points, places=2000):
    """CPU seconds to prepare the moves, and places found in a CPU second."""
    curve = polyline(points)
    s = np.linspace(0.0, curve.knots[-1], places)
    start = time.process_time()
    swept = swept_path(curve, 3e-3)
    ready = time.process_time() - start
    point, tangent, _ = sample(curve, curve.knots, s)
    start = time.process_time()
    contact_patches(point, np.arctan2(tangent[:, 1], tangent[:, 0]), s, swept, ENDLESS)
    return ready, places / (time.process_time() - start)


def main():
    """One line for each program and size; ratios to the smallest."""
    for shape in (trochoid, wavy):
        cost(shape(500))  # compiled
        found = [(moves, *cost(shape(moves))) for moves in (5_000, 20_000, 80_000)]
        for moves, ready, rate in found:
            print(
                f"{shape.__name__:9s} {moves:7d} moves: ready {ready:7.3f} CPU s, {rate:9.0f} places a CPU s "
                f"({found[0][2] / rate:.2f} times the cost of a place at {found[0][0]})"
            )


if __name__ == "__main__":
    main()
