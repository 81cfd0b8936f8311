"""What is drawn of a tool that something carries, and of a shaft that is turned: places against laws of their own."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from app.view_file import read
from cutwise.app.scene import rows
from cutwise.app.scene.toolpath import toolpath_of
from cutwise.app.scene.turn import _insert
from cutwise.app.scene.view import view_file
from cutwise.io.scenario import load

ARMS = ("mill_on_robot", "deburr_on_robot", "chamfer_on_robot")
MACHINES = ("mill_on_machine", "chamfer_on_machine", "deburr_rigid_on_machine", "drill_on_machine")


@pytest.fixture(scope="module")
def seen(run_of):
    """Run and scene of an example, made once."""
    made = {}

    def of(name):
        if name not in made:
            result = run_of(name)
            made[name] = result, rows.of(result)
        return made[name]

    return of


@pytest.mark.parametrize("name", [*ARMS, *MACHINES])
def test_whatever_carries_the_tool_is_drawn(seen, name):
    """Seen to fail: mills and edges had no carrier at all, drills only a robot."""
    result, scene = seen(name)
    assert scene.links_are == ("arm" if name in ARMS else "bodies")
    assert scene.link_of.shape == scene.clock.shape
    assert scene.link_of.max() == len(scene.links) - 1
    if name in ARMS:
        base = scene.links[:, 0]
        assert np.ptp(base, axis=0).max() < 1e-12  # it stands, and takes its postures
        assert np.ptp(scene.links[:, 4], axis=0).max() > 1e-4
        spans = np.linalg.norm(np.diff(scene.links[:, :-1], axis=1), axis=2)
        assert np.ptp(spans, axis=0).max() < 1e-9  # links are rigid
        told = result["carrier"].dataset
        assert np.allclose(told["arm"].values[:, -1], told["tool_point"].values, atol=1e-6)
        tool = scene.tools[0]
        top = max(float(profile[:, 0].max(initial=0.0)) for profile in (tool.cutter, tool.holder, tool.fixed))
        held = scene.links[scene.link_of, -1] - top * scene.axis
        apart = np.linalg.norm(held - scene.place, axis=1)
        pitch = np.linalg.norm(np.diff(told["tool_point"].values, axis=0), axis=1).max()
        assert apart.max() <= 2.0 * pitch


@pytest.mark.parametrize("name", ["mill_on_robot", "mill_on_machine"])
def test_the_wall_is_off_the_path_by_the_radius_and_its_error(seen, name):
    """Points of the wall against the line of the scenario, on the side of the work."""
    result, scene = seen(name)
    line, radius = result.scenario.path.line, 0.5 * result.scenario.tool.diameter
    start, way = np.array(line.start)[:2], np.subtract(line.end, line.start)[:2]
    way = way / np.linalg.norm(way)
    right = np.array([way[1], -way[0]])  # down milling has the work there
    wall = next(one for one in scene.surfaces if one.title == "wall")
    away = (wall.points[:, :2] - start) @ right
    times = float(next(one for one in scene.said if one.startswith("error of the wall")).split()[-2])
    assert times > 1.0
    known = ~np.isnan(wall.values)
    assert known.any()
    assert away[known] == pytest.approx(radius + times * wall.values[known], abs=1e-9)
    assert np.ptp(wall.points[:, 2]) == pytest.approx(result.scenario.operation.axial_depth, abs=1e-9)
    assert wall.points[:, 2].min() == pytest.approx(scene.place[0, 2], abs=1e-9)
    assert np.dot(scene.front[:2], right) == pytest.approx(-1.0)
    assert ("part" in {one.title for one in scene.surfaces}) == (name == "mill_on_machine")


def test_what_yields_is_turned_into_the_part(seen):
    """Seen to fail: on the slanting wall of a machine the tool was not moved at all, on a robot along the wrong axes."""
    for name in ("mill_on_robot", "mill_on_machine"):
        result, scene = seen(name)
        line = result.scenario.path.line
        way = np.subtract(line.end, line.start)
        way /= np.linalg.norm(way)
        off = np.cross([0.0, 0.0, 1.0], way)
        terms = result["structure"].dataset
        moved = sum(a.values for key, a in terms.items() if str(key).startswith("deflection_"))
        assert scene.deflection @ way == pytest.approx(moved[:, 0], abs=1e-15)
        assert scene.deflection @ off == pytest.approx(moved[:, 1], abs=1e-15)
        assert scene.deflection[:, 2] == pytest.approx(moved[:, 2], abs=1e-15)


@pytest.mark.parametrize("turning", ["follow", "fixed"])
def test_off_an_edge_is_off_it_all_round(examples, turning):
    """Process axes that keep the attitude of the start do not turn the edge with them."""
    arc = (
        "path={arc: {centre: [1900 mm, 0 mm, 800 mm], radius: 50 mm, from: 90 deg, sweep: 180 deg}, tool_axis: [0, 0, -1],"
        f" orientation: {turning}}}"
    )
    edits = [arc, *(["spindle=rigid"] if turning == "fixed" else [])]
    way = toolpath_of(SimpleNamespace(scenario=load(examples / "deburr_on_robot.yaml", edits)))
    along = np.linspace(0.0, way.at[-1], 41)
    out = np.linalg.norm(way.on(along, 0.004, 0.001) - [1.9, 0.0, 0.801], axis=1)
    assert out == pytest.approx(0.054, abs=1e-4)  # chords of stations: less by s²/8r
    turned = way.turned(along, np.tile([0.0, 1.0, 0.0], (41, 1)))
    assert (np.ptp(turned, axis=0).max() < 1e-12) == (turning == "fixed")
    beyond = way.on(np.array([way.at[-1] + 0.01]), 0.0, 0.0) - way.point[-1]
    assert np.linalg.norm(beyond) == pytest.approx(0.01)


@pytest.mark.parametrize(("towards", "sense"), [("headstock", -1.0), ("tailstock", 1.0)])
def test_the_edges_of_an_insert_stand_as_its_angles_say(examples, towards, sense):
    """93° to the feed, and 55° of the corner left; the lowest point of the nose is the tip."""
    scenario = load(examples / "turn_shaft.yaml", [f"operation.towards={towards}"])
    cuts, holds = _insert(SimpleNamespace(scenario=scenario)).bodies
    edge = cuts.points[cuts.points[:, 1] == 0.0][:, [0, 2]]
    assert edge[:, 1].min() == pytest.approx(0.0, abs=1e-6)  # the nose in steps of 5 degrees
    major, minor = edge[25] - edge[24], edge[27] - edge[0]
    towards_feed = np.array([sense, 0.0])
    assert math.degrees(math.acos(major @ towards_feed / np.linalg.norm(major))) == pytest.approx(93.0)
    corner = major @ minor / np.linalg.norm(major) / np.linalg.norm(minor)
    assert math.degrees(math.acos(corner)) == pytest.approx(55.0)
    assert holds.holds
    assert holds.points[:, 2].min() > 0.0  # clear of the shaft


def test_a_shaft_shows_its_barrel_and_the_insert_follows(seen):
    result, scene = seen("turn_shaft")
    header, found = read(view_file(result))
    times = header["deflection"]["k"]
    assert times > 1.0
    shaft = next(one for one in scene.surfaces if one.title == "shaft")
    middle = np.argmin(np.abs(shaft.points[:, 0] - 0.2))
    error = result["surface"]["diameter_error"].values[:, -1]
    z = result["surface"]["z"].values
    here = int(np.argmin(np.abs(z - 0.2)))
    wide = float(np.hypot(*shaft.points[middle, 1:]))
    assert wide == pytest.approx(0.0125 + 0.5 * times * error[here], rel=1e-9)
    last = scene.counted & (np.abs(scene.place[:, 0] - 0.2) < 1e-6)
    assert scene.place[last, 2] == pytest.approx(0.0125)  # what is told is where it is, not where it is drawn
    assert scene.place[last, 2] + times * scene.deflection[last, 2] == pytest.approx(wide)
    assert header["tools"][0]["bodies"] == [False, True]
    assert found["t/0/0/point"].shape == scene.tools[0].bodies[0].points.shape
    assert np.abs(shaft.points[:, 0]).max() == pytest.approx(0.4)


def test_a_carrier_that_a_run_does_not_tell_is_said(seen):
    """Run files made before the carrier was told, and those without the group."""
    result, scene = seen("mill_on_robot")
    older = result.stages.copy()
    older["carrier"] = xr.DataTree(older["carrier"].to_dataset().drop_vars(["arm", "tool_point"]))
    assert "run it again" in rows.of(dataclasses.replace(result, stages=older)).said[-1]
    del older["carrier"]
    assert "robot is not drawn" in rows.of(dataclasses.replace(result, stages=older)).said[-1]
    assert not any("drawn: the run" in one or "run it again" in one for one in scene.said)
