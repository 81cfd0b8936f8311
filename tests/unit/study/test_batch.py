"""Independent cases in one process or several: the same, in order, with what failed among them."""

import pytest

from cutwise import load
from cutwise.study.batch import batch
from cutwise.study.case import cases
from cutwise.study.sensitivity import variants

MANY = [{"operation.feed": f"{feed} mm/s"} for feed in (60, 80, -3, 100)]


@pytest.fixture(scope="module")
def scenario(examples):
    return load(examples / "deburr_compliant_spindle.yaml")


def test_cases_come_in_their_order(scenario):
    shares = []
    found = list(batch(scenario, MANY, coarse=True, progress=shares.append))
    evaluate = cases(scenario, coarse=True)
    assert [one.measures for one in found] == [evaluate(values).measures for values in MANY]
    assert "impossible" in str(found[2].failure)
    assert shares == [0.25, 0.5, 0.75, 1.0]
    assert list(batch(scenario, [])) == []


@pytest.mark.slow
def test_no_number_depends_on_the_processes(scenario):
    one, two = (list(batch(scenario, MANY, coarse=True, jobs=jobs)) for jobs in (1, 2))
    assert [(case.outcome, str(case.failure)) for case in one] == [(case.outcome, str(case.failure)) for case in two]
    assert variants(scenario, jobs=2) == variants(scenario)
