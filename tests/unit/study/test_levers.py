"""What may be turned: every example offers settings that it can read, each in the quantity of its key."""

from pathlib import Path

import pytest

from cutwise.io.scenario import load
from cutwise.spec import fields
from cutwise.spec.faults import dotted, split_dotted
from cutwise.spec.machine_scenario import MachineScenario
from cutwise.study.advice import consult
from cutwise.study.levers import levers_of
from cutwise.study.trials import Budget

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*.yaml"))


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_levers_of_every_example_are_ordered_limits_of_quantities(file):
    scenario = load(file)
    for lever in levers_of(scenario):
        assert lever.low < lever.high, lever
        info = fields.field_at(type(scenario), split_dotted(lever.key))
        assert info is not None, lever
        assert lever.whole or fields.dimension(info) == lever.dimension, lever  # a number of things has none


@pytest.mark.parametrize("key", ["axial_depth", "radial_depth"])
def test_a_word_after_a_list_of_forces_is_a_key_of_the_section_that_stands_in_its_place(key):
    """`load.force` is three forces or a section: its depths are lengths, not entries of the list."""
    info = fields.field_at(MachineScenario, ("load", "force", key))
    assert fields.dimension(info) == "length"
    assert fields.dimension(fields.field_at(MachineScenario, ("load", "force", 0))) == "force"
    assert fields.field_at(MachineScenario, ("load", "force", "no_such_key")) is None


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_no_lever_is_offered_that_turns_nothing(file):
    """A setting that the scenario tells as not used, or of a section that another stands for, is no advice."""
    scenario = load(file)
    idle = {dotted((*before, *path)) for before, spec in fields.specs(scenario) for path, _ in spec.unused()}
    for lever in levers_of(scenario):
        assert not any(lever.key == key or lever.key.startswith((f"{key}.", f"{key}[")) for key in idle), lever
        section = split_dotted(lever.key)[0]
        assert getattr(scenario, str(section)) is not None, lever


def test_the_depths_of_a_cut_are_no_levers_where_the_stock_decides_them(examples):
    with_stock = {lever.key for lever in levers_of(load(examples / "machine_pocket.yaml"))}
    assert not with_stock & {"load.force.axial_depth", "load.force.radial_depth", "path.feed"}
    without = load(examples / "machine_pocket.yaml", ["stock=null", "load.force.axial_depth=5 mm"])
    assert "load.force.axial_depth" in {lever.key for lever in levers_of(without)}


def test_a_span_that_the_budget_ends_names_only_what_was_tried(examples):
    advice = consult(load(examples / "machine_pocket.yaml"), budget=Budget(4))
    assert not advice.complete
    assert not any("of 13 values" in sentence for sentence in advice.sentences)
