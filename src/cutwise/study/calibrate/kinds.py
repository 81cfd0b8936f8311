"""The kinds of calibration: columns, settings, and what is fitted; a new kind is a row here."""

from collections.abc import Callable
from difflib import get_close_matches
from typing import Any, NamedTuple

from cutwise.io.measurements import Channel, Measurement
from cutwise.spec.calibration import (
    ArmGeometry,
    ArmStiffness,
    Calibration,
    DriveLog,
    ForceWaves,
    FrequencyResponse,
    MachineVolume,
    MeanForces,
    SealTravel,
)
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate import cutting, drive, geometry, modal, seals, stiffness, volumetric, waveform
from cutwise.study.calibrate.posed import Finding


class Kind(NamedTuple):
    """A kind of calibration."""

    name: str
    describes: str
    settings: type[Calibration]
    channels: Callable[[Any], tuple[Channel, ...]]  # columns, of the settings or of None
    least_rows: int
    too_few: Callable[[int], str]
    calibrate: Callable[[Measurement, Any], Finding]
    shelf: str  # of the entry
    models: tuple[str, ...] = ()  # that fit.model may name, the default first
    completes: str = ""  # section whose values go into the entry
    left_behind: tuple[str, ...] = ()  # keys of it that no run knows


def _few(text: str) -> Callable[[int], str]:
    return lambda rows: f"has {rows} row{'s' if rows != 1 else ''}: {text}"


_ALL = (
    Kind(
        "cutting", "cutting coefficients from mean forces", MeanForces, cutting.channels, 3,
        lambda rows: f"{rows} feeds give a line but no error; cut at least 3", cutting.calibrate, "materials",
        cutting.MODELS,
    ),
    Kind(
        "cutting-waveform", "cutting coefficients, run-out and speed from forces over time", ForceWaves, waveform.channels, 16,
        _few("record two turns of the mill and more, 10 samples for each tooth"), waveform.calibrate, "materials",
    ),
    Kind(
        "robot-stiffness", "springs of an arm from load tests", ArmStiffness, stiffness.channels, 3,
        _few("load the arm at 3 postures or more, 10 times as many as joints for useful intervals"),
        stiffness.calibrate, "robots", stiffness.MODELS, "robot", ("link_weights", "gravity", "joint_stiffness"),
    ),
    Kind(
        "robot-geometry", "geometric errors of an arm from places that a tracker has seen", ArmGeometry, geometry.channels, 12,
        _few("twelve poses are the least for base and target; 200 and more for the errors of the joints"),
        geometry.calibrate, "robots", ("rigid+joints", "nominal", "rigid"), "robot",
    ),
    Kind(
        "spindle-seals", "piston force and seal friction of a compliant spindle from slow travel", SealTravel, seals.channels, 2,
        _few("travel at two pressures or more, several times each"), seals.calibrate, "spindles", (), "spindle",
        ("piston_force", "friction_static", "friction_dynamic", "friction_preload_fraction", "reference_pressure"),
    ),
    Kind(
        "modal", "modes of a tool tip from its frequency response", FrequencyResponse, modal.channels, 8,
        _few("a peak needs points on both of its sides, 10 within its width"), modal.calibrate, "tools",
    ),
    Kind(
        "feed-drive", "inertia, damping, friction and gains of a feed drive from a log", DriveLog, drive.channels, 60,
        _few("a log of a few seconds, back and forth at more than 10 rad/s"), drive.calibrate, "machines", (), "machine",
    ),
    Kind(
        "volumetric", "the 21 geometric errors of a three-axis machine", MachineVolume, volumetric.channels, 12,
        _few("measure a plate, diagonals or a ball bar, 50 places and more"), volumetric.calibrate, "machines", (), "machine",
        ("geometry_errors",),
    ),
)  # fmt: skip
KINDS = {kind.name: kind for kind in _ALL}


def kind_named(name: str) -> Kind:
    """The kind of a name.

    Raises
    ------
    ScenarioFault
        There is none; the message lists what there is.
    """
    if name not in KINDS:
        near = get_close_matches(name, KINDS, n=1)
        hint = f"did you mean {near[0]}? " if near else ""
        raise ScenarioFault([Fault((), f'"{name}" is no kind of calibration; {hint}there are: {", ".join(KINDS)}')])
    return KINDS[name]
