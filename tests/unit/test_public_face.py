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
    with pytest.raises(AttributeError, match="no attribute 'lod'; did you mean load"):
        cutwise.lod  # noqa: B018


def test_a_wrong_name_is_answered_with_the_right_one(examples):
    result = cutwise.simulate(cutwise.load(examples / "drill_robot.yaml", {"operation.feed_per_rev": "0.08 mm"}))
    with pytest.raises(KeyError) as caught:
        result.measures["thrust_maxx"]
    assert str(caught.value).startswith('no measure "thrust_maxx"; did you mean thrust_max? (')
    assert "thrust_maxx" not in result.measures
    with pytest.raises(KeyError, match='no stage "surfaces"; did you mean surface'):
        result["surfaces"]
    for wrong in (3, None, ""):  # seen to fail: 'int' object has no attribute 'endswith'
        with pytest.raises(KeyError, match="no measure"):
            result.measures[wrong]
    with pytest.raises(KeyError, match="there are cutting/thrust"):
        result.plot("Thrust")
    with pytest.raises(KeyError, match="no single column"):
        result.plot(3)
    with pytest.raises(TypeError, match="ax is a int; expected axes"):
        result.plot("cutting/thrust", ax=5)
    with pytest.raises(ValueError, match="height is 600px"):
        result.view(height="600px")


@pytest.mark.parametrize("source", [None, 3, [1], b"x", float("nan"), True])
def test_what_is_no_scenario_is_told(source):
    for call in (cutwise.load, cutwise.simulate):
        with pytest.raises(TypeError, match="a scenario is a path, a mapping, or what load gave"):
            call(source)


def test_a_scenario_answers_in_and_does_not_change(examples):
    """Seen to fail in silence: ``"spindle.pressure" in scenario`` was False; Python looked among pairs of names and values."""
    scenario = cutwise.load(examples / "deburr_compliant_spindle.yaml")
    assert "spindle.pressure" in scenario
    assert "requirements.surface_error_max.max" in scenario
    for wrong in ("spindle.presure", "", None, 3, "a." * 500):
        assert wrong not in scenario
    with pytest.raises(TypeError, match="a scenario does not change"):
        scenario["spindle.pressure"] = "4 bar"


def test_a_sweep_over_a_text_or_nothing_is_told(examples):
    """Seen to fail: "4 bar" was swept letter by letter."""
    scenario = cutwise.load(examples / "deburr_compliant_spindle.yaml")
    with pytest.raises(cutwise.ScenarioFault, match="expected a list of values") as caught:
        cutwise.sweep(scenario, {"spindle.pressure": "4 bar", "operation.feed": 3.0})
    assert len(caught.value.faults) == 2
    with pytest.raises(TypeError, match="values are lists by their keys"):
        cutwise.sweep(scenario, None)


def test_a_key_of_thousands_of_steps_is_a_fault(examples):
    """Seen to fail: a RecursionError, on the command line too."""
    with pytest.raises(cutwise.ScenarioFault, match="nested too deeply to be a key"):
        cutwise.load(examples / "deburr_compliant_spindle.yaml", {"a." * 3000 + "b": "1"})


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
