"""What a calibration is told beside its data: the machine that was measured, how it is fitted, what the file does not say."""

import datetime
import math
import warnings
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, create_model

from cutwise.spec.base import (
    Angle,
    AngularSpeed,
    Count,
    Length,
    LibrarySpec,
    Notice,
    Number,
    Pressure,
    Spec,
    Time,
    TorqueConstant,
    Transmission,
    Voltage,
)
from cutwise.spec.fields import tag
from cutwise.spec.robot import Angles, Direction, Joint, LinkWeight, Position

Positive = Annotated[Length, Field(gt=0)]

MINUS = {"x": (0, 1.0), "y": (1, 1.0), "z": (2, 1.0), "-x": (0, -1.0), "-y": (1, -1.0), "-z": (2, -1.0)}
"""A measured channel as it is written: which of x, y, z, and its sign."""


class FitSettings(Spec):
    """How the parameters are fitted."""

    loss: Literal["linear", "soft_l1"] = Field(
        default="linear", description="least squares, or robust against gross outliers", examples=["soft_l1"]
    )
    level: Annotated[Number, Field(gt=0.5, lt=1.0)] = Field(
        default=0.9, description="probability of the intervals", examples=[0.9]
    )
    model: str | None = Field(
        default=None, description="model that is written, where a kind has several", examples=["joints"]
    )
    hold_out: Literal["leave_one_out"] | Annotated[Number, Field(ge=0, le=0.5)] | None = Field(
        default=None,
        description="rows that are left out for the left-out error: leave_one_out (default up to 200 rows), or a share: "
        "rows k, 2k ... with k = 1/share (default 0.2 above, 0 for a frequency response)",
        examples=["leave_one_out", 0.2],
    )
    prior: dict[str, tuple[str | float, str | float]] = Field(
        default_factory=dict,
        description="what is known of parameters beforehand: value and standard deviation of each by name",
        examples=["{alpha: [0.3, 0.1]}"],
    )


class GeometryFit(FitSettings):
    """How the geometry of an arm is fitted."""

    harmonics: Annotated[Count, Field(ge=0, le=100)] = Field(
        default=60, description="orders of the angle correction of each joint (robot-geometry)", examples=[60]
    )
    gravity: bool = Field(
        default=True, description="fit joints 2 and 3 as yielding under the links' weight", examples=[True]
    )


class ModalFit(FitSettings):
    """How modes are fitted."""

    modes: Annotated[Count, Field(ge=1, le=12)] | None = Field(
        default=None, description="number of modes (modal); left out: the peaks that stand out", examples=[2]
    )


class MeasuredSettings(Spec):
    """What the entry says about the measurement."""

    date: str | None = Field(default=None, description="when it was measured", examples=["2026-03-01"])

    def contradictions(self) -> Iterator[Notice]:
        """A date that is none."""
        if self.date is not None and not is_date(self.date):
            yield Notice(("date",), f'"{self.date}" is not a date; write for example 2026-03-01')


def is_date(text: str) -> bool:
    """Whether a text is a date as 2026-03-01."""
    try:
        datetime.date.fromisoformat(text)
    except ValueError:
        return False
    return True


class Calibration(Spec):
    """Settings of every kind."""

    listed: ClassVar[bool] = False

    fit: FitSettings = FitSettings()
    measured: MeasuredSettings = MeasuredSettings()


class MeasuredArm(LibrarySpec):
    """The chain of the arm that was measured."""

    library_shelf: ClassVar[str] = "robots"

    joints: tuple[Joint, ...] = Field(
        description="the joints from the base", min_length=2, max_length=12,
        examples=["[{origin: [0 mm, 0 mm, 675 mm], axis: [0, 0, -1], limits: [-170 deg, 170 deg]}]"],
    )  # fmt: skip
    flange_origin: Position = Field(
        default=(0.0, 0.0, 0.0), description="origin of the flange", examples=["[0 mm, 0 mm, 0 mm]"]
    )
    flange_rotation: Angles = Field(
        default=(0.0, 0.0, 0.0), description="roll, pitch and yaw of the flange", examples=["[0 deg, 0 deg, 0 deg]"]
    )
    tool_position: Position = Field(
        default=(0.0, 0.0, 0.0), description="tool point in the flange frame", examples=["[0 mm, 0 mm, 100 mm]"]
    )
    link_weights: tuple[LinkWeight, ...] = Field(
        default=(),
        description="masses of the links, one for each joint",
        examples=["[{mass: 7 kg, centre: [0 m, 0 m, 0 m]}]"],
    )
    gravity: Direction = Field(
        default=(0.0, 0.0, -1.0), description="which way is down, in the base frame", examples=["[0, 0, -1]"]
    )

    def contradictions(self) -> Iterator[Notice]:
        """As many weights as joints, a direction with a length, no joint that follows another."""
        if self.link_weights and len(self.link_weights) != len(self.joints):
            message = f"has {len(self.link_weights)} links for {len(self.joints)} joints; write one for each joint"
            yield Notice(("link_weights",), message)
        if math.hypot(*self.gravity) < 1e-9:
            yield Notice(("gravity",), "has no length; write for example [0, 0, -1]")
        for n, joint in enumerate(self.joints):
            if joint.mimic is not None:
                message = (
                    "a joint that follows another cannot be calibrated yet; write the angles of six joints of their own"
                )
                yield Notice(("joints", n, "mimic"), message)


class PointSettings(Spec):
    """Where the deflection was measured."""

    point: Position | None = Field(
        default=None,
        description="measured point in the flange frame; left out: the tool point",
        examples=["[7 mm, 245 mm, 319 mm]"],
    )


class ArmStiffness(Calibration):
    """Settings of ``robot-stiffness``."""

    robot: MeasuredArm
    data: PointSettings = PointSettings()


class ArmGeometry(Calibration):
    """Settings of ``robot-geometry``."""

    fit: GeometryFit = GeometryFit()
    robot: MeasuredArm


class MeasuredTool(Spec):
    """The mill that cut."""

    flutes: Annotated[Count, Field(ge=1, le=40)] = Field(description="number of teeth", examples=[2])


class MeasuredOperation(Spec):
    """The cut."""

    axial_depth: Length = Field(description="axial depth of cut", examples=["3 mm"], gt=0)


class MeasuredCut(Spec):
    """Where the teeth cut."""

    arc: tuple[Angle, Angle] = Field(
        description="angles at which a tooth enters and leaves, from +y the way it turns; a slot is [0 deg, 180 deg]",
        examples=["[0 deg, 180 deg]"],
    )

    def contradictions(self) -> Iterator[Notice]:
        """Entry before exit, within half a turn of chip."""
        start, end = self.arc
        if not (-1e-9 <= start < end <= math.pi + 1e-9):
            yield Notice(("arc",), "a tooth enters before it leaves, both between 0 deg and 180 deg")


class ForceSettings(Spec):
    """How the forces were measured."""

    axes: Literal["auto"] | tuple[str, str, str] = Field(
        default=("x", "y", "z"),
        description="measured channels that are +x (feed), +y (normal), +z (to the motor); auto finds them for slots",
        examples=["[-y, x, z]"],
    )
    forces_on: Literal["tool", "work"] = Field(default="tool", description="what the forces act on", examples=["work"])

    def contradictions(self) -> Iterator[Notice]:
        """Each channel once."""
        if self.axes != "auto":
            unknown = [axis for axis in self.axes if axis not in MINUS]
            if unknown or len({axis[-1] for axis in self.axes}) < 3:
                yield Notice(
                    ("axes",),
                    f"[{', '.join(self.axes)}] does not name each of x, y, z once; write for example [-y, x, z]",
                )


class MeanForces(Calibration):
    """Settings of ``cutting``."""

    tool: MeasuredTool
    operation: MeasuredOperation
    cut: MeasuredCut
    data: ForceSettings = ForceSettings()


class SampledTool(MeasuredTool):
    """The mill whose forces were sampled."""

    diameter: Length = Field(description="diameter", examples=["10 mm"], gt=0)
    helix: Annotated[Angle, Field(ge=0, lt=math.pi / 2)] = Field(description="helix angle", examples=["30 deg"])


class SampledOperation(MeasuredOperation):
    """The cut whose forces were sampled."""

    feed_per_tooth: Length = Field(description="feed per tooth", examples=["0.1 mm"], gt=0)
    spindle_speed: AngularSpeed = Field(description="nominal speed, within 1 %", examples=["6000 rpm"], gt=0)


class ForceWaves(Calibration):
    """Settings of ``cutting-waveform``."""

    tool: SampledTool
    operation: SampledOperation
    cut: MeasuredCut
    data: ForceSettings = ForceSettings()


class MeasuredSpindle(LibrarySpec):
    """The compliant spindle that was pushed."""

    library_shelf: ClassVar[str] = "spindles"

    piston_arm: Length = Field(description="distance of the pistons from the joint", examples=["80 mm"], gt=0)
    tool_reach: Length = Field(description="distance of the tip from the joint", examples=["150 mm"], gt=0)
    pistons: Annotated[Count, Field(ge=3, le=60)] = Field(description="number of pistons", examples=[7])
    reference_pressure: Pressure = Field(
        description="gauge pressure at which piston force and friction are written", examples=["5 bar"], gt=0
    )


class SealTravel(Calibration):
    """Settings of ``spindle-seals``."""

    spindle: MeasuredSpindle


class ResponseSettings(Spec):
    """Direction and scatter of the frequency response."""

    direction: Literal["x", "y"] | None = Field(
        default=None, description="direction in which the tip was struck and moved", examples=["x"]
    )
    noise_relative: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default=0.01, description="scatter over magnitude (assumed)", examples=[0.01]
    )
    averages: Annotated[Count, Field(ge=1)] | None = Field(
        default=None,
        description="averages of the response: with a column coherence they give its scatter",
        examples=[16],
    )
    noise_floor: Annotated[Number, Field(ge=0)] = Field(default=0.0, description="least scatter [m/N]", examples=[1e-9])


class FrequencyResponse(Calibration):
    """Settings of ``modal``."""

    fit: ModalFit = ModalFit()
    data: ResponseSettings = ResponseSettings()


class LoggedDrive(Spec):
    """The feed drive that was logged."""

    axis: Literal["x", "y", "z"] | None = Field(default=None, description="axis that it moves", examples=["x"])
    r_g: Transmission = Field(description="travel per angle of the motor", examples=["1.5915 mm/rad"], gt=0)
    K_t: TorqueConstant | None = Field(
        default=None,
        description="torque of the motor per ampere, for a column current",
        examples=["0.4769 N m/A"],
        gt=0,
    )
    saturation: Voltage | None = Field(
        default=None,
        description="largest output of the controller; left out: it was not reached",
        examples=["10 V"],
        gt=0,
    )


class CompletedMachine(LibrarySpec):
    """The machine whose entry the new values complete."""

    library_shelf: ClassVar[str] = "machines"


class DriveLog(Calibration):
    """Settings of ``feed-drive``."""

    drive: LoggedDrive
    machine: CompletedMachine = CompletedMachine()


class VolumeSettings(Spec):
    """How the errors are written."""

    scale: tuple[Positive, Positive, Positive] | None = Field(
        default=None,
        description="command of x, y, z that counts as 1 in the polynomials; left out: the largest of the data",
        examples=["[200 mm, 150 mm, 300 mm]"],
    )


class VolumePrior(Spec):
    """What is taken for combinations that the data leave free."""

    prior: tuple[Positive, Annotated[Angle, Field(gt=0)]] = Field(
        default=(5e-6, 20e-6),
        description="standard deviation of displacements and rotations that the data leave free, in the band of a run (assumed)",
        examples=["[5 um, 20 urad]"],
    )


class MachineVolume(Calibration):
    """Settings of ``volumetric``."""

    machine: CompletedMachine = CompletedMachine()
    volumetric: VolumePrior = VolumePrior()
    data: VolumeSettings = VolumeSettings()


def _fit_or_time(value: Any) -> str:
    return "<fit>" if isinstance(value, str) and value.strip()[:1].isalpha() else "<time>"


class ValidateSettings(Spec):
    """How runs are held against a measurement."""

    noise: str | dict[str, str] | None = Field(
        default=None,
        description="scatter of the measurement that widens the band: of all measures of its unit, or of each by name",
        examples=["0.22 mm", "{thrust_max: 5 N}"],
    )
    delay: Annotated[
        Annotated[Literal["fit"], tag("fit")] | Annotated[Time, tag("time")], Discriminator(_fit_or_time)
    ] = Field(
        default=0.0,
        description="by how much a recording lags the run, or fit: that of the largest correlation",
        examples=["fit", "0.02 s"],
    )


with warnings.catch_warnings():
    warnings.simplefilter("ignore", UserWarning)  # pydantic has an old name "validate", which nobody here calls
    Validation: Any = create_model(  # type: ignore[call-overload]
        "Validation",
        __base__=Spec,
        __doc__="Settings of ``validate``.",
        **{
            "validate": (ValidateSettings, Field(default=ValidateSettings(), description="how it is compared")),
            "data": (ForceSettings, Field(default=ForceSettings(), description="how forces were measured")),
        },
    )
