"""What every scenario has: a name, a process, requirements, and a record of where each value came from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from pydantic import Field, PrivateAttr

from cutwise import units
from cutwise.spec.base import Spec, Status


@dataclass(frozen=True, slots=True)
class Origin:
    """Where an input value came from."""

    status: Status
    source: str = ""
    text: str = ""  # as written


class MeasureSpec(NamedTuple):
    """A measure that a process reports."""

    dimension: str
    description: str


class Limit(Spec):
    """Limits on a measure, in the measure's own unit once read."""

    min: Any = None
    max: Any = None


class Scenario(Spec):
    """The base of the scenarios of all processes."""

    name: str = Field(default="unnamed", description="name of the scenario", pattern=r"^[^/\\\n]+$")
    process: str = Field(description="which operation is simulated")
    requirements: dict[str, Limit] = Field(default_factory=dict, description="limits on measures")

    measures: ClassVar[Mapping[str, MeasureSpec]] = {}

    _origins: dict[str, Origin] = PrivateAttr(default_factory=dict)

    @property
    def origins(self) -> Mapping[str, Origin]:
        """Dotted key of every given value: where it came from (library entry, or the user)."""
        return self._origins

    def with_origins(self, origins: Mapping[str, Origin]) -> "Scenario":
        """The same scenario, knowing where its values came from."""
        copy = self.model_copy()
        copy._origins = dict(origins)
        return copy

    def document(self) -> dict[str, Any]:
        """The scenario as plain text values that can be read back exactly; each value with its source."""
        plain = self.model_dump(mode="json", exclude_unset=True)
        for key, origin in self._origins.items():
            if origin.status == "user" and not origin.source:
                continue
            *path, last = key.split(".")
            place = plain
            for step in path:
                place = place.get(step, {})
            if last in place and not isinstance(place[last], dict):
                place[last] = {"value": place[last], "status": origin.status, "source": origin.source}
        return plain


def measure_value(scenario: type[Scenario], name: str, text: object) -> float:
    """A limit written as text, in the SI unit of the measure it limits."""
    return units.parse(text, scenario.measures[name].dimension)
