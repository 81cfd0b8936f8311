"""What carries a tool, told the same for every process: postures and bodies station by station, and whose fault it is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from cutwise import units
from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.physics.structure.series_compliance import translation_at
from cutwise.process import carried, yielding
from cutwise.process.labels import Column, Group, Over, labelled
from cutwise.process.posture import posture_frames
from cutwise.process.postures import Arm
from cutwise.results import Finding
from cutwise.spec.carrier import CarryingRobot
from cutwise.spec.part_block import PartBlock
from cutwise.spec.uncertain import Fitted

if TYPE_CHECKING:
    import xarray as xr

    from cutwise.process import chain_compliance
    from cutwise.process.carriage import Carriage, Terms
    from cutwise.process.carried import ArmAlong
    from cutwise.process.chain_compliance import BodiesAlong
else:
    chain_compliance = later("cutwise.process.chain_compliance")

_STATION = "s_station"


def deflections(
    moved: Mapping[str, FloatArray], read: str, along: str, over: Over,
    text: str = "displacement by the term {name} where {read} is read",
) -> Group:  # fmt: skip
    """The displacement by each term, (n, 3) [m], where something (an edge, a wall) is read; ``along`` a dimension."""
    columns = {
        f"deflection_{name}": Column(f"{along} axis", partial(_same, value), "m", text.format(name=name, read=read))
        for name, value in moved.items()
    }
    return Group(columns, over)


def _same(value: FloatArray, _: object) -> FloatArray:
    return value


def _standing_there(
    told: xr.Dataset, tip: FloatArray, name: str, over: str, points: FloatArray, text: str
) -> xr.Dataset:
    """Group ``carrier`` with where the carrier is at the stations: tool point (n, 3), its points (n, k, 3) [m]."""
    seen = {"tool_point": ((_STATION, "axis"), tip, {"units": "m", "long_name": f"tool point in the {text}"}),
            name: ((_STATION, over, "axis"), points, {"units": "m", "long_name": f"{_SEEN[name]} in the {text}"})}  # fmt: skip
    return told.assign(seen).assign_coords(axis=list("xyz"))


_SEEN = {"arm": "base, joints and tool tip", "body_origin": "origins of the bodies"}


def points_of(arm: Arm, q: FloatArray) -> FloatArray:
    """Base, joints and tool tip of an arm in postures (n, 6), in the base frame [m], shape (n, points, 3)."""
    at = posture_frames(arm, q)
    tip = at.origins[:, -1] + at.rotations[:, -1] @ arm.tool_tip
    return np.concatenate([at.origins, tip[:, None]], axis=1)


def bodies_there(told: xr.Dataset, each: Sequence[tuple[BodiesAlong, FloatArray]]) -> xr.Dataset:
    """Group ``carrier`` with where the bodies of a machine are at the stations of paths, whose tool points (n, 3) go with
    them [m].
    """
    tip, origins = np.concatenate([tip for _, tip in each]), np.concatenate([one.origins for one, _ in each])
    return _standing_there(told, tip, "body_origin", "body", origins, "part")


def postures(robot: CarryingRobot, arms: Sequence[ArmAlong], where: str = "place along the path") -> xr.Dataset:
    """Angles and compliance of a robot station by station, all paths one after another."""
    ends = np.concatenate([[0.0], np.cumsum([arm.path.at[-1] for arm in arms])])
    at = np.concatenate([start + arm.path.at for start, arm in zip(ends[:-1], arms, strict=True)])
    matrix = np.concatenate([arm.joints + arm.base for arm in arms])
    joints = [joint.name or str(n) for n, joint in enumerate(robot.joints, 1)]
    told = labelled((_STATION, at, "m", where), {
        "joint_angles": (np.concatenate([arm.postures.q for arm in arms]), "rad", "angles of the joints"),
        "redundancy_angle": (
            np.concatenate([arm.postures.angle for arm in arms]), "rad", "angle of the tool about its axis"
        ),
        "compliance_off_work": (matrix[:, 1, 1], "m/N", "compliance off the work, across the tool"),
        "compliance_rod": (matrix[:, 2, 2], "m/N", "compliance along the tool"),
    }, joint=joints)  # fmt: skip
    points = np.concatenate([points_of(arm.arm, arm.postures.q) for arm in arms])
    return _standing_there(told, points[:, -1], "arm", "point", points, "base frame")


def bodies(carriage: Carriage, height: float, moved: FloatArray) -> xr.Dataset:
    """The bodies of a machine one by one, at a height over the tip [m]; ``moved`` (n, 3): by all, at the stations [m]."""
    each, path = carriage.bodies, carriage.path
    assert each is not None
    assert path is not None
    parts = [
        list(chain_compliance.parts_along(each, path.at, float(s), height, u).values())
        for s, u in zip(path.at, moved, strict=True)
    ]
    told = labelled((_STATION, path.at, "m", "place along the path"), {
        "compliance": (translation_at(each.each, height)[:, :, 1, 1].T, "m/N", "compliance off the work of each"),
        "deflection": (np.array(parts), "m", "displacement off the work by each under the force of the cut there"),
    }, element=list(each.names))  # fmt: skip
    return bodies_there(told, [(each, path.point)])


def along(at: FloatArray, moved: FloatArray, stations: FloatArray) -> FloatArray:
    """Displacements (n, 3) at rising places ``at`` (n,), at the stations."""
    return np.column_stack([np.interp(stations, at, one) for one in moved.T])


def of_carrier(
    carriage: Carriage, robot: CarryingRobot | None, height: float, at: FloatArray, moved: Mapping[str, FloatArray]
) -> dict[str, xr.Dataset]:
    """Group ``carrier`` of a run: postures of its robot, or the bodies of its machine; nothing without one.

    ``moved``: displacement by each term (n, 3) [m] at rising places ``at`` (n,) of the path [m], at a height [m].
    """
    if carriage.arm is not None and robot is not None:
        return {"carrier": postures(robot, [carriage.arm])}
    if carriage.bodies is not None and carriage.path is not None:
        return {"carrier": bodies(carriage, height, along(at, moved["bodies"], carriage.path.at))}
    return {}


class Said(Protocol):
    """What a scenario says of its tool and of what carries it."""

    @property
    def robot(self) -> CarryingRobot | None:
        """That carries the tool."""

    @property
    def measured(self) -> Mapping[str, Fitted]:
        """What calibrations say."""

    @property
    def tool(self) -> Any:
        """With a diameter [m], where it stands over a block."""


def warnings(
    scenario: Said, carried_by: Iterable[Carriage], block: PartBlock | None = None
) -> Iterator[Finding]:  # fmt: skip
    """What to know of the robot that carries a tool along its paths; that a path on a machine is not on its block."""
    each = list(carried_by)
    if scenario.robot is not None:
        arms = [one.arm for one in each if one.arm is not None]
        yield from carried.warnings(scenario.robot, arms, scenario.measured.get("robot"))
    for one in each:
        if block is not None and one.path is not None:
            yield from chain_compliance.off_part(block, one.path.point, 0.5 * scenario.tool.diameter)


def measures(
    scenario: Said, carriage: Carriage, terms: Terms, feed: float, *, limited: bool = False
) -> dict[str, float]:
    """How stiff and how quick is what carries a tool: by its postures, or by all that yields with a machine.

    ``limited``: the feed [m/s] is lowered where the joints cannot follow it.
    """
    each = [term for _, term in terms]
    found = yielding.lowest_frequency(each)
    if carriage.arm is None or scenario.robot is None:
        return found | yielding.normal_stiffness(each)
    return found | carried.measures(carriage.arm, scenario.robot, feed, limited=limited)


def in_order(parts: Mapping[str, float]) -> str:
    """Bodies with what each gives off the work [m], the largest first; positive is into the part."""
    largest = sorted(parts.items(), key=lambda item: -abs(item[1]))
    return ", ".join(f"{name} {units.show(-value, 'small_length', 4)}" for name, value in largest)


def shares(moved: Mapping[str, FloatArray], row: int, *, into: bool = False) -> str:
    """What each term gives off the work in a row, in words; ``into``: positive is into the part."""
    sign = -1.0 if into else 1.0
    each = {name: sign * float(value[row, 1]) for name, value in moved.items()}
    return ", ".join(f"{name} {units.show(value, 'small_length', 4)}" for name, value in each.items())


def notes(
    carriage: Carriage, height: float, place: float, moved: Mapping[str, FloatArray], row: int
) -> dict[str, str]:  # fmt: skip
    """Which body has how much of the error in a row, at a place of the path [m]; what another angle of the tool brings."""
    said = redundancy([carriage.arm] if carriage.arm is not None else [])
    if carriage.bodies is not None and carriage.path is not None:
        here = moved["bodies"][row]
        each = chain_compliance.parts_along(carriage.bodies, carriage.path.at, place, height, here)
        said["bodies"] = f"Of the bodies there: {in_order(each)} (positive is into the part)."
    return said


def redundancy(arms: Sequence[ArmAlong]) -> dict[str, str]:
    """What turning the tool on the way would bring, where one angle leads all along."""
    known = [arm for arm in arms if math.isfinite(arm.constant) and math.isfinite(arm.turned)]
    constant, turned = (sum(getattr(arm, name) for arm in known) for name in ("constant", "turned"))
    if not known or turned >= constant * (1 - 1e-6):
        return {}
    return {
        "redundancy": f"With robot.redundancy_angle: along_path the arm would yield by {turned / len(known) * 1e6:.4g} µm on "
        f"average under the rigid cut, with the best single angle by {constant / len(known) * 1e6:.4g} µm."
    }
