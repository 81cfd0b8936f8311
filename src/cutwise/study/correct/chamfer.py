"""``change: offset`` of a chamfer: the path is led as much deeper as the structure gives way, place by place."""

from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.revision import revisions
from cutwise.io.scenario import read_document
from cutwise.maths.curves import FloatArray
from cutwise.process import chamfer
from cutwise.process.chamfer_led import way_along
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.band import simulate
from cutwise.study.correct.outcome import Change, Proposal, Task
from cutwise.study.correct.uncertain import draws_of, share_80

_NOTHING = 1e-7  # [m] of width that is not worth a correction
_GAINS = 0.02  # share by which a repetition has to lessen the error
_PROBE = 0.02  # of the width, by which the path is led deeper to see what that makes of it
_SLACK = 0.3  # width for depth, below which a structure gives way instead: a spindle at its constant force
_LEAST = 0.3  # of the mean gain, that a place is taken to have
_MM = 1e3


class Left(NamedTuple):
    """A chamfer that was run."""

    way: FloatArray  # along the edge, where the chamfer is measured [m], rising, shape (n,)
    whole: float  # length of the edge [m]
    closed: bool
    error: FloatArray  # of its width [m], positive: too wide, shape (n,)

    @property
    def worst(self) -> float:
        """Largest error [m]."""
        return float(np.abs(self.error).max())


def corrected(task: Task) -> Proposal:
    """A path whose depth over the way makes up for what takes the ball off it, run again.

    Raises
    ------
    ScenarioFault
        Nothing yields, more than one path, or a spindle whose constant force no offset changes.
    """
    given, said = task.scenario, task.said
    assert isinstance(given, ChamferScenario)
    before = left(given)
    if before.worst < _NOTHING:
        raise ScenarioFault(
            [
                Fault(
                    ("correct", "change"),
                    f"offset: the width is off by {units.show(before.worst, 'small_length', 3)} only",
                )
            ]
        )
    depth = _depth(given, before)
    probe = _PROBE * given.chamfer.width
    gain = (left(_with(given, before, depth + probe)).error - before.error) / probe
    mean = float(gain.mean())
    if mean < _SLACK:
        why = (
            f"offset: a path that is led deeper makes the chamfer only {mean:.2g} times as much wider: the spindle gives way at "
            "its constant force; change feed or spindle.pressure instead (cutwise advise)"
        )
        raise ScenarioFault([Fault(("correct", "change"), why)])
    gain = np.maximum(gain, _LEAST * mean)
    best, found, first = given, before, depth
    for _ in range(said.iterations):
        tried = first + np.clip(depth - found.error / gain - first, -said.shift_max, said.shift_max)
        scenario = _with(given, before, tried)
        here = left(scenario)
        better = here.worst < (1.0 - _GAINS) * found.worst
        if here.worst < found.worst:
            best, found, depth = scenario, here, tried
        if not better:
            break
    judging = draws_of(given, said, 0)[1]
    rest = [left(one).worst for draw in judging if isinstance(one := revisions(best)(draw), ChamferScenario)]
    most = float(np.abs(depth - first).max())
    return Proposal(
        best, (_change(before, found, most),), _measures(said, before, found, rest, most, mean), tuple(_told(rest, before)),
        tuple(_kept(said, before, found, most)), after=simulate(best, None),
    )  # fmt: skip


def left(scenario: ChamferScenario) -> Left:
    """What a scenario leaves of its width along the edge.

    Raises
    ------
    ScenarioFault
        There is nothing to correct, or more than one path.
    """
    done = chamfer.run(scenario, wanted=frozenset())
    why = None
    if not scenario.yields:
        why = "nothing takes the ball off its path; give tool.stiffness, a robot, a machine or a spindle that yields"
    elif done.infeasible:
        why = "the chamfer cannot be cut as it stands (cutwise run says why)"
    elif len(done.paths) != 1:
        why = f"there are {len(done.paths)} paths; a table of presets goes over one (part.edges)"
    elif not done.deflected[0].believed:
        why = "the ball is carried so far that its chamfer cannot be told (cutwise run says why)"
    if why is not None:
        raise ScenarioFault([Fault(("correct", "change"), f"offset: {why}")])
    (path,), width = done.paths, done.deflected[0].width
    wanted = path.found.width if scenario.chamfer.definition == "leg" else scenario.chamfer.width
    way, frames = way_along(path), path.path.frames
    near = np.linalg.norm(path.at.point[:, None] - frames.point[None], axis=2).argmin(axis=1)
    along = np.einsum("ij,ij->i", path.at.point - frames.point[near], frames.tangent[near])
    place = (way[near] + along) % way[-1] if frames.closed else np.clip(way[near] + along, 0.0, way[-1])
    order = np.argsort(place)
    return Left(place[order], float(way[-1]), frames.closed, (width - wanted)[order])


def _depth(scenario: ChamferScenario, at: Left) -> FloatArray:
    """What stands in the table of presets already [m]."""
    profile = scenario.operation.preset_profile
    return np.zeros(len(at.way)) if profile is None else np.interp(at.way, *profile.points())


def _with(scenario: ChamferScenario, at: Left, depth: FloatArray) -> ChamferScenario:
    """The scenario with a table of presets; a closed path ends as it begins."""
    if at.closed:
        places, values = np.append(at.way, at.way[0] + at.whole), np.append(depth, depth[0])
        seam = float(np.interp(at.whole, places, values))
        ends = seam, seam
    else:
        ends = float(depth[0]), float(depth[-1])
    inside = (at.way > 1e-9) & (at.way < at.whole - 1e-9)
    way = [0.0, *at.way[inside], at.whole]
    preset = [ends[0], *depth[inside], ends[1]]
    document: dict[str, Any] = scenario.document()
    document["operation"] = {**document["operation"], "preset_profile": {"columns": {
        "w [mm]": [float(f"{_MM * one:.9f}") for one in way], "preset [mm]": [float(f"{_MM * one:.7f}") for one in preset],
    }}}  # fmt: skip
    found = read_document(document, scenario.name)
    assert isinstance(found, ChamferScenario)
    return found


def _measures(
    said: Correction, before: Left, after: Left, rest: list[float], most: float, gain: float
) -> dict[str, tuple[float, str]]:  # fmt: skip
    values = {
        "residual_max": (after.worst, "small_length"),
        "residual_ratio": (after.worst / before.worst, "dimensionless"),
        "shift_max": (most, "small_length"),
        "offset_gain": (gain, "dimensionless"),
    }
    if rest:
        values["residual_p80"] = share_80(rest), "small_length"
        values["probability_within"] = (
            float(np.mean([one <= said.residual * before.worst for one in rest])),
            "dimensionless",
        )
    return values


def _change(before: Left, after: Left, most: float) -> Change:
    sizes = [units.show(one.worst, "small_length", 4) for one in (before, after)]
    return Change("chamfer.width", f"off by {sizes[0]}", sizes[1], f"the path is led up to {units.show(most, 'small_length', 3)} "
                  "deeper or less deep, place by place")  # fmt: skip


def _told(rest: list[float], before: Left) -> list[str]:
    if not rest:
        return ["nothing is said to vary (correct.vary, or correct.draws with a table): the residual is that of the nominal "
                "cell alone"]  # fmt: skip
    sizes = [units.show(one, "small_length", 3) for one in (share_80(rest), before.worst)]
    return [f"of {len(rest)} cells that may be the true one four of five leave at most {sizes[0]} of {sizes[1]}"]


def _kept(said: Correction, before: Left, after: Left, most: float) -> list[str]:
    sizes = [units.show(one.worst, "small_length", 3) for one in (after, before)]
    if after.worst >= before.worst:
        return [f"nothing is gained: the width is off by {sizes[0]} after {sizes[1]}"]
    if after.worst <= max(said.residual * before.worst, _NOTHING):
        return []
    at = most >= said.shift_max * (1.0 - 1e-9)
    floor = f"; the shift is at correct.shift_max ({units.show(said.shift_max, 'small_length', 3)})" if at else ""
    return [f"{sizes[0]} of {sizes[1]} are left, more than correct.residual ({said.residual:g}){floor}"]
