"""The plots of the report, by process; a process adds its list here."""

from cutwise.app.plots import deburr
from cutwise.app.plots.figures import Plot

PLOTS: dict[str, list[Plot]] = {"deburr": deburr.PLOTS}
