"""The cutting force along a pass on a machine: prescribed, or the mean force of the cut from the flute kernel."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import Frames
from cutwise.maths.frames import FloatArray
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import Mill, feed_per_tooth
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import AVERAGED, wall_force
from cutwise.physics.engagement.corner import straight_immersion
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import block_stock, contact_patches, immersion
from cutwise.physics.engagement.wall import path_immersion, wall_patches
from cutwise.process.assemble import linear_coefficients
from cutwise.process.machine_way import Way
from cutwise.spec.machine_pass import FromCutting
from cutwise.spec.machine_scenario import MachineScenario

_UPRIGHT = 1e-9  # a tool axis that leans less is along z of the part


class CutForce(NamedTuple):
    """What the cut does to the tool along the way."""

    force: FloatArray  # [N] in the part's frame, shape (m, 3)
    immersion: FloatArray | None  # immersion angle [rad], shape (m,), if the force follows from it


def cut_force(scenario: MachineScenario, way: Way, at: Frames) -> CutForce:
    r"""Cutting force on the tool in the part's frame.

    A prescribed force acts wherever the tool cuts. Otherwise it is the mean over a revolution of the flute kernel at
    the local immersion, in the frame of the feed direction f and the tool axis u, :math:`F = F_x f + F_y\,u \times f +
    F_z\,u`. Inner corners are seen where the tool stands upright on the part and the previous pass was offset by less
    than its radius; elsewhere the immersion is that of a straight wall.
    """
    given = scenario.load.force
    if not isinstance(given, FromCutting):
        constant = np.array(given or (0.0, 0.0, 0.0))
        return CutForce(np.where(way.cuts[:, None], constant, 0.0), None)
    assert way.spindle is not None
    assert scenario.material is not None
    assert scenario.tool.flutes is not None
    upward = at.rotations[:, -1, :, 2]
    patches = _patches(scenario, given, way, upward)
    mill, flutes = Mill(0.5 * scenario.tool.diameter, scenario.tool.flutes, 0.0), scenario.tool.flutes
    none = discs(mill.radius, 0.0, 1e-3, flutes, 1)  # the mean needs none
    cutting = even_edges(linear_coefficients(scenario.material))
    local = np.zeros((len(way.travel), 3))
    for k in np.flatnonzero(way.cuts):
        chip = feed_per_tooth(way.feed[k], 0.0, way.spindle, flutes)
        for low, high, z_lo, z_hi in patches[k]:
            local[k] += wall_force(AVERAGED, 0.0, 0.0, low, high, z_lo, z_hi, chip, 0.0, mill, none, cutting)
    ahead = way.direction - np.einsum("mi,mi->m", way.direction, upward)[:, None] * upward
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-300)
    force = local[:, :1] * ahead + local[:, 1:2] * np.cross(upward, ahead) + local[:, 2:] * upward
    return CutForce(force, np.where(way.cuts, immersion(patches), 0.0))


def _patches(scenario: MachineScenario, cut: FromCutting, way: Way, upward: FloatArray) -> FloatArray:
    """Contact at every place: with the stock that the program has left, or along a wall."""
    if scenario.stock is not None:
        assert scenario.program is not None
        assert way.curve is not None
        x, y, z = (np.array(side) + shift for side, shift in zip(
            (scenario.stock.x, scenario.stock.y, scenario.stock.z), scenario.program.zero, strict=True
        ))  # fmt: skip
        swept = swept_path(way.curve, 0.5 * scenario.tool.diameter)
        heading = np.arctan2(way.direction[:, 1], way.direction[:, 0])
        return contact_patches(way.point, heading, way.along, swept, block_stock(x, y, z[1], z[0]))
    assert cut.axial_depth is not None
    return wall_patches(_immersion(scenario, cut, way, upward), cut.axial_depth)


def _immersion(scenario: MachineScenario, cut: FromCutting, way: Way, upward: FloatArray) -> FloatArray:
    radius = 0.5 * scenario.tool.diameter
    if cut.radial_depth is None:
        return np.full(len(way.travel), math.pi)
    upright = np.abs(upward - [0.0, 0.0, 1.0]).max() < _UPRIGHT
    if way.curve is None or not upright or cut.radial_depth >= radius:
        return np.full(len(way.travel), straight_immersion(cut.radial_depth, radius))
    return path_immersion(way.curve, way.curve_cuts, way.block, way.point, way.direction, radius, cut.radial_depth)
