"""The plots of the report, by process; a process adds its list here."""

from cutwise.app.plots import deburr, drill, machine, mill
from cutwise.app.plots.figures import Plot

PLOTS: dict[str, list[Plot]] = {
    "deburr": deburr.PLOTS,
    "drill": drill.PLOTS,
    "machine": machine.PLOTS,
    "mill": mill.PLOTS,
}
