"""The flutes of a turning mill in a material: the force of each row of contact, by the law in use."""

import math
from typing import NamedTuple

from cutwise.maths.compiled import inlined_stepping
from cutwise.physics.cutting.flute import FluteForce, Mill, mean_force, mirrored, tooth_force
from cutwise.physics.cutting.uneven import (
    Edges,
    even_and_linear,
    force_per_length,
    turning_mean_force,
    uneven_tooth_force,
    whole_turn_force,
)
from cutwise.stages import cut, stage


class MeanFlutes(NamedTuple):
    """A turning mill in a material, its force averaged over a tooth period."""

    mill: Mill
    edges: Edges  # force law, coefficients and run-out
    spindle_speed: float  # [rad/s]
    up_milling: bool


class TurnFlutes(NamedTuple):
    """A turning mill in a material, its force averaged over a whole turn: what a structure at rest answers to."""

    mill: Mill
    edges: Edges
    up_milling: bool


class ToothFlutes(NamedTuple):
    """A turning mill in a material, tooth by tooth."""

    mill: Mill
    edges: Edges
    spindle_speed: float  # [rad/s]
    up_milling: bool


class ChipFlutes(NamedTuple):
    """A turning mill in a material, its force averaged over a tooth period, from the chip that each column loses."""

    mill: Mill
    edges: Edges
    up_milling: bool


@stage
def arc_force(cutting, chip, theta, lo, hi, foot, width, time):
    """Force of one arc over a strip of the mill, in down milling."""


@arc_force.of(MeanFlutes)
def _(cutting, chip, theta, lo, hi, foot, width, time):
    """In closed form where flutes are even and the law is linear, quadrature elsewhere."""
    mill, edges = cutting.mill, cutting.edges
    length = (foot + width) - foot
    if even_and_linear(edges):
        return mean_force(lo, hi, chip, theta, length, mill.flutes, edges.linear)
    rotation = (cutting.spindle_speed * time) % (2.0 * math.pi)
    return turning_mean_force(rotation, lo, hi, chip, theta, length, mill, edges)


@arc_force.of(TurnFlutes)
def _(cutting, chip, theta, lo, hi, foot, width, time):
    """Over a whole turn; without run-out every tooth is like the next."""
    mill, edges = cutting.mill, cutting.edges
    if even_and_linear(edges):
        return mean_force(lo, hi, chip, theta, (foot + width) - foot, mill.flutes, edges.linear)
    return whole_turn_force(lo, hi, chip, theta, (foot + width) - foot, mill, edges)


@arc_force.of(ToothFlutes)
def _(cutting, chip, theta, lo, hi, foot, width, time):
    """As the teeth stand at a time."""
    mill, edges = cutting.mill, cutting.edges
    rotation = (cutting.spindle_speed * time) % (2.0 * math.pi)
    if even_and_linear(edges):
        return tooth_force(rotation, lo, hi, chip, theta, foot, foot + width, mill, edges.linear)
    return uneven_tooth_force(rotation, lo, hi, chip, theta, foot, foot + width, mill, edges)


@inlined_stepping
def put(load, layer: int, force: FluteForce, arm: float) -> None:  # type: ignore[no-untyped-def]
    """Add a force that acts at an arm below the pivot to a load.

    The force laws count F_z as the paper does; a right-hand helix on a right-hand cut pulls the tool out of its
    holder, so a structure feels the other sign.

    Parameters
    ----------
    load : Load
        Changed in place: the force by layer [N], and the total with its moments about the pivot [N m].
    layer : int
        Layer of the work, 0 for the burr.
    force : FluteForce
        [N]
    arm : float
        Distance of the force below the pivot [m].

    Notes
    -----
    Valid for a right-hand tool that turns clockwise seen from the motor (M3).

    Examples
    --------
    >>> import numpy as np
    >>> from cutwise.records import Load
    >>> load = Load(np.zeros((1, 3)), np.zeros(6))
    >>> put(load, 0, FluteForce(1.0, 2.0, 3.0, 4.0), 0.1)
    >>> load.total.round(9).tolist()
    [1.0, 2.0, -3.0, 4.0, 0.1, 0.2]

    References
    ----------
    Derived here; the sign of the paper is that of Berselli et al. 2016, Eq. (2).
    """
    by_layer, total = load
    by_layer[layer, 0] += force.x
    by_layer[layer, 1] += force.y
    by_layer[layer, 2] += force.z
    total[0] += force.x
    total[1] += force.y
    total[2] -= force.z
    total[3] += force.tangential
    total[4] += arm * force.x
    total[5] += arm * force.y


@cut.of(MeanFlutes, TurnFlutes, ToothFlutes)
def _(cutting, contact, count, time, pivot, load):
    """Up milling is the mirror image."""
    rows = contact.rows
    for i in range(count):
        lo, hi, theta = rows[i, 3], rows[i, 4], rows[i, 6]
        foot, width = rows[i, 1], rows[i, 2]
        if cutting.up_milling:
            lo, hi, theta = math.pi - hi, math.pi - lo, -theta
        force = arc_force(cutting, rows[i, 5], theta, lo, hi, foot, width, time)
        if cutting.up_milling:
            force = mirrored(force)
        put(load, int(rows[i, 0]), force, pivot - foot - 0.5 * width)


@cut.of(ChipFlutes)
def _(cutting, contact, count, time, pivot, load):
    r"""Over an angle :math:`\Delta\phi` the tooth-averaged force is :math:`N b \Delta\phi / 2\pi` times the force per
    length at the thickness of the chip there."""
    rows = contact.rows
    turn = -1.0 if cutting.up_milling else 1.0
    teeth = cutting.mill.flutes / (2.0 * math.pi)
    x = y = z = tangential = 0.0
    for i in range(count):
        sin_phi, cos_phi, width = rows[i, 3], rows[i, 4], rows[i, 2]
        ft, fr, fa = force_per_length(cutting.edges, rows[i, 6])
        share = teeth * width * rows[i, 5]
        x += share * (-turn * ft * cos_phi - fr * sin_phi)
        y += share * (turn * ft * sin_phi - fr * cos_phi)
        z += share * fa
        tangential += share * ft
        if i + 1 == count or rows[i + 1, 1] != rows[i, 1] or rows[i + 1, 0] != rows[i, 0]:  # the strip ends
            put(load, int(rows[i, 0]), FluteForce(x, y, z, tangential), pivot - rows[i, 1] - 0.5 * width)
            x = y = z = tangential = 0.0
