r"""Gauss-Newton for fits of very many unknowns with priors, by the normal equations.

.. math:: x = \arg\min \sum_n w_n |r_n|^2/\sigma^2 + \sum_k (x_k/\varsigma_k)^2, \qquad
          C = \frac{\bar r^2}{\sigma^2}\,(A^T W A/\sigma^2 + P)^{-1}

Priors keep the matrix well conditioned, so that Cholesky does; weights that fall below 1 in few rows change it by little.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy import linalg

from cutwise.study.calibrate.posed import FloatArray

PASSES, REWEIGHTED = 2, 5
_FAR = 3.0  # times the median error: from there a row weighs less


class Linearised(NamedTuple):
    """Residual (n, 3) and what the unknowns move it by (n, 3, p)."""

    residual: FloatArray
    jacobian: FloatArray


class Solution(NamedTuple):
    """Where the passes ended."""

    x: FloatArray
    weights: FloatArray  # of the rows (n,)
    residual: FloatArray  # (n, 3)
    jacobian: FloatArray  # (n, 3, p)
    factor: FloatArray  # lower Cholesky factor of the normal matrix, sigma in it
    mean_square: float  # of the components of the residual

    def leverage(self, jacobian: FloatArray, sigma: float) -> FloatArray:
        """x C x^T over sigma^2 of equations (m, p), before the scale of the residual."""
        solved = linalg.solve_triangular(self.factor, jacobian.T, lower=True, check_finite=False)
        return np.asarray(np.einsum("pm,pm->m", solved, solved) / sigma**2)

    def variances(self, sigma: float) -> FloatArray:
        """Of the unknowns (p,)."""
        inverse = linalg.solve_triangular(self.factor, np.eye(len(self.x)), lower=True, check_finite=False)
        return np.asarray(np.einsum("pm,pm->m", inverse, inverse) * self.mean_square / sigma**2)

    def covariance(self, places: Sequence[int], held: int, sigma: float) -> FloatArray:
        """Of some of the unknowns, with the first ones held where they are and all others as free as they are."""
        normal = (self.factor @ self.factor.T)[held:, held:]
        factor = linalg.cholesky(normal, lower=True, check_finite=False)
        own = np.eye(len(normal))[:, [place - held for place in places]]
        inverse = linalg.solve_triangular(factor, own, lower=True, check_finite=False)
        return np.asarray(inverse.T @ inverse * self.mean_square / sigma**2)


def gauss_newton(linearised: Callable[[FloatArray], Linearised], prior: FloatArray, sigma: float) -> Solution:
    """Two passes from 0, the last one weighted: rows weigh min(1, 3 median|e|/|e|), five times over.

    Parameters
    ----------
    linearised : callable
        Residual and Jacobian at x (p,).
    prior : array (p,)
        Standard deviations about 0; infinite for none.
    sigma : float
        Scatter of a component.
    """
    x = np.zeros(len(prior))
    penalty = 1.0 / prior**2
    for step in range(PASSES):
        at = linearised(x)
        flat = at.jacobian.reshape(-1, len(x))
        # the upper triangle alone, which is half the work
        normal = linalg.blas.dsyrk(1.0 / sigma**2, flat.T)
        right = flat.T @ at.residual.reshape(-1) / sigma**2
        weights = np.ones(len(at.residual))
        for _ in range(REWEIGHTED if step == PASSES - 1 else 1):
            move, factor = _step(at, (normal, right), weights, x, penalty, sigma)
            left = at.residual - (flat @ move).reshape(at.residual.shape)
            size = np.linalg.norm(left, axis=1)
            if step == PASSES - 1:
                weights = np.minimum(1.0, _FAR * np.median(size) / np.maximum(size, 1e-300))
        x = x + move
    return Solution(x, weights, left, at.jacobian, factor, float(np.mean(left**2)))


def _step(
    at: Linearised,
    summed: tuple[FloatArray, FloatArray],
    weights: FloatArray,
    x: FloatArray,
    penalty: FloatArray,
    sigma: float,
) -> tuple[FloatArray, FloatArray]:
    """The step and the Cholesky factor; only rows that weigh less are summed again."""
    normal, right = summed
    less = np.flatnonzero(weights < 1.0)
    if len(less):
        part = (at.jacobian[less] * np.sqrt(1.0 - weights[less])[:, None, None]).reshape(-1, len(x))
        normal = normal - linalg.blas.dsyrk(1.0 / sigma**2, part.T)
        right = (
            right
            - np.einsum("nc,ncp->p", at.residual[less] * (1.0 - weights[less])[:, None], at.jacobian[less]) / sigma**2
        )
    normal = normal + np.diag(penalty)
    factor = linalg.cholesky(normal, lower=False, check_finite=False).T
    move = linalg.cho_solve((factor, True), right - penalty * x, check_finite=False)
    return move, factor
