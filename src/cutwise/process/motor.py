"""What the motor of a spindle can give, held against what the cut takes."""

from collections.abc import Iterator

from cutwise import units
from cutwise.results import Finding, warned
from cutwise.spec.spindle import CompliantSpindle


def overload(spindle: CompliantSpindle, power: float) -> Iterator[Finding]:
    """A mean cutting power [W] above the rating of the motor, if that is known."""
    rating = spindle.power_rating
    if rating is not None and power > rating:
        yield warned(
            "motor_overloaded", f"cutting takes {units.show(power, 'power')}, more than the motor's {units.show(rating, 'power')}: "
            "it will slow down or stall; reduce feed or burr height", power, rating, "power",
        )  # fmt: skip
