"""A pass on a machine tool, twice: ideal, and under forces, weights and geometric errors (Demeč, Madáč, Eqs. 1-9)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.maths import chains
from cutwise.maths.chains import Frames
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion import volumetric
from cutwise.physics.motion.volumetric import Axes
from cutwise.physics.structure import bodies
from cutwise.physics.structure.beams import Section, cantilever
from cutwise.physics.structure.bodies import Elements, Loads, PartBlock
from cutwise.physics.structure.pads import ContactPads, NoEquilibriumError, PadLostError, contact_equilibrium
from cutwise.process.carried import ArmAlong
from cutwise.process.machine_force import CutForce
from cutwise.process.machine_path import ToolPath
from cutwise.results import Infeasible, Place, SolverFailure
from cutwise.spec.base import known


class ElasticElement(NamedTuple):
    """A spring between two bodies, written in the frame that it travels with."""

    name: str
    joint: int  # between body joint - 1 and body joint
    frame: int  # body that carries the element's point
    point: FloatArray  # [m] in that frame, shape (3,)
    compliance: FloatArray  # linear compliance at the point, in that frame's axes, shape (6, 6)
    contact: ContactPads | None  # the contact law instead of the linear compliance


class Weight(NamedTuple):
    """A force that keeps its direction in the ground's frame."""

    body: int
    force: FloatArray  # [N] in the ground's axes, shape (3,)
    point: FloatArray  # [m] in the body's frame, shape (3,)


class FlexiblePart(NamedTuple):
    """The part as a block standing on z = 0 of its frame."""

    section: Section
    youngs_modulus: float  # [Pa]
    shear_modulus: float  # [Pa]


class SpringPart(NamedTuple):
    """The part as one spring off its wall, wherever it stands."""

    normal: FloatArray  # of the wall at the places of the pass, from the part to the tool, shape (m, 3)
    stiffness: float  # [N/m]


class MachineCell(NamedTuple):
    """A machine, what acts on it, and the pass that it makes."""

    names: tuple[str, ...]  # of bodies 0 ... n
    axes: Axes
    ground: int
    tip: FloatArray  # [m] tool point in the last frame, shape (3,)
    elements: tuple[ElasticElement, ...]
    weights: tuple[Weight, ...]
    part: FlexiblePart | SpringPart | None
    way: ToolPath
    cut: CutForce
    literal: bool  # errors of table-side bodies added as Eq. (2) reads; not physical
    feed_moment: bool  # False drops the moment of x forces on the part side; not physical
    arm: ArmAlong | None = None  # of a robot: its postures at the places of the pass, each once


class MachineRun(NamedTuple):
    """A finished pass; errors are of the tool point against the part, in frame 0, unless said otherwise."""

    cell: MachineCell
    at: Frames
    ideal: FloatArray  # r_0 [m], shape (m, 3)
    reach: FloatArray  # r_i [m], shape (m, n + 1, 3)
    twists: FloatArray  # all errors as twists of the chain bodies [m, rad], shape (m, n + 1, 6)
    geometric: FloatArray  # the share of geometric errors in them, same shape
    local: FloatArray  # f1_i [m], in the body's frame, shape (m, n + 1, 3)
    body: FloatArray  # f2_i [m], and f3 at index 0, shape (m, n + 1, 3)
    deviation: FloatArray  # Delta = f4 [m], shape (m, 3)
    exact: FloatArray  # the same by exact composition [m], shape (m, 3)
    rotation: FloatArray  # error of the tool's direction [rad], shape (m, 3)
    element_names: tuple[str, ...]  # "part" first if it is flexible
    contributions: FloatArray  # of each element [m], shape (m, e, 3)
    external: FloatArray  # sum of f_k . u_k [J], shape (m,)
    internal: FloatArray  # sum of W . xi [J], shape (m,)

    @property
    def size(self) -> FloatArray:
        """|Delta| [m], shape (m,)."""
        return np.linalg.norm(self.deviation, axis=1)

    @property
    def counted(self) -> npt.NDArray[np.bool_]:
        """Rows that count: those of the cut, or all if nothing cuts; shape (m,)."""
        cuts = self.cell.way.cuts
        return cuts if cuts.any() else np.ones_like(cuts)

    @property
    def worst(self) -> int:
        """Row of the largest |Delta| of those that count; the first of equals."""
        return int(np.argmax(np.where(self.counted, self.size, -1.0)))


def run_pass(cell: MachineCell) -> MachineRun:
    """Ideal pass, loads, twists of all bodies, and their sum at the tool point."""
    at = chains.frames(cell.axes.chain, cell.way.commands * cell.axes.sense)
    ideal = chains.tool_point(at, cell.tip)
    elements, loads = placed_elements(cell.elements, cell.ground, at), _loads(cell, at, ideal)
    wrenches = bodies.element_wrenches(elements, loads, feed_moment=cell.feed_moment)
    yielded = bodies.element_twists(elements, wrenches)
    for e, element in enumerate(cell.elements):
        if element.contact is not None:
            yielded[:, e] = _contact_twists(element, at, wrenches[:, e], ideal)
    geometric = volumetric.chain_errors(cell.axes, at, cell.way.commands)
    elastic = bodies.chain_twists(elements, yielded, at, literal=cell.literal)
    moved, work = _part_displacement(cell, ideal)
    elastic[:, 0, :3] += moved if cell.literal else -moved
    twists = elastic + geometric.twists
    contributions = bodies.contributions(elements, yielded, ideal, literal=cell.literal)
    names = tuple(element.name for element in cell.elements)
    if cell.part is not None:
        contributions = np.concatenate([twists[:, :1, :3], contributions], axis=1)
        names = ("part", *names)
    displaced = bodies.load_displacements(elements, yielded, loads)
    displaced[:, 1] += moved
    return MachineRun(
        cell,
        at,
        ideal,
        chains.tool_vectors(at, cell.tip),
        twists,
        geometric.twists,
        chains.local_errors(at, twists, cell.tip),
        chains.body_errors(at, twists, cell.tip),
        chains.linear_error(at, twists, cell.tip),
        chains.exact_error(at, geometric.carried, cell.tip, geometric.own, elastic),
        np.einsum("mbij,mbj->mi", at.rotations, twists[..., 3:]),
        names,
        contributions,
        bodies.external_work(loads, displaced),
        bodies.strain_work(wrenches, yielded) + work,
    )


def energy_balance(run: MachineRun) -> float | None:
    """Largest relative residual of Clapeyron's balance over the pass; None where it does not hold.

    It holds for linear elements with physical signs; geometric errors take part in no balance, and are not in it.
    """
    cell = run.cell
    if cell.literal or not cell.feed_moment or any(element.contact is not None for element in cell.elements):
        return None
    loaded = run.internal > 0.0
    if not loaded.any():
        return None
    return float(bodies.energy_residual(run.external[loaded], run.internal[loaded]).max())


def placed_elements(elements: Sequence[ElasticElement], ground: int, at: Frames) -> Elements:
    """Elements seen from frame 0 in every posture."""
    count = len(elements)
    frame = np.array([element.frame for element in elements], dtype=np.int64)
    point = np.array([element.point for element in elements]).reshape(count, 3)
    compliance = np.array([element.compliance for element in elements]).reshape(count, 6, 6)
    joint = np.array([element.joint for element in elements], dtype=np.int64)
    return Elements(joint, ground, *bodies.place(at, frame, point, compliance))


def _loads(cell: MachineCell, at: Frames, tool: FloatArray) -> Loads:
    # the cutting force on the last body and its reaction on the part come first
    upright = at.rotations[:, cell.ground]
    last = len(cell.names) - 1
    body, force, point = [last, 0], [cell.cut.force, -cell.cut.force], [tool, tool]
    for weight in cell.weights:
        body.append(weight.body)
        force.append(upright @ weight.force)
        point.append(at.origins[:, weight.body] + at.rotations[:, weight.body] @ weight.point)
    return Loads(np.array(body), np.stack(force, axis=1), np.stack(point, axis=1))


def _part_displacement(cell: MachineCell, tool: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Displacement of the material under the tool [m] and the work in the part [J]."""
    if cell.part is None:
        return np.zeros_like(tool), np.zeros(len(tool))
    if isinstance(cell.part, SpringPart):
        pushed = np.einsum("mi,mi->m", cell.cut.force, cell.part.normal)
        yielded = pushed / cell.part.stiffness
        return -yielded[:, None] * cell.part.normal, pushed * yielded
    block = block_under(cell.part, tool)
    wrench, twist = bodies.part_twist(block, cell.cut.force, tool)
    return bodies.point_displacement(block.point, twist, tool), np.einsum("mi,mi->m", wrench, twist)


def block_under(part: FlexiblePart, tool: FloatArray) -> PartBlock:
    """The part up to the height of each tool point, shape (m, 3)."""
    heights, inverse = np.unique(tool[:, 2], return_inverse=True)
    rigid = np.zeros((6, 6))  # the block does not bend below its foot
    blocks = np.array(
        [cantilever(part.section, h, part.youngs_modulus, part.shear_modulus) if h > 0.0 else rigid for h in heights]
    )
    return PartBlock(tool * [0.0, 0.0, 1.0], blocks[inverse])  # on the axis of the block


def _contact_twists(element: ElasticElement, at: Frames, wrenches: FloatArray, tool: FloatArray) -> FloatArray:
    turned = np.empty_like(wrenches)
    for k, wrench in enumerate(wrenches):
        rotation = at.rotations[k, element.frame]
        local = np.concatenate([rotation.T @ wrench[:3], rotation.T @ wrench[3:]])
        try:
            twist = contact_equilibrium(known(element.contact), local)[0]
        except PadLostError as error:
            where = ", ".join(units.show(float(value), "length", 4) for value in tool[k])
            raise Infeasible(
                f"{element.name}: {error} (tool point at {where} in the part)", "gives_way", Place(element.name)
            ) from None
        except NoEquilibriumError as error:
            raise SolverFailure(f"{element.name}: {error}") from None
        turned[k] = np.concatenate([rotation @ twist[:3], rotation @ twist[3:]])
    return turned
