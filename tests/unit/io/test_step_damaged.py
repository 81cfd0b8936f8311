"""Damaged STEP files: told in words, whatever is wrong with them, and no process dies of it but the reader's own."""

import contextlib
import os
import re
import time
from pathlib import Path

import pytest
from tests.unit.io.step_mutants import DAMAGES, mutant

from cutwise.io import cad, cad_edges, cad_mesh, part21, step, step_process
from cutwise.io.occ import CadFault

STEP = Path(__file__).parents[2] / "data" / "step"
SOUND = (STEP / "half_cylinder_hole_1e-9.step", STEP / "roof_convex40_concave45.step")
MUTANTS = int(os.environ.get("CUTWISE_STEP_MUTANTS", "65"))  # set to 5000 for a night


def written(folder, text):
    file = folder / "part.step"
    file.write_bytes(text.encode("latin-1"))
    return file


def fault(folder, text):
    with pytest.raises(CadFault) as found:
        step.read_step(written(folder, text))
    return str(found.value)


@pytest.fixture(scope="module")
def box():
    return SOUND[0].read_text()


def test_a_direction_that_is_missing_ended_the_process(tmp_path, box):
    """rc 139 in version 0.1."""
    line = next(k for k, text in enumerate(box.splitlines()) if "= DIRECTION(" in text)
    number = re.match(r"#\d+", box.splitlines()[line])[0]
    said = fault(tmp_path, "".join(text for k, text in enumerate(box.splitlines(keepends=True)) if k != line))
    assert re.search(rf"line \d+: #\d+ = \w+ refers to {number}, which is missing", said)
    assert "export it again" in said


def test_a_line_without_its_vector_ended_the_process(tmp_path, box):
    """``LINE('',#28,$)``: rc 139 in version 0.1."""
    found = re.search(r"#(\d+) = LINE\('',#\d+,(#\d+)\)", box)
    line = box[: found.start()].count("\n") + 1
    said = fault(tmp_path, box[: found.start(2)] + "$" + box[found.end(2) :])
    assert f"line {line}: #{found[1]} = LINE: parameter 3 (dir) is missing or not of its type" in said


def test_all_missing_lines_are_told_at_once(tmp_path, box):
    kept = [line for line in box.splitlines(keepends=True) if "= VECTOR(" not in line]
    assert fault(tmp_path, "".join(kept)).count("which is missing") > 4


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("= DIRECTION('',(0.,0.,1.));", "= DIRECTION('',(0.,0.,1.)", "is no whole statement"),
        ("= VERTEX_POINT(", "= VERTEX_POINT((", "is no whole statement"),
        ("#17 = ", "#18 = ", "#18 is there twice"),
    ],
)  # fmt: skip
def test_statements_that_are_not_whole(tmp_path, box, old, new, said):
    assert said in fault(tmp_path, box.replace(old, new, 1))


def test_a_file_that_is_cut_short_is_told_as_such(tmp_path, box):
    assert re.search(
        r"line \d+: the last whole statement: the file is cut short", fault(tmp_path, box[: len(box) // 2])
    )
    assert "cut short" in fault(tmp_path, box.replace("ENDSEC;\nEND-ISO-10303-21;", ""))


def test_what_the_shape_does_not_need_may_be_missing_and_is_said(tmp_path, box):
    extra = "#900 = STYLED_ITEM('color',(#901),#902);\nENDSEC;\nEND-ISO"
    part = step.read_step(written(tmp_path, box.replace("ENDSEC;\nEND-ISO", extra)))
    assert part.solids == 1
    assert "damaged where the shape is not touched: #900 = STYLED_ITEM refers to #901" in "; ".join(part.notices)


def test_a_face_that_is_lost_on_the_way_is_said(tmp_path, box):
    """A radius of nearly nothing: OpenCascade leaves the face out and says nothing."""
    text = re.sub(r"(= CYLINDRICAL_SURFACE\('',#\d+,)[\d.]+\)", r"\g<1>-1.)", box, count=1)
    try:
        part = step.read_step(written(tmp_path, text))
    except CadFault:
        return
    assert any("could not be translated" in said or "open shell" in said for said in part.notices)


def test_comments_strings_and_complex_entities_are_read_as_the_standard_says():
    text = (
        "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n/* #3 = NOT('a';\n*/#1=A('it''s; (x',#2,(1.E-3,$,*),.T.,\"0F\");\n"
        "#2=(B(1.)\nC(LENGTH_MEASURE(2.5),#1)D());\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    found = part21.exchange(text)
    assert [(i.kind, i.refers) for i in found.instances.values()] == [("A", (2,)), ("B+C+D", (1,))]
    assert [found.line(n) for n in (1, 2)] == [5, 7]


def test_one_reader_for_all_files_and_another_one_after_its_end(tmp_path, box):
    step.read_step(written(tmp_path, box))
    first = step_process.READER._process
    step.read_step(written(tmp_path, box))
    assert step_process.READER._process is first
    first.kill()
    first.wait()
    assert step.read_step(written(tmp_path, box)).faces == 8


def test_a_reader_that_ends_over_a_file_is_told_in_words(tmp_path, box, monkeypatch):
    monkeypatch.setattr(step_process, "_COMMAND", "import sys, os; sys.stdin.readline(); os.abort()")
    reader = step_process.Reader()
    monkeypatch.setattr(step_process, "READER", reader)
    monkeypatch.setattr(step, "READER", reader)
    assert "reading it ended the reader of OpenCascade" in fault(tmp_path, box)


@pytest.mark.skipif(os.name != "posix", reason="limits of a process are POSIX")
def test_a_reader_that_does_not_end_is_stopped(tmp_path, box, monkeypatch):
    endless = (
        "import sys; from cutwise.io import step_reader as r\n"
        "sys.stdin.readline(); r.SECONDS = 0.2; r.limited(0)\nwhile True: pass"
    )
    monkeypatch.setattr(step_process, "_COMMAND", endless)
    reader = step_process.Reader()
    monkeypatch.setattr(step_process, "READER", reader)
    monkeypatch.setattr(step, "READER", reader)
    assert re.search(r"took more than \d+ s of computing", fault(tmp_path, box))


def test_mutants_of_every_kind_are_read_or_refused_in_words(tmp_path):
    """One change to a sound file: lines gone, arguments unset or of another type, wrong references, cut short ..."""
    texts = [file.read_text() for file in SOUND]
    refused = 0
    for seed in range(MUTANTS):
        text, damage = mutant(texts[seed // len(DAMAGES) % len(texts)], seed)
        begun = time.process_time()
        with contextlib.suppress(CadFault):
            refused += 1
            model = cad.topology(step.read_step(written(tmp_path, text)))
            cad_edges.sharp_chains(model, spacing=1e-3)
            cad_mesh.cad_mesh(model)
            refused -= 1
        assert time.process_time() - begun < 20.0, (seed, damage)
    assert refused > MUTANTS / 2
