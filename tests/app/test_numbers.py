"""Numbers as people read them: the examples of the rule, each in one unit and never with another verdict."""

import math

import pytest

from cutwise.app.numbers import amount, form, forms, grouped, held, span, titled
from cutwise.io.scenario import load
from cutwise.spec.scenario import Limit


@pytest.mark.parametrize(("limit", "value", "shown"), [
    ("surface_error_max={max: 0.05 mm}", -9.466e-6, "-0.0095 mm"),
    ("surface_error_max={max: 60 um}", 46.8238e-6, "46.8 µm"),
    ("cutting_power_mean={max: 340 W}", 175.2138, "175 W"),
    ("surface_error_max={max: 0.05 mm}", 1.5617e-25, "< 0.0001 mm"),
    ("surface_error_max={max: 60 um}", 60.004e-6, "60.004 µm"),
    ("surface_error_max={max: 60 um}", 59.9996e-6, "60.0 µm"),
    ("surface_error_max={min: 0.29 mm}", 0.28996e-3, "0.28996 mm"),
    ("fraction_partial={max: 0.2}", 0.1159, "0.116"),
    ("surface_error_max={max: 0 mm}", 0.0, "0 mm"),
    ("surface_error_max={max: 0 mm}", 1.5617e-25, "1.56e-22 mm"),
])  # fmt: skip
def test_with_a_limit(examples, limit, value, shown):
    name, _, ends = limit.partition("=")
    scenario = load(examples / "deburr_compliant_spindle.yaml", [f"requirements={{{name}: {ends}}}"])
    if shown != "1.56e-22 mm":
        assert held(scenario, name, value, scenario.requirements[name]).text == shown
    number = held(scenario, name, value, scenario.requirements[name]).number
    met = value <= (scenario.requirements[name].max if scenario.requirements[name].max is not None else math.inf)
    if scenario.requirements[name].min is None and not number.startswith("<"):
        unit = 1.0 if "W" in ends or "fraction" in name else 1e-6 if "um" in ends else 1e-3
        assert (float(number) <= round(scenario.requirements[name].max / unit, 9)) == met


def test_without_a_limit():
    lengths = [1.5617e-25, 9.1588e-6, 2.2741e-5]
    assert [form("length", lengths).text(value) for value in lengths] == ["0 µm", "9.16 µm", "22.74 µm"]
    forces = [0.42, 38.05, 712.9]
    assert [form("force", forces).number(value) for value in forces] == ["0.4", "38.0", "712.9"]
    assert form("small_length", [1.2e-3]).text(1.2e-3) == "1.200 mm"
    assert form("angle", [math.radians(35.0)]).text(math.radians(35.0)) == "35.00°"
    assert form("small_angle", [360e-6]).unit == "mrad"


def test_the_required_ones_come_first_then_the_focus_then_groups(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    found = grouped(scenario, scenario.measures, scenario.requirements)
    assert found[""] == ["surface_error_max", "surface_error_min", "cutting_power_mean", "surface_error_mean"]
    assert list(found)[1:] == ["surface", "force and power", "motion and time", "structure", "checks"]
    assert sum(map(len, found.values())) == len(scenario.measures)
    assert titled("surface_error_max") == "Surface error, max"


def test_a_small_error_beside_a_long_path_is_not_shown_as_nothing(examples):
    scenario = load(examples / "mill_pocket_corner.yaml")
    values = {"path_length": 0.1, "tracking_error_max_x": 34.2e-6, "settling_overshoot": 9.9e-6}
    shapes = forms(scenario, values, list(values))
    assert [shapes[name].text(values[name]) for name in values] == ["100.0 mm", "34.20 µm", "9.90 µm"]


@pytest.mark.parametrize(("typed", "ends", "shown", "limit"), [
    ("50 um", (-13.75e-6, 480.3e-6), "-13.8 … 480 µm", "50 µm"),
    ("0.05 mm", (-13.75e-6, 480.3e-6), "-0.0138 … 0.48 mm", "0.05 mm"),
    ("50 um", (None, 50.004e-6), "? … 50.004 µm", "50 µm"),  # 50.0 would be within
])  # fmt: skip
def test_a_band_beside_its_limit(examples, typed, ends, shown, limit):
    scenario = load(
        examples / "deburr_compliant_spindle.yaml", [f"requirements={{surface_error_max: {{max: {typed}}}}}"]
    )
    assert span(scenario, "surface_error_max", ends, scenario.requirements["surface_error_max"]) == (shown, limit)
    assert (
        amount(scenario, "surface_error_max", 119.76e-6)
        == f"{119.76 if 'um' in typed else 0.11976:.3g} " + limit.split()[1]
    )


def test_what_stands_between_two_limits(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    both = Limit.model_construct(min=-5e-5, max=5e-5)
    assert span(scenario, "surface_error_max", (0.0,), both) == ("0 mm", "-0.05 to 0.05 mm")


def test_a_tolerance_of_the_part_comes_after_what_is_required(examples):
    scenario = load(examples / "mill_part.yaml", ["requirements={force_xy_peak: {max: 2 kN}}"])
    assert next(iter(scenario.asked)) == "force_xy_peak"
    assert "deviation_max" in scenario.asked


def test_the_position_of_a_robot_says_what_is_not_in_it(examples):
    scenario = load(examples / "drill_robot.yaml")
    said = "compliance only; an uncalibrated arm is off by tenths of a millimetre"
    assert scenario.caveat("hole_position_error_exit") == said
    assert scenario.caveat("thrust_max") == ""
    assert load(examples / "drill_on_machine.yaml").caveat("hole_position_error_exit") == ""


def test_what_does_not_change_is_a_sentence_and_no_plot():
    from matplotlib.figure import Figure

    from cutwise.app.plots.figures import svg

    def drawn(y, bars=False):
        figure = Figure()
        axes = figure.subplots()
        axes.plot(range(len(y)), y)
        axes.axhline(1.0)
        axes.set(ylabel="power [W]")
        if bars:
            axes.bar([0], [1])
        return figure

    assert (
        svg(lambda _: drawn([175.0] * 9), None, "a", "t") == "<p>No curve, since nothing changes: power is 175 W.</p>"
    )
    assert "<svg" in svg(lambda _: drawn([175.0] * 8 + [175.1]), None, "a", "t")
    assert "<svg" in svg(lambda _: drawn([175.0] * 9, bars=True), None, "a", "t")
