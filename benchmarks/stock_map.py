"""A stock in 3D: sweeping, contact and deviation on a wavy surface that a ball finishes, beside plain NumPy.

    python benchmarks/stock_map.py [program.nc diameter_in_mm]

With a program (G-code in mm, one flat mill) its moves are swept too. Peers that are not installed are left out and named.
"""

import importlib.util
import itertools
import math
import sys
import time
from pathlib import Path

import numpy as np

from cutwise.maths import profiles
from cutwise.maths.envelopes import COLUMNS, Segments
from cutwise.maths.height_map import RINGS, cell_middles, height_map, layout, volume_of
from cutwise.maths.map_sweep import swept_band
from cutwise.maths.profiles import cylinder_foot, meridian
from cutwise.maths.solid import RECTANGLE, Outline, Solid
from cutwise.maths.workpiece import alone
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.engagement.map_contact import Edge
from cutwise.physics.surface.map_deviation import deviations, shaped_by
from cutwise.process.stock_loop import STATION, Run, Teeth, run_moves

MM = 1e-3
NO_SHANK = profiles.Cutters(np.zeros((0, 5)), np.zeros(2, np.int64), np.zeros(1))


def wavy_rows():
    """Tips of a ball of 3 mm on z = 5 sin(2 pi x / 60) cos(2 pi y / 70), rows there and back [m]."""
    x, y = np.meshgrid(np.arange(0.0, 100.01, 0.5), np.arange(0.0, 100.01, 0.3))
    a, b = 2 * math.pi / 60, 2 * math.pi / 70
    z = 5 * np.sin(a * x) * np.cos(b * y)
    slope = np.stack([-5 * a * np.cos(a * x) * np.cos(b * y), 5 * b * np.sin(a * x) * np.sin(b * y), np.ones_like(x)])
    normal = slope / np.linalg.norm(slope, axis=0)
    points = np.stack([x, y, z]) + 3 * normal
    points[2] -= 3
    rows = np.moveaxis(points, 0, -1).copy()
    rows[1::2] = rows[1::2, ::-1]
    surface = np.stack([x, y, z]).reshape(3, -1).T
    return MM * rows.reshape(-1, 3), MM * surface, normal.reshape(3, -1).T


def path_of(points):
    """Lines through points [m]."""
    start, end = points[:-1], points[1:]
    step = end - start
    flat = np.hypot(step[:, 0], step[:, 1])
    rows = np.zeros((len(start), COLUMNS))
    rows[:, 2:5], rows[:, 5] = start, 1.0
    lies = flat > 1e-12
    rows[lies, 5:7] = step[lies, :2] / flat[lies, None]
    rows[lies, 7], rows[lies, 8] = flat[lies], step[lies, 2] / flat[lies]
    rows[~lies, 4] = np.minimum(start[~lies, 2], end[~lies, 2])
    return Segments(rows, np.arange(len(start) + 1))


def wave(x, y):
    """Height of the wavy surface [m]."""
    return 5 * MM * np.sin(2 * math.pi * x / (60 * MM)) * np.cos(2 * math.pi * y / (70 * MM))


def block(points, bottom, top, grid):
    """A block over the plan of a path; without a top it stands 0.5 mm over the wavy surface."""
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    cells = layout((low[0], high[0]), (low[1], high[1]), grid)
    if top is None:
        x, y = (c[RINGS : RINGS + n] for c, n in zip(cell_middles(cells), (cells.across, cells.along), strict=True))
        return height_map(cells, np.ones((cells.along, cells.across)), bottom, wave(*np.meshgrid(x, y)) + 0.5 * MM)
    return height_map(cells, np.ones((cells.along, cells.across)), bottom, top)


def swept(points, pieces, bottom, top, grid):
    """CPU seconds of a sweep, the solid, and the volume [m^3]."""
    path, tools, stock = path_of(points), profiles.cutters([pieces]), block(points, bottom, top, grid)
    taken = np.zeros(path.first.size - 1, np.int64)
    start = time.process_time()
    swept_band(stock, path, tools, (0, stock.layout.rows), taken)
    spent = time.process_time() - start
    return spent, Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools), float(volume_of(stock, taken).sum())


def stamped(points, radius, grid, moves):
    """CPU seconds a move of plain NumPy: the ball put down at the middle of each move, over the cells below it."""
    reach = int(radius / grid) + 1
    offset = grid * np.arange(-reach, reach + 1)
    x, y = np.meshgrid(offset, offset)
    ball = radius - np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0.0))
    ball[x**2 + y**2 > radius**2] = np.inf
    size = int(0.1 / grid) + 2 * reach + 4
    height = np.full((size, size), 1.0, np.float32)
    start = time.process_time()
    for a, b in itertools.pairwise(points[: moves + 1]):
        i, j = (int((0.5 * (a[k] + b[k]) + 2e-3) / grid) + reach for k in (1, 0))
        i, j = min(max(i, reach), size - reach - 1), min(max(j, reach), size - reach - 1)
        part = height[i - reach : i + reach + 1, j - reach : j + reach + 1]
        np.minimum(part, ball + 0.5 * (a[2] + b[2]), out=part)
    return (time.process_time() - start) / moves


def engaged(points, pieces, grid, elements, refine, forces=False, places=2):
    """CPU seconds of contact at one or both ends of every move, with the sweep."""
    path, tools, stock = path_of(points), profiles.cutters([pieces]), block(points, -20 * MM, None, grid)
    count = path.first.size - 1
    radius = max(piece[2] for piece in pieces)
    edge = Edge(meridian(pieces, 0.0, elements), radius, cylinder_foot(pieces), math.inf)
    coefficients = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
    teeth = Teeth(edge, Mill(radius, 2, math.radians(30)), -1.0, even_edges(coefficients), forces)
    stations = np.arange(0, places * count + 1, places)
    run = Run(
        points[:-1], points[1:], np.linalg.norm(np.diff(points, axis=0), axis=1), np.zeros(count, bool), np.full(count, 0.05),
        np.full(count, 1000.0), np.full(places * count, 0.05), stations, np.zeros((places * count, len(STATION))),
        np.zeros(places * count, np.int64), np.zeros(count, np.int64), np.zeros((count, 5)), np.zeros((count, 5)),
    )  # fmt: skip
    solid = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    start = time.process_time()
    run_moves(alone(solid), NO_SHANK, teeth, run, (0, count), True, refine)
    return time.process_time() - start


def meshed(points, radius, moves):
    """CPU seconds a move of meshes: the hull of the ball at both ends of a move, taken off a block (manifold3d)."""
    from manifold3d import Manifold

    ball = Manifold.sphere(1e3 * radius, 24)
    low, high = 1e3 * points[: moves + 1].min(axis=0) - 10, 1e3 * points[: moves + 1].max(axis=0) + 10
    block_ = Manifold.cube((high - low).tolist()).translate(low.tolist())
    start = time.process_time()
    for a, b in itertools.pairwise(1e3 * points[: moves + 1] + [0.0, 0.0, 1e3 * radius]):
        block_ -= Manifold.batch_hull([ball.translate(a.tolist()), ball.translate(b.tolist())])
    block_.volume()  # booleans are put off until they are asked for
    return (time.process_time() - start) / moves


def dropped(surface, radius):
    """CPU seconds a point of a drop cutter: the ball put down on the surface, in triangles (opencamlib)."""
    import opencamlib as ocl

    count = len(np.unique(surface[:, 1].round(9)))
    grid = 1e3 * surface.reshape(count, -1, 3)[::4, ::4]
    solid = ocl.STLSurf()
    for j, i in itertools.product(range(grid.shape[0] - 1), range(grid.shape[1] - 1)):
        a, b, c, d = (ocl.Point(*map(float, grid[j + q, i + p])) for q, p in ((0, 0), (0, 1), (1, 1), (1, 0)))
        solid.addTriangle(ocl.Triangle(a, b, c))
        solid.addTriangle(ocl.Triangle(a, c, d))
    job = ocl.BatchDropCutter()
    job.setSTL(solid)
    ball = ocl.BallCutter(2e3 * radius, 50.0)  # the job keeps no reference of its own
    job.setCutter(ball)
    job.setThreads(1)
    some = 1e3 * surface[::5]
    for x, y, _ in some:
        job.appendPoint(ocl.CLPoint(float(x), float(y), -100.0))
    start = time.process_time()
    job.run()
    return (time.process_time() - start) / len(some)


PEERS = {name: importlib.util.find_spec(name) is not None for name in ("manifold3d", "opencamlib")}


def wavy():
    """A ball on a wavy surface."""
    points, surface, normal = wavy_rows()
    pieces, count = profiles.ball(3 * MM), len(points) - 1
    swept(points[:50], pieces, -20 * MM, None, 0.5 * MM)  # compiled
    for grid in (0.1, 0.05):
        spent, plain, mesh = math.inf, math.inf, math.inf
        for _ in range(2):  # in turns, so that a busy machine slows all of them
            spent = min(spent, swept(points, pieces, -20 * MM, None, grid * MM)[0])
            plain = min(plain, stamped(points, 3 * MM, grid * MM, 2000))
            if PEERS["manifold3d"]:
                mesh = min(mesh, meshed(points[30_000:], 3 * MM, 200))
        told = f"; meshes (manifold3d, 24 segments) {mesh * count / spent:7.0f} times" if PEERS["manifold3d"] else ""
        print(
            f"sweep {grid:4.2f} mm: {count / spent:9.0f} moves a CPU s; NumPy, one pose a move {plain * count / spent:6.1f} times"
            + told
        )
    some = points[:8001]
    for words, elements, refine, forces in (
        ("coarse, 10 elements", 10, False, False), ("refined, 10 elements", 10, True, False),
        ("refined, 40 elements", 40, True, False), ("refined, 10 elements, forces and peaks", 10, True, True),
    ):  # fmt: skip
        engaged(points[:60], pieces, 0.1 * MM, elements, refine, forces)
        spent = [math.inf, math.inf, math.inf]
        for _ in range(2):
            spent = [
                min(spent[0], stamped(points, 3 * MM, 0.1 * MM, 2000)),
                *(min(spent[k], engaged(some, pieces, 0.1 * MM, elements, refine, forces, k) / 8000) for k in (1, 2)),
            ]
        print(
            f"contact, {words}: {1 / spent[2]:9.0f} moves a CPU s with both ends of each looked at, {1 / spent[1]:9.0f} with one; "
            f"NumPy, one pose a move without contact {spent[0] / spent[2]:4.2f} and {spent[0] / spent[1]:4.2f} times"
        )
    _, solid, _ = swept(points, pieces, -20 * MM, None, 0.1 * MM)
    left = shaped_by(alone(solid))
    value, segment = np.empty(len(surface)), np.empty(len(surface), np.int64)
    surface, normal = np.ascontiguousarray(surface), np.ascontiguousarray(normal)
    deviations(left, surface[:9], normal[:9], 1e-5, value, segment)  # compiled
    start = time.process_time()
    deviations(left, surface, normal, 1e-5, value, segment)
    spent = (time.process_time() - start) / len(surface)
    told = f"; drop cutter (opencamlib) {dropped(surface, 3 * MM) / spent:5.1f} times" if PEERS["opencamlib"] else ""
    print(f"deviation: {1 / spent:9.0f} points a CPU s{told}")


def of_program(file, diameter):
    """The moves of a program."""
    from cutwise.programs.interpreter import interpret

    moves = interpret(Path(file).read_text(), file).moves
    points = np.concatenate([moves.starts[:1], moves.ends])
    for grid in (0.5, 0.1, 0.05):
        pieces = profiles.flat(0.5 * MM * diameter)
        found = [swept(points, pieces, -32 * MM, 0.0, grid * MM) for _ in range(2)]
        print(
            f"{Path(file).name} {grid} mm: {len(moves)} moves, {min(f[0] for f in found):.3f} CPU s, {1e9 * found[0][2]:.0f} mm^3"
        )


def main():
    """Everything once."""
    for peer, there in PEERS.items():
        if not there:
            print(f"{peer} is not installed: left out (pip install cutwise[benchmark])")
    wavy()
    if len(sys.argv) == 3:
        of_program(sys.argv[1], float(sys.argv[2]))


if __name__ == "__main__":
    main()
