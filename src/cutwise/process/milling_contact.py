"""What the mill meets along its path: a wall by closed form, or the stock that the program has left so far."""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.physics.engagement.corner import Corner, greatest_immersion, straight_immersion
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import (
    Stock,
    contact_patches,
    immersion,
    removal_area,
)
from cutwise.physics.engagement.wall import greatest_contact, path_contact, wall_patches
from cutwise.physics.motion.reference import Reference
from cutwise.process.program_path import ProgramPath
from cutwise.process.stock_moves import FLAT, StockMoves, moves_into_stock, stock_of
from cutwise.spec.milling import MillingScenario


class SteadyPatch(NamedTuple):
    """A contact that is looked at by itself."""

    low: float  # arc from the wall side [rad]
    high: float
    depth: float  # [m]


class Contact(NamedTuple):
    """What the mill meets at the servo instants, ``n`` of them."""

    patches: FloatArray  # arc from, to [rad], heights above the tip from, to [m]; shape (n, p, 4)
    immersion: FloatArray  # largest sum of arcs at one height [rad], shape (n,)
    greatest: float  # largest immersion [rad]
    steady: dict[str, SteadyPatch]  # "straight", where there is one such contact, and "corner", the heaviest
    removal: FloatArray | None  # cross-section taken per length of feed [m^2], where a stock is known, shape (n,)
    into: StockMoves  # program lines that run into the stock as they should not

    @property
    def depth(self) -> float:
        """Greatest height of contact above the tip [m]."""
        return float(self.patches[..., 3].max())


def contact(scenario: MillingScenario, path: ProgramPath, reference: Reference) -> Contact:
    """Contact along a path at the servo instants."""
    if scenario.stock is not None:
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
    patches = wall_patches(arcs, depth)
    alpha = immersion(patches)
    greatest = float(alpha.max())
    if scenario.path is not None:  # of a corner: the geometric maximum, not that of the samples
        if path.blended:
            greatest = greatest_contact(path.curve, radius, width)
        else:
            greatest = greatest_immersion(Corner(radius, width, scenario.path.turn, scenario.path.fillet))
    steady = {}
    if path.cuts.any():
        angles = {"straight": float(straight_immersion(width, radius)), "corner": greatest}
        steady = {name: SteadyPatch(0.0, angle, depth) for name, angle in angles.items()}
    return Contact(patches, alpha, greatest, steady, None, StockMoves())


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
    steady = {}
    if angle.any():
        heavy = removal_area(patches[:, :, None], radius)  # of each patch by itself
        k, p = np.unravel_index(int(np.argmax(heavy)), heavy.shape)
        steady["corner"] = SteadyPatch(
            float(patches[k, p, 0]), float(patches[k, p, 1]), float(patches[k, p, 3] - patches[k, p, 2])
        )
    return Contact(
        patches, angle, float(angle.max()), steady, removal_area(patches, radius), moves_into_stock(path, swept, stock)
    )
