"""A place in a program: the line of the file and the number of the block, which are not the same."""

from cutwise.programs.block_text import block_named, blocks_named

TEXT = "%\nO1\nN100 G21\nN105 G1 X20\t(to the wall)\n\nG1 X30\n/N110 X40 " + "Y1" * 60 + "\n"


def test_line_and_block_are_both_said_with_the_text():
    assert block_named(TEXT, 4) == "line 4 of the program (block N105: N105 G1 X20 (to the wall))"
    assert block_named(TEXT, 6) == "line 6 of the program (G1 X30)"
    assert block_named(TEXT, 7).startswith("line 7 of the program (block N110: /N110 X40 Y1Y1")
    assert len(block_named(TEXT, 7)) < 100
    assert block_named("", 22) == block_named(TEXT, 99).replace("99", "22") == "line 22 of the program"


def test_many_lines_are_named_by_their_blocks():
    assert blocks_named(TEXT, (4, 6)) == "lines 4 (N105), 6 of the program"
    assert blocks_named(TEXT, (4,)) == block_named(TEXT, 4)
    assert blocks_named("", tuple(range(1, 13))) == "lines 1, 2, 3, 4, 5, 6, 7, 8 and 4 more of the program"


def test_control_characters_are_not_handed_on():
    assert block_named("N1 G1\rM3\x1b[2J X1", 1) == "line 1 of the program (block N1: N1 G1 M3 [2J X1)"
