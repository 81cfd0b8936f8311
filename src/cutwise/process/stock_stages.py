"""The arrays of a program in a stock in 3D, labelled."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.height_map import RINGS, cell_middles, in_rows
from cutwise.maths.map_surface import corner_heights
from cutwise.process.labels import Column, Coordinate, Group, Over, Read, table
from cutwise.process.stock_deviation import Deviation, Judged
from cutwise.process.stock_earlier import Sweep, kept
from cutwise.process.stock_milling import StockRunDone
from cutwise.process.stock_real import Cut
from cutwise.process.stock_setups import Done
from cutwise.process.stock_stations import move_time, station_along, station_moves, station_places, station_times
from cutwise.spec.base import known

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

IntArray = npt.NDArray[np.int64]


_AXES = "xyz"
OFFSET = Group({
    "along": Column("piece", lambda real: real.done.moves.along[:, 0], "m", "place on the planned path"),
    "line": Column("piece", lambda real: np.repeat(real.done.moves.line, np.diff(real.done.moves.path.first)), "1",
                   "line of the program"),
    "offset": Column("piece axis", lambda real: real.off[:, 0], "m", "tool less its planned place"),
    "offset_known": Column("piece axis", lambda real: real.known[:, 0], "m", "part of it by drives and the sag of an arm"),
}, {"piece": Coordinate(lambda real: np.arange(len(real.done.moves.way)), "1", "piece of the path"), "axis": _AXES})  # fmt: skip
"""Where the tool stands beside its planned path, at the start of each piece; of a :class:`Real`."""


def _stations(name: str, unit: str, text: str) -> Column:
    """What was noted at every station."""
    return Column("station", lambda done: done.stations(name), unit, text)


def _removal_rate(done: StockRunDone) -> FloatArray:
    return done.stations("removal") * done.moves.feed[station_moves(done)]


def _power(done: StockRunDone) -> FloatArray:
    return done.stations("torque") * done.moves.spindle[station_moves(done)]


STATIONS = Group({
    "time": Column("station", station_times, "s", "time"),
    "line": Column("station", lambda done: done.moves.line[station_moves(done)], "1", "line of the program"),
    "travelled": Column("station", station_along, "m", "place on the program's path"),
    "tip": Column("station axis", station_places, "m", "tip of the tool"),
    "immersion": _stations("angle", "rad", "largest sum of contact arcs at one height"),
    "removal": _stations("removal", "m**2", "volume taken per length of feed"),
    "removal_rate": Column("station", _removal_rate, "m**3/s", "volume taken per time"),
    "force": Column("station axis", lambda done: np.column_stack([done.stations(f"force_{axis}") for axis in _AXES]), "N",
                    "mean force on the tool along the feed, to its left, up"),
    "force_end": _stations("end_force", "N", "part of the bottom edges in the force up"),
    "force_xy_peak": _stations("force_xy_peak", "N", "largest force in the plane over a tooth period"),
    "torque": _stations("torque", "N*m", "mean torque of the cut"),
    "power": Column("station", _power, "W", "mean power of the cut"),
    "chip_thickness": _stations("chip_thickness", "m", "thickest chip"),
}, {
    "station": Coordinate(lambda done: np.arange(station_moves(done).size), "1", "place along the program"), "axis": _AXES,
})  # fmt: skip
"""What the tool meets place by place; of a :class:`StockRunDone`."""


class Lines(NamedTuple):
    """The moves of one set-up, and how what they left is off the part."""

    cut: Cut
    number: int  # of the set-up, from 0
    off: Judged | None

    @property
    def done(self) -> StockRunDone:
        """As planned."""
        return self.cut.ideal


def _moves(read: Read, unit: str, text: str) -> Column:
    return Column("move", lambda lines: read(lines.done), unit, text)


def _most(read: Callable[[StockRunDone], FloatArray], unit: str, text: str) -> Column:
    """Largest value of each move's stations; 0 without stations."""
    return _moves(lambda done: _largest(read(done), done.run.station), unit, text)


def _feed(done: StockRunDone) -> FloatArray:
    return np.where(done.moves.rapid, np.nan, done.moves.feed)


def _ends(end: int) -> Read:
    """Least and largest deviation of the surface that each move made."""
    return lambda lines: None if lines.off is None else _made(lines.cut, lines.number, lines.off.left)[end]


LINES = Group({
    "line": _moves(lambda done: done.moves.line, "1", "line of the program"),
    "last_line": _moves(lambda done: done.moves.last_line, "1", "last line of short moves that go together"),
    "tool": _moves(lambda done: np.array(done.planned.tools.numbers or (0,))[done.moves.tool], "1", "number of the tool"),
    "rapid": _moves(lambda done: done.moves.rapid.astype(np.int64), "1", "whether it is a rapid move"),
    "time": _moves(lambda done: move_time(done, np.arange(done.moves.number)), "s", "time at which it begins"),
    "feed": _moves(_feed, "m/s", "feed"),
    "removed_volume": _moves(lambda done: done.volume, "m**3", "volume taken"),
    "removed_volume_error": _moves(lambda done: done.error and done.error.of_moves, "m**3",
                                   "error of it, three standard deviations"),
    "immersion_max": _most(lambda done: done.stations("angle"), "rad", "largest contact angle"),
    "removal_rate_max": _most(_removal_rate, "m**3/s", "largest removal rate"),
    "chip_thickness_max": _most(lambda done: done.stations("chip_thickness"), "m", "thickest chip"),
    "force_xy_peak": _most(lambda done: done.stations("force_xy_peak"), "N", "largest force in the plane"),
    "torque_max": _most(lambda done: done.stations("torque"), "N*m", "largest mean torque"),
    "power_max": _most(_power, "W", "largest mean power"),
    "rapid_depth": _moves(lambda done: done.run.through[:, 1], "m", "how deep a rapid move runs into the stock"),
    "collision_depth": _moves(lambda done: np.maximum(done.run.hit[:, 1], done.fixed[:, 1]), "m",
                              "how deep shank, holder or fixture overlap"),
    "deviation_min": Column("move", _ends(0), "m", "least deviation of the surface that it made"),
    "deviation_max": Column("move", _ends(1), "m", "largest deviation of the surface that it made, positive: material left"),
}, {"move": Coordinate(lambda lines: np.arange(lines.done.moves.number), "1", "move")})  # fmt: skip
"""Moves with their lines: load, volume, events and the extremes of the deviation that they made; of :class:`Lines`."""


class Heights(NamedTuple):
    """The height map in rows along y, and the heights at the corners of its cells [m]."""

    x: FloatArray
    y: FloatArray
    x_corner: FloatArray
    y_corner: FloatArray
    top: npt.NDArray[np.float32]
    floor: npt.NDArray[np.float32]
    line: npt.NDArray[np.int32]
    above: npt.NDArray[np.float32]
    below: npt.NDArray[np.float32]


MAP = Group({
    "height": Column("y x", lambda map: map.top, "m", "height of what is left"),
    "bottom": Column("y x", lambda map: map.floor, "m", "underside"),
    "line": Column("y x", lambda map: map.line, "1", "line that cut it last, 0: the stock"),
    "height_corner": Column("y_corner x_corner", lambda map: map.above, "m", "height at the corners of cells"),
    "bottom_corner": Column("y_corner x_corner", lambda map: map.below, "m", "underside there"),
}, {
    "x": Coordinate(lambda map: map.x, "m", "x"), "y": Coordinate(lambda map: map.y, "m", "y"),
    "x_corner": Coordinate(lambda map: map.x_corner, "m", "x"), "y_corner": Coordinate(lambda map: map.y_corner, "m", "y"),
})  # fmt: skip
"""Of :class:`Heights`."""


class Samples(NamedTuple):
    """The points of the nominal part that are judged."""

    off: Deviation
    setup: IntArray  # that made the surface there, from 0; -1: the stock, or an earlier run
    line: IntArray  # that made it, 0: the stock

    @property
    def judged(self) -> npt.NDArray[np.bool_]:
        """Which of all points these are."""
        return self.off.judged_samples


_POINTS: Over = {
    "sample": Coordinate(lambda samples: np.arange(len(samples.line)), "1", "point of the nominal part"), "axis": _AXES,
}  # fmt: skip
SAMPLES = Group({
    "point": Column("sample axis", lambda samples: samples.off.samples.point[samples.judged].astype(np.float32), "m",
                    "point of the nominal part"),
    "deviation": Column("sample", lambda samples: samples.off.value[samples.judged].astype(np.float32), "m",
                        "deviation, positive: material left"),
    "line": Column("sample", lambda samples: samples.line.astype(np.int32), "1",
                   "line that made the surface there, 0: the stock"),
    "face": Column("sample", lambda samples: (samples.off.samples.face[samples.judged] + 1).astype(np.int32), "1",
                   "face of the part"),
    "setup": Column("sample", lambda samples: (
        (samples.setup + 1).astype(np.int32) if len(samples.off.owners.runs) > 1 else None
    ), "1", "set-up that made it, 0: the stock, or an earlier run"),
}, _POINTS, attrs=lambda samples: {"tolerance": samples.off.tolerance or 0.0})  # fmt: skip
"""Of :class:`Samples`."""


def _of_faces(name: str, unit: str, text: str) -> Column:
    return Column("face", lambda faces: np.array([getattr(face, name) for face in faces], float), unit, text)


FACES = Group({
    "area": _of_faces("area", "m**2", "judged area"),
    "least": _of_faces("least", "m", "least deviation"),
    "most": _of_faces("most", "m", "largest deviation"),
    "mean": _of_faces("mean", "m", "mean deviation"),
    "rms": _of_faces("rms", "m", "root mean square"),
    "gouge": _of_faces("gouge", "m**3", "volume cut into the part"),
    "excess": _of_faces("excess", "m**3", "volume of material left"),
    "scallop": _of_faces("scallop", "m", "largest scallop of ball or bull-nose"),
}, {"face": Coordinate(lambda faces: np.array([face.face + 1 for face in faces]), "1", "face of the part")})  # fmt: skip
"""Of the faces of a :class:`Deviation`."""


def stages(done: Done, off: Judged | None) -> xr.DataTree:
    """Stations, moves, the maps, faces and samples of the part; of the ideal surface beside the real one too.

    Stations and moves of several set-ups follow one another, the maps have groups of their own, each in its frame.
    """
    groups = {
        "motion": _joined([known(table(cut.ideal, STATIONS)) for cut in done.cuts], "station", done, timed=True),
        "lines": _joined([
            known(table(Lines(cut, number, off), LINES)) for number, cut in enumerate(done.cuts)
        ], "move", done, timed=True),
    }  # fmt: skip
    for number, (job, cut) in enumerate(zip(done.jobs, done.cuts, strict=True), start=1):
        ending = "" if number == 1 else f"_{number}"
        groups[f"stock{ending}"] = known(table(_map(cut.left), MAP))
        groups[f"stock{ending}"].attrs |= {"axes": job.frame.axes.ravel(), "zero": job.frame.zero}
        if cut.real is not None:
            groups[f"offset{ending}"] = known(table(cut.real, OFFSET))
    if off is not None:
        groups |= {"surface": _samples(off.left), "faces": known(table(off.left.faces, FACES))}
        if off.ideal is not None:
            groups["surface_ideal"] = _samples(off.ideal)
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


def _largest(values: FloatArray, first: IntArray) -> FloatArray:
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


def _map(done: StockRunDone) -> Heights:
    """The map, what cut it last, and the heights at the corners of its cells."""
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
    return Heights(
        x, y, np.asarray(xc), np.asarray(yc), np.where(gone, np.nan, height),
        np.where(gone, np.nan, floor).astype(np.float32), line.astype(np.int32),
        above.reshape(at_x.shape).astype(np.float32), below.reshape(at_x.shape).astype(np.float32),
    )  # fmt: skip


def _samples(off: Deviation) -> xr.Dataset:
    run, segment = off.owners.of(off.segment[off.judged_samples])
    line = np.zeros(segment.size, np.int64)
    for number, done in enumerate(off.owners.runs):
        mine = run == number
        line[mine] = done.planned.path.source[done.moves.block[segment[mine]]]
    return known(table(Samples(off, run, line), SAMPLES))
