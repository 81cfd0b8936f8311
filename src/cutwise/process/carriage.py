"""What carries a tool along a path, a robot or the bodies of a machine, and everything that yields with it in series."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.paths.carried import CarriedPath
from cutwise.physics.structure.terms import Compliance
from cutwise.process import carried
from cutwise.process.yielding import Bending, spring, tip_of
from cutwise.spec.base import known
from cutwise.spec.carrier import CarriedPath as PathSpec
from cutwise.spec.carrier import CarryingRobot, Standing
from cutwise.spec.chained import CarryingMachine
from cutwise.spec.drives import CncMachine
from cutwise.spec.faults import Path
from cutwise.spec.milling_machine import MillingMachine, bodies_of
from cutwise.spec.part_block import PartBlock

if TYPE_CHECKING:
    from cutwise.process import chain_compliance
else:
    chain_compliance = later("cutwise.process.chain_compliance")

Terms = tuple[tuple[str, NamedTuple], ...]


class Carriage(NamedTuple):
    """What carries a tool along a path; nothing at all for a tool that is led as programmed."""

    terms: Terms = ()  # what it yields by, from the tool on
    arm: "carried.ArmAlong | None" = None
    bodies: "chain_compliance.BodiesAlong | None" = None
    path: CarriedPath | None = (
        None  # whose axes are those of the process in those of the modes of the tool; None: the same
    )


def by_robot(robot: CarryingRobot, along: "carried.ArmAlong", height: float) -> Carriage:
    """A robot in its postures along a path; the surface is read at a height over the tip [m]."""
    return Carriage(carried.terms_of(robot, along, height), arm=along)


def by_machine(
    machine: CarryingMachine, block: PartBlock | None, path: CarriedPath, key: Path = ("path", "line"),
    axis: Path = ("path", "tool_axis"),
) -> Carriage:  # fmt: skip
    """The bodies of a machine along a path in the part; modes of a tool lie along x and y of the machine."""
    bodies = chain_compliance.bodies_along(machine, block, np.array(machine.tip), path, key, axis)
    return Carriage((("bodies", Compliance(path.at, np.ascontiguousarray(bodies.total))),), bodies=bodies, path=path)


class Led(Protocol):
    """What a scenario says of a path along its part, and of what carries a tool along it."""

    @property
    def robot(self) -> CarryingRobot | None:
        """That carries the tool."""

    @property
    def machine(self) -> CncMachine | MillingMachine | None:
        """That carries the tool."""

    @property
    def block(self) -> PartBlock | None:
        """Under the tool, on the machine."""

    @property
    def placement(self) -> Standing | None:
        """Of the part, before the robot."""

    @property
    def operation(self) -> Any:
        """With ``milling``, ``limit_feed``."""

    @property
    def numerics(self) -> Any:
        """With ``station`` [m], ``mode``."""


def stations_of(scenario: Led, path: PathSpec, standing: Standing | None = None) -> CarriedPath:
    """The stations of a path in the frame of what carries the tool, where the part stands, or stands as told."""
    return carried.path_in_base(
        path, standing or scenario.placement or Standing(), scenario.numerics.station,
        work_on_left=scenario.operation.milling == "up",
    )  # fmt: skip


def carrying(
    scenario: Led, path: CarriedPath | None, rigid: Callable[[], FloatArray], height: float, feed: float
) -> Carriage:
    """What carries a tool along a path as a scenario says it: a robot, the bodies of a machine, or nothing that yields.

    A robot takes the postures that suit the wrench (6,) of the rigid cut about the tip, process axes [N, N m], at a feed
    [m/s]; the surface is read at a height over the tip [m]. At rest a robot answers by its stiffness alone.
    """
    robot = scenario.robot
    if robot is not None:
        along = carried.arm_along(
            robot, known(path), rigid(), height, feed, limited=scenario.operation.limit_feed
        )  # fmt: skip
        still = scenario.numerics.mode == "still"
        return by_robot(robot.model_copy(update={"dynamics": "static"}) if still else robot, along, height)
    return on_machine(scenario, path)


def on_machine(scenario: Led, path: CarriedPath | None) -> Carriage:
    """The bodies of the machine of a scenario along a path; drives alone do not yield."""
    machine = bodies_of(scenario.machine)
    return Carriage() if machine is None else by_machine(machine, scenario.block, known(path))


def in_series(tool: Bending | None, carriage: Carriage, part: Compliance | None = None) -> Terms:
    """All terms without memory from the tool to the part."""
    tip = None if tool is None else tip_of(tool, carriage.path)
    ends: tuple[Terms, Terms] = (
        () if tip is None else (("tip", tip),), () if part is None else (("part_stiffness", part),)
    )  # fmt: skip
    return (*ends[0], *carriage.terms, *ends[1])


def off_surface(
    stiffness: float | None, at: FloatArray | None = None, normal: FloatArray | None = None
) -> Compliance | None:
    r"""A part that yields off its surface: :math:`n n^T / k` with k [N/m], along y, or along normals (m, 3) at places (m,)."""
    if stiffness is None:
        return None
    if at is None or normal is None:
        return spring({1: stiffness})
    matrix = np.zeros((len(at), 6, 6))
    matrix[:, :3, :3] = np.einsum("ni,nj->nij", normal, normal) / stiffness
    return Compliance(at, matrix)
