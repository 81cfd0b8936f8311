"""What ``cutwise part`` says about a CAD part."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.cad import CONCAVE, CONVEX, CROWDED, DEGENERATE, FREE, SEAM, SMOOTH, Topology, topology
from cutwise.io.cad_edges import EdgeChain, sharp_chains
from cutwise.io.cad_select import counted
from cutwise.io.step import read_step

_KINDS = (CONVEX, CONCAVE, SMOOTH, SEAM, DEGENERATE, FREE, CROWDED)


class Listing(NamedTuple):
    """A part with its sharp edges."""

    model: Topology
    chains: tuple[EdgeChain, ...]

    def as_json(self) -> dict[str, Any]:
        """The listing in SI."""
        part = self.model.part
        return {
            "file": part.name, "unit": part.unit, "solids": part.solids, "open_shells": part.open_shells,
            "faces": part.faces,
            "edges": {"total": self.model.whole_edges} | {kind: self.model.count(kind) for kind in _KINDS},
            "holes": [
                {"number": n, "radius": hole.radius, "depth": hole.depth, "middle": list(hole.middle),
                 "origin": list(hole.origin), "axis": list(hole.axis)}
                for n, hole in enumerate(self.model.holes, start=1)
            ],
            "sharp_edges": [
                {"number": chain.number, "length": chain.length, "closed": chain.closed, "holes": list(chain.holes),
                 "where": chain.where, "middle": chain.middle.tolist(),
                 "faces": [self.model.faces[int(f)].name for f in np.unique(chain.frames.face)],
                 "wedge_angle_min": float(chain.frames.wedge.min()),
                 "wedge_angle_max": float(chain.frames.wedge.max())}
                for chain in self.chains
            ],
            "remarks": list(self.model.notices),
        }  # fmt: skip


def listing(file: Path, done: Callable[[float], object] | None = None) -> Listing:
    """Read a STEP file and find its sharp edges; ``done`` is told the share of the edges.

    Raises
    ------
    CadFault
        The file cannot be used; the message says why.
    """
    model = topology(read_step(file))
    return Listing(model, sharp_chains(model, spacing=2e-4, done=done))


def shown(found: Listing) -> str:
    """The listing as text."""
    part, model = found.model.part, found.model
    lines = [
        f"{part.name}: {part.solids} solid(s), {counted(part.faces, 'face')}, {counted(model.whole_edges, 'edge')}"
        + (f", written in {part.unit}" if part.unit else ""),
        "edges: " + ", ".join(f"{model.count(kind)} {kind}" for kind in _KINDS if model.count(kind)),
        *model.notices,
        "",
        counted(len(model.holes), "hole") + ("; the middle of their axes in mm" if model.holes else ""),
    ]
    for number, hole in enumerate(model.holes, start=1):
        axis = ", ".join(f"{x + 0.0:.3g}" for x in hole.axis)
        lines.append(
            f"  hole:{number:<4} diameter {units.show(2.0 * hole.radius, 'length')}, depth {units.show(hole.depth, 'length')}, "
            f"at {_place(np.array(hole.middle))}, axis ({axis})"
        )
    closed = sum(chain.closed for chain in found.chains)
    lines += [
        "",
        f"{counted(len(found.chains), 'sharp convex edge')} ({closed} closed)"
        + ("; their middles in mm" if found.chains else ""),
    ]
    for chain in found.chains:
        low, high = np.degrees([chain.frames.wedge.min(), chain.frames.wedge.max()])
        angle = f"{low:.4g}°" if high - low < 0.05 else f"{low:.4g} to {high:.4g}°"
        place = ("closed" if chain.closed else "open") + (f", {chain.where}" if chain.where else "")
        place += "".join(f", hole:{n}" for n in chain.holes)
        length = units.show(chain.length, "length", 4)
        lines.append(f"  edge:{chain.number:<4} {length:>12}  {angle:<16} {_place(chain.middle):<24} {place}")
    return "\n".join(lines)


def _place(point: np.ndarray) -> str:
    return "(" + ", ".join(f"{round(x, 3) + 0.0:.6g}" for x in point * 1e3) + ")"


def draw(found: Listing) -> str:
    """All sharp edges in an isometric view, numbered, as SVG."""
    x, y = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0), np.array([-1.0, -1.0, 2.0]) / np.sqrt(6.0)
    flat = [np.column_stack([c.frames.point @ x, -c.frames.point @ y]) * 1e3 for c in found.chains]
    if not flat:
        return '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"/>\n'
    points = np.vstack(flat)
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    scale = 800.0 / float(size.max() or 1.0)
    width, height = size * scale + 40.0
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif">']
    for chain, line in zip(found.chains, flat, strict=True):
        at = (line - low) * scale + 20.0
        path = "M" + "L".join(f"{a:.1f},{b:.1f}" for a, b in at) + ("Z" if chain.closed else "")
        colour = {"inner": "#c4570c", "outer": "#1f66b0"}.get(chain.where, "#5b6876")
        a, b = at[len(at) // 2]
        out.append(f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        out.append(f'<text x="{a + 3:.1f}" y="{b - 3:.1f}" font-size="11" fill="#1d2733">{chain.number}</text>')
    return "\n".join([*out, "</svg>", ""])
