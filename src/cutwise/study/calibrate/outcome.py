"""A whole calibration: settings and file read with all their faults, fitted, judged, and said in words."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cutwise import units
from cutwise.io.measurements import Measurement, read_measurement
from cutwise.io.scenario import OVERRIDES, settings
from cutwise.spec.calibration import Calibration
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Origin
from cutwise.study.calibrate.entry import entry_text, ranges
from cutwise.study.calibrate.kinds import Kind, kind_named
from cutwise.study.calibrate.posed import Finding

MANY_OUTLIERS = 0.05  # of the rows: the residual is not noise


class Outcome(NamedTuple):
    """A finished calibration."""

    kind: Kind
    finding: Finding
    data: Measurement
    settings: Calibration
    origins: dict[str, Origin]

    @property
    def reasons(self) -> list[str]:
        """Why it is not identified; none if it is."""
        found = [
            f"{value.name} is {value.verdict}{': ' + value.note if value.note else ''}"
            for value in self.finding.values
            if value.deciding and value.verdict != "identified"
        ]
        found += self.finding.failed
        rows = {outlier.row for outlier in self.finding.outliers}
        if len(rows) > max(1.0, MANY_OUTLIERS * self.data.rows):
            found.append(f"{len(rows)} of {self.data.rows} rows are outliers: the residual is not noise")
        return list(dict.fromkeys(found))

    @property
    def warnings(self) -> list[str]:
        """What to know."""
        unused = self.data.unused
        passed = [f"columns that are not used: {', '.join(unused)}"] if unused else []
        return [*self.finding.warnings, *passed]

    def entry(self, name: str) -> str:
        """The library entry as YAML."""
        return entry_text(self.kind, self.finding, self.data, self.settings, self.origins, name)

    @property
    def advice(self) -> list[str]:
        """What to measure next."""
        fit, found = self.finding.fit, list(self.finding.advice)
        if fit is not None and fit.next is not None:
            best = fit.next
            found.append(
                f"the row of line {self.data.lines[best.row]} again tells most (log det of the information +{best.gain:.4g})"
            )
            found.append(
                f"for {best.parameter}, least well known, that of line {self.data.lines[best.parameter_row]} again "
                f"(its standard error times {best.factor:.4g})"
            )
        return found

    def as_json(self, files: dict[str, str]) -> dict[str, Any]:
        """In SI, for other programs."""
        finding = self.finding
        best = finding.fit.next if finding.fit is not None else None
        return {
            "kind": self.kind.name, "model": finding.model,
            "parameters": {
                value.name: {
                    "value": _number(value.value), "standard_error": _number(value.standard_error), "low": value.low,
                    "high": value.high, "unit": units.DIMENSIONS[value.dimension].si, "verdict": value.verdict,
                }
                for value in finding.values
            },
            "covariances": finding.covariances, "residual": finding.residual, "left_out_error": finding.left_out_error,
            "condition": _number(finding.condition), "unknown": list(finding.unknown),
            "outliers": [
                {"row": outlier.row + 1, "column": outlier.column, "studentised": outlier.studentised}
                for outlier in finding.outliers
            ],
            "next": None if best is None else {
                "row": best.row + 1, "log_det": best.gain, "parameter": best.parameter,
                "parameter_row": best.parameter_row + 1, "factor": best.factor,
            },
            "ranges": {name: [low, high] for name, (_, low, high) in ranges(self.kind, self.data, self.settings).items()},
            "warnings": self.warnings, "reasons": self.reasons, "files": files,
        }  # fmt: skip


def _number(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def calibrated(
    name: str, file: Path, overrides: Sequence[str] | dict[str, Any] = (), *, named: str = OVERRIDES
) -> Outcome:
    """Calibrate from a file.

    Raises
    ------
    ScenarioFault
        Everything wrong with settings and file.
    SolverFailure
        The fit does not converge.
    """
    kind = kind_named(name)
    faults: list[Any] = []
    read: Any = None
    origins: dict[str, Origin] = {}
    try:
        read, origins = settings(kind.settings, overrides, named=named)
    except ScenarioFault as found:
        faults += found.faults
    model = read.fit.model if read is not None else None
    if model is not None and model not in kind.models:
        there = f"there are {', '.join(kind.models)}" if kind.models else "it has one, leave the key out"
        faults.append(
            Fault(("fit", "model"), f'"{model}" is not a model of {kind.name}; {there}', file=named.format("fit.model"))
        )
    try:
        data = read_measurement(file, kind.channels(read), kind.least_rows, kind.too_few)
    except ScenarioFault as found:
        faults += found.faults
    if faults:
        raise ScenarioFault(faults)
    finding = kind.calibrate(data, read)
    _priors_used(kind, finding, read, named)
    return Outcome(kind, finding, data, read, origins)


def _priors_used(kind: Kind, finding: Finding, settings: Calibration, named: str) -> None:
    """Refuse priors of what is not fitted, or fitted in a way that takes none."""
    if not settings.fit.prior:
        return
    place = named.format("fit.prior")
    if finding.fit is None:
        model = f" with fit.model={finding.model}" if kind.models else ""
        raise ScenarioFault([Fault((), f"{kind.name}{model} takes no priors; leave the key out", file=place)])
    unknown = [name for name in settings.fit.prior if name not in finding.fit.posed.names]
    if unknown:
        there = ", ".join(finding.fit.posed.names[:16])
        raise ScenarioFault(
            [Fault((), f"{', '.join(unknown)}: no parameter of this fit; there are {there}", file=place)]
        )
