"""Tool tables in the format of LinuxCNC."""

import math

import pytest

from cutwise.io.program_setup import tool_table
from cutwise.programs.tools import read_tool_table
from cutwise.spec.faults import ScenarioFault

TABLE = "T1 P1 D6.0 Z+50.5 ; end mill\n\n; a comment\nt12 p3 x1 a90 d10 i5 j10 q3\n"


def test_a_table():
    tools = read_tool_table(TABLE, "t.tbl", inch=False)
    assert list(tools) == [1, 12]
    assert (tools[1].diameter, tools[1].offset[2], tools[1].notice) == (
        pytest.approx(6e-3),
        pytest.approx(50.5e-3),
        "end mill",
    )
    twelve = tools[12]
    assert (twelve.pocket, twelve.orientation) == (3, 3)
    assert twelve.offset[0] == pytest.approx(1e-3)
    assert twelve.offset[3] == pytest.approx(math.pi / 2)
    assert twelve.front_angle == pytest.approx(math.radians(5))


def test_inches_are_known_by_the_program_or_by_diameters_that_no_mill_has():
    assert tool_table("T1 D0.25", "t", "G20")[1].diameter == pytest.approx(6.35e-3)
    assert tool_table("T1 D6", "t", "G21")[1].diameter == pytest.approx(6e-3)
    assert tool_table("T1 D0.0625\nT2 D1", "t", "G21")[2].diameter == pytest.approx(25.4e-3)


def test_every_wrong_line_is_named():
    with pytest.raises(ScenarioFault) as found:
        read_tool_table("T1 D6\nhello\nP3 D2\nT2 Y1 Y2\nT3 F5\nT1 D8\nT1.5", "t.tbl", inch=False)
    assert [str(fault).split(":")[1] for fault in found.value.faults] == ["2", "3", "4", "5", "6", "7"]
    assert "F has no meaning" in str(found.value)


def test_numbers_out_of_scale_are_refused():
    with pytest.raises(ScenarioFault, match=r"t\.tbl:1:4: 1e\+39 is out of scale"):
        read_tool_table("T1 D1" + "0" * 39, "t.tbl", inch=False)
