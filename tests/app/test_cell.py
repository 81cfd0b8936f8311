"""The slots of a cell: named rows are those that run, what is left out is left out, and what is forbidden says why."""

import json

import numpy as np
import pytest

from app.test_matrix import LEGAL
from cutwise import loop, still
from cutwise.io.scenario import load, parse
from cutwise.physics.structure.terms import Pistons, Rigid, Series
from cutwise.process.recipes import quick_outcome, simulate
from cutwise.spec.cell import PRESETS, REFUSED, ROWS, SLOTS
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.filled import in_words, rows_of
from cutwise.spec.kinds import KINDS

_TERM = {"tip modes": "tip_modes", "links": "arm", "drives": None}


def without_slots(scenario):
    """The values of a scenario, without what naming its engagement writes."""
    values = scenario.model_dump(exclude={"cell"})
    (values.get("numerics") or {}).pop("engagement", None)
    return values


class Assembled(Exception):
    """What a run put together, before it ran."""


def named(scenario):
    """The overrides that name every row of a scenario."""
    said = []
    for slot, rows in rows_of(scenario).items():
        if slot == "structure":
            said.append(f"cell.structure=[{', '.join(rows)}]")
        elif len(rows) == 1:
            said.append(f"cell.{slot}={rows[0]}")
    return said


@pytest.mark.parametrize("pair", LEGAL)
def test_the_rows_of_a_legal_pair_are_told_and_can_be_named(pair, examples):
    (name, *overrides), _ = LEGAL[pair]
    scenario = load(examples / f"{name}.yaml", overrides)
    rows = rows_of(scenario)
    word = pair.partition(" x ")[2].partition(",")[0]
    term = _TERM.get(word, word)
    assert term in rows["structure"] if term else "driv" in rows["motion"][0]
    again = load(examples / f"{name}.yaml", [*overrides, *named(scenario)])
    assert rows_of(again)["structure"] == rows["structure"]
    assert without_slots(again) == without_slots(scenario)


def leaves(structure):
    """The terms of a structure, from the tool on."""
    if isinstance(structure, Series):
        return [*leaves(structure.near), *leaves(structure.far)]
    return [] if isinstance(structure, Rigid) else [structure]


def arrays(record):
    """The arrays of a record and of the records in it."""
    if isinstance(record, np.ndarray):
        yield record
    for part in record if isinstance(record, tuple) else ():
        yield from arrays(part)


def whole(cell):
    """Whether its arrays have no gaps: a loop is compiled once more, in a dozen seconds, for those that have."""
    return all(array.flags.c_contiguous and array.flags.writeable for array in arrays(cell))


RECORDS = [  # drilling and machine have no cell in time; a tip that swings alone behind drives is part of the cutting
    pair
    for pair in LEGAL
    if not pair.startswith(("drill", "machine"))
    and pair not in ("mill x tip modes", "mill x drives")
    and "tooth by tooth" not in pair
]


@pytest.mark.parametrize("pair", RECORDS)
def test_the_records_of_a_run_are_the_rows_that_are_told(pair, examples, monkeypatch):
    """As many terms in series as rows of the structure, the pistons first; a block of the part is among the bodies."""
    (name, *overrides), _ = LEGAL[pair]
    scenario = load(examples / f"{name}.yaml", overrides)

    def halting(run):
        def until(cell, *rest):
            assert whole(cell)
            if leaves(cell.structure):  # a rigid mill is looked at beforehand, to choose a posture
                raise Assembled(cell.structure)
            return run(cell, *rest)

        return until

    monkeypatch.setattr(loop, "advance", halting(loop.advance))
    monkeypatch.setattr(still, "at_poses", halting(still.at_poses))
    terms = []
    try:
        quick_outcome(scenario, coarse=True)
    except Assembled as caught:
        terms = leaves(caught.args[0])
    rows = rows_of(scenario)["structure"]
    block = "bodies" in rows and getattr(scenario.part, "stiffness", None) is None
    assert len(terms) == len([row for row in rows if not (row == "part" and block)])
    assert [isinstance(term, Pistons) for term in terms] == [row == "pistons" for row in rows[: len(terms)]]


def test_half_of_the_samples_go_through_the_loop_of_all(examples, monkeypatch):
    """Seen to fail: the run that shows convergence took every second sample where they lay, and all was compiled twice."""
    seen, at_poses = [], still.at_poses

    def looked(cell, *rest):
        seen.append(whole(cell))
        return at_poses(cell, *rest)

    monkeypatch.setattr(still, "at_poses", looked)
    simulate(load(examples / "chamfer_on_robot.yaml", ["path.points=48", "requirements={}"]))
    assert len(seen) > 1
    assert all(seen)


def test_one_file_runs_with_and_without_its_terms(examples):
    file = examples / "cell_robot_wall.yaml"
    whole = quick_outcome(load(file)).measures
    arm = quick_outcome(load(file, ["cell.structure=[arm]"])).measures
    plain = quick_outcome(load(file, ["cell=null", "process=mill", "tool.stiffness=null", "part=null",
                                      "robot.base_compliance=null"])).measures  # fmt: skip
    assert arm == plain
    assert abs(arm["wall_error_min"]) < abs(whole["wall_error_min"])
    assert "share_tip" not in arm


@pytest.mark.parametrize("slot", [*SLOTS, ""])
def test_a_slot_that_is_emptied_takes_nothing_out(slot, examples):
    key = f"cell.{slot}" if slot else "cell"
    emptied = load(examples / "cell_robot_wall.yaml", [f"{key}=null", "process=mill"])
    assert rows_of(emptied) == rows_of(load(examples / "cell_robot_wall.yaml"))


def test_pistons_are_taken_out(examples):
    stiff = load(examples / "deburr_on_robot.yaml", ["cell.structure=[arm]", "operation.preset=0.05 mm"])
    assert stiff.spindle == "rigid"
    assert parse(json.dumps(stiff.document())).model_dump() == stiff.model_dump()


def test_modes_of_a_library_and_drives_are_taken_out(examples):
    assert not load(examples / "mill_on_machine.yaml", ["cell.structure=[bodies, part]"]).tool.modes
    driven = load(examples / "mill_on_machine.yaml", ["cell.motion=drives", "cell.structure=[tip_modes]"])
    assert in_words(driven).startswith("motion drives; engagement wall; cutting flutes; structure tip_modes;")
    slow = load(examples / "mill_on_machine.yaml", ["cell.motion=machine", "tool.modes=[]", "numerics={mode: still}"])
    assert rows_of(slow)["motion"] == ("machine",)


def test_a_carrier_is_taken_out(examples):
    bare = load(examples / "cell_robot_wall.yaml", ["cell.motion=programmed", "cell.structure=[tip]"])
    assert bare.robot is None
    assert rows_of(bare)["structure"] == ("tip",)


def test_an_engagement_sets_how_an_edge_is_met(examples):
    file = examples / "deburr_compliant_spindle.yaml"
    assert load(file, ["cell.engagement=edge_memory"]).numerics.engagement == "swept"
    with pytest.raises(ScenarioFault, match=r"is edge, the rest .* edge_memory; for edge write"):
        load(file, ["cell.engagement=edge", "numerics.engagement=swept"])


FAULTS = {
    "cell.structure=[arm, base]": "names base, which nothing fills; write robot.base_compliance, or leave it out",
    "cell.structure=[arm, bodies]": "the tool has one carrier: write robot or machine",
    "cell.structure=[pistons]": "leaves out arm, which the scenario has; name it, or write robot: null",
    "cell={motion: drives, structure: [arm]}": "arm: yields where a robot carries the tool; write motion: robot",
    "cell={motion: robot, structure: [pistons]}": "leaves out arm, by which a robot always yields: add it",
    "cell.structure=[arm, arm]": "names a term twice",
    "cell.structure=[arm, shaft]": "shaft: a shaft is turned in a chuck",
    "cell.engagement=hole": "hole is not of process: deburr; write process: drill, or edge or edge_memory",
    "cell={engagement: hole, cutting: flutes}": "a drill cuts by lips and chisel edge along its axis: write lips",
    "cell={engagement: wall, cutting: ball}": "ball does not go with wall: flutes that turn cut here",
    "cell={engagement: wedge, surface: hole}": "hole is not what is left here: write chamfer",
    "cell.motion=drives": "is drives, the rest of the scenario says programmed",
    "cell.structure=[pistons, arms]": '"arms" is not one of pistons, tip, tip_modes, arm,',
    "cell.motoin=robot": "unknown key; did you mean cell.motion?",
    "cell.structure=arm": "cell.structure",
}


@pytest.mark.parametrize("override", FAULTS)
def test_what_does_not_fit_is_told_with_the_key_to_write(override, examples):
    with pytest.raises(ScenarioFault) as caught:
        load(examples / "deburr_on_robot.yaml", [override])
    assert FAULTS[override] in str(caught.value)


@pytest.mark.parametrize(("process", "row"), REFUSED)
def test_a_forbidden_row_is_refused_with_its_reason_and_without_a_process(process, row):
    slot = "structure" if row in ROWS["structure"] else "motion"
    preset = PRESETS[process]
    text = (
        f"name: x\ncell: {{engagement: {preset.engagement[0]}, {slot}: {f'[{row}]' if slot == 'structure' else row}}}\n"
    )
    with pytest.raises(ScenarioFault) as caught:
        parse(text)
    assert f"{row}: {REFUSED[process, row]}" in str(caught.value)
    assert row not in getattr(preset, slot)


def test_every_row_belongs_to_a_process_or_is_forbidden_there():
    assert set(PRESETS) == set(KINDS)
    for slot, rows in ROWS.items():
        assert set(rows) == {row for preset in PRESETS.values() for row in getattr(preset, slot)}
        assert tuple(rows) == tuple(SLOTS[slot].__args__)
    for process, preset in PRESETS.items():
        for slot in ("motion", "structure"):
            for row in ROWS[slot]:
                assert (row in getattr(preset, slot)) != ((process, row) in REFUSED), (process, row)


def test_a_file_without_process_or_slots_says_which_are_possible():
    with pytest.raises(ScenarioFault, match="process: missing"):
        parse("name: x\ncell: {cutting: flutes}\n")


def test_the_same_numbers_by_name_and_by_process(examples):
    by_name = simulate(load(examples / "cell_robot_wall.yaml"))
    by_process = simulate(load(examples / "cell_robot_wall.yaml", ["cell=null", "process=mill"]))
    assert {k: m.value for k, m in by_name.measures.items()} == {k: m.value for k, m in by_process.measures.items()}
