"""What a time step of the compliant-edge loop costs, beside MuJoCo and Exudyn stepping its structure alone.

Run from the repository: ``python benchmarks/compliant_spindle.py``. All times are CPU seconds of this process, best of
several repeats, with parameters that arrive at run time. The peers get the smallest model that they can hold of the
same structure (two degrees of freedom of the motor, seven pistons with seal friction, stops and one-sided contact),
the mean cutting force of the reference case through a spring, and no Python between their steps.
"""

import argparse
import importlib.metadata
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

import numpy as np

from cutwise.physics.structure import pistons, seals
from cutwise.process.loops import TOOTH_RESOLVED, EdgeCell, run_compliant_edge, run_swept_edge
from peers.cells import MM, r0

FORCE = (5.7, 9.4)  # [N] mean burr force of the reference case
DEFLECTION = (1.587 * MM, 1.990 * MM)  # [m] of the mill there
PROCESS_STIFFNESS = 20e3  # [N/m] stands for the material, without which the motor would run to its stop
PROCESS_DAMPING = 500.0  # [N s/m]
REACH = 0.1495  # [m] from the joint to the point where the force acts
PISTON_MASS = 0.002  # [kg] cutwise has none; the peers need one
DURATION = 0.6  # [s]


class Row(NamedTuple):
    """One line of the table."""

    name: str
    time_step: float  # [s]
    cost: float  # [s] CPU time of a step
    deflection: float  # [m] of the mill off the work at the end


def timed(run: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """Least CPU time of some repeats [s], and what the last gave."""
    least, found = np.inf, None
    for _ in range(repeats):
        start = time.process_time()
        found = run()
        least = min(least, time.process_time() - start)
    return float(least), found


def own(name: str, time_step: float, repeats: int, run: Callable[..., Any] = run_compliant_edge, **changes: Any) -> Row:
    """The whole loop of cutwise: motion, engagement, forces, structure and history."""
    run(r0(**{**changes, "duration": 100 * time_step, "lead_in": 0.0}), time_step)  # compiles
    cell: EdgeCell = r0(**changes)
    cost, history = timed(lambda: run(cell, time_step), repeats)
    return Row(name, time_step, cost / round(cell.path.duration / time_step), history.response.tilt[-1, 1] * REACH)


def mujoco_model(ring: pistons.PistonRing, time_step: float) -> str:
    """Motor on two hinges against seven sliding pistons, in MuJoCo's format."""
    piston = ring.piston
    ball, shaft = 0.003, 0.019
    stiffness, damping = PROCESS_STIFFNESS * REACH**2, PROCESS_DAMPING * REACH**2
    size = f"{shaft} {0.05}"
    bodies = []
    for i, (nx, ny) in enumerate(ring.direction):
        away = shaft + ball
        bodies.append(
            f'<body pos="{nx * away} {ny * away} {-ring.arm}"><inertial pos="0 0 0" mass="{PISTON_MASS}" '
            f'diaginertia="1e-8 1e-8 1e-8"/><joint name="p{i}" type="slide" axis="{nx} {ny} 0" limited="true" '
            f'range="0 {piston.stroke}" frictionloss="{piston.friction_dynamic}"/>'
            f'<geom type="sphere" size="{ball}" contype="1" conaffinity="2"/></body>'
        )
    return f"""<mujoco><option timestep="{time_step}" gravity="0 0 0" integrator="implicitfast"/>
    <default><geom friction="0 0 0" condim="1" solref="0.0005 1"/><joint solreflimit="0.0005 1"/></default>
    <worldbody><body><inertial pos="0 0 -0.01" mass="0.6" diaginertia="{ring.inertia} {ring.inertia} 1e-4"/>
    <joint name="qx" type="hinge" axis="0 -1 0" stiffness="{stiffness}" damping="{damping}"/>
    <joint name="qy" type="hinge" axis="1 0 0" stiffness="{stiffness}" damping="{damping}"/>
    <geom type="cylinder" size="{size}" pos="0 0 {-ring.arm}" contype="2" conaffinity="1"/></body>
    {"".join(bodies)}</worldbody></mujoco>"""


def mujoco_row(time_step: float, repeats: int) -> Row:
    """MuJoCo: soft contact and friction, solved as a convex program in every step."""
    import mujoco

    ring = r0().ring
    model = mujoco.MjModel.from_xml_string(mujoco_model(ring, time_step))
    steps = round(DURATION / time_step)

    def run() -> float:
        data = mujoco.MjData(model)
        for joint, force, shift in zip(("qx", "qy"), FORCE, DEFLECTION, strict=True):
            push = (force + PROCESS_STIFFNESS * shift) * REACH
            data.qfrc_applied[model.joint(joint).dofadr] = push
        for i in range(len(ring.direction)):
            data.qfrc_applied[model.joint(f"p{i}").dofadr] = -ring.piston.pressure_force
        mujoco.mj_step(model, data, steps)
        return float(data.joint("qy").qpos[0]) * REACH

    cost, deflection = timed(run, repeats)
    return Row("MuJoCo, structure alone", time_step, cost / steps, deflection)


def exudyn_row(time_step: float, repeats: int) -> Row:
    """Exudyn: penalty contact, friction with a sticking spring, explicit integration."""
    import exudyn as exu
    import exudyn.itemInterface as items  # noqa: N813

    ring = r0().ring
    piston = ring.piston
    ball, shaft = 0.003, 0.019
    scale = REACH / ring.arm  # the motor is a point mass at the height of the pistons
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddNode(items.NodePointGround())
    fixed = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    motor = mbs.AddNode(items.NodePoint2D())
    body = mbs.AddObject(items.ObjectMassPoint2D(mass=ring.inertia / ring.arm**2, nodeNumber=motor))
    for axis in (0, 1):
        here = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=motor, coordinate=axis))
        mbs.AddObject(
            items.CoordinateSpringDamper(
                markerNumbers=[fixed, here], stiffness=PROCESS_STIFFNESS * scale**2, damping=PROCESS_DAMPING * scale**2
            )
        )
        push = (FORCE[axis] + PROCESS_STIFFNESS * DEFLECTION[axis]) * scale
        mbs.AddLoad(items.LoadCoordinate(markerNumber=here, load=push))
    face = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
    for nx, ny in ring.direction:
        away = shaft + ball
        node = mbs.AddNode(items.Node1D(referenceCoordinates=[0]))
        turn = [[nx, -ny, 0.0], [ny, nx, 0.0], [0.0, 0.0, 1.0]]
        mass = mbs.AddObject(
            items.ObjectMass1D(
                mass=PISTON_MASS, nodeNumber=node, referencePosition=[nx * away, ny * away, 0.0],
                referenceRotation=turn,
            )
        )  # fmt: skip
        slide = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
        seal = mbs.AddNode(items.NodeGenericData(initialCoordinates=[0.0] * 3, numberOfDataCoordinates=3))
        mbs.AddObject(
            items.CoordinateSpringDamperExt(
                markerNumbers=[fixed, slide], nodeNumber=seal, damping=5.0, useLimitStops=True, limitStopsLower=0.0,
                limitStopsUpper=piston.stroke, limitStopsStiffness=1e6, limitStopsDamping=20.0,
                dynamicFrictionForce=piston.friction_dynamic, stickingStiffness=1e5, stickingDamping=10.0,
                frictionProportionalZone=1e-4,
            )
        )  # fmt: skip
        mbs.AddLoad(items.LoadCoordinate(markerNumber=slide, load=-piston.pressure_force))
        spot = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=mass))
        memory = mbs.AddNode(items.NodeGenericData(initialCoordinates=[0.0] * 4, numberOfDataCoordinates=4))
        mbs.AddObject(
            items.ObjectContactSphereSphere(
                markerNumbers=[face, spot], nodeNumber=memory, spheresRadii=[shaft, ball], contactStiffness=1e6,
                contactDamping=20.0,
            )
        )  # fmt: skip
    mbs.Assemble()
    steps = round(DURATION / time_step)
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.endTime = DURATION
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = DURATION
    start = mbs.systemData.GetSystemState()

    def run() -> float:
        mbs.systemData.SetSystemState(start)
        mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.VelocityVerlet)
        return float(mbs.GetNodeOutput(motor, exu.OutputVariableType.Coordinates)[1]) * scale

    cost, deflection = timed(run, repeats)
    return Row("Exudyn, structure alone", time_step, cost / steps, deflection)


def peer_rows(repeats: int) -> list[Row]:
    """The peers that are installed; the others are named."""
    rows = []
    for package, run, step in (("mujoco", mujoco_row, 50e-6), ("exudyn", exudyn_row, 10e-6)):
        try:
            version = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            print(f"{package} is not installed and left out; to compare with it: pip install {package}")
            continue
        row = run(step, repeats)
        rows.append(row._replace(name=f"{row.name} ({version})"))
    return rows


def own_rows(repeats: int) -> list[Row]:
    """The loops of cutwise, the plain averaged one first."""
    return [
        own("averaged, set-valued friction", 50e-6, 3 * repeats),
        own("averaged, no friction", 50e-6, 3 * repeats, law=seals.NO_FRICTION),
        own("averaged, presliding", 50e-6, 3 * repeats, law=seals.PRESLIDING),
        own("averaged, presliding with Stribeck", 50e-6, 3 * repeats, law=seals.PRESLIDING, stribeck=1e-3),
        own("averaged, regularised", 50e-6, repeats, law=seals.REGULARISED, stribeck=1e-3),
        own("averaged, 10 slices", 50e-6, 3 * repeats, slices=10),
        own("averaged, swept surface", 50e-6, repeats, run_swept_edge),
        own("tooth-resolved", 2.5e-6, repeats, force=TOOTH_RESOLVED),
        own("tooth-resolved with run-out", 2.5e-6, 1, force=TOOTH_RESOLVED, runout=5e-6, duration=0.1, lead_in=0.05),
    ]


def main() -> None:
    """Measure everything and print the table."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--repeats", type=int, default=3, help="repeats of each run, of which the best counts")
    repeats = options.parse_args().repeats
    ours, peers = own_rows(repeats), peer_rows(repeats)
    base = ours[0].cost
    titles = f"{'step':>8} {'CPU per step':>14} {'of the first':>13} {'simulated s / CPU s':>20} {'mill off work':>14}"
    print(f"{'':44}{titles}")
    for row in (*ours, *peers):
        print(
            f"{row.name:44}{row.time_step * 1e6:>5.3g} us {row.cost * 1e6:>11.3f} us {row.cost / base:>12.2f}x "
            f"{row.time_step / row.cost:>20.3g} {row.deflection / MM:>11.3f} mm"
        )
    for peer in peers:
        print(f"a step of {peer.name} costs {peer.cost / base:.1f} times one of the whole averaged loop")


if __name__ == "__main__":
    main()
