"""Arrays as CSV and VTK."""

import numpy as np
import pytest
import xarray as xr

from cutwise.io.export import export


@pytest.fixture
def stages():
    x, y, z = np.linspace(0, 1, 2), np.linspace(0, 2, 3), np.linspace(0, 3, 4)
    position = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)
    volume = xr.Dataset(
        {
            "position": (("X", "Y", "Z", "axis"), position, {"units": "m"}),
            "error": (("X", "Y", "Z", "axis"), 1e-6 * position, {"units": "m"}),
            "size": (("X", "Y", "Z"), position.sum(axis=-1), {"units": "m"}),
        },
        {"X": x, "Y": y, "Z": z, "axis": ["x", "y", "z"]},
    )
    time = xr.Dataset({"force": (("time", "body"), np.arange(4.0).reshape(2, 2), {"units": "N"})},
                      {"time": ("time", [0.0, 0.5], {"units": "s"}), "body": ["table", "bed"]})  # fmt: skip
    return xr.DataTree.from_dict({"volume": volume, "structure": time})


def test_tables_have_units_and_one_row_for_each_point(stages, tmp_path):
    written = {path.name: path for path in export(stages, tmp_path)}
    assert set(written) == {"volume_X_Y_Z.csv", "volume.vtk", "structure_time_body.csv"}
    lines = written["structure_time_body.csv"].read_text(encoding="utf-8").splitlines()
    assert lines == [
        "time [s], body, force [N]",
        "0.0, table, 0.0",
        "0.0, bed, 1.0",
        "0.5, table, 2.0",
        "0.5, bed, 3.0",
    ]
    volume = written["volume_X_Y_Z.csv"].read_text(encoding="utf-8").splitlines()
    assert len(volume) == 1 + 24
    assert volume[0].startswith("X, Y, Z, position_x [m], position_y [m]")


def test_grid_runs_with_x_fastest(stages, tmp_path):
    export(stages, tmp_path)
    lines = (tmp_path / "volume.vtk").read_text(encoding="utf-8").splitlines()
    assert lines[3:6] == ["DATASET STRUCTURED_GRID", "DIMENSIONS 2 3 4", "POINTS 24 double"]
    points = np.array([list(map(float, line.split())) for line in lines[6:30]])
    assert points[1].tolist() == [1.0, 0.0, 0.0]
    assert points[2].tolist() == [0.0, 1.0, 0.0]
    start = lines.index("VECTORS error double") + 1
    errors = np.array([list(map(float, line.split())) for line in lines[start : start + 24]])
    assert errors == pytest.approx(1e-6 * points)
    start = lines.index("SCALARS size double 1") + 2
    assert np.array(lines[start : start + 24], float) == pytest.approx(points.sum(axis=1))
