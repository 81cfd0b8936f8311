"""CSV tables: every fault with its row and column."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutwise.io.tables import read_table
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.part import BurrHeightTable

OVER, ORDINATE = BurrHeightTable.over, BurrHeightTable.ordinate


def read(tmp_path, content):
    path = tmp_path / "burr.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_table(path, "burr.csv", ("part", "burr", "height"), OVER, ORDINATE)


def faults(tmp_path, content):
    with pytest.raises(ScenarioFault) as caught:
        read(tmp_path, content)
    return [(fault.line, fault.column, fault.message) for fault in caught.value.faults]


def test_columns_by_title_in_any_order_and_case_with_comments(tmp_path):
    content = "# measured on Monday\nHeight [um], station, w [cm]\n\n500, 3, 0\n 1.5e3 ,4,  3\n"
    assert read(tmp_path, content) == {"w [cm]": [0.0, 3.0], "Height [um]": [500.0, 1500.0]}


def test_a_byte_order_mark_and_quotes_do_no_harm(tmp_path):
    assert read(tmp_path, b'\xef\xbb\xbf"w [mm]","height [mm]"\r\n0,1\r\n1,2\r\n')["w [mm]"] == [0.0, 1.0]


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("w [mm], height [mm]\n0, 1\n1,\n2, 3\n", (3, 3, "a hole in column height [mm]")),
        ("w [mm], height [mm]\n0, 1\n1\n2, 3\n", (3, 2, "a hole in column height [mm]")),
        ("w [mm], height [mm]\n0, abc\n1, 1\n2, 3\n", (2, 4, '"abc" is not a number in column height [mm]')),
        ("w [mm], height [mm]\n0, nan\n1, 1\n2, 3\n", (2, 4, '"nan" is not a number')),
        ("w [mm], height\n0, 1\n1, 1\n", (1, 9, 'write the title with its unit, for example "height [mm]"')),
        ("w [mm], height [bar]\n0, 1\n1, 1\n", (1, 9, 'column height: "bar" is not a unit of length')),
        ("w [mm], height [mm]\n1, 1\n0, 1\n", (3, 1, "w = 0 comes after 1; sort the rows by w")),
        ("w [mm], height [mm]\n0, 1\n0, 1\n", (3, 1, "w = 0 is repeated; w must increase")),
        ("w [mm], height [mm]\n0, 1\n1, -1\n", (3, 4, "-1 is impossible; height must be at least 0")),
        ("w [mm], height [mm]\n0, 1\n", (1, 1, "has 1 row; at least two are needed")),
        ("w [mm], height [mm]\n", (1, 1, "has 0 rows; at least two are needed")),
        ("", (None, None, 'is empty; it needs a title line such as "w [mm], height [mm]"')),
        ("w [mm], hight [mm]\n0, 1\n1, 1\n", (1, 1, 'needs a column "height [mm]"; found: w [mm], hight [mm]')),
        ("w [mm]; height [mm]\n0; 1\n1; 2\n", (1, 1, "separated by semicolons; separate them by commas, for")),
        ("w [mm]; height [mm]\n0; 1,5\n1; 2\n", (1, 1, "and write decimal points in place of decimal commas")),
        ("w [mm]\theight [mm]\n0\t1\n1\t2\n", (1, 1, "columns are separated by tabs")),
        ("w [mm], height [mm]\n0,0,1,5\n1, 1\n2, 3\n", (2, 1, "4 values for 2 columns; decimal commas?")),
        ("w [mm], height [mm], w [mm]\n0, 1, 2\n1, 1, 3\n", (1, 22, "column w [mm] is there twice")),
        ("w [mm], height [mm]\n0, 1\n1, 1\n".encode("utf-16"), (None, None, "is UTF-16 text")),
        (b"w [\xb5m], height [mm]\n0, 1\n", (1, 4, "byte 0xb5 is not UTF-8 text")),
    ],
)  # fmt: skip
def test_each_fault_is_named_with_its_place(tmp_path, content, expected):
    found = faults(tmp_path, content)
    line, column, message = expected
    assert any((line, column) == fault[:2] and message in fault[2] for fault in found), found
    assert len(found) == 1


def test_all_faults_at_once(tmp_path):
    found = faults(tmp_path, "w, height [bar]\n0, x\n2, 1\n1, \n1, 3\n")
    assert [fault[:2] for fault in found] == [(1, 1), (1, 4), (2, 4), (4, 4), (5, 1)]


def test_a_flood_of_faults_is_cut_short(tmp_path):
    found = faults(tmp_path, "w [mm], height [mm]\n" + "x, x\n" * 1000)
    assert len(found) == 21
    assert found[-1][2] == "and 1980 more faults in this file"


@given(st.lists(st.floats(0, 1e6), min_size=2, max_size=30, unique=True), st.randoms(use_true_random=False))
def test_points_are_those_of_the_file(tmp_path_factory, places, random):
    heights = [random.random() for _ in places]
    rows = "\n".join(f"{w!r},{h!r}" for w, h in zip(sorted(places), heights, strict=True))
    columns = read(tmp_path_factory.mktemp("csv"), f"w [m],height [m]\n{rows}\n")
    assert BurrHeightTable(columns=columns).points() == (tuple(sorted(places)), tuple(heights))
