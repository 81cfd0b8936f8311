"""STEP parts: what cannot be read, what is found, and CAD paths against the analytic pipe."""

import numpy as np
import pytest

from cutwise.io import cad, cad_edges, cad_parts, cad_select, step
from cutwise.paths.chamfer.ball_path import Chamfer, chamfer_path
from cutwise.paths.pipe import PipeHole, one_turn, pipe_edge

HEADER = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n" \
         "FILE_SCHEMA(('CONFIG_CONTROL_DESIGN'));\nENDSEC;\n"  # fmt: skip


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"), ("solid of an STL", "not a STEP file"), (HEADER + "END-ISO-10303-21;\n", "no data section"),
        (HEADER + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n", "without geometry"),
    ],
)  # fmt: skip
def test_files_that_are_no_part(tmp_path, text, message):
    file = tmp_path / "part.step"
    file.write_text(text)
    with pytest.raises(step.CadFault, match=message):
        step.read_step(file)


def test_damaged_file(tmp_path):
    file = step.write_step(cad_parts.drilled_block(0.06, 0.04, 0.03, []), tmp_path / "block.step")
    file.write_text(file.read_text()[:6000])
    with pytest.raises(step.CadFault, match="damaged"):
        step.read_step(file)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (",30.)", ",nan)", r"line \d+: nan is not a number"), (",30.)", ",-INF)", "-INF is not a number"),
        (",30.)", ",1e300)", "the coordinate 1e300 is no length of a part"), (",30.)", ",)", "coordinate that is missing"),
    ],
)  # fmt: skip
def test_numbers_that_no_part_has(tmp_path, old, new, message):
    file = step.write_step(cad_parts.drilled_block(0.06, 0.04, 0.03, []), tmp_path / "block.step")
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    with pytest.raises(step.CadFault, match=message):
        step.read_step(file)


def test_a_part_of_kilometres_is_in_another_unit(tmp_path):
    file = step.write_step(cad_parts.drilled_block(2000.0, 0.04, 0.03, []), tmp_path / "block.step")
    with pytest.raises(step.CadFault, match="reaches farther than 1 km: check the unit"):
        step.read_step(file)


@pytest.fixture(scope="module")
def pipe(tmp_path_factory):
    file = tmp_path_factory.mktemp("cad") / "pipe.step"
    return cad.topology(step.read_step(step.write_step(cad_parts.drilled_pipe(0.015, 0.002, 0.004, 0.06), file)))


def test_drilled_pipe_has_ten_edges_and_six_closed_chains(pipe):
    assert (pipe.count(cad.CONVEX), pipe.count(cad.SEAM), len(pipe.edges)) == (10, 5, 15)
    chains = cad_edges.sharp_chains(pipe)
    assert len(chains) == 6
    assert all(chain.closed for chain in chains)


@pytest.mark.parametrize("inner", [True, False])
def test_cad_path_is_the_analytic_one(pipe, inner):
    chains = [c for c in cad_edges.sharp_chains(pipe, spacing=5e-5) if 1 in c.holes and len(c.edges) == 3]
    chain = next(c for c in chains if (c.where == "inner") == inner)
    path = chamfer_path(chain.frames, Chamfer(0.3e-3), 0.002)
    theta = np.arctan2(chain.frames.point[:, 1], chain.frames.point[:, 0])
    order = np.argsort(theta)
    part = PipeHole(0.015, 0.002, 0.004)
    frames = pipe_edge(part, theta[order], inner=inner)
    expected = chamfer_path(frames, Chamfer(0.3e-3), 0.002, nodes=pipe_edge(part, one_turn(512), inner=inner))
    np.testing.assert_allclose(path.centre[order], expected.centre, atol=1e-9)


def test_selectors(pipe):
    chains = cad_edges.sharp_chains(pipe)
    assert len(cad_select.select(chains, "all")) == 6
    assert len(cad_select.select(chains, "inner")) == 1
    assert len(cad_select.select(chains, "edge:1, edge:3")) == 2
    with pytest.raises(step.CadFault, match="selects no"):
        cad_select.select(chains, "edge:99")
    with pytest.raises(step.CadFault, match="selects nothing"):
        cad_select.select(chains, "top")
