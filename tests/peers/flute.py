"""Plain, slow versions of the flute forces: the sliced integral, and an exact trochoid."""

import math

import numpy as np


def sliced_force(rotation, lo, hi, chip, theta, z_lo, z_hi, mill, k, slices):
    """Midpoint rule over the flutes, straight from Eqs. (2)-(5) and (9): who is in the arc cuts."""
    dz = (z_hi - z_lo) / slices
    z = z_lo + dz * (np.arange(slices) + 0.5)
    total = np.zeros(3)
    for flute in range(mill.flutes):
        phi = rotation + flute * 2 * math.pi / mill.flutes - math.tan(mill.helix) / mill.radius * z
        turns = np.ceil((lo - phi) / (2 * math.pi))
        for turn in range(2):  # an arc may be wider than one turn is left of
            at = phi + 2 * math.pi * (turns + turn)
            at = at[(at >= lo) & (at <= hi)]
            h = chip * np.sin(at - theta)
            ft = k.K_tc * h + k.K_te
            fr = k.K_rc * h + k.K_re
            fa = k.K_ac * h + k.K_ae
            total += dz * np.array(
                [
                    (-ft * np.cos(at) - fr * np.sin(at)).sum(),
                    (ft * np.sin(at) - fr * np.cos(at)).sum(),
                    fa.sum(),
                ]
            )
    return total


def trochoid_forces(depth, work_depth, speed, omega, mill, width, k, points=200_000):
    """Mean burr and work force per metre of width from exact tooth paths; (2, 3).

    The chip of a tooth reaches from its own path to that of the tooth before, measured along the radius. Material is
    what stands below the top of the burr and what the tooth before has left.
    """
    phi = (np.arange(points) + 0.5) * 2 * math.pi / points
    pitch = 2 * math.pi / mill.flutes
    radius = mill.radius
    # the tooth before passed the same direction about one pitch earlier: solve for when, by fixed point
    before = np.full(points, -pitch / omega)
    for _ in range(40):
        # a tooth ahead by one pitch: its angle at time t' is phi + pitch + omega t'
        px = speed[0] * before + radius * np.sin(phi + pitch + omega * before)
        py = speed[1] * before + radius * np.cos(phi + pitch + omega * before)
        angle = np.arctan2(px, py)
        before -= np.angle(np.exp(1j * (angle - phi))) / omega
    h = radius - np.hypot(px, py)
    y = radius * np.cos(phi) + radius  # above the lowest point of the mill
    cuts = (h > 0) & (y <= max(depth, work_depth))
    ft, fr, fa = (c * h + e for c, e in ((k.K_tc, k.K_te), (k.K_rc, k.K_re), (k.K_ac, k.K_ae)))
    force = np.array([-ft * np.cos(phi) - fr * np.sin(phi), ft * np.sin(phi) - fr * np.cos(phi), fa])
    weight = mill.flutes * width / points
    in_work = y < work_depth
    return np.array([(force * (cuts & ~in_work)).sum(1), (force * (cuts & in_work)).sum(1)]) * weight
