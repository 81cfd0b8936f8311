"""The plots of the report, by process (the row of a process in ``spec.kinds`` names them), and figures for papers."""

from collections.abc import Mapping

from cutwise.app.plots.figures import Plot
from cutwise.app.plots.paper import history as history
from cutwise.spec.kinds import Registered

PLOTS: Mapping[str, list[Plot]] = Registered("plots")
