"""A machine chain that carries a tool: the commands that lead it to some places, and what its bodies yield by there."""

from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.maths import chains
from cutwise.maths.frames import FloatArray
from cutwise.physics.structure.series_compliance import in_axes
from cutwise.process.machine_assemble import axes_of, elements_of, flexible_part
from cutwise.process.machine_pass import Bodies, compliance_at
from cutwise.results import Infeasible
from cutwise.spec.faults import Fault, Path, ScenarioFault
from cutwise.spec.machine import Machine, PartBlock

_ASIDE = 1e-6  # sine of the angle between the axis of the tool and that of the spindle
_APART = 1e-9  # [m] from a place to the nearest that the axes can reach


class BodiesAlong(NamedTuple):
    """A machine at some places of a path."""

    bodies: Bodies
    commands: FloatArray  # of all joints, shape (n, joints)
    matrix: FloatArray  # compliance of the tool against the part at the tip, in the axes asked for, shape (n, 6, 6)


def bodies_of(machine: Machine, block: PartBlock | None) -> Bodies:
    """A machine as it yields, with the part on its table; geometric errors and weights left out."""
    assert machine.tool_point is not None
    return Bodies(
        axes_of(machine, {}), machine.ground, np.array(machine.tool_point), tuple(elements_of(machine)),
        flexible_part(block),
    )  # fmt: skip


def bodies_along(
    machine: Machine, block: PartBlock | None, points: FloatArray, axes: FloatArray, axis_of_tool: Path
) -> BodiesAlong:
    """A machine with its tool at places of the part.

    Parameters
    ----------
    points : array (n, 3)
        Tool tip in the frame of the part [m].
    axes : array (3, 3) or (n, 3, 3)
        Axes in which the compliance is wanted, as columns; z along the tool.
    axis_of_tool : path
        Key that says how the tool stands, for the message.

    Raises
    ------
    ScenarioFault
        The tool does not stand as the spindle of this machine does.
    Infeasible
        A place is out of reach of the axes.
    """
    bodies = bodies_of(machine, block)
    commands = commands_at(bodies, points)
    at = chains.frames(bodies.axes.chain, commands * bodies.axes.sense)
    spindle, tool = at.rotations[:, -1, :, 2], np.broadcast_to(axes, (len(points), 3, 3))[:, :, 2]
    if np.linalg.norm(np.cross(spindle, tool), axis=1).max() > _ASIDE:
        shown = ", ".join(f"{x:.3g}" for x in -spindle[0] + 0.0)
        raise ScenarioFault([Fault(axis_of_tool, f"the spindle of this machine points along [{shown}]; write that")])
    _within_travel(machine, bodies, commands, points)
    return BodiesAlong(bodies, commands, in_axes(compliance_at(bodies, commands), axes))


def commands_at(bodies: Bodies, points: FloatArray) -> FloatArray:
    """Commands of the linear axes that lead the tip to places of the part, turning axes at zero, shape (n, joints).

    Raises
    ------
    Infeasible
        No axis leads to a place.
    """
    chain, sense = bodies.axes.chain, bodies.axes.sense
    linear = np.flatnonzero(chain.kinds == chains.PRISMATIC)
    steps = np.zeros((len(linear) + 1, len(chain.kinds)))
    steps[np.arange(1, len(linear) + 1), linear] = 1.0
    reached = chains.tool_point(chains.frames(chain, steps * sense), bodies.tip)
    per_step = (reached[1:] - reached[0]).T
    found = np.linalg.lstsq(per_step, (points - reached[0]).T, rcond=None)[0].T
    apart = np.linalg.norm(found @ per_step.T + reached[0] - points, axis=1)
    if apart.max() > _APART:
        place = int(np.argmax(apart))
        raise Infeasible(
            f"the machine does not reach {_shown(points[place])}: its linear axes lead past it by "
            f"{units.show(float(apart[place]), 'length')}"
        )
    commands = np.zeros((len(points), len(chain.kinds)))
    commands[:, linear] = found
    return commands


def _within_travel(machine: Machine, bodies: Bodies, commands: FloatArray, points: FloatArray) -> None:
    joints = [body.joint for body in machine.ordered[1:]]
    for k, joint in enumerate(joints):
        if joint is None or joint.kind == "fixed":
            continue
        low, high = bodies.axes.low[k], bodies.axes.high[k]
        over = np.maximum(low - commands[:, k], commands[:, k] - high)
        if over.max() > _APART:
            place = int(np.argmax(over))
            dimension = "length" if joint.kind == "prismatic" else "angle"
            told, first, last = (units.show(float(x), dimension) for x in (commands[place, k], low, high))
            raise Infeasible(
                f"the machine does not reach {_shown(points[place])}: axis {joint.command} would go to {told}, its travel is "
                f"{first} to {last}"
            )


def _shown(point: FloatArray) -> str:
    return f"({', '.join(f'{1e3 * x:.4g}' for x in point)}) mm of the part"
