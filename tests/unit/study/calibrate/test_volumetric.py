"""The 21 errors of a three-axis machine: what each measurement can tell, against an independent program; recovery."""

import math

import numpy as np
import pytest

from cutwise import load, simulate
from cutwise.io import library
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate import volumetric
from cutwise.study.calibrate.outcome import calibrated
from cutwise.study.inputs import scatter_of

SCALES = np.array([0.2, 0.15, 0.3])
TERMS = volumetric.terms()
TRUTH = np.random.default_rng(1).normal(size=51) * [5e-6 if t.component < 3 else 20e-6 for t in TERMS]
TITLES = "x [mm], y [mm], z [mm], tool_length [mm], set, zero, "
PLATE = TITLES + "error_x [um], error_y [um], error_z [um]"


def errors_at(commands, length, truth=TRUTH):
    return volumetric.deviations(commands, np.full(len(commands), length), SCALES) @ truth


def written(tmp_path, titles, *columns):
    file = tmp_path / "volume.csv"
    rows = np.column_stack(columns)
    file.write_text("\n".join([titles, *(", ".join(repr(float(v)) for v in row) for row in rows)]))
    return file


def along(places, ways, zeros, sets, length=0.12):
    """Columns of errors along directions, less the error at the zero of each set (its last row)."""
    error = np.einsum("nc,nc->n", ways, errors_at(places, length) - errors_at(zeros, length))
    marked = np.all(places == zeros, axis=1)
    return np.column_stack([1e3 * places, np.full(len(places), 1e3 * length), sets, marked, ways, 1e6 * error])


def diagonals():
    found = []
    for k, (sx, sy) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1))):
        start, end = np.array([sx * 0.2, sy * 0.15, 0.0]), np.array([-sx * 0.2, -sy * 0.15, 0.3])
        places = start + np.linspace(0.0, 1.0, 21)[:, None] * (end - start)
        way = (end - start) * [-1, -1, 1]  # of the tool against the part
        found.append(
            along(places, np.tile(way / np.linalg.norm(way), (21, 1)), np.tile(start, (21, 1)), np.full(21, k))
        )
    return np.vstack(found)


def ball_bar():
    found = []
    for k, (i, j) in enumerate(((0, 1), (0, 2), (1, 2))):
        t = np.radians(np.arange(0, 360, 5))
        way = np.zeros((73, 3))
        way[:72, i], way[:72, j] = np.cos(t), np.sin(t)
        centre = np.tile([0.0, 0.0, 0.15], (73, 1))
        found.append(along(centre + 0.14 * way, way * [-1, -1, 1], centre, np.full(73, 10 + k)))
    return np.vstack(found)


def plate(length=0.12, noise=0.0, zero=True, seed=0):
    x, y, z = np.meshgrid(np.linspace(-0.2, 0.2, 9), np.linspace(-0.15, 0.15, 7), [0.0, 0.1, 0.2, 0.3], indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    error = errors_at(places, length) + noise * np.random.default_rng(seed).normal(size=places.shape)
    marked = np.all(np.abs(places) < 1e-12, axis=1) & zero
    if zero:
        error = error - error[marked]
    return np.column_stack(
        [1e3 * places, np.full(len(places), 1e3 * length), np.zeros(len(places)), marked, 1e6 * error]
    )


DIRECTED = TITLES + "direction_x, direction_y, direction_z, error [um]"


@pytest.mark.parametrize(
    ("columns", "titles", "rank", "alone", "condition"),
    [
        (diagonals(), DIRECTED, 14, 3, 29.5), (ball_bar(), DIRECTED, 22, 6, 139),
        (np.vstack([diagonals(), ball_bar()]), DIRECTED, 28, 11, 294), (plate(), PLATE, 40, 32, 197),
        (np.vstack([plate(), plate(0.22)]), PLATE, 46, 44, 815),
    ],
    ids=["diagonals", "bar", "both", "plate", "two tools"],
)  # fmt: skip
def test_what_can_be_known(tmp_path, columns, titles, rank, alone, condition):
    scale = ["data.scale=[200 mm, 150 mm, 300 mm]"]
    found = calibrated("volumetric", written(tmp_path, titles, columns), scale)
    fit = found.finding.fit
    assert 51 - fit.null.shape[1] == rank
    assert int(np.sum(np.sum(fit.null**2, axis=1) < 1e-9)) == alone
    assert fit.condition == pytest.approx(condition, rel=5e-3)
    assert f"{rank} of 51 combinations are known, {alone} parameters alone" in " ".join(found.finding.cannot_tell)
    known = np.sum(fit.null**2, axis=1) < 1e-9
    assert fit.x[known] == pytest.approx(TRUTH[known], abs=1e-12)
    assert fit.residual == pytest.approx(0.0, abs=1e-12)
    assert len(found.finding.unknown) == 51 - rank


def test_the_formula_is_that_of_the_machine():
    """The 21-parameter case of the machine: its deviation at one place, to its last printed digit."""
    errors = library.entry("machines", "three_axis_21").values.value["geometry_errors"].plain()
    place = np.array([[0.1, 0.05, 0.2]])
    moved = volumetric.deviations(place, np.array([0.12]), place[0])[0]

    def number(text):
        return float(text.split()[0])

    total, done = np.zeros(3), set()
    for k, term in enumerate(TERMS):
        given = errors[term.function]
        if not term.power:
            total += moved[:, k] * 1e-6 * number(given)
        elif term.function not in done:
            done.add(term.function)
            u = place[0, term.axis] / 0.5
            sines = zip(given["amplitudes"], given["phases"], strict=True)
            size = sum(number(a) * math.sin(2 * math.pi * n * u + number(p)) for n, (a, p) in enumerate(sines, 1))
            total += moved[:, k] * 1e-6 * size
    assert 1e6 * total == pytest.approx([23.4035, -19.2526, 1.3168], abs=1e-4)


def test_a_zero_at_no_known_place(tmp_path):
    """Without a marked row a shift of all errors of a set changes nothing."""
    shifted = plate(zero=False)
    shifted[:, 6:] += [3.0, -7.0, 11.0]
    found = calibrated("volumetric", written(tmp_path, PLATE, shifted), [])
    assert any("3 zeros" in text for text in found.warnings)
    known = np.sum(found.finding.fit.null**2, axis=1) < 1e-9
    assert found.finding.fit.x[known] == pytest.approx(TRUTH[known], abs=1e-12)


def test_left_out_places_and_intervals(tmp_path):
    found = calibrated("volumetric", written(tmp_path, PLATE, plate(noise=1e-6, zero=False)), [])
    fit, finding = found.finding.fit, found.finding
    assert fit.scale == pytest.approx(1e-6, rel=0.1)
    assert finding.left_out_error == pytest.approx(1e-6, rel=0.15)
    known = np.sum(fit.null**2, axis=1) < 1e-9
    inside = np.abs(fit.x - TRUTH)[known] < (fit.quantile * fit.standard_errors)[known]
    assert 0.75 <= inside.mean() <= 1.0  # of 32, which hang together
    assert not found.reasons


def test_the_entry_is_a_machine_s(tmp_path):
    file = tmp_path / "my_machine.yaml"
    file.write_text(calibrated("volumetric", written(tmp_path, PLATE, plate()), []).entry("my_machine"))
    entry = library.read_entry(file, str(file), "machines")
    assert {origin.status for _, _, origin in entry.origins()} == {"measured"}
    assert set(entry.values.value["geometry_errors"].value) == {term.function for term in TERMS}


def test_columns_that_do_not_go_together(tmp_path):
    with pytest.raises(ScenarioFault, match="needs errors"):
        calibrated("volumetric", written(tmp_path, TITLES.rstrip(", "), plate()[:, :6]), [])
    twice = plate()
    twice[:2, 5] = 1.0
    with pytest.raises(ScenarioFault, match="a set has one zero"):
        calibrated("volumetric", written(tmp_path, PLATE, twice), [])


def test_a_run_with_the_fitted_errors_has_a_band(tmp_path, examples):
    """The fit put into the chain of the library's machine; combinations that a plate leaves free keep their prior."""
    found = calibrated("volumetric", written(tmp_path, PLATE, plate(noise=0.5e-6)), ["machine.library=three_axis_21"])
    file = tmp_path / "machine.yaml"
    file.write_text(found.entry("machine"))
    given = {"machine.library": str(file), "requirements": "{}", "volume.points": 3, "volume.diagonal_points": 5}
    scenario = load(examples / "machine_volumetric_map.yaml", given)
    scatter = scatter_of(scenario)
    assert len(scatter.inputs) == 51
    free = next(k for k, one in enumerate(scatter.inputs) if one.key == "machine.geometry_errors.EAZ.polynomial[1]")
    assert 5e-6 < scatter.standard_errors[free] < 20e-6
    spread = simulate(scenario).measures["diagonal_range_max"].band
    assert 0.0 < spread.sd < 5e-6


def test_a_chain_of_other_axes_is_refused(tmp_path):
    with pytest.raises(ScenarioFault, match=r"the fit is for X \(part\), Y \(part\), Z \(tool\)"):
        calibrated("volumetric", written(tmp_path, PLATE, plate()), ["machine.library=five_axis_trunnion"])


@pytest.mark.parametrize("title", ["direction_x", "direction_x []", "direction_x [-]", "direction_x [1]"])
def test_directions_and_names_of_sets(tmp_path, title):
    """Numbers without a unit as people title them, and sets that have words for names, are what numbers are."""
    rows = diagonals()
    names = [f"from corner {'ABCD'[int(k)]}" for k in rows[:, 4]]
    file = tmp_path / "words.csv"
    lines = [
        ", ".join([*(repr(float(v)) for v in row[:4]), name, *(repr(float(v)) for v in row[5:])])
        for row, name in zip(rows, names, strict=True)
    ]
    file.write_text("\n".join([DIRECTED.replace("direction_x", title), *lines]))
    words = calibrated("volumetric", file, []).finding
    numbers = calibrated("volumetric", written(tmp_path, DIRECTED, rows), []).finding
    assert [v.value for v in words.values] == [v.value for v in numbers.values]
