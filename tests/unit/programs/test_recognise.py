"""Files that are something else say so in one sentence, not in one fault a line."""

import pytest

from cutwise.io.program_setup import read_program
from cutwise.programs.fanuc import macro_sign
from cutwise.programs.interpreter import interpret
from cutwise.programs.recognise import foreign_text
from cutwise.programs.rs274 import first_unit
from cutwise.spec.faults import ScenarioFault

HEIDENHAIN = "0 BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 TOOL CALL 1 Z S2000\n3 L X+10 R0 FMAX M3\n4 END PGM PART MM\n"
SIEMENS = 'N10 G17 G90 G54\nN20 T="MILL10"\nN30 M6\nN40 R1=10\nN50 G1 X=R1 F500\nN60 CYCLE81(10,0,2,-5)\nN70 M30\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEIDENHAIN, "Heidenhain program in plain language"),
        ("L X+10 Y+20 R0 FMAX\nL Z-5 F500\nCC X+0 Y+0\nC X+10 Y+0 DR+\n", "Heidenhain program in plain language"),
        ("%PART G71 *\nN10 G30 G17 X+0 Y+0 Z-20*\nN20 G00 X+1*\n", "DIN/ISO"),
        (SIEMENS, "Siemens"),
        ("%_N_PART_MPF\n;$PATH=/_N_WKS_DIR\nG0 X1\n", "Siemens"),
        ("G0 X0\nG2 X10 Y0 CR=5\nG1 X=IC(5)\nG1 Y=AC(2) G642\n", "Siemens"),
        ("G21\nM104 S200\nG1 X1 E0.5 F100\n", "3D printer"),
        ("$BRACKET.MIN%\nO1\nG15 H1\nG0 X0 Y0\nM2\n", "Okuma"),
        ("O100\nVC1=10\nG0 X=VC1\nIF [VC1 EQ 3] GOTO NEND\nNEND M2\n", "Okuma"),
        ("%PART,MX--,\nG0 X0 Y0\nM30\n", "Fagor"),
        ("&ACCESS RVP\nDEF part( )\nLIN {X 100, Y 0, Z 50}\nEND\n", "KUKA"),
        ("MODULE Part\nPROC main()\nMoveL [[0,0,0],[1,0,0,0]], v100, fine, tool0;\nENDPROC\nENDMODULE\n", "RAPID"),
        ("  0\nSECTION\n  2\nHEADER\n  9\n$ACADVER\n", "drawing (DXF)"),
        ("999\nmade by hand\n0\nSECTION\n", "drawing (DXF)"),
        ("solid part\n  facet normal 0 0 1\n    outer loop\n", "mesh (STL)"),
        ("ISO-10303-21;\nHEADER;\n", "STEP file"),
        ("<!doctype html><html>", "page of the web"),
        ("G1\0X\0", "binary"),
        ("process: mill\nprogram: a.nc\n", "scenario"),
    ],
)
def test_one_sentence_says_what_a_file_is(text, words):
    with pytest.raises(ScenarioFault) as found:
        interpret(text, "p.nc")
    (fault,) = found.value.faults
    assert words in str(fault)
    assert str(fault).startswith("p.nc: is a")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_wide_encodings_are_named(tmp_path, encoding):
    file = tmp_path / "p.nc"
    file.write_bytes("G21 G90\nG1 X1 F100\n".encode(encoding))
    with pytest.raises(ScenarioFault, match="is UTF-"):
        read_program(file, "p.nc")


@pytest.mark.parametrize(
    "text",
    [
        "%\nO1 (CYCLE DEF)\nG21 G1 X1 F100\n%",
        "(MCALL is a word of another control)\nG1 X1 F100",
        "G1 X1 F100 (L X+1)\n(R1=2)\n; CYCLE83(1)\n",
        "#1=2\n#<R1>=5\nG1 X#1 F100",
        "%\nO2 (DEF PART, MODULE 3, SOLID)\nG15\nG1 X1 F100\nM98 P100\n%",
        "(VC1=2)\n(LET X=3)\nG1 X1 F100",
        "G1 X1 F100 *1",  # one star is a fault of its own
    ],
)
def test_programs_stay_programs(text):
    assert foreign_text(text, apt=False) is None


@pytest.mark.parametrize(
    "text", [" " * 40_000, "(" * 40_000 + "G21 X10", "IF[" + "] " * 20_000, "X=1 " * 10_000, "\n" * 40_000]
)
def test_looking_at_a_file_comes_to_an_end(text):
    """Patterns that go back and forth over blanks or brackets would take minutes here."""
    assert foreign_text(text, apt=False) is None
    macro_sign(text)
    first_unit(text)


def test_numbers_out_of_scale_are_refused_where_they_stand():
    for text, place in (
        ("G21 G90 G1 F100 X" + "9" * 308, "p.nc:1:17"),
        ("G1 F1" + "0" * 300 + " X1", "p.nc:1:4"),
        ("G1 F100 X[10**200]", "p.nc:1:9"),
        ("G1 F100 X1\nX2000000000", "p.nc:2:1"),
        ("G1 F100 X1\n#1=1000000\nG4 P[#1*#1]", "p.nc:3:4"),
    ):
        with pytest.raises(ScenarioFault, match="out of scale") as found:
            interpret(text, "p.nc")
        assert str(found.value.faults[0]).startswith(place + ":"), text
