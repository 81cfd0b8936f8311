r"""Cutting coefficients from mean forces over whole turns, on the tool: x feed, y normal, z to the motor.

.. math::
    F_x = -f [c (K_{tc} I_{sc} + K_{rc} I_{ss}) + K_{te} I_c + K_{re} I_s], \quad
    F_y = f [c (K_{tc} I_{ss} - K_{rc} I_{sc}) + K_{te} I_s - K_{re} I_c], \quad
    F_z = -f [c K_{ac} I_s + K_{ae} \Delta]

with :math:`f = N a/2\pi`, feed per tooth c, arc :math:`\Delta = \varphi_{ex} - \varphi_{st}` and the integrals of sine and
cosine over it. Kienzle's law, :math:`k\,h^{1-m}` with h in mm, by quadrature over the arc.
"""

import math
from itertools import permutations, product
from typing import Any

import numpy as np

from cutwise import units
from cutwise.io.measurements import Channel, Measurement
from cutwise.spec.calibration import MINUS, MeanForces
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate.arm import folds
from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.posed import Finding, Fit, FloatArray, Posed, Unknown
from cutwise.study.calibrate.told import (
    covariance_block,
    drawn,
    plain,
    poorly_seen,
    quantity,
    rms,
    unknown_combinations,
    written,
)

MODELS = ("linear", "kienzle")
LINEAR = ("K_tc", "K_rc", "K_ac", "K_te", "K_re", "K_ae")
KIENZLE = ("k_c11", "k_r11", "k_a11", "m_c", "m_r", "m_a")
_FORCES = ("force_x", "force_y", "force_z")
_SPREAD_OF_FEEDS = 2.0  # largest over smallest, below which the edge is told from the chip by little
_NODES = 200


def channels(_settings: MeanForces | None) -> tuple[Channel, ...]:
    """Columns of the mean forces."""
    hint = "is more than 5 mm of feed per tooth; is the unit right?"
    return (Channel("feed_per_tooth", "length", True, 5e-3, hint, "mm"), *(Channel(name, "force") for name in _FORCES))


def calibrate(data: Measurement, settings: MeanForces) -> Finding:
    """Fit both laws and write the one that is asked for."""
    model = settings.fit.model or MODELS[0]
    faults = []
    feeds = data.columns["feed_per_tooth"]
    faults += [data.fault("feed_per_tooth: must be above zero", int(row)) for row in np.flatnonzero(feeds <= 0.0)]
    if not faults and len(np.unique(feeds)) < 2:
        message = (
            f"all rows have one feed, {units.show(feeds[0], 'length', 4)}: cut at 3 feeds or more, the largest 2 times"
        )
        faults.append(data.fault(f"{message} the smallest"))
    if faults:
        raise ScenarioFault(faults)
    forces, axes = _on_tool(data, settings)
    linear = _fitted(settings, _linear(feeds, forces, settings), data.rows)
    kienzle = _fitted(settings, _kienzle(feeds, forces, settings, linear), data.rows)
    chosen = linear if model == MODELS[0] else kienzle
    return _found(data, settings, chosen, model, (linear, kienzle), axes)


def _fitted(settings: MeanForces, posed: Posed, rows: int) -> Fit:
    apart = folds(settings.fit.hold_out, rows)
    return fitted(posed, loss=settings.fit.loss, level=settings.fit.level, prior=settings.fit.prior, folds=apart)


def integrals(start: float, end: float) -> tuple[float, float, float, float, float]:
    """I_sc, I_ss, I_s, I_c and the arc."""
    i_sc = 0.5 * (math.sin(end) ** 2 - math.sin(start) ** 2)
    i_ss = 0.5 * (end - start) - 0.25 * (math.sin(2.0 * end) - math.sin(2.0 * start))
    return i_sc, i_ss, math.cos(start) - math.cos(end), math.sin(end) - math.sin(start), end - start


def _factor(settings: MeanForces) -> float:
    return settings.tool.flutes * settings.operation.axial_depth / (2.0 * math.pi)


def _linear(feeds: FloatArray, forces: FloatArray, settings: MeanForces) -> Posed:
    """Mean forces, linear in the six coefficients."""
    i_sc, i_ss, i_s, i_c, arc = integrals(*settings.cut.arc)
    zero, one = np.zeros_like(feeds), np.ones_like(feeds)
    matrix = _factor(settings) * np.stack([
        np.column_stack([-feeds * i_sc, -feeds * i_ss, zero, -one * i_c, -one * i_s, zero]),
        np.column_stack([feeds * i_ss, -feeds * i_sc, zero, one * i_s, -one * i_c, zero]),
        np.column_stack([zero, zero, -feeds * i_s, zero, zero, -one * arc]),
    ], axis=1).reshape(-1, 6)  # fmt: skip
    first = np.linalg.lstsq(matrix / np.linalg.norm(matrix, axis=0), forces.reshape(-1), rcond=None)[0]
    first = first / np.linalg.norm(matrix, axis=0)
    unknowns = tuple(
        Unknown(name, "stress" if k < 3 else "edge_force", 0.0, True, 0.0 if k < 3 else abs(first[k - 3]) * feeds.max())
        for k, name in enumerate(LINEAR)
    )
    return _posed(unknowns, forces, lambda x: np.asarray(matrix @ x), lambda _: matrix, linear=True)


def _posed(unknowns: tuple[Unknown, ...], forces: FloatArray, model: Any, jacobian: Any, *, linear: bool) -> Posed:
    rows = len(forces)
    return Posed(
        unknowns, forces.reshape(-1), np.repeat(np.arange(rows), 3), np.tile(np.arange(3), rows), _FORCES, ("force",) * 3,
        model, jacobian, linear, sigma_by_column=True, degrees_of_freedom=rows - 2,
    )  # fmt: skip


def _kienzle(feeds: FloatArray, forces: FloatArray, settings: MeanForces, linear: Fit) -> Posed:
    """Mean forces of power laws of the chip thickness; they begin where the linear law has the middle feed."""
    start, end = settings.cut.arc
    u, weight = np.polynomial.legendre.leggauss(_NODES)
    u = 0.5 * (u + 1.0)
    phi = start + (end - start) * u * u * (3.0 - 2.0 * u)  # nodes gather where the chip begins and ends
    weight = 0.5 * weight * (end - start) * 6.0 * u * (1.0 - u)
    sin, cos = np.sin(phi), np.cos(phi)
    thickness = np.maximum(1e3 * feeds[:, None] * sin, 1e-12)  # [mm]
    factor = 1e-3 * _factor(settings)

    def parts(m: float) -> tuple[FloatArray, FloatArray]:
        """h^(1-m) at the nodes, and its derivative with m."""
        power = thickness ** (1.0 - m)
        return power, -np.log(thickness) * power

    def terms(x: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Mean force per k of each law (rows, 3), and its derivative with m."""
        ways = (
            np.stack([-cos, sin, 0 * sin]),
            np.stack([-sin, -cos, 0 * sin]),
            np.stack([0 * sin, 0 * sin, 0 * sin - 1.0]),
        )
        found = []
        for k, way in enumerate(ways):
            power, slope = parts(x[3 + k])
            found.append((factor * (power * weight) @ way.T, factor * (slope * weight) @ way.T))
        return found

    def model(x: FloatArray) -> FloatArray:
        return np.asarray(sum(x[k] * force for k, (force, _) in enumerate(terms(x)))).reshape(-1)

    def jacobian(x: FloatArray) -> FloatArray:
        found = terms(x)
        columns = [force.reshape(-1) for force, _ in found] + [
            x[k] * slope.reshape(-1) for k, (_, slope) in enumerate(found)
        ]
        return np.column_stack(columns)

    middle = float(np.sqrt(feeds.min() * feeds.max()))
    begin = [float((linear.x[k] + linear.x[3 + k] / middle) * (1e3 * middle) ** 0.3) for k in range(3)]
    unknowns = tuple(Unknown(name, "stress", begin[k], True) for k, name in enumerate(KIENZLE[:3]))
    unknowns += tuple(Unknown(name, "dimensionless", 0.3, True, 0.5) for name in KIENZLE[3:])
    return _posed(unknowns, forces, model, jacobian, linear=False)


def _on_tool(data: Measurement, settings: MeanForces) -> tuple[FloatArray, str]:
    """Forces on the tool along x, y, z (rows, 3), and which channels they are."""
    measured = data.matrix(_FORCES)
    sign = -1.0 if settings.data.forces_on == "work" else 1.0
    if settings.data.axes != "auto":
        order = [MINUS[axis] for axis in settings.data.axes]
        return sign * np.column_stack(
            [turn * measured[:, k] for k, turn in order]
        ), f"[{', '.join(settings.data.axes)}]"
    start, end = settings.cut.arc
    if abs(start) > 1e-6 or abs(end - math.pi) > 1e-6:
        raise ScenarioFault(
            [Fault(("data", "axes"), "auto finds the channels of slots alone (cut.arc [0 deg, 180 deg]); name them")]
        )
    feeds = data.columns["feed_per_tooth"]
    fits = []
    for (first, second), signs in product(permutations((0, 1)), product((1.0, -1.0), repeat=3)):
        forces = sign * measured[:, [first, second, 2]] * np.array(signs)
        x = fitted(_linear(feeds, forces, settings)).x
        if np.all(x[:3] > 0.0) and x[0] > x[1]:
            names = [("-" if s < 0 else "") + "xyz"[k] for s, k in zip(signs, (first, second, 2), strict=True)]
            handed = signs[0] * signs[1] * signs[2] * (1.0 if first == 0 else -1.0)
            fits.append((forces, f"[{', '.join(names)}]", handed))
    if not fits:
        raise ScenarioFault(
            [data.fault("no assignment of the channels gives K_tc > K_rc > 0 and K_ac > 0: name data.axes")]
        )
    forces, names_of, handed = fits[0]
    if handed < 0.0:
        raise ScenarioFault([data.fault(
            f"the only channels that fit, {names_of}, are left-handed: a channel is turned, or the forces are those on the "
            "work (data.forces_on: work)"
        )])  # fmt: skip
    return forces, names_of


def _found(data: Measurement, settings: MeanForces, fit: Fit, model: str, both: tuple[Fit, Fit], axes: str) -> Finding:
    feeds = data.columns["feed_per_tooth"]
    values = [plain(fit, k) for k in range(6)]
    warnings, failed, advice = [f"measured channels that are +x, +y, +z: {axes}"], [], []
    if settings.data.axes != "auto":
        warnings = []
    for value in values:
        if value.value < 0.0 and value.name[-1] != "e" and value.name[0] in "Kk":
            warnings.append(
                f"{value.name} came out negative, which no cut gives; written as it is: is a channel turned (data.axes), or "
                "are the forces those on the work (data.forces_on)?"
            )
            failed.append(f"{value.name} is negative")
    if feeds.max() < _SPREAD_OF_FEEDS * feeds.min():
        least, largest = feeds.min(), feeds.max()
        failed.append(
            f"the largest feed is only {largest / least:.3g} times the smallest: chip and edge are told apart by little"
        )
        advice.append(f"cut at {units.show(3.0 * least, 'length', 3)} per tooth as well")
        values = [value._replace(verdict="weak") if value.verdict == "identified" else value for value in values]
    names, rows = LINEAR if model == MODELS[0] else KIENZLE, data.rows
    block = written([v for v in values if v.name in names], "coefficients", rows)
    for key, end in (("chip_thickness_min", feeds.min()), ("chip_thickness_max", feeds.max())):
        block[key] = {
            "value": quantity(float(end), "length"),
            "status": "measured",
            "source": f"{{file}}, feeds of {rows} rows",
        }
    scatter = [fit.scatter[k] for k in range(3)]
    table: list[tuple[str, ...]] = [("model", "rms F_x", "rms F_y", "rms F_z", "left out, rms")]
    for name, one in zip(MODELS, both, strict=True):
        by_axis = (units.show(float(np.sqrt(np.mean(one.residual[k::3] ** 2))), "force", 5) for k in range(3))
        left = rms(one.left_out)
        table.append((name, *by_axis, "-" if left is None else units.show(left, "force", 4)))
    said = ", ".join(units.show(float(one), "force", 4) for one in scatter)
    return Finding(
        model, tuple(values), block, {"coefficients": covariance_block(fit, fit.posed.names, [v.dimension for v in values])},
        float(np.sqrt(np.mean(np.square(scatter)))), "force", rms(fit.left_out), "rms of the forces", "force", fit,
        drawn(fit.posed, fit.residual), tuple(table), tuple(warnings),
        (f"scatter of x, y, z: {said}; run-out and speed: they are not in mean forces", *poorly_seen(fit)), tuple(advice),
        tuple(failed), fit.outliers, fit.condition, unknown_combinations(fit),
    )  # fmt: skip
