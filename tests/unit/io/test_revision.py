"""A value replaced in the bare values of a scenario is a value replaced in its text."""

import pytest

from cutwise.io import revision
from cutwise.io.revision import revisions
from cutwise.io.scenario import load, read_document
from cutwise.spec import fields
from cutwise.spec.faults import ScenarioFault, dotted

EXAMPLES = (
    "chamfer_compliant_spindle", "deburr_compliant_spindle", "drill_robot", "machine_error_budget", "machine_pocket",
    "mill_pocket", "mill_pocket_stock",
)  # fmt: skip


@pytest.mark.parametrize("name", EXAMPLES)
def test_both_ways_give_the_same_scenario(examples, monkeypatch, name):
    scenario = load(examples / f"{name}.yaml")
    amounts = {
        dotted(path): tuple(1.01 * v for v in value) if isinstance(value, tuple) else 1.01 * value
        for path, info, value in fields.leaves(scenario)
        if fields.dimension(info) and revision._is_amount(value)
    }
    fast = revisions(scenario)
    monkeypatch.setattr(revision, "_replaceable", lambda *_: [])
    slow = revisions(scenario)
    for key, value in amounts.items():
        found = []
        for revised in (slow, fast):
            try:
                one = revised({key: value})
                found.append((one, one.origins.get(key) and one.origins[key].text))
            except ScenarioFault as fault:
                found.append(str(fault))
        assert found[0] == found[1], key


def test_most_quantities_need_no_text(examples, monkeypatch):
    """And what needs it still works: a word, a library entry, a key that is new."""
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    revised = revisions(scenario)
    assert revised({"spindle.library": "default"}).spindle != scenario.spindle
    assert revised({"operation.milling": "up"}).operation.milling == "up"
    assert revised({"operation.tolerance": "0.1 mm"}).operation.tolerance == pytest.approx(1e-4)
    monkeypatch.setattr(revision, "read_document", None)
    assert revised({"spindle.pressure": "4 bar", "operation.feed": 0.07}).operation.feed == 0.07
    assert revised({"spindle.pressure": "4 bar"}).spindle.pressure == pytest.approx(4e5)


def test_a_refused_value_is_told_with_its_key(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    with pytest.raises(ScenarioFault) as caught:
        revisions(scenario)({"operation.feed": "80"})
    assert str(caught.value).startswith('overrides["operation.feed"]: 80 has no unit')
    with pytest.raises(ScenarioFault, match=r"values\[\"operation.fed\"\]: unknown key; did you mean operation.feed\?"):
        revisions(scenario, 'values["{}"]')({"operation.fed": "80 mm/s"})


def test_overrides_may_be_a_mapping(examples):
    file = examples / "deburr_compliant_spindle.yaml"
    given = load(file, {"operation.feed": "60 mm/s", "part.slices": 2})
    assert given == load(file, ["operation.feed=60 mm/s", "part.slices=2"])
    document = given.document()
    assert read_document(document) == given
