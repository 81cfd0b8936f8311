"""What ``cutwise spindle`` says about the compliant spindle of a scenario, and its solid as STEP."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from cutwise import units
from cutwise.io.cad_parts import SpindleSize, compliant_spindle, spindle_assembly
from cutwise.io.occ import CadFault
from cutwise.io.spindle_body import Misfit, cylinders
from cutwise.io.step import write_step
from cutwise.physics.structure.statics import Characteristic, characteristic
from cutwise.process.spindles import piston_ring
from cutwise.spec.scenario import Scenario
from cutwise.spec.spindle import CompliantSpindle
from cutwise.spec.spindle_solid import SpindleSolid


class Sheet(NamedTuple):
    """Data sheet of a compliant spindle."""

    spindle: CompliantSpindle
    statics: Characteristic
    statuses: Mapping[str, str]  # of mass, centre_of_mass and inertia

    def as_json(self) -> dict[str, Any]:
        """The sheet in SI."""
        s, c = self.spindle, self.statics
        bodies = {}
        if isinstance(s.solid, SpindleSolid):
            bodies = {name: one.mass for name, one in cylinders(s.solid, s.tool_reach).items()}
        return {
            "mass": s.mass, "centre_of_mass": s.centre_of_mass, "inertia": s.inertia, "status": self.statuses,
            "bodies": bodies, "pressure": s.pressure, "breakaway_force": c.loading.breakaway,
            "loading_force": c.loading.plateau, "unloading_force": c.unloading.plateau,
            "return_force": c.unloading.breakaway, "stop": c.stop, "remarks": list(s.solid_remarks),
        }  # fmt: skip


def sheet(scenario: Scenario) -> Sheet:
    """The sheet of the spindle of a scenario.

    Raises
    ------
    ValueError
        The scenario has no compliant spindle.
    """
    spindle = getattr(scenario, "spindle", None)
    if not isinstance(spindle, CompliantSpindle):
        raise ValueError(f"a {scenario.process} scenario without a spindle section has no compliant spindle")
    origins = scenario.origins
    statuses = {
        key: origins[f"spindle.{key}"].status
        for key in ("mass", "centre_of_mass", "inertia") if f"spindle.{key}" in origins
    }  # fmt: skip
    return Sheet(spindle, characteristic(piston_ring(spindle), spindle.tool_reach), statuses)


def shown(found: Sheet) -> str:
    """The sheet as text."""
    s, c = found.spindle, found.statics
    rows = []
    for key, dimension in (("mass", "mass"), ("centre_of_mass", "length"), ("inertia", "inertia")):
        value = getattr(s, key)
        if value is not None:
            rows.append((key, units.show(value, dimension, 5), found.statuses.get(key, "")))
    if isinstance(s.solid, SpindleSolid):
        for name, one in cylinders(s.solid, s.tool_reach).items():
            rows.append(
                (f"  {name}", units.show(one.mass, "mass", 4), f"from {one.start * 1e3:.4g} mm below the joint")
            )
    rows += [
        (f"at the tip, {units.show(s.pressure, 'pressure', 3)}", "", ""),
        ("  breakaway", units.show(c.loading.breakaway, "force", 4), "no motion below"),
        ("  loading plateau", units.show(c.loading.plateau, "force", 4), "pushed out"),
        ("  unloading plateau", units.show(c.unloading.plateau, "force", 4), "on the way back"),
        ("  stop", units.show(c.stop, "length", 4), "displacement of the tip"),
    ]
    wide = max(len(row[0]) for row in rows)
    lines = [f"{name:<{wide}}  {value:>14}  {text}".rstrip() for name, value, text in rows]
    return "\n".join([*lines, *(f"warning: {text}" for text in s.solid_remarks)])


def export(found: Sheet, file: Path, tip: tuple[float, float] = (0.0, 0.0)) -> Path:
    """Write the spindle as STEP, the tip displaced along x and y [m].

    Raises
    ------
    CadFault
        The spindle is not given by its sizes, or OpenCascade is missing.
    """
    s = found.spindle
    if not isinstance(s.solid, SpindleSolid):
        raise CadFault("the spindle has no sizes to draw it from: give spindle.solid, or spindle.library: prototype")
    if math.hypot(*tip) > found.statics.stop * (1.0 + 1e-9):
        raise CadFault(f"the tip cannot go that far: it stops at {units.show(found.statics.stop, 'length', 3)}")
    size = SpindleSize(s.solid, s.tool_reach, s.piston_arm, s.pistons, s.piston_azimuth)
    tilt = (tip[0] / s.tool_reach, tip[1] / s.tool_reach)
    try:
        return write_step(spindle_assembly(compliant_spindle(size, tilt)), file)
    except Misfit as fault:
        raise CadFault(f"spindle.solid.{fault.key}: {fault}") from None
