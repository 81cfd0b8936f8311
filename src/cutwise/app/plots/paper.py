"""A history as a figure for a paper: one or two columns wide, 8 pt, in a unit that people read, with its limits."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

from cutwise import units
from cutwise.app.numbers import form, printed
from cutwise.app.plots.figures import SERIES, SOFT, curve
from cutwise.spec.faults import NoSuchName
from cutwise.tabular import components, main_dimension, without_single

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

    from cutwise.results import Result

_WIDTHS = (85.0, 170.0)  # [mm] one column of a journal, or two
_MM = 1.0 / 25.4  # [in]
_HEIGHT = 0.62  # of the width, at most that of one column
_MOST_CURVES = 12
_ENDS = ("", "_max", "_min", "_peak")  # a measure of a history that is a value of it
LOOK: dict["RcKeyType", Any] = {
    "font.size": 8.0, "axes.labelsize": 8.0, "xtick.labelsize": 8.0, "ytick.labelsize": 8.0, "legend.fontsize": 8.0,
    "axes.linewidth": 0.6, "lines.linewidth": 1.0, "axes.spines.top": False, "axes.spines.right": False,
    "legend.frameon": False, "axes.prop_cycle": cycler(color=SERIES), "svg.fonttype": "none", "pdf.fonttype": 42,
    "path.simplify": False,
}  # fmt: skip


def history(
    result: "Result", name: str | None = None, unit: str | None = None, ax: Axes | None = None, *, width: float = 85.0
) -> Figure:
    """Draw an array of a result over time, over its path, or as a map; nothing is shown or written.

    Parameters
    ----------
    result : Result
        A finished run.
    name : str, optional
        ``"stage/column"``, or the column alone where one stage has it; left out: what the process is about.
    unit : str, optional
        Unit of the values; left out: the one that people read numbers of this size in.
    ax : matplotlib.axes.Axes, optional
        Axes to draw into; left out: those of a new figure.
    width : float
        Width of a new figure [mm], 85 or 170.

    Returns
    -------
    matplotlib.figure.Figure
        The figure, to be saved as a vector drawing: ``figure.savefig("force.pdf")``.

    Raises
    ------
    NoSuchName
        No stage or column of that name.
    cutwise.units.UnitFault
        The unit is not one of this quantity.
    TypeError
        ``ax`` is nothing to draw into.
    ValueError
        Another width, no value at all, or more dimensions than a drawing has.
    """
    if width not in _WIDTHS:
        raise ValueError(f"width is {width:g} mm; a figure is 85 mm (one column) or 170 mm (two columns) wide")
    if ax is not None and not isinstance(ax, Axes):
        raise TypeError(f"ax is a {type(ax).__name__}; expected axes of matplotlib, as Figure().subplots() gives them")
    stage, column = _named(result, name)
    array = _drawable(result[stage].to_dataset()[column])
    scale, shown = _unit(array, unit)
    with mpl.rc_context(LOOK):
        axes = ax
        if axes is None:
            size = (width * _MM, _HEIGHT * _WIDTHS[0] * _MM)
            axes = Figure(figsize=size, layout="constrained").subplots()
        _draw(axes, array, scale, _labelled(column, shown))
        if array.ndim == 1 or min(array.shape) <= _MOST_CURVES:
            _limits(axes, result, stage, column, array, scale)
    found = axes.get_figure(root=True)
    assert found is not None
    return found


def _drawable(array: xr.DataArray) -> xr.DataArray:
    """The array without dimensions of one entry; what no drawing has is refused."""
    whole = array.to_dataset(name=array.name)
    array = without_single(whole, main_dimension(whole))[array.name]
    if not 1 <= array.ndim <= 2:
        raise ValueError(f"{array.name} has {array.ndim} dimensions ({', '.join(map(str, array.dims))}); a drawing has one "
                         "or two: select a part of it and draw that with xarray")  # fmt: skip
    if not np.isfinite(array.values.astype(float)).any():
        raise ValueError(f"{array.name} has no value in this run")
    return array


def default(result: "Result") -> str | None:
    """The history that says most: an error of the surface, then a force, then what there is; None without any."""
    arrays = [
        (str(stage), str(name), array)
        for stage, node in result.stages.children.items()
        for name, array in node.dataset.data_vars.items()
        if array.ndim and array.size > 1 and np.issubdtype(array.dtype, np.number)
    ]
    focus = result.scenario.focus
    flat = [
        (f"{stage}/{name}", stage, name, wide) for stage, name, array in arrays
        if (wide := sum(size > 1 for size in array.shape)) <= 2 and np.isfinite(array.values).any()
    ]  # fmt: skip
    ranked = [
        [path for path, stage, name, _ in flat if focus.startswith((f"{stage}_{name}", name))],
        [path for path, stage, name, _ in flat if stage == "surface" and "error" in name],
        [path for path, _, name, _ in flat if "error" in name],
        [path for path, _, name, _ in flat if "force" in name],
        [path for path, _, _, dimensions in flat if dimensions == 1],
    ]
    return next((paths[0] for paths in ranked if paths), None)


def _named(result: "Result", name: str | None) -> tuple[str, str]:
    """Stage and column that a name means."""
    given = default(result) if name is None else str(name)
    if given is None:
        raise NoSuchName("history", "", (), "result.stages")
    stage, slash, column = given.partition("/")
    if not slash:
        stages = [str(s) for s, node in result.stages.children.items() if given in node.dataset.data_vars]
        if len(stages) != 1:
            known = [f"{s}/{c}" for s, node in result.stages.children.items() for c in node.dataset.data_vars]
            near = [one for one in known if one.endswith(f"/{given}")]
            near = near or [one for one in known if given and given.lower() in one.lower()] or known
            raise NoSuchName("single column", given, near, "result.stages")
        return stages[0], given
    if column not in result[stage].to_dataset().data_vars:
        raise NoSuchName("column", column, map(str, result[stage].dataset.data_vars), f'result["{stage}"]')
    return stage, column


def _unit(array: xr.DataArray, unit: str | None) -> tuple[float, str]:
    """Size in SI and print of the unit of an array."""
    si = str(array.attrs.get("units", ""))
    dimension = next((d.name for d in units.DIMENSIONS.values() if d.si == si), None)
    if dimension is None or (not si and unit is None):
        if unit is not None and unit != si:
            raise units.UnitFault(f'"{unit}" is not a unit of {array.name}, which is in {si or "no unit"}')
        return 1.0, units.pretty(si)
    if unit is not None:
        return units.factor(unit, dimension), printed(unit)
    shape = form(dimension, [float(value) for value in (array.max(), array.min())])
    return shape.scale, shape.unit


def _labelled(name: str, unit: str) -> str:
    return f"{name.replace('_', ' ')} [{unit}]" if unit else name.replace("_", " ")


def _draw(axes: Axes, array: xr.DataArray, scale: float, label: str) -> None:
    main = main_dimension(array.to_dataset(name="drawn"))
    others = [str(dim) for dim in array.dims if dim != main]
    if others and array.sizes[others[0]] > _MOST_CURVES:
        _map(axes, array, scale, label)
        return
    x, x_label = _abscissa(array, main)
    parts = components(str(array.name), array, main)
    for column, part in parts:
        curve(axes, x, part.values / scale, label=column.removeprefix(f"{array.name}_"))
    axes.set(xlabel=x_label, ylabel=label)
    axes.margins(x=0)
    if len(parts) > 1:
        axes.legend(loc="best", handlelength=1.2)


def _abscissa(array: xr.DataArray, dim: str) -> tuple[np.ndarray, str]:
    if dim not in array.coords or not np.issubdtype(array[dim].dtype, np.number):
        return np.arange(array.sizes[dim]), dim.replace("_", " ")
    scale, unit = _unit(array[dim], None)
    return array[dim].values / scale, _labelled(dim, unit)


def _map(axes: Axes, array: xr.DataArray, scale: float, label: str) -> None:
    down, across = (str(dim) for dim in array.dims)
    (x, x_label), (y, y_label) = _abscissa(array, across), _abscissa(array, down)
    drawn = axes.pcolormesh(x, y, array.values / scale, shading="nearest", cmap="cividis", rasterized=True)
    axes.set(xlabel=x_label, ylabel=y_label)
    figure = axes.get_figure()
    assert figure is not None
    figure.colorbar(drawn, ax=axes, label=label)


def _limits(axes: Axes, result: "Result", stage: str, column: str, array: xr.DataArray, scale: float) -> None:
    """Limits of the measures that are values of this history."""
    for limit in sorted(set(_ends(result, stage, column, str(array.attrs.get("units", ""))))):
        axes.axhline(limit / scale, color=SOFT, linewidth=0.8, linestyle="--")


def _ends(result: "Result", stage: str, column: str, si: str) -> Iterator[float]:
    for name in (column, f"{stage}_{column}"):
        for end in _ENDS:
            limit = result.scenario.asked.get(f"{name}{end}")
            known = result.scenario.measures.get(f"{name}{end}")
            if limit is not None and known is not None and units.DIMENSIONS[known.dimension].si == si:
                yield from (bound for bound in (limit.min, limit.max) if bound is not None)
