"""The plots of the report, by process (the row of a process in ``spec.kinds`` names them), and figures for papers.

``cdf``, ``scatter``, ``tornado`` and ``pareto`` are pictures of a study, and ``history`` one of a run.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from cutwise.app.plots.figures import Plot
from cutwise.app.plots.paper import history as history
from cutwise.spec.kinds import Registered

if TYPE_CHECKING:
    from cutwise.app.plots.study import cdf as cdf
    from cutwise.app.plots.study import pareto as pareto
    from cutwise.app.plots.study import scatter as scatter
    from cutwise.app.plots.study import tornado as tornado

PLOTS: Mapping[str, list[Plot]] = Registered("plots")
_OF_STUDIES = ("cdf", "pareto", "scatter", "tornado")


def __getattr__(name: str) -> Any:
    """Pictures of studies at their first use: a report of a run imports nothing of studies."""
    if name in _OF_STUDIES:
        from cutwise.app.plots import study

        return getattr(study, name)
    raise AttributeError(f"module 'cutwise.app.plots' has no attribute {name!r}")
