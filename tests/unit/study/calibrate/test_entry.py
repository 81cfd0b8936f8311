"""What a new entry takes over from the one that it completes: values, and the covariances of those that stay."""

import numpy as np
from ruamel.yaml import YAML

from cutwise.io import library
from cutwise.study.calibrate import entry

FANUC = YAML(typ="safe", pure=True).load(library.entry("robots", "fanuc_r2000ic").file)


def test_covariances_of_values_that_stay_come_along():
    kept = entry._kept(FANUC, {"errors": {"value": {"bodies": []}, "status": "measured"}}, ())
    assert kept == FANUC["covariances"]


def test_those_of_replaced_values_do_not():
    assert entry._kept(FANUC, {"joint_stiffness": {"value": [], "status": "measured"}}, ()) == {}
    assert entry._kept(FANUC, {}, ("joint_stiffness",)) == {}


def test_rows_and_columns_of_what_is_left():
    base = {"covariances": {"plant": {
        "of": ["x.J", "x.B", "y.J"], "as": ["value", "log", "value"], "unit": ["kg m^2", "", "kg m^2"],
        "matrix": [[1.0, 2.0, 3.0], [2.0, 5.0, 6.0], [3.0, 6.0, 9.0]], "degrees_of_freedom": 7,
    }}}  # fmt: skip
    kept = entry._kept(base, {"x": {"J": {"value": "1 kg m^2"}}}, ())["plant"]
    assert kept["of"] == ["x.B", "y.J"]
    assert (kept["as"], kept["unit"], kept["degrees_of_freedom"]) == (["log", "value"], ["", "kg m^2"], 7)
    assert np.array(kept["matrix"]).tolist() == [[5.0, 6.0], [6.0, 9.0]]


def test_sections_are_put_together_value_by_value():
    weak = {"x": {"J": {"value": 1}, "friction": {"a": {"value": 2}, "b": {"value": 3}}}, "y": {"J": {"value": 4}}}
    strong = {"x": {"J": {"value": 5}, "friction": {"a": {"value": 6}}}}
    assert entry._together(weak, strong) == {
        "x": {"J": {"value": 5}, "friction": {"a": {"value": 6}, "b": {"value": 3}}}, "y": {"J": {"value": 4}}
    }  # fmt: skip
