"""``cutwise program``: listing, JSON, canonical commands, drawing, and bad programs."""

import json

import pytest


@pytest.fixture
def pocket(examples):
    return examples / "mill_pocket.nc"


def test_a_listing(cutwise, pocket):
    found = cutwise("program", pocket)
    assert found.code == 0, found.err
    for words in ("G-code in mm", "tools: T1", "spindle: 8000 rpm", "feeds: 5 mm/s, 40 mm/s", "length: 880.212 mm feed",
                  "rapid: x 0.000 to 70.000", "no start position"):  # fmt: skip
        assert words in found.out


def test_json_is_si(cutwise, pocket):
    told = json.loads(cutwise("program", pocket, "--json").out)
    assert told["feed_length"] == pytest.approx(0.8802123739)
    assert told["boxes"]["feed"]["high"] == pytest.approx([0.09, 0.05, 0.005])
    assert told["units"] == ["mm"]
    assert told["tools"] == [1]


def test_canonical_commands(cutwise, pocket):
    lines = cutwise("program", pocket, "--canonical").out.splitlines()
    assert lines[0] == "    1 N..... USE_LENGTH_UNITS(CANON_UNITS_MM)"
    assert "ARC_FEED(74.0000, 30.0000, 70.0000, 30.0000, 1, -5.0000, 0.0000, 0.0000, 0.0000)" in "\n".join(lines)
    assert lines[-3].endswith("PROGRAM_END()")


MACRO = "G21 G90 F300\n#1=0\nWHILE[#1LT3]DO1\n#1=#1+1\nG1 X#1\nEND1\nM30\n"


def test_the_dialect_is_recognised_or_chosen(cutwise, tmp_path):
    program = tmp_path / "macro.nc"
    program.write_text(MACRO)
    for chosen in ((), ("--dialect", "fanuc")):
        found = cutwise("program", program, *chosen)
        assert found.code == 0, found.err
        assert "x 0.000 to 3.000" in found.out
        assert ("run in the dialect fanuc" in found.out) is (not chosen)
    refused = cutwise("program", program, "--dialect", "rs274")
    assert refused.code == 2
    assert refused.err.splitlines()[0].endswith("macro.nc:3: WHILE [...] DO is Fanuc macro B, which the dialect rs274 does "
                                                "not know; choose the dialect fanuc")  # fmt: skip


def test_a_file_of_another_kind_is_named_once(cutwise, tmp_path):
    program = tmp_path / "part.h"
    program.write_text("0 BEGIN PGM PART MM\n" + "1 L X+1 R0 FMAX\n" * 50)
    found = cutwise("program", program)
    assert found.code == 2
    assert len(found.err.splitlines()) == 2
    assert "Heidenhain" in found.err
    program.write_bytes("G21 G1 X1 F100\n".encode("utf-16"))
    assert "is UTF-16 text" in cutwise("program", program).err


def test_a_drawing(cutwise, pocket, tmp_path):
    assert cutwise("program", pocket, "--svg", tmp_path / "pocket.svg").code == 0
    assert (tmp_path / "pocket.svg").read_text().rstrip().endswith("</svg>")


def test_a_tool_table(cutwise, tmp_path):
    program, table = tmp_path / "p.ngc", tmp_path / "t.tbl"
    program.write_text("G21 F100\nT4 M6\nG41\nG1 X10\nG40\nG1 X20\nM2\n")
    table.write_text("T4 P1 D6 ; six\n")
    found = cutwise("program", program, "--tool-table", table)
    assert found.code == 0, found.err
    assert "y 0.000 to 3.000" in found.out
    assert "tool table are taken as mm" in found.out
    table.write_text("T5 P1 D6\nrubbish\n")
    found = cutwise("program", program, "--tool-table", table)
    assert found.code == 2
    assert "t.tbl:2:1: " in found.err


def test_cl_data_and_subroutine_files(cutwise, tmp_path):
    (tmp_path / "p.cls").write_text("PARTNO/X\nFEDRAT/600,MMPM\nGOTO/1,2,3\nFINI\n")
    assert "APT in mm" in cutwise("program", tmp_path / "p.cls").out
    (tmp_path / "p.ngc").write_bytes("(Fräser 6 mm)\r\nG21\r\no<square> call [5]\r\nM2\r\n".encode("latin-1"))
    (tmp_path / "square.ngc").write_text("o<square> sub\nG0 X#1\nY#1\no<square> endsub\n")
    found = cutwise("program", tmp_path / "p.ngc")
    assert "rapid: x 0.000 to 5.000, y 0.000 to 5.000" in found.out


def test_bad_programs_are_named_line_by_line(cutwise, tmp_path):
    program = tmp_path / "bad.nc"
    program.write_text("G21\nG1 X1\nG76 X2\nG0 Q3 X1\no1 call\nM2\n")
    for option in ((), ("--canonical",), ("--json",)):
        found = cutwise("program", program, *option)
        assert found.code == 2
        assert found.out == ""
        assert [line.split("bad.nc:")[1].split(":")[0] for line in found.err.splitlines()[:-1]] == ["2", "3", "4", "5"]
        assert "4 faults" in found.err
    assert "no such file" in cutwise("program", tmp_path / "none.nc").err
