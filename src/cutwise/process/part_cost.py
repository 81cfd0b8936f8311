"""What a part costs: the machine's time, and the share of an edge that is worn."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.physics.cutting.tool_life import life_ratio, part_cost
from cutwise.process.milling import MillRun
from cutwise.spec.milling import MillingScenario
from cutwise.spec.shop import Wear

_QUANTILE = 1.6448536269514722  # of the normal distribution at 95 %
_NEAR = 0.3  # share of the reference cut within which its law of wear is trusted


class Use(NamedTuple):
    """How a part uses machine and tool."""

    time: float  # [s] of the part
    cutting: float  # [s] of it in the cut
    speed: float  # [m/s] at the nominal radius
    feed: float  # [m] per tooth, mean over the cut
    depth: float  # [m] greatest axial depth


def use_of(scenario: MillingScenario, done: MillRun) -> Use:
    """Time, and the cut in which the tool wears."""
    reference = done.reference
    cutting = (done.contact.immersion > 0.0) & (reference.travelled < reference.travelled[-1])
    step = scenario.drives.control.sample_time
    time = float(cutting.sum()) * step
    teeth = done.cut.spindle * done.cut.mill.flutes / (2.0 * np.pi)
    feed = float(reference.speed[cutting].mean()) / teeth if cutting.any() else 0.0
    return Use(done.plan.profile.duration, time, done.cut.spindle * done.cut.mill.radius, feed, done.contact.depth)


def life(wear: Wear, use: Use) -> float:
    """How long an edge lasts in a cut [s]."""
    feed = 1.0 if not wear.feed_exponent or not wear.at.feed_per_tooth else use.feed / wear.at.feed_per_tooth
    depth = 1.0 if not wear.depth_exponent or not wear.at.depth else use.depth / wear.at.depth
    return wear.life * life_ratio(
        use.speed / wear.at.cutting_speed, feed, depth, speed_exponent=wear.speed_exponent,
        feed_exponent=wear.feed_exponent, depth_exponent=wear.depth_exponent,
    )  # fmt: skip


def measures(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """Cost of a part, as far as it is known what machine and tool cost."""
    if scenario.shop is None:
        return {}
    return costs(scenario, use_of(scenario, done))


def costs(scenario: MillingScenario, use: Use) -> dict[str, float]:
    """Cost of a part that uses machine and tool so, with what it is made of."""
    shop = scenario.shop
    assert shop is not None
    found = {"cutting_time": use.cutting}
    if scenario.wear is None or use.cutting <= 0.0:
        return {**found, "cost_per_part": part_cost(shop.machine_rate, use.time)}
    found["tool_life"] = life(scenario.wear, use)
    assert shop.tool_price is not None
    price, lasts = shop.tool_price, found["tool_life"]
    found["cost_per_part"] = part_cost(shop.machine_rate, use.time, price, use.cutting, lasts)
    if scenario.wear.scatter:
        for end, sign in (("low", 1.0), ("high", -1.0)):
            drawn = lasts * math.exp(sign * _QUANTILE * scenario.wear.scatter)
            found[f"cost_{end}"] = part_cost(shop.machine_rate, use.time, price, use.cutting, drawn)
    return found


def warnings(scenario: MillingScenario, done: MillRun) -> Iterator[str]:
    """What the cost leaves out, and where the law of wear is carried on beyond its cut."""
    if scenario.shop is None:
        return
    if scenario.wear is None:
        yield "cost_per_part is that of the machine's time alone: no tool life is known (wear)"
        return
    use, at = use_of(scenario, done), scenario.wear.at
    for name, value, reference in (
        ("cutting speed", use.speed, at.cutting_speed),
        ("feed per tooth", use.feed, at.feed_per_tooth),
    ):
        if reference is not None and value > 0.0 and abs(value / reference - 1.0) > _NEAR:
            dimension = "speed" if name == "cutting speed" else "length"
            yield (
                f"the {name} is {units.show(value, dimension, 3)}, more than {100 * _NEAR:.0f} % off the cut of wear.at "
                f"({units.show(reference, dimension, 3)}): the tool life is extrapolated"
            )
