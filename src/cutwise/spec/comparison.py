"""What ``cutwise compare`` holds side by side."""

from collections.abc import Iterator
from typing import Any, ClassVar

from pydantic import Field

from cutwise.spec.base import Count, Notice, Spec


class Comparison(Spec):
    """Cases of a scenario side by side, and what is uncertain in all of them."""

    listed: ClassVar[bool] = False

    cases: dict[str, dict[str, Any]] = Field(
        default_factory=dict, description="by name: keys that each case has otherwise, with their values; {} is the scenario",
        examples=["{contour: {}, trochoid: {pocket.strategy: trochoid, pocket.stepover: 2 mm}}"],
    )  # fmt: skip
    vary: dict[str, Any] = Field(
        default_factory=dict, description="what is uncertain in all cases alike, as in a study",
        examples=["{shop.machine_rate: {normal: {mean: 60 EUR/h, deviation: 12 EUR/h}}}"],
    )  # fmt: skip
    draws: Count = Field(
        default=64, description="draws of what is uncertain, a run of each case for each where more than money and wear vary",
        examples=[64], ge=8, le=100_000,
    )  # fmt: skip
    seed: Count = Field(default=1, description="seed of the draws", examples=[1], ge=0)

    def contradictions(self) -> Iterator[Notice]:
        """One case is no comparison."""
        if len(self.cases) == 1:
            yield Notice(("cases",), "is one case alone: write two or more")

    def unused(self) -> Iterator[Notice]:
        """Draws of nothing."""
        yield from super().unused()
        if not self.vary and "draws" in self.model_fields_set:
            yield Notice(("draws",), "nothing varies (compare.vary) but, where it is given, the life of the tool")
