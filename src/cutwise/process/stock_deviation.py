"""The machined surface held against the nominal part: deviation at its samples, face by face."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.io.part_samples import Samples
from cutwise.maths.curves import FloatArray
from cutwise.maths.solid import CIRCLE
from cutwise.maths.workpiece import Frame, under
from cutwise.physics.surface.map_deviation import REACH, Fit, deviations, fitted, shaped_by
from cutwise.process.nominal_part import nominal_samples, tolerance_of
from cutwise.process.stock_material import Raw
from cutwise.process.stock_milling import StockRunDone
from cutwise.process.stock_setups import Done
from cutwise.spec.milling import MillingScenario

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_OWN = 1e-9  # [m] from the stock's own surface
_UPRIGHT = 1e-6  # of a normal along the tool axis: a wall
_SCALLOPS = ("ball", "bull_nose")
_LOW = 0.05  # quantile from which a scallop is counted


class FaceDeviation(NamedTuple):
    """Deviation of one face that is judged."""

    face: int
    name: str
    area: float  # that is judged [m^2]
    least: float  # [m]
    most: float
    mean: float
    rms: float
    gouge: float  # volume cut into the part [m^3]
    excess: float  # volume of material left
    cut: bool  # whether any move made a part of it
    scallop: float  # [m]; NaN where neither ball nor bull-nose cut it


class Owners(NamedTuple):
    """The runs to which segments belong."""

    first: IntArray  # number of the first segment of each run, shape (runs,); lower ones are of earlier runs
    runs: tuple[StockRunDone, ...]
    frames: tuple[Frame, ...]  # of their set-ups

    def of(self, segment: IntArray) -> tuple[IntArray, IntArray]:
        """Run and segment in it, of segments (n,); the run is -1 for the stock and for earlier runs."""
        run = np.searchsorted(self.first, segment, side="right") - 1
        return run, segment - self.first[np.maximum(run, 0)]


class Deviation(NamedTuple):
    """Deviation of the machined surface from the part, positive where material is left."""

    samples: Samples
    value: FloatArray  # [m]; NaN where a face is seen from behind, shape (n,)
    segment: IntArray  # that made the surface, of all maps together; -1 the stock, shape (n,)
    owners: Owners
    faces: tuple[FaceDeviation, ...]
    tolerance: float | None
    fit: Fit | None
    judged: float  # area [m^2]
    within: float  # share of it in tolerance
    rms: float
    outside: tuple[float, tuple[float, float, float]]  # how far the part stands out of the stock [m], and where

    @property
    def judged_samples(self) -> BoolArray:
        """Samples of faces that are not seen from behind."""
        return np.isfinite(self.value)

    def worst(self, gouge: bool) -> int:
        """The sample with the deepest gouge, or the most material left."""
        value = np.where(self.judged_samples, self.value, 0.0)
        return int(np.argmin(value) if gouge else np.argmax(value))


class Judged(NamedTuple):
    """The surface that comes off the machine, and where that is another one the ideal surface, against the part."""

    left: Deviation
    ideal: Deviation | None


def judged(scenario: MillingScenario, done: Done) -> Judged | None:
    """The machined surfaces against the part; None without a part."""
    if scenario.nominal is None:
        return None
    samples = nominal_samples(scenario)
    left = deviation(scenario, done, samples, ideal=False)
    return Judged(left, deviation(scenario, done, samples, ideal=True) if done.moved else None)


def deviation(scenario: MillingScenario, done: Done, samples: Samples, *, ideal: bool) -> Deviation:
    """A machined surface against samples of the part."""
    part = scenario.nominal
    assert part is not None
    value, segment = np.empty(len(samples.weight)), np.empty(len(samples.weight), np.int64)
    tolerance = tolerance_of(scenario)
    runs = done.left(ideal)
    solids = done.solids(min(run.grid for run in runs), ideal)
    seen = Frame(np.eye(3), np.zeros(3))
    left = shaped_by(under([one.solid for one in solids], [one.frame for one in solids], seen))
    deviations(
        left, np.ascontiguousarray(samples.point), np.ascontiguousarray(samples.normal), tolerance, value, segment
    )
    owners = Owners(left.first[len(solids) - len(runs) :], runs, tuple(job.frame for job in done.jobs))
    judged = np.isfinite(value)
    lean = np.abs(samples.normal @ left.piece.turn[:, 2].T).min(axis=1)
    own = (
        judged & (lean <= _UPRIGHT) & (segment < 0) & (np.abs(value) <= _OWN)
    )  # the outline of the stock, which no tool has to make
    counted = judged & ~own
    faces = tuple(
        _of_face(owners, samples, value, segment, face, tolerance) for face in np.unique(samples.face[judged]).tolist()
    )
    area = float(samples.weight[judged].sum())
    weight = samples.weight[counted]
    total = float(weight.sum())
    within = float(weight[np.abs(value[counted]) <= tolerance].sum()) / total if total > 0.0 else 1.0
    rms = math.sqrt(float(weight @ value[counted] ** 2) / total) if total > 0.0 else 0.0
    fit = None
    if total > 0.0 and judged.sum() > 6:  # the outline too: where it stands says where the part lies in the stock
        fit = fitted(samples.point[judged], samples.normal[judged], value[judged], samples.weight[judged])
    return Deviation(
        samples, value, segment, owners, faces, part.tolerance, fit, area, within, rms,
        _standing_out(done.raw, samples.point),
    )  # fmt: skip


def _of_face(
    owners: Owners, samples: Samples, value: FloatArray, segment: IntArray, face: int, tolerance: float
) -> FaceDeviation:
    mine = (samples.face == face) & np.isfinite(value)
    d, w = value[mine], samples.weight[mine]
    area = float(w.sum())
    made = segment[mine]
    return FaceDeviation(
        face, samples.names[face], area, float(d.min()), float(d.max()), float(w @ d) / area,
        math.sqrt(float(w @ (d * d)) / area), -float(w @ np.minimum(d, 0.0)), float(w @ np.maximum(d, 0.0)),
        bool((made >= 0).any()), _scallop(owners, d, made, tolerance),
    )  # fmt: skip


def _scallop(owners: Owners, value: FloatArray, segment: IntArray, tolerance: float) -> float:
    """Largest deviation less the 5 % quantile, where ball or bull-nose cut and no pass went too deep."""
    run, own = owners.of(segment)
    theirs = np.zeros(value.size, bool)
    for number, done in enumerate(owners.runs):
        mine = run == number
        round_ = np.array([shape in _SCALLOPS for shape in done.planned.tools.shapes])
        theirs[mine] = round_[done.moves.path.row[own[mine], 1].astype(np.int64)]
    there = theirs & (value >= -0.1 * tolerance)
    if (
        2 * int(theirs.sum()) <= value.size or not there.any()
    ):  # an edge that a ball touches in passing is no scalloped face
        return math.nan
    return float(value[there].max() - np.quantile(value[there], _LOW))


def _standing_out(raw: Raw, point: FloatArray) -> tuple[float, tuple[float, float, float]]:
    """How far the part stands out of the box or the round bar of the stock at the most [m], and where."""
    (x0, x1), (y0, y1), (z0, z1) = raw.box
    out = np.maximum(np.maximum(point[:, 2] - z1, z0 - point[:, 2]), 0.0)
    if raw.kind == CIRCLE:
        away = np.hypot(point[:, 0] - raw.circle[0], point[:, 1] - raw.circle[1]) - raw.circle[2]
        out = np.maximum(out, away)
    else:
        sides = (x0 - point[:, 0], point[:, 0] - x1, y0 - point[:, 1], point[:, 1] - y1)
        out = np.maximum.reduce([out, *sides])
    worst = int(np.argmax(out))
    x, y, z = (float(v) for v in point[worst])
    return float(out[worst]), (x, y, z)


def cut_off(value: float) -> bool:
    """Whether a deviation is as large as distances are followed: it may be more."""
    return abs(value) >= REACH * (1.0 - 1e-9)
