"""Compensation of a path: the digits of the corner of the reference, and the written program read back."""

import math

import numpy as np
import pytest
from scipy.special import ndtri

import cutwise
from cutwise.io.scenario import load
from cutwise.process import milling
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct import path, shift
from cutwise.study.correct.uncertain import read_draws

UM = 1e-6


@pytest.fixture(scope="module")
def corner(examples):
    return lambda *given: load(examples / "mill_pocket_corner.yaml", ["path.compare=[]", *given])


def learned(scenario, most=8, lead=None, smoothing=None, plants=None):
    told = milling.commanded(scenario, scenario.numerics.substeps)
    rule = shift.rule_of(told, scenario.drives.limits.jerk, lead, smoothing)
    return told, shift.learn(plants or [shift.Plant(scenario, told)], rule, most)


# largest contour error before and after each repetition [µm], by an independent program
TRAILS = [
    ("2 mm", "40 mm/s", 0.0, 0.0, [37.94, 12.36, 13.11]),
    ("2 mm", "40 mm/s", 0.0, 4e-3, [37.94, 11.59, 6.27, 4.52, 3.70, 2.84, 2.94]),
    ("2 mm", "40 mm/s", None, None, [37.94, 9.92, 3.35, 1.45, 0.81, 0.87]),
    ("5 mm", "40 mm/s", 4e-3, 2e-3, [21.96, 5.97, 2.23, 0.97, 0.61]),
    ("2 mm", "20 mm/s", 4e-3, 2e-3, [17.57, 4.83, 1.94, 0.87, 0.67]),
    ("5 mm", "80 mm/s", 4e-3, 2e-3, [56.2, 14.0, 4.5, 1.9, 1.6]),
]


@pytest.mark.parametrize(("fillet", "feed", "lead", "smoothing", "trail"), TRAILS)
def test_each_repetition_leaves_the_error_of_the_reference(corner, fillet, feed, lead, smoothing, trail):
    found = learned(corner(f"path.corner={fillet}", f"operation.feed={feed}"), 8, lead, smoothing)[1]
    count = min(len(trail), len(found.trail))
    assert count >= min(len(trail), 3)
    assert [e / UM for e in found.trail[:count]] == pytest.approx(trail[:count], abs=0.05)


def test_lead_and_smoothing_are_chosen_and_the_rule_converges(corner):
    """Reference: 4 ms, 2 ms, c 0.743 and 0.552; without both 1.618 and 1.471."""
    rule = learned(corner("path.corner=2 mm"), 0)[1].rule
    assert (rule.lead, rule.smoothing) == (4, 2)
    assert rule.convergence == pytest.approx((0.743, 0.552), abs=5e-4)
    plain = learned(corner("path.corner=2 mm"), 0, 0.0, 0.0)[1].rule
    assert plain.convergence == pytest.approx((1.618, 1.471), abs=5e-4)


def radical_inverse(n, base):
    value, share = 0.0, 1.0 / base
    while n:
        value, n, share = value + share * (n % base), n // base, share / base
    return value


def table(folder, scenario):
    """Points 1 to 40 judge, 101 to 109 are fitted: J, B, four torques of friction and K_t of both axes together."""
    titles, rows = [], []
    names = {"J": "kg m^2", "B": "N m s/rad", "friction.stiction_plus": "N m", "friction.stiction_minus": "N m",
             "friction.coulomb_plus": "N m", "friction.coulomb_minus": "N m", "K_t": "N m/A"}  # fmt: skip
    for axis in "xy":
        titles += [f"machine.{axis}.{name} [{unit}]" for name, unit in names.items()]
    for n in (*range(1, 41), *range(101, 110)):
        j, b, f, k = (
            1.0 + c * ndtri(radical_inverse(n, base))
            for c, base in zip((0.05, 0.1, 0.15, 0.03), (2, 3, 5, 7), strict=True)
        )
        row = []
        for axis in "xy":
            drive = getattr(scenario.machine, axis)
            torques = [getattr(drive.friction, name.split(".")[1]) * f for name in names if "friction" in name]
            row += [drive.J * j, drive.B * b, *torques, drive.K_t * k]
        rows.append(", ".join(map(repr, map(float, row))))
    file = folder / "draws.csv"
    file.write_text("\n".join([", ".join(titles), *rows, ""]))
    return str(file)


def test_what_is_not_known_is_not_compensated(corner, tmp_path):
    """Reference: median, p80, p90, largest of 40 machines before, with the nominal shift, with that of 9 machines."""
    scenario = corner("path.corner=2 mm")
    rows = read_draws(scenario, table(tmp_path, scenario))
    told, nominal = learned(scenario, 4)
    judging, fitted = (
        [path._drawn(shift.Plant(scenario, told), row) for row in some] for some in (rows[:40], rows[40:])
    )

    def quantiles(order):
        return np.quantile(np.abs(shift.errors(judging, order)).max(axis=1) / UM, [0.5, 0.8, 0.9, 1.0])

    assert quantiles(told.order)[:2] == pytest.approx([37.98, 39.62], abs=0.05)
    assert quantiles(shift.shifted(told, nominal.at(told.place.travelled))) == pytest.approx(
        [2.53, 3.68, 4.08, 6.62], abs=0.05
    )
    mean = learned(scenario, 4, plants=fitted)[1]
    assert quantiles(shift.shifted(told, mean.at(told.place.travelled))) == pytest.approx(
        [2.47, 3.39, 3.87, 4.60], abs=0.05
    )


@pytest.mark.parametrize(("reading", "before", "after"), [("matched", 34.89, 2.26), ("as_printed", 7.68, 28.5)])
def test_a_shift_of_one_reading_may_spoil_the_part_on_another(corner, reading, before, after):
    told, found = learned(corner("path.corner=2 mm"), 4)
    other = corner("path.corner=2 mm", f"machine.reading={reading}")
    there = milling.commanded(other, 10)
    sizes = [
        float(np.abs(shift.errors([shift.Plant(other, there)], order)).max()) / UM
        for order in (there.order, shift.shifted(there, found.at(told.place.travelled)))
    ]
    assert sizes == pytest.approx([before, after], abs=0.05)


def test_vertices_of_the_written_path(corner):
    """Reference: 344 of 0.1 mm, 173 of 0.2 mm, 88 of 0.4 mm."""
    told, found = learned(corner("path.corner=2 mm"), 4)
    assert [len(shift.chords(told.wanted, found, h)[0]) for h in (1e-4, 2e-4, 4e-4)] == [344, 173, 88]


@pytest.fixture(scope="module")
def proved(corner):
    return cutwise.correct(corner("path.corner=2 mm"), ("path",))


def test_the_written_program_is_what_is_reported(proved, tmp_path):
    """Read back from the file, with the program before beside it, it leaves what was told: at most a tenth."""
    program = proved.scenario.program
    (tmp_path / "new.nc").write_text(proved.program)
    (tmp_path / "old.nc").write_text(program.wanted.text)
    document = proved.scenario.document()
    document["program"] = {
        key: value for key, value in document["program"].items() if key not in ("text", "wanted", "file")
    }
    document["program"] |= {"file": "new.nc", "wanted": "old.nc"}
    import json

    (tmp_path / "again.json").write_text(json.dumps(document))
    again = load(tmp_path / "again.json")
    done = milling.run(again, again.numerics.substeps)
    left = float(np.nanmax(np.abs(done.contour_error)))
    assert left == pytest.approx(proved.measures["residual_max"].value, rel=1e-9)
    assert left < 0.1 * 37.94 * UM
    assert proved.measures["residual_ratio"].value < 0.1
    assert proved.measures["contour_error_max_after"].value == pytest.approx(left, rel=1e-9)
    assert proved.good


def test_chords_run_without_braking(proved):
    done = milling.run(proved.scenario, 10)
    fillet = (done.place.travelled > 0.028) & (done.place.travelled < 0.031)
    assert done.reference.speed[fillet].min() > 0.0398


def test_every_line_that_is_not_shifted_stays(examples):
    found = cutwise.correct(load(examples / "mill_pocket.yaml", ["requirements=null"]), ("path",))
    old, new = found.scenario.program.wanted.text.split("\n"), found.program.split("\n")
    kept = [line for line in old if line in new]
    assert all(line in new for line in old if line.startswith("(")), "comments stay"
    assert new[:10] == old[:10]
    assert len(kept) > 10
    assert found.measures["residual_ratio"].value < 0.1
    assert not [line for line in new if line.startswith(("G2 ", "G3 "))]


def test_a_path_corrected_twice_is_that_corrected_once(proved):
    twice = cutwise.correct(proved.scenario, ("path",))
    assert twice.program == proved.program
    assert twice.measures["residual_max"].value == pytest.approx(proved.measures["residual_max"].value, rel=1e-9)


def test_an_assumed_reading_that_decides_is_refused(corner):
    with pytest.raises(ScenarioFault, match="frequency response of the position loops decides"):
        cutwise.correct(corner("path.corner=2 mm", "machine.reading=null"), ("path",))


def test_a_program_that_strays_is_no_correction(examples):
    text = "G21 G90 G61 S8000 M3\nG0 X50 Y26 Z5\nG1 Z-5 F300\nG1 X90 F2400\nM2\n"
    scenario = load(examples / "mill_pocket.yaml")
    document = scenario.document()
    document["program"]["wanted"] = {"file": "other.nc", "text": text}
    from cutwise.io.scenario import read_document

    other = read_document(document)
    with pytest.raises(ScenarioFault, match="which is no correction"):
        milling.commanded(other, 10)


def test_what_nothing_corrects_is_refused_in_words(examples, corner):
    with pytest.raises(ScenarioFault, match="a stock in 3D"):
        cutwise.correct(load(examples / "mill_part.yaml"), ("path",))
    with pytest.raises(ScenarioFault, match="is not held by change: path"):
        cutwise.correct(corner("path.corner=2 mm", "correct={change: [path], limits: {force_xy_peak: {max: 600 N}}}"))


def test_a_limit_of_the_shift_is_kept_and_told(corner):
    found = cutwise.correct(corner("path.corner=2 mm", "correct={change: [path], shift_max: 10 um}"))
    assert found.measures["shift_max"].value <= 10.0 * UM * (1 + 1e-9)
    assert not found.good
    assert any("correct.shift_max" in why for why in found.reasons)


def test_what_a_drive_runs_on_beyond_an_end_does_not_spoil_the_shift(examples, tmp_path):
    """A cut that ends at a rapid move: the overshoot lies along the path, and is none of the shift's."""
    file = tmp_path / "ends.nc"
    file.write_text(
        "G21 G17 G90 G61\nS8000 M3\nG0 X0 Y0 Z5\nG1 Z-5 F300\nG1 X20 F2400\nG3 X24 Y4 J4\nG1 Y20\nG0 Z5\nM2\n"
    )
    told, found = learned(load(examples / "mill_pocket.yaml", [f"program={file}", "requirements=null"]), 4)
    assert found.trail[-1] < 0.1 * found.trail[0]
    active = shift.window(told)
    end = told.place.time[told.place.block <= 4][-1]  # of the last cut
    assert not active[(told.place.time > end - 0.02) & (told.place.time <= end)].any()
    assert np.abs(np.diff(found.shift)).max() < 2.0 * UM, "no jump at the end of a window"


def test_a_control_without_a_word_for_the_tolerance_of_joints_is_refused(examples):
    with pytest.raises(ScenarioFault, match="no word for the tolerance"):
        cutwise.correct(
            load(examples / "mill_pocket.yaml", ["program.dialect=fanuc", "program.file=mill_pocket.nc"]), ("path",)
        )


def test_draws_with_faults_are_told_at_their_line(corner, tmp_path):
    file = tmp_path / "draws.csv"
    file.write_text("machine.x.J [kg m^2], machine.x.Q [N]\n0.0078, 1\n0.0079, x\n1\n")
    with pytest.raises(ScenarioFault) as fault:
        read_draws(corner(), str(file))
    assert [one.line for one in fault.value.faults] == [1, 3, 4]


def test_right_of_a_turned_path():
    normal = shift.right_normal(np.array([[math.cos(0.3), math.sin(0.3), 0.0]]))
    assert normal[0] == pytest.approx([math.sin(0.3), -math.cos(0.3)])
