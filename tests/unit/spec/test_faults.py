"""Faults as the engineer reads them."""

from hypothesis import given
from hypothesis import strategies as st

from cutwise.spec.faults import Fault, ScenarioFault, dotted, split_dotted

names = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]*", fullmatch=True)
paths = st.tuples(names, st.lists(names | st.integers(0, 99), max_size=4)).map(lambda parts: (parts[0], *parts[1]))


@given(paths)
def test_a_dotted_key_is_split_into_its_path(path):
    assert split_dotted(dotted(path)) == path


def test_one_line_each_and_the_number_of_faults():
    fault = ScenarioFault(
        [
            Fault(("operation", "feed"), "80 has no unit", 12, 9, "deburr.yaml"),
            Fault(("tool", "diametre"), "unknown key; did you mean tool.diameter?", 19, 3, "deburr.yaml"),
        ]
    )
    assert str(fault) == (
        "deburr.yaml:12:9: operation.feed: 80 has no unit\n"
        "deburr.yaml:19:3: tool.diametre: unknown key; did you mean tool.diameter?\n"
        "2 faults, nothing was run"
    )


def test_an_override_names_its_key_once():
    assert str(Fault(("operation", "feed"), "no unit", file="--set operation.feed")) == "--set operation.feed: no unit"


def test_one_fault_is_counted_in_the_singular():
    assert str(ScenarioFault([Fault((), "no such file", file="a.yaml")])).endswith("\n1 fault, nothing was run")
