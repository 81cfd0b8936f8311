"""An edge of a STEP part that is deburred: it becomes the line or the arc that it is, and what is neither is refused."""

import math
from pathlib import Path

import numpy as np
import pytest

import cutwise
from cutwise.io import step
from cutwise.io.cad_parts import drilled_block
from cutwise.io.occ import occ
from cutwise.process.assemble import deburring_cell
from cutwise.process.deburring_part import on_part
from cutwise.process.loops import Arc, axis_over_edge, run_compliant_edge
from cutwise.spec.faults import ScenarioFault

EXAMPLES = Path(__file__).parents[3] / "examples"
MM, UM = 1e-3, 1e-6


def disc(minor=50.0):
    """A disc of 50 mm radius and 12 mm height off the origin, or an ellipse; shape of OpenCascade in mm."""
    gp, make = occ("gp"), occ("BRepBuilderAPI")
    frame = gp.gp_Ax2(gp.gp_Pnt(30, -20, 5), gp.gp_Dir(0, 0, 1))
    if minor == 50.0:
        return occ("BRepPrimAPI").BRepPrimAPI_MakeCylinder(frame, 50.0, 12.0).Shape()
    rim = make.BRepBuilderAPI_MakeEdge(gp.gp_Elips(frame, 50.0, minor)).Edge()
    face = make.BRepBuilderAPI_MakeFace(make.BRepBuilderAPI_MakeWire(rim).Wire()).Face()
    return occ("BRepPrimAPI").BRepPrimAPI_MakePrism(face, gp.gp_Vec(0, 0, 12)).Shape()


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    made = {"disc": disc(), "oval": disc(40.0), "block": drilled_block(0.3, 0.06, 0.02, [(0.15, 0.03, 0.01, 0.0)])}
    return {name: step.write_step(shape, folder / f"{name}.step") for name, shape in made.items()}


def scenario(parts, name, *changes, orientation="follow"):
    path = (
        f"path={{tool_axis: [0, 0, -1], orientation: {orientation}}}" if orientation else "path={tool_axis: [0, 0, -1]}"
    )
    return cutwise.load(EXAMPLES / "deburr_arc.yaml", (path, f"part.step={parts[name]}", *changes))


def test_the_rim_of_a_disc_gives_the_digits_of_the_arc(parts):
    """4f of the specification of the cell: -8.08883 um throughout, where the tool turns with the edge."""
    found = on_part(scenario(parts, "disc", "part.edges=facing:+z", "operation.duration=1.9635 s"))
    assert found.path.arc.centre == pytest.approx([0.030, -0.020, 0.017], abs=1e-9)
    assert found.path.arc.sweep == pytest.approx(2 * math.pi)
    cell = deburring_cell(found)
    assert cell.arc == pytest.approx(Arc(50 * MM, True), rel=1e-9)
    history = run_compliant_edge(cell, 2e-5)
    moved = (cell.reach - 0.5 * MM) * history.response.tilt
    along, height = axis_over_edge(cell, history.motion.time, moved[:, 0], moved[:, 1])
    at = np.interp([60, 90, 120, 150, 175], np.degrees(along / cell.arc.radius), height / UM)
    assert at == pytest.approx(np.full(5, -8.08883), abs=1e-4)


def test_the_rim_runs_to_its_end_where_nothing_else_is_said(parts):
    found = on_part(scenario(parts, "disc", "part.edges=facing:+z"))
    assert found.operation.run_length == pytest.approx(2 * math.pi * 0.05)


@pytest.mark.parametrize(("milling", "sense"), [("down", 1.0), ("up", -1.0)])
def test_a_straight_edge_is_run_with_the_work_on_its_side(parts, milling, sense):
    """The long edge at y = 60 mm and the top: with the motor above and the work on the right the feed goes along -x."""
    plain = ("part.edges=longer:200mm&facing:+z&facing:+y", f"operation.milling={milling}")
    found = on_part(scenario(parts, "block", *plain, orientation=None))
    start, end = np.array(found.path.line.start), np.array(found.path.line.end)
    work = np.array([0.0, -1.0, 0.0])
    right = np.cross(end - start, [0.0, 0.0, 1.0]) / 0.3
    assert right @ work == pytest.approx(sense)
    assert [start[1], end[1]] == pytest.approx([0.06, 0.06])
    assert found.operation.run_length == pytest.approx(0.3)


def test_a_straight_edge_gives_what_its_length_alone_gives(parts):
    """Without a robot a line is a length."""
    alone = cutwise.load(EXAMPLES / "deburr_arc.yaml", ("path=null", "operation.length=300 mm"))
    of_part = on_part(scenario(parts, "block", "part.edges=longer:200mm&facing:+z&facing:+y", orientation=None))
    first, second = (run_compliant_edge(deburring_cell(one), 5e-5) for one in (alone, of_part))
    np.testing.assert_allclose(second.response.tilt, first.response.tilt, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "changes", "key", "words"),
    [
        ("oval", ("part.edges=facing:+z",), "part.edges", "neither a line nor an arc"),
        ("block", ("part.edges=hole:1&facing:+z",), "part.edges", "inside of a hole"),
        ("block", ("part.edges=all",), "part.edges", "a pass runs along one"),
        ("block", ("part.edges=edge:99",), "part.edges", "selects no sharp edge"),
        ("disc", ("part.edges=facing:+z", "path.tool_axis=[1, 0, -1]"), "part.edges", "neither face"),
        ("disc", ("part.edges=facing:+z", "operation.duration=60 s"), "operation.duration", "the path only"),
        ("disc", ("part.edges=facing:+z", "operation.milling=up"), "operation.milling", "not modelled"),
    ],
)
def test_what_the_mill_cannot_follow_is_refused(parts, name, changes, key, words):
    with pytest.raises(ScenarioFault) as caught:
        on_part(scenario(parts, name, *changes))
    told = [f"{'.'.join(map(str, fault.path))}: {fault.message}" for fault in caught.value.faults]
    assert any(line.startswith(key) and words in line for line in told), told


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        (("part.edges=edge:1",), "part.edges", "write part.step"),
        (("path={tool_axis: [0, 0, -1]}",), "path.line", "or part.step"),
    ],
)
def test_an_edge_is_given_once(changes, key, words):
    with pytest.raises(ScenarioFault) as caught:
        cutwise.load(EXAMPLES / "deburr_arc.yaml", changes)
    assert any(".".join(map(str, fault.path)) == key and words in fault.message for fault in caught.value.faults)


def test_a_part_beside_a_path_is_refused(parts):
    with pytest.raises(ScenarioFault, match="second time"):
        cutwise.load(EXAMPLES / "deburr_arc.yaml", (f"part.step={parts['disc']}",))
