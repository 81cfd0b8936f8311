"""The arrays of a chamfer run with names and units, all paths one after another."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import arc_lengths
from cutwise.paths import reach
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.process import carriers, chamfer_carrier
from cutwise.process.chamfer import ChamferRun
from cutwise.process.labels import Column, Coordinate, Group, Groups, Over, Read, labelled
from cutwise.spec.chamfer import ChamferScenario

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

_POINTS = ["first face", "first border", "edge", "second border", "second face"]


def stages(scenario: ChamferScenario, done: ChamferRun) -> Groups:
    """Paths, contacts, forces and widths, the moves of the program, what carries the tool, and the part."""
    if done.program is None:
        return {}
    groups: dict[str, Group | xr.Dataset] = {
        **GROUPS,
        "structure": _structure(scenario, done),
        "program": done.program.table,
    }
    if done.carriers:
        groups["carrier"] = chamfer_carrier.stations(scenario, done.carriers)
    if done.outline is not None:
        groups["part"] = _part(scenario, done)
        if scenario.part.pipe is None:  # the faces of its mesh reach beyond it
            groups["scene"] = _seen(done.paths[0])
    return groups


def _joined(members: Iterable[Any], value: Callable[[Any], Any]) -> FloatArray | None:
    """Something of all paths, one after another; None without any, or where one has none."""
    found = [value(one) for one in members]
    return np.concatenate(found) if found and all(one is not None for one in found) else None


def _paths(value: Callable[[EdgePath], Any]) -> Read:
    """Something of the planned paths."""
    return lambda done: _joined(done.paths, value)


def _each(value: Callable[[EdgePath], float]) -> Read:
    """A number of a path, at all of its points."""
    return _paths(lambda path: np.full(len(path.path.centre), value(path)))


def _of(members: str, value: Callable[[Any], Any]) -> Read:
    """Something of other members of a run: of the paths as led, their forces, or their deflections."""
    return lambda done: _joined(getattr(done, members), value)


def _moves(value: Callable[[Any], Any]) -> Read:
    return _of("deflected", lambda one: value(one.moves))


def _numbers(done: ChamferRun, size: Callable[[EdgePath], int]) -> np.ndarray:
    return np.concatenate([np.full(size(path), i) for i, path in enumerate(done.paths)])


def _at_points(one: FloatArray, path: EdgePath) -> FloatArray:
    return one if path.path.frames.closed else np.append(one, one[-1])


def _steps(path: EdgePath) -> FloatArray:
    """Arc lengths of the edge from point to point [m]."""
    edge = path.path.frames
    return arc_lengths(edge.point, edge.tangent, closed=edge.closed)


def _lengths(path: EdgePath) -> FloatArray:
    """Arc length of the edge at its points, and behind the last of a closed one [m]."""
    return np.concatenate([[0.0], np.cumsum(_steps(path))])


def _station(done: ChamferRun) -> FloatArray:
    """Arc length along the edges, one after another, at the path points."""
    found, before = [], 0.0
    for path in done.paths:
        found.append(before + _lengths(path)[: len(path.path.centre)])
        before += float(_steps(path).sum())
    return np.concatenate(found)


def _measured(done: ChamferRun) -> FloatArray:
    """The same where what is left is measured."""
    found, before = [], 0.0
    for path in done.paths:
        edge, run_length = path.path.frames, _lengths(path)
        parameter = np.append(edge.parameter, edge.parameter[0] + edge.period) if edge.closed else edge.parameter
        found.append(before + np.interp(path.at.parameter, parameter, run_length))
        before += float(run_length[-1])
    return np.concatenate(found)


_OVER: Over = {
    "s": Coordinate(_station, "m", "position along the edges"),
    "s_measured": Coordinate(_measured, "m", "position along the edges"),
    "axis": "xyz", "axis2": "xy", "side": ["first", "second"],
}  # fmt: skip
GROUPS = {
    "motion": Group({
        "centre": Column("s axis", _paths(lambda p: p.path.centre), "m", "ball centre"),
        "tool_axis": Column("s axis", _paths(lambda p: np.tile(p.axis, (len(p.path.centre), 1))), "1", "rod direction"),
        "feed": Column("s", _paths(lambda p: _at_points(p.feeds.centre, p)), "m/s", "speed of the ball centre"),
        "contact_feed": Column("s", _paths(lambda p: _at_points(p.feeds.contact, p)), "m/s", "contact speed"),
        "path": Column("s", lambda done: _numbers(done, lambda p: len(p.path.centre)), "1", "path number"),
        "edge_number": Column("s", _each(lambda p: p.work.number), "1", "number of the edge"),
        "closed": Column("s", _each(lambda p: float(p.path.frames.closed)), "1", "1 where the path runs back to its start"),
        "tilt": Column("s", _each(lambda p: p.tilt), "rad", "tilt of the chamfer"),
        "plunge": Column("s", _paths(lambda p: p.local.plunge), "1", "edge tangent along the rod"),
    }, _OVER),
    "engagement": Group({
        "contact": Column("s axis", _paths(lambda p: p.path.contact.mean(axis=1)), "m", "middle of the chamfer"),
        "edge": Column("s axis", _paths(lambda p: p.path.frames.point), "m", "edge"),
        "tangent": Column("s axis", _paths(lambda p: p.path.frames.tangent), "1", "edge tangent"),
        "air": Column("s axis", _paths(lambda p: p.path.air), "1", "chamfer normal, out of the material"),
        "leg": Column("s side", _paths(lambda p: p.path.leg), "m", "leg on each face"),
        "contact_angle": Column("s side", _paths(lambda p: reach.contact_angles(p.path, p.axis)), "rad", "border from the rod"),
        "wedge_angle": Column("s", _paths(lambda p: p.path.frames.wedge), "rad", "wedge angle of the material"),
        "rod_clearance": Column("s", _paths(lambda p: p.rod_each), "m", "rod from the wall of its hole"),
        "chip_area": Column("s", _of("forces", lambda f: f.chip_area), "m**2",
                            "cross-section taken off, at right angles to the edge"),
    }, _OVER),
    "cutting": Group({
        "force": Column("s axis", _of("forces", lambda f: f.force), "N", "force on the tool, frame of the pass"),
        "burr_force": Column("s axis", _of("forces", lambda f: f.burr_force), "N", "that of the burr alone"),
        "power": Column("s", _of("forces", lambda f: f.power), "W", "cutting power"),
    }, _OVER),
    "surface": Group({
        "width": Column("s_measured", _of("led", lambda p: p.found.width), "m", "chamfer width left by the sweep"),
        "swept_leg": Column("s_measured side", _of("led", lambda p: p.found.leg), "m", "legs left by the sweep"),
        "beside": Column("s_measured", _of("led", lambda p: p.found.beyond), "m", "cut into both faces beside the chamfer"),
        "setup_slope": Column("s_measured", _paths(lambda p: p.slope), "1", "width change per shift along the tool axis"),
        "path_measured": Column("s_measured", lambda done: _numbers(done, lambda p: len(p.found.width)).astype(float), "1",
                                "path number"),
        "width_deflected": Column("s_measured", _of("deflected", lambda d: d.width), "m",
                                  "chamfer width with the spindle deflected"),
        "width_low": Column("s_measured", lambda done: done.band and done.band.low_along, "m", "5 % of set-ups below"),
        "width_high": Column("s_measured", lambda done: done.band and done.band.high_along, "m", "5 % of set-ups above"),
    }, _OVER),
}  # fmt: skip
"""All paths one after another."""


def _structure(scenario: ChamferScenario, done: ChamferRun) -> Group:
    """What spindle and carrier yield by."""
    columns = {
        "tip_deflection": Column("s axis2", _moves(lambda m: m.tip), "m", "deflection of the tip, feed and off the work"),
        "ball_offset": Column("s axis", _moves(lambda m: m.offset), "m", "ball centre from its nominal path"),
        "deflected_force": Column("s axis", _moves(lambda m: m.force), "N", "force while yielding"),
        "tilt": Column("s axis2", _moves(lambda m: m.tilt), "rad", "tilt of the motor across the rod, fixed directions"),
        **carriers.deflections(
            chamfer_carrier.by_term(done.paths, [one.moves for one in done.deflected]), "the chamfer", "s", _OVER,
            "displacement of the ball by the term {name}, frame of the pass",
        ).columns,
    }  # fmt: skip
    if scenario.compliant is None:
        del columns["tilt"]
    return Group(columns, _OVER)


def _part(scenario: ChamferScenario, done: ChamferRun) -> xr.Dataset:
    """Outline of the part, and where the tool is nearest to trouble."""
    assert done.outline is not None
    paths = done.paths
    nearest, at, why = _worst(scenario, paths)
    found = labelled(("outline_point", np.arange(len(done.outline.point)), "1", "point of the outline"), {
        "outline": (done.outline.point, "m", "edges of the part"),
        "outline_line": (done.outline.number.astype(float), "1", "number of the line"),
    }, axis=["x", "y", "z"])  # fmt: skip
    return found.merge(_section(nearest, at)).assign_attrs(
        worst_centre=nearest.path.centre[at].tolist(), worst_axis=nearest.axis.tolist(), worst_reason=why,
        worst_path=int(next(i for i, p in enumerate(paths) if p is nearest)), worst_point=at,
        worst_name=nearest.work.name,
    )  # fmt: skip


def _seen(path: EdgePath) -> xr.Dataset:
    """Triangles of the part with the faces that they are on, as a picture needs them."""
    mesh, names = path.work.shape.mesh, path.work.shape.names
    return labelled(("triangle", np.arange(len(mesh.face)), "1", "triangle of the part"), {
        "corner": (mesh.piece[:, :9].astype(np.float32), "m", "corners of the triangles, x, y, z of each"),
        "face": (mesh.face.astype(np.int32), "1", "face that they are on, from 0"),
    }, number=list(range(9))).assign_attrs(face_names=list(names))  # fmt: skip


def _worst(scenario: ChamferScenario, paths: Sequence[EdgePath]) -> tuple[EdgePath, int, str]:
    """Path and point where the tool is nearest to trouble, and why it is there."""
    rod_why = "where the rod is nearest to the part"
    for path in paths:
        if path.rod_each is not None:
            return path, int(np.argmin(path.rod_each)), rod_why
    with_rod = [p for p in paths if p.rod is not None and np.isfinite(p.rod.place).all()]
    if with_rod:
        nearest = min(with_rod, key=lambda p: p.rod.value if p.rod is not None else np.inf)
        assert nearest.rod is not None
        off = nearest.rod.place - nearest.path.centre
        off = off - (off @ nearest.axis)[:, None] * nearest.axis
        return nearest, int(np.linalg.norm(off, axis=1).argmin()), rod_why
    tool = scenario.tool
    nearest = min(paths, key=lambda p: min(m.value for m in p.margins if m.code == reach.KNIFE))
    chi = reach.contact_angles(nearest.path, nearest.axis)
    spare = np.minimum(chi.min(axis=1) - tool.knife_limit_angle, np.pi - tool.pole_limit_angle - chi.max(axis=1))
    return nearest, int(spare.argmin()), "where the contact is nearest to the end of the knife"


def _section(path: EdgePath, at: int) -> xr.Dataset:
    """The edge across its direction at one place, from the ball centre, the rod as upright as it can be [m]."""
    frames, centre = path.path.frames, path.path.centre[at]
    tangent = frames.tangent[at]
    up = path.axis - (path.axis @ tangent) * tangent
    if np.linalg.norm(up) < 1e-6:
        up = frames.air[at]
    up = up / np.linalg.norm(up)
    aside = np.cross(tangent, up)

    def seen(point: FloatArray) -> FloatArray:
        return np.column_stack([point @ aside, point @ up])

    edge, border = frames.point[at] - centre, path.path.contact[at] - centre
    far = edge + 1.6 * path.ball_radius * frames.into[at]
    points = seen(np.vstack([far[0], border[0], edge, border[1], far[1]]))
    section = ("section_point", "section_axis"), points, {"units": "m", "long_name": "edge across its direction"}
    return xr.Dataset({"section": section}, {"section_point": _POINTS, "section_axis": ["aside", "up"]})
