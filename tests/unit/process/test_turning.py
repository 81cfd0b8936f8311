"""Turning of a shaft against closed forms, and what it says and refuses."""

import math
from itertools import pairwise

import numpy as np
import pytest

from cutwise.physics.cutting.insert import chip_slopes
from cutwise.process.recipes import quick_outcome, simulate
from cutwise.process.turning import passes, run, setup
from cutwise.spec.faults import ScenarioFault
from peers.turned import scenario, turned


def test_a_clamped_bar_is_a_cantilever():
    """u_y = F_p z^3 / 3EI + F_x r z^2 / 2EI with the bar as thick as it stands between chuck and tool."""
    (done,) = turned()
    bending = 210e9 * math.pi * 0.022**4 / 64.0
    force, z, r = done.rest.total, done.z, done.goal
    expected = force[:, 1] * z**3 / (3 * bending) + force[:, 0] * r * z**2 / (2 * bending)
    assert done.moved()["work"][:, 1] == pytest.approx(expected, rel=1e-5, abs=1e-15)
    along = force[:, 2] * z**3 / (3 * bending)
    radius = np.hypot(r + expected, along)
    assert done.error == pytest.approx(2 * (radius - r), rel=1e-5, abs=1e-13)


def test_between_rigid_centres_it_is_a_beam_on_two_hinges_half_turned():
    """Integral of the moment squared over EI on both sides of the tool."""
    (done,) = turned(lathe__headstock="centre", lathe__tailstock="centre")
    length, z = 0.3, done.z
    thin, thick = (210e9 * math.pi * d**4 / 64.0 for d in (0.020, 0.022))
    c = ((length - z) / length) ** 2 * z**3 / (3 * thick) + (z / length) ** 2 * (length - z) ** 3 / (3 * thin)
    assert done.parts["work"][:, 1, 1] == pytest.approx(c, rel=1e-6, abs=1e-18)


def test_a_spring_pass_cuts_what_deflection_left():
    """Each pass leaves less, and what is left can only shrink."""
    done = turned(operation__spring_passes=3)
    left = [one.error.max() for one in done]
    assert all(after < before for before, after in pairwise(left))
    assert left[0] > 0.0


def test_copying_of_run_out_is_that_of_the_copying_factor():
    """dr/dR = g / (1 + g), g = n C dF/da along the radius to the edge; on a straight edge dF/da is K f and K_te / sin k."""
    case = scenario(part__runout="2 um", material__K_re="0 N/mm", part__stock_diameter="24 mm", lathe__tailstock="centre",
                    lathe__tailstock_stiffness="30 N/um")  # fmt: skip
    found = quick_outcome(case).measures["roundness_error_max"]
    (done,) = run(setup(case))
    k = math.radians(45.0)
    across = 900e6 * 0.2e-3
    rate = np.array([-across * math.sin(k), across * math.cos(k), 2000e6 * 0.2e-3 + 30e3 / math.sin(k)])
    bent = sum(part[:, :3, :3] for part in done.parts.values()) @ rate
    u = sum(done.moved().values())
    g = ((done.goal + u[:, 1]) * bent[:, 1] + u[:, 2] * bent[:, 2]) / np.hypot(done.goal + u[:, 1], u[:, 2])
    assert found == pytest.approx(2e-6 * (g / (1 + g)).max(), rel=1e-3)


def test_passes_of_a_stepped_shaft():
    """A section that a pass does not reach is left alone; each has its feed in the last pass."""
    sections = [{"length": "100 mm", "diameter": "22 mm"}, {"length": "100 mm", "diameter": "20 mm"},
                {"length": "100 mm", "diameter": "14 mm", "feed": "0.1 mm/rev"}]  # fmt: skip
    case = scenario(part__sections=sections, operation__passes=4, operation__finish_depth="0.5 mm")
    planned = list(passes(case))
    radii = 1e3 * np.array([one.goal for one in planned])
    assert radii == pytest.approx(np.array([
        [11, 10.5, 11 - 3.5 / 3], [11, 10.5, 11 - 7 / 3], [11, 10.5, 7.5], [11, 10, 7],
    ]))  # fmt: skip
    assert [list(one.turned) for one in planned] == [
        [False, True, True],
        *[[False, False, True]] * 2,
        [False, True, True],
    ]
    assert planned[-1].feed == pytest.approx([0.2e-3, 0.2e-3, 0.1e-3])
    done = run(setup(case))
    assert done[-1].z.min() == pytest.approx(0.1)
    time = quick_outcome(case).measures["cycle_time"]
    turns = [0.1 / 0.2e-3 / (3 / r) for r in 1e-3 * np.array([10.5, 9.8333333, 8.6666667, 7.5, 10.0])]
    assert time == pytest.approx(2 * math.pi * (sum(turns) + 0.1 / 0.1e-3 / (3 / 7e-3)), rel=1e-6)


def test_a_slender_bar_chatters_and_says_so():
    chat = {"part__density": "7850 kg/m^3", "part__damping": 0.02}
    found = simulate(scenario(**chat))
    assert found.verdict == "fail"
    assert [one.code for one in found.findings if one.code == "unstable"] == ["unstable"]
    assert found.measures["depth_margin"].value < 0.0
    short = [{"length": "25 mm", "diameter": "20 mm"}]
    assert quick_outcome(scenario(**chat, part__sections=short)).measures["depth_margin"] > 0.0


def test_thin_chips_are_told():
    said = scenario(material__chip_thickness_min="20 um", operation__spring_passes=1)
    (told,) = (text for text in simulate(said).warnings if text.startswith("material"))
    assert "this mean chip is" in told


@pytest.mark.parametrize(("changes", "told"), [
    ({"lathe__headstock": "centre"}, "leaves the shaft on one centre"),
    ({"operation__spindle_speed": "900 rpm"}, "write one of cutting_speed and spindle_speed"),
    ({"operation__feed": "0.5 mm/rev"}, "is more than the nose radius"),
    ({"operation__passes": 2, "operation__finish_depth": "1.2 mm"}, "is all that the bar has over the shaft"),
    ({"operation__passes": 2, "operation__finish_depth": "1 mm"}, "is all that the bar has over the shaft"),
    ({"part__stock_diameter": "20 mm"}, "leaves nothing to turn"),
    ({"part__stock_diameter": "19 mm"}, "is larger than the bar"),
    ({"part__damping": 0.02}, "chatter needs both"),
    ({"lathe__steady_position": "400 mm"}, "is beyond the shaft"),
    ({"tool__stiffness": "40 N/um",
      "tool__modes": [{"direction": "y", "frequency": "900 Hz", "damping": 0.03, "stiffness": "40 N/um"}]},
     "both say how the tool bends"),
    ({"requirements": {"depth_margin": {"min": 0}}}, "part.damping"),
    ({"requirements": {"share_steady": {"max": "1 um"}}}, "lathe.steady_stiffness"),
])  # fmt: skip
def test_what_cannot_be_is_refused(changes, told):
    with pytest.raises(ScenarioFault, match=told):
        scenario(**changes)


def test_modes_of_the_tool_count_at_rest_and_in_chatter():
    mode = [{"direction": "y", "frequency": "900 Hz", "damping": "0.03", "stiffness": "40 N/um"}]
    chat = {
        "part__density": "7850 kg/m^3",
        "part__damping": 0.02,
        "part__sections": [{"length": "30 mm", "diameter": "20 mm"}],
    }
    rigid, soft = (quick_outcome(scenario(**chat, **more)).measures for more in ({}, {"tool__modes": mode}))
    assert soft["stable_depth_min"] < rigid["stable_depth_min"]
    (done,) = turned(tool__modes=mode)
    assert done.moved()["tool"][:, 1] == pytest.approx(done.rest.total[:, 1] / 40e6)


def test_slopes_have_one_row_for_each_axis():
    assert chip_slopes(np.zeros((3, 12)), None).shape == (3, 2)
