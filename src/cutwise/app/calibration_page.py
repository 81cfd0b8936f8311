"""The page of a calibration: data with the fit, residuals, intervals, correlations; one file without outside requests."""

from typing import TYPE_CHECKING, Any

import numpy as np

import cutwise
from cutwise import units
from cutwise.app.calibrating import line_of
from cutwise.app.pages import template
from cutwise.app.plots import figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cutwise.study.calibrate.outcome import Outcome


def page(found: "Outcome") -> str:
    """The page as HTML."""
    finding = found.finding
    relative = finding.left_out_dimension == "dimensionless"
    error = finding.left_out_error
    left_out = "" if error is None else f"{error:.2%}" if relative else units.show(error, finding.left_out_dimension)
    drawings = (("Measured and fitted", _against, "fit"), ("Residuals", _left, "rest")) if finding.drawn else ()
    plots = [(title, figures.svg(draw, found, name, title)) for title, draw, name in drawings]
    return template("calibration").render(
        found=found, finding=finding, version=cutwise.__version__, colours=figures.COLOURS,
        rows=[line_of(value) for value in finding.values], left_out=left_out,
        residual=units.show(finding.residual, finding.residual_dimension), plots=plots,
        correlations=_correlations(found), reasons=found.reasons, level=f"{found.settings.fit.level:.0%}",
        date=found.settings.measured.date or found.data.date or "not stated",
    )  # fmt: skip


def _correlations(found: "Outcome") -> list[list[str]]:
    """Table of correlations, titles first; empty without a covariance or where it would fill pages."""
    fit = found.finding.fit
    if fit is None or len(fit.x) > 24:
        return []
    names = list(fit.posed.names)
    matrix = fit.correlation()
    return [["", *names], *([name, *(f"{c:.3f}" for c in row)] for name, row in zip(names, matrix, strict=True))]


def _against(found: "Outcome") -> "Figure":
    """Measured over fitted, one panel a column."""
    drawn = found.finding.drawn
    fig = figures.figure(3.2)
    axes = np.atleast_1d(fig.subplots(1, len(drawn)))
    for ax, (name, dimension, measured, modelled) in zip(axes, drawn, strict=True):
        scale, unit = figures.scale(dimension)
        both = np.concatenate([measured, modelled]) * scale
        ends = [float(both.min()), float(both.max())]
        ax.plot(ends, ends, color=figures.SOFT, linewidth=0.8)
        ax.plot(modelled * scale, measured * scale, ".", markersize=4)
        ax.set(title=name, xlabel=f"fitted [{unit}]", ylabel=f"measured [{unit}]")
    return fig


def _left(found: "Outcome") -> "Figure":
    """Residual of each row, outliers marked."""
    drawn = found.finding.drawn
    fig = figures.figure(2.8)
    axes = np.atleast_1d(fig.subplots(1, len(drawn)))
    for ax, (name, dimension, measured, modelled) in zip(axes, drawn, strict=True):
        scale, unit = figures.scale(dimension)
        rest: Any = (measured - modelled) * scale
        ax.axhline(0.0, color=figures.SOFT, linewidth=0.8)
        ax.plot(np.arange(1, len(rest) + 1), rest, ".", markersize=4)
        wrong = [outlier.row for outlier in found.finding.outliers if outlier.column == name]
        ax.plot(np.array(wrong, dtype=int) + 1, rest[wrong], "o", color=figures.BAD, fillstyle="none")
        ax.set(title=name, xlabel="row", ylabel=f"residual [{unit}]")
    return fig
