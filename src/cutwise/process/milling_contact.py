"""What the mill meets along its path: a wall by closed form, or the stock that the program has left so far."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.wall import place_loads
from cutwise.physics.engagement.corner import Corner, greatest_immersion, straight_immersion
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.rim import SLIGHT
from cutwise.physics.engagement.stock import Stock, contact_patches, immersion, removal_area
from cutwise.physics.engagement.wall import greatest_contact, path_contact, wall_patches
from cutwise.physics.motion.reference import Reference
from cutwise.process.loops_drives import Cut
from cutwise.process.program_path import ProgramPath
from cutwise.process.stock_moves import FLAT, StockMoves, moves_into_stock, stock_of
from cutwise.spec.milling import CornerPath, MillingScenario
from cutwise.spec.program import StockBlock


class SteadyPatch(NamedTuple):
    """A contact that is looked at by itself, with the feed that it is run at."""

    low: float  # arc of the patch that takes the most, from the wall side [rad]
    high: float
    depth: float  # of that patch [m]
    chip: float  # feed per tooth [m]
    whole: FloatArray  # all patches of the place, rows as those of ``Contact``, shape (p, 4)


class Contact(NamedTuple):
    """What the mill meets at the servo instants, ``n`` of them."""

    patches: FloatArray  # arc from, to [rad], heights above the tip from, to [m]; shape (n, p, 4)
    immersion: FloatArray  # largest sum of arcs at one height [rad], shape (n,)
    greatest: float  # largest immersion [rad]
    removal: FloatArray | None  # cross-section taken per length of feed [m^2], where a stock is known, shape (n,)
    into: StockMoves  # program lines that run into the stock as they should not

    @property
    def depth(self) -> float:
        """Greatest height of contact above the tip [m]."""
        return float(self.patches[..., 3].max())


def contact(scenario: MillingScenario, path: ProgramPath, reference: Reference) -> Contact:
    """Contact along a path at the servo instants."""
    if isinstance(scenario.stock, StockBlock):
        return stock_contact(path, reference, 0.5 * scenario.tool.diameter, stock_of(scenario.stock))
    return _wall_contact(scenario, path, reference)


def _wall_contact(scenario: MillingScenario, path: ProgramPath, reference: Reference) -> Contact:
    """The previous pass has the same shape, offset by the radial depth."""
    radius, operation = 0.5 * scenario.tool.diameter, scenario.operation
    assert operation.radial_depth is not None
    assert operation.axial_depth is not None
    depth, width = operation.axial_depth, operation.radial_depth
    arcs = path_contact(path.curve, path.cuts, reference.block, reference.travelled, radius, width)
    arcs[reference.travelled >= path.curve.knots[-1]] = 0.0
    if scenario.line is not None:
        arcs[reference.travelled < (scenario.line.cut_from or 0.0)] = 0.0
    patches = wall_patches(arcs, depth)
    alpha = immersion(patches)
    greatest = float(alpha.max())
    if isinstance(scenario.path, CornerPath):  # the geometric maximum, not that of the samples
        if path.blended:
            greatest = greatest_contact(path.curve, radius, width)
        else:
            greatest = greatest_immersion(Corner(radius, width, scenario.path.turn, scenario.path.fillet))
    return Contact(patches, alpha, greatest, None, StockMoves())


def stock_contact(path: ProgramPath, reference: Reference, radius: float, stock: Stock) -> Contact:
    """Contact with what the moves of a program have left of its stock.

    Rapid moves cut nothing here, and neither do plunges, whose end of the mill is not modelled; both are noted by their lines where
    they run into the stock.
    """
    heading = np.arctan2(reference.direction[:, 1], reference.direction[:, 0])
    moving = reference.travelled < path.curve.knots[-1]
    swept = swept_path(path.curve, radius)
    patches = contact_patches(reference.point, heading, reference.travelled, swept, stock)
    patches[~moving] = 0.0
    angle = immersion(patches)
    rapid = np.isinf(path.feed[reference.block])
    upright = np.hypot(reference.direction[:, 0], reference.direction[:, 1]) < FLAT
    patches[rapid | upright] = 0.0
    angle = np.where(rapid | upright, 0.0, angle)
    flat = np.hypot(reference.direction[:, 0], reference.direction[:, 1])  # of a ramp only what it goes in the plane
    told = path.programmed  # a blend from a plunge into a level line goes down too, and is no ramp
    falls = (told.along[:, 2] + told.climb[:, 2] < -FLAT) & (np.hypot(told.along[:, 0], told.along[:, 1]) > FLAT)
    ramps = falls[path.origin[reference.block]] & (angle > 0.0)
    into = moves_into_stock(path, swept, stock)._replace(
        ramps=tuple(int(line) for line in np.unique(path.source[reference.block[ramps]]))
    )
    return Contact(patches, angle, float(angle.max()), removal_area(patches, radius) * flat, into)


class SteadyCuts(NamedTuple):
    """Contacts that are looked at by themselves: "straight", if there is one on the path, and "corner", the heaviest."""

    force: dict[str, SteadyPatch]  # the heaviest by its mean force in the plane, with the feed of its own place
    width: dict[str, SteadyPatch]  # the heaviest by its cross-section, in which a tool chatters first


def steady_cuts(
    scenario: MillingScenario, path: ProgramPath, reference: Reference, met: Contact, feed: FloatArray, cut: Cut
) -> SteadyCuts:
    """Contacts to look at by themselves, each at its own feed.

    Forces are compared place by place: where feed and contact together make the largest mean force. ``feed`` is the speed
    of each block [m/s], shape (blocks,).
    """
    if not path.cuts.any() or not met.immersion.any():
        return SteadyCuts({}, {})
    per_tooth = 2.0 * math.pi / (cut.spindle * cut.mill.flutes)
    radius, depth = 0.5 * scenario.tool.diameter, met.depth
    straight = {}
    if met.removal is None:
        lines = path.cuts & path.curve.straight
        chip = float(feed[lines if lines.any() else path.cuts].max()) * per_tooth
        straight["straight"] = _one_patch(
            straight_immersion(scenario.operation.radial_depth or 0.0, radius), depth, chip
        )
        if scenario.line is not None:
            if scenario.operation.milling == "up":  # the arc ends at the far side
                straight = {name: _mirrored(patch) for name, patch in straight.items()}
            return SteadyCuts(straight, straight)
        if scenario.path is not None:  # of a corner: one feed, and the geometric maximum
            both = straight | {"corner": _one_patch(met.greatest, depth, chip)}
            return SteadyCuts(both, both)
    flat = np.hypot(reference.direction[:, 0], reference.direction[:, 1])  # what goes along the axis makes no chip
    chips = np.where(met.immersion > 0.0, feed[reference.block], 0.0) * flat * per_tooth
    loads = place_loads(met.patches, chips, cut.mill, cut.discs, cut.edges)
    widths = np.where(chips > 0.0, removal_area(met.patches, radius), 0.0)
    return SteadyCuts(*(straight | _heaviest(met, chips, weight) for weight in (loads, widths)))


def _heaviest(met: Contact, chips: FloatArray, weight: FloatArray) -> dict[str, SteadyPatch]:
    """The contact with the largest weight."""
    place = int(np.argmax(weight))
    if not weight[place] > 0.0:
        return {}
    return {"corner": patch_of(met.patches[place], float(chips[place]))}


def patch_of(whole: FloatArray, chip: float) -> SteadyPatch:
    """A place by the patch of it that takes the most, with its feed per tooth [m]; ``whole``: all of them, shape (p, 4)."""
    return SteadyPatch(*_largest(whole[whole[:, 1] > whole[:, 0]]), chip, whole)


def _one_patch(angle: float, depth: float, chip: float) -> SteadyPatch:
    return SteadyPatch(0.0, angle, depth, chip, np.array([[0.0, angle, 0.0, depth]]))


def _mirrored(patch: SteadyPatch) -> SteadyPatch:
    """The same arc of a tool that has the work on its left."""
    low, high = math.pi - patch.high, math.pi - patch.low
    whole = patch.whole.copy()
    whole[:, 0], whole[:, 1] = math.pi - patch.whole[:, 1], math.pi - patch.whole[:, 0]
    return patch._replace(low=low, high=high, whole=whole)


def _largest(rows: FloatArray) -> tuple[float, float, float]:
    """The arc from, to [rad] and depth [m] that takes the most, of patches that stand on one floor beside one another."""
    found = []
    for first in range(len(rows)):
        last = first
        while last + 1 < len(rows) and rows[last + 1, 0] - rows[last, 1] < SLIGHT:
            last += 1
        for end in range(first, last + 1):
            low, high = float(rows[first, 0]), float(rows[end, 1])
            depth = float((rows[first : end + 1, 3] - rows[first : end + 1, 2]).min())
            found.append(((math.cos(low) - math.cos(high)) * depth, low, high, depth))
    return max(found)[1:]
