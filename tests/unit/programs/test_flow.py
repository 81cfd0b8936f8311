"""Subroutines, branches, loops; variables and where they hold."""

import pytest

from cutwise.io.program_setup import library_beside, subroutine_files
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup


def said(text, library=None):
    """What a program says to its operator."""
    run = Rs274(text, "p.ngc", Setup(library=library))
    return [command.text.strip() for command in run.commands() if type(command).__name__ in ("Message", "Printed")]


def test_arguments_and_variables_of_a_subroutine_are_its_own():
    text = """
    #1=5 #40=6 #<a>=7 #<_own>=8
    o1 sub
      (debug,%d#1 #2 #3 #40 #<a> #<_own>)
      #1=50 #40=60 #<a>=70 #<_own>=80
    o1 endsub
    o1 call [1] [2]
    (debug,%d#1 #2 #40 #<a> #<_own>)
    """
    assert said(text) == ["1 2 0 6 ###### 8", "5 0 60 7 80"]


def test_a_numbered_program_shares_all_variables_and_repeats():
    assert said("#1=5\nM98 P9 L3\n(debug,%d#1)\nM98 P9 L0\nM2\nO9\n#1=[#1+1]\nM99") == ["8"]
    nested = "M98 P1 L2\n(debug,%.2f#1)\nM2\nO1\n#1=[#1+1]\nM98 P2 L3\nM99\nO2\n#1=[#1+0.01]\nM99"
    assert said(nested) == ["2.06"]


def test_values_come_back():
    text = "o1 sub\no2 if [#1 gt 0]\no1 return [#1*2]\no2 endif\no1 endsub\n"
    assert said(text + "o1 call [3]\n(debug,%d#<_value> #<_value_returned>)") == ["6 1"]
    assert said(text + "o1 call [0]\n(debug,%d#<_value> #<_value_returned>)") == ["0 0"]


@pytest.mark.parametrize(("given", "branch"), [(1, "one"), (2, "two"), (3, "three"), (4, "more")])
def test_branches(given, branch):
    text = f"""
    #1={given}
    o1 if [#1 eq 1]
    (debug,one)
    o1 elseif [#1 eq 2]
    (debug,two)
    o1 elseif [#1 eq 3]
    (debug,three)
    o1 else
    (debug,more)
    o1 endif
    """
    assert said(text) == [branch]


def test_loops():
    assert said("o1 while [#1 lt 3]\n#1=[#1+1]\n(debug,%d#1)\no1 endwhile") == ["1", "2", "3"]
    assert said("o1 do\n#1=[#1+1]\n(debug,%d#1)\no1 while [#1 lt 0]") == ["1"]
    assert said("o1 repeat [2.6]\n(debug,x)\no1 endrepeat\no2 repeat [-1]\n(debug,y)\no2 endrepeat") == ["x"] * 3
    skipping = (
        "o1 while [#1 lt 5]\n#1=[#1+1]\no2 if [#1 eq 2]\no1 continue\no2 endif\no3 if [#1 eq 4]\no1 break\no3 endif"
    )
    assert said(skipping + "\n(debug,%d#1)\no1 endwhile") == ["1", "3"]


def test_loops_within_loops_and_recursion():
    text = "o1 repeat [2]\no2 repeat [3]\n#1=[#1+1]\no2 endrepeat\no1 endrepeat\n(debug,%d#1)"
    assert said(text) == ["6"]
    factorial = """
    o<fac> sub
      o<end> if [#1 le 1]
        o<fac> return [1]
      o<end> endif
      o<fac> call [#1 - 1]
    o<fac> endsub [#1 * #<_value>]
    o<fac> call [5]
    (debug,%d#<_value>)
    """
    assert said(factorial) == ["120"]


def test_labels_by_value_and_names_as_they_come():
    assert said(
        "o12 sub\n(debug,here)\no12 endsub\n#3=10\no[#3+2] call\no#4 call" + "\n" * 0 + "\nm2\no0 sub\no0 endsub"
    ) == ["here"]
    assert said("O<My Sub> SUB\n(debug,%d#< A b >)\nO<mysub> ENDSUB\n#<ab>=1\no<MYSUB> call") == ["######"]


def test_assignments_take_effect_behind_their_block():
    assert said("#1=2\n#1=3 #2=#1\n(debug,%d#1 #2)") == ["3 2"]
    run = Rs274("#3=15 g21\n#3=6 g0 x#3\nm2", "p")
    assert next(c.x for c in run.commands() if type(c).__name__ == "Traverse") == 15.0


def test_subroutine_files_beside_the_program(tmp_path):
    (tmp_path / "outer.ngc").write_text("o<outer> sub\n(debug,outer %d#1)\no<inner> call [#1+1]\no<outer> endsub\nm2")
    (tmp_path / "inner.ngc").write_text("(a comment)\no<inner> sub\n(debug,inner %d#1)\no<inner> endsub [9]")
    text = "o<outer> call [1]\n(debug,%d#<_value>)\nm2"
    library = library_beside(tmp_path)
    assert said(text, library) == ["outer 1", "inner 2", "0"]
    assert sorted(subroutine_files(text, library)) == ["inner", "outer"]
    assert library("../outer") is None


def test_modes_are_saved_and_restored_at_each_level():
    text = "g21 g90\nm70\ng20 g91\no1 sub\nm73\ng90 f5\no1 endsub\no1 call\n(debug,%d#<_metric> #<_absolute>)\nm72\n"
    assert said(text + "(debug,%d#<_metric> #<_absolute> #<_feed>)") == ["0 0", "1 1 0"]


def test_the_state_of_the_controller_can_be_asked():
    text = "g20 g18 g91 g98 g55 f7 s8 m4 m7 t2 m6\n(debug,%d#<_imperial> #<_plane> #<_incremental> #<_retract_old_z> "
    text += "#<_coord_system> #<_feed> #<_rpm> #<_spindle_on> #<_mist> #<_current_tool> #5400 #5220 #<_line>)"
    assert said(text) == ["1 180 1 1 550 7 8 1 1 2 2 2 2"]
    moved = "g21 g90\ng10 l2 p1 x10 r90\ng0 x1 y2\n(debug,%d#5420 #5421 #<_x> #<_abs_x> #<_abs_y> #5021 #5221 #5230)"
    assert said(moved) == ["1 2 1 8 1 8 10 90"]
