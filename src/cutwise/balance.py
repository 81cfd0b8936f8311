"""The force of the cut, and the displacement of a structure without inertia that the force at that displacement gives."""

import math

from cutwise.maths.compiled import inlined_stepping
from cutwise.stages import axial, cut, held, met, pivot, probed, settled, yielded

CLOSE = 1e-14  # [m] of a displacement that is solved for with the force
HARMLESS = 1e-9  # [m] by which it may be missed where rounding does not let it come closer
TRIALS = 60  # looks at the force in one step; a step that takes them all has not found its displacement


@inlined_stepping
def look(cell, flexed, pose, contact, load):  # type: ignore[no-untyped-def]
    """The force of the cut with the tool displaced as its structure stands; returns the number of rows of contact."""
    _, engagement, stock, cutting, structure = cell
    load.layer[:] = 0.0
    load.total[:] = 0.0
    count = met(engagement, stock, pose, structure, flexed, contact)
    cut(cutting, contact, count, pose.time, pivot(structure), load)
    return count


@inlined_stepping
def balance(cell, flexed, pose, contact, load, guess):  # type: ignore[no-untyped-def]
    r"""Solve for the displacement u of the terms without inertia that the force at that displacement gives.

    :math:`g(u) = u - C W(u) = 0` at the height where the surface is read: along y, and along z too where the contact
    depends on it. The plain fixed point :math:`u \leftarrow C W(u)` diverges where the cut is stiffer than the
    structure.

    Parameters
    ----------
    guess : array
        Slopes of g in the last step, shape (4,); changed.

    Returns
    -------
    tuple
        Number of rows of contact, and of looks at the force; ``TRIALS`` of them have not found the displacement.
    """
    foot, above = probed(cell.engagement, pose)
    height = foot + above
    if axial(cell.engagement):
        return balance_of_two(cell, flexed, pose, contact, load, guess, height)
    return balance_of_one(cell, flexed, pose, contact, load, guess, height)


@inlined_stepping
def balance_of_one(cell, flexed, pose, contact, load, guess, height):  # type: ignore[no-untyped-def]
    """Along y, by the secant rule inside a bracket.

    A force that falls as the tool retreats makes g rise with a slope of at least one, so that the root lies between u
    and u - g.
    """
    structure = cell.structure
    arm = pivot(structure)
    u = held(structure, flexed, height)[0]
    count = look(cell, flexed, pose, contact, load)
    g = u - yielded(structure, flexed, pose, load, arm, height)[0]
    low, high = -math.inf, math.inf
    trials = 1
    while abs(g) > CLOSE and trials < TRIALS:
        if g > 0.0:
            high = u
        else:
            low = u
        new = u - g / (guess[0] if guess[0] > 0.0 else 1.0)
        if new <= low or new >= high:
            new = 0.5 * (low + high)
        settled(structure, flexed, new - (u - g), 0.0)
        count = look(cell, flexed, pose, contact, load)
        fresh = new - yielded(structure, flexed, pose, load, arm, height)[0]
        if new != u and math.isfinite(fresh):
            guess[0] = (fresh - g) / (new - u)
        u, g = new, fresh
        trials += 1
    trials = min(trials, TRIALS - 1) if abs(g) < HARMLESS else TRIALS
    settled(structure, flexed, 0.0, 0.0)  # all of the twist is that of the last force: work and energy agree
    return count, trials


@inlined_stepping
def balance_of_two(cell, flexed, pose, contact, load, guess, height):  # type: ignore[no-untyped-def]
    r"""Along y and z, by Broyden's rule from the slopes of the last step.

    :math:`J \leftarrow J + (\Delta g - J \Delta u)\,\Delta u^T / |\Delta u|^2`; a step that makes g larger is halved.
    """
    structure = cell.structure
    arm = pivot(structure)
    y, z = held(structure, flexed, height)
    count = look(cell, flexed, pose, contact, load)
    want_y, want_z = yielded(structure, flexed, pose, load, arm, height)
    gy, gz = y - want_y, z - want_z
    trials = 1
    share = 1.0
    while max(abs(gy), abs(gz)) > CLOSE and trials < TRIALS:
        determinant = guess[0] * guess[3] - guess[1] * guess[2]
        if determinant == 0.0 or not math.isfinite(determinant):
            guess[0], guess[1], guess[2], guess[3] = 1.0, 0.0, 0.0, 1.0
            determinant = 1.0
        step_y = -share * (guess[3] * gy - guess[1] * gz) / determinant
        step_z = -share * (guess[0] * gz - guess[2] * gy) / determinant
        settled(structure, flexed, y + step_y - want_y, z + step_z - want_z)
        count = look(cell, flexed, pose, contact, load)
        want_y, want_z = yielded(structure, flexed, pose, load, arm, height)
        new_y, new_z = y + step_y - want_y, z + step_z - want_z
        square = step_y * step_y + step_z * step_z
        if square > 0.0:
            miss_y = (new_y - gy - guess[0] * step_y - guess[1] * step_z) / square
            miss_z = (new_z - gz - guess[2] * step_y - guess[3] * step_z) / square
            guess[0] += miss_y * step_y
            guess[1] += miss_y * step_z
            guess[2] += miss_z * step_y
            guess[3] += miss_z * step_z
        share = 1.0 if math.hypot(new_y, new_z) <= 2.0 * math.hypot(gy, gz) else 0.5
        y, z, gy, gz = y + step_y, z + step_z, new_y, new_z
        trials += 1
    trials = min(trials, TRIALS - 1) if abs(gy) < HARMLESS and abs(gz) < HARMLESS else TRIALS  # so NaN is not found
    settled(structure, flexed, 0.0, 0.0)
    return count, trials
