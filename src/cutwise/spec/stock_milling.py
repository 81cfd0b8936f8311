"""What a program in a stock in 3D needs of the scenario, and what does not count there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from cutwise.spec.base import Notice
from cutwise.spec.cell import ONE_CARRIER
from cutwise.spec.chained import tip_faults
from cutwise.spec.milling_machine import MillingMachine, drives_of

if TYPE_CHECKING:
    from cutwise.spec.cutter import Cutter
    from cutwise.spec.faults import Path
    from cutwise.spec.milling import MillingScenario
    from cutwise.spec.tool import EndMill


def _carrier_faults(scenario: MillingScenario) -> Iterator[Notice]:
    """What cannot carry a tool through a stock in 3D."""
    if scenario.robot is not None and scenario.machine is not None:
        yield Notice(("robot",), ONE_CARRIER)
    if scenario.robot is not None and scenario.robot.redundancy_angle == "along_path":
        yield Notice(("robot", "redundancy_angle"), "along_path turns the tool on the way; along a program it keeps one angle: "
                     "write best_constant, or an angle")  # fmt: skip
    if isinstance(scenario.machine, MillingMachine):
        yield from tip_faults(scenario.machine)
    if scenario.compliant is not None:
        yield Notice(
            ("spindle",),
            "a compliant spindle yields along a straight wall (path.line); in a stock in 3D yield tools (stiffness or modes), "
            "a robot or the bodies of a machine",
        )
    if scenario.placement is not None and scenario.robot is None and not isinstance(scenario.machine, MillingMachine):
        yield Notice(("placement",), "places a program before a robot, or on a machine with bodies; the nominal part has "
                     "part.origin and part.rotation")  # fmt: skip


def _program_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.path is not None:
        yield Notice(("path",), "a stock in 3D is cut by a program: write program instead of path")
    if scenario.setups and scenario.program is not None:
        yield Notice(("program",), "and setups both say what is run; write one of them")
    if scenario.setups and scenario.fixtures:
        yield Notice(("fixtures",), "stand with a set-up: write them there (setups[0].fixtures)")
    if scenario.program is None and not scenario.setups:
        yield Notice(("program",), "missing; a stock in 3D is cut by a program, for example program: part.nc")
    for key in ("shop", "wear", "pocket"):
        if getattr(scenario, key) is not None:
            yield Notice(
                (key,), "counts with drives and exact arcs: a stock that is a block, one tool, no nominal part"
            )
    if scenario.program is not None and scenario.program.wanted is not None:
        yield Notice(
            ("program", "wanted"),
            "is the path before a correction for drives, which stands with exact arcs (a stock that is a block, one tool)",
        )


def _stock_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.stock is None:
        why = "a part is machined out of a stock" if vars(scenario).get("part") is not None else "tools cut a stock"
        yield Notice(
            ("stock",), f"missing; {why}, for example stock: {{x: [0 mm, 60 mm], y: [0 mm, 40 mm], z: [-20 mm, 0 mm]}}"
        )


def _part_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.nominal is None and scenario.part is not None:
        yield Notice(
            ("part",),
            "yields with the bodies of a machine; of a stock in 3D it is the nominal part: part: {file: part.step}",
        )


def _cut_faults(scenario: MillingScenario) -> Iterator[Notice]:
    for key in ("axial_depth", "radial_depth"):
        if getattr(scenario.operation, key) is not None:
            yield Notice(("operation", key), "the stock says what the program meets; leave it out")
    if scenario.operation.limit_feed:
        yield Notice(("operation", "limit_feed"), "lowers the feed of a robot along a path (path.line); a program in a stock "
                     "in 3D keeps its feeds: write lower ones there")  # fmt: skip
    if scenario.operation.milling == "up":
        yield Notice(("operation", "milling"), "is for a line; which side the work is on follows from the stock")


def _numerics_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.numerics.mode == "still":
        yield Notice(
            ("numerics", "mode"), "still is for a wall (path.line); a stock in 3D is cut move by move: write step"
        )


def _tool_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.tools and scenario.tool is not None:
        yield Notice(("tool",), "and tools both say what cuts; write one of them")
    if not scenario.tools and scenario.tool is None and not (
        scenario.setups and all(setup.tools for setup in scenario.setups)
    ):  # fmt: skip
        yield Notice(("tools",), "missing; write the tools that the program calls, for example tools: [{number: 1, shape: flat, "
                     "diameter: 10 mm, flutes: 3, helix: 30 deg}]")  # fmt: skip
    numbers = [tool.number for tool in scenario.tools]
    for number in sorted({n for n in numbers if numbers.count(n) > 1}):
        yield Notice(("tools",), f"tool {number} is there twice")


STOCK_CHECKS: tuple[Callable[[MillingScenario], Iterator[Notice]], ...] = (
    _carrier_faults, _program_faults, _stock_faults, _part_faults, _cut_faults, _numerics_faults, _tool_faults,
)  # fmt: skip
"""What is missing, and what cannot be done together with a stock in 3D; a fault in one section hides none of the others."""


def stock_unused(scenario: MillingScenario) -> Iterator[Notice]:
    """Keys that turn nothing where the stock is in 3D."""
    map_alone = "a stock in 3D is cut move by move"
    yield Notice(("operation", "lead_in_time"), map_alone)
    yield Notice(("numerics", "force"), "drives and structures feel the mean force of the cut in a stock in 3D")
    yield Notice(("numerics", "discs"), "contact in a stock in 3D has elements (numerics.stock.elements)")
    yield Notice(("numerics", "settling_time"), "how drives settle behind the end is not looked at in a stock in 3D")
    yield Notice(("numerics", "station"), map_alone + " (numerics.stock.station)")
    yield from _ideal_unused(scenario)
    yield Notice(("stability",), "chatter is not looked at in a stock in 3D")
    yield Notice(("lobes",), "chatter is not looked at in a stock in 3D")
    yield Notice(("load",), "a program in a stock in 3D is set against the machine as it stands under its weights")
    yield Notice(("program", "top"), "the stock has its own top")
    yield Notice(("material", "group"), "deburring alone holds its cutting speed against that of the group")
    if scenario.numerics.stock.engagement == "none":
        yield Notice(("material",), "without engagement there are no forces (numerics.stock.engagement: none)")
        for key in ("elements", "station"):
            yield Notice(("numerics", "stock", key), "there is no engagement (numerics.stock.engagement: none)")


def _ideal_unused(scenario: MillingScenario) -> Iterator[Notice]:
    """What counts only where the real way of the tool is swept."""
    drives = drives_of(scenario.machine)
    ideal = scenario.numerics.stock.sweep == "ideal"
    why = "the planned path is swept (numerics.stock.sweep: ideal)"
    if drives is None or ideal:
        for key in ("substeps", "time_step"):
            yield Notice(("numerics", key), why if ideal else "there are no feed drives")
    modes: list[tuple[Path, EndMill | Cutter]] = [(("tool",), scenario.tool)] if scenario.tool is not None else []
    modes += list(all_cutters(scenario))
    for path, tool in modes:
        for place in range(len(tool.modes)):
            for key in ("frequency", "damping"):
                yield Notice((*path, "modes", place, key), "modes count by their stiffness in a stock in 3D")
        if ideal or scenario.material is None or scenario.numerics.stock.engagement == "none":
            for key in ("modes", "stiffness"):
                yield Notice((*path, key), why if ideal else "nothing pushes the tool: there are no forces")
    if scenario.robot is not None:
        for key in ("dynamics", "modal_mass", "damping", "joint_speed", "joint_acceleration"):
            yield Notice(
                ("robot", key), "an arm yields at rest along a program, its joints are not held against their speeds"
            )
    cutters = [tool for _, tool in modes]
    bends = any(tool.stiffness or tool.modes or tool.runout for tool in cutters)
    if scenario.machine is None and scenario.robot is None and not bends:
        yield Notice(("numerics", "stock", "sweep"), "nothing here moves a tool beside its path")
    if not ideal:
        return
    if drives is not None:
        at = ("machine", "drives") if isinstance(scenario.machine, MillingMachine) else ("machine",)
        for key in ("reading", "control", *"xyz"):
            yield Notice((*at, key), why)
    if isinstance(scenario.machine, MillingMachine):
        for key in ("chain", "tip", "gravity"):
            yield Notice(("machine", key), why)
    for key in ("robot", "placement"):
        yield Notice((key,), why)


def stock_notices(scenario: MillingScenario) -> Iterator[Notice]:
    """What is unusual."""
    for path, tool in all_cutters(scenario):
        if tool.flat_radius > 0.0 and tool.end_core is None and scenario.material is not None:
            yield Notice(
                (*path, "end_core"), f"is not given: the bottom of tool {tool.number} has no force in plunges and ramps"
            )


def all_cutters(scenario: MillingScenario) -> Iterator[tuple[Path, Cutter]]:
    """The tools of all set-ups with their keys."""
    yield from ((("tools", place), tool) for place, tool in enumerate(scenario.tools))
    for number, setup in enumerate(scenario.setups):
        yield from ((("setups", number, "tools", place), tool) for place, tool in enumerate(setup.tools))
