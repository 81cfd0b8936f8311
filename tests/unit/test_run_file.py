"""The seal of a run file: damage is told before a reader of HDF5 meets it."""

import io

import h5py
import numpy as np
import pytest
import xarray as xr

from cutwise import run_file
from cutwise.run_file import DamagedRun, has_seal, make_sure, sealed, tree_of


@pytest.fixture(scope="module")
def content():
    tree = xr.DataTree.from_dict({"motion": xr.Dataset({"x": ("time", np.arange(50.0))})})
    tree.attrs = {"scenario": "{}"}
    stream = io.BytesIO()
    tree.to_netcdf(stream, engine="h5netcdf")
    return sealed(stream.getvalue())


def test_sealed_files_open_everywhere(content, tmp_path):
    assert has_seal(content)
    assert tree_of(content)["motion/x"].sum() == 1225.0
    (tmp_path / "run.nc").write_bytes(content)
    with h5py.File(tmp_path / "run.nc") as file:
        assert file["motion/x"][3] == 3.0
    with xr.open_datatree(tmp_path / "run.nc", engine="h5netcdf") as tree:
        assert tree.attrs["scenario"] == "{}"


@pytest.mark.parametrize("place", [10, 500, 2000, -200])
def test_one_changed_bit_is_told(content, place, monkeypatch):
    damaged = bytearray(content)
    damaged[place] ^= 4
    monkeypatch.setattr(run_file, "_opened", lambda _: pytest.fail("HDF5 met it"))
    with pytest.raises(DamagedRun, match="checksum"):
        tree_of(bytes(damaged))


def test_a_file_without_a_seal_is_tried_in_another_process(content, monkeypatch):
    bare = content.rpartition(b"\ncutwise run file")[0]
    assert not has_seal(bare)
    make_sure(bare)
    assert tree_of(bare)["motion/x"].size == 50
    monkeypatch.setattr(run_file, "_opened", lambda _: pytest.fail("HDF5 met it in this process"))
    with pytest.raises(DamagedRun, match="not a run file"):
        tree_of(bare[: len(bare) // 2])


def test_an_array_that_is_larger_than_the_file_could_hold():
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        file.create_dataset("motion/x", (10**10,), dtype="f4", chunks=(1000,))  # 40 GB of nothing in 10 kB
    with pytest.raises(DamagedRun):
        tree_of(stream.getvalue())
