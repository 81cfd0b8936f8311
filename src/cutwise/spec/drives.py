"""A machine with feed drives: the axes, their controllers, and the limits of the motion."""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from cutwise.spec.base import (
    Acceleration,
    AccelerationGain,
    AngularDamping,
    AngularSpeed,
    Count,
    CurrentGain,
    DerivativeGain,
    Inertia,
    IntegralGain,
    Jerk,
    LibrarySpec,
    Moment,
    Notice,
    ProportionalGain,
    SmallLength,
    Spec,
    Speed,
    Time,
    TorqueConstant,
    Transmission,
    Usual,
    Voltage,
)
from cutwise.spec.tables import Column, Table

Reading = Literal["as_printed", "kp_ki_swapped", "matched"]

READINGS: dict[str, str] = {
    "as_printed": "gains as the table gives them",
    "kp_ki_swapped": "the rows of K_p and K_i are taken to be exchanged: K_p is read where the table says K_i",
    "matched": "as kp_ki_swapped, and the x and y columns of all gains exchanged too, which makes the loops alike",
}


class Friction(Spec):
    """Stribeck friction at the motor: T_f = T_s exp(-w/W1) + T_c (1 - exp(-w/W2)), a set for each sign of w."""

    stiction_plus: Moment = Field(description="break-away torque T_s, w > 0", examples=["2.6256 N m"], ge=0)
    stiction_minus: Moment = Field(description="break-away torque T_s, w < 0", examples=["-1.8672 N m"], le=0)
    coulomb_plus: Moment = Field(description="Coulomb torque T_c, w > 0", examples=["2.1529 N m"], ge=0)
    coulomb_minus: Moment = Field(description="Coulomb torque T_c, w < 0", examples=["-1.4730 N m"], le=0)
    decay_plus: AngularSpeed = Field(description="speed W1 over which stiction fades", examples=["3.88 rad/s"], gt=0)
    decay_minus: AngularSpeed = Field(description="the same for w < 0", examples=["-3.51 rad/s"], lt=0)
    rise_plus: AngularSpeed = Field(
        description="speed W2 over which Coulomb friction builds up", examples=["4.20 rad/s"], gt=0
    )
    rise_minus: AngularSpeed = Field(description="the same for w < 0", examples=["-3.52 rad/s"], lt=0)


class FeedDrive(Spec):
    """One axis: amplifier, motor, transmission, friction, and the gains of its position controller."""

    K_a: CurrentGain = Field(description="current of the amplifier per volt", examples=["6.4898 A/V"], gt=0)
    K_t: TorqueConstant = Field(description="torque of the motor per ampere", examples=["0.4769 N m/A"], gt=0)
    J: Inertia = Field(description="inertia reflected to the motor", examples=["0.0077736 kg m^2"], gt=0)
    B: AngularDamping = Field(description="viscous damping at the motor", examples=["0.019811 N m s/rad"], ge=0)
    r_g: Transmission = Field(description="travel per angle of the motor", examples=["1.5915 mm/rad"], gt=0)
    K_p: ProportionalGain = Field(description="proportional gain of the table", examples=["500 V/mm"], ge=0)
    K_i: IntegralGain = Field(description="integral gain of the table", examples=["70 V/(mm s)"], ge=0)
    K_d: DerivativeGain = Field(description="derivative gain", examples=["0.3 V s/mm"], ge=0)
    K_1: AccelerationGain = Field(description="feedforward of the acceleration", examples=["0 V s^2/mm"])
    K_2: DerivativeGain = Field(description="feedforward of the speed", examples=["0 V s/mm"])
    friction: Friction = Field(description="friction at the motor")
    backlash: Annotated[SmallLength, Usual("0 um", "50 um")] = Field(
        description="whole play of the transmission", examples=["3 um"], ge=0
    )


class MotionLimits(Spec):
    """What the motion may do."""

    act_on: Literal["path", "axes"] = Field(
        default="path",
        description="path: limits of the motion along the path; axes: of each axis, so that a diagonal may be quicker",
        examples=["path"],
    )
    velocity: Annotated[Speed, Usual("50 mm/s", "2000 mm/s")] = Field(
        description="highest speed", examples=["169 mm/s"], gt=0
    )
    acceleration: Annotated[Acceleration, Usual("200 mm/s^2", "30000 mm/s^2")] = Field(
        description="highest acceleration", examples=["2000 mm/s^2"], gt=0
    )
    jerk: Annotated[Jerk, Usual("2000 mm/s^3", "2000000 mm/s^3")] = Field(
        description="highest jerk", examples=["50000 mm/s^3"], gt=0
    )


class Control(Spec):
    """The sampled controller."""

    sample_time: Annotated[Time, Usual("0.05 ms", "5 ms")] = Field(
        description="sample time of the position loop", examples=["1 ms"], gt=0
    )
    delay: Annotated[Count, Usual(0, 1)] = Field(
        description="samples by which the output is late (0 or 1)", examples=[0], ge=0, le=1
    )
    saturation: Annotated[Voltage, Usual("5 V", "10 V")] = Field(
        description="largest output of the controller", examples=["10 V"], gt=0
    )
    encoder: Annotated[SmallLength, Usual("0 um", "5 um")] = Field(
        description="quantum of the measured position; 0 for none", examples=["1 um"], ge=0
    )
    block_time: Annotated[Time, Usual("0.2 ms", "20 ms")] | None = Field(
        default=None, description="least time that a block of a program may take; what cutwise correct writes keeps it",
        examples=["2 ms"], gt=0,
    )  # fmt: skip
    ramp: Literal["inside_faster", "after"] = Field(
        default="inside_faster",
        description="where the speed changes between two feeds: inside the faster block, or behind the border, for cutwise correct",
        examples=["inside_faster"],
    )


class SpindlePower(Table):
    """The power that a spindle has over its speed, straight lines between points."""

    over: ClassVar[tuple[Column, ...]] = (Column("speed", "angular_speed", 0.0),)
    ordinate: ClassVar[Column] = Column("power", "power", 0.0)

    columns: dict[str, tuple[float, ...]] = Field(
        description="columns by their titles with units; a CSV file named by `table` is read into here",
        examples=['{"speed [rpm]": [500, 4000, 12000], "power [kW]": [1.2, 9, 9]}'],
    )


class SpindleTorque(Table):
    """The torque that a spindle has over its speed, straight lines between points."""

    over: ClassVar[tuple[Column, ...]] = (Column("speed", "angular_speed", 0.0),)
    ordinate: ClassVar[Column] = Column("torque", "moment", 0.0)

    columns: dict[str, tuple[float, ...]] = Field(
        description="columns by their titles with units; a CSV file named by `table` is read into here",
        examples=['{"speed [rpm]": [500, 4000, 12000], "torque [N*m]": [22, 22, 7]}'],
    )


class CncMachine(LibrarySpec):
    """A milling machine that follows its feed drives; without a z drive, z is taken as ideal."""

    library_shelf: ClassVar[str] = "machines"

    reading: Reading = Field(
        default="as_printed",
        description="how the table of gains is read: as_printed; kp_ki_swapped (rows exchanged); matched (rows and "
        "columns exchanged)",
        examples=["kp_ki_swapped"],
    )
    readings: tuple[Reading, ...] = Field(
        default=("as_printed",),
        description="readings that this table of gains allows; others than as_printed only where a print is in doubt",
        examples=["[as_printed, kp_ki_swapped]"],
    )
    limits: MotionLimits = Field(description="limits of the axes")
    control: Control = Field(description="the sampled controller")
    spindle_power: SpindlePower | None = Field(
        default=None, description="what power the spindle has over its speed; left out: as much as is asked for",
        examples=['{columns: {"speed [rpm]": [500, 4000, 12000], "power [kW]": [1.2, 9, 9]}}'],
    )  # fmt: skip
    spindle_torque: SpindleTorque | None = Field(
        default=None, description="what torque the spindle has over its speed; left out: as much as is asked for",
        examples=['{columns: {"speed [rpm]": [500, 4000, 12000], "torque [N*m]": [22, 22, 7]}}'],
    )  # fmt: skip
    x: FeedDrive = Field(description="the x axis")
    y: FeedDrive = Field(description="the y axis")
    z: FeedDrive | None = Field(default=None, description="the z axis; left out: it follows exactly")

    def contradictions(self) -> Iterator[Notice]:
        """A reading that exchanges gains of a table that is not in doubt."""
        if self.reading not in self.readings:
            yield Notice(
                ("reading",), f"{self.reading} exchanges gains, but those of this machine are not in doubt: "
                f"{' or '.join(self.readings)} (machine.readings says which are open)",
            )  # fmt: skip

    def notices(self) -> Iterator[Notice]:
        """Friction that is larger in motion than at rest."""
        for axis, friction in ((axis, drive.friction) for axis in "xyz" if (drive := getattr(self, axis)) is not None):
            for way in ("plus", "minus"):
                sliding, sticking = getattr(friction, f"coulomb_{way}"), getattr(friction, f"stiction_{way}")
                if abs(sliding) > abs(sticking):
                    yield Notice((axis, "friction", f"coulomb_{way}"), "is more than the stiction; usual is less")
