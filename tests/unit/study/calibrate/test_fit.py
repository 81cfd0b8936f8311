"""The statistics that every kind of calibration has."""

import numpy as np
import pytest

from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.posed import Posed, Unknown


def line(rows=40, noise=0.1, seed=0, matrix=None, truth=(2.0, -1.0, 0.5), rng=None):
    """A linear problem of as many unknowns as the truth has."""
    rng = rng or np.random.default_rng(seed)
    matrix = rng.normal(size=(rows, len(truth))) if matrix is None else matrix
    measured = matrix @ np.array(truth) + noise * rng.normal(size=len(matrix))
    return posed(matrix, measured)


def posed(matrix, measured):
    count = matrix.shape[1]
    unknowns = tuple(Unknown(f"p{k}", "force", deciding=True) for k in range(count))
    return Posed(
        unknowns, measured, np.arange(len(measured)), np.zeros(len(measured), dtype=int), ("y",), ("force",),
        lambda x: matrix @ x, lambda _: matrix,
    )  # fmt: skip


def test_noise_free_data_give_the_truth():
    fit = fitted(line(noise=0.0))
    assert fit.x == pytest.approx([2.0, -1.0, 0.5], rel=1e-12)
    assert fit.outliers == ()


def test_covariance_is_that_of_the_textbook():
    problem = line()
    matrix = problem.jacobian(np.zeros(3))
    fit = fitted(problem)
    s2 = np.sum(fit.residual**2) / (40 - 3)
    assert fit.covariance == pytest.approx(s2 * np.linalg.inv(matrix.T @ matrix), rel=1e-10)
    assert fit.degrees_of_freedom == 37
    assert fit.quantile == pytest.approx(1.6870936, rel=1e-7)


def test_intervals_cover_what_they_promise():
    """1,000 fits of 8 rows: the truth in 90 % of the intervals, the rows left out in 90 % of theirs."""
    rng = np.random.default_rng(7)
    matrix = rng.normal(size=(8, 3))
    inside, left = [], []
    for _ in range(1000):
        fit = fitted(line(matrix=matrix, rng=rng), folds=[[k] for k in range(8)])
        inside.append(np.abs(fit.x - [2.0, -1.0, 0.5]) <= fit.quantile * fit.standard_errors)
        left.append(fit.left_out_cover)
    assert np.mean(inside) == pytest.approx(0.9, abs=0.02)
    assert np.mean(left) == pytest.approx(0.9, abs=0.02)


def test_other_units_change_no_relative_error():
    problem = line()
    matrix = problem.jacobian(np.zeros(3))
    other = posed(1e3 * matrix * np.array([1e-3, 1.0, 1e3]), 1e3 * problem.measured)
    one, two = fitted(problem), fitted(other)
    assert two.standard_errors / two.x == pytest.approx(one.standard_errors / one.x, rel=1e-9)
    assert two.verdicts == one.verdicts
    assert two.condition == pytest.approx(one.condition, rel=1e-9)


def test_doubled_rows_shrink_errors_by_the_root_of_two():
    problem = line()
    matrix = problem.jacobian(np.zeros(3))
    twice = fitted(posed(np.vstack([matrix, matrix]), np.tile(problem.measured, 2)))
    one = fitted(problem)
    expected = one.standard_errors / np.sqrt(2.0) * np.sqrt(2 * 37 / 77)
    assert twice.standard_errors == pytest.approx(expected, rel=1e-9)


def test_a_duplicated_column_is_just_that_combination_not_identified():
    problem = line()
    matrix = problem.jacobian(np.zeros(3))
    fit = fitted(posed(np.column_stack([matrix, matrix[:, 2]]), problem.measured))
    assert fit.verdicts == ("identified", "identified", "not identified", "not identified")
    assert np.abs(fit.null[:, 0]) == pytest.approx([0, 0, np.sqrt(0.5), np.sqrt(0.5)], abs=1e-9)
    assert np.all(np.isinf(fit.standard_errors[2:]))


def test_a_column_of_nothing_is_not_identified():
    problem = line()
    matrix = np.column_stack([problem.jacobian(np.zeros(3)), np.zeros(40)])
    assert fitted(posed(matrix, problem.measured)).verdicts[3] == "not identified"


def test_left_out_errors_are_those_of_fits_without_the_rows():
    problem = line()
    matrix = problem.jacobian(np.zeros(3))
    fit = fitted(problem, folds=[[0, 5, 9]])
    kept = np.setdiff1d(np.arange(40), [0, 5, 9])
    x = np.linalg.lstsq(matrix[kept], problem.measured[kept], rcond=None)[0]
    assert fit.left_out[[0, 5, 9]] == pytest.approx(problem.measured[[0, 5, 9]] - matrix[[0, 5, 9]] @ x, rel=1e-9)
    assert np.isnan(fit.left_out[1])


@pytest.mark.parametrize("loss", ["linear", "soft_l1"])
def test_gross_outliers_are_named_with_either_loss(loss):
    problem = line(rows=40)
    measured = problem.measured.copy()
    measured[[3, 30]] += 50.0
    fit = fitted(posed(problem.jacobian(np.zeros(3)), measured), loss=loss)
    assert {outlier.row for outlier in fit.outliers} == {3, 30}


def test_soft_l1_withstands_one_gross_outlier_in_twenty():
    problem = line(rows=200)
    measured = problem.measured.copy()
    measured[::20] += 20.0
    matrix = problem.jacobian(np.zeros(3))
    plain, robust = (fitted(posed(matrix, measured), loss=loss) for loss in ("linear", "soft_l1"))
    clean = fitted(problem)
    assert np.max(np.abs(robust.x - clean.x)) < 0.5 * np.max(np.abs(plain.x - clean.x))
    assert robust.scale < 0.5 * plain.scale


def test_the_next_row_is_the_one_that_tells_most():
    matrix = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.1], [1.0, 3.0]])
    fit = fitted(posed(matrix, matrix @ [1.0, 1.0] + [0.01, -0.01, 0.01, 0.0]))
    again = [np.linalg.slogdet(matrix.T @ matrix + np.outer(row, row))[1] for row in matrix]
    assert fit.next.row == int(np.argmax(again)) == 3
    assert fit.next.gain == pytest.approx(max(again) - np.linalg.slogdet(matrix.T @ matrix)[1], rel=1e-9)
