"""Plots of a turned shaft: its diameter after each pass, and what yielded."""

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from cutwise.app.plots.figures import SERIES, Plot, curve, figure, legend_above, scale

if TYPE_CHECKING:
    from cutwise.results import Result

_SAID = {"work": "shaft", "steady": "steady rest", "tool": "tool holder"}


def _along(result: "Result", group: str, names: dict[str, str], axis: str, *, passes: bool = False) -> Figure:
    """Columns of the last pass over the distance from the headstock; of one column, every pass."""
    table, (far, far_unit), (small, unit) = result[group], scale("length"), scale("small_length")
    drawn = figure(3.0)
    axes = drawn.subplots()
    columns = [(said, table[name].values[:, -1]) for name, said in names.items()]
    if passes:
        columns = [(f"pass {k + 1}", column) for k, column in enumerate(table[next(iter(names))].values.T)][
            -len(SERIES) :
        ]
    for colour, (said, column) in zip(SERIES, columns, strict=False):
        curve(axes, far * table["z"].values, small * column, color=colour, label=said)
    axes.set(xlabel=f"distance from the headstock end [{far_unit}]", ylabel=f"{axis} [{unit}]")
    axes.margins(x=0)
    legend_above(axes, 7)
    return drawn


def diameter(result: "Result") -> Figure:
    """Diameter error along the shaft after each pass."""
    return _along(result, "surface", {"diameter_error": ""}, "diameter error", passes=True)


def yielding(result: "Result") -> Figure:
    """Displacement off the shaft in the last pass by each thing that yields."""
    names = {str(name): str(name).removeprefix("deflection_") for name in result["structure"].dataset.data_vars}
    return _along(result, "structure", {key: _SAID.get(name, name) for key, name in names.items()}, "off the shaft")


PLOTS = [
    Plot("Diameter", "Error after each pass; positive: too thick.", diameter, ("surface/diameter_error",)),
    Plot("What yields", "In the last pass; the parts add up, and the diameter is off by twice their sum.", yielding,
         ("structure/deflection_work",)),
]  # fmt: skip
