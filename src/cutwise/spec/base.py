"""The base of all specifications: frozen, unknown keys refused, and quantities that are text outside, SI inside."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, Strict, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from cutwise import units
from cutwise.spec.faults import Path, dotted
from cutwise.spec.texts import hidden_fault

Status = Literal["measured", "catalogue", "paper", "assumed", "derived", "user"]


class Notice(NamedTuple):
    """Something to say about the values of a section: where (relative to the section), and what."""

    path: Path
    message: str


Given = TypeVar("Given")


def known(value: Given | None) -> Given:
    """A value that may be left out, where the checks of its section have found that it is there."""
    assert value is not None
    return value


def contradiction(found: Sequence[Notice]) -> PydanticCustomError:
    """The error that carries faults found by comparing values, for a pydantic validator to raise."""
    message = "; ".join(": ".join(filter(None, (dotted(path), text))) for path, text in found)
    return PydanticCustomError("contradiction", "{message}", {"message": message, "found": tuple(found)})


class Spec(BaseModel):
    """Something the engineer says."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=False, ser_json_inf_nan="strings")

    either: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys that say the same thing in different words: writing one sets aside weaker ones of the others
    (a library entry's, or those of the file under a ``--set``)."""

    instead: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Keys that stand in place of others: writing the one sets aside weaker ones of the others, and the other way round."""

    listed: ClassVar[bool] = True
    """Whether lists of all keys go into it; not where the keys are many and follow a rule."""

    stands_for: ClassVar[Mapping[str, str]] = {}
    """Keys that are names of keys in a section inside of this one, each with that section."""

    refused: ClassVar[Mapping[str, str]] = {}
    """Keys that an engineer may well write here and that physics forbids, each with the reason and what to do."""

    beside: ClassVar[tuple[str, ...]] = ()
    """Keys that name files which stand beside the scenario."""

    many_lines: ClassVar[tuple[str, ...]] = ()
    """Keys whose texts have lines; all others are written into comments, titles and tables, where a line end is harm."""

    def contradictions(self) -> Iterator[Notice]:
        """Values that cannot hold together."""
        yield from ()

    def notices(self) -> Iterator[Notice]:
        """Combinations that are possible but unusual."""
        yield from ()

    def unused(self) -> Iterator[Notice]:
        """Keys that change nothing beside the others, each with the reason: told where the engineer wrote them himself.

        What has to be written anyway is not told, nor what a library entry says for other uses.
        """
        yield from ()

    @model_validator(mode="after")
    def _holds_together(self) -> Self:
        found = tuple(self._hidden_letters()) or tuple(self.contradictions())
        if found:
            raise contradiction(found)
        return self

    def _hidden_letters(self) -> Iterator[Notice]:
        """Texts that hold control characters."""
        for name, value in self.__dict__.items():
            for path, text in _texts(value, (name,)):
                fault = hidden_fault(text, lines=name in self.many_lines)
                if fault is not None:
                    yield Notice(path, fault)


def _texts(value: Any, path: Path) -> Iterator[tuple[Path, str]]:
    """Every text in a value that is no section, keys of mappings included."""
    if isinstance(value, str):
        yield path, value
    elif isinstance(value, tuple):
        if value and not isinstance(value[0], float):
            for place, entry in enumerate(value):
                yield from _texts(entry, (*path, place))
    elif isinstance(value, dict):
        for key, entry in value.items():
            yield from _texts(key, path)
            yield from _texts(entry, (*path, key))


class LibrarySpec(Spec):
    """A section whose values may come from a library entry named by its ``library`` key."""

    library_shelf: ClassVar[str]

    library: str | None = Field(
        default=None,
        description="library entry (or own library file) that gives the values not written here",
        examples=["default", "./my_entry.yaml"],
    )


@dataclass(frozen=True)
class Quantity:
    """Annotation that makes a float a quantity: ``"80 mm/s"`` outside, 0.08 inside."""

    dimension: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(
            self._read,
            handler(source),
            serialization=core_schema.plain_serializer_function_ser_schema(
                self._write, when_used="json", return_schema=core_schema.any_schema()
            ),
        )

    def _read(self, value: Any) -> float:
        try:
            return units.parse(value, self.dimension)
        except units.UnitFault as fault:
            raise PydanticCustomError("quantity", "{message}", {"message": str(fault)}) from None

    def _write(self, value: float) -> str | float:
        return value if self.dimension == "dimensionless" else units.text(value, self.dimension)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        example = units.DIMENSIONS[self.dimension].example
        if self.dimension == "dimensionless":
            return {"type": ["number", "string"], "examples": [float(example)]}
        return {"type": "string", "examples": [example]}


@dataclass(frozen=True)
class Usual:
    """Annotation that says which values are usual (in text, with units); others are warned about, not refused."""

    low: str | float | None = None
    high: str | float | None = None


@dataclass(frozen=True)
class ByChance:
    """Annotation of a key that is another for each part, or each time a tool is clamped: a phase, the seed of what is random.

    What is the same for all parts, though nobody knows it well (a coefficient, a stiffness), has no such annotation: a program
    is made for its mean, and for the mean of what differs by chance only as far as it stands out of its scatter.
    """


Count = Annotated[int, Strict()]
Length = Annotated[float, Quantity("length")]
SmallLength = Annotated[float, Quantity("small_length")]
Area = Annotated[float, Quantity("area")]
Speed = Annotated[float, Quantity("speed")]
Acceleration = Annotated[float, Quantity("acceleration")]
Jerk = Annotated[float, Quantity("jerk")]
FeedPerRevolution = Annotated[float, Quantity("feed_per_revolution")]
AngularAcceleration = Annotated[float, Quantity("angular_acceleration")]
AngularSpeed = Annotated[float, Quantity("angular_speed")]
Angle = Annotated[float, Quantity("angle")]
SmallAngle = Annotated[float, Quantity("small_angle")]
Elasticity = Annotated[float, Quantity("elasticity")]
Frequency = Annotated[float, Quantity("frequency")]
SpatialFrequency = Annotated[float, Quantity("spatial_frequency")]
Time = Annotated[float, Quantity("time")]
Mass = Annotated[float, Quantity("mass")]
Density = Annotated[float, Quantity("density")]
Inertia = Annotated[float, Quantity("inertia")]
Force = Annotated[float, Quantity("force")]
Moment = Annotated[float, Quantity("moment")]
Power = Annotated[float, Quantity("power")]
Pressure = Annotated[float, Quantity("pressure")]
Stress = Annotated[float, Quantity("stress")]
EdgeForce = Annotated[float, Quantity("edge_force")]
Stiffness = Annotated[float, Quantity("stiffness")]
AngularStiffness = Annotated[float, Quantity("angular_stiffness")]
Compliance = Annotated[float, Quantity("compliance")]
AngularCompliance = Annotated[float, Quantity("angular_compliance")]
Damping = Annotated[float, Quantity("damping")]
AngularDamping = Annotated[float, Quantity("angular_damping")]
Voltage = Annotated[float, Quantity("voltage")]
Current = Annotated[float, Quantity("current")]
CurrentGain = Annotated[float, Quantity("current_gain")]
TorqueConstant = Annotated[float, Quantity("torque_constant")]
Transmission = Annotated[float, Quantity("transmission")]
ProportionalGain = Annotated[float, Quantity("proportional_gain")]
IntegralGain = Annotated[float, Quantity("integral_gain")]
DerivativeGain = Annotated[float, Quantity("derivative_gain")]
AccelerationGain = Annotated[float, Quantity("acceleration_gain")]
Money = Annotated[float, Quantity("money")]
MoneyRate = Annotated[float, Quantity("money_rate")]
Number = Annotated[float, Quantity("dimensionless")]
