"""How the computation is done; nothing in here is physics."""

from typing import Annotated, Any, Literal

from pydantic import Field

from cutwise.spec.base import Count, Length, Spec, Time, Usual


def _usual_step(given: dict[str, Any]) -> float:
    return 2.5e-6 if given.get("force") == "tooth_resolved" else 20e-6


class TimeStepping(Spec):
    """Time stepping of a coupled run."""

    force: Literal["averaged", "tooth_resolved"] = Field(
        default="averaged",
        description="cutting force averaged over a tooth (edge error, spindle), or resolved tooth by tooth (ripple)",
        examples=["averaged"],
    )
    time_step: Annotated[Time, Usual("0.1 us", "400 us")] = Field(
        default_factory=_usual_step,
        description="time step; left out: 20 us averaged, 2.5 us tooth by tooth",
        examples=["20 us"],
        gt=0,
    )
    mode: Literal["step", "still"] = Field(
        default="step",
        description="time steps, or each place of the edge at rest (with spindle: rigid, without drives)",
        examples=["step"],
    )
    station: Annotated[Length, Usual("0.5 mm", "50 mm")] = Field(
        default=5e-3,
        description="distance of the places along a path at which the carrier's compliance is taken, and of those that "
        "are looked at at rest",
        examples=["5 mm"], gt=0,
    )  # fmt: skip
    substeps: Annotated[Count, Usual(4, 100)] = Field(
        default=10,
        description="steps in a sample of the controllers of feed drives, divided further to come down to time_step",
        examples=[10], ge=1,
    )  # fmt: skip
    engagement: Literal["auto", "arcs", "swept"] = Field(
        default="auto",
        description="arcs from the present position of the mill (fast), or a swept surface with memory; auto takes the "
        "surface where the arcs are not valid: under run-out, and with a path-memory index above 1",
        examples=["auto"],
    )
