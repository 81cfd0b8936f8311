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


def test_a_wrong_name_is_answered_with_the_right_one(examples):
    result = cutwise.simulate(cutwise.load(examples / "drill_robot.yaml", {"operation.feed_per_rev": "0.08 mm"}))
    with pytest.raises(KeyError) as caught:
        result.measures["thrust_maxx"]
    assert str(caught.value).startswith('no measure "thrust_maxx"; did you mean thrust_max? (')
    assert "thrust_maxx" not in result.measures
    with pytest.raises(KeyError, match='no stage "surfaces"; did you mean surface'):
        result["surfaces"]


def test_a_check_imports_its_own_process_only(examples):
    """Row 42: scipy, xarray, pandas, matplotlib and four other processes took half of the time of a check."""
    code = (
        "import sys\nfrom cutwise.app.cli import main\n"
        f"sys.argv = ['cutwise', 'check', r'{examples / 'deburr_compliant_spindle.yaml'}']\n"
        "try:\n    main()\nexcept SystemExit as left:\n    assert left.code == 0\n"
        "heavy = ('scipy.interpolate._interpolate', 'scipy.optimize._optimize', 'pandas', 'matplotlib', 'xarray.core')\n"
        "print([name for name in heavy if name in sys.modules])\n"
        "used = lambda name: type(sys.modules.get(name)).__name__ not in ('NoneType', '_LazyModule')\n"
        "print([name for name in ('milling', 'drilling', 'chamfer', 'machine') if used(f'cutwise.process.{name}')])\n"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.splitlines()[-2:] == ["[]", "[]"]
