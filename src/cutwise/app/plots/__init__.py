"""The plots of the report, by process; a process adds its list here."""

from cutwise.app.plots import arm, chamfer, deburr, drill, machine, mill, stock
from cutwise.app.plots.figures import Plot

PLOTS: dict[str, list[Plot]] = {
    "chamfer": chamfer.PLOTS,
    "deburr": deburr.PLOTS,
    "drill": drill.PLOTS,
    "machine": machine.PLOTS,
    "mill": [*arm.PLOTS, *mill.PLOTS, *stock.PLOTS],
}
