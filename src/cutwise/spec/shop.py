"""What an hour and a tool cost, and how long a tool lasts."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from cutwise.spec.base import Length, Money, MoneyRate, Notice, Number, Spec, Speed, Time, Usual


class Shop(Spec):
    """What an hour of the machine and a tool cost."""

    machine_rate: Annotated[MoneyRate, Usual("20 EUR/h", "300 EUR/h")] = Field(
        description="of machine and operator", examples=["60 EUR/h"], ge=0
    )
    tool_price: Annotated[Money, Usual("1 EUR", "500 EUR")] | None = Field(
        default=None, description="price of a cutting edge (a tool, or its regrinding); left out: tools cost nothing",
        examples=["60 EUR"], ge=0,
    )  # fmt: skip


class WearAt(Spec):
    """The cut in which the tool life was found."""

    cutting_speed: Annotated[Speed, Usual("20 m/min", "2000 m/min")] = Field(
        description="at the nominal radius", examples=["500 m/min"], gt=0
    )
    feed_per_tooth: Annotated[Length, Usual("0.01 mm", "0.5 mm")] | None = Field(
        default=None, description="needed with feed_exponent", examples=["0.1 mm"], gt=0
    )
    depth: Annotated[Length, Usual("0.1 mm", "30 mm")] | None = Field(
        default=None, description="axial depth; needed with depth_exponent", examples=["5 mm"], gt=0
    )


class Wear(Spec):
    """How long a tool lasts: Taylor's law with feed and depth."""

    life: Annotated[Time, Usual("5 min", "500 min")] = Field(
        description="time in the cut until it is changed, in the cut of at", examples=["90 min"], gt=0
    )
    at: WearAt = Field(description="the cut in which it lasts so long")
    speed_exponent: Annotated[Number, Usual(0.1, 0.8)] = Field(
        description="Taylor's n: life goes with cutting speed to the power of -1/n", examples=[0.25], gt=0, le=2
    )
    feed_exponent: Annotated[Number, Usual(0, 2)] = Field(
        default=0.0, description="q: life goes with feed per tooth to the power of -q", examples=[0.36], ge=0, le=5
    )
    depth_exponent: Annotated[Number, Usual(0, 1)] = Field(
        default=0.0, description="m: life goes with axial depth to the power of -m", examples=[0.2], ge=0, le=5
    )
    scatter: Annotated[Number, Usual(0.1, 0.6)] = Field(
        default=0.0, description="standard deviation of the logarithm of the life", examples=[0.4], ge=0, le=3
    )

    def contradictions(self) -> Iterator[Notice]:
        """An exponent without the cut that it starts from."""
        for exponent, key in (("feed_exponent", "feed_per_tooth"), ("depth_exponent", "depth")):
            if getattr(self, exponent) and getattr(self.at, key) is None:
                yield Notice(("at", key), f"missing; {exponent} counts from it")
