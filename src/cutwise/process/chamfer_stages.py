"""The arrays of a chamfer run with names and units, all paths one after another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import arc_lengths
from cutwise.paths import reach
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.process import chamfer_carrier
from cutwise.process.chamfer import ChamferRun
from cutwise.process.labels import labelled
from cutwise.spec.chamfer import ChamferScenario

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

One = TypeVar("One")


def stages(scenario: ChamferScenario, done: ChamferRun) -> xr.DataTree:
    """Paths, contacts, forces and widths as labelled arrays."""
    paths = done.paths
    if not paths or done.program is None:
        return xr.DataTree()
    groups = {
        "motion": _motion(paths), "engagement": _engagement(done), "surface": _surface(done),
        "program": done.program.table,
    }  # fmt: skip
    at = _station(paths)
    if done.forces:
        groups["cutting"] = labelled(at, {
            "force": (_joined(done.forces, lambda f: f.force), "N", "force on the tool, frame of the pass"),
            "burr_force": (_joined(done.forces, lambda f: f.burr_force), "N", "that of the burr alone"),
            "power": (_joined(done.forces, lambda f: f.power), "W", "cutting power"),
        }, axis=["x", "y", "z"])  # fmt: skip
    if done.deflected:
        groups["structure"] = _structure(scenario, done)
    if done.carriers:
        groups["carrier"] = chamfer_carrier.stations(scenario, done.carriers)
    if done.outline is not None:
        groups["part"] = _part(scenario, done)
        if scenario.part.pipe is None:  # the faces of its mesh reach beyond it
            groups["scene"] = _seen(paths[0])
    return xr.DataTree.from_dict(groups)


def _joined(members: Sequence[One], value: Callable[[One], FloatArray]) -> FloatArray:
    return np.concatenate([value(one) for one in members])


def _station(paths: Sequence[EdgePath]) -> tuple[str, FloatArray, str, str]:
    """Arc length along the edges, one after another, at the path points."""
    found, before = [], 0.0
    for path in paths:
        edge = path.path.frames
        step = arc_lengths(edge.point, edge.tangent, closed=edge.closed)
        run_length = np.concatenate([[0.0], np.cumsum(step)])
        found.append(before + run_length[: len(path.path.centre)])
        before += float(step.sum())
    return ("s", np.concatenate(found), "m", "position along the edges")


def _motion(paths: Sequence[EdgePath]) -> xr.Dataset:
    def at_points(one: FloatArray, path: EdgePath) -> FloatArray:
        return one if path.path.frames.closed else np.append(one, one[-1])

    def same(value: float, path: EdgePath) -> FloatArray:
        return np.full(len(path.path.centre), value)

    return labelled(_station(paths), {
        "centre": (_joined(paths, lambda p: p.path.centre), "m", "ball centre"),
        "tool_axis": (_joined(paths, lambda p: np.tile(p.axis, (len(p.path.centre), 1))), "1", "rod direction"),
        "feed": (_joined(paths, lambda p: at_points(p.feeds.centre, p)), "m/s", "speed of the ball centre"),
        "contact_feed": (_joined(paths, lambda p: at_points(p.feeds.contact, p)), "m/s", "contact speed"),
        "path": (np.concatenate([same(i, p) for i, p in enumerate(paths)]), "1", "path number"),
        "edge_number": (_joined(paths, lambda p: same(p.work.number, p)), "1", "number of the edge"),
        "closed": (_joined(paths, lambda p: same(float(p.path.frames.closed), p)), "1",
                   "1 where the path runs back to its start"),
        "tilt": (_joined(paths, lambda p: same(p.tilt, p)), "rad", "tilt of the chamfer"),
        "plunge": (_joined(paths, lambda p: p.local.plunge), "1", "edge tangent along the rod"),
    }, axis=["x", "y", "z"])  # fmt: skip


def _engagement(done: ChamferRun) -> xr.Dataset:
    paths = done.paths
    columns = {
        "contact": (_joined(paths, lambda p: p.path.contact.mean(axis=1)), "m", "middle of the chamfer"),
        "edge": (_joined(paths, lambda p: p.path.frames.point), "m", "edge"),
        "tangent": (_joined(paths, lambda p: p.path.frames.tangent), "1", "edge tangent"),
        "air": (_joined(paths, lambda p: p.path.air), "1", "chamfer normal, out of the material"),
        "leg": (_joined(paths, lambda p: p.path.leg), "m", "leg on each face"),
        "contact_angle": (_joined(paths, lambda p: reach.contact_angles(p.path, p.axis)), "rad", "border from the rod"),
        "wedge_angle": (_joined(paths, lambda p: p.path.frames.wedge), "rad", "wedge angle of the material"),
    }  # fmt: skip
    if all(path.rod_each is not None for path in paths):
        columns["rod_clearance"] = (_joined(paths, lambda p: p.rod_each), "m", "rod from the wall of its hole")
    if done.forces:
        columns["chip_area"] = (
            _joined(done.forces, lambda f: f.chip_area),
            "m**2",
            "cross-section taken off, at right angles to the edge",
        )
    return labelled(_station(paths), columns, axis=["x", "y", "z"], side=["first", "second"])


def _surface(done: ChamferRun) -> xr.Dataset:
    paths = done.paths
    at, before = [], 0.0
    for path in paths:
        edge = path.path.frames
        run_length = np.concatenate([[0.0], np.cumsum(arc_lengths(edge.point, edge.tangent, closed=edge.closed))])
        parameter = np.append(edge.parameter, edge.parameter[0] + edge.period) if edge.closed else edge.parameter
        at.append(before + np.interp(path.at.parameter, parameter, run_length))
        before += float(run_length[-1])
    columns = {
        "width": (_joined(done.led, lambda p: p.found.width), "m", "chamfer width left by the sweep"),
        "swept_leg": (_joined(done.led, lambda p: p.found.leg), "m", "legs left by the sweep"),
        "beside": (_joined(done.led, lambda p: p.found.beyond), "m", "cut into both faces beside the chamfer"),
        "setup_slope": (_joined(paths, lambda p: p.slope), "1", "width change per shift along the tool axis"),
        "path_measured": (
            np.concatenate([np.full(len(p.found.width), float(i)) for i, p in enumerate(paths)]), "1", "path number",
        ),
    }  # fmt: skip
    if done.deflected:
        columns["width_deflected"] = (
            _joined(done.deflected, lambda d: d.width), "m", "chamfer width with the spindle deflected"
        )  # fmt: skip
    if done.band is not None:
        columns["width_low"] = (done.band.low_along, "m", "5 % of set-ups below")
        columns["width_high"] = (done.band.high_along, "m", "5 % of set-ups above")
    place = ("s_measured", np.concatenate(at), "m", "position along the edges")
    return labelled(place, columns, side=["first", "second"])


def _structure(scenario: ChamferScenario, done: ChamferRun) -> xr.Dataset:
    moved = [one.moves for one in done.deflected]
    motor = {"tilt": (_joined(moved, lambda m: m.tilt), "rad", "tilt of the motor across the rod, fixed directions")}
    each = {
        f"deflection_{name}": (
            np.concatenate([
                chamfer_carrier.in_pass(path, one.terms[k][1]) for path, one in zip(done.paths, moved, strict=True)
            ]), "m", f"displacement of the ball by the term {name}, frame of the pass",
        )
        for k, (name, _) in enumerate(moved[0].terms)
    }  # fmt: skip
    return labelled(_station(done.paths), {
        "tip_deflection": (_joined(moved, lambda m: m.tip), "m", "deflection of the tip, feed and off the work"),
        "ball_offset": (_joined(moved, lambda m: m.offset), "m", "ball centre from its nominal path"),
        "deflected_force": (_joined(moved, lambda m: m.force), "N", "force while yielding"),
        **(motor if scenario.compliant is not None else {}), **each,
    }, axis=["x", "y", "z"], axis2=["x", "y"])  # fmt: skip


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
    walls = [p for p in paths if p.rod_each is not None]
    if walls:
        return walls[0], int(np.argmin(walls[0].rod_each)), rod_why
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
    return xr.Dataset(
        {"section": (("section_point", "section_axis"), points, {"units": "m", "long_name": "edge across its direction"})},
        {"section_point": ["first face", "first border", "edge", "second border", "second face"],
         "section_axis": ["aside", "up"]},
    )  # fmt: skip
