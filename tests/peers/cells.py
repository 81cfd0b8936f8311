"""The reference case R0 of the deburring papers as bare records, with anything in it changed."""

import math

import numpy as np

from cutwise.maths.curves import constant, no_cubic
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import LINEAR, NO_KIENZLE, Edges
from cutwise.physics.motion.edge import EdgePass
from cutwise.physics.structure import pistons, seals
from cutwise.process import loops

MM = 1e-3


def ring(
    pressure=5.0, law=seals.SET_VALUED, arm=0.080, travel=50e-6, stribeck=0.0, count=7, moment=(0.0, 0.0), damping=0.0
):
    """Piston ring of R0 at a pressure in bar."""

    def friction(force):
        return seals.friction_at(force, pressure, 5.0, 0.3)

    piston = seals.Piston(5 * MM, 7.70 * pressure / 5.0, friction(3.90), friction(2.80), law, travel, stribeck, damping)
    return pistons.PistonRing(
        pistons.piston_directions(count, math.pi / 2), piston, arm, 4.1e-3, moment[0], moment[1], 1e-6
    )


def r0(
    *, feed=80 * MM, preset=2 * MM, burr=1 * MM, edge=0.0, lead_in=0.2, duration=0.6, up=False, slices=1,
    amplitude=0.0, frequency=1.0, force=loops.AVERAGED, reach=0.150,
    runout=0.0, **structure,
):  # fmt: skip
    """The cell of R0."""
    return loops.EdgeCell(
        EdgePass(feed, duration, lead_in, 0.0, burr + 0.5 * MM, preset, amplitude, frequency, no_cubic()),
        loops.Layers(constant(burr), constant(1 * MM), loops.Strips(0.0, 0.0, 10 * MM, slices)),
        loops.Cutter(
            Mill(4 * MM, 20, math.radians(20.0)),
            Edges(LINEAR, EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, edge, edge, 0.0), NO_KIENZLE, runout, 0.0),
            40_000 * 2 * math.pi / 60,
            up,
            force,
        ),
        ring(**structure),
        reach,
    )


def error_at_tool(cell, history):
    """Edge error e at point C over time [m]."""
    arm = cell.reach - 0.5 * MM
    return np.minimum(history.motion.height + arm * history.response.tilt[:, 1], cell.layers.burr_height.value[0])


def end_error(time_step=50e-6, **changes):
    """Edge error at the end of a run [mm]."""
    cell = r0(**changes)
    return error_at_tool(cell, loops.run_compliant_edge(cell, time_step))[-1] / MM
