"""Corner strategies side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.later import later
from cutwise.process.milling import run
from cutwise.process.milling_measures import measures
from cutwise.spec.milling import CornerPath, MillingScenario
from cutwise.spec.program import Blend

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

COMPARED = (
    "cycle_time", "contour_error_max", "drive_error_max", "contour_error_rms", "force_xy_peak", "force_xy_mean_corner",
    "engagement_angle_max", "feed_min", "drive_voltage_max", "settling_overshoot",
)  # fmt: skip


def compare(scenario: MillingScenario) -> dict[str, Mapping[str, float]]:
    """Measures of each corner strategy that the scenario asks to compare, by its name.

    Where blends are among them, what the drives alone are off by is told of all: the contour error of a fillet is measured
    from the fillet, that of a blend from the corner that it rounds.
    """
    if not isinstance(scenario.path, CornerPath):
        return {}
    rows: dict[str, Mapping[str, float]] = {}
    for strategy in scenario.path.compare:
        blend = strategy if isinstance(strategy, Blend) else None
        path = {"corner": "sharp" if blend else strategy, "compare": ()}
        other = scenario.model_copy(update={
            "path": scenario.path.model_copy(update=path), "path_mode": blend or "exact_path",
        })  # fmt: skip
        rows[_named(strategy)] = measures(other, run(other, scenario.numerics.substeps))
    if any("drive_error_max" in row for row in rows.values()):
        return {name: {"drive_error_max": row["contour_error_max"], **row} for name, row in rows.items()}
    return rows


def _named(strategy: str | float | Blend) -> str:
    if isinstance(strategy, Blend):
        return f"blend {units.show(strategy.blend, 'length', 3)}, {strategy.shape}"
    return "sharp, exact stop" if isinstance(strategy, str) else f"fillet {units.show(strategy, 'length', 3)}"


def comparison_table(
    rows: Mapping[str, Mapping[str, float]], known: Mapping[str, tuple[str, str]]
) -> xr.Dataset | None:
    """The compared measures over the strategies."""
    if not rows:
        return None
    names = [name for name in COMPARED if all(name in row for row in rows.values())]
    data = {
        name: (("strategy",), [row[name] for row in rows.values()],
               {"units": units.DIMENSIONS[known[name][0]].si or "1", "long_name": known[name][1]})
        for name in names
    }  # fmt: skip
    return xr.Dataset(data, coords={"strategy": list(rows)})
