"""Tools of a scenario by their profiles: what sweeps, what cuts, and what stands above the edges."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths import profiles
from cutwise.maths.profiles import Cutters, Piece, cylinder_foot, meridian
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.uneven import NO_LINEAR, Edges, even_edges, largest_radius
from cutwise.physics.engagement.map_contact import Edge
from cutwise.process.stock_loop import Teeth
from cutwise.spec.cutter import Cutter
from cutwise.spec.tool import EndMill


class ToolSet(NamedTuple):
    """Tools in their order."""

    numbers: tuple[int, ...]  # by which the program calls them; empty: one tool for every call
    shapes: tuple[str, ...]
    cutting: Cutters
    shanks: Cutters  # shank and holder; a tool without has no pieces
    edges: tuple[Edge, ...]
    mills: tuple[Mill, ...]
    cores: tuple[float | None, ...]  # end_core [m]; None: the bottom does not cut, or there is none
    runouts: tuple[tuple[float, float], ...]  # offset of the axis [m] and its direction [rad]

    def teeth(self, row: int, law: Edges | None) -> Teeth:
        """One tool in a material, whose law of force is that of teeth that are alike."""
        core, (runout, angle) = self.cores[row], self.runouts[row]
        alike = law or even_edges(NO_LINEAR)
        return Teeth(
            self.edges[row], self.mills[row], -1.0 if core is None else core,
            alike._replace(runout=runout, runout_angle=angle), law is not None,
        )  # fmt: skip


def cutting_pieces(tool: Cutter | EndMill) -> list[Piece]:
    """The profile of a tool's cutting end."""
    radius = 0.5 * tool.diameter
    if isinstance(tool, EndMill):
        return profiles.flat(radius)
    tip = 0.5 * (tool.tip_diameter or 0.0)
    if tool.shape == "ball":
        return profiles.ball(radius)
    if tool.shape == "bull_nose":
        return profiles.bull_nose(radius, min(tool.corner_radius or 0.0, radius))
    if tool.shape == "taper":
        assert tool.half_angle is not None
        return profiles.taper(radius, tip, tool.half_angle)
    if tool.shape == "ball_taper":
        assert tool.half_angle is not None
        assert tool.ball_radius is not None
        return profiles.ball_taper(radius, tool.ball_radius, tool.half_angle)
    if tool.shape in ("drill", "chamfer"):
        assert tool.point_angle is not None
        return profiles.taper(radius, tip, 0.5 * tool.point_angle)
    return profiles.flat(radius)


def shank_pieces(tool: Cutter | EndMill) -> list[Piece]:
    """Shank and holder; none where it is not known where they begin."""
    if isinstance(tool, EndMill):
        return []
    outline: list[tuple[float, float]] = []
    if tool.shank_diameter is not None and tool.flute_length is not None:
        outline.append((tool.flute_length, 0.5 * tool.shank_diameter))
    found = profiles.revolved(outline) if outline else []
    holder = [(height, 0.5 * diameter) for height, diameter in tool.holder]
    return found + (profiles.revolved(holder) if holder else [])


def tool_set(tools: Sequence[Cutter | EndMill], elements: int, *, real: bool = False) -> ToolSet:
    """The tools of a scenario; ``real``: as wide as the tooth that run-out carries out most."""
    nominal = [cutting_pieces(tool) for tool in tools]
    out = [
        largest_radius(tool.runout, tool.runout_angle, tool.flutes) if real and tool.runout else 0.0 for tool in tools
    ]
    cutting = [
        [(kind, inner + more, outer + more, foot, shape) for kind, inner, outer, foot, shape in pieces]
        for pieces, more in zip(nominal, out, strict=True)
    ]
    edges, cores = [], []
    for tool, pieces, bare, more in zip(tools, cutting, nominal, out, strict=True):
        core = tool.end_core
        flat = bare[0][1]
        cores.append(core if flat > 0.0 else None)
        end = math.inf if tool.flute_length is None else tool.flute_length
        edges.append(
            Edge(
                meridian(pieces, pieces[0][1] if core is None else core, elements),
                0.5 * tool.diameter + more,
                cylinder_foot(pieces),
                end,
            )
        )
    return ToolSet(
        tuple(tool.number for tool in tools if isinstance(tool, Cutter)),
        tuple("flat" if isinstance(tool, EndMill) else tool.shape for tool in tools),
        profiles.cutters(cutting), _shanks([shank_pieces(tool) for tool in tools]), tuple(edges),
        tuple(Mill(0.5 * tool.diameter, tool.flutes, tool.helix) for tool in tools), tuple(cores),
        tuple((tool.runout, tool.runout_angle) for tool in tools),
    )  # fmt: skip


def _shanks(tools: Sequence[Sequence[Piece]]) -> Cutters:
    rows = np.array([row for pieces in tools for row in pieces], float).reshape(-1, profiles.COLUMNS)
    first = np.concatenate(([0], np.cumsum([len(pieces) for pieces in tools]))).astype(np.int64)
    return Cutters(rows, first, np.array([max((row[2] for row in pieces), default=0.0) for pieces in tools], float))
