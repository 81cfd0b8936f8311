"""What the terms of a structure amount to: displacements, shares and stiffness, the same for every process."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, NamedTuple, Protocol

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.paths.carried import CarriedPath
from cutwise.physics.structure.series_compliance import in_axes
from cutwise.physics.structure.swings import Linked, Swinging, natural_frequencies
from cutwise.physics.structure.terms import Compliance, displacement, turning, width

AXES = ("x", "y", "z")


class Mode(Protocol):
    """A mode of a tool tip."""

    @property
    def direction(self) -> Literal["x", "y"]:
        """Along which it bends."""

    @property
    def frequency(self) -> float:
        """[Hz]"""

    @property
    def damping(self) -> float:
        """Ratio."""

    @property
    def stiffness(self) -> float:
        """[N/m]"""


def spring(stiffness: Mapping[int, float]) -> Compliance:
    """A term that yields along some axes of the process (0 to 2), with a stiffness [N/m] in each, at the tip."""
    matrix = np.zeros((1, 6, 6))
    for axis, value in stiffness.items():
        matrix[0, axis, axis] = 1.0 / value
    return Compliance(np.zeros(1), matrix)


def modes_at_rest(modes: Iterable[Mode], path: CarriedPath | None = None) -> Compliance:
    """Modes of a tool tip at rest: F/k in their directions, those of one direction together.

    ``path``: whose axes are those of the process, in those along which the modes lie; left out, they are the same.
    """
    yields = {0: 0.0, 1: 0.0}
    for mode in modes:
        yields["xy".index(mode.direction)] += 1.0 / mode.stiffness
    term = spring({axis: 1.0 / value for axis, value in yields.items() if value > 0.0})
    return term if path is None else Compliance(path.at, in_axes(term.matrix, path.axes))


class Bending(Protocol):
    """A tool that may bend: by one stiffness across its axis [N/m], or by modes that count at rest."""

    @property
    def stiffness(self) -> float | None:
        """[N/m]"""

    @property
    def modes(self) -> Sequence[Mode]:
        """Of the tip."""


def tip_of(tool: Bending, path: CarriedPath | None = None) -> Compliance | None:
    """What a tool yields by at its tip, at rest; None for a rigid one. ``path`` as in :func:`modes_at_rest`."""
    if tool.stiffness is not None:
        return spring({0: tool.stiffness, 1: tool.stiffness})
    return modes_at_rest(tool.modes, path) if tool.modes else None


def mode_receptance(modes: Iterable[Mode], omega: FloatArray, axes: FloatArray | None = None) -> np.ndarray:
    r"""Displacement of a tool tip for a force there, :math:`\sum 1/[k(1 - r^2 + 2i\zeta r)]`, :math:`r = \omega/\omega_n`.

    At angular frequencies (m,) [rad/s], shape (m, 3, 3) [m/N]; ``axes``: directions x, y of the modes in those of the
    process, as rows; left out, they are the same.
    """
    total = np.zeros((len(omega), 3, 3), dtype=complex)
    for mode in modes:
        ratio = omega / (2.0 * np.pi * mode.frequency)
        axis = (np.eye(3) if axes is None else axes)["xy".index(mode.direction)]
        one = 1.0 / (mode.stiffness * (1.0 - ratio * ratio + 2j * mode.damping * ratio))
        total += one[:, None, None] * np.outer(axis, axis)
    return total


def by_term(terms: Sequence[tuple[str, NamedTuple]], columns: FloatArray, height: float) -> dict[str, FloatArray]:
    """Displacement by each term at a height over the tip [m], from the columns that they noted; shape (n, 3)."""
    found, at = {}, 0
    for name, term in terms:
        found[name] = displacement(term, columns[:, at : at + width(term)], height)
        at += width(term)
    return found


def turned(terms: Sequence[tuple[str, NamedTuple]], columns: FloatArray) -> FloatArray:
    """Turn of the tool about the feed by all terms [rad], from the columns that they noted; shape (n,)."""
    total, at = np.zeros(len(columns)), 0
    for _, term in terms:
        total = total + turning(term, columns[:, at : at + width(term)])
        at += width(term)
    return total


def extremes(name: str, values: FloatArray, *, mean: bool = False) -> dict[str, float]:
    """The least and the greatest of something as measures, before them its mean where that is one."""
    ends = {f"{name}_min": float(values.min()), f"{name}_max": float(values.max())}
    return {f"{name}_mean": float(values.mean()), **ends} if mean else ends


def largest(values: FloatArray) -> float:
    """The value of largest magnitude, with its sign."""
    return float(values[int(np.argmax(np.abs(values)))])


def term_measures(
    terms: Mapping[str, FloatArray], rows: slice | np.ndarray, worst: int, *,
    off: Mapping[str, FloatArray] | None = None, weights: FloatArray | None = None,
) -> dict[str, float]:  # fmt: skip
    """Mean and largest displacement by each term over some rows, and its part in the one off the surface at the worst.

    Of feed drives, what they are off the surface by, at most. ``off``: displacements off the surface (n,) where it does
    not lie along x; ``weights``: of the rows in the means.
    """
    found: dict[str, float] = {}
    for name, of_term in terms.items():
        away = of_term[:, 1] if off is None else off[name]
        found[f"share_{name}"] = float(away[worst])
        if name == "drives":
            found["deviation_drives_max"] = largest(away[rows])
            continue
        for k, axis in enumerate(AXES[:2] if name == "pistons" else AXES):  # a motor tilts across its axis
            part = of_term[rows, k]
            found[f"deflection_{name}_mean_{axis}"] = float(np.average(part, weights=weights))
            found[f"deflection_{name}_max_{axis}"] = largest(part)
    return found


def lowest_frequency(terms: Iterable[NamedTuple]) -> dict[str, float]:
    """The lowest natural frequency of the first term with mass, if there is one."""
    for term in terms:
        if isinstance(term, Swinging | Linked):
            return {"natural_frequency_min": float(natural_frequencies(term).min())}
    return {}


def whole(terms: Sequence[NamedTuple], at: FloatArray) -> FloatArray:
    """Compliance of all terms without inertia at places of the path [m], shape (n, 6, 6)."""
    total = np.zeros((len(at), 6, 6))
    for term in terms:
        if isinstance(term, Compliance):
            each = term.matrix.reshape(len(term.at), 36)
            total += np.stack([np.interp(at, term.at, column) for column in each.T], axis=1).reshape(-1, 6, 6)
    return total


def normal_stiffness(terms: Sequence[NamedTuple]) -> dict[str, float]:
    """Least and greatest stiffness off the surface of the terms without inertia; nothing where they do not yield there."""
    places = np.unique(np.concatenate([term.at for term in terms if isinstance(term, Compliance)] or [np.zeros(1)]))
    return stiffness_of(whole(terms, places)[:, 1, 1])


def stiffness_of(normal: FloatArray) -> dict[str, float]:
    """Least and greatest stiffness of compliances off the surface [m/N], (n,); nothing where one does not yield."""
    if not normal.min() > 0.0:
        return {}
    return {"stiffness_normal_min": float(1.0 / normal.max()), "stiffness_normal_max": float(1.0 / normal.min())}


def wrench_at(force: FloatArray, height: float) -> FloatArray:
    """Forces (..., 3) [N] at a height over the tip [m], each with its moment about the tip [N m], shape (..., 6)."""
    x, y = force[..., 0], force[..., 1]
    moment = np.stack([-height * y, height * x, np.zeros_like(x)], axis=-1)
    return np.concatenate([force, moment], axis=-1)


def energy_at_rest(
    terms: Sequence[NamedTuple], at: FloatArray, wrench: FloatArray, columns: FloatArray
) -> dict[str, float]:
    """The measure of :func:`energy_balance` for terms that all yield at once, from the columns that they noted."""
    twist = columns.reshape(len(wrench), -1, 6).sum(axis=1)
    return {"energy_balance": energy_balance(terms, at, wrench, twist)}


def energy_balance(terms: Sequence[NamedTuple], at: FloatArray, wrench: FloatArray, twist: FloatArray) -> float:
    r"""Work of a wrench less twice the elastic energy, :math:`\max|W\cdot\xi - W^T C W|` over the largest work.

    Parameters
    ----------
    at : array (n,)
        Places of the path [m].
    wrench, twist : array (n, 6)
        Force and moment about the tip [N, N m], and the twist there that was found with it [m, rad].
    """
    work = np.einsum("ni,ni->n", wrench, twist)
    stored = np.einsum("ni,nij,nj->n", wrench, whole(terms, at), wrench)
    return float(np.abs(work - stored).max() / max(np.abs(work).max(), 1e-30))
