"""The public names, and that importing the package costs nothing."""

import subprocess
import sys

import pytest

import cutwise


def test_import_is_lazy():
    code = (
        "import sys, cutwise\n"
        "heavy = {'numba', 'pint', 'xarray', 'pydantic', 'numpy', 'scipy', 'matplotlib'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "cutwise.load\n"
        "heavy = {'numba', 'xarray', 'scipy', 'matplotlib', 'h5py'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_names():
    assert cutwise.load.__module__ == "cutwise.io.scenario"
    assert set(dir(cutwise)) == set(cutwise.__all__)
    with pytest.raises(AttributeError, match="no attribute 'lod'"):
        cutwise.lod  # noqa: B018
