"""``change: offset`` of a machine: the map of its geometric errors as a table for the control."""

from typing import Any

import numpy as np

from cutwise import units
from cutwise.io.scenario import read_document
from cutwise.process import machine
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.machine_scenario import MachineScenario
from cutwise.study.band import simulate
from cutwise.study.correct.outcome import Change, Proposal, Task

_MEASURE = "volumetric_error_max"
_MM, _UM = 1e3, 1e6


def corrected(task: Task) -> Proposal:
    """A table with the points of the map, and what is left between them.

    The machine is looked at again with the table taken off, at twice as many places: the middles of its cells among them.

    Raises
    ------
    ScenarioFault
        The scenario has no map, or no error in it.
    """
    scenario = task.scenario
    assert isinstance(scenario, MachineScenario)
    if scenario.volume is None:
        raise ScenarioFault(
            [Fault(("volume",), "missing; an error table covers the working space: write volume: {points: 11}")]
        )
    count = scenario.volume.table_points or scenario.volume.points
    before = machine.evaluate_volume(_as_it_is(scenario))
    assert before is not None
    size = float(np.linalg.norm(before.error, axis=-1).max())
    if size < 1e-9:
        raise ScenarioFault(
            [Fault(("correct", "change"), "offset: the machine has no geometric error in its working space")]
        )
    new = _with(scenario, {"table_points": count, "points": 2 * count - 1})
    after = simulate(new, None)
    left = after.measures[_MEASURE].value
    kept = []
    if left > task.said.residual * size:
        kept.append(
            f"{units.show(left, 'small_length', 3)} of {units.show(size, 'small_length', 3)} are left between the points, more "
            f"than correct.residual ({task.said.residual:g}): take more volume.points"
        )
    beyond = units.show(_beyond(scenario, count), "small_length", 3)
    shown = units.show(size, "small_length", 4), units.show(left, "small_length", 4)
    return Proposal(
        new,
        (
            Change(
                _MEASURE,
                *shown,
                f"a table of {count} points along each axis in the control, straight lines between them",
            ),
        ),
        {
            "residual_max": (left, "small_length"),
            "residual_ratio": (left / size, "dimensionless"),
            "table_points": (float(count), "dimensionless"),
        },
        (
            "-o FILE --format table writes it; the values are to be added to the commands",
            f"at the ends of the travel the table leads up to {beyond} beyond them: keep so much room in the control's limits",
        ),
        tuple(kept),
        after=after,
    )


def text(scenario: MachineScenario) -> str:
    """The table: x, y, z of the command [mm], and what is to be added to it [µm]; x goes fastest."""
    assert scenario.volume is not None
    nodes, added = machine.error_table(scenario, scenario.volume.table_points or scenario.volume.points)
    lines = [
        f"# cutwise: {scenario.name}: against the geometric errors of the machine: add to the command",
        "# x y z: commands of X, Y, Z as the scenario counts them (joint.positive); dx dy dz: added to them, so that the tool "
        "goes by minus its predicted error in the part; between the points straight lines",
        "x [mm], y [mm], z [mm], dx [um], dy [um], dz [um]",
    ]
    for k, z in enumerate(nodes[2]):
        for j, y in enumerate(nodes[1]):
            for i, x in enumerate(nodes[0]):
                values = [
                    *(f"{_MM * place:.6f}" for place in (x, y, z)),
                    *(f"{e:.4f}" for e in _UM * added[i, j, k] + 0.0),
                ]
                lines.append(", ".join(values))
    return "\n".join([*lines, ""])


def _beyond(scenario: MachineScenario, count: int) -> float:
    """How far a table leads axes beyond the ends of their travel [m]."""
    _, added = machine.error_table(scenario, count)
    ends = [np.moveaxis(added[..., k], k, 0) for k in range(3)]
    return max(0.0, *(float(max(-one[0].min(), one[-1].max())) for one in ends))


def _as_it_is(scenario: MachineScenario) -> MachineScenario:
    """The machine without a table."""
    return _with(scenario, {"table_points": None})


def _with(scenario: MachineScenario, given: dict[str, Any]) -> MachineScenario:
    document: dict[str, Any] = scenario.document()
    volume = {**document["volume"], **given}
    document["volume"] = {key: value for key, value in volume.items() if value is not None}
    found = read_document(document, scenario.name)
    assert isinstance(found, MachineScenario)
    return found
