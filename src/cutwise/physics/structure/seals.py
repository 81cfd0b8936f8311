r"""One piston against its seal: what a face that is pushed onto it feels, by the friction law in use.

The position of a piston is a state of its own: pushed by the face, or coming out as far as pressure and friction let it.
"""

import math
from typing import NamedTuple

from cutwise.maths.compiled import inlined

NO_FRICTION = 0
SET_VALUED = 1
PRESLIDING = 2
REGULARISED = 3
TOUCH = 1e-12  # [m] a face closer than this touches its piston
STUCK_SPEED = 1e-6  # [m/s] a piston slower than this counts as stuck


class Piston(NamedTuple):
    """One piston and its seal, at one pressure."""

    stroke: float  # [m] travel from the extended dead point to the other
    pressure_force: float  # [N]
    friction_static: float  # [N]
    friction_dynamic: float  # [N]
    law: int  # NO_FRICTION, SET_VALUED, PRESLIDING or REGULARISED
    breakaway_travel: float  # [m] elastic travel of the seal before it slips (presliding)
    stribeck_speed: float  # [m/s] of the fall from static to dynamic friction, or of the regularised law; 0: at once
    damping: float  # [N s/m] viscous, of the rubber


@inlined
def friction_limit(piston: Piston, speed: float) -> float:
    r"""Friction limit of a seal that moved with a speed in the last step [N].

    .. math:: F = F_d + (F_s - F_d) e^{-(v/v_s)^2}

    With :math:`v_s = 0` the fall is at once, decided by the last step: static while stuck, dynamic when sliding. The
    step then is a convex program. With a Stribeck speed the limit follows the speed of the step itself, sweep by sweep.
    The regularised law is :math:`F_s \tanh(v / v_s)` and has no stick to fall from.

    Parameters
    ----------
    piston : Piston
        Seal with :math:`F_s, F_d` [N], :math:`v_s` [m/s] and its law.
    speed : float
        v [m/s], of either sign; slower than ``STUCK_SPEED`` counts as stuck where :math:`v_s = 0`.

    Returns
    -------
    float
        Limit [N], not negative.

    Notes
    -----
    Valid for :math:`F_d \le F_s` at one pressure, which is in both (:func:`friction_at`); no dwell time, no temperature.

    Examples
    --------
    Stuck, sliding, and at the Stribeck speed, where :math:`2.8 + 1.1/e` is left.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 0.0)
    >>> friction_limit(seal, 0.0), friction_limit(seal, 0.1)
    (3.9, 2.8)
    >>> round(friction_limit(seal._replace(stribeck_speed=0.01), 0.01), 6)
    3.204667

    References
    ----------
    Berselli et al. 2016, sec. 3.3 (two coefficients, no law between them); Armstrong-Hélouvry, Dupont and Canudas de
    Wit 1994, Automatica 30 (Gaussian fall).
    """
    if piston.law == NO_FRICTION:
        return 0.0
    if piston.law == REGULARISED:
        return piston.friction_static
    if piston.stribeck_speed > 0.0:
        ratio = speed / piston.stribeck_speed
        return piston.friction_dynamic + (piston.friction_static - piston.friction_dynamic) * math.exp(-ratio * ratio)
    return piston.friction_static if abs(speed) < STUCK_SPEED else piston.friction_dynamic


@inlined
def pushed_position(
    piston: Piston, limit: float, free: float, yielding: float, old: float, anchor: float, dt: float
) -> float:
    r"""Where the motor face comes to rest against one piston that it pushes, all other pistons held.

    Solves :math:`(s - s_f) / d + N(s) = 0` for a piston in contact (x = s), with :math:`N = F_p + F_f(s)`,
    :math:`d` the yielding of the face [m/N] and :math:`s_f` where it would go freely. N rises with s, so the root is
    unique; for the set-valued law and the seal spring it is in closed form.

    Parameters
    ----------
    piston : Piston
        The piston and the law of its seal.
    limit : float
        Friction limit of the step [N], from :func:`friction_limit`.
    free : float
        :math:`s_f` [m], without this piston.
    yielding : float
        :math:`d = \Delta t^2 l_p^2 / I` [m/N], positive.
    old, anchor : float
        Position of the piston and anchor of its seal before the step [m].
    dt : float
        Time step [s]; counts for the regularised law.

    Returns
    -------
    float
        s [m]; neither stops nor loss of contact are looked at, see :func:`contact_force`.

    Notes
    -----
    Valid for a piston without mass in touch with the face. The regularised law is met to :math:`d F_s / 2^{60}`, the
    others to rounding.

    Examples
    --------
    Pushed 2 mm, the face rests where 1.16 mm of yielding carry 7.7 N of pressure and 3.9 N of friction; pushed 1 mm, the
    seal holds it.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 0.0)
    >>> [round(1e3 * pushed_position(seal, 3.9, free, 1e-4, 0.0, 0.0, 1e-5), 9) for free in (0.002, 0.001)]
    [0.84, 0.0]

    References
    ----------
    Derived here: one row of Moreau's step with the forces of Berselli et al. 2016, sec. 3.3.
    """
    pressed = free - yielding * piston.pressure_force
    if piston.law == PRESLIDING:
        stiffness = piston.friction_static / piston.breakaway_travel
        s = (pressed + yielding * stiffness * anchor) / (1.0 + yielding * stiffness)
        if stiffness * (s - anchor) > limit:
            s = pressed - yielding * limit
        elif stiffness * (s - anchor) < -limit:
            s = pressed + yielding * limit
        return s
    if piston.law == REGULARISED:
        low = pressed - yielding * limit
        high = pressed + yielding * limit
        for _ in range(60):
            s = 0.5 * (low + high)
            if s - pressed + yielding * limit * math.tanh((s - old) / (dt * piston.stribeck_speed)) > 0.0:
                high = s
            else:
                low = s
        return 0.5 * (low + high)
    if pressed - yielding * limit > old:
        return pressed - yielding * limit
    if pressed + yielding * limit < old:
        return pressed + yielding * limit
    return old


@inlined
def free_return(piston: Piston, limit: float, old: float, anchor: float, dt: float) -> float:
    r"""Where a piston comes to rest that nothing touches: back at the dead point, or where friction holds it [m].

    .. math:: c\,(x_{old} - x) / \Delta t = F_p - F, \qquad x \ge 0

    Without damping c it is back at once if pressure is more than friction; less than friction, it stays (set-valued),
    relaxes its seal (presliding) or creeps at :math:`v_s \tanh^{-1}(F_p/F_s)` (regularised, damping left out).

    Parameters
    ----------
    piston : Piston
        Piston with pressure force :math:`F_p` [N] and damping c [N s/m].
    limit : float
        Friction limit F [N].
    old, anchor : float
        Position of the piston and anchor of its seal before the step [m].
    dt : float
        Time step [s].

    Returns
    -------
    float
        Position [m], from 0, the extended dead point, to ``old``.

    Notes
    -----
    Valid for pistons whose mass and air flow take no time; c is the only thing that does.

    Examples
    --------
    3.8 N against 10 N s/m drive it 0.38 mm in 1 ms; friction of 8 N holds it.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 10.0)
    >>> [round(1e3 * free_return(seal, limit, 0.001, 0.0, 0.001), 9) for limit in (3.9, 8.0)]
    [0.62, 1.0]

    References
    ----------
    Derived here from the forces of Berselli et al. 2016, sec. 3.3.
    """
    if piston.law == PRESLIDING:
        stiffness = piston.friction_static / piston.breakaway_travel
        if piston.pressure_force <= limit:
            return max(0.0, min(old, anchor - piston.pressure_force / stiffness))
    elif piston.law == REGULARISED and piston.pressure_force < limit:
        return max(0.0, old - dt * piston.stribeck_speed * math.atanh(piston.pressure_force / limit))
    if piston.pressure_force <= limit:
        return old
    if piston.damping == 0.0:
        return 0.0
    return max(0.0, old - dt * (piston.pressure_force - limit) / piston.damping)


@inlined
def contact_force(
    piston: Piston, limit: float, free: float, yielding: float, old: float, anchor: float, dt: float
) -> float:
    r"""Contact force of one piston on the motor, all others held: the prox of its convex potential [N].

    The face either stays clear of the piston (no force), rests on it at its own free position, pushes it, or drives
    it into the inner dead point.

    .. math:: N = (s_f - s) / d, \qquad x_r \le s \le s_{max}

    with :math:`x_r` of :func:`free_return` and s of :func:`pushed_position`; viscous damping c makes that step with
    :math:`s_f' = (s_f + d c\,x_{old}/\Delta t)/h` and :math:`d' = d/h`, :math:`h = 1 + d c/\Delta t`.

    Parameters
    ----------
    piston : Piston
        The piston and the law of its seal.
    limit : float
        Friction limit [N].
    free : float
        :math:`s_f`, position of the face without this piston [m].
    yielding : float
        d [m/N], positive.
    old, anchor : float
        Position of the piston and anchor of its seal before the step [m].
    dt : float
        Time step [s].

    Returns
    -------
    float
        N [N], never negative: the piston is not fastened to the motor.

    Notes
    -----
    Valid for inelastic stops; at the inner one the force is whatever stops the motor.

    Examples
    --------
    Clear, holding, pushed (pressure and friction: 11.6 N), and on the stop: 6 mm less 4 mm over the yielding.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, SET_VALUED, 0.0, 0.0, 0.0)
    >>> [round(contact_force(seal, 3.9, free, 1e-4, 0.0, 0.0, 1e-5), 6) for free in (-0.001, 0.001, 0.002, 0.006)]
    [0.0, 10.0, 11.6, 20.0]

    References
    ----------
    Berselli et al. 2016, sec. 3.3 (the three contacts of a piston); Moreau 1965, Bull. Soc. Math. France 93 (prox).
    """
    rest = free_return(piston, limit, old, anchor, dt)
    if free <= rest:
        return 0.0
    if piston.damping == 0.0:
        s = pushed_position(piston, limit, free, yielding, old, anchor, dt)
    else:
        hold = 1.0 + yielding * piston.damping / dt  # viscous force (s - old) / dt folded into the free position
        damped = (free + (hold - 1.0) * old) / hold
        s = pushed_position(piston, limit, damped, yielding / hold, old, anchor, dt)
    s = min(max(s, rest), piston.stroke)
    return (free - s) / yielding


@inlined
def dragged_anchor(piston: Piston, limit: float, x: float, anchor: float) -> float:
    r"""Where a seal is anchored after its piston came to x: it follows once the spring is at its limit [m].

    .. math:: |x - z| \le F\, x_b / F_s

    Parameters
    ----------
    piston : Piston
        Seal with static friction :math:`F_s` [N] and elastic travel :math:`x_b` [m].
    limit : float
        Friction limit F of the step [N].
    x : float
        Position of the piston after the step [m].
    anchor : float
        z before the step [m].

    Returns
    -------
    float
        z after it; the position itself where the seal has no spring.

    Notes
    -----
    Valid for one spring of even stiffness that slips at once (Jenkins element); rubber itself softens before it slips.

    Examples
    --------
    A seal that yields 0.1 mm before it slips is 0.1 mm behind its piston.

    >>> seal = Piston(0.004, 7.7, 3.9, 2.8, PRESLIDING, 0.0001, 0.0, 0.0)
    >>> round(1e3 * dragged_anchor(seal, 3.9, 0.001, 0.0), 9)
    0.9

    References
    ----------
    Derived here: the Prandtl (Jenkins) element as a stop operator.
    """
    if piston.law != PRESLIDING:
        return x
    reach = limit * piston.breakaway_travel / piston.friction_static
    return min(max(anchor, x - reach), x + reach)


def friction_at(force_at_reference: float, pressure: float, reference: float, preload_fraction: float) -> float:
    r"""Seal friction at a pressure: :math:`F(p) = F(p_0) [f + (1 - f) p / p_0]`.

    The preload share f stays at zero pressure: the paper's :math:`\mu (A p + P)` with one unknown (sec. 3.3).

    Valid for pressures [Pa] not below zero; ``preload_fraction`` f is from 0 to 1.

    References
    ----------
    Berselli et al. 2016, sec. 3.3.
    """
    return force_at_reference * (preload_fraction + (1.0 - preload_fraction) * pressure / reference)
