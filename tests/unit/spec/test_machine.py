"""What is wrong with a machine is named at its place, all of it at once."""

import pytest

from cutwise.io.scenario import parse
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.geometry_errors import GeometryErrors
from cutwise.spec.kinds import KINDS
from cutwise.spec.notices import notices

BAD = """
process: machine
machine:
  gravity: [0, 0, 0]
  chain:
    - name: part
    - name: table
      parent: part
      joint: {kind: prismatic, side: part, offset: [0 mm, 0 mm, 0 mm], axis: [0, 0, 0], command: X, positive: table,
              travel: [0 mm, 100 mm]}
      elements:
        - {name: c, at: [0 mm, 0 mm, 0 mm], compliance: [[1, 2, 0, 0, 0, 0], [2, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0],
            [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]}
        - {name: d, at: [0 mm, 0 mm, 0 mm], pads: {points: [[0 mm, 0 mm, 0 mm], [1 mm, 0 mm, 0 mm]],
            stiffness: [1 N/um, 1 N/um, 1 N/um]}}
    - name: column
      parent: base
      joint: {kind: fixed, side: tool, offset: [0 mm, 0 mm, 0 mm]}
    - name: a
      parent: b
      joint: {kind: fixed, side: tool, offset: [0 mm, 0 mm, 0 mm]}
    - name: b
      parent: a
      joint: {kind: fixed, side: tool, offset: [0 mm, 0 mm, 0 mm]}
tool: {diameter: 10 mm, tip: [0 mm, 0 mm, 0 mm], flexible: false}
path: {points: [{X: 0 mm}, {X: 260 mm}], feed: 400 mm/min}
load: {force: [1 N, 0 N, 0 N]}
geometry_errors:
  EXX: {columns: {"position [mm]": [0, 10, 20, 30, 40, 90], "error [um]": [0, 1, 2, 1, 0, 1]}}
  EXZ: {amplitudes: [1 um], phases: [0 deg], wavelength: 1 mm}
"""


def faults(text: str) -> list[str]:
    with pytest.raises(ScenarioFault) as caught:
        parse(text)
    assert all(fault.line is not None for fault in caught.value.faults)
    return [str(fault) for fault in caught.value.faults]


def test_loop_orphan_axis_compliance_travel_and_tables_at_once():
    found = faults(BAD)
    for words in (
        "machine.gravity: has no direction",
        "chain[1].joint.axis: has zero length",
        "chain[1].elements[0].compliance: is not positive definite",
        "chain[1].elements[1].pads.points: is not positive definite",
        'chain[2].parent: column is an orphan: there is no body "base"',
        "chain[3].parent: is a loop: a - b - a",
        "path.points[1].X: 260 mm is beyond the travel of axis X, 0 mm to 100 mm",
        "geometry_errors.EXX: covers 0 mm to 90 mm only",
        "geometry_errors.EXX: has a gap from 40 mm to 90 mm",
        "geometry_errors.EXZ: is an error of axis Z, which the machine does not have",
    ):
        assert sum(words in fault for fault in found) == 1, (words, found)
    assert len(found) == 10


def test_a_fault_of_one_section_hides_none_of_the_others():
    """A unit that does not fit, and still what is wrong with the chain and the travel."""
    found = faults(BAD.replace("[1 N, 0 N, 0 N]", "[1 mm, 0 N, 0 N]"))
    for words in ('"mm" is not a unit of force', "machine.gravity: has no direction", "is beyond the travel of axis X",
                  "column is an orphan"):  # fmt: skip
        assert any(words in said for said in found), words


@pytest.mark.parametrize("axis", ["[1e-300, 0, 0]", "[1e200, 0, 0]"])
def test_numbers_out_of_scale_are_no_directions(axis):
    assert any("out of scale" in said for said in faults(BAD.replace("axis: [0, 0, 0]", f"axis: {axis}")))


def test_a_chain_without_a_beginning_is_a_loop():
    body = "{{name: {0}, parent: {1}, joint: {{kind: fixed, side: tool, offset: [0 mm, 0 mm, 0 mm]}}}}"
    chain = f"[{body.format('a', 'b')}, {body.format('b', 'a')}]"
    tail = "tool: {diameter: 10 mm, tip: [0 mm, 0 mm, 0 mm], flexible: false}\nvolume: {points: 3}\n"
    found = faults(f"process: machine\nmachine: {{gravity: [0, 0, -1], chain: {chain}}}\n{tail}")
    assert any("is a loop: no body is without a parent" in fault for fault in found)
    assert any("needs three linear axes" in fault for fault in found)


GOOD = """
process: machine
machine: {library: demec_mill}
tool: {library: demec}
path: {points: [{X: 0 mm}, {X: 260 mm}], feed: 400 mm/min}
load: {force: [1 N, 0 N, 0 N]}
"""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("machine.chain[5].parent=saddle", "saddle already carries bed; a serial chain has no branches"),
        ("machine.chain[4].joint.side=part", "no fault expected"),
        ("machine.chain[6].joint.side=part", "spindle is on the part side, but head before it on the tool side"),
        ("machine.chain[2].joint.command=A", "A is no letter of a prismatic axis"),
        ("machine.chain[2].joint.command=Y", "axis Y already moves saddle"),
        ("machine.chain[2].joint.travel=[1 mm, 0 mm]", "ends before it begins"),
        ("machine.chain[2].elements[0].travels_with=head", "is neither saddle nor table"),
        ("machine.chain[2].elements[0].pads=null", "give exactly one of"),
        ("machine.chain[2].elements[0].pads.stiffness=[0 N/um, 0 N/um, 3 N/um]", "no stiffness along y"),
        ("machine.chain[4].elements[0].springs.stiffness=[0 N/um, 1 N/um, 1 N/um]", "every spring must be above zero"),
        ("machine.chain[4].elements[1].beam.wall=200 mm", "is thicker than half of the box"),
        ("path.points=[{X: 0 mm}, {X: 0 mm}]", "all points are the same"),
        ("path.points=[{X: 0 mm}, {B: 1 deg}]", "the machine has no axis B; it has X, Y, Z"),
        ("path=null", "missing: write a path or program for a pass"),
        ("uncertainty={bodies: [{bodies: [tabel], displacement: 1 um, rotation: 1 urad, distribution: normal}]}",
         'there is no body "tabel"'),
        ("load.force={axial_depth: 5 mm, spindle_speed: 500 rpm}", "material: missing"),
        ("load.force=4 kN", "load.force"),
        ("tool.diameter=null", "tool.diameter: missing"),
        ("surface={normal: [0, 0, 0], depth: 5 mm}", "has zero length"),
        ("geometry_errors={EXX: {amplitudes: [1 um], phases: [0 deg, 1 deg], wavelength: 1 m}}",
         "2 entries for 1 amplitudes"),
        ("geometry_errors={EXX: {deviation: 1 um, seed: 1}}", "exactly one of wavelength"),
        ("geometry_errors={EXQ: {deviation: 1 um, seed: 1}}", "unknown key"),
        ("machine.chain[9].weight=1 N", "machine.chain: has no entry 9; they are counted from 0"),
        ("geometry_errors={EXX: {deviation: 1 um, seed: 1, period: 360 deg}}", "axis X moves: write wavelength instead of period"),
        ("geometry_errors={EAX: {polynomial: [1 urad], angle_scale: 1 rad}}", "axis X moves: write scale instead of angle_scale"),
        ("volume={points: 3, at: {X: 10 mm}}", "is mapped over its whole travel; leave it out"),
        ("uncertainty={bodies: [{bodies: [table, table], displacement: 1 um, rotation: 1 urad, distribution: normal}]}",
         "table has its random error already"),
        ("requirements={share_tabel: {max: 1 um}}", 'there is no body "tabel"'),
        ("load.force=[1 N, 2 N]", "load.force.*: has too few entries"),
        ("machine.chain[1].name=my table", "use letters, digits and _, a letter first"),
        ("tool.flexible=perhaps", "perhaps is neither true nor false"),
        ("machine.chain[1].parent=table", "is a loop: table - table"),
    ],
)  # fmt: skip
def test_single_faults(change, words):
    if words == "no fault expected":
        assert parse(GOOD, overrides=[change]).machine.ground == 4  # the column is at rest then
        return
    with pytest.raises(ScenarioFault, match=words.replace("[", r"\[")):
        parse(GOOD, overrides=[change])


def test_axes_off_their_travel_are_refused_in_a_map_too():
    with pytest.raises(ScenarioFault, match="no axis C"):
        parse(GOOD, overrides=["volume={points: 3, at: {C: 1 deg}}"])


def test_null_takes_a_section_of_the_file_away():
    text = GOOD + "surface: {normal: [0, 1, 0], depth: 5 mm}\n"
    assert parse(text).surface is not None
    assert parse(text, overrides=["surface=null"]).surface is None


def test_a_fault_has_no_followers():
    """A wrong list is one fault, whatever else could be said of it; a loop hides no axes."""
    with pytest.raises(ScenarioFault) as caught:
        parse(GOOD, overrides=["machine.chain[2].joint.axis=[1, 0]", "machine.chain[1].parent=table"])
    found = [str(fault) for fault in caught.value.faults]
    assert sum("has too few entries" in fault for fault in found) == 1
    assert not any("no axis" in fault for fault in found)


def test_weight_of_the_body_at_rest_is_told():
    told = notices(
        parse(GOOD, overrides=["machine.chain[3].weight=1 kN", "machine.chain[3].weight_at=[0 mm, 0 mm, 0 mm]"])
    )
    assert any("bed is at rest" in notice for notice in told)


def test_every_error_function_is_described():
    for name, info in GeometryErrors.model_fields.items():
        assert info.description, name
        assert info.examples, name
    assert len(GeometryErrors.model_fields) == 36 + 6 + 18


def test_shares_are_measures_whatever_the_bodies_are_called():
    measures = KINDS["machine"].measures
    assert "share_turntable" in measures
    assert measures["share_turntable"].dimension == "small_length"
    assert "sharing" not in measures
    with pytest.raises(KeyError):
        measures["sharing"]
