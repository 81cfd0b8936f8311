"""``cutwise calibrate``: parameters from a measurement, as a library entry."""

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutwise.app import outputs
from cutwise.app.exits import OK, REQUIREMENT_FAILED, refuse
from cutwise.app.options import SET, Overrides
from cutwise.disk import write_text

if TYPE_CHECKING:
    from cutwise.study.calibrate.outcome import Outcome
    from cutwise.study.calibrate.posed import Value


def calibrate(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="what is calibrated, for example robot-stiffness")],
    data: Annotated[
        Path | None, typer.Argument(metavar="DATA", help="measured data (CSV, units in the titles)")
    ] = None,
    overrides: Overrides = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="write the library entry (YAML)")
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", metavar="FILE", help="write a page: data, fit, residuals, correlations")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="print one JSON object (SI) and nothing else on standard output")
    ] = False,
    template: Annotated[bool, typer.Option("--template", help="print an empty data file of this kind")] = False,
) -> None:
    """Find parameters from a measurement, with what is not known about them, as an entry of the library."""
    from cutwise.study.calibrate.kinds import kind_named

    chosen = kind_named(kind)
    if template:
        from cutwise.io.measurements import template as empty

        print(empty(chosen.channels(None), chosen.describes), end="")
        return
    if data is None:
        refuse(f"name the measured data: cutwise calibrate {kind} DATA.csv; --template prints an empty file")
    from cutwise.study.calibrate.outcome import calibrated

    outputs.checked([output, report], [data])
    found = calibrated(kind, data, overrides or (), named=SET)
    files = {}
    if output is not None and found.finding.entry:
        files["entry"] = str(write_text(output, found.entry(output.stem)))
    if report is not None:
        from cutwise.app.calibration_page import page

        files["report"] = str(write_text(report, page(found)))
    if as_json:
        import json

        print(json.dumps(found.as_json(files), allow_nan=False))
    else:
        print(shown(found))
        for path in files.values():
            print(path)
        if not found.finding.entry:
            print("no entry is written: the fit does not explain the data", file=sys.stderr)
        elif output is None:
            print("nothing written; -o FILE writes the library entry", file=sys.stderr)
    raise typer.Exit(REQUIREMENT_FAILED if found.reasons else OK)


def line_of(value: "Value") -> tuple[str, str, str, str]:
    """Value ± standard error, interval and verdict of a parameter."""
    from cutwise import units

    number, unit = units.displayed(value.value, value.dimension)
    scale = value.value / number if number else units.displayed(1.0, value.dimension)[0] ** -1
    ends = ["no end" if end is None else f"{end / scale:.5g}" for end in (value.low, value.high)]
    error = f"{value.standard_error / scale:.3g}" if math.isfinite(value.standard_error) else "unknown"
    said = f"{number:.6g} ± {error} {unit}".strip()
    note = f" ({value.note})" if value.note else ""
    return value.name, said, f"{ends[0]} … {ends[1]}", f"{value.verdict}{note}"


def shown(found: "Outcome") -> str:
    """A calibration as text."""
    from cutwise import units

    finding, level = found.finding, found.settings.fit.level
    lines = [f"{found.kind.name}, model {finding.model}: {found.data.rows} rows of {found.data.file}"]
    rows = [("", "value ± standard error", f"{level:.0%} interval", ""), *map(line_of, finding.values)]
    wide = [max(len(row[k]) for row in rows) for k in range(3)]
    lines += ["  ".join(f"{row[k]:<{wide[k]}}" for k in range(3)) + f"  {row[3]}".rstrip() for row in rows]
    lines.append(f"residual {units.show(finding.residual, finding.residual_dimension)}")
    if finding.left_out_error is not None:
        error = finding.left_out_error
        relative = finding.left_out_dimension == "dimensionless"
        text = f"{error:.2%}" if relative else units.show(error, finding.left_out_dimension)
        lines.append(f"left out: {text}, {finding.left_out_words}")
    lines += _table(finding.compared)
    for outlier in finding.outliers[:10]:
        weight = f", weight {outlier.weight:.2f}" if outlier.weight < 1.0 else ""
        lines.append(
            f"outlier: {outlier.column} in line {found.data.lines[outlier.row]} (row {outlier.row + 1}), "
            f"{outlier.studentised:.4g} standard deviations{weight}; kept"
        )
    lines += [f"not told by the data: {text}" for text in finding.cannot_tell]
    lines += [f"measure next: {text}" for text in found.advice]
    lines += [f"warning: {text}" for text in found.warnings]
    reasons = found.reasons
    lines += [f"not identified: {text}" for text in reasons] if reasons else ["identified"]
    return "\n".join(lines)


def _table(rows: tuple[tuple[str, ...], ...]) -> list[str]:
    if not rows:
        return []
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]
