"""How the bodies of a machine yield under the tool along a path: the sum of their elements in process axes."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.maths import chains
from cutwise.maths.frames import FloatArray
from cutwise.paths.carried import CarriedPath
from cutwise.physics.motion.setpoints import DependentAxesError, setpoints
from cutwise.physics.structure.series_compliance import carried_to, chain_compliance, in_axes, translation_at
from cutwise.process.machine_assemble import axes_of, elements_of, part_block
from cutwise.process.machine_pass import block_under, placed_elements
from cutwise.process.machine_path import beyond_travel
from cutwise.results import Finding, warned
from cutwise.spec.faults import Fault, Path, ScenarioFault
from cutwise.spec.machine import Machine
from cutwise.spec.part_block import PartBlock

_ASIDE = 1e-6  # sine of the angle between the axis of the tool and that of the spindle


class BodiesAlong(NamedTuple):
    """The bodies of a machine along a path."""

    names: tuple[str, ...]  # of the elements; "part" last if it bends
    each: FloatArray  # compliance of each at the tool point, process axes, shape (e, n, 6, 6)
    origins: FloatArray  # [m] of the frames of the bodies, in the part, shape (n, bodies, 3)

    @property
    def total(self) -> FloatArray:
        """All of them together, shape (n, 6, 6)."""
        carried = np.moveaxis(self.each, 0, 1)
        return chain_compliance(carried, np.zeros((*carried.shape[:2], 3)))


def tool_point_at_zero(machine: Machine, tip: FloatArray) -> FloatArray:
    """Where the tool point is in the part with all axes at zero [m], shape (3,)."""
    axes = axes_of(machine, {})
    return np.asarray(chains.tool_point(chains.frames(axes.chain, np.zeros((1, len(axes.errors)))), tip))[0]


def bodies_along(
    machine: Machine, part: PartBlock | None, tip: FloatArray, path: CarriedPath, key: Path = ("path", "line"),
    axis: Path = ("path", "tool_axis"),
) -> BodiesAlong:  # fmt: skip
    r"""Compliance of the elements of a machine at its tool point along a path in the part.

    .. math:: \sum_e X_e^T C_e X_e, \qquad X_e = [I, 0; S(p - c_e), I]

    What is on the part's side is pushed the other way by the reaction, so that tool against part it adds; the part
    itself does likewise.

    Parameters
    ----------
    tip : array (3,)
        Tool point in the frame of the last body [m].
    path : CarriedPath
        Stations in the frame of the part.
    key, axis : path
        Of the scenario, which say where the tool goes and how it stands; for messages.

    Raises
    ------
    ScenarioFault
        The path leads an axis beyond its travel, the tool does not stand as the spindle does, or the axes do not span
        space.
    """
    axes = axes_of(machine, {})
    try:
        commands = setpoints(axes, tip, path.point, np.zeros((len(path.at), len(axes.errors))))
    except DependentAxesError as error:
        raise ScenarioFault([Fault(("machine", "chain"), f"cannot follow a path: {error}")]) from None
    faults = [Fault(key, said) for _, said in beyond_travel(machine, axes, commands, "shift the part")]
    if faults:
        raise ScenarioFault(faults)
    at = chains.frames(axes.chain, commands * axes.sense)
    aside = np.linalg.norm(np.cross(at.rotations[:, -1, :, 2], path.tool_axis), axis=1)
    if aside.max() > _ASIDE:
        shown = ", ".join(f"{x:.3g}" for x in -at.rotations[0, -1, :, 2] + 0.0)
        raise ScenarioFault([Fault(axis, f"the spindle of this machine points along [{shown}]; write that")])
    given = elements_of(machine)
    placed = placed_elements(given, machine.ground, at)
    each = carried_to(placed.compliance, path.point[:, None] - placed.point)
    names = [element.name for element in given]
    block = part_block(part)
    if block is not None:
        under = block_under(block, path.point)
        each = np.concatenate([each, carried_to(under.compliance, path.point - under.point)[:, None]], axis=1)
        names.append("part")
    turned = in_axes(each, path.axes[:, None])
    return BodiesAlong(tuple(names), np.moveaxis(turned, 1, 0), at.origins)


def parts_along(
    bodies: BodiesAlong, at: FloatArray, along: float, height: float, moved: FloatArray
) -> dict[str, float]:
    """What each body gives off the work at a place [m], by name, where all together move the tool by ``moved`` (3,) [m].

    At a height over the tip [m]; the force is the one that gives this displacement. ``at``: stations [m].
    """
    matrices = translation_at(_between(at, bodies.each, along), height)
    force = np.linalg.lstsq(matrices.sum(axis=0), moved, rcond=None)[0]
    return {name: float((one @ force)[1]) for name, one in zip(bodies.names, matrices, strict=True)}


def _between(at: FloatArray, matrices: FloatArray, along: float) -> FloatArray:
    """Matrices of stations (e, n, 6, 6), straight between them."""
    after = min(max(int(np.searchsorted(at, along)), 1), len(at) - 1)
    share = (along - at[after - 1]) / (at[after] - at[after - 1])
    return np.asarray((1.0 - share) * matrices[:, after - 1] + share * matrices[:, after])


def off_part(part: PartBlock, at: FloatArray, reach: float) -> Iterator[Finding]:
    """What to say where tool points (m, 3) of the cut are not on the part, or beside it by more than a reach [m]."""
    if at[:, 2].max() > part.height * (1 + 1e-9) or at[:, 2].min() < 0.0:
        low, high = (units.show(float(end), "length") for end in (at[:, 2].min(), at[:, 2].max()))
        yield warned("off_part", f"the tool point cuts at z = {low} to {high}, but the part stands from 0 to "
                     f"{units.show(part.height, 'length')}", float(at[:, 2].max()), part.height, "length")  # fmt: skip
    if (np.abs(at[:, :2]) > 0.5 * np.array([part.width_x, part.width_y]) + reach).any():
        yield warned("off_part", "the tool point leaves the part by more than the radius of the tool while it cuts")
