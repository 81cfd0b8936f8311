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
from cutwise.physics.engagement.wall import path_immersion
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
    arc = _immersion(scenario, given, way, upward)
    flutes = scenario.tool.flutes
    mill = Mill(0.5 * scenario.tool.diameter, flutes, 0.0)
    depth, none = given.axial_depth, discs(mill.radius, 0.0, given.axial_depth, flutes, 1)
    cutting = even_edges(linear_coefficients(scenario.material))
    chips = [feed_per_tooth(feed, 0.0, way.spindle, flutes) for feed in way.feed]
    local = np.array(
        [
            wall_force(AVERAGED, 0.0, 0.0, 0.0, a, 0.0, depth, c, 0.0, mill, none, cutting)
            for a, c in zip(arc, chips, strict=True)
        ]
    )
    ahead = way.direction - np.einsum("mi,mi->m", way.direction, upward)[:, None] * upward
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-300)
    force = local[:, :1] * ahead + local[:, 1:2] * np.cross(upward, ahead) + local[:, 2:] * upward
    return CutForce(np.where(way.cuts[:, None], force, 0.0), np.where(way.cuts, arc, 0.0))


def _immersion(scenario: MachineScenario, cut: FromCutting, way: Way, upward: FloatArray) -> FloatArray:
    radius = 0.5 * scenario.tool.diameter
    if cut.radial_depth is None:
        return np.full(len(way.travel), math.pi)
    upright = np.abs(upward - [0.0, 0.0, 1.0]).max() < _UPRIGHT
    if way.curve is None or not upright or cut.radial_depth >= radius:
        return np.full(len(way.travel), straight_immersion(cut.radial_depth, radius))
    return path_immersion(way.curve, way.curve_cuts, way.block, way.point, way.direction, radius, cut.radial_depth)
