"""What a cut takes of the spindle, held against its curves of power and torque over speed."""

from collections.abc import Iterator

import numpy as np

from cutwise import units
from cutwise.physics.cutting.wall import place_torques
from cutwise.process.assemble_mill import spindle_limits
from cutwise.process.loops_drives import NO_FORCE
from cutwise.process.milling import MillRun
from cutwise.programs.block_text import block_named
from cutwise.results import Finding, Place
from cutwise.spec.milling import MillingScenario


def overloads(scenario: MillingScenario, done: MillRun) -> Iterator[Finding]:
    """A cut that takes more than the spindle has at its speed, by the mean over a tooth at the planned feed."""
    known = {} if done.cut.law == NO_FORCE else spindle_limits(scenario.drives, done.cut.spindle)
    if not known or not done.contact.immersion.any():
        return
    reference, cut = done.reference, done.cut
    flat = np.hypot(reference.direction[:, 0], reference.direction[:, 1])
    chip = reference.speed * flat * 2.0 * np.pi / (cut.spindle * cut.mill.flutes)
    torque = place_torques(done.contact.patches, chip, cut.mill, cut.edges._replace(runout=0.0))
    row = int(np.argmax(torque))
    most = float(torque[row])
    takes = {
        "spindle_torque_max": (most, "moment", "torque"),
        "cutting_power_max": (most * cut.spindle, "power", "power"),
    }
    line = int(done.path.source[reference.block[row]])
    where = f" at {block_named(scenario.program.text, line)}" if scenario.program is not None and line else ""
    for name, limit in known.items():
        value, dimension, what = takes[name]
        if value > limit * (1.0 + 1e-9):
            yield Finding(
                "overloaded", Place(time=float(reference.time[row]), line=line), value, limit, dimension, cannot=True,
                words=f"the cut takes a {what} of {units.show(value, dimension, 4)}{where}, and the spindle has "
                f"{units.show(limit, dimension, 4)} at {units.show(cut.spindle, 'angular_speed', 5)}: it stalls; less feed or "
                "depth, or another speed",
            )  # fmt: skip
