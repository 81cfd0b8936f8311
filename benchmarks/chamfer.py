"""Chamfer paths and their proof: CPU seconds of a fine path round a hole and of a part with 80 edges, beside peers.

The peers are what one writes by hand: a root finder called point by point, a cloud of points in a k-d tree, and
OpenCascade's own distance of a point from a solid. All run in one process.

Run: python benchmarks/chamfer.py
"""

import math
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import fsolve
from scipy.spatial import cKDTree

import cutwise
from cutwise.io import step
from cutwise.maths.edges import EdgeFrames
from cutwise.paths.chamfer import proof
from cutwise.paths.chamfer.ball_path import Chamfer, chamfer_path
from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge
from cutwise.process import chamfer
from cutwise.spec.chamfer import ChamferScenario

EXAMPLES = Path(__file__).parent.parent / "examples"
PIPE = PipeHole(0.015, 0.002, 0.004)
BALL = 0.002
WIDTH = 0.3e-3
CLOUD = 250_000


def best(work: Callable[[], Any], repeats: int = 5) -> float:
    """CPU seconds of the quickest of several repeats."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def path_of_hole() -> None:
    """2880 points of the exact path, per point beside a root finder on the two surfaces."""
    nodes = pipe_edge(PIPE, one_turn(512), inner=True)
    ours = best(lambda: chamfer_path(pipe_edge(PIPE, one_turn(2880), inner=True), Chamfer(WIDTH), BALL, nodes=nodes))
    some = pipe_edge(PIPE, one_turn(240), inner=True)
    peer = best(lambda: [_by_root_finder(some, i) for i in range(240)], 2)
    print(f"path of 2880 points, exact tier: {1e3 * ours:.1f} ms")
    print(
        f"  a root finder called for each point (less exact tier): {peer / 240 / (ours / 2880):.0f} times that per point"
    )


def _by_root_finder(frames: EdgeFrames, i: int) -> np.ndarray:
    """Borders of the chamfer on both cylinders in the normal plane: chord and symmetry."""
    edge, tangent, air = frames.point[i], frames.tangent[i], frames.air[i]
    bore = PIPE.radius - PIPE.wall

    def residual(u: np.ndarray) -> list[float]:
        first, second = u[:3], u[3:]
        chord = second - first
        return [
            (first - edge) @ tangent, (second - edge) @ tangent, math.hypot(first[0], first[2]) - bore,
            math.hypot(second[0], second[1]) - PIPE.hole_radius, math.sqrt(chord @ chord) - WIDTH, chord @ air,
        ]  # fmt: skip

    leg = 0.7 * WIDTH
    start = np.concatenate([edge + leg * frames.into[i, 0], edge + leg * frames.into[i, 1]])
    return fsolve(residual, start, xtol=1e-11)


def proof_of_hole() -> None:
    """How deep a ball that is too large cuts the far side of the hole."""
    changes = ("part.edges=outer", "chamfer.tier=surface", "tool.ball_radius=6 mm", "tool.rod_radius=2 mm",
               "tool.knife_limit_angle=30 deg", "requirements={}", "setup=null")  # fmt: skip
    scenario = cutwise.load(EXAMPLES / "chamfer_pipe_hole.yaml", changes)
    assert isinstance(scenario, ChamferScenario)
    done = chamfer.run(scenario)
    path = done.paths[0]

    def prove() -> Any:
        seen = float(path.found.beyond.max())
        return proof.gouge_of(path.work.shape, path.path, 6e-3, done.members, path.work.number, seen)

    found: list[float] = []

    def cloud() -> None:
        point = _cloud(CLOUD)
        far = cKDTree(path.path.frames.point).query(point)[0] > 1.02 * float(path.path.leg.max()) + 3e-6
        found.append(6e-3 - float(cKDTree(path.path.centre).query(point[far])[0].min()))

    ours, peer = best(prove), best(cloud, 2)
    exact = prove()
    print(f"deepest cut proved on the true surfaces: {1e3 * ours:.0f} ms, {1e3 * exact.value:.6f} mm, "
          f"at most {1e6 * (exact.bound - exact.value):.1f} um more")  # fmt: skip
    print(f"  a cloud of {CLOUD} points: {peer / ours:.0f} times that, {1e6 * (exact.value - found[0]):.1f} um missed")


def _cloud(count: int) -> np.ndarray:
    """Points spread evenly over outside, bore and hole near the hole."""
    side = int(math.sqrt(count / 3))
    y, psi = np.meshgrid(np.linspace(-8e-3, 8e-3, side), np.linspace(-0.6, 0.6, side))
    parts = []
    for radius in (PIPE.radius, PIPE.radius - PIPE.wall):
        point = np.column_stack([radius * np.sin(psi).ravel(), y.ravel(), radius * np.cos(psi).ravel()])
        parts.append(point[np.hypot(point[:, 0], point[:, 1]) >= PIPE.hole_radius])
    theta, z = np.meshgrid(one_turn(side), np.linspace(0.012, 0.0155, side))
    wall = np.column_stack([4e-3 * np.cos(theta).ravel(), 4e-3 * np.sin(theta).ravel(), z.ravel()])
    radius = np.hypot(wall[:, 0], wall[:, 2])
    return np.vstack([*parts, wall[(radius <= PIPE.radius) & (radius >= PIPE.radius - PIPE.wall)]])


def bladed_disc(blades: int = 8, holes: int = 6) -> Any:
    """A disc with a bore, lofted blades and oblique holes: 80 sharp convex edges and 34 concave ones."""
    cut, join = (step.occ("BRepAlgoAPI").BRepAlgoAPI_Cut, step.occ("BRepAlgoAPI").BRepAlgoAPI_Fuse)
    body = _cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 45.0, 12.0)
    for i in range(blades):
        body = join(body, _blade(2.0 * math.pi * i / blades)).Shape()
    body = cut(body, _cylinder((0.0, 0.0, -10.0), (0.0, 0.0, 1.0), 8.0, 100.0)).Shape()
    for i in range(holes):
        c, s = math.cos(2.0 * math.pi * (i + 0.5) / holes), math.sin(2.0 * math.pi * (i + 0.5) / holes)
        axis = (0.35 * c, 0.35 * s, math.sqrt(1.0 - 0.35**2))
        start = (12.5 * c - 20.0 * axis[0], 12.5 * s - 20.0 * axis[1], 6.0 - 20.0 * axis[2])
        body = cut(body, _cylinder(start, axis, 2.0, 40.0)).Shape()
    return body


def _cylinder(origin: Sequence[float], axis: Sequence[float], radius: float, height: float) -> Any:
    gp = step.occ("gp")
    frame = gp.gp_Ax2(gp.gp_Pnt(*origin), gp.gp_Dir(*axis))
    return step.occ("BRepPrimAPI").BRepPrimAPI_MakeCylinder(frame, radius, height).Shape()


def _blade(azimuth: float) -> Any:
    """A twisted, tapered blade through four sections; it stands a millimetre deep in the disc."""
    gp, api = step.occ("gp"), step.occ("BRepBuilderAPI")
    loft = step.occ("BRepOffsetAPI").BRepOffsetAPI_ThruSections(True, False, 1e-6)
    for share in (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0):
        half, thick = 10.0 * (1.0 - 0.2 * share), 1.5 * (1.0 - 0.3 * share)
        turn, height = azimuth + 0.5 * share + 0.6, 11.0 + 19.0 * share
        c, s = math.cos(turn), math.sin(turn)
        polygon = api.BRepBuilderAPI_MakePolygon()
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            x, y = (
                30.0 * math.cos(azimuth) + a * half * c - b * thick * s,
                30.0 * math.sin(azimuth) + a * half * s + b * thick * c,
            )
            polygon.Add(gp.gp_Pnt(x, y, height))
        polygon.Close()
        loft.AddWire(polygon.Wire())
    loft.Build()
    return loft.Shape()


def part_with_80_edges() -> None:
    """All edges of the bladed disc: planned, trimmed, joined, proved; the proof beside the kernel's own distances."""
    with tempfile.TemporaryDirectory() as folder:
        file = step.write_step(bladed_disc(), Path(folder) / "disc.step")
        scenario = cutwise.load(
            EXAMPLES / "chamfer_step_part.yaml", (f"part.step={file}", "part.edges=all", "requirements={}")
        )
        assert isinstance(scenario, ChamferScenario)
        part = step.read_step(file)
        load = best(lambda: step.read_step(file))
        chamfer.run(scenario)
        ours = best(lambda: chamfer.run(scenario), 3) - load
        done = chamfer.run(scenario)
    points = sum(len(path.path.centre) for path in done.paths)
    trimmed = sum(plan.trimmed for plan in done.plans)
    print(f"{len(done.plans)} edges of a bladed disc: {ours:.2f} CPU s after loading ({load:.2f}), {points} points, "
          f"{sum(bool(plan.paths) for plan in done.plans)} chamfered, {1e3 * trimmed:.0f} mm left out")  # fmt: skip
    gp, api = step.occ("gp"), step.occ("BRepBuilderAPI")
    some = np.vstack([path.path.centre for path in done.paths])[:: max(1, points // 40)] / step.MM

    def distances() -> None:
        for p in some:
            vertex = api.BRepBuilderAPI_MakeVertex(gp.gp_Pnt(*(float(x) for x in p))).Vertex()
            step.occ("BRepExtrema").BRepExtrema_DistShapeShape(vertex, part.shape).Value()

    peer = best(distances, 1) / len(some) * points
    print(
        f"  OpenCascade's distance of the ball centres from the part alone, no zones, no rod: {peer / ours:.1f} times that"
    )


def main() -> None:
    """Print all ratios."""
    path_of_hole()
    proof_of_hole()
    part_with_80_edges()


if __name__ == "__main__":
    main()
