"""Edges that fade into tangency keep their width as long as they can, stop, and say where; long plans say how long."""

import logging
import math
import re
from pathlib import Path

import numpy as np
import pytest

import cutwise
from cutwise.io import step
from cutwise.io.occ import occ
from cutwise.paths.chamfer import fading
from cutwise.process import chamfer, pace

STEP = Path(__file__).parents[3] / "data" / "step"
WIDTH = 0.2e-3


def rounded(width, radius, along):
    """A block 20 mm high, 60 mm long along x or y, whose upper edge at the width [mm] is rounded."""
    gp, api = occ("gp"), occ("BRepBuilderAPI")

    def at(across, z):
        return gp.gp_Pnt(0, across, z) if along == "x" else gp.gp_Pnt(across, 0, z)

    diagonal = radius * math.sqrt(0.5)
    corner = at(width - radius + diagonal, 20 - radius + diagonal)
    arc = occ("GC").GC_MakeArcOfCircle(at(width, 20 - radius), corner, at(width - radius, 20)).Value()
    wire = api.BRepBuilderAPI_MakeWire()
    wire.Add(api.BRepBuilderAPI_MakeEdge(at(0, 0), at(width, 0)).Edge())
    wire.Add(api.BRepBuilderAPI_MakeEdge(at(width, 0), at(width, 20 - radius)).Edge())
    wire.Add(api.BRepBuilderAPI_MakeEdge(arc).Edge())
    wire.Add(api.BRepBuilderAPI_MakeEdge(at(width - radius, 20), at(0, 20)).Edge())
    wire.Add(api.BRepBuilderAPI_MakeEdge(at(0, 20), at(0, 0)).Edge())
    face = api.BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    length = gp.gp_Vec(60, 0, 0) if along == "x" else gp.gp_Vec(0, 60, 0)
    return occ("BRepPrimAPI").BRepPrimAPI_MakePrism(face, length).Shape()


@pytest.fixture(scope="module", params=[8.0, 3.0])
def mitre(request, tmp_path_factory):
    """Two rounded edges meet: the edge between them is square below and fades into the flat top."""
    shape = occ("BRepAlgoAPI").BRepAlgoAPI_Common(rounded(30, 8, "y"), rounded(25, request.param, "x")).Shape()
    return step.write_step(shape, tmp_path_factory.mktemp("mitre") / "mitre.step")


def planned(examples, file, *said, progress=None):
    keys = (f"part={{step: {file}, edges: all}}", "chamfer.width=0.2 mm", *(said or ("requirements={}",)))
    return chamfer.run(
        cutwise.load(examples / "chamfer_step_part.yaml", keys), wanted=frozenset(), progress=progress
    )  # fmt: skip


def fading_plan(done):
    return next(p for p in done.plans if p.work.nodes.wedge.max() > math.radians(170.0))


def test_an_edge_that_fades_keeps_its_width_and_stops(examples, mitre):
    """Version 0.1: up to 0.227 mm for 0.2, and not a word."""
    done = planned(examples, mitre)
    for path in done.paths:
        np.testing.assert_allclose(path.found.width, WIDTH, rtol=0.03)
    plan = fading_plan(done)
    (trim,) = plan.trims
    assert trim.length < 0.5e-3
    where = re.search(r"fades into tangency at \((.*), (.*), (.*)\) mm: beyond a wedge of (17\d\.\d)°", trim.reason)
    assert float(where[3]) == pytest.approx(20.0, abs=0.02)
    assert float(where[4]) == pytest.approx(math.degrees(2.0 * math.atan(0.5 * WIDTH / 2e-6)), abs=0.3)


def test_a_requirement_on_the_width_says_where_to_stop(examples, mitre):
    """Half a micrometre cannot be kept in a blunt wedge: the path stops there, and what is cut meets the requirement."""
    loose = fading_plan(planned(examples, mitre))
    limits = "requirements={width_min: {min: 0.1995 mm}, width_max: {max: 0.2005 mm}}"
    tight = fading_plan(planned(examples, mitre, limits))
    assert tight.trimmed > loose.trimmed
    assert all(trim.reason.startswith("the edge fades") for trim in tight.trims)
    for path in tight.paths:
        assert math.degrees(path.at.wedge.max()) < 177.5
        blunt = path.at.wedge > fading.BLUNT
        assert np.abs(path.found.width[blunt] - WIDTH).max(initial=0.0) <= 0.5e-6


def test_a_straight_ridge_that_fades_is_chamfered_to_its_end(examples):
    """A control that version 0.1 had right: 4 mm from 120 to 174 degrees."""
    done = planned(examples, STEP / "fading_ridge_4mm.step")
    plan = fading_plan(done)
    assert not plan.trims
    np.testing.assert_allclose(plan.paths[0].found.width, WIDTH, rtol=0.01)
    assert sum(p.trimmed for p in done.plans) == 0.0


def test_a_plan_shows_how_far_it_is_and_stops_when_asked(examples):
    seen = []
    planned(examples, STEP / "fading_ridge_4mm.step", progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)
    assert len(seen) == 30

    def stop(share):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        planned(examples, STEP / "fading_ridge_4mm.step", progress=stop)


def test_the_rest_of_a_long_plan_is_estimated_once(monkeypatch, caplog):
    clock = iter([0.0, 0.5, 2.0, 4.0, 6.0])
    monkeypatch.setattr(pace.time, "process_time", lambda: next(clock))
    with caplog.at_level(logging.INFO, "cutwise"):
        job = pace.Pace(100.0, "Fewer edges make it shorter.")
        for _ in range(4):
            job.advance(1.0)
    assert caplog.messages == ["about 98 s of computing to come; Ctrl-C stops it. Fewer edges make it shorter."]


@pytest.mark.parametrize(("seconds", "said"), [(12.3, "12 s"), (99.9, "100 s"), (340.0, "5.7 min"), (7000.0, "1.9 h")])
def test_times_that_are_estimates(seconds, said):
    assert pace.span(seconds) == said
