"""Demeč and Madáč, Virtual machining: the printed equations, the milling example, and the model worked out from them.

The example machine's compliances are not in the paper; they are assumed values with results reproduced by an
independent program (superposition of absolute displacements, no chain).
"""

from typing import NamedTuple

import numpy as np
import pytest

from cutwise.maths import chains, frames
from cutwise.physics.motion import volumetric
from cutwise.physics.motion.geometry import AxisErrors, Sines
from cutwise.physics.motion.volumetric import Axes
from cutwise.physics.structure import beams, bodies, pads
from cutwise.physics.surface import budget, probability
from cutwise.process import machine_pass
from cutwise.process.machine_force import CutForce
from cutwise.process.machine_pass import ElasticElement, FlexiblePart, MachineCell, MachineRun, Weight
from cutwise.process.machine_path import ToolPath

MM, UM, PER_MM = 1e-3, 1e-6, 1e3
K = np.array([(0, 0, -44), (-130, 0, -42), (0, -306, 0), (0, 0, 6), (0, 266, 515), (0, 0, -95)]) * MM  # Eq. (10)
R_N = np.array([0, 0, -45]) * MM  # Eq. (11)
START, MIDDLE, END = 0, 13, 26


def four(x: float, y: float) -> np.ndarray:
    return np.array([(a, b, 0.0) for a in (-x, x) for b in (-y, y)]) * MM


def mill_elements(*, soft: bool = False, on_saddle: bool = False, tool: bool = False) -> tuple[ElasticElement, ...]:
    upright = np.array([(x, 0, z) for x in (-70, 70) for z in (-120, 120)]) * MM
    column = beams.box_section(0.220, 0.260, 0.015, shear_factor=0.5)
    foot = 2e6 if soft else 1e7
    spindle = np.diag([1 / 2e8, 1 / 2e8, 1 / 2.5e8, 1e-6, 1e-6, 1e-6])
    top = np.array([0, 0, 515]) * MM
    beam = beams.cantilever(column, 0.515, 1.2e11, 1.2e11 / 2.52)

    def group(points, x, y, z):
        return pads.pad_compliance(points, np.array([x, y, z]) * PER_MM)

    x_guide = group(four(90, 100), 1e5 / 4, 2e5, 3e5)
    zero = np.zeros(3)
    found = [
        ("clamping", 1, 0, zero, group(four(110, 35), 2e6, 2e6, 5e6)),
        ("x guide", 2, 2, zero, x_guide) if on_saddle else ("x guide", 2, 1, np.array([0, 0, -42]) * MM, x_guide),
        ("y guide", 3, 2, np.array([0, 0, -30]) * MM, group(four(110, 90), 3e5, 1e5 / 4, 4e5)),
        ("column foot", 4, 4, zero, np.diag([1 / 2e9] * 3 + [1 / foot] * 3)),
        ("column beam", 4, 4, top, beam),
        ("z guide", 5, 4, top, group(upright, 3e5, 4e5, 1.5e5 / 4)),
        ("spindle", 6, 6, zero, spindle),
    ]
    if tool:
        bar = beams.round_section(0.010, filling=0.8, shear_factor=0.9)
        found.append(("tool", 6, 6, R_N, beams.cantilever(bar, 0.020, 2.1e11, 2.1e11 / 2.6, downward=True)))
    return tuple(ElasticElement(*element, None) for element in found)


def way_along_x(s: np.ndarray, commands: np.ndarray) -> ToolPath:
    along = np.tile([1.0, 0.0, 0.0], (len(s), 1))
    every, none = np.ones(len(s), bool), np.zeros(len(s), np.int64)
    feed = np.full(len(s), 0.4 / 60)
    return ToolPath(s / feed, s, commands, along, along, feed, every, none, None, np.ones(0, bool), none, s, None)


def mill(
    *, force=(4000.0, 4000.0, 2000.0), weights=True, literal=False, feed_moment=True, travel=None, **elements
) -> MachineCell:
    s = np.linspace(0, 260, 27) * MM if travel is None else np.asarray(travel) * MM
    chain = chains.chain([0, 1, 0, 0, 0, 0], [[1, 0, 0]] * 6, K, sides=[-1, -1, -1, 1, 1, 1])
    none = np.zeros(6)
    axes = Axes(chain, np.ones(6), np.ones(6, dtype=bool), (None,) * 6, none, none + 0.26)
    commands = np.zeros((len(s), 6))
    commands[:, 1] = s
    heavy = (
        (0, 540, (0, 0, 150)),
        (1, 150, (0, 0, 0)),
        (2, 220, (0, 0, 0)),
        (5, 400, (0, 0, -50)),
    )
    return MachineCell(
        ("part", "table", "saddle", "bed", "column", "head", "spindle"),
        axes,
        3,
        R_N,
        mill_elements(**elements),
        tuple(Weight(b, np.array([0, 0, -w], float), np.array(at) * MM) for b, w, at in heavy) if weights else (),
        FlexiblePart(beams.block_section(0.260, 0.090), 2.1e11, 2.1e11 / 2.6),
        way_along_x(s, commands),
        CutForce(np.tile(np.array(force, float), (len(s), 1))),
        literal,
        feed_moment,
    )


@pytest.fixture(scope="module")
def loaded() -> MachineRun:
    return machine_pass.run_pass(mill())


def same(found, expected, *, tolerance=1e-6):
    """Micrometres against a reference, relative to its length."""
    size = np.linalg.norm(expected)
    return np.linalg.norm(np.asarray(found) / UM - expected) <= tolerance * size


# --- kinematics -----------------------------------------------------------------------------------------------------


def test_eqs_1_8_12_13_tool_point_and_vectors_of_the_example(loaded):
    assert loaded.cell.way.time[-1] == pytest.approx(39.0, rel=1e-14)
    assert loaded.ideal[START] / MM == pytest.approx([-130, -40, 295], abs=1e-9)
    assert loaded.ideal[END] / MM == pytest.approx([130, -40, 295], abs=1e-9)
    expected = [(-130, -40, 339), (0, -40, 381), (0, 266, 381), (0, 266, 375), (0, 0, -140), (0, 0, -45)]
    assert loaded.reach[START, 1:] / MM == pytest.approx(np.array(expected), abs=1e-9)
    assert loaded.reach[:, 0] == pytest.approx(loaded.ideal, abs=1e-15)


class FiveAxis(NamedTuple):
    turns: list[np.ndarray]
    d: np.ndarray
    tip: np.ndarray
    twists: np.ndarray
    at: chains.Frames


@pytest.fixture
def five_axis() -> FiveAxis:
    """C = 50°, A = -35° on the part side; errors are defined by these rounded values."""
    d = np.array([(0, 0, -50), (5, -20, -80), (-120, 60, -30), (10, 300, 450)]) * MM
    angles = np.radians([50, -35, 0, 0])
    chain = chains.chain([2, 2, 0, 0], [[0, 0, 1], [1, 0, 0], [0, 0, 1], [0, 0, 1]], d)
    twists = np.array([
        (0.0246, 5.9749, -5.4828, 34.7652, -67.2107, -22.8808),
        (-17.8118, -9.0934, -19.8329, -95.0611, -64.4769, -92.0868),
        (1.2029, 26.8043, -9.8441, -11.7546, -63.3723, 13.5632),
        (-12.4095, 9.7968, 7.1377, 7.8376, -9.3465, -125.8380),
        (2.1083, -18.6094, -0.5850, -26.9346, -2.4250, 5.6654),
    ])  # fmt: skip
    turns = [frames.rotation_about(chain.axes[i], angles[i]) for i in range(4)]
    return FiveAxis(turns, d, np.array([0, 0, -140]) * MM, twists * UM, chains.frames(chain, angles))


def test_five_axis_eq_1_corrected_eq_8_and_composition_agree(five_axis):
    right = [-401.1020956255, 199.4968551239, -107.1249446855]
    assert chains.tool_point(five_axis.at, five_axis.tip) / MM == pytest.approx(right, abs=1e-9)
    r, d, tip = five_axis.turns, five_axis.d, five_axis.tip
    eq8 = tip  # i = 0 of Eq. (8): innermost product first
    for rotation, step in zip(r[::-1], d[::-1], strict=True):
        eq8 = step + rotation @ eq8
    assert eq8 / MM == pytest.approx(right, abs=1e-9)
    corrected = r[0] @ r[1] @ r[2] @ r[3] @ tip + d[0] + r[0] @ d[1] + r[0] @ r[1] @ d[2] + r[0] @ r[1] @ r[2] @ d[3]
    assert corrected / MM == pytest.approx(right, abs=1e-9)


def test_eq_1_as_printed_drops_a_rotation_and_shifts_the_sum(five_axis):
    """Misprint: products to n-1 and i-1. Invisible in the paper's example, where every R is the unit matrix."""
    r, d, tip = five_axis.turns, five_axis.d, five_axis.tip
    product = [np.eye(3), r[0], r[0] @ r[1], r[0] @ r[1] @ r[2]]
    printed = product[3] @ tip + sum(product[i - 1] @ d[i] for i in (1, 2, 3)) + d[0]
    assert printed / MM == pytest.approx([-436.1307280807, 206.5578294069, -78.1357971757], abs=1e-9)
    assert np.abs(printed - chains.tool_point(five_axis.at, tip)).max() > 25 * MM
    straight = K.sum(axis=0) + R_N  # all R = I: the two forms agree
    assert straight / MM == pytest.approx([-130, -40, 295], abs=1e-12)


def test_five_axis_linear_and_exact_error(five_axis):
    linear = chains.linear_error(five_axis.at, five_axis.twists, five_axis.tip)
    exact = chains.exact_error(five_axis.at, five_axis.twists, five_axis.tip)
    assert linear / UM == pytest.approx([31.98946178, 40.36182006, -110.45093432], abs=1e-7)
    assert exact / UM == pytest.approx([32.00275701, 40.36096417, -110.44522529], abs=1e-7)


def test_eq_5_with_the_printed_limit_contradicts_eq_2(five_axis):
    """Misprint: the product runs to n; it must run to i."""
    local = chains.local_errors(five_axis.at, five_axis.twists, five_axis.tip)
    printed = local[0] + five_axis.at.rotations[-1] @ local[1:].sum(axis=0)
    assert printed / UM == pytest.approx([61.1958, 15.8548, -95.3685], abs=1e-4)
    right = chains.body_errors(five_axis.at, five_axis.twists, five_axis.tip).sum(axis=0)
    assert right / UM == pytest.approx([31.98946178, 40.36182006, -110.45093432], abs=1e-7)


def test_eq_7_is_the_cross_product():
    phi, upsilon, psi = 0.3, -0.2, 0.7
    printed = np.array([[0, -psi, upsilon], [psi, 0, -phi], [-upsilon, phi, 0]])
    assert frames.skew([phi, upsilon, psi]) == pytest.approx(printed)


# --- the loaded pass ------------------------------------------------------------------------------------------------

REFERENCE = {
    START: ((337.62845386, 276.93305676, 47.61099844), 439.26267535, 2551.783346216),
    MIDDLE: ((333.12888529, 266.77848476, 21.79980066), 427.34160277, 2448.745871358),
    END: ((328.62931673, 285.95934298, 3.94306496), 435.64380107, 2479.790249159),
}


@pytest.mark.parametrize("row", [START, MIDDLE, END])
def test_example_deviation_and_energy(loaded, row):
    deviation, size, work = REFERENCE[row]
    assert same(loaded.deviation[row], deviation)
    assert loaded.size[row] / UM == pytest.approx(size, rel=1e-9)
    assert loaded.internal[row] / MM == pytest.approx(work, rel=1e-11)
    assert loaded.external[row] == pytest.approx(loaded.internal[row], rel=1e-12)


def test_example_extremes_over_the_travel(loaded):
    assert loaded.worst == START
    assert loaded.size.min() / UM == pytest.approx(427.262, abs=5e-4)
    assert loaded.ideal[np.argmin(loaded.size), 0] / MM == pytest.approx(10.0)


BUDGET = {
    "part": (2.4587, 12.1183, 2.5036, 9.6096, -0.8729),
    "clamping": (1.9985, 15.6714, 2.1841, 11.4526, -1.0399),
    "x guide": (100.5927, 55.9270, 7.5883, 113.7167, -10.3342),
    "y guide": (38.8199, 94.6731, 7.1397, 89.7278, -8.1327),
    "column foot": (86.5524, 42.2900, -27.7790, 92.4543, -8.3901),
    "column beam": (30.8215, 9.5097, 0.1175, 29.9691, -2.7231),
    "z guide": (43.7853, 8.4889, 22.0456, 40.5563, -3.6788),
    "spindle": (28.1000, 28.1000, 8.0000, 39.8552, -3.6227),
}


def test_example_budget_at_the_middle(loaded):
    expected = np.array([BUDGET[name] for name in loaded.element_names])
    parts, total = loaded.contributions[MIDDLE], loaded.deviation[MIDDLE]
    assert parts / UM == pytest.approx(expected[:, :3], abs=6e-5)
    assert budget.signed_shares(parts, total) / UM == pytest.approx(expected[:, 3], abs=6e-5)
    assert budget.stiffening_gain(parts[None], total[None]) / UM == pytest.approx(expected[:, 4], abs=6e-5)
    assert budget.signed_shares(parts, total).sum() == pytest.approx(loaded.size[MIDDLE], rel=1e-12)


def test_stiffening_gain_is_what_a_stiffer_machine_does(loaded):
    cell = loaded.cell
    stiffer = [e._replace(compliance=e.compliance / 1.1) if e.name == "x guide" else e for e in cell.elements]
    again = machine_pass.run_pass(cell._replace(elements=tuple(stiffer)))
    gain = budget.stiffening_gain(loaded.contributions, loaded.deviation)
    assert again.size.max() - loaded.size.max() == pytest.approx(gain[loaded.element_names.index("x guide")])


def test_example_shares_of_bodies_at_the_worst_place(loaded):
    shares = budget.signed_shares(loaded.body[loaded.worst], loaded.deviation[loaded.worst]) / UM
    expected = [11.2420, 12.1071, 125.6264, 88.8348, 119.8755, 41.3958, 40.1811]
    assert shares == pytest.approx(
        np.array(expected), abs=1e-4
    )  # printed to four places, column from two rounded parts
    assert shares.sum() == pytest.approx(loaded.size[loaded.worst] / UM, rel=1e-12)


def test_example_chain_twists_at_the_middle(loaded):
    expected = np.array([
        (2.458742, 12.118336, 2.503580, 0, 0, 0),
        (0.285455, -1.762857, 0.127000, -51.428571, 4.876033, 1.500938),
        (40.000000, 5.000000, 2.241667, -133.666667, 156.790123, 21.390374),
        (10.360268, 43.990741, 42.524306, -133.024691, 84.917355, 14.638609),
        (6.998406, 10.958249, 1.308642, -108.910492, 170.324794, -174.825743),
        (39.433333, 2.500000, 22.045556, 42.777778, -31.085207, -135.714286),
        (20, 20, 8, 180, -180, 0),
    ])  # fmt: skip
    assert loaded.twists[MIDDLE] / UM == pytest.approx(expected, abs=6e-7)


def test_example_exact_minus_linear(loaded):
    assert (loaded.exact - loaded.deviation)[MIDDLE] / UM == pytest.approx([0.012554, -0.016394, -0.142975], abs=1e-6)


def test_example_stiffness_diagonals_and_column_beam():
    elements = {element.name: element.compliance for element in mill_elements()}
    newton_mm, newton_metre = 1e3, 1e-3
    scale = np.array([newton_mm] * 3 + [newton_metre] * 3)
    expected = {
        "clamping": (8e6, 8e6, 2e7, 2.45e10, 2.42e11, 1.066e11),
        "x guide": (1e5, 8e5, 1.2e6, 1.2e10, 9.72e9, 7.48e9),
        "y guide": (1.2e6, 1e5, 1.6e6, 1.296e10, 1.936e10, 1.093e10),
        "z guide": (1.2e6, 1.6e6, 1.5e5, 2.304e10, 1.8015e10, 7.84e9),
    }
    for name, diagonal in expected.items():
        stiffness = np.linalg.inv(elements[name])
        assert np.diag(stiffness) / scale == pytest.approx(np.array(diagonal), rel=1e-12)
        assert np.abs(stiffness - np.diag(np.diag(stiffness))).max() < 1e-6 * np.abs(stiffness).max()
    beam = elements["column beam"]
    assert 1e-3 / beam[0, 0] == pytest.approx(1.843191e5, rel=1e-6)
    assert 1e-3 / beam[1, 1] == pytest.approx(2.207391e5, rel=1e-6)
    assert beam[0, 4] == pytest.approx(1.11354e-8, rel=1e-5)
    assert beam[1, 3] == pytest.approx(-8.52819e-9, rel=1e-5)


def test_weights_alone():
    run = machine_pass.run_pass(mill(force=(0.0, 0.0, 0.0), travel=[0, 130, 260]))
    assert run.deviation[:, 0] / UM == pytest.approx([-1.90427169, 0, 1.90427169], abs=1e-8)
    assert run.deviation[:, 1] / UM == pytest.approx([3.75752826] * 3, abs=1e-8)
    assert run.deviation[:, 2] / UM == pytest.approx([-6.81907233] * 3, abs=1e-8)


def test_variants_saddle_soft_and_tool():
    saddle = machine_pass.run_pass(mill(on_saddle=True)).deviation[[START, MIDDLE, END]] / UM
    assert saddle[:, 1] == pytest.approx([270.676, 266.778, 274.141], abs=6e-4)
    assert saddle[:, 2] == pytest.approx([23.751, 21.800, 20.848], abs=6e-4)
    soft = machine_pass.run_pass(mill(soft=True)).deviation[[START, MIDDLE, END]] / UM
    assert soft[:, 1] == pytest.approx([438.093, 427.938, 447.119], abs=6e-4)
    assert soft[:, 2] == pytest.approx([-66.705, -92.516, -110.373], abs=6e-4)
    tool = machine_pass.run_pass(mill(tool=True))
    assert same(tool.deviation[MIDDLE], (479.98931955, 413.63891902, 24.83132339))


def test_drive_on_the_centre_line_is_another_machine():
    """The drive is spread over the pads; as one spring on the centre line it would not add to the yaw stiffness."""
    x_guide = pads.stiffness_matrix(four(90, 100), np.array([0.0, 2e5, 3e5]) * PER_MM)
    y_guide = pads.stiffness_matrix(four(110, 90), np.array([3e5, 0.0, 4e5]) * PER_MM)
    x_guide[0, 0] += 1e8
    y_guide[1, 1] += 1e8
    centre = {"x guide": np.linalg.inv(x_guide), "y guide": np.linalg.inv(y_guide)}
    upright = np.array([(x, 0, z) for x in (-70, 70) for z in (-120, 120)]) * MM
    z_guide = pads.stiffness_matrix(upright, np.array([3e5, 4e5, 0.0]) * PER_MM)
    z_guide[2, 2] += 1.5e8
    centre["z guide"] = np.linalg.inv(z_guide)
    cell = mill()
    changed = tuple(e._replace(compliance=centre.get(e.name, e.compliance)) for e in cell.elements)
    run = machine_pass.run_pass(cell._replace(elements=changed))
    assert run.deviation[START, 1] / UM == pytest.approx(277.90, abs=6e-3)
    assert run.deviation[MIDDLE, 0] / UM == pytest.approx(333.52, abs=6e-3)


# --- energy, convexity, figure 4 ------------------------------------------------------------------------------------


def test_cutting_force_alone_clapeyron():
    run = machine_pass.run_pass(mill(weights=False, travel=[400 * 7.3 / 60]))
    work = float(run.cell.cut.force[0] @ run.deviation[0])
    assert work / MM == pytest.approx(2499.96808433, rel=1e-11)
    assert work == pytest.approx(run.internal[0], rel=1e-12)
    assert machine_pass.energy_balance(run) < 1e-12


def test_with_weights_the_cutting_work_alone_is_not_the_energy(loaded):
    cutting = np.einsum("mi,mi->m", loaded.cell.cut.force, loaded.deviation)
    assert np.abs(cutting / loaded.internal - 1.0).max() > 5e-3
    assert machine_pass.energy_balance(loaded) < 1e-12


@pytest.mark.parametrize("options", [{"literal": True}, {"feed_moment": False}])
def test_energy_balance_does_not_apply_to_unphysical_options(options):
    run = machine_pass.run_pass(mill(**options))
    assert machine_pass.energy_balance(run) is None
    assert bodies.energy_residual(run.external, run.internal).max() == pytest.approx(0.0, abs=1e-12) or options == {
        "feed_moment": False
    }


def test_work_of_the_cutting_force_is_convex_along_the_travel():
    run = machine_pass.run_pass(mill(weights=False))
    force = run.cell.cut.force
    along = np.einsum("mi,mi->m", force, run.deviation) / np.linalg.norm(force[0])
    assert along[START] / UM == pytest.approx(426.61553, abs=5e-6)
    assert along[END] / UM == pytest.approx(409.53862, abs=5e-6)
    assert along.min() / UM == pytest.approx(405.33147, abs=5e-6)
    assert run.ideal[np.argmin(along), 0] / MM == pytest.approx(50.0)
    assert bodies.least_convexity(run.cell.way.travel, along) > 0.0
    for axis in (1, 2):
        assert bodies.least_convexity(run.cell.way.travel, force[:, axis] * run.deviation[:, axis]) > -1e-12


def test_z_is_monotonic_for_any_stiffness():
    """Vertices h Fx/(2 Fz) of x guide, clamping and part lie beyond the travel of 130 mm, whatever the stiffness."""
    run = machine_pass.run_pass(mill(weights=False, travel=np.linspace(0, 260, 261)))
    assert (np.diff(run.deviation[:, 2]) < 0.0).all()
    x, elements = run.ideal[:, 0], {name: k for k, name in enumerate(run.element_names)}
    for name, vertex in (("x guide", 381), ("clamping", 295), ("part", 147.5)):
        curve = np.polyfit(x, run.contributions[:, elements[name], 2] / UM, 2)
        assert -curve[1] / (2 * curve[0]) / MM == pytest.approx(vertex, rel=1e-6)


def test_carriages_on_the_saddle_tilt_alike_everywhere():
    run = machine_pass.run_pass(mill(on_saddle=True, weights=False))
    guide = run.contributions[:, run.element_names.index("x guide")]
    assert np.ptp(guide, axis=0) == pytest.approx(np.zeros(3), abs=1e-15)


def test_figure_4_like_demo_needs_the_literal_signs():
    """Y and Z largest in the middle: only with table errors added, the feed moment dropped and Fz downward."""
    demo = machine_pass.run_pass(
        mill(force=(4000.0, 4000.0, -2000.0), literal=True, feed_moment=False, soft=True)
    ).deviation[[START, MIDDLE, END]]
    expected = [(498.511, 269.383, -329.165), (481.177, 282.513, -332.325), (463.842, 266.308, -327.530)]
    assert demo / UM == pytest.approx(np.array(expected), abs=6e-4)


def test_figure_4_is_not_a_result_of_the_physical_signs():
    """In none of 16 physical cases (force signs and foot stiffness) do |Y| and |Z| both peak in the middle."""
    for soft in (False, True):
        for signs in np.ndindex(2, 2, 2):
            force = np.array([4000.0, 4000.0, 2000.0]) * (1 - 2 * np.array(signs))
            size = np.abs(machine_pass.run_pass(mill(force=force, soft=soft, travel=[0, 130, 260])).deviation)
            assert not (size[1, 1:] > size[[0, 2], 1:].max(axis=0)).all()


def test_eq_2_literal_adds_what_the_table_takes_away(loaded):
    literal = machine_pass.run_pass(mill(literal=True))
    table_side = [
        k for k, name in enumerate(loaded.element_names) if name in ("part", "clamping", "x guide", "y guide")
    ]
    expected = loaded.contributions.copy()
    expected[:, table_side] *= -1.0
    assert literal.contributions == pytest.approx(expected, abs=1e-15)


# --- probability ----------------------------------------------------------------------------------------------------


@pytest.fixture
def scatter(loaded):
    jacobian = chains.error_jacobian(loaded.at, loaded.cell.tip)[MIDDLE]
    deviation = np.vstack([np.zeros(6), np.tile([3 * UM] * 3 + [15 * UM] * 3, (6, 1))])
    return jacobian, deviation


def test_covariance_and_variance_shares(scatter):
    spread = np.sqrt(np.diag(probability.covariance(*scatter))) / UM
    assert spread == pytest.approx([14.637149, 13.479092, 9.303773], abs=1e-6)
    shares = probability.variance_shares(*scatter)
    assert shares == pytest.approx([0, 0.164634, 0.192837, 0.257336, 0.253106, 0.074240, 0.057848], abs=1e-6)


def test_covariance_against_monte_carlo_and_quantiles(loaded, scatter):
    random = probability.random_errors(*scatter, np.zeros(7, int), samples=100_000, seed=1)
    found = probability.quantiles(loaded.deviation[MIDDLE], random, 0.95)
    spread = np.sqrt(np.diag(probability.covariance(*scatter)))
    assert found.deviation == pytest.approx(spread, rel=0.01)  # standard error 0.22 %
    assert found.together / UM == pytest.approx(450.83, abs=0.4)
    assert found.random / UM == pytest.approx(36.30, abs=0.25)


# --- 21 parameters --------------------------------------------------------------------------------------------------

# amplitudes (µm, µrad) and phases (rad) of three sines over 500 mm
SINES = {
    "EXX": ((0.236432494, 9.009273927, -7.116807746), (1.277698911, 1.647327778, 4.712290144)),
    "EYX": ((8.972988943, -3.76337096, -1.533471021), (1.760967, 3.046999319, 6.159029615)),
    "EZX": ((6.554051876, -1.816017273, 0.991873753), (6.039207176, 4.551680828, 3.398904653)),
    "EAX": ((-28.346453205, 15.21078652, 2.288598793), (1.738876761, 1.008894615, 6.091131595)),
    "EBX": ((-10.21609701, 17.305722206, -11.808310243), (3.240910717, 0.727636046, 3.915515665)),
    "ECX": ((-2.790126631, -21.957498165, -5.813220813), (4.877569958, 3.849660731, 5.760629586)),
    "EXY": ((-9.208142467, 0.571785265, -0.813282342), (1.201514256, 0.512150437, 5.370825399)),
    "EYY": ((-8.753008417, 2.826563383, 7.05265677), (5.408860356, 5.504652965, 2.963593038)),
    "EZY": ((1.858820362, -4.798051045, 6.797630421), (1.72102388, 0.044536684, 4.055127224)),
    "EAY": ((0.569752891, 0.653333068, 15.181812462), (4.521030928, 5.24737468, 1.770192756)),
    "EBY": ((-21.124677853, 19.177603147, 10.99721436), (1.35157009, 4.015001067, 5.055744352)),
    "ECY": ((17.225816493, -18.503024459, 18.141849668), (6.051853081, 0.945295935, 3.028293798)),
    "EXZ": ((7.894317244, -1.545661861, 1.790041242), (4.341596582, 1.121431395, 2.488488699)),
    "EYZ": ((-9.51018645, 3.469197743, 8.381772393), (0.036578457, 1.648466796, 2.645065753)),
    "EZZ": ((6.536506591, 7.710405334, 3.20710761), (0.665185367, 3.976244461, 2.389064415)),
    "EAZ": ((-15.266863965, 16.111019934, -17.299515444), (4.554845931, 4.10627855, 2.708103982)),
    "EBZ": ((19.87649008, -26.236924646, 19.529268804), (5.446772775, 3.969808538, 5.088522931)),
    "ECZ": ((-20.129564012, -7.49118021, -10.995710007), (2.146470866, 3.414243139, 1.232744439)),
}
A0Z, B0Z, C0Y = 39.691295209, -20.542762855, -19.450602622  # µrad


def axis(name: str, direction, squareness=(0.0, 0.0, 0.0)) -> AxisErrors:
    motion = [Sines(np.array(SINES[f"E{c}{name}"][0]) * UM, np.array(SINES[f"E{c}{name}"][1]), 0.5) for c in "XYZABC"]
    return AxisErrors(motion, np.array(direction, float), np.array(squareness) * UM, np.zeros(6), True)


@pytest.fixture(scope="module")
def three_axis() -> Axes:
    """Chain w X Y b Z t, commands are displacements of the tables."""
    chain = chains.chain([1, 1, 1], np.eye(3), np.zeros((3, 3)), sides=[-1, -1, 1])
    errors = (axis("X", (1, 0, 0)), axis("Y", (0, 1, 0), (0, 0, C0Y)), axis("Z", (0, 0, 1), (A0Z, B0Z, 0)))
    low, high = np.array([-0.2, -0.2, 0.0]), np.array([0.2, 0.2, 0.4])
    return Axes(chain, np.array([-1.0, -1.0, 1.0]), np.ones(3, bool), errors, low, high)


POINTS = np.array([(0, 0, 0), (100, 50, 200), (-150, -80, 300), (200, 120, 50)]) * MM
SPINDLE_NOSE = np.array([0, 0, -120]) * MM


def test_21_parameters_linear_and_exact(three_axis):
    linear = volumetric.direct_error(three_axis, POINTS, SPINDLE_NOSE) / UM
    exact = volumetric.direct_error(three_axis, POINTS, SPINDLE_NOSE, exact=True) / UM
    assert linear == pytest.approx(
        np.array([
            (-17.681671, -7.961536, 4.312712),
            (23.403501, -19.252558, 1.316883),
            (3.086296, -12.172077, -12.763988),
            (-21.943647, -8.831455, -10.635639),
        ]),
        abs=6e-7,
    )  # fmt: skip
    assert exact == pytest.approx(
        np.array([
            (-17.681708, -7.961361, 4.312549),
            (23.404111, -19.252527, 1.316366),
            (3.086576, -12.172055, -12.764036),
            (-21.944083, -8.831202, -10.635445),
        ]),
        abs=7e-7,
    )  # fmt: skip


def test_21_parameters_map_from_tables(three_axis):
    tables = volumetric.tabulate(three_axis)
    from_tables = volumetric.volumetric_error(three_axis, tables, POINTS, SPINDLE_NOSE)
    assert from_tables == pytest.approx(volumetric.direct_error(three_axis, POINTS, SPINDLE_NOSE), abs=1e-3 * UM)
    assert volumetric.interpolation_error(three_axis, tables, SPINDLE_NOSE) < 1e-3 * UM


def test_21_parameters_exact_is_the_product_of_the_table_motions(three_axis):
    """p = (Trans(x) exp X)^-1 (Trans(y) exp Y)^-1 Trans(z) exp Z r_n, composed here without the chain."""
    for command, found in zip(
        POINTS, volumetric.direct_error(three_axis, POINTS, SPINDLE_NOSE, exact=True), strict=True
    ):
        point = SPINDLE_NOSE
        for k in (2, 1, 0):
            errors = three_axis.errors[k]
            twist = volumetric.motion_twist(errors, command[k])
            rotation, shift = frames.exp_twists(twist)
            slide = errors.direction * command[k]
            if k == 2:
                point = slide + rotation @ point + shift
            else:
                point = rotation.T @ (point - slide - shift)
        ideal = np.array([-command[0], -command[1], command[2]]) + SPINDLE_NOSE
        assert point - ideal == pytest.approx(found, abs=1e-16)
