import numpy as np
import pytest

from cutwise.maths import chains, frames
from cutwise.physics.motion import geometry, volumetric
from cutwise.physics.motion.geometry import AxisErrors, Polynomial, Sines, Table


def test_functions_of_an_axis():
    table = Table(np.array([0.0, 0.1, 0.3]), np.array([0.0, 2e-6, -2e-6]))
    assert table(np.array([0.05, 0.2])) == pytest.approx([1e-6, 0.0])
    with pytest.raises(geometry.OutsideTableError, match=r"commanded 0.4 to 0.4, but the error table covers 0 to 0.3"):
        table(np.array([0.4]))
    assert Polynomial(np.array([1.0, 0.0, 2.0]))(np.array([3.0])) == pytest.approx([19.0])
    sines = Sines(np.array([1.0, 0.5]), np.array([0.1, 0.2]), 0.5)
    u = 0.07
    expected = np.sin(2 * np.pi * u / 0.5 + 0.1) + 0.5 * np.sin(4 * np.pi * u / 0.5 + 0.2)
    assert sines(np.array([u])) == pytest.approx([expected])


def test_random_errors_have_the_deviation_asked_for_and_repeat():
    drawn = [
        geometry.random_sines(2e-6, wavelength=0.5, orders=4, generator=np.random.default_rng(seed))
        for seed in range(800)
    ]
    values = np.array([sines(np.linspace(0, 0.5, 50, endpoint=False)) for sines in drawn])
    assert values.std() == pytest.approx(2e-6, rel=0.05)
    again = geometry.random_sines(2e-6, wavelength=0.5, orders=4, generator=np.random.default_rng(3))
    assert (again.amplitude == drawn[3].amplitude).all()


def test_squareness_turns_the_motion_and_adds_no_rotation():
    z = AxisErrors([None] * 6, np.array([0.0, 0, 1]), np.array([3e-5, -2e-5, 0]), np.zeros(6), True)
    assert geometry.motion_twist(z, 0.2) == pytest.approx([-2e-5 * 0.2, -3e-5 * 0.2, 0, 0, 0, 0])


def five_axis(side: int, *, location=(0.0,) * 6, drifting: bool = True) -> volumetric.Axes:
    rng = np.random.default_rng(4)
    chain = chains.chain(
        [2, 1, 1, 2], [[0, 0, 1], [1, 0, 0], [0, 1, 1], [1, 0, 0]], rng.normal(size=(4, 3)),
        rotations=frames.exp_twists(rng.normal(size=(4, 6)))[0], sides=[side, side, 1, 1],
    )  # fmt: skip

    def errors(linear: bool, before) -> AxisErrors:
        motion = [geometry.random_sines(1e-5, wavelength=2.0, orders=3, generator=rng) if drifting else None] * 6
        return AxisErrors(motion, np.array([0.0, 0, 1]), np.array([1e-5, 0, 0]), np.array(before, float), linear)

    given = (errors(False, location), errors(True, np.zeros(6)), errors(True, np.zeros(6)), errors(False, location))
    ones = np.ones(4)
    return volumetric.Axes(chain, np.array([1.0, -1, 1, 1]), np.ones(4, bool), given, -ones, ones)


TIP = np.array([0.05, 0.1, -0.2])


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("location", [(0.0,) * 6, (1e-5, -2e-5, 0, 3e-5, 1e-5, 0)])
def test_map_from_tables_agrees_with_direct_evaluation_on_five_axes(side, location):
    axes = five_axis(side, location=location)
    commands = np.random.default_rng(0).uniform(-1, 1, (200, 4))
    tables = volumetric.tabulate(axes, tolerance=1e-10, reach=4.0)
    direct = volumetric.direct_error(axes, commands, TIP)
    assert volumetric.volumetric_error(axes, tables, commands, TIP) == pytest.approx(direct, abs=2e-9)
    assert volumetric.interpolation_error(axes, tables, TIP) < 2e-9


@pytest.mark.parametrize("side", [1, -1])
def test_location_error_of_a_rotary_axis_is_before_its_motion(side):
    """Composed by hand: tool side E_before R, part side the inverse of E_before R^-1 ... of the table's motion."""
    location = np.array([1e-3, -2e-3, 5e-4, 3e-3, 1e-3, -2e-3])
    chain = chains.chain([2], [[0, 0, 1]], np.array([[0.1, 0.2, 0.3]]), sides=[side])
    axes = volumetric.Axes(
        chain, np.ones(1), np.ones(1, bool),
        (AxisErrors([None] * 6, np.array([0.0, 0, 1]), np.zeros(3), location, False),), -np.ones(1), np.ones(1),
    )  # fmt: skip
    found = volumetric.direct_error(axes, [0.7], TIP, exact=True)
    turn, shift = frames.rotation_about([0, 0, 1], 0.7), np.array([0.1, 0.2, 0.3])
    error_turn, error_shift = frames.exp_twists(location)
    if side > 0:
        moved = error_turn @ (turn @ TIP + shift) + error_shift
    else:  # table: part in carrier = E_before M, M = H^-1; the tool in the part is the inverse of that
        moved = turn @ (error_turn.T @ (TIP - error_shift)) + shift
    assert found == pytest.approx(moved - (turn @ TIP + shift), abs=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_motion_and_location_errors_composed_by_hand_with_their_product(side):
    """Tool side E_before R E_after, part side the inverse of E_before M E_after with the table's motion M = H^-1."""
    location, motion = np.array([1e-3, -2e-3, 5e-4, 3e-3, 1e-3, -2e-3]), np.array([2e-3, 1e-3, 0, -1e-3, 4e-3, 2e-3])
    chain = chains.chain([2], [[0, 0, 1]], np.array([[0.1, 0.2, 0.3]]), sides=[side])
    constant = [Polynomial(np.array([value])) for value in motion]
    errors = AxisErrors(constant, np.array([0.0, 0, 1]), np.zeros(3), location, False)
    axes = volumetric.Axes(chain, np.ones(1), np.ones(1, bool), (errors,), -np.ones(1), np.ones(1))
    turn, shift = frames.rotation_about([0, 0, 1], 0.7), np.array([0.1, 0.2, 0.3])
    before, after = (homogeneous(*frames.exp_twists(twist)) for twist in (location, motion))
    step = homogeneous(turn, shift)
    whole = before @ step @ after if side > 0 else np.linalg.inv(before @ np.linalg.inv(step) @ after)
    expected = ((whole - step) @ np.append(TIP, 1.0))[:3]
    assert volumetric.direct_error(axes, [0.7], TIP, exact=True) == pytest.approx(expected, abs=1e-15)
    both = axes._replace(errors=(errors._replace(before=True, location=np.zeros(6)),))
    alone = homogeneous(*frames.exp_twists(motion))
    whole = alone @ step if side > 0 else np.linalg.inv(alone @ np.linalg.inv(step))
    expected = ((whole - step) @ np.append(TIP, 1.0))[:3]
    assert volumetric.direct_error(both, [0.7], TIP, exact=True) == pytest.approx(expected, abs=1e-15)


def homogeneous(rotation, translation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation
    return matrix


def test_a_table_error_is_inverted_and_a_tool_error_is_not():
    table = five_axis(-1)
    relative = table._replace(of_table=np.zeros(4, bool))
    commands = np.random.default_rng(0).uniform(-1, 1, (20, 4))
    at = chains.frames(table.chain, commands * table.sense)
    one, other = (volumetric.chain_errors(axes, at, commands).twists for axes in (table, relative))
    assert one[:, 1:3] == pytest.approx(-other[:, 1:3])
    assert one[:, 3:] == pytest.approx(other[:, 3:])


def test_beyond_the_travel_is_an_error():
    axes = five_axis(1)
    tables = volumetric.tabulate(axes, tolerance=1e-8)
    with pytest.raises(geometry.OutsideTableError, match="point 2 is beyond the travel"):
        volumetric.volumetric_error(axes, tables, [[0.0] * 4, [0.0, 1.01, 0.0, 0.0]], TIP)


def test_plain_and_compiled_map_agree():
    axes = five_axis(-1)
    tables = volumetric.tabulate(axes, tolerance=1e-8)
    commands = np.random.default_rng(0).uniform(-1, 1, (5, 4))
    plain = np.empty((5, 3))
    c = axes.chain
    volumetric._fill_map.py_func(
        c.kinds, c.axes, np.zeros(4, bool), c.rotations, c.origins, axes.sense, *tables, commands, TIP, plain
    )
    assert plain == pytest.approx(volumetric.volumetric_error(axes, tables, commands, TIP), abs=1e-16)


def test_body_diagonals_and_the_error_along_them():
    lines = volumetric.diagonals([0, 0, 0], [1.0, 2.0, 2.0], 5)
    assert lines.shape == (4, 5, 3)
    assert lines[0, 0] == pytest.approx([0, 0, 0])
    assert lines[3, 0] == pytest.approx([1, 2, 0])
    stretched = lines * 1e-5 + 3e-6
    along = volumetric.along(lines, stretched)
    assert along == pytest.approx(np.linspace(0, 3e-5, 5) * np.ones((4, 1)))
