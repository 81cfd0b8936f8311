"""operation.feed replaces the F of what cuts, and of nothing else."""

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process.assemble_mill import program_path, read_program
from cutwise.process.recipes import simulate


@pytest.fixture
def scenario(examples, tmp_path):
    program = tmp_path / "short.nc"
    program.write_text("G21 G90 G17\nS8000 M3\nG0 X0 Y0 Z5\nG1 Z-5 F300\nG1 X20 F2400\nG1 Z2 F600\nG1 X30\nM2\n")
    return load(examples / "mill_pocket.yaml", [f"program={program}", "operation.feed=20 mm/s", "numerics.substeps=4"])


def test_plunges_and_moves_above_the_material_keep_their_feed(scenario):
    path = program_path(scenario, read_program(scenario))
    feed = dict(
        zip(path.source[np.isfinite(path.feed)].tolist(), path.feed[np.isfinite(path.feed)].tolist(), strict=True)
    )
    assert feed == pytest.approx({4: 5e-3, 5: 20e-3, 6: 10e-3, 7: 10e-3})


def test_the_run_says_so(scenario):
    assert "3 other feed moves" in simulate(scenario).notes["feed"]
