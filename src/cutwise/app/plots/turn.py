"""Plots of a turned shaft: its diameter after each pass, and what yielded in the last one."""

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from cutwise.app.plots.figures import SERIES, Plot, curve, figure, legend_above, scale
from cutwise.results import Result


def _along(z: np.ndarray, columns: Iterable[tuple[str, np.ndarray]], axis: str) -> Figure:
    """Small lengths over the distance from the headstock end."""
    (far, far_unit), (small, unit) = scale("length"), scale("small_length")
    drawn = figure(3.0)
    axes = drawn.subplots()
    for colour, (said, column) in zip(SERIES, columns, strict=False):
        curve(axes, far * z, small * column, color=colour, label=said)
    axes.set(xlabel=f"distance from the headstock end [{far_unit}]", ylabel=f"{axis} [{unit}]")
    axes.margins(x=0)
    legend_above(axes, len(SERIES))
    return drawn


def diameter(result: Result) -> Figure:
    """Diameter error along the shaft after each of the last passes."""
    error = result["surface"]["diameter_error"]
    last = error["cut"].values[-len(SERIES) :]
    return _along(error["z"].values, [(f"pass {cut}", error.sel(cut=cut).values) for cut in last], "diameter error")


def yielding(result: Result) -> Figure:
    """Displacement off the shaft in the last pass by each thing that yields."""
    table = result["structure"].dataset
    columns = [(str(name).partition("_")[2], table[name].values[:, -1]) for name in table.data_vars]
    return _along(table["z"].values, columns, "off the shaft")


PLOTS = [
    Plot("Diameter", "Error after each pass; positive: too thick.", diameter, ("surface/diameter_error",)),
    Plot("What yields", "In the last pass, off the shaft; the diameter is off by twice the sum.", yielding,
         ("structure/deflection_work",)),
]  # fmt: skip
