"""The JSON schema admits what the loader admits, and complains about what it refuses."""

import copy
from pathlib import Path

import jsonschema
import pytest

from cutwise.io.tree import compose
from cutwise.spec.kinds import KINDS
from cutwise.spec.schema import schema

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*.yaml"))


@pytest.fixture(scope="module")
def validator():
    found = schema()
    jsonschema.Draft202012Validator.check_schema(found)
    return jsonschema.Draft202012Validator(found)


@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("requirements={surface_error_max: {max: 0.05 mm}, fraction_ideal: {min: 0.9}}",),
        ("operation.path_error={amplitude: 0.2 mm, frequency: 2 Hz}", "spindle.gravity=-y"),
        ("operation.path_error={columns: {'t [s]': [0, 1], 'error [mm]': [0, 1]}}", "spindle.gravity=[0, 3, 4]"),
        ("part.burr.height={mean: 1 mm, deviation: 0.1 mm, correlation_length: 5 mm, seed: 3}",),
    ],
)
def test_documents_are_valid(validator, scenario_with, overrides):
    validator.validate(scenario_with(*overrides).document())


@pytest.mark.parametrize(
    ("key", "value", "valid"),
    [
        ("feed", "80 mm/s", True),
        ("feed", {"value": "80 mm/s", "status": "paper", "source": "x"}, True),
        ("feed", 80, False),
        ("fed", "80 mm/s", False),
        ("milling", "sideways", False),
        ("path_error", "error.csv", True),
        ("path_error", {"table": "error.csv"}, True),
        ("path_error", "maybe", False),
    ],
)
def test_while_typing(validator, scenario_with, key, value, valid):
    document = copy.deepcopy(scenario_with().document())
    document["operation"][key] = value
    assert validator.is_valid(document) == valid


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_valid_as_they_are_written(validator, file):
    tree, _ = compose(file.read_text(encoding="utf-8"), file.name)
    validator.validate(tree.plain())


@pytest.mark.parametrize(
    ("cell", "valid"),
    [
        ({"engagement": "wall"}, True),
        ({"surface": "wall"}, True),
        ({"motion": "robot"}, False),
        ({"engagement": "w"}, False),
    ],
)
def test_a_process_or_slots_that_tell_it(cell, valid):
    tree, _ = compose((EXAMPLES[0].parent / "cell_robot_wall.yaml").read_text(encoding="utf-8"), "x")
    assert jsonschema.Draft202012Validator(schema("mill")).is_valid({**tree.plain(), "cell": cell}) == valid


def test_library_values_may_be_left_out(validator, scenario_with):
    document = scenario_with().document()
    document["spindle"] = {"library": "default"}
    validator.validate(document)


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_is_described(kind):
    for name, definition in schema(kind)["$defs"].items():
        for key, value in definition.get("properties", {}).items():
            assert "description" in value or name == "Sourced", (name, key)
