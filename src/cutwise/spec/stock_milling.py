"""What a program in a stock in 3D needs of the scenario, and what does not count there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from cutwise.spec.base import Notice
from cutwise.spec.drives import CncMachine

if TYPE_CHECKING:
    from cutwise.spec.milling import MillingScenario


def _carrier_faults(scenario: MillingScenario) -> Iterator[Notice]:
    """What cannot carry a tool through a stock in 3D."""
    if scenario.robot is not None:
        yield Notice(("robot",), "a stock in 3D is cut by a program on a machine; leave the robot out")
    if scenario.compliant is not None:
        yield Notice(
            ("spindle",),
            "a compliant spindle yields along a straight wall (path.line); in a stock in 3D nothing yields",
        )
    if scenario.placement is not None:
        yield Notice(("placement",), "places a part before a robot; the nominal part has part.origin and part.rotation")
    if scenario.machine is not None and not isinstance(scenario.machine, CncMachine):
        yield Notice(("machine",), "bodies of a machine yield along a straight wall (path.line); in a stock in 3D a machine has "
                     "limits of its motion alone: machine: {library: fadal2216}")  # fmt: skip


def _program_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.path is not None:
        yield Notice(("path",), "a stock in 3D is cut by a program: write program instead of path")
    if scenario.program is None:
        yield Notice(("program",), "missing; a stock in 3D is cut by a program, for example program: part.nc")
    for key in ("shop", "pocket"):
        if getattr(scenario, key) is not None:
            yield Notice(
                (key,), "counts with drives and exact arcs: a stock that is a block, one tool, no nominal part"
            )
    if scenario.program is not None and scenario.program.wanted is not None:
        yield Notice(
            ("program", "wanted"), "is the path before a correction for drives; a stock in 3D is cut without drives"
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
        yield Notice(
            ("operation", "limit_feed"), "lowers the feed where the joints of a robot cannot follow; there is none"
        )
    if scenario.operation.milling == "up":
        yield Notice(("operation", "milling"), "is for a line; which side the work is on follows from the stock")


def _material_faults(scenario: MillingScenario) -> Iterator[Notice]:
    material = scenario.material
    if material is not None and material.law != "linear":
        yield Notice(("material",), "Kienzle's law is not covered in a stock in 3D yet; write K_tc, K_te, ... (or leave the "
                     "material out: no forces)")  # fmt: skip


def _numerics_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.numerics.mode == "still":
        yield Notice(("numerics", "mode"), "still is for a robot; a stock in 3D is cut move by move")


def _tool_faults(scenario: MillingScenario) -> Iterator[Notice]:
    if scenario.tools and scenario.tool is not None:
        yield Notice(("tool",), "and tools both say what cuts; write one of them")
    if not scenario.tools and scenario.tool is None:
        yield Notice(("tools",), "missing; write the tools that the program calls, for example tools: [{number: 1, shape: flat, "
                     "diameter: 10 mm, flutes: 3, helix: 30 deg}]")  # fmt: skip
    for key in ("modes", "stiffness"):
        if scenario.tool is not None and getattr(scenario.tool, key):
            yield Notice(("tool", key), "a tool that bends or swings is not covered in a stock in 3D; leave it out")
    numbers = [tool.number for tool in scenario.tools]
    for number in sorted({n for n in numbers if numbers.count(n) > 1}):
        yield Notice(("tools",), f"tool {number} is there twice")


STOCK_CHECKS: tuple[Callable[[MillingScenario], Iterator[Notice]], ...] = (
    _carrier_faults, _program_faults, _stock_faults, _part_faults, _cut_faults, _material_faults, _numerics_faults, _tool_faults,
)  # fmt: skip
"""What is missing, and what cannot be done together with a stock in 3D; a fault in one section hides none of the others."""


def stock_unused(scenario: MillingScenario) -> Iterator[Notice]:
    """Keys that turn nothing where the stock is in 3D."""
    map_alone = "a stock in 3D is cut along the planned path: drives are not stepped"
    yield Notice(("operation", "lead_in_time"), map_alone)
    for key in ("substeps", "force", "discs", "settling_time", "station", "time_step"):
        yield Notice(("numerics", key), map_alone + (" (numerics.stock.station)" if key == "station" else ""))
    yield Notice(("stability",), "chatter is not looked at in a stock in 3D")
    yield Notice(("lobes",), "chatter is not looked at in a stock in 3D")
    yield Notice(("load",), "nothing yields in a stock in 3D")
    yield Notice(("program", "top"), "the stock has its own top")
    yield Notice(("material", "group"), "deburring alone holds its cutting speed against that of the group")
    yield Notice(("machine", "reading"), map_alone)
    yield Notice(("machine", "control"), map_alone)
    for axis in "xyz":
        yield Notice(("machine", axis), map_alone)
    if scenario.tool is not None:
        for key in ("runout", "runout_angle"):
            yield Notice(("tool", key), "the teeth of a tool are alike in a stock in 3D")
    if scenario.numerics.stock.engagement == "none":
        yield Notice(("material",), "without engagement there are no forces (numerics.stock.engagement: none)")
        for key in ("elements", "station"):
            yield Notice(("numerics", "stock", key), "there is no engagement (numerics.stock.engagement: none)")


def stock_notices(scenario: MillingScenario) -> Iterator[Notice]:
    """What is unusual."""
    for place, tool in enumerate(scenario.tools):
        if tool.flat_radius > 0.0 and tool.end_core is None and scenario.material is not None:
            yield Notice(
                ("tools", place, "end_core"),
                f"is not given: the bottom of tool {tool.number} has no force in plunges and ramps",
            )
