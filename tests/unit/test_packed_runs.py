"""Run files are packed, and never so much that they would not open again."""

import numpy as np
import pytest
import xarray as xr

from cutwise import run_file


@pytest.fixture(scope="module")
def tree():
    heights = np.zeros((300, 200), np.float32)
    heights[100:] = -0.01
    return xr.DataTree.from_dict({"stock": xr.Dataset({"height": (("y", "x"), heights), "few": ("n", np.arange(3.0))})})


def test_long_arrays_are_packed_and_come_back_as_they_were(tree):
    content = run_file.written(tree)
    assert len(content) < 0.2 * tree["stock"]["height"].nbytes
    back = run_file.tree_of(run_file.sealed(content))
    assert back.identical(tree)


def test_a_file_that_would_unpack_to_more_than_is_opened_stays_unpacked(tree, monkeypatch):
    packed = len(run_file.written(tree))
    monkeypatch.setattr(run_file, "_MUCH", 1.0)
    monkeypatch.setattr(run_file, "_SWOLLEN", 0.5 * tree["stock"]["height"].nbytes / packed)
    content = run_file.written(tree)
    assert len(content) > tree["stock"]["height"].nbytes
    assert run_file.tree_of(run_file.sealed(content)).identical(tree)
