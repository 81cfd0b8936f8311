"""Scenario files: every fault at its place, all at once, in plain words; overrides, run files and reports."""

import json

import h5py
import pytest

from cutwise.io import library
from cutwise.io.scenario import load, parse
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.notices import notices

GOOD = """\
process: deburr
operation:
  feed: 80 mm/s
  spindle_speed: 40000 rpm
  preset: 2 mm
  duration: 0.6 s
  lead_in_time: 0.2 s
  clearance: 0.5 mm
  path_error: none
part:
  burr: {height: 1 mm, width: 1 mm}
  contact_length: 10 mm
tool: {library: berselli2016}
material: {library: berselli2016}
spindle: {library: berselli2016}
"""


def faults_of(text, *overrides, **options):
    with pytest.raises(ScenarioFault) as caught:
        parse(text, "deburr.yaml", overrides, **options)
    return [str(fault) for fault in caught.value.faults]


def written(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_all_faults_at_once_each_at_its_place():
    text = GOOD.replace("feed: 80 mm/s", "feed: 80").replace("tool: {library", "tool: {diametre: 8 mm, library")
    text = text.replace("preset: 2 mm", "preset: 2 bar\n  presett: 3 mm").replace(
        "clearance: 0.5 mm", "clearence: 0.5 mm"
    )
    assert faults_of(text) == [
        'deburr.yaml:3:9: operation.feed: 80 has no unit; write it as text with a unit, for example "80 mm/s"',
        'deburr.yaml:5:11: operation.preset: "bar" is not a unit of length, expected for example "2 mm"',
        "deburr.yaml:6:3: operation.presett: unknown key; did you mean operation.preset?",
        "deburr.yaml:9:3: operation.clearence: unknown key; did you mean operation.clearance?",
        "deburr.yaml:14:8: tool.diametre: unknown key; did you mean tool.diameter?",
    ]


def test_a_key_of_another_section_is_found():
    assert faults_of(GOOD + "feed: 3 mm/s\n") == ["deburr.yaml:16:1: feed: unknown key; did you mean operation.feed?"]
    assert faults_of(GOOD.replace("tool: {", "tool: {preset: 1 mm, "))[0].endswith("did you mean operation.preset?")


def test_a_missing_key_says_how_to_write_it_and_where_the_library_has_it():
    (fault,) = faults_of(GOOD.replace("  preset: 2 mm\n", ""))
    assert fault == "deburr.yaml:2:1: operation.preset: missing; write it, for example preset: 2 mm"
    faults = faults_of(GOOD.replace("spindle: {library: berselli2016}", "spindle: {stroke: 5 mm}"))
    assert (
        "deburr.yaml:15:1: spindle.pressure: missing; write it, for example pressure: 5 bar; or name a library entry "
        "with spindle.library: default, berselli2016, prototype"
    ) in faults
    (fault,) = faults_of(GOOD.replace("tool: {library: berselli2016}\n", ""))
    assert "tool: missing; write the section tool with diameter, flutes, helix; or name" in fault
    faults = faults_of(GOOD.replace("material: {library: berselli2016}", "material: {K_tc: 3 GPa}"))
    assert [fault.split(": ")[1] for fault in faults] == ["material.K_rc", "material.K_te", "material.K_re"]


def test_what_is_left_out_of_account_is_said(tmp_path):
    own = tmp_path / "own.yaml"
    entry = library.entry("spindles", "berselli2016").values.plain()
    lines = [f"  {key}: {value}" for key, value in entry.items() if key != "gravity"]
    own.write_text(GOOD.replace("spindle: {library: berselli2016}", "spindle:\n" + "\n".join(lines)), encoding="utf-8")
    assert any("hang upright" in text for text in notices(load(own)))
    assert not any("hang upright" in text for text in notices(parse(GOOD)))


def test_every_duplicate_key_is_reported():
    faults = faults_of(
        GOOD.replace("  feed: 80 mm/s\n", "  feed: 80 mm/s\n  feed: 3 mm/s\n  feed: 4 mm/s\n") + "part: 3\n"
    )
    assert [fault.split(": ", 1)[0] for fault in faults] == ["deburr.yaml:4:3", "deburr.yaml:5:3", "deburr.yaml:18:1"]
    assert faults[0].endswith("operation.feed: written twice, first in line 3; keep one")


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("", "", "is empty; a scenario has sections, start with: cutwise new deburr"),
        ("# only a comment\n", "", "is empty"),
        ("- a\n- b\n", "", "is a list"),
        ("word", "", "is a single value"),
        ("operation:\n\tfeed: 3\n", ":2:1", "a tab; indent with blanks"),
        ("operation: feed: 3\n", ":1:16", "a colon where none can be"),
        ('name: "a\n', ":2:1", "a quote that is opened before here is not closed"),
        ("name: [a\nb: 3\n", ":2:2", "a bracket that is opened before here is not closed"),
        ("name: a\n---\nname: b\n", ":2:1", "a second one begins here"),
        ("name: *a\n", ":1:7", "undefined alias"),
        ("[" * 5000, "", "nested too deeply"),
        ("name: &a [*a]\n", ":1:7", "this alias (*) stands inside of what it names"),
        ("name: !!python/name:os.system\n", ":1:7", "the tag !!python/name:os.system is not understood"),
        ("<<: {a: 3}\n", ":1:1", "<< is not understood here"),
        ("? [a]\n: 3\n", ":1:3", "a key must be a plain word"),
        ('{"process": "deburr",\n "part": }', ":2:2", "part.burr: missing"),
    ],
)
def test_what_is_no_scenario_is_said_in_plain_words(text, place, message):
    faults = [fault for fault in faults_of(text) if message in fault]
    assert faults
    assert faults[0].startswith(f"deburr.yaml{place}: ")


def test_aliases_that_multiply_are_stopped():
    lines = ["a: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"b{i}: &a{i + 1} [{', '.join([f'*a{i}'] * 10)}]" for i in range(9)]
    (fault,) = faults_of("\n".join(lines))
    assert "too large" in fault


def test_anchors_and_aliases_are_read():
    assert (
        parse(GOOD.replace("preset: 2 mm", "preset: &two 2 mm").replace("0.5 mm", "*two")).operation.clearance == 0.002
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (bytes(range(256)), "is a binary file, not text"),
        ("process: deburr".encode("utf-16"), "is UTF-16 text; save it as UTF-8"),
        (b"# ok\nname: \xe9t\xe9\n", ":2:7: byte 0xe9 is not UTF-8 text"),
        (b"\x89HDF\r\n\x1a\n rubbish", "is not a run file of cutwise"),
    ],
)
def test_files_that_are_no_text(tmp_path, content, message):
    path = written(tmp_path, "a.yaml", content)
    with pytest.raises(ScenarioFault, match="nothing was run") as caught:
        load(path)
    assert message in str(caught.value)


def test_missing_files_and_folders(tmp_path):
    written(tmp_path, "deburr.yaml", GOOD)
    with pytest.raises(ScenarioFault, match=r"no such file; did you mean deburr\.yaml\?"):
        load(tmp_path / "debur.yaml")
    with pytest.raises(ScenarioFault, match="is a folder"):
        load(tmp_path)


def test_a_byte_order_mark_and_windows_line_ends_are_fine(tmp_path):
    content = b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode()
    assert load(written(tmp_path, "edge.yaml", content)).name == "edge"


def test_overrides_are_read_as_yaml():
    scenario = parse(
        GOOD, overrides=["operation.feed=60 mm/s", "tool.flutes=12", 'name="a b"', "numerics.time_step=5 us"]
    )
    assert (scenario.operation.feed, scenario.tool.flutes, scenario.name) == (0.06, 12, "a b")
    assert scenario.numerics.time_step == 5e-6


def test_an_override_turns_a_scalar_into_a_section():
    overrides = ['operation.path_error.amplitude="0.2 mm"', "operation.path_error.frequency=2 Hz"]
    path_error = parse(GOOD, overrides=overrides).operation.path_error
    assert (path_error.amplitude, path_error.frequency) == (0.2e-3, 2.0)


def test_faults_of_overrides_name_the_override():
    overrides = ("operation.feed=80", "operation.fed=3 mm/s", "nonsense", "tool.helix=[", "part.burr.height=", "=3")
    faults = faults_of(GOOD, *overrides)
    assert 'overrides["operation.feed"]: 80 has no unit; write it as text with a unit, for example "80 mm/s"' in faults
    assert 'overrides["operation.fed"]: unknown key; did you mean operation.feed?' in faults
    assert 'overrides["nonsense"]: is not of the form dotted.key=value' in faults
    assert 'overrides["=3"]: is not of the form dotted.key=value' in faults
    assert any(fault.startswith('overrides["tool.helix"]: not YAML') for fault in faults)
    assert any(fault.startswith('overrides["part.burr.height"]: has no value') for fault in faults)
    assert len(faults) == 6


def test_values_with_a_source():
    scenario = parse(GOOD.replace("feed: 80 mm/s", "feed: {value: 80 mm/s, status: measured, source: stopwatch}"))
    assert scenario.operation.feed == 0.08
    assert scenario.origins["operation.feed"].source == "stopwatch"
    assert scenario.origins["operation.preset"].status == "user"
    section = GOOD.replace("{height: 1 mm, width: 1 mm}", "{value: {height: 1 mm, width: 1 mm}, status: measured}")
    assert parse(section).origins["part.burr.height"].status == "measured"
    faults = faults_of(GOOD.replace("feed: 80 mm/s", "feed: {value: 80, status: mesured, unit: mm/s}"))
    assert faults[1].startswith('deburr.yaml:3:29: operation.feed.status: "mesured" is not one of')
    assert faults[2].startswith("deburr.yaml:3:38: operation.feed.unit: unknown key beside value")


def test_library_entries():
    (fault,) = faults_of(GOOD.replace("spindle: {library: berselli2016}", "spindle: {library: berseli2016}"))
    assert fault == (
        'deburr.yaml:15:20: spindle.library: no entry "berseli2016" on the library shelf spindles; did you mean '
        "berselli2016? there are: default, berselli2016, prototype"
    )
    scenario = parse(GOOD.replace("spindle: {", "spindle: {piston_arm: 90 mm, "))
    assert scenario.spindle.piston_arm == 0.09
    assert scenario.origins["spindle.piston_arm"].status == "user"
    (fault,) = faults_of(GOOD.replace("spindle: {library: berselli2016}", "spindle: default"))
    assert 'to take the library entry "default", write spindle: {library: default}' in fault


def test_an_own_library_file_beside_the_scenario(tmp_path):
    own = "name: mine\ndescribes: my bur\nvalues:\n  diameter: {value: 6 mm, status: measured, source: calliper}\n"
    written(tmp_path, "bur.yaml", own + "  flutes: 12\n  helix: 25 deg\n  runout: 2 um\n")
    path = written(tmp_path, "s.yaml", GOOD.replace("tool: {library: berselli2016}", "tool: {library: ./bur.yaml}"))
    scenario = load(path)
    assert scenario.tool.diameter == 6e-3
    assert scenario.origins["tool.diameter"].source == "calliper"
    written(tmp_path, "bur.yaml", own + "  flute: 12\n  helix: 25\n  runout: 2 um\n")
    with pytest.raises(ScenarioFault) as caught:
        load(path)
    places = [(fault.file.rpartition("/")[2], fault.line, fault.path[-1]) for fault in caught.value.faults]
    assert places == [("bur.yaml", 5, "flute"), ("bur.yaml", 6, "helix")]
    (tmp_path / "bur.yaml").unlink()
    with pytest.raises(ScenarioFault, match=r"s.yaml:13:17: tool.library: .*bur.yaml: no such file"):
        load(path)


def test_tables_are_taken_into_the_scenario(tmp_path):
    written(tmp_path, "burr.csv", "w [mm], height [mm]\n0, 0.5\n30, 1.5\n60, 1\n")
    for given in ("{table: burr.csv}", "burr.csv"):
        text = GOOD.replace("height: 1 mm", f"height: {given}")
        scenario = load(written(tmp_path, "s.yaml", text))
        assert scenario.part.burr.height.points() == ((0.0, 0.03, 0.06), (0.0005, 0.0015, 0.001))
        assert scenario.document()["part"]["burr"]["height"] == {
            "columns": {"w [mm]": [0, 30, 60], "height [mm]": [0.5, 1.5, 1]},
            "file": "burr.csv",
        }
    with pytest.raises(ScenarioFault, match="table covers w = 0 to 60 mm, the run needs 0 to 80 mm"):
        load(tmp_path / "s.yaml", ["operation.duration=1 s"])
    (tmp_path / "burr.csv").unlink()
    with pytest.raises(ScenarioFault, match=r"s.yaml:11:18: part.burr.height: .*burr.csv: no such file"):
        load(tmp_path / "s.yaml")


def test_faults_of_a_table_stand_among_the_others(tmp_path):
    written(tmp_path, "burr.csv", "w [mm], height\n0, 0.5\n30, x\n")
    text = GOOD.replace("height: 1 mm", "height: burr.csv").replace("80 mm/s", "80")
    path = written(tmp_path, "s.yaml", text)
    with pytest.raises(ScenarioFault) as caught:
        load(path)
    faults = str(caught.value)
    assert "s.yaml:3:9: operation.feed: 80 has no unit" in faults
    assert "burr.csv:1:9: part.burr.height: column height has no unit" in faults
    assert 'burr.csv:3:5: part.burr.height: "x" is not a number' in faults
    assert "3 faults, nothing was run" in faults


def test_json_run_files_and_reports_hold_the_same_scenario(tmp_path):
    scenario = parse(GOOD, overrides=["name=edge"])
    document = json.dumps(scenario.document())
    assert load(written(tmp_path, "s.json", document)) == scenario
    with h5py.File(tmp_path / "run.nc", "w") as run:
        run.attrs["scenario"] = document
    assert load(tmp_path / "run.nc") == scenario
    report = (
        f'<!doctype html><script>let a = 1</script><script type="application/json" id="scenario">{document}</script>'
    )
    assert load(written(tmp_path, "report.html", report)) == scenario
    assert load(tmp_path / "run.nc", ["operation.feed=60 mm/s"]).operation.feed == 0.06
    with pytest.raises(ScenarioFault, match="is not a report of cutwise"):
        load(written(tmp_path, "other.html", "<html></html>"))


@pytest.mark.parametrize(
    ("word", "hint"),
    [("deburring", "did you mean deburr?"), ("debur", "did you mean deburr?"), ("sew", "known are: deburr")],
)
def test_an_unknown_process_says_what_there_is_and_the_other_faults_too(word, hint):
    faults = faults_of(GOOD.replace("process: deburr", f"process: {word}").replace("80 mm/s", "80"))
    assert hint in faults[0]
    assert "operation.feed: 80 has no unit" in faults[1]


def test_the_process_may_be_left_out():
    assert parse(GOOD.replace("process: deburr\n", "")).process == "deburr"
    assert "process: missing" in faults_of("name: a\n")[0]


def test_an_empty_section_is_a_section_without_keys():
    assert parse(GOOD + "numerics:\n").numerics.force == "averaged"
    assert faults_of(GOOD.replace("tool: {library: berselli2016}", "tool:"))[0].startswith(
        "deburr.yaml:13:1: tool.diameter: missing"
    )
    assert faults_of(GOOD.replace("feed: 80 mm/s", "feed:"))[0].startswith(
        "deburr.yaml:3:3: operation.feed: has no value"
    )
