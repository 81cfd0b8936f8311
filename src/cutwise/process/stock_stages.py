"""The arrays of a program in a stock in 3D, labelled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.height_map import RINGS, cell_middles, in_rows
from cutwise.maths.map_surface import corner_heights
from cutwise.process.labels import labelled
from cutwise.process.stock_deviation import Deviation, Judged
from cutwise.process.stock_earlier import Sweep, kept
from cutwise.process.stock_milling import StockRunDone
from cutwise.process.stock_real import Cut, Real
from cutwise.process.stock_setups import Done
from cutwise.process.stock_stations import move_time, station_along, station_moves, station_places, station_times

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

IntArray = npt.NDArray[np.int64]


def stages(done: Done, off: Judged | None) -> xr.DataTree:
    """Stations, moves, the maps, faces and samples of the part; of the ideal surface beside the real one too.

    Stations and moves of several set-ups follow one another, the maps have groups of their own, each in its frame.
    """
    groups = {
        "motion": _joined([_stations(cut.ideal) for cut in done.cuts], "station", done, timed=True),
        "lines": _joined([_lines(done, number, off) for number in range(len(done.cuts))], "move", done, timed=True),
    }
    for number, (job, cut) in enumerate(zip(done.jobs, done.cuts, strict=True), start=1):
        ending = "" if number == 1 else f"_{number}"
        groups[f"stock{ending}"] = _map(cut.left)
        groups[f"stock{ending}"].attrs |= {"axes": job.frame.axes.ravel(), "zero": job.frame.zero}
        if cut.real is not None:
            groups[f"offset{ending}"] = _offset(cut.real)
    if off is not None:
        groups |= {"surface": _samples(off.left), "faces": _faces(off.left)}
        groups["surface"].attrs["tolerance"] = off.left.tolerance or 0.0
        if off.ideal is not None:
            groups["surface_ideal"] = _samples(off.ideal)
            groups["surface_ideal"].attrs["tolerance"] = off.ideal.tolerance or 0.0
    sweeps = [
        Sweep(job.frame, run.moves.path, run.planned.tools.cutting, run.moves.line)
        for job, run in zip(done.jobs, done.left(False), strict=True)
    ]
    groups |= kept(done.raw, (*(done.earlier.sweeps if done.earlier is not None else ()), *sweeps))
    return xr.DataTree.from_dict(groups)


def _joined(parts: list[xr.Dataset], over: str, done: Done, *, timed: bool) -> xr.Dataset:
    """Tables of set-ups one behind the other, with the number of the set-up where there are several."""
    if len(parts) == 1:
        return parts[0]
    begins = 0.0
    for number, (part, cut) in enumerate(zip(parts, done.cuts, strict=True), start=1):
        part["setup"] = (over, np.full(part.sizes[over], number), {"units": "1", "long_name": "set-up"})
        if timed:
            part["time"] = part["time"] + begins
            part["time"].attrs |= {"units": "s", "long_name": "time, set-ups one behind the other"}
        begins += float(cut.ideal.planned.block_time[-1])
    whole = xr.concat(parts, over)
    whole[over] = np.arange(whole.sizes[over])
    return whole


def _offset(real: Real) -> xr.Dataset:
    """Where the tool stands beside its planned path, at the start of each piece."""
    moves = real.done.moves
    row = ("piece", np.arange(len(moves.way)), "1", "piece of the path")
    line = np.repeat(moves.line, np.diff(moves.path.first))
    return labelled(row, {
        "along": (moves.along[:, 0], "m", "place on the planned path"),
        "line": (line, "1", "line of the program"),
        "offset": (real.off[:, 0], "m", "tool less its planned place"),
        "offset_known": (real.known[:, 0], "m", "part of it by drives and the sag of an arm"),
    }, axis=["x", "y", "z"])  # fmt: skip


def _stations(done: StockRunDone) -> xr.Dataset:
    move = station_moves(done)
    row = ("station", np.arange(move.size), "1", "place along the program")
    force = np.column_stack([done.stations(f"force_{axis}") for axis in "xyz"])
    power = done.stations("torque") * done.moves.spindle[move]
    return labelled(row, {
        "time": (station_times(done), "s", "time"),
        "line": (done.moves.line[move], "1", "line of the program"),
        "travelled": (station_along(done), "m", "place on the program's path"),
        "tip": (station_places(done), "m", "tip of the tool"),
        "immersion": (done.stations("angle"), "rad", "largest sum of contact arcs at one height"),
        "removal": (done.stations("removal"), "m**2", "volume taken per length of feed"),
        "removal_rate": (done.stations("removal") * done.moves.feed[move], "m**3/s", "volume taken per time"),
        "force": (force, "N", "mean force on the tool along the feed, to its left, up"),
        "force_end": (done.stations("end_force"), "N", "part of the bottom edges in the force up"),
        "force_xy_peak": (done.stations("force_xy_peak"), "N", "largest force in the plane over a tooth period"),
        "torque": (done.stations("torque"), "N*m", "mean torque of the cut"),
        "power": (power, "W", "mean power of the cut"),
        "chip_thickness": (done.stations("chip_thickness"), "m", "thickest chip"),
    }, axis=["x", "y", "z"])  # fmt: skip


def _lines(all_: Done, number: int, off: Judged | None) -> xr.Dataset:
    """Moves with their lines: load, volume, events and the extremes of the deviation that they made."""
    done = all_.cuts[number].ideal
    moves, count = done.moves, done.moves.number
    station = done.run.station
    numbers = np.array(done.planned.tools.numbers or (0,))
    found: dict[str, Any] = {
        "line": (moves.line, "1", "line of the program"),
        "last_line": (moves.last_line, "1", "last line of short moves that go together"),
        "tool": (numbers[moves.tool], "1", "number of the tool"),
        "rapid": (moves.rapid.astype(np.int64), "1", "whether it is a rapid move"),
        "time": (move_time(done, np.arange(count)), "s", "time at which it begins"),
        "feed": (np.where(moves.rapid, np.nan, moves.feed), "m/s", "feed"),
        "removed_volume": (done.volume, "m**3", "volume taken"),
    }
    if done.error is not None:
        found["removed_volume_error"] = (done.error.of_moves, "m**3", "error of it, three standard deviations")
    turning = np.repeat(moves.spindle, np.diff(station))
    for name, values, unit, text in (
        ("immersion_max", done.stations("angle"), "rad", "largest contact angle"),
        (
            "removal_rate_max",
            done.stations("removal") * np.repeat(moves.feed, np.diff(station)),
            "m**3/s",
            "largest removal rate",
        ),
        ("chip_thickness_max", done.stations("chip_thickness"), "m", "thickest chip"),
        ("force_xy_peak", done.stations("force_xy_peak"), "N", "largest force in the plane"),
        ("torque_max", done.stations("torque"), "N*m", "largest mean torque"),
        ("power_max", done.stations("torque") * turning, "W", "largest mean power"),
    ):
        found[name] = (_largest(values, station), unit, text)
    found["rapid_depth"] = (done.run.through[:, 1], "m", "how deep a rapid move runs into the stock")
    found["collision_depth"] = (
        np.maximum(done.run.hit[:, 1], done.fixed[:, 1]),
        "m",
        "how deep shank, holder or fixture overlap",
    )
    if off is not None:
        low, high = _made(all_.cuts[number], number, off.left)
        found["deviation_min"] = (low, "m", "least deviation of the surface that it made")
        found["deviation_max"] = (high, "m", "largest deviation of the surface that it made, positive: material left")
    return labelled(("move", np.arange(count), "1", "move"), found)


def _largest(values: FloatArray, first: IntArray) -> FloatArray:
    """Largest value of each move's stations; 0 without stations."""
    out = np.zeros(len(first) - 1)
    there = np.flatnonzero(np.diff(first) > 0)
    if there.size:
        out[there] = np.maximum.reduceat(values, first[:-1][there])
    return out


def _made(cut: Cut, number: int, off: Deviation) -> tuple[FloatArray, FloatArray]:
    moves = cut.ideal.moves
    low, high = np.full(moves.number, np.nan), np.full(moves.number, np.nan)
    run, segment = off.owners.of(off.segment)
    made = off.judged_samples & (run == number)
    middle = cut.left.moves.along.mean(axis=1)[segment[made]]  # pieces of a moved tool have moves of their own
    move = np.searchsorted(moves.along[moves.path.first[:-1], 0], middle, side="right") - 1
    np.fmin.at(low, move, off.value[made])
    np.fmax.at(high, move, off.value[made])
    return low, high


def _map(done: StockRunDone) -> xr.Dataset:
    """The height map, what cut it last, and the heights at the corners of its cells."""
    grid = done.solid.map.layout
    x, y = (c[RINGS : RINGS + n] for c, n in zip(cell_middles(grid), (grid.across, grid.along), strict=True))
    xc, yc = grid.x + grid.dx * np.arange(grid.across + 1), grid.y + grid.dy * np.arange(grid.along + 1)
    height = in_rows(grid, done.solid.map.height).astype(np.float32)
    share, bottom = in_rows(grid, done.solid.map.share), done.solid.map.bottom
    floor = in_rows(grid, bottom) if bottom.size > 1 else np.full(height.shape, bottom[0])
    gone = (share <= 0.0) | (height <= floor)
    cutter = in_rows(grid, done.solid.map.cutter)
    line = np.where(cutter >= 0, done.moves.line[np.maximum(cutter, 0)], 0)
    at_x, at_y = np.meshgrid(xc, yc)
    above, below = np.empty(at_x.size), np.empty(at_x.size)
    corner_heights(done.solid, at_x.ravel(), at_y.ravel(), above, below)
    cells, corners = ("y", "x"), ("y_corner", "x_corner")
    return xr.Dataset(
        {
            "height": (cells, np.where(gone, np.nan, height), _unit("m", "height of what is left")),
            "bottom": (cells, np.where(gone, np.nan, floor).astype(np.float32), _unit("m", "underside")),
            "line": (cells, line.astype(np.int32), _unit("1", "line that cut it last, 0: the stock")),
            "height_corner": (corners, above.reshape(at_x.shape).astype(np.float32), _unit("m", "height at the corners of cells")),
            "bottom_corner": (corners, below.reshape(at_x.shape).astype(np.float32), _unit("m", "underside there")),
        },
        {
            "x": ("x", x, _unit("m", "x")), "y": ("y", y, _unit("m", "y")),
            "x_corner": ("x_corner", xc, _unit("m", "x")), "y_corner": ("y_corner", yc, _unit("m", "y")),
        },
    )  # fmt: skip


def _unit(unit: str, name: str) -> dict[str, str]:
    return {"units": unit, "long_name": name}


def _samples(off: Deviation) -> xr.Dataset:
    judged = off.judged_samples
    run, segment = off.owners.of(off.segment[judged])
    line = np.zeros(segment.size, np.int64)
    for number, done in enumerate(off.owners.runs):
        mine = run == number
        line[mine] = done.planned.path.source[done.moves.block[segment[mine]]]
    row = ("sample", np.arange(int(judged.sum())), "1", "point of the nominal part")
    return labelled(row, {
        "point": (off.samples.point[judged].astype(np.float32), "m", "point of the nominal part"),
        "deviation": (off.value[judged].astype(np.float32), "m", "deviation, positive: material left"),
        "line": (line.astype(np.int32), "1", "line that made the surface there, 0: the stock"),
        "face": ((off.samples.face[judged] + 1).astype(np.int32), "1", "face of the part"),
    } | ({"setup": ((run + 1).astype(np.int32), "1", "set-up that made it, 0: the stock, or an earlier run")}
         if len(off.owners.runs) > 1 else {}), axis=["x", "y", "z"])  # fmt: skip


def _faces(off: Deviation) -> xr.Dataset:
    table = off.faces
    row = ("face", np.array([face.face + 1 for face in table]), "1", "face of the part")
    columns = {
        "area": ("m**2", "judged area"), "least": ("m", "least deviation"), "most": ("m", "largest deviation"),
        "mean": ("m", "mean deviation"), "rms": ("m", "root mean square"), "gouge": ("m**3", "volume cut into the part"),
        "excess": ("m**3", "volume of material left"), "scallop": ("m", "largest scallop of ball or bull-nose"),
    }  # fmt: skip
    return labelled(row, {
        name: (np.array([getattr(face, name) for face in table], float), unit, text) for name, (unit, text) in columns.items()
    })  # fmt: skip
