"""A robot that mills a shoulder or a slot: what it yields by at rest, and the depth at which it chatters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.loop import Cell
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.flutes import TurnFlutes
from cutwise.physics.cutting.regeneration import (
    DepthLimit,
    Receptance,
    depth_limit,
    mean_directions,
    swinging_receptance,
)
from cutwise.physics.cutting.uneven import largest_radius, tangent_coefficients
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.shoulder import SEEN, Shoulder, Slot
from cutwise.physics.structure.series_compliance import translation_at
from cutwise.physics.structure.terms import (
    Compliance,
    Rigid,
    Swinging,
    in_series,
    relaxed,
    swinging,
    width,
)
from cutwise.process import carried, yielding
from cutwise.process.edges import edges
from cutwise.process.labels import labelled
from cutwise.results import Finding, Place, SolverFailure
from cutwise.spec.carrier import Standing
from cutwise.spec.milling import MillingScenario
from cutwise.spec.notices import notices
from cutwise.still import Rest, rest

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

HIGHEST = 800.0  # [Hz] up to which the limit of chatter is looked for
_MODES_HIGHEST = 1.3  # of the highest tip mode, where the tool has modes

LIMITS = (
    "at rest: the mean force of the cut displaces the arm; ripple of the teeth and drives of the robot are left out",
    "links are rigid, joints linear; backlash and the control of the joints are left out",
    "the limit of chatter takes the mean directions of the cut and one swinging mass for the arm",
)


class ArmMilling(NamedTuple):
    """A finished pass of a robot that mills."""

    along: carried.ArmAlong
    terms: tuple[tuple[str, Compliance], ...]
    at_rest: Rest
    height: float  # [m] over the tip, where the wall is read
    limits: tuple[DepthLimit, ...]  # of chatter, at some stations
    limit_at: FloatArray  # [m] of the path, where these are
    force: FloatArray  # mean force on the tool [N], shape (n, 3)


def _is_slot(scenario: MillingScenario) -> bool:
    radial = scenario.operation.radial_depth
    assert radial is not None
    return radial >= scenario.tool.diameter * (1.0 - 1e-12)


def _cutting(scenario: MillingScenario) -> tuple[Round, TurnFlutes]:
    tool, operation = scenario.tool, scenario.operation
    speed = operation.spindle_speed
    assert speed is not None
    up = operation.milling == "up"
    mill = Mill(0.5 * tool.diameter, tool.flutes, tool.helix)
    return Round(mill.radius, mill.flutes, speed), TurnFlutes(mill, edges(scenario.material, tool), up)


def _cell(scenario: MillingScenario, structure: NamedTuple) -> Cell:
    mill, flutes = _cutting(scenario)
    depth = scenario.operation.axial_depth
    engagement = Slot(mill, depth) if _is_slot(scenario) else Shoulder(mill, depth)
    return Cell((), engagement, (), flutes, structure)


def _poses(scenario: MillingScenario, at: FloatArray, sag_y: FloatArray, sag_z: FloatArray) -> FloatArray:
    """The programmed tool at the stations, moved by the sag of the arm."""
    poses = np.zeros((len(at), 8))
    poses[:, 1] = poses[:, 2] = at
    poses[:, 3] = -scenario.operation.radial_depth + sag_y
    poses[:, 4] = sag_z
    poses[:, 5] = scenario.operation.feed
    return poses


def path_of(scenario: MillingScenario) -> carried.CarriedPath:
    """The stations of the path in the base frame."""
    return carried.path_in_base(
        scenario.path, scenario.placement or Standing(), scenario.numerics.station,
        work_on_left=scenario.operation.milling == "up",
    )  # fmt: skip


def prepare(scenario: MillingScenario) -> carried.ArmAlong:
    """The postures of the robot: what a check finds out without the cut."""
    assert scenario.robot is not None
    path = path_of(scenario)
    height = 0.5 * scenario.operation.axial_depth
    firm = Rigid(0.0)
    still = rest(
        _cell(scenario, firm),
        relaxed(firm),
        _poses(scenario, path.at[:1], np.zeros(1), np.zeros(1)),
        seen=SEEN,
        state=0,
    )
    return carried.arm_along(scenario.robot, path, _wrench(still.total[0, :3], height), height, scenario.operation.feed)


def _wrench(force: FloatArray, height: float) -> FloatArray:
    """Force at a height over the tip, with its moment about the tip."""
    return np.array([*force, -height * force[1], height * force[0], 0.0])


def run(scenario: MillingScenario, *, limits: bool = True) -> ArmMilling:
    """The pass at rest, station by station; with the limits of chatter, which take longer."""
    along = prepare(scenario)
    height = 0.5 * scenario.operation.axial_depth
    static = scenario.robot.model_copy(update={"dynamics": "static"})
    terms = list(carried.terms_of(static, along, height))
    if scenario.tool.modes:
        terms.append(("tip", _tip(scenario)))
    structure = in_series([term for _, term in terms])
    sag_y = along.sag[:, 1] - along.sag[:, 3] * height
    poses = _poses(scenario, along.path.at, sag_y, along.sag[:, 2])
    found = rest(_cell(scenario, structure), relaxed(structure), poses, seen=SEEN, state=width(structure))
    if not found.found.all():
        place = along.path.at[int(np.argmin(found.found))]
        raise SolverFailure(
            f"no equilibrium of force and displacement was found at {place * 1e3:.4g} mm of the path: the arm is too soft "
            "for this cut; reduce operation.axial_depth"
        )
    rows = np.unique(np.linspace(0, len(along.path.at) - 1, min(9, len(along.path.at))).round().astype(int))
    chatter = tuple(_limit(scenario, along, int(k), height) for k in rows) if limits else ()
    return ArmMilling(along, tuple(terms), found, height, chatter, along.path.at[rows], found.total[:, :3])


def _tip(scenario: MillingScenario) -> Compliance:
    """Modes of the tool tip at rest: F/k in their directions."""
    return yielding.modes_at_rest(scenario.tool.modes)


def _limit(scenario: MillingScenario, along: carried.ArmAlong, k: int, height: float) -> DepthLimit:
    """Limit of chatter at a station: the receptances of arm and tip modes together."""
    mill, flutes = _cutting(scenario)
    matrix = translation_at((along.joints + along.base)[[k]], height)
    robot = scenario.robot
    swing = swinging(np.zeros(1), matrix, robot.modal_mass, robot.damping)
    up = scenario.operation.milling == "up"
    angle = math.pi if _is_slot(scenario) else math.acos(1.0 - scenario.operation.radial_depth / mill.radius)
    lo, hi = (0.0, angle) if up else (math.pi - angle, math.pi)
    chip = 2.0 * math.pi * scenario.operation.feed / (mill.flutes * mill.spindle_speed)
    mean_chip = chip * (math.cos(lo) - math.cos(hi)) / (hi - lo)
    directions = mean_directions(lo, hi, mill.flutes, tangent_coefficients(flutes.edges, mean_chip), up=up)
    highest = max([HIGHEST, *(_MODES_HIGHEST * mode.frequency for mode in scenario.tool.modes)])
    period = 2.0 * math.pi / (mill.flutes * mill.spindle_speed)
    return depth_limit(_receptance(scenario, swing), directions, period, highest)


def _receptance(scenario: MillingScenario, swing: Swinging) -> Receptance:
    """Displacement at the tip for a force there, arm and tip modes together."""
    arm = swinging_receptance(swing.stiffness[0], swing.damping[0], swing.mass)

    def receptance(omega: FloatArray) -> np.ndarray:
        total = arm(omega)
        for mode in scenario.tool.modes:
            ratio = omega / (2.0 * math.pi * mode.frequency)
            axis = "xy".index(mode.direction)
            total[:, axis, axis] += 1.0 / (mode.stiffness * (1.0 - ratio * ratio + 2j * mode.damping * ratio))
        return np.asarray(total)

    return receptance


def moved(done: ArmMilling) -> dict[str, FloatArray]:
    """Displacement by each term where the wall is read, station by station [m], shape (n, 3)."""
    return yielding.by_term(done.terms, done.at_rest.state, done.height)


def _turned(done: ArmMilling) -> FloatArray:
    """Tilt of the tool about the feed, which is the slope of the wall [rad], shape (n,)."""
    return np.asarray(done.at_rest.state.reshape(len(done.along.path.at), -1, 6)[:, :, 3].sum(axis=1))


def outermost(scenario: MillingScenario) -> float:
    """How far run-out carries the outermost flute [m]."""
    tool = scenario.tool
    return largest_radius(tool.runout, tool.runout_angle, tool.flutes) if tool.runout else 0.0


def wall_and_floor(scenario: MillingScenario, done: ArmMilling) -> tuple[FloatArray, FloatArray]:
    """Error of wall and floor along the path [m], positive into the part: what the tool yields by and sags.

    The wall is cut by the flute that run-out carries outermost; of a slot, this is the wall on the side of the work.
    """
    sag_y = done.along.sag[:, 1] - done.along.sag[:, 3] * done.height
    total = sum(moved(done).values())
    return outermost(scenario) - (total[:, 1] + sag_y), -(total[:, 2] + done.along.sag[:, 2])


def measures(scenario: MillingScenario, done: ArmMilling) -> dict[str, float]:
    """Measures in SI."""
    wall, floor = wall_and_floor(scenario, done)
    operation, terms = scenario.operation, moved(done)
    deeper = outermost(scenario)
    worst = int(np.argmax(np.abs(wall - deeper)))
    found = {
        "floor_error_min": float(floor.min()),
        "floor_error_max": float(floor.max()),
        "wall_tilt_max": float(np.abs(_turned(done)).max()),
        "cycle_time": float(done.along.path.at[-1]) / operation.feed,
        "path_length": float(done.along.path.at[-1]),
        "force_xy_mean_straight": float(np.hypot(done.force[:, 0], done.force[:, 1]).max()),
        "engagement_angle_max": float(done.at_rest.seen[:, 2].max()),
    }
    if _is_slot(scenario):
        shift = abs(float(wall[worst] - deeper))  # moves one wall into the part and the other out of it
        found["wall_error_min"], found["wall_error_max"] = deeper - shift, deeper + shift
    else:
        found["wall_error_min"], found["wall_error_max"] = float(wall.min()), float(wall.max())
    found |= yielding.term_measures(terms, slice(None), worst)
    wrench = np.array([_wrench(force, done.height) for force in done.force])
    twist = done.at_rest.state.reshape(len(wrench), -1, 6).sum(axis=1)
    each = [term for _, term in done.terms]
    found["energy_balance"] = yielding.energy_balance(each, done.along.path.at, wrench, twist)
    if done.limits:
        least = min(limit.depth for limit in done.limits)
        if math.isfinite(least):
            found["stable_depth_min"] = least
            found["depth_margin"] = 1.0 - operation.axial_depth / least
    found |= carried.measures(done.along, scenario.robot, operation.feed)
    swing = swinging(
        done.along.path.at, translation_at(done.along.joints + done.along.base, done.height),
        scenario.robot.modal_mass, scenario.robot.damping,
    )  # fmt: skip
    found["natural_frequency_min"] = float(
        np.sqrt(np.linalg.eigvalsh(swing.stiffness).min() / swing.mass) / (2 * math.pi)
    )
    return found


def stages(scenario: MillingScenario, done: ArmMilling) -> xr.DataTree:
    """Histories along the path, with units."""
    at = ("s", done.along.path.at, "m", "place along the path")
    wall, floor = wall_and_floor(scenario, done)
    twists = {
        f"deflection_{name}": (value, "m", f"displacement by the term {name} where the wall is read")
        for name, value in moved(done).items()
    }
    limit = ("s_limit", done.limit_at if done.limits else np.zeros(0), "m", "place along the path")
    joints = [joint.name or str(n) for n, joint in enumerate(scenario.robot.joints, 1)]
    groups = {
        "motion": labelled(at, {
            "joint_angles": (done.along.postures.q, "rad", "angles of the joints"),
            "redundancy_angle": (done.along.postures.angle, "rad", "angle of the tool about its axis"),
        }, joint=joints),
        "engagement": labelled(at, {
            "radial_depth": (done.at_rest.seen[:, 0], "m", "radial depth of cut, the tool displaced"),
            "axial_depth": (done.at_rest.seen[:, 1], "m", "axial depth of cut, the tool displaced"),
            "immersion": (done.at_rest.seen[:, 2], "rad", "immersion angle"),
        }),
        "cutting": labelled(at, {"force": (done.force, "N", "mean force on the tool")}, axis=list("xyz")),
        "structure": labelled(at, {
            **twists,
            "compliance": ((done.along.joints + done.along.base)[:, 1, 1], "m/N", "compliance normal to the wall"),
        }, axis=list("xyz")),
        "surface": labelled(at, {
            "wall_error": (wall, "m", "error of the wall, positive into the part"),
            "floor_error": (floor, "m", "error of the floor, positive into the part"),
        }),
        "stability": labelled(limit, {
            "stable_depth": (np.array([one.depth for one in done.limits]), "m", "depth at which the arm chatters"),
            "frequency": (np.array([one.frequency for one in done.limits]), "Hz", "frequency of that vibration"),
        }),
    }  # fmt: skip
    return xr.DataTree.from_dict(groups)


def warnings(scenario: MillingScenario, done: ArmMilling) -> tuple[str, ...]:
    """What a user has to know about the run."""
    return (*notices(scenario), *carried.warnings(scenario.robot, done.along, scenario.measured.get("robot")))


def notes(done: ArmMilling) -> dict[str, str]:
    """What the run took for granted, and what another angle of the tool would bring."""
    said = {}
    constant, turned = done.along.constant, done.along.turned
    if math.isfinite(constant) and math.isfinite(turned) and turned < constant * (1 - 1e-6):
        said["redundancy"] = (
            f"With robot.redundancy_angle: along_path the arm would yield by {turned * 1e6:.4g} µm on average under the "
            f"rigid cut, with the best single angle by {constant * 1e6:.4g} µm."
        )
    return said


def unsound(found: Mapping[str, float]) -> Iterator[Finding]:
    """A depth at which the arm chatters; the value is the depth over its limit."""
    if found.get("depth_margin", 1.0) <= 0.0:
        yield Finding("unstable", Place("arm"), 1.0 - found["depth_margin"], 1.0, measure="depth_margin")
