"""The numbers of a program in a stock in 3D."""

import math

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.physics.motion.lookahead import time_without_limits
from cutwise.process.stock_deviation import Deviation, Judged
from cutwise.process.stock_milling import StockRunDone
from cutwise.process.stock_real import Cut, Real
from cutwise.process.stock_setups import Done
from cutwise.process.stock_stations import events, station_along, station_headings, station_moves, station_times
from cutwise.spec.milling import MillingScenario

_SUMMED = (
    "cycle_time", "cycle_time_ideal", "path_length", "stops", "removed_volume", "removed_volume_error", "air_cut_time",
    "rapids_in_stock", "collisions",
)  # fmt: skip


def measures(done: Done, off: Judged | None) -> dict[str, float]:
    """All measures in SI; one that does not apply is left out. Loads are those of the planned path.

    Of several set-ups times, volumes and counts are summed, of others the largest is told.
    """
    found: dict[str, float] = {}
    for job, cut in zip(done.jobs, done.cuts, strict=True):
        for name, value in _of_setup(job.scenario, cut).items():
            both = found[name] + value if name in _SUMMED and name in found else max(found.get(name, value), value)
            found[name] = both
    if off is None:
        return found
    found |= _of_part(off.left)
    if off.ideal is not None:
        ideal = _of_part(off.ideal)
        found |= {f"{name}_ideal": ideal[name] for name in ("deviation_min", "deviation_max", "deviation_rms")}
    return found


def _of_setup(scenario: MillingScenario, cut: Cut) -> dict[str, float]:
    """Motion, load and events of one set-up."""
    done = cut.ideal
    found = _motion(done)
    volume = done.volume
    found["removed_volume"] = float(volume.sum())
    if done.error is not None:
        found["removed_volume_error"] = done.error.of_all
    if scenario.numerics.stock.engagement != "none":
        found |= _cutting(scenario, done)
    happened = events(done)
    hits = [event for event in happened if event.kind in ("shank", "fixture")]
    found["rapids_in_stock"] = float(sum(event.kind == "rapid" for event in happened))
    found["collisions"] = float(len(hits))
    if hits:
        found["collision_depth_max"] = max(event.depth for event in hits)
    checks = [one.check.largest for one in {id(run): run for run in (done, cut.left)}.values() if one.check is not None]
    if checks:
        found["surface_check_max"] = max(checks)
    if cut.real is not None and cut.real.terms != ("runout",):
        found |= _aside(cut.real)
    return found


def checked(done: StockRunDone) -> dict[str, str]:
    """What the checks of a map found, in words."""
    said = {}
    if done.check is not None:
        most = units.show(done.check.largest, "small_length", 3) + " above all moves together"
        said["surface check"] = f"at {done.check.points} points of the cut surface the map is at most {most}"
    if done.error is not None:
        volume, (shift, spread) = float(done.volume.sum()), done.error.whole
        said["volumes"] = (
            f"{units.show(volume, 'volume', 6)} by the cells, {units.show(done.error.of_all, 'volume', 2)} off at the most (three "
            f"standard deviations, {done.error.points} points); by these points {units.show(volume + shift, 'volume', 6)} and "
            f"{units.show(3.0 * spread, 'volume', 2)}"
        )
    by_contact = contact_volume(done)
    if by_contact is not None and by_contact[1] > 0.0:
        along, cells = by_contact
        said["balance of contact"] = (
            f"stations are in contact with {units.show(along, 'volume', 5)} along the feed moves, {along / cells:.4f} of what the "
            "cells say; forces are as far off, at a shallow place more: more numerics.stock.elements and a shorter "
            "numerics.stock.station bring both together"
        )
    return said


def contact_volume(done: StockRunDone) -> tuple[float, float] | None:
    """Volume of feed moves by contact, straight between stations, and by the cells [m^3]; None without stations."""
    station, move = done.run.station, station_moves(done)
    if not move.size:
        return None
    removal = done.stations("removal")
    length = np.add.reduceat(done.moves.way, done.moves.path.first[:-1])
    parts = np.maximum(np.diff(station) - 1, 1)
    beside = move[1:] == move[:-1]
    between = 0.5 * (removal[1:] + removal[:-1]) * (length / parts)[move[1:]]
    return float(between[beside].sum()), float(done.volume[np.diff(station) > 0].sum())


def _aside(real: Real) -> dict[str, float]:
    """How far the tool stands beside its path while it cuts [m]."""
    where = aside(real)
    found = {"tool_offset_max": float(where.max())} if where.size else {}  # without contact nothing is known of the cut
    if real.change is not None:
        found["tool_offset_change"] = real.change
    return found


def aside(real: Real) -> FloatArray:
    """Distance of the tool from its path at stations in contact, what its drives lag along it left out [m].

    A lag shifts the tool to where it is a moment later and changes nothing of the surface; what the tool bends along its feed does.
    """
    contact = real.done.stations("contact") > 0.0
    segment = real.done.run.segment[contact]
    off = real.off[segment, 0]
    along = station_headings(real.done)[contact]
    row = real.done.moves.path.row[segment]
    level = np.where(row[:, 7] > 1e-12, 1.0 / np.sqrt(1.0 + row[:, 8] ** 2), 0.0)
    ahead = np.column_stack([along * level[:, None], np.where(row[:, 7] > 1e-12, row[:, 8] * level, 1.0)])
    if real.driven is None:
        return np.asarray(np.linalg.norm(off, axis=1))
    lag = (real.driven.known.at(station_along(real.done)[contact]) * ahead).sum(axis=1)
    return np.asarray(np.linalg.norm(off - lag[:, None] * ahead, axis=1))


def _motion(done: StockRunDone) -> dict[str, float]:
    ready = done.planned
    found = {
        "cycle_time": float(ready.block_time[-1]),
        "path_length": float(ready.path.curve.knots[-1]),
    }
    if ready.plan is not None:
        found["cycle_time"] = ready.plan.profile.duration
        found["cycle_time_ideal"] = time_without_limits(ready.path.curve, ready.feed) + float(
            ready.path.dwell_after.sum()
        )
        found["stops"] = float(ready.plan.stops)
    return found


def plunging(done: StockRunDone) -> npt.NDArray[np.bool_]:
    """Whether each station goes straight down."""
    row = done.moves.path.row[done.run.segment]
    start, end = done.moves.start[done.run.segment], done.moves.end[done.run.segment]
    return np.asarray((row[:, 0] == 0.0) & (row[:, 7] <= 1e-12) & (end[:, 2] < start[:, 2]))


def _cutting(scenario: MillingScenario, done: StockRunDone) -> dict[str, float]:
    """Contact and forces at stations."""
    move = station_moves(done)
    feed = done.moves.feed[move]
    found: dict[str, float] = {"air_cut_time": _air_time(done)}
    if not move.size:
        return found
    found["engagement_angle_max"] = float(done.stations("angle").max())
    found["removal_rate_max"] = float((done.stations("removal") * feed).max())
    turning = done.moves.spindle[move]
    if scenario.material is None or not (turning > 0.0).any():
        return found
    torque = done.stations("torque")
    found["spindle_torque_max"] = float(torque.max())
    found["cutting_power_max"] = float((torque * turning).max())
    found["chip_thickness_max"] = float(done.stations("chip_thickness").max())
    if scenario.numerics.stock.engagement == "refined":
        found["force_xy_peak"] = float(done.stations("force_xy_peak").max())
    down = plunging(done) & (done.stations("contact") > 0.0)
    if down.any():
        found["plunge_force_max"] = float(done.stations("force_z")[down].max())
    return found


def _air_time(done: StockRunDone) -> float:
    """Time of feed moves without contact: of each stretch between two stations that have none [s]."""
    move, times = station_moves(done), station_times(done)
    air = done.stations("contact") == 0.0
    beside = (move[1:] == move[:-1]) & air[1:] & air[:-1]
    return float(np.diff(times)[beside].sum())


def _of_part(off: Deviation) -> dict[str, float]:
    value = off.value[off.judged_samples]
    found = {
        "deviation_min": float(value.min()) if value.size else 0.0,
        "deviation_max": float(value.max()) if value.size else 0.0,
        "deviation_rms": off.rms,
        "gouge_volume": sum(face.gouge for face in off.faces),
        "excess_volume": sum(face.excess for face in off.faces),
    }
    if off.tolerance is not None:
        found["fraction_in_tolerance"] = off.within
    scallops = [face.scallop for face in off.faces if math.isfinite(face.scallop)]
    return found | ({"scallop_max": max(scallops)} if scallops else {})
