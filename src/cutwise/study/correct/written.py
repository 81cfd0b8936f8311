"""A shifted path as a program: written as chords, read back, planned and run again."""

from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.io.scenario import read_document
from cutwise.maths.curves import FloatArray
from cutwise.paths.pocket import corner
from cutwise.process.milling import Commanded, commanded
from cutwise.programs.fanuc import Fanuc
from cutwise.programs.interpreter import reading
from cutwise.programs.rs274 import Rs274
from cutwise.programs.trace import Trace, traced
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import CornerPath, MillingScenario
from cutwise.study.correct.bent import Walls, walls_of
from cutwise.study.correct.chorded import Stretch, corner_program, joint_tolerance, mode_of, rewritten, writable
from cutwise.study.correct.level import cut_level, stretches
from cutwise.study.correct.shift import Learned, Plant, Seen, chords, judged, seen


class Written(NamedTuple):
    """A program with a shifted path, read back."""

    scenario: MillingScenario
    told: Commanded
    seen: Seen  # what the nominal machine makes of it
    chords: int
    walls: Walls | None = None
    left: tuple[str, ...] = ()  # lines that could not be shifted, and why

    @property
    def plant(self) -> Plant:
        """The nominal machine that runs it."""
        return Plant(self.scenario, self.told, self.walls)

    @property
    def error(self) -> FloatArray:
        """Error of the nominal machine at the servo instants, of walls in their middle [m]."""
        return self.seen.error[0]

    @property
    def residual(self) -> float:
        """Largest error where a shift is judged [m]."""
        return largest(self.told, self.seen.worst, whole=self.walls is not None)


def largest(told: Commanded, error: FloatArray, *, whole: bool = False) -> float:
    """Largest error where a shift is judged: not in plunges and rapid moves, before the first bend, and next to stops [m]."""
    return float(np.abs(np.asarray(error)[..., judged(told, whole=whole)]).max(initial=0.0))


def as_program(scenario: MillingScenario) -> MillingScenario:
    """The same cut with its corner written as a program."""
    if not isinstance(scenario.path, CornerPath):
        return scenario
    path, operation = scenario.path, scenario.operation
    assert operation.feed is not None
    assert operation.spindle_speed is not None
    assert operation.axial_depth is not None
    mode = scenario.path_mode
    blocks = corner(path.lead, path.turn, path.fillet)
    words = mode_of("blend", mode.blend) if not isinstance(mode, str) else mode_of(mode, 0.0)
    text = corner_program(blocks, (operation.feed, operation.spindle_speed), operation.axial_depth, words)
    start = dict(zip("xyz", (*blocks[0].start[:2], -operation.axial_depth), strict=True))
    document = _without(scenario.document(), {"path": None, "operation": ("feed", "spindle_speed")})
    if not isinstance(mode, str) and mode.shape != "arc":
        raise ScenarioFault([Fault(("path_mode", "shape"), "path: a program has blends of arcs; write shape: arc")])
    document.pop("path_mode", None)
    document["program"] = {
        "file": f"{scenario.name}.nc", "text": text, "start": {axis: units.text(at, "length") for axis, at in start.items()},
    }  # fmt: skip
    return _read(document, scenario)


def from_wanted(scenario: MillingScenario) -> MillingScenario:
    """The scenario with the wanted program in place of one that was corrected before."""
    assert scenario.program is not None
    if scenario.program.wanted is None:
        return scenario
    document = scenario.document()
    wanted = document["program"].pop("wanted")
    document["program"] |= {key: wanted[key] for key in ("file", "text")}
    return _read(document, scenario)


def _without(document: dict[str, Any], gone: dict[str, tuple[str, ...] | None]) -> dict[str, Any]:
    """A document without some sections, or keys of them."""
    for section, keys in gone.items():
        if keys is None:
            document.pop(section, None)
        else:
            document[section] = {key: value for key, value in document[section].items() if key not in keys}
    return document


def _read(document: dict[str, Any], like: MillingScenario) -> MillingScenario:
    found = read_document(document, like.name)
    assert isinstance(found, MillingScenario)
    return found


def program_of(scenario: MillingScenario) -> Trace:
    """The program as text and as it runs.

    Raises
    ------
    ScenarioFault
        Its language has no words for a shifted path.
    """
    program = scenario.program
    assert program is not None
    setup = setup_of(program)
    run = reading(program.text, program.file, setup)
    why = None
    if not isinstance(run, Rs274):
        why = "is APT; paths are shifted in G-code alone: post-process it first"
    elif isinstance(run, Fanuc):
        why = ("is in the dialect fanuc, which has no word for the tolerance of a joint (G64 P), and chords would brake at each "
               "of theirs: correct the program in rs274 and write it with --format fanuc")  # fmt: skip
    trace = None if why is not None else traced(program.text, program.file, setup)
    if trace is None:
        raise ScenarioFault([Fault(("program",), f"{why}")])
    return trace


def written(
    scenario: MillingScenario, told: Commanded, found: Learned, said: Correction, walls: Walls | None = None
) -> Written:  # fmt: skip
    """The program of a shift, read back and run on the nominal machine; stretches that cannot be written stay.

    Raises
    ------
    ScenarioFault
        None of them can, with the reason of each line.
    """
    trace, program = program_of(scenario), scenario.program
    assert program is not None
    pieces, faults = writable(trace, told.wanted, _stretches(scenario, told, found, said))
    if faults and not pieces:
        raise ScenarioFault(faults)
    moded = "path_mode" in scenario.model_fields_set
    text = rewritten(trace, told.wanted, pieces, said.decimals, moded=moded) if pieces else program.text
    document = scenario.document()
    if moded:
        document.pop("path_mode")
    wanted = {"file": program.file, "text": program.text}
    document["program"] = {**document["program"], "file": _renamed(program.file), "text": text, "wanted": wanted}
    new = _read(document, scenario)
    again = commanded(new, new.numerics.substeps)
    left = tuple(fault.message for fault in faults)
    walls = walls_of(new, again, walls)
    one = seen([Plant(new, again, walls)], again.order)
    return Written(new, again, one, sum(len(one.end) for one in pieces), walls, left)


def _renamed(file: str) -> str:
    stem, dot, suffix = file.rpartition(".")
    stem = stem if dot else file
    return file if stem.endswith("_corrected") else f"{stem}_corrected{dot}{suffix if dot else ''}"


def _stretches(scenario: MillingScenario, told: Commanded, found: Learned, said: Correction) -> list[Stretch]:
    """Chords of every stretch that is shifted at all, rounded as they are written."""
    path, limits = told.wanted, scenario.drives.limits
    at, point = chords(path, found, chord_of(scenario, told, said))
    point = np.round(point * 1e3, said.decimals) * 1e-3
    block = np.minimum(np.searchsorted(path.curve.knots, at - 1e-12, side="left") - 1, path.curve.count - 1)
    along, instant = np.unique(told.place.travelled, return_index=True)
    pieces, least = [], 0.5 * 10.0 ** -(3 + said.decimals)
    for low, high in stretches(path):
        inside = np.flatnonzero((at >= low - 1e-12) & (at <= high + 1e-12))
        if np.abs(found.at(at[inside])).max(initial=0.0) < least:
            continue
        inside = _own(at, inside, low, high)
        ends = point[inside[1:], :2]
        speed = np.interp(at[inside[1:-1]], along, told.reference.speed[instant])
        tolerance = joint_tolerance(point[inside[0], :2], ends, speed, limits.acceleration, limits.jerk)
        pieces.append(Stretch(path.source[np.maximum(block[inside[1:]], 0)], ends, tolerance))
    return pieces


def chord_of(scenario: MillingScenario, told: Commanded, said: Correction) -> float:
    """Length of the chords [m]: as asked for, but no block shorter than the control takes."""
    feed = told.wanted.feed[cut_level(told.wanted)]
    block_time = scenario.drives.control.block_time
    return said.chord if block_time is None else max(said.chord, float(feed.max(initial=0.0)) * block_time)


def _own(at: FloatArray, inside: Any, low: float, high: float) -> Any:
    """Of vertices at both sides of a joint of stretches those of this one: places rise within it."""
    first = inside[np.flatnonzero(np.abs(at[inside] - low) < 1e-12)[-1:]]
    last = inside[np.flatnonzero(np.abs(at[inside] - high) < 1e-12)[:1]]
    return np.arange(first[0], last[0] + 1)
