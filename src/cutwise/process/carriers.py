"""What carries a tool, told the same for every process: postures and bodies station by station, and whose fault it is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from cutwise import units
from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.physics.structure.series_compliance import translation_at
from cutwise.process.labels import Column, Group, Over, labelled
from cutwise.spec.carrier import CarryingRobot

if TYPE_CHECKING:
    import xarray as xr

    from cutwise.process import chain_compliance
    from cutwise.process.carriage import Carriage
    from cutwise.process.carried import ArmAlong
else:
    chain_compliance = later("cutwise.process.chain_compliance")

_STATION = "s_station"


def deflections(moved: Mapping[str, FloatArray], read: str, along: str, over: Over) -> Group:
    """The displacement by each term, (n, 3) [m], where something (an edge, a wall) is read; ``along`` a dimension."""
    columns = {
        f"deflection_{name}": Column(f"{along} axis", partial(_same, value), "m",
                                     f"displacement by the term {name} where {read} is read")
        for name, value in moved.items()
    }  # fmt: skip
    return Group(columns, over)


def _same(value: FloatArray, _: object) -> FloatArray:
    return value


def postures(robot: CarryingRobot, arms: Sequence[ArmAlong], where: str = "place along the path") -> xr.Dataset:
    """Angles and compliance of a robot station by station, all paths one after another."""
    ends = np.concatenate([[0.0], np.cumsum([arm.path.at[-1] for arm in arms])])
    at = np.concatenate([start + arm.path.at for start, arm in zip(ends[:-1], arms, strict=True)])
    matrix = np.concatenate([arm.joints + arm.base for arm in arms])
    joints = [joint.name or str(n) for n, joint in enumerate(robot.joints, 1)]
    return labelled((_STATION, at, "m", where), {
        "joint_angles": (np.concatenate([arm.postures.q for arm in arms]), "rad", "angles of the joints"),
        "redundancy_angle": (
            np.concatenate([arm.postures.angle for arm in arms]), "rad", "angle of the tool about its axis"
        ),
        "compliance_off_work": (matrix[:, 1, 1], "m/N", "compliance off the work, across the tool"),
        "compliance_rod": (matrix[:, 2, 2], "m/N", "compliance along the tool"),
    }, joint=joints)  # fmt: skip


def bodies(carriage: Carriage, height: float, moved: FloatArray) -> xr.Dataset:
    """The bodies of a machine one by one, at a height over the tip [m]; ``moved`` (n, 3): by all, at the stations [m]."""
    each, path = carriage.bodies, carriage.path
    assert each is not None
    assert path is not None
    parts = [
        list(chain_compliance.parts_along(each, path.at, float(s), height, u).values())
        for s, u in zip(path.at, moved, strict=True)
    ]
    return labelled((_STATION, path.at, "m", "place along the path"), {
        "compliance": (translation_at(each.each, height)[:, :, 1, 1].T, "m/N", "compliance off the work of each"),
        "deflection": (np.array(parts), "m", "displacement off the work by each under the force of the cut there"),
    }, element=list(each.names))  # fmt: skip


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
