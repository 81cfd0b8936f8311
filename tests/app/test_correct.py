"""``cutwise correct``: what comes back, and with which exit code."""

import json

import pytest

from cutwise.io.scenario import load
from cutwise.programs.interpreter import interpret

EXAMPLE = "correct_pocket.yaml"


@pytest.fixture
def desk(tmp_path, examples):
    for name in (EXAMPLE, "mill_pocket.nc", "mill_part.yaml", "mill_part.nc", "mill_part.step", "mill_pocket.yaml"):
        (tmp_path / name).write_bytes((examples / name).read_bytes())
    return tmp_path


def test_the_example_saves_a_quarter_and_more_at_equal_force_and_wall(cutwise, desk):
    out = desk / "better.nc"
    done = cutwise("correct", desk / EXAMPLE, "-o", out, "--report", desk / "page.html", "--json")
    assert done.code == 0
    told = json.loads(done.out)
    value = {name: one["value"] for name, one in told["measures"].items()}
    assert value["time_before"] == pytest.approx(24.478, abs=1e-3)
    assert value["time_saved"] >= 0.25
    assert value["time_bound"] < value["time_after"]
    assert value["force_xy_peak_after"] <= 1.01 * value["force_xy_peak_before"]
    assert value["wall_error_min_after"] >= 1.01 * value["wall_error_min_before"]
    assert value["contour_error_max_after"] <= 70e-6
    text = out.read_text(encoding="utf-8")
    assert text == told["program"]
    ends = [move.end for move in interpret((desk / "mill_pocket.nc").read_text(), "a").moves]
    found = [move.end for move in interpret(text, "b").moves]
    assert found[-1] == pytest.approx(ends[-1], abs=1e-12)
    assert all(any(end == pytest.approx(one, abs=1e-9) for one in found) for end in ends)  # every corner is still there
    again = load(desk / EXAMPLE, {"program": str(out)})
    assert again.program.text == text
    page = (desk / "page.html").read_text(encoding="utf-8")
    assert "S9700" in page
    assert "<svg" in page


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--change", "offset"), "offset is not there yet"),
        (("--change", "depth"), "says how deep it cuts"),
        (("--change", "feed,spedd"), "did you mean speed?"),
        (("--objective", "cost"), "shop: missing"),
        (("--format", "krl"), "krl"),
        (("--range", "operation.spindle_speed=8000..9000"), "has no unit"),
        (("--range", "spindle"), "is not of the form"),
        (("--set", "correct.limits.force_xy_pek={max: 3 N}"), "did you mean force_xy_peak?"),
        (("--set", "correct.limits.force_xy_peak={min: 3 N}"), "held to a max alone"),
        (("--set", "correct.limits.plunge_force_max={max: 3 N}"), "write tool.end_core"),
        (("--set", "tool.stiffness=null", "--set", "correct.limits.wall_error_min=equal"), "the tool is rigid"),
    ],
)
def test_what_is_not_there_is_refused_by_name(cutwise, desk, options, words):
    done = cutwise("correct", desk / EXAMPLE, *options, "-o", desk / "out.nc")
    assert done.code == 2
    assert words in done.err
    assert "Traceback" not in done.err
    assert not (desk / "out.nc").exists()


def test_inputs_are_not_written_over(cutwise, desk):
    before = (desk / "mill_pocket.nc").read_bytes()
    done = cutwise("correct", desk / EXAMPLE, "-o", desk / "mill_pocket.nc")
    assert done.code == 2
    assert (desk / "mill_pocket.nc").read_bytes() == before


def test_a_stock_in_3d_without_a_machine_is_refused_in_words(cutwise, desk):
    done = cutwise("correct", desk / "mill_part.yaml")
    assert done.code == 2
    assert "what it can do says how fast moves in air may be" in done.err


def test_a_wall_that_no_feed_changes_is_named_and_written_only_by_force(cutwise, desk):
    limit = ("--change", "feed", "--set", "correct.limits.wall_error_min={min: -7 um}", "-o", desk / "out.nc")
    done = cutwise("correct", desk / EXAMPLE, *limit)
    assert done.code == 1
    assert "no feed keeps wall_error_min -7 µm" in done.out
    assert not (desk / "out.nc").exists()
    assert cutwise("correct", desk / EXAMPLE, *limit, "--force").code == 1
    assert (
        (desk / "out.nc")
        .read_text(encoding="utf-8")
        .split("\n")[1]
        .startswith("(cutwise: not good enough: no feed keeps")
    )


def test_without_a_stock_feeds_do_not_rise(cutwise, desk):
    done = cutwise("correct", desk / "mill_pocket.yaml", "--dry-run")
    assert done.code == 1
    assert "feeds may fall and not rise" in done.out
    assert "nothing is gained" in done.out


def test_the_bytes_of_the_program_stay(cutwise, desk):
    text = (desk / "mill_pocket.nc").read_text().replace("(pass 1)", "(passé 1)").replace("\n", "\r\n")
    (desk / "old.nc").write_bytes(text.encode("latin-1"))
    done = cutwise("correct", desk / EXAMPLE, "--change", "feed", "--set", "program=old.nc", "-o", desk / "new.nc")
    assert done.code == 0
    new = (desk / "new.nc").read_bytes()
    assert "(passé 1)\r\n".encode("latin-1") in new
    assert new.count(b"\n") == new.count(b"\r\n")
