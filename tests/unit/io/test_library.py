"""Library look-up."""

import pytest

from cutwise.io import library
from cutwise.spec.faults import ScenarioFault


def test_a_shelf_lists_its_entries_the_default_first():
    shelf = library.shelf("spindles")
    assert list(shelf) == ["default", "berselli2016", "prototype"]
    assert shelf["berselli2016"].describes.startswith("pneumatic compliant spindle of Berselli et al. 2016")


def test_an_entry_knows_text_status_and_source_of_its_values():
    values = {key: (text, origin.status) for key, text, origin in library.entry("spindles", "berselli2016").origins()}
    assert values["piston_force"] == ("7.70 N", "paper")
    assert values["piston_arm"] == ("80 mm", "assumed")


def test_what_is_not_there_is_said_with_what_is():
    with pytest.raises(ScenarioFault, match="there are: default, berselli2016"):
        library.entry("spindles", "nonesuch")
    with pytest.raises(ScenarioFault, match=r"did you mean spindles\?"):
        library.shelf("spindle")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is no library entry; it needs name, describes and values"),
        ("- a", "is no library entry"),
        ("name: a\n", "values: missing"),
        ("name: a\nvalue: {a: 3}\nvalues: {a: 3}\n", "value: unknown key; a library entry has name, describes, values"),
        ("values: {a: {value: 3, status: guess}}\n", '"guess" is not one of'),
    ],
)
def test_faults_of_an_own_file(tmp_path, content, message):
    path = tmp_path / "mine.yaml"
    path.write_text(content)
    with pytest.raises(ScenarioFault) as caught:
        library.read_entry(path, "mine.yaml", "tools")
    assert message in str(caught.value)
