"""APT cutter location data: the same commands and moves as G-code of the same path."""

import math

import pytest

from cutwise.programs.cldata import is_apt, statements
from cutwise.programs.interpreter import interpret, reading
from cutwise.programs.moves import moves
from cutwise.spec.faults import ScenarioFault

HEAD = "PARTNO X\nUNITS/MM\nSPINDL/RPM,1000,CLW\nFEDRAT/600,MMPM\n"


def mm(point):
    return pytest.approx([1e-3 * value for value in point], abs=1e-12)


def made(text, head=HEAD):
    run = reading(head + text, "p.cls")
    return list(moves(run.commands(), start=run.start))


def test_the_same_path_as_g_code():
    apt = made("FROM/0,0,10\nRAPID\nGOTO/5,0,1\nGOTO/5,0,-1\nCIRCLE/5,10,-1,0,0,1,10\nGOTO/15,10,-1\nGODLTA/-1\nFINI")
    code = interpret("G21 G90 S1000 M3 F600\nG0 Z10\nG0 X5 Z1\nG1 Z-1\nG3 X15 Y10 I0 J10\nG91 G1 Z-1\nM2").moves[1:]
    assert len(apt) == len(code)
    for a, b in zip(apt, code, strict=True):
        assert a.kind == b.kind
        assert a.start == pytest.approx(b.start)
        assert a.end == pytest.approx(b.end)
        assert a.sweep == pytest.approx(b.sweep)
        assert (a.feed, a.spindle) == pytest.approx((b.feed, b.spindle))


def test_circles_about_any_axis():
    clockwise = made("FROM/0,0,0\nCIRCLE/10,0,0,0,0,-1,10\nGOTO/20,0,0")[0]
    assert clockwise.sweep == pytest.approx(-math.pi)
    whole = made("FROM/0,0,0\nCIRCLE/10,0,0,0,1,0,10\nGOTO/0,0,0")[0]
    assert whole.axis == (0.0, 1.0, 0.0)
    assert abs(whole.sweep) == pytest.approx(2 * math.pi)
    s = math.sqrt(0.5)
    tilted = made(f"FROM/10,0,0\nCIRCLE/0,0,0,0,{-s},{s},10\nGOTO/-10,0,0")
    middle = tilted[len(tilted) // 2].start
    assert middle == pytest.approx((0.0, 10e-3 * s, 10e-3 * s), abs=0.1e-3)
    assert sum(math.dist(m.start, m.end) for m in tilted) == pytest.approx(math.pi * 10e-3, rel=1e-3)


def test_holes():
    plain = made(
        "RAPID\nGOTO/0,0,20\nCYCLE/DRILL,RAPTO,3,FEDTO,-12,MMPM,150\nGOTO/5,5,0\nGOTO/9,5,0\nCYCLE/OFF\nGOTO/0,0,0"
    )
    assert [m.kind for m in plain[1:]] == ["rapid", "feed", "rapid", "rapid", "feed", "rapid", "feed"]
    assert plain[2].end == mm((5, 5, -12))
    assert (plain[2].feed, plain[-1].feed) == pytest.approx((2.5e-3, 10e-3))
    catia = made("CYCLE/DRILL,20,MMPM,100,5\nGOTO/1,1,0")
    assert [round(1e3 * m.end[2], 6) for m in catia] == [5, -20, 5]
    deep = made("CYCLE/DEEP,RAPTO,2,FEDTO,-5,STEP,3,MMPM,100,DWELL,0.5\nGOTO/0,0,0")
    assert [round(1e3 * m.end[2], 6) for m in deep if m.kind == "feed"] == [-1, -4, -5]
    assert [m.dwell for m in deep if m.kind == "dwell"] == [0.5]
    along = made("CYCLE/DRILL,4,MMPM,100,2\nGOTO/0,0,0,1,0,0")
    assert along[1].end == mm((-4, 0, 0))


def test_tool_axes_are_carried():
    tilted = made("MULTAX/ON\nGOTO/1,0,0,0,0,1\nGOTO/2,0,0,0,0.5,0.8660254")
    assert tilted[0].rotary_end == (0.0, 0.0, 0.0)
    assert tilted[1].rotary_end == pytest.approx((0.0, math.pi / 6, math.pi / 2))


def test_units_and_feeds():
    inch = made("UNITS/INCH\nFEDRAT/10,IPM\nGOTO/1,0,0", head="")[0]
    assert (inch.end[0], inch.feed) == pytest.approx((25.4e-3, 0.254 / 60))
    mixed = made("FEDRAT/10,IPM\nGOTO/1,0,0", head="UNITS/MM\n")[0]
    assert mixed.feed == pytest.approx(0.254 / 60)
    turned = made("FEDRAT/0.1,MMPR\nGOTO/1,0,0")[0]
    assert turned.feed == pytest.approx(0.1e-3 * 1000 / 60)
    assert made("FEDRAT/10,IPM\nGOTO/1,0,0", head="")[0].end[0] == pytest.approx(
        25.4e-3
    )  # no UNITS, but a feed in inches


def test_statements_go_over_lines_and_comments_end_them():
    found = list(statements("GOTO/1.0,$\n 2.0,$$ rest\n-3\n\n$$ only\nPPRINT $ not a line\nGOTO / 1 , 2, 3E-1"))
    assert found[0].numbers() == [1.0, 2.0]
    assert [s.word for s in found] == ["GOTO", "-3", "PPRINT", "GOTO"]
    assert found[-1].numbers() == [1.0, 2.0, 0.3]
    assert (found[-1].line, found[-1].arguments[2].column) == (7, 15)


def test_what_is_cl_data():
    assert is_apt("", "part.CLS")
    assert is_apt("PARTNO X\nGOTO/1,2,3", "part.txt")
    assert not is_apt("G21 G90\n(GOTO the fixture)\nG1 X1", "part.nc")


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("GOTO/1,2", "p.cls:5:1", "x,y,z"),
        ("GOTO/1,2,3,0,0,0", "p.cls:5:12", "no length"),
        ("TLON,GOFWD/1", "p.cls:5:1", "unknown or unsupported"),
        ("FEDRAT/0", "p.cls:5:1", "positive feed"),
        ("FROM/0,0,0\nCIRCLE/10,0,0,0,0,1,10\nGOTO/50,0,0", "p.cls:7:1", "end of the arc"),
        ("CIRCLE/10,0,0,0,0", "p.cls:5:1", "radius"),
        ("FROM/0,0,0\nCIRCLE/0,0,0,0,0,1", "p.cls:6:1", "apart from its axis"),
        ("CYCLE/WHAT", "p.cls:5:1", "unsupported cycle"),
        ("LOADTL/A", "p.cls:5:1", "number of a tool"),
        ("SPINDL/SFM,100", "p.cls:5:1", "surface speeds"),
    ],
)
def test_faults_name_their_place(text, place, words):
    with pytest.raises(ScenarioFault) as found:
        list(reading(HEAD + text + "\nFINI", "p.cls").commands())
    assert any(str(fault).startswith(place + ":") and words in str(fault) for fault in found.value.faults), found.value


def test_a_feed_is_needed():
    with pytest.raises(ScenarioFault, match="without a feed"):
        list(reading("GOTO/1,2,3\nFINI", "p.cls").commands())


@pytest.mark.parametrize("unit", ["UNITS/INCH", "UNIT/INCH", "UNITS/INCHES", "UNIT / IN", "UNITS/ENGLISH", "MODE/INCH",
                                  "CSI_SET_UNITS/INCH"])  # fmt: skip
def test_every_spelling_of_a_unit_counts(unit):
    made_so = made("RAPID\nGOTO/0,0,1\nFEDRAT/10,PERMIN\nGOTO/0,0,0\nGOTO/2,0,0\nFINI", head=unit + "\n")
    assert made_so[-1].end[0] == pytest.approx(50.8e-3)
    assert made_so[-1].feed == pytest.approx(0.254 / 60)


def test_a_unit_that_changes_on_the_way_holds_from_there_on():
    found = made(
        "UNITS/MM\nFEDRAT/254,PERMIN\nGOTO/25.4,0,0\nUNITS/INCH\nGODLTA/1,0,0\nFEDRAT/20,IPM\nGOTO/3,0,0", head=""
    )
    assert [m.end[0] for m in found] == pytest.approx([25.4e-3, 50.8e-3, 76.2e-3])
    assert [m.feed for m in found] == pytest.approx([0.254 / 60, 0.254 / 60, 0.508 / 60])


def test_units_that_are_not_known_are_refused():
    with pytest.raises(ScenarioFault, match="UNITS/CM: not a unit of length"):
        made("UNITS/CM\nGOTO/1,0,0")


SOLIDWORKS = """PARTNO/plate
UNIT/MM
INSERT/Stock Size X100 Y50 Z20
TRNTYP/WORLD
SETUP/1
CSYS/1,0,0,5,0,1,0,6,0,0,1,7
CUTTER/10,0,5,0,0,0,60
CSI_SET_FLUTE_LENGTH/25.0
CSI_SET_EXTENSION_LENGTH/40.0
LOAD/TOOL,3
SELECT/TOOL,4
SPINDL/2000,RPM,CLW
COOLNT/FLOOD
RAPID/
GOTO/0,0,10
FEDRAT/300,MMPM
GOTO/0,0,0
CUTCOM/LEFT
GOTO/10,0,0
CIRCLE/10,5,0,0,0,1
GOTO/10,10,0
CUTCOM/OFF
CYCLE/DEEP2,FEDTO,12,1STPECK,5,SUBPECK,3,MMPM,100,RAPTO,2,RTRCTO,8
CYCLE/INIT
GOTO/20,20,0
GOTO/30,20,0
CYCLE/OFF
FINI
"""


def test_cl_data_of_solidworks_cam():
    run = reading(SOLIDWORKS, "part.txt")
    found = list(moves(run.commands(), start=run.start))
    arc = next(m for m in found if m.kind == "arc")
    assert (arc.end, arc.centre, arc.sweep) == (mm((10, 10, 0)), mm((10, 5, 0)), pytest.approx(math.pi))
    feeds = [m for m in found if m.line == 25 and m.kind == "feed"]
    assert [round(1e3 * m.end[2], 6) for m in feeds] == [-3, -6, -9, -12]  # 5 from the clearance of 2, then 3 each
    assert [m.feed for m in feeds] == pytest.approx([100e-3 / 60] * 4)
    second = [round(1e3 * m.end[2], 6) for m in found if m.line == 26]
    assert (second[:2], second[-1]) == ([8, 2], 8)  # across at the height of RTRCTO, then down to RAPTO
    assert any("CUTCOM" in words for words in run.notices())


def test_rapid_holds_until_a_feed_in_cl_data_of_solidworks_cam():
    text = "RAPID/\nGOTO/0,0,10\nGOTO/5,0,10\nFEDRAT/300,MMPM\nGOTO/5,0,0\nGOTO/9,0,0"
    found = made("UNIT/MM\nTRNTYP/WORLD\n" + text, head="")
    assert [m.kind for m in found] == ["rapid", "rapid", "feed", "feed"]
    with pytest.raises(ScenarioFault, match=r"p\.cls:4:1: feed motion without a feed"):
        made("UNITS/MM\n" + text, head="")  # elsewhere RAPID is for one motion


def test_holes_are_left_at_the_height_that_the_cycle_names():
    found = made("CYCLE/DRILL,FEDTO,4,MMPM,100,CLEAR,9,RTRCTO,6,RAPTO,2\nGOTO/0,0,0\nGOTO/5,0,0")
    assert [round(1e3 * m.end[2], 6) for m in found] == [6, 2, -4, 6, 6, 2, -4, 6]


def test_setups_stand_in_one_frame():
    """The second setup looks along x of the part: its tool axis tilts, its points stay where they are on the part."""
    first, second = "CSYS/1,0,0,0,0,1,0,0,0,0,1,0\n", "CSYS/0,0,1,0,1,0,0,0,0,1,0,0\n"
    found = made("TRNTYP/WORLD\n" + first + "GOTO/1,2,3\n" + second + "GOTO/4,5,6")
    assert [m.end for m in found] == [mm((1, 2, 3)), mm((4, 5, 6))]
    assert found[1].rotary_end == pytest.approx((0.0, math.pi / 2, 0.0))
    alone = made("TRNTYP/WORLD\n" + second + "GOTO/4,5,6")[0]
    assert (alone.end, alone.rotary_end) == (mm((5, 6, 4)), (0.0, 0.0, 0.0))
    local = made("MSYS/10,0,0,1,0,0,0,1,0\nGOTO/1,2,3\nMSYS/10,5,0,1,0,0,0,1,0\nGOTO/1,2,3")
    assert [m.end for m in local] == [mm((1, 2, 3)), mm((1, 7, 3))]
    with pytest.raises(ScenarioFault, match="square to each other"):
        made("CSYS/1,0,0,0,1,1,0,0,0,0,1,0\nGOTO/1,2,3")


def test_unknown_words_are_refused_all_at_once_each_by_its_name():
    text = HEAD + "".join("FROBN/1\nGOTO/1,0,0\nZZZ/2\n" for _ in range(300)) + "LAST/1\nFINI"
    with pytest.raises(ScenarioFault) as found:
        list(reading(text, "p.cls").commands())
    assert [str(fault)[:40] for fault in found.value.faults] == [
        "p.cls:5:1: FROBN: unknown or unsupported", "p.cls:7:1: ZZZ: unknown or unsupported A",
        "p.cls:905:1: LAST: unknown or unsupporte",
    ]  # fmt: skip
    assert "(300 times, first here)" in str(found.value.faults[0])


def test_a_comment_that_goes_on_is_no_statement():
    found = list(statements("$$-> CSYS / 1.0, 0.0, $\n  0.0, 1.0E+00, $\n -1.0\nGOTO/1,2,3\n$$ five $\nGOTO/4,5,6"))
    assert [s.numbers() for s in found] == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]


def test_motions_behind_the_end_are_told():
    run = reading(HEAD + "GOTO/1,0,0\nFINI\nGOTO/2,0,0", "p.cls")
    assert len(list(moves(run.commands(), start=run.start))) == 1
    assert any("1 motions stand behind the end" in words for words in run.notices())


@pytest.mark.parametrize(
    "text",
    ["CYCLE/DEEP,FEDTO,10,STEP,1E-9,MMPM,100,RAPTO,1\nGOTO/1,0,0",
     "CYCLE/DEEP2,FEDTO,9,1STPECK,1E-30,SUBPECK,1E-30\nGOTO/1,0,0"],
)  # fmt: skip
def test_pecks_without_end_are_refused(text):
    with pytest.raises(ScenarioFault, match=r"p\.cls:6:1: this cycle draws back more often than the limit"):
        list(reading(HEAD + text, "p.cls").commands())


def test_incremental_points_and_numbers_out_of_scale_are_refused():
    for text, words in (("MODE/INCR", "incremental"), ("GOTO/1E10,0,0", "out of scale"), ("LOADTL/1E300", "out of scale"),
                        ("GOTO/1E999,0,0", "out of scale")):  # fmt: skip
        with pytest.raises(ScenarioFault, match=words):
            list(reading(HEAD + text, "p.cls").commands())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("GOTO/1,A,2,3", '"A" is not a number'), ("GOTO/1,2,3,PSIS", '"PSIS" is not a number'),
        ("GOTO/1,,2,3", "a number is missing"), ("GODLTA/,1,2,3", "a number is missing"),
        ("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,A10\nGOTO/0,10,0", '"A10" is not a number'),
        ("FEDRAT/1E-12\nGOTO/1,2,3", "out of scale: feeds begin at"),
    ],
)  # fmt: skip
def test_numbers_that_count_by_their_place_stand_in_a_row(text, said):
    with pytest.raises(ScenarioFault, match=said):
        made(text + "\nFINI")


def test_exponents_of_fortran():
    assert made("GOTO/1.5D1,-2.D0,3E-1\nFINI")[0].end == mm((15, -2, 0.3))
