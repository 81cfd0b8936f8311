"""The moving body of a compliant spindle: from its sizes or its STEP file to mass, centre and inertia."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.step import MassProperties, mass_properties, read_step
from cutwise.maths.solids import BodyMass, Cylinder, coaxial
from cutwise.spec.spindle_solid import SpindleSolid, SpindleStep

_ROUND = 0.05  # difference of the two transverse inertias above which a body is called lopsided
_OFF_AXIS = 1e-3  # [m] distance of its centre from the axis above which that is said

DERIVED = {"mass": "mass", "centre_of_mass": "length", "inertia": "inertia"}  # key: dimension


class Body(NamedTuple):
    """What a solid gives."""

    found: BodyMass
    notices: tuple[str, ...]


class Misfit(ValueError):
    """Sizes of a spindle that do not fit one another; the key and what is wrong."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


def cylinders(solid: SpindleSolid, tool_reach: float) -> dict[str, Cylinder]:
    """Motor, collet, shank and mill, from the joint towards the tip.

    Raises
    ------
    Misfit
        Motor, collet and flutes together are longer than the tool reach.
    """
    below = solid.motor_length + solid.collet_length
    shank = tool_reach - below - solid.mill_length
    if shank < 0.0:
        shown = units.show(below + solid.mill_length, "length")
        raise Misfit(
            "motor_length",
            f"motor, collet and flutes are {shown} long, tool_reach only {units.show(tool_reach, 'length')}",
        )
    rows = {
        "motor": (0.0, solid.motor_length, solid.motor_diameter, solid.motor_density),
        "collet": (solid.motor_length, solid.collet_length, solid.collet_diameter, solid.collet_density),
        "shank": (below, shank, solid.shank_diameter, solid.mill_density),
        "mill": (below + shank, solid.mill_length, solid.mill_diameter, solid.mill_density),
    }
    return {name: Cylinder(start, length, 0.5 * wide, density) for name, (start, length, wide, density) in rows.items()}


def parametric_body(solid: SpindleSolid, tool_reach: float) -> Body:
    """Mass properties about the joint of a body given by its sizes, in closed form."""
    return Body(coaxial(cylinders(solid, tool_reach).values()), ())


def step_body(solid: SpindleStep, file: Path) -> Body:
    """Mass properties about the joint of a body given as a STEP file.

    The motor tilts in every direction alike in the model; the mean of both transverse inertias is taken, and it is
    said if they differ, or if the centre of mass lies beside the axis.

    Raises
    ------
    CadFault
        The file cannot be used.
    """
    found = mass_properties(read_step(file), solid.density)
    return about_joint(found, np.array(solid.joint), np.array(solid.axis, float))


def about_joint(found: MassProperties, joint: np.ndarray, axis: np.ndarray) -> Body:
    """Mass properties of a solid as the spindle needs them: along an axis from a joint."""
    axis = axis / np.linalg.norm(axis)
    arm = np.array(found.centre) - joint
    tensor = np.array(found.inertia) + found.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
    axial = float(axis @ tensor @ axis)
    across = np.eye(3) - np.outer(axis, axis)
    both = np.linalg.eigvalsh(across @ tensor @ across)[1:]
    along = float(arm @ axis)
    notices = []
    beside = float(np.linalg.norm(arm - along * axis))
    if beside > _OFF_AXIS:
        notices.append(f"the centre of mass lies {units.show(beside, 'length', 3)} beside the axis, which is left out")
    if along <= 0.0:
        notices.append("the centre of mass lies behind the joint: is axis the direction to the tool tip?")
    if both[1] - both[0] > _ROUND * both[1]:
        share = 100.0 * (both[1] - both[0]) / both[1]
        notices.append(f"the body is lopsided: its two transverse inertias differ by {share:.0f} %; their mean is used")
    return Body(BodyMass(found.mass, along, float(both.mean()), axial), tuple(notices))


def text_of(body: BodyMass) -> Mapping[str, str]:
    """The values that a spindle takes from a body, as text with units, by their keys."""
    values: dict[str, Any] = {"mass": body.mass, "centre_of_mass": body.centre, "inertia": body.inertia}
    return {key: units.text(values[key], dimension) for key, dimension in DERIVED.items()}
