"""The cutting force along a pass on a machine: prescribed, or the mean force of the cut from the flute kernel."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import Frames
from cutwise.maths.frames import FloatArray
from cutwise.maths.linearc import carried
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.wall import AVERAGED, wall_force
from cutwise.physics.engagement.corner import straight_immersion
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import contact_patches, immersion
from cutwise.physics.engagement.wall import path_contact, wall_patches
from cutwise.process.edges import edges_alike
from cutwise.process.machine_path import ToolPath
from cutwise.process.stock_moves import stock_of
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.machine_pass import FromCutting
from cutwise.spec.machine_scenario import MachineScenario

_STEADY = 1e-9  # a tool axis that changes less keeps its direction


class CutForce(NamedTuple):
    """What the cut does to the tool along the way."""

    force: FloatArray  # [N] in the part's frame, shape (m, 3)
    immersion: FloatArray | None = None  # immersion angle [rad], shape (m,), if the force follows from it
    chip: FloatArray | None = None  # feed per tooth [m], shape (m,), if the force follows from it


def cut_force(scenario: MachineScenario, way: ToolPath, at: Frames) -> CutForce:
    r"""Cutting force on the tool in the part's frame.

    A prescribed force acts wherever the tool cuts. Otherwise it is the mean over a revolution of the flute kernel at
    the local immersion, in the frame of the feed direction f and the tool axis u, :math:`F = F_x f + F_y\,u \times f +
    F_z\,u`. Where the tool keeps its direction, inner corners are seen; elsewhere the immersion is that of a straight
    wall. The end of the mill does not cut: along its axis there is no force.

    Raises
    ------
    ScenarioFault
        There is a stock, and the tool does not stand upright.
    """
    given = scenario.load.force
    if not isinstance(given, FromCutting):
        constant = np.array(given or (0.0, 0.0, 0.0))
        return CutForce(np.where(way.cuts[:, None], constant, 0.0))
    assert way.spindle is not None
    assert scenario.material is not None
    assert scenario.tool.flutes is not None
    upward = at.rotations[:, -1, :, 2]
    patches = _patches(scenario, given, way, at)
    mill, flutes = Mill(0.5 * scenario.tool.diameter, scenario.tool.flutes, 0.0), scenario.tool.flutes
    none = discs(mill.radius, 0.0, 1e-3, flutes, 1)  # the mean needs none
    cutting = edges_alike(scenario.material)
    local = np.zeros((len(way.travel), 3))
    ahead = way.direction - np.einsum("mi,mi->m", way.direction, upward)[:, None] * upward
    across = np.linalg.norm(ahead, axis=1)  # what goes along the axis makes no chip
    chips = way.feed * across * 2.0 * math.pi / (way.spindle * flutes)
    for k in np.flatnonzero(way.cuts):
        for low, high, z_lo, z_hi in patches[k]:
            local[k] += wall_force(AVERAGED, 0.0, 0.0, low, high, z_lo, z_hi, chips[k], 0.0, mill, none, cutting)
    ahead /= np.maximum(across, 1e-300)[:, None]
    force = local[:, :1] * ahead + local[:, 1:2] * np.cross(upward, ahead) + local[:, 2:] * upward
    return CutForce(force, np.where(way.cuts, immersion(patches), 0.0), chips)


def _patches(scenario: MachineScenario, cut: FromCutting, way: ToolPath, at: Frames) -> FloatArray:
    """Contact at every place: with the stock that the program has left, or along a wall."""
    radius, tool = 0.5 * scenario.tool.diameter, at.rotations[:, -1]
    steady = bool(np.abs(tool[..., 2] - tool[0, :, 2]).max() < _STEADY)
    if scenario.stock is not None:
        return _stock_patches(scenario, way, steady and bool(np.abs(tool[0, :, 2] - [0.0, 0.0, 1.0]).max() < _STEADY))
    assert cut.axial_depth is not None
    if cut.radial_depth is None:
        return wall_patches(np.full(len(way.travel), math.pi), cut.axial_depth)
    if way.curve is None or not steady:
        return wall_patches(np.full(len(way.travel), straight_immersion(cut.radial_depth, radius)), cut.axial_depth)
    seen = carried(way.curve, tool[0].T, np.zeros(3))  # by the tool, which looks along its own axis
    arcs = path_contact(seen, way.curve_cuts, way.block, way.along, radius, cut.radial_depth)
    return wall_patches(arcs, cut.axial_depth)


def _stock_patches(scenario: MachineScenario, way: ToolPath, upright: bool) -> FloatArray:
    if way.curve is None or not upright:
        message = "is cut by a tool that stands upright on the part; leave it out, and write load.force.axial_depth"
        raise ScenarioFault([Fault(("stock",), message)])
    assert scenario.stock is not None
    assert scenario.program is not None
    swept = swept_path(way.curve, 0.5 * scenario.tool.diameter)
    heading = np.arctan2(way.direction[:, 1], way.direction[:, 0])
    return contact_patches(way.point, heading, way.along, swept, stock_of(scenario.stock, scenario.program.zero))
