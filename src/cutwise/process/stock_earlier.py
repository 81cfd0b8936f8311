"""What an earlier run has left of its stock: its sweeps are kept in its run file, and swept anew on the grid that is wanted."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.later import later
from cutwise.maths.envelopes import COLUMNS, Segments
from cutwise.maths.map_sweep import swept_band
from cutwise.maths.profiles import Cutters
from cutwise.maths.solid import Solid
from cutwise.maths.workpiece import Frame
from cutwise.process.stock_material import Raw, box_of, material_of, raw_seen
from cutwise.process.stock_milling import Earlier
from cutwise.run_file import DamagedRun, is_netcdf, tree_of
from cutwise.spec.faults import Fault, ScenarioFault

IntArray = npt.NDArray[np.int64]

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

_KEY = ("stock", "run")


class Sweep(NamedTuple):
    """All moves of a set-up."""

    frame: Frame
    path: Segments
    tools: Cutters
    line: IntArray  # of the program, of each move


class EarlierRun(NamedTuple):
    """What is known of an earlier run."""

    name: str
    raw: Raw  # in the coordinates of the part
    sweeps: tuple[Sweep, ...]

    def swept(self, grid: float) -> tuple[Earlier, ...]:
        """Its set-ups on a grid [m]."""
        return tuple(_swept(self.raw, sweep, grid) for sweep in self.sweeps)


def _swept(raw: Raw, sweep: Sweep, grid: float) -> Earlier:
    left = material_of(raw_seen(raw, sweep.frame), grid)
    taken = np.zeros(sweep.path.first.size - 1, np.int64)
    swept_band(left.map, sweep.path, sweep.tools, (0, left.map.layout.rows), taken)
    return Earlier(Solid(left.map, left.outline, sweep.path, sweep.tools), sweep.frame)


def earlier_run(file: str) -> EarlierRun:
    """Read the sweeps of a run file, or of the folder that holds run.nc.

    Raises
    ------
    ScenarioFault
        The file is no run, or not one of a stock in 3D.
    """
    place = Path(file)
    place = place / "run.nc" if place.is_dir() else place
    try:
        content = place.read_bytes()
    except OSError as fault:
        raise ScenarioFault([Fault(_KEY, f"{place}: {fault.strerror or fault}")]) from None
    if not is_netcdf(content):
        raise ScenarioFault([Fault(_KEY, f"{place}: is no run file (run.nc, which cutwise run writes)")])
    try:
        tree = tree_of(content)
    except DamagedRun as fault:
        raise ScenarioFault([Fault(_KEY, f"{place}: {fault}")]) from None
    if "sweep_1" not in tree.children:
        raise ScenarioFault(
            [Fault(_KEY, f"{place}: holds no stock in 3D: that takes a run of a program with tools or a part")]
        )
    raw, count = tree.children["raw"].to_dataset(), 1
    sweeps = []
    while f"sweep_{count}" in tree.children:
        sweeps.append(_read(tree[f"sweep_{count}"]))
        count += 1
    x, y, r = (float(v) for v in raw["circle"].values)
    triangles = np.ascontiguousarray(raw["triangles"].values, float) if "triangles" in raw else None
    return EarlierRun(
        str(place), Raw(box_of(raw["box"].values), int(raw.attrs["kind"]), (x, y, r), triangles), tuple(sweeps)
    )


def _read(group: Any) -> Sweep:
    def column(name: str, kind: type) -> Any:
        return np.ascontiguousarray(group[name].values, dtype=kind)

    return Sweep(
        Frame(column("axes", float), column("zero", float)),
        Segments(column("row", float).reshape(-1, COLUMNS), column("first", np.int64)),
        Cutters(column("piece", float), column("first_piece", np.int64), column("radius", float)),
        column("line", np.int64),
    )


def kept(raw: Raw, sweeps: tuple[Sweep, ...]) -> "dict[str, xr.Dataset]":
    """Groups of a run file from which a later run goes on."""
    whole: dict[str, Any] = {"box": (("axis", "end"), np.array(raw.box)), "circle": ("part", np.array(raw.circle))}
    if raw.triangles is not None:
        whole["triangles"] = (("triangle", "corner", "axis"), raw.triangles.reshape(-1, 3, 3))
    groups = {"raw": xr.Dataset(whole, attrs={"kind": raw.kind})}
    for number, (frame, path, tools, line) in enumerate(sweeps, start=1):
        groups[f"sweep_{number}"] = xr.Dataset({
            "axes": (("axis", "column"), frame.axes), "zero": ("axis", frame.zero),
            "row": (("segment", "value"), path.row), "first": ("move_end", path.first), "line": ("move", line),
            "piece": (("piece", "shape"), tools.piece), "first_piece": ("tool_end", tools.first),
            "radius": ("tool", tools.radius),
        })  # fmt: skip
    return groups
