"""The edge of a STEP part that is deburred: a line or an arc across the tool axis, run on the side that the milling asks."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.occ import CadFault
from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.paths.carried import across
from cutwise.spec.carrier import Arc, Line
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.faults import Fault, ScenarioFault

if TYPE_CHECKING:
    from cutwise.io import cad, cad_edges, cad_select, step
else:
    cad, cad_edges, cad_select, step = (
        later(f"cutwise.io.{name}") for name in ("cad", "cad_edges", "cad_select", "step")
    )

_TRUE = 1e-5  # [m] by which an edge may be off a line or an arc: gaps of CAD parts reach that
_UPRIGHT = math.sin(math.radians(1.0))  # a face that leans more does not lie against the flank of the mill


class FoundEdge(NamedTuple):
    """An edge of a part as a pass runs along it."""

    name: str
    point: FloatArray  # [m] in the order of the feed, shape (n, 3)
    off: FloatArray  # outward normal of the face along the tool axis, there, shape (n, 3)
    closed: bool


def on_part(scenario: DeburringScenario) -> DeburringScenario:
    """The scenario with the chosen edge of its STEP part as its path; itself without one.

    Raises
    ------
    ScenarioFault
        The file cannot be used, not one edge is chosen, or the mill cannot follow it; the message says why.
    """
    part, path = scenario.part, scenario.path
    if part.step is None or path is None or path.line is not None or path.arc is not None:
        return scenario
    up = -np.array(path.tool_axis) / np.linalg.norm(path.tool_axis)
    edge = _found(scenario, up)
    right, ahead = across(up)
    flat = np.column_stack([edge.point @ right, edge.point @ ahead])
    height = edge.point @ up
    if float(np.ptp(height)) > _TRUE:
        raise _refused(f"{edge.name} rises by {_mm(float(np.ptp(height)))} along path.tool_axis; the mill follows edges at a "
                       "right angle to its axis")  # fmt: skip
    line, length = _line(edge, flat)
    arc = None
    if line is None:
        arc, length = _arc(edge, flat, right, ahead, float(height.mean()) * up)
    operation = scenario.operation
    if operation.length is None and operation.duration is None:
        operation = operation.model_copy(update={"length": length})
        operation.model_fields_set.discard("length")
    found = scenario.model_copy(
        update={"path": path.model_copy(update={"line": line, "arc": arc}), "operation": operation}
    )
    told = part.model_copy(update={"step": None, "edges": None})
    faults = list(found.model_copy(update={"part": told}).contradictions())
    if line is not None and scenario.robot is None:
        faults = [fault for fault in faults if fault.path != ("path",)]  # a line needs nothing that follows it
    faults += list(operation.contradictions())
    if faults:
        raise ScenarioFault([Fault(fault.path, fault.message) for fault in faults])
    return found


def _found(scenario: DeburringScenario, up: FloatArray) -> FoundEdge:
    """The one edge that is chosen, in the order in which the mill passes it."""
    part = scenario.part
    assert part.step is not None
    try:
        chains = cad_edges.sharp_chains(cad.topology(step.read_step(part.step)))
    except CadFault as fault:
        raise ScenarioFault([Fault(("part", "step"), str(fault))]) from None
    try:
        chosen = cad_select.select(chains, part.edges or "all")
    except CadFault as fault:
        raise ScenarioFault([Fault(("part", "edges"), str(fault))]) from None
    if len(chosen) > 1:
        several = ", ".join(f"edge:{chain.number}" for chain in chosen[:8])
        raise ScenarioFault([Fault(("part", "edges"),
            f"selects {len(chosen)} edges, a pass runs along one; write one of {several}")])  # fmt: skip
    chain = chosen[0]
    name, frames = f"edge:{chain.number}", chain.frames
    leans = np.abs(frames.normal @ up).max(axis=0)
    face = int(np.argmin(leans))
    if leans[face] > _UPRIGHT:
        raise _refused(
            f"neither face of {name} stands along path.tool_axis (the nearer one leans by "
            f"{math.degrees(math.asin(min(1.0, float(leans[face])))):.3g} deg): the flank of the mill would not lie against it"
        )
    off = frames.normal[:, face]
    ahead = np.cross(off, up) if scenario.operation.milling == "down" else np.cross(up, off)
    back = float(np.einsum("ij,ij->i", frames.tangent, ahead).mean()) < 0.0
    order = slice(None, None, -1 if back else 1)
    return FoundEdge(name, frames.point[order], off[order], chain.closed)


def _line(edge: FoundEdge, flat: FloatArray):  # type: ignore[no-untyped-def]
    """The edge as a line, and its length; None where it is none."""
    way = flat[-1] - flat[0]
    length = float(np.linalg.norm(way))
    if edge.closed or length < _TRUE:
        return None, 0.0
    aside = np.abs((flat - flat[0]) @ np.array([-way[1], way[0]]) / length).max()
    if aside > _TRUE:
        return None, 0.0
    return Line.model_construct(**{"from": tuple(edge.point[0].tolist()), "to": tuple(edge.point[-1].tolist())}), length


def _arc(edge: FoundEdge, flat: FloatArray, right: FloatArray, ahead: FloatArray, level: FloatArray):  # type: ignore[no-untyped-def]
    """The edge as an arc round the work, and its length, by the circle of least squares through its samples."""
    middle = flat.mean(axis=0)
    local = flat - middle
    columns = np.column_stack([2.0 * local, np.ones(len(local))])
    (x, y, rest), *_ = np.linalg.lstsq(columns, (local**2).sum(axis=1), rcond=None)
    centre, radius = middle + np.array([x, y]), math.sqrt(max(0.0, rest + x * x + y * y))
    off = flat - centre
    wrong = float(np.abs(np.linalg.norm(off, axis=1) - radius).max())
    if wrong > _TRUE:
        raise _refused(
            f"{edge.name} is neither a line nor an arc: it is off the nearest circle by {_mm(wrong)}; deburring runs along "
            "lines and arcs (split such an edge, or give its parts as path.line and path.arc)"
        )
    outward = edge.off @ np.column_stack([right, ahead])
    if float(np.einsum("ij,ij->i", off, outward).mean()) < 0.0:
        raise _refused(
            f"{edge.name} runs round the inside of a hole; deburring by the flank of a mill is modelled on convex edges: "
            "use process: chamfer there"
        )
    turned = np.unwrap(np.arctan2(off[:, 1], off[:, 0]))
    sweep = 2.0 * math.pi if edge.closed else abs(float(turned[-1] - turned[0]))
    place = centre[0] * right + centre[1] * ahead + level
    arc = Arc.model_construct(
        **{"centre": tuple(place.tolist()), "radius": radius, "from": float(turned[0]), "sweep": sweep}
    )
    return arc, radius * sweep


def _refused(why: str) -> ScenarioFault:
    return ScenarioFault([Fault(("part", "edges"), why)])


def _mm(value: float) -> str:
    return units.show(value, "length")
