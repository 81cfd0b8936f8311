"""The pocket corner of the reference case, run straight through the kernels, and brute-force engagement."""

import math

import numpy as np

from cutwise.maths.linearc import join
from cutwise.paths.pocket import corner
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import AVERAGED, DISCS
from cutwise.physics.engagement.wall import path_contact, wall_patches
from cutwise.physics.motion.contour import contour_errors
from cutwise.physics.motion.driven import SetPoints
from cutwise.physics.motion.drives import Controller, Drive, Plant
from cutwise.physics.motion.lookahead import plan
from cutwise.physics.motion.profile import Limits
from cutwise.physics.motion.reference import central_difference, sampled
from cutwise.process.loops_drives import NO_FORCE, Cut, run_drives

FRICTION = (2.6256, -1.8672, 2.1529, -1.4730, 3.88, -3.51, 4.20, -3.52)
NO_FRICTION = (0.0, 0.0, 0.0, 0.0, 3.88, -3.51, 4.20, -3.52)
X = Plant(6.4898, 0.4769, 0.0077736, 0.019811, 1.5915e-3, *FRICTION, 0.0)
Y = Plant(7.5768, 0.4769, 0.0098109, 0.28438, 1.5915e-3, *FRICTION, 0.0)
AL7075 = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
LIMITS = Limits(0.169, 2.0, 50.0)
PRINTED_X = (500.0, 70.0, 0.3, 0.0, -2.37e-6)
PRINTED_Y = (462.539, 64.75, 0.278, 0.0, 5.55e-4)
OMEGA = 8000 * math.pi / 30


def laws(reading, sample_time=1e-3, encoder=0.0, delay=0.0, **gains):
    """Controllers of both axes under a reading; gains in the units of the table, V and mm."""
    x, y = PRINTED_X, PRINTED_Y
    if reading != "as_printed":
        x, y = (x[1], x[0], *x[2:]), (y[1], y[0], *y[2:])
    if reading == "matched":
        x, y = y, x
    x, y = (list(g) for g in (x, y))
    if "k1" in gains:
        x[3], y[3] = gains["k1"]
    if "k2" in gains:
        x[4], y[4] = gains["k2"]
    return tuple(Controller(*(1e3 * k for k in g), sample_time, 10.0, encoder, delay) for g in (x, y))


def run(
    fillet, reading="kp_ki_swapped", law=DISCS, substeps=10, plants=(X, Y), tail=1.0, modes=None, edges=None, **options
):
    """Contour error, time, force and the rest of the reference corner, in µm, s, V, N."""
    curve = join(corner(0.03, 0.5 * math.pi, fillet))
    planned = plan(curve, np.full(curve.count, 0.04), LIMITS)
    controllers = laws(reading, **options)
    step = controllers[0].sample_time
    reference = sampled(curve, [planned.profile], step, tail)
    arcs = path_contact(curve, np.ones(curve.count, bool), reference.block, reference.travelled, 0.01, 0.004)
    arcs[reference.travelled >= curve.knots[-1]] = 0.0
    point = np.ascontiguousarray(reference.point[:, :2])
    velocity = central_difference(point, step)
    order = SetPoints(
        point, velocity, central_difference(velocity, step),
        np.arctan2(reference.direction[:, 1], reference.direction[:, 0]), reference.travelled,
    )  # fmt: skip
    pair = (Drive(plants[0], controllers[0]), Drive(plants[1], controllers[1]))
    mill = Mill(0.01, 3, math.radians(30))
    cut = Cut(law, mill, discs(0.01, mill.helix, 0.005, 3, 20), edges or even_edges(AL7075), OMEGA)
    history = run_drives(order, wall_patches(arcs, 0.005), pair, cut, substeps, modes=modes)
    error = contour_errors(curve, reference.block, history.position, True)
    lag = np.abs(point - history.position).max(axis=0)
    return {
        "time": planned.profile.duration,
        "max": 1e6 * np.abs(error).max(),
        "rms": 1e6 * math.sqrt(np.mean(error**2)),
        "tracking": 1e6 * lag,
        "voltage": np.abs(history.voltage).max(),
        "overshoot": 1e6 * (history.position[reference.time >= reference.end, 1].max() - 0.03),
        "peak": history.force_peak[:, 3].max(),
        "steps": planned.curvature_steps,
        "history": history,
        "error": error,
    }


__all__ = ["AVERAGED", "DISCS", "NO_FORCE", "run"]


def corner_immersion(px, py, heading, shape):
    """Closed form for an obtuse or right corner and a_e < R: from the wall side to the first crossing of the rim with
    the edge that the previous pass has left, a line, an arc of radius max(rho - a_e, 0) + R, and a line."""
    radius, depth, turn = shape.mill_radius, shape.radial_depth, shape.turn
    b = max(shape.fillet, depth)
    wall, gap, foot = heading - 0.5 * math.pi, radius - depth, b * math.tan(0.5 * turn)
    angles = [math.pi]

    def meets(x, y):
        angles.append(((math.atan2(y - py, x - px) - wall) % (2.0 * math.pi)) or 2.0 * math.pi)

    for second, (dx, dy) in enumerate(((1.0, 0.0), (math.cos(turn), math.sin(turn)))):
        along, off = px * dx + py * dy, -px * dy + py * dx
        if (square := radius**2 - (off + gap) ** 2) >= 0.0:
            for q in (along - math.sqrt(square), along + math.sqrt(square)):
                if (second and q >= foot) or (not second and q <= -foot):
                    meets(q * dx + gap * dy, q * dy - gap * dx)
    cx, cy, bound = -foot, b, b - depth + radius
    distance = math.hypot(px - cx, py - cy)
    if 0.0 < distance <= radius + bound and distance >= abs(radius - bound):
        axial = (distance**2 + bound**2 - radius**2) / (2.0 * distance)
        side = math.sqrt(max(bound**2 - axial**2, 0.0))
        ux, uy = (px - cx) / distance, (py - cy) / distance
        for sign in (-1.0, 1.0):
            x, y = axial * ux - sign * side * uy, axial * uy + sign * side * ux
            if (math.atan2(y, x) + 0.5 * math.pi) % (2.0 * math.pi) <= turn:
                meets(cx + x, cy + y)
    return min(angles)


def counted_immersion(px, py, heading, shape, points=40_000):
    """Immersion angle from counting rim points outside what the previous pass, and this one before the corner, cleared."""
    radius, depth = shape.mill_radius, shape.radial_depth
    angle = heading - 0.5 * math.pi + (np.arange(points) + 0.5) * math.pi / points
    x, y = px + radius * np.cos(angle), py + radius * np.sin(angle)
    b = max(shape.fillet, depth)
    foot = b * math.tan(0.5 * shape.turn)
    c, s = math.cos(shape.turn), math.sin(shape.turn)
    # centre line of the previous pass: two rays and the arc between, all points within R of it are cleared
    x0, y0 = -foot, b
    inner = b - depth
    along0 = np.minimum(x, -foot)
    first = np.hypot(x - along0, y - depth)
    q = np.maximum(x * c + y * s, foot)
    second = np.hypot(x - (q * c - depth * s), y - (q * s + depth * c))
    spoke = np.arctan2(y - y0, x - x0)
    turned = (spoke + 0.5 * math.pi) % (2.0 * math.pi)
    on_arc = turned <= shape.turn
    third = np.where(on_arc, np.abs(np.hypot(x - x0, y - y0) - inner), np.inf)
    cleared = np.minimum(np.minimum(first, second), third) <= radius
    cleared |= np.hypot(x - np.minimum(x, min(px, -shape.fillet * math.tan(0.5 * shape.turn))), y) < radius * (
        1.0 - 1e-9
    )
    return (~cleared).sum() * math.pi / points
