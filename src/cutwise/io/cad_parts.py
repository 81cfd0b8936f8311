"""Parts made by OpenCascade: drilled pipes and blocks for examples and tests, and the compliant spindle as a solid."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from cutwise.io.occ import MM, occ
from cutwise.io.spindle_body import Misfit, cylinders
from cutwise.spec.spindle_solid import SpindleSolid


def _cylinder(origin: Sequence[float], axis: Sequence[float], radius: float, height: float) -> Any:
    """Cylinder from an origin along an axis; all lengths in m."""
    gp = occ("gp")
    frame = gp.gp_Ax2(gp.gp_Pnt(*(x / MM for x in origin)), gp.gp_Dir(*axis))
    return occ("BRepPrimAPI").BRepPrimAPI_MakeCylinder(frame, radius / MM, height / MM).Shape()


def _cut(body: Any, tool: Any) -> Any:
    return occ("BRepAlgoAPI").BRepAlgoAPI_Cut(body, tool).Shape()


def drilled_pipe(
    radius: float,
    wall: float,
    hole_radius: float,
    length: float,
    *,
    eccentricity: float = 0.0,
    inclination: float = 0.0,
) -> Any:
    """A pipe along y with one hole drilled from +z [m, rad]; shape of OpenCascade in mm."""
    start = (0.0, -0.5 * length, 0.0)
    body = _cylinder(start, (0.0, 1.0, 0.0), radius, length)
    bore = _cylinder((0.0, -length, 0.0), (0.0, 1.0, 0.0), radius - wall, 2.0 * length)
    axis = (0.0, math.sin(inclination), math.cos(inclination))
    drill = _cylinder((eccentricity, 0.0, 0.0), axis, hole_radius, 3.0 * radius)
    return _cut(_cut(body, bore), drill)


def drilled_block(
    length: float, width: float, height: float, holes: Sequence[tuple[float, float, float, float]],
    bore_radius: float | None = None,
) -> Any:  # fmt: skip
    """A block from the origin with through holes (x, y, radius, inclination) from its top, and a bore along x [m]."""
    block = occ("BRepPrimAPI").BRepPrimAPI_MakeBox(length / MM, width / MM, height / MM).Shape()
    for x, y, radius, inclination in holes:
        axis = (0.0, math.sin(inclination), math.cos(inclination))
        reach = 2.0 * height / axis[2]
        foot = (x, y - reach * axis[1], height - reach * axis[2])
        block = _cut(block, _cylinder(foot, axis, radius, 2.0 * reach))
    if bore_radius is not None:
        block = _cut(block, _cylinder((-length, 0.5 * width, 0.5 * height), (1.0, 0.0, 0.0), bore_radius, 3.0 * length))
    return block


class SpindleSize(NamedTuple):
    """A compliant spindle as a solid: what the sizes of its body leave open [m]; the joint is the origin."""

    solid: SpindleSolid
    tool_reach: float  # L_t, joint to tip
    piston_arm: float  # l_p, joint to the plane of the pistons
    pistons: int
    piston_azimuth: float  # [rad] of piston 0 from +x


class SpindleBodies(NamedTuple):
    """The spindle as solids of OpenCascade, in mm."""

    moving: tuple[Any, ...]  # motor, collet, shank and mill: what tilts about the joint
    pistons: tuple[Any, ...]
    housing: Any


def compliant_spindle(size: SpindleSize, tilt: tuple[float, float] = (0.0, 0.0)) -> SpindleBodies:
    """Housing, motor, pistons and mill as solids, the mill pointing down (-z); the moving body tilted by a small angle.

    Parameters
    ----------
    size : SpindleSize
        Sizes.
    tilt : tuple of float
        Displacement over distance from the joint, along x and y [rad].

    Raises
    ------
    Misfit
        The sizes do not fit one another.
    """
    solid = size.solid
    if size.piston_arm > solid.motor_length:
        raise Misfit("motor_length", "the motor ends above the pistons (piston_arm)")
    down = (0.0, 0.0, -1.0)
    moving = [
        _tilted(_cylinder((0.0, 0.0, -one.start), down, one.radius, one.length), tilt)
        for one in cylinders(solid, size.tool_reach).values() if one.length > 0.0
    ]  # fmt: skip
    radius = 0.5 * solid.motor_diameter
    pistons = []
    for i in range(size.pistons):
        azimuth = size.piston_azimuth + 2.0 * math.pi * i / size.pistons
        out = (math.cos(azimuth), math.sin(azimuth), 0.0)
        foot = (radius * out[0], radius * out[1], -size.piston_arm)
        pistons.append(_cylinder(foot, out, 0.5 * solid.piston_diameter, solid.housing_gap + solid.housing_wall))
    outside = radius + solid.housing_gap
    shell = _cylinder((0.0, 0.0, solid.housing_wall), down, outside + solid.housing_wall, solid.motor_length)
    housing = _cut(shell, _cylinder((0.0, 0.0, 0.0), down, outside, 2.0 * solid.motor_length))
    for piston in pistons:
        housing = _cut(housing, piston)
    return SpindleBodies(tuple(moving), tuple(pistons), housing)


def spindle_assembly(bodies: SpindleBodies) -> Any:
    """All bodies of a spindle as one shape, for export."""
    return _compound([*bodies.moving, *bodies.pistons, bodies.housing])


def _compound(bodies: Sequence[Any]) -> Any:
    whole = occ("TopoDS").TopoDS_Compound()
    builder = occ("BRep").BRep_Builder()
    builder.MakeCompound(whole)
    for body in bodies:
        builder.Add(whole, body)
    return whole


def _tilted(body: Any, tilt: tuple[float, float]) -> Any:
    """A body hanging from the origin, its end displaced along (x, y) per unit of distance."""
    angle = math.hypot(*tilt)
    if angle == 0.0:
        return body
    gp = occ("gp")
    turn = gp.gp_Trsf()
    axis = gp.gp_Ax1(gp.gp_Pnt(0, 0, 0), gp.gp_Dir(tilt[1] / angle, -tilt[0] / angle, 0.0))
    turn.SetRotation(axis, math.atan(angle))
    return occ("BRepBuilderAPI").BRepBuilderAPI_Transform(body, turn, True).Shape()
