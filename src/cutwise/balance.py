"""The force of the cut, and the displacement of a structure without inertia that the force at that displacement gives."""

import math

from cutwise.maths.compiled import inlined_stepping, merged
from cutwise.stages import cut, held, met, pivot, probed, settled, spatial, yielded

CLOSE = 1e-14  # [m] of a displacement that is solved for with the force
CLOSE_IN_SPACE = 1e-13  # [m] the same along x, y and z: a look at the force there costs ten times as much
HARMLESS = 1e-9  # [m] by which it may be missed where rounding does not let it come closer
TRIALS = 60  # looks at the force in one step; a step that takes them all has not found its displacement


@merged
def look(cell, flexed, pose, contact, load):
    """The force of the cut with the tool displaced as its structure stands; returns the number of rows of contact."""
    _, engagement, stock, cutting, structure = cell
    load.layer[:] = 0.0
    load.total[:] = 0.0
    count = met(engagement, stock, pose, structure, flexed, contact)
    cut(cutting, contact, count, pose.time, pivot(structure), load)
    return count


@merged
def balance(cell, flexed, pose, contact, load, guess):
    r"""Solve for the displacement u of the terms without inertia that the force at that displacement gives.

    :math:`g(u) = u - C W(u) = 0` at the height where the surface is read: along y, and along x and z too where the
    contact depends on them. The plain fixed point :math:`u \leftarrow C W(u)` diverges where the cut is stiffer than the
    structure.

    Parameters
    ----------
    guess : array
        Slopes of g in the last step, row by row, shape (9,); changed.

    Returns
    -------
    tuple
        Number of rows of contact, and of looks at the force; ``TRIALS`` of them have not found the displacement.
    """
    foot, above = probed(cell.engagement, pose)
    height = foot + above
    if spatial(cell.engagement):
        return balance_of_three(cell, flexed, pose, contact, load, guess, height)
    return balance_of_one(cell, flexed, pose, contact, load, guess, height)


@merged
def balance_of_one(cell, flexed, pose, contact, load, guess, height):
    """Along y, by the secant rule inside a bracket.

    A force that falls as the tool retreats makes g rise with a slope of at least one, so that the root lies between u
    and u - g.
    """
    structure = cell.structure
    arm = pivot(structure)
    u = held(structure, flexed, height)[1]
    count = look(cell, flexed, pose, contact, load)
    g = u - yielded(structure, flexed, pose, load, arm, height)[1]
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
        settled(structure, flexed, 0.0, new - (u - g), 0.0)
        count = look(cell, flexed, pose, contact, load)
        fresh = new - yielded(structure, flexed, pose, load, arm, height)[1]
        if new != u and math.isfinite(fresh):
            guess[0] = (fresh - g) / (new - u)
        u, g = new, fresh
        trials += 1
    trials = min(trials, TRIALS - 1) if abs(g) < HARMLESS else TRIALS
    settled(structure, flexed, 0.0, 0.0, 0.0)  # all of the twist is that of the last force: work and energy agree
    return count, trials


@inlined_stepping
def forget(slopes):
    """Slopes of a cut that does not depend on the displacement: the unit matrix."""
    for i in range(9):
        slopes[i] = 1.0 if i % 4 == 0 else 0.0


@inlined_stepping
def newton_step(slopes, gx, gy, gz):
    """The step to where g vanishes by its slopes J, shape (9,): minus J^-1 g, by Cramer's rule."""
    a, b, c = slopes[0], slopes[1], slopes[2]
    d, e, f = slopes[3], slopes[4], slopes[5]
    g, h, i = slopes[6], slopes[7], slopes[8]
    p, q, r = e * i - f * h, f * g - d * i, d * h - e * g
    determinant = a * p + b * q + c * r
    if determinant == 0.0 or not math.isfinite(determinant):
        forget(slopes)
        return -gx, -gy, -gz
    x = p * gx + (c * h - b * i) * gy + (b * f - c * e) * gz
    y = q * gx + (a * i - c * g) * gy + (c * d - a * f) * gz
    z = r * gx + (b * g - a * h) * gy + (a * e - b * d) * gz
    return -x / determinant, -y / determinant, -z / determinant


@inlined_stepping
def learn(slopes, x, y, z, dx, dy, dz):
    r"""Broyden's rule, from a step :math:`\Delta u` and the change of g.

    :math:`J \leftarrow J + (\Delta g - J \Delta u)\,\Delta u^T / |\Delta u|^2`.
    """
    square = x * x + y * y + z * z
    if square == 0.0:
        return
    for row in range(3):
        at = 3 * row
        change = dx if row == 0 else (dy if row == 1 else dz)
        miss = (change - slopes[at] * x - slopes[at + 1] * y - slopes[at + 2] * z) / square
        slopes[at] += miss * x
        slopes[at + 1] += miss * y
        slopes[at + 2] += miss * z


@merged
def balance_of_three(cell, flexed, pose, contact, load, guess, height):
    """Along x, y and z, by Broyden's rule from the slopes of the last step; a step that makes g larger is halved."""
    structure = cell.structure
    arm = pivot(structure)
    x, y, z = held(structure, flexed, height)
    count = look(cell, flexed, pose, contact, load)
    want_x, want_y, want_z = yielded(structure, flexed, pose, load, arm, height)
    gx, gy, gz = x - want_x, y - want_y, z - want_z
    trials = 1
    share = 1.0
    while max(abs(gx), max(abs(gy), abs(gz))) > CLOSE_IN_SPACE and trials < TRIALS:
        step_x, step_y, step_z = newton_step(guess, gx, gy, gz)
        step_x, step_y, step_z = share * step_x, share * step_y, share * step_z
        settled(structure, flexed, x + step_x - want_x, y + step_y - want_y, z + step_z - want_z)
        count = look(cell, flexed, pose, contact, load)
        want_x, want_y, want_z = yielded(structure, flexed, pose, load, arm, height)
        x, y, z = x + step_x, y + step_y, z + step_z
        new_x, new_y, new_z = x - want_x, y - want_y, z - want_z
        learn(guess, step_x, step_y, step_z, new_x - gx, new_y - gy, new_z - gz)
        before, after = gx * gx + gy * gy + gz * gz, new_x * new_x + new_y * new_y + new_z * new_z
        share = 1.0 if after <= 4.0 * before else 0.5
        gx, gy, gz = new_x, new_y, new_z
        trials += 1
    found = abs(gx) < HARMLESS and abs(gy) < HARMLESS and abs(gz) < HARMLESS  # so NaN is not found
    trials = min(trials, TRIALS - 1) if found else TRIALS
    settled(structure, flexed, 0.0, 0.0, 0.0)
    return count, trials
