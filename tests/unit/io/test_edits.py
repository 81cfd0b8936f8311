"""Edits by place: a changed file loads as the scenario with the same --set, and everything else stays to the letter."""

import difflib
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise import units
from cutwise.io.edits import edited, with_edits
from cutwise.io.scenario import parse
from cutwise.io.tree import compose
from cutwise.spec import fields
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.faults import ScenarioFault, split_dotted

TRIALS = 8  # of each example


def change(text, **edits):
    return edited(text, {key.replace("__", "."): value for key, value in edits.items()}, DeburringScenario)


def lines(before, after):
    """Lines taken away, and lines that came."""
    found = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[:2] in ("- ", "+ ")]
    return [line[2:] for line in found if line[0] == "-"], [line[2:] for line in found if line[0] == "+"]


@pytest.mark.parametrize(("text", "edits", "after"), [
    ("a: 5 bar   # why\n", {"a": "4 bar"}, "a: 4 bar   # why\n"),
    ("a: '5 bar'\nb: 1\n", {"a": "4 bar"}, "a: 4 bar\nb: 1\n"),
    ("a: {value: 5 bar, status: measured, source: me}\n", {"a": "4 bar"}, "a: {value: 4 bar, status: measured, source: me}\n"),
    ("s:\n  a:\n    value: 5 bar\n    status: user\n", {"s.a": "4 bar"}, "s:\n  a:\n    value: 4 bar\n    status: user\n"),
    ("a: [1 mm, 2 mm]\n", {"a": "[3 mm, 2 mm]"}, "a: [3 mm, 2 mm]\n"),
    ("a: [1 mm, 2 mm]\n", {"a[1]": "3 mm"}, "a: [1 mm, 3 mm]\n"),
    ("a:\n- 1 mm\n- 2 mm # k\nb: 1\n", {"a": "[3 mm]"}, "a: [3 mm] # k\nb: 1\n"),
    ("s:\n    a: 1 # one\n    b: 2 # two\n\nt: 3\n", {"s.c": "4"}, "s:\n    a: 1 # one\n    b: 2 # two\n    c: 4\n\nt: 3\n"),
    ("s: {a: 1, b: {c: 2}}\n", {"s.b.d": "4"}, "s: {a: 1, b: {c: 2, d: 4}}\n"),
    ("s: {}\n", {"s.a.b": "4"}, "s: {a: {b: 4}}\n"),
    ("s: {a: 1, }\n", {"s.b": "2"}, "s: {a: 1, b: 2, }\n"),
    ("a: 1", {"s.b": "2"}, "a: 1\ns:\n  b: 2\n"),
    ("a: 1\n# the end\n", {"s": "2"}, "a: 1\n# the end\ns: 2\n"),
    ("s:\nt: 1\n", {"s.a": "2"}, "s:\n  a: 2\nt: 1\n"),
    ("s: # why\n  a: # open\nt: 1\n", {"s.a": "2"}, "s: # why\n  a: 2 # open\nt: 1\n"),
    ("a: 1\r\ns:\r\n  b: 2 # k\r\nc: 3\r\n", {"s.d": "4"}, "a: 1\r\ns:\r\n  b: 2 # k\r\n  d: 4\r\nc: 3\r\n"),
    ("t: |\n  one\n  two\nb: 1\n", {"t": "three"}, "t: three\nb: 1\n"),
    ("s:\n  t: |\n    one\nb: 1\n", {"s.c": "3"}, "s:\n  t: |\n    one\n  c: 3\nb: 1\n"),
    ("a: &x 5 bar\n", {"a": "4 bar"}, "a: &x 4 bar\n"),
    ("a: x\n", {"a": "yes: no"}, None),  # a mapping where --set reads one too
    ("a: x\n", {"a": '"#1, {2}"'}, 'a: "#1, {2}"\n'),
    ("s: {a: x}\n", {"s.a": "one, two"}, 's: {a: "one, two"}\n'),  # plain it would end at the comma
    ("a: x\n", {"a": "é µm ü 刀"}, "a: é µm ü 刀\n"),
    ("刀: x # ü\nb: 1\n", {"b": "2"}, "刀: x # ü\nb: 2\n"),
])  # fmt: skip
def test_where_a_value_is_written(text, edits, after):
    changed = edited(text, edits, DeburringScenario)
    if after is not None:
        assert changed == after
    assert compose(changed, "")[0] is not None


def test_json_stays_json():
    import json

    text = '{"a": "5 bar", "s": {"b": 1}}'
    changed = edited(text, {"a": "4 bar", "s.c": "2 mm", "d": "3"}, DeburringScenario, is_json=True)
    assert json.loads(changed) == {"a": "4 bar", "s": {"b": 1, "c": "2 mm"}, "d": 3}


@pytest.mark.parametrize(("text", "edits", "why"), [
    ("a: &x 5 bar\nb: *x\n", {"b": "4 bar"}, "behind an alias"),
    ("a: &x 5 bar\nb: *x\n", {"a": "4 bar"}, "without changing another one"),
    ("a: 5\n", {"a.b": "4 bar"}, "a is no section here"),
    ("a: [1, 2]\n", {"a[2]": "3"}, "there is no such entry"),
    ("a: 1\n", {"a": ""}, "a value is needed"),
    ("a: 1\n", {"a": "[1"}, "bracket"),
    ("", {"a": "1"}, "the text is empty"),
])  # fmt: skip
def test_what_cannot_be_written_is_refused(text, edits, why):
    with pytest.raises(ScenarioFault, match=why):
        edited(text, edits, DeburringScenario)


def test_all_refusals_at_once():
    with pytest.raises(ScenarioFault) as caught:
        edited("a: 5\nb: 1\n", {"a.b": "1", "b": "2", "a.c": "1"}, DeburringScenario)
    assert [fault.path for fault in caught.value.faults] == [("a", "b"), ("a", "c")]


WORDS = st.text("ab #:'\"{}[],&*!|>%@`-?µ\t1.", min_size=1, max_size=8)


@given(st.lists(st.tuples(st.sampled_from("abc"), WORDS), max_size=4), st.booleans(), WORDS)
@settings(max_examples=200, deadline=None)
def test_any_text_is_read_back_as_it_was_given(entries, flow, value):
    """Whatever is typed either stands in the file as --set reads it, or nothing is written."""
    import json

    laid = [f"{key}{i}: {json.dumps(text)}" for i, (key, text) in enumerate(entries)]
    text = (
        f"s: {{{', '.join(laid)}}}\nz: 1\n" if flow else "s:\n" + "".join(f"  {one}  # k\n" for one in laid) + "z: 1\n"
    )
    try:
        changed = edited(text, {"s.b1": value}, DeburringScenario)
    except ScenarioFault:
        return
    before, after = compose(text, "")[0].plain(), compose(changed, "")[0].plain()
    assert after.pop("s") == {**(before.pop("s") or {}), "b1": compose(value.strip(), "")[0].plain()}
    assert after == before


def trials(folder, seed=20261130):
    rng = random.Random(seed)
    for file in sorted(folder.glob("*.yaml")):
        scenario = parse(file.read_text(), str(file), folder=folder, title=file.stem)
        keys = []
        for key in scenario.origins:
            info = fields.field_at(type(scenario), split_dotted(key))
            dimension = fields.dimension(info) if info is not None else None
            try:
                value = scenario[key]
            except KeyError:
                continue
            if isinstance(value, float) and dimension is not None:
                keys.append((key, units.text(value * 1.0001 if value else 1e-9, dimension)))
        for key, value in rng.sample(keys, min(TRIALS, len(keys))):
            yield file, key, value


def test_the_examples_change_by_one_line(examples):
    tried = 0
    for file, key, value in trials(examples):
        text = file.read_text()
        try:
            wanted = parse(text, file.name, {key: value}, folder=examples, title=file.stem)
        except ScenarioFault:  # beside others it would contradict itself
            continue
        changed = with_edits(text, file.name, {key: value}, folder=examples, title=file.stem)
        assert parse(changed, file.name, folder=examples, title=file.stem).model_dump() == wanted.model_dump()
        gone, came = lines(text, changed)
        assert len(gone) <= 1, (file.name, key, gone)
        assert 1 <= len(came) <= len(split_dotted(key)), (
            file.name,
            key,
            came,
        )  # an absent key brings the sections that it stands in
        tried += 1
    assert tried > 100


def test_a_value_that_the_scenario_refuses_changes_nothing(examples):
    file = examples / "deburr_compliant_spindle.yaml"
    for edits, why in (({"spindle.pressure": "4 kg"}, "not a unit of pressure"), ({"spindle.presure": "4 bar"}, "did you mean"),
                       ({"spindle.pressure": "4"}, "has no unit")):  # fmt: skip
        with pytest.raises(ScenarioFault, match=why):
            with_edits(file.read_text(), file.name, edits, folder=examples)


def test_several_edits_at_once(examples):
    file = examples / "deburr_compliant_spindle.yaml"
    edits = {"spindle.pressure": "4 bar", "requirements.cutting_power_mean.max": "100 W", "numerics.time_step": "10 us",
             "tool.flutes": "3"}  # fmt: skip
    changed = with_edits(file.read_text(), file.name, edits, folder=examples, title="d")
    found = parse(changed, file.name, folder=examples, title="d")
    assert (found["spindle.pressure"], found["tool.flutes"], found["numerics.time_step"]) == (4e5, 3, 1e-5)


def test_the_short_form_of_a_file_stays_short(examples):
    """Seen to fail: ``program.file``, as the page names the key, could not be saved where the text says ``program: a.nc``."""
    file = examples / "mill_pocket_stock.yaml"
    text = file.read_text()
    changed = with_edits(text, file.name, {"program.file": "bracket.ngc"}, folder=examples)
    assert changed == text.replace("program: mill_pocket.nc", "program: bracket.ngc") != text
