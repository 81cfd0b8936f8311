r"""Modes of a tool tip from its frequency response.

.. math:: G(f) = \sum_n \frac{1/k_n}{1 - (f/f_n)^2 + 2 i \zeta_n f/f_n} + r
"""

from typing import Any

import numpy as np
from scipy import ndimage, signal

from cutwise import units
from cutwise.io.measurements import Channel, Measurement
from cutwise.spec.calibration import FrequencyResponse
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate.arm import folds
from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.posed import Finding, FloatArray, Posed, Unknown
from cutwise.study.calibrate.told import (
    covariance_block,
    drawn,
    plain,
    poorly_seen,
    quantity,
    rms,
    unknown_combinations,
)

_HINT = "is more than 1 mm/N; is the unit right?"
_STANDS = 0.05  # prominence of a peak over the largest, to be taken for a mode
_ABOVE_NOISE = 6.0  # prominence of a peak over the scatter near it
_NEAR = 41  # samples over which the scatter is judged
_NOT_NOISE = 2.0  # chi squared over its degrees of freedom


def channels(_settings: FrequencyResponse | None) -> tuple[Channel, ...]:
    """Columns of the response: real and imaginary part, or magnitude and phase; as compliance, or acceleration over force."""
    return (
        Channel("frequency", "frequency", unit="Hz"),
        *(Channel(name, "compliance", False, 1e-3, _HINT, "um/N", "accelerance") for name in ("real", "imaginary", "magnitude")),
        Channel("phase", "angle", False, unit="deg"), Channel("coherence", "dimensionless", False),
    )  # fmt: skip


def calibrate(data: Measurement, settings: FrequencyResponse) -> Finding:
    """Fit all modes and the residual together."""
    frequency, response = _response(data)
    starts = _starts(data, frequency, response, settings)
    posed = _posed(frequency, response, starts, settings, _relative(data, settings))
    share = 0.0 if settings.fit.hold_out is None else settings.fit.hold_out
    fit = fitted(
        posed, loss=settings.fit.loss, level=settings.fit.level, prior=settings.fit.prior, folds=folds(share, data.rows)
    )
    modes, failed, warnings = len(starts), [], []
    for k in range(modes):
        f, stiffness, damping = fit.x[3 * k : 3 * k + 3]
        for name, value in (("stiffness", stiffness), ("damping", damping)):
            if value <= 0.0:
                warnings.append(f"modes[{k}].{name} came out negative, which no mode is; written as it is")
                failed.append(f"modes[{k}].{name} is negative")
        if not frequency[0] <= f <= frequency[-1]:
            failed.append(f"modes[{k}] lies outside of the data, at {units.show(float(f), 'frequency')}")
    if fit.scale**2 > _NOT_NOISE:
        failed.append(
            f"chi squared over its degrees of freedom is {fit.scale**2:.3g}: a mode is missing, or the "
            "scatter is larger than data.noise_*"
        )
    values = tuple(plain(fit, k) for k in range(len(posed.unknowns)))
    direction = settings.data.direction or "x"
    if "coherence" in data.columns and settings.data.averages is None:
        warnings.append("the coherence is not used: how many averages is not given (data.averages)")
    if settings.data.direction is None:
        warnings.append("data.direction is not given: the modes are written as those along x")
    listed = [{"direction": direction, **mode} for mode in _told(fit.posed, fit.x, modes)]
    block: dict[str, Any] = {"modes": {
        "value": listed, "standard_error": _told(fit.posed, fit.standard_errors, modes), "status": "measured",
        "covariance": "modes", "source": f"{{file}}, {data.rows} frequencies",
    }}  # fmt: skip
    dimensions = [unknown.dimension for unknown in posed.unknowns[:-1]]  # no tool has the residual
    return Finding(
        f"{modes} mode{'s' if modes != 1 else ''}", values, block,
        {"modes": covariance_block(fit, posed.names[:-1], dimensions)}, float(np.sqrt(np.mean(fit.residual**2))), "compliance",
        rms(fit.left_out), "rms of real and imaginary part", "compliance", fit, drawn(posed, fit.residual), (), tuple(warnings),
        (f"chi squared over its degrees of freedom {fit.scale**2:.4g} ({_noise(data, settings)}, assumed)",
         "modes outside of the measured frequencies: they are in the residual", *poorly_seen(fit)), (), tuple(failed),
        fit.outliers, fit.condition, unknown_combinations(fit),
    )  # fmt: skip


def _told(posed: Posed, values: FloatArray, modes: int) -> list[dict[str, Any]]:
    """Frequency, stiffness and damping of each mode as an entry holds them."""
    return [
        {key: quantity(float(values[3 * k + j]), posed.unknowns[3 * k + j].dimension)
         for j, key in enumerate(("frequency", "stiffness", "damping"))} for k in range(modes)
    ]  # fmt: skip


def _response(data: Measurement) -> tuple[FloatArray, Any]:
    """Frequencies [Hz] and response [m/N], complex."""
    there, faults = set(data.columns), []
    if not ({"real", "imaginary"} <= there or {"magnitude", "phase"} <= there):
        faults.append(data.fault("needs columns real [um/N] and imaginary [um/N], or magnitude [um/N] and phase [deg]"))
    frequency = data.columns["frequency"]
    low = np.flatnonzero(frequency <= 0.0)
    faults += [data.fault("frequency: must be above zero", int(row)) for row in low[:3]]
    if len(np.unique(frequency)) < len(frequency):
        repeated = int(np.flatnonzero(np.diff(np.sort(frequency)) == 0.0)[0])
        faults.append(data.fault(f"frequency {np.sort(frequency)[repeated]:g} Hz is there twice"))
    if faults:
        raise ScenarioFault(faults)
    cartesian = {"real", "imaginary"} <= there
    if cartesian and len({"real", "imaginary"} & data.in_other) == 1:
        raise ScenarioFault(
            [data.fault("real and imaginary are a compliance and an acceleration over force; one of both")]
        )
    if cartesian:
        found = data.columns["real"] + 1j * data.columns["imaginary"]
    else:
        found = data.columns["magnitude"] * np.exp(1j * data.columns["phase"])
    turned = ("real" if cartesian else "magnitude") in data.in_other  # accelerance is -(2 pi f)^2 times the compliance
    return frequency, found / -((2.0 * np.pi * frequency) ** 2) if turned else found


def _relative(data: Measurement, settings: FrequencyResponse) -> FloatArray:
    r"""Scatter over magnitude (n,): :math:`\sqrt{(1-\gamma^2)/(n \gamma^2)}` of n averages with a coherence, else as set."""
    coherence = data.columns.get("coherence")
    if coherence is None or settings.data.averages is None:
        return np.full(data.rows, settings.data.noise_relative)
    wrong = np.flatnonzero((coherence <= 0.0) | (coherence > 1.0))
    if len(wrong):
        raise ScenarioFault([
            data.fault("coherence: must be above 0, and at most 1", int(row)) for row in wrong[:5]
        ])  # fmt: skip
    return np.asarray(np.sqrt((1.0 - coherence) / (settings.data.averages * coherence)))


def _noise(data: Measurement, settings: FrequencyResponse) -> str:
    if "coherence" in data.columns and settings.data.averages is not None:
        return f"scatter by the coherence and {settings.data.averages} averages"
    return f"data.noise_relative {settings.data.noise_relative:g}"


def _starts(
    data: Measurement, frequency: FloatArray, response: Any, settings: FrequencyResponse
) -> list[tuple[float, float, float]]:
    """Frequency, stiffness and damping ratio of the peaks of the imaginary part, by their widths at half height."""
    order = np.argsort(frequency)
    f, imaginary = frequency[order], response.imag[order]
    height = np.abs(imaginary)
    stands = np.maximum(_STANDS * height.max(), _ABOVE_NOISE * _noise_of(imaginary))
    peaks, found = signal.find_peaks(height, prominence=stands)
    if len(peaks) == 0:
        raise ScenarioFault([data.fault(
            "has no peak of the imaginary part: is it a compliance (displacement over force), and do the frequencies reach "
                    "the modes?"
        )])  # fmt: skip
    if np.median(imaginary[peaks]) > 0.0:
        raise ScenarioFault([data.fault(
            "the imaginary part is positive at the peaks: displacement follows force, so it is negative; a sign or "
                    "the phase is turned"
        )])  # fmt: skip
    count = settings.fit.modes or len(peaks)
    if count > len(peaks):
        message = f"{count} modes are asked for, and {len(peaks)} peaks stand out"
        raise ScenarioFault([Fault(("fit", "modes"), message)])
    kept = np.sort(peaks[np.argsort(-found["prominences"])[:count]])
    widths = signal.peak_widths(height, kept, rel_height=0.5)
    numbers = np.arange(len(f))
    starts = []
    for peak, left, right in zip(kept, widths[2], widths[3], strict=True):
        width = max(float(np.interp(right, numbers, f) - np.interp(left, numbers, f)), 1e-6 * f[peak])
        damping = float(np.clip(0.5 * width / f[peak], 1e-4, 0.4))
        starts.append((float(f[peak]), float(1.0 / (2.0 * damping * height[peak])), damping))
    return starts


def _noise_of(values: FloatArray) -> FloatArray:
    """Scatter about a smooth curve, near each sample (n,): of second differences, whose variance is six times that."""
    bend = np.abs(np.diff(values, 2, prepend=values[:1], append=values[-1:]))
    width = min(_NEAR, len(bend))
    return np.asarray(ndimage.median_filter(bend, size=width, mode="nearest") / (0.6745 * np.sqrt(6.0)))


def _posed(
    frequency: FloatArray, response: Any, starts: list[tuple[float, float, float]], settings: FrequencyResponse,
    relative: FloatArray | None = None,
) -> Posed:  # fmt: skip
    rows, count = len(frequency), len(starts)
    spread = settings.data.noise_relative if relative is None else relative
    unknowns = []
    for k, (f, stiffness, damping) in enumerate(starts):
        unknowns += [
            Unknown(f"modes[{k}].frequency", "frequency", f, True), Unknown(f"modes[{k}].stiffness", "stiffness", stiffness, True),
            Unknown(f"modes[{k}].damping", "dimensionless", damping, True),
        ]  # fmt: skip
    scale = float(np.sqrt(np.mean(np.abs(response) ** 2)))
    unknowns.append(Unknown("residual_compliance", "compliance", 0.0, False, scale))

    def split(values: Any) -> FloatArray:
        return np.stack([values.real, values.imag], axis=1).reshape(rows * 2, *values.shape[1:])

    def each(x: FloatArray) -> Any:
        for k in range(count):
            f, stiffness, damping = x[3 * k : 3 * k + 3]
            ratio = frequency / f
            yield f, stiffness, ratio, damping, 1.0 / (1.0 - ratio**2 + 2j * damping * ratio)

    def model(x: FloatArray) -> FloatArray:
        return split(sum(one / stiffness for _, stiffness, _, _, one in each(x)) + x[-1])

    def jacobian(x: FloatArray) -> FloatArray:
        columns = []
        for f, stiffness, ratio, damping, one in each(x):
            square = one * one / stiffness
            columns += [
                -square * (2.0 * ratio**2 - 2j * damping * ratio) / f, -one / stiffness**2, -square * 2j * ratio,
            ]  # fmt: skip
        columns.append(np.ones(rows, dtype=complex))
        return split(np.stack(columns, axis=1))

    def sigma(modelled: FloatArray) -> FloatArray:
        size = np.linalg.norm(modelled.reshape(rows, 2), axis=1)
        level = np.sqrt(((spread * size) ** 2 + settings.data.noise_floor**2) / 2.0)
        return np.repeat(np.maximum(level, 1e-6 * scale), 2)

    return Posed(
        tuple(unknowns), split(response), np.repeat(np.arange(rows), 2), np.tile(np.arange(2), rows), ("real", "imaginary"),
        ("compliance", "compliance"), model, jacobian, linear=False, sigma=sigma,
    )  # fmt: skip
