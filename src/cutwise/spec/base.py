"""The base of all specifications: frozen, unknown keys refused, and quantities that are text outside, SI inside."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from cutwise import units

Status = Literal["measured", "catalogue", "paper", "assumed", "user"]


class Spec(BaseModel):
    """Something the engineer says."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=False, ser_json_inf_nan="strings")


class LibrarySpec(Spec):
    """A section whose values may come from a library entry named by its ``library`` key."""

    library: str | None = None
    library_shelf: ClassVar[str]


@dataclass(frozen=True)
class Quantity:
    """Annotation that makes a float a quantity: ``"80 mm/s"`` outside, 0.08 inside."""

    dimension: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(
            self._read,
            handler(source),
            serialization=core_schema.plain_serializer_function_ser_schema(
                self._write, when_used="json", return_schema=core_schema.str_schema()
            ),
        )

    def _read(self, value: Any) -> float:
        try:
            return units.parse(value, self.dimension)
        except units.UnitFault as fault:
            raise PydanticCustomError("quantity", "{message}", {"message": str(fault)}) from None

    def _write(self, value: float) -> str:
        return units.text(value, self.dimension)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        example = units.DIMENSIONS[self.dimension].example
        return {"type": "string", "examples": [example], "description": self.dimension.replace("_", " ")}


@dataclass(frozen=True)
class Usual:
    """Annotation that says which values are usual (in text, with units); others are warned about, not refused."""

    low: str | float | None = None
    high: str | float | None = None


Length = Annotated[float, Quantity("length")]
SmallLength = Annotated[float, Quantity("small_length")]
Area = Annotated[float, Quantity("area")]
Speed = Annotated[float, Quantity("speed")]
Acceleration = Annotated[float, Quantity("acceleration")]
Jerk = Annotated[float, Quantity("jerk")]
FeedPerRevolution = Annotated[float, Quantity("feed_per_revolution")]
AngularSpeed = Annotated[float, Quantity("angular_speed")]
Angle = Annotated[float, Quantity("angle")]
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
Damping = Annotated[float, Quantity("damping")]
AngularDamping = Annotated[float, Quantity("angular_damping")]
Voltage = Annotated[float, Quantity("voltage")]
Current = Annotated[float, Quantity("current")]
Number = Annotated[float, Quantity("dimensionless")]
