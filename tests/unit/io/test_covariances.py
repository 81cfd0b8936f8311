"""Covariances of a library entry: sound ones are read, others told in words."""

import pytest

from cutwise.io import library
from cutwise.spec.faults import ScenarioFault

ENTRY = """
name: mine
describes: for a test
values:
  K_tc: {{value: 800 N/mm^2, standard_error: 8 N/mm^2, status: measured, covariance: c, source: slots.csv}}
  K_te: {{value: 16 N/mm, standard_error: 1 N/mm, status: measured, covariance: c, source: slots.csv}}
  list: {{value: [1, 2], status: measured, source: slots.csv}}
covariances:
  c: {{of: {of}, as: {kind}, degrees_of_freedom: 3, matrix: {matrix}, unit: [Pa, N/m]}}
measured: {{kind: cutting, rows: 5}}
"""


def read(tmp_path, of="[K_tc, K_te]", kind="value", matrix="[[4.0, -1.0], [-1.0, 1.0]]"):
    file = tmp_path / "mine.yaml"
    file.write_text(ENTRY.format(of=of, kind=kind, matrix=matrix))
    return library.read_entry(file, "mine.yaml", "materials")


def test_a_sound_one(tmp_path):
    assert read(tmp_path).name == "mine"
    assert read(tmp_path, of="['list[0]', 'list[1]']").name == "mine"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"of": "[K_tc, K_rc]"}, "mine.yaml:9:.*: covariances.c.of: K_rc is no value of this entry"),
        ({"of": "['list[0]', 'list[2]']"}, "list\\[2\\] is no value"),
        ({"kind": "inverse"}, '"inverse" is not one of value, reciprocal, log'),
        ({"matrix": "[[4.0, -1.0], [1.0, 1.0]]"}, "not symmetric"),
        ({"matrix": "[[4.0, -3.0], [-3.0, 1.0]]"}, "not positive semi-definite"),
        ({"matrix": "[[4.0, -1.0]]"}, "is 1x2; 2 values need 2 rows"),
        ({"matrix": "[[4.0, x], [x, 1.0]]"}, "not a square of numbers"),
        ({"matrix": "[[4.0, .nan], [.nan, 1.0]]"}, "finite"),
    ],
)
def test_what_can_be_wrong(tmp_path, given, said):
    with pytest.raises(ScenarioFault, match=said):
        read(tmp_path, **given)


def test_all_faults_at_once(tmp_path):
    with pytest.raises(ScenarioFault) as caught:
        read(tmp_path, of="[K_rc, K_ac]", kind="x", matrix="[[1.0]]")
    assert len(caught.value.faults) == 4
