"""Contact of a mill on a trochoidal path: circles whose centres go along a slot."""

import math


def trochoid_contact(psi: float, circle: float, step: float, radius: float) -> tuple[float, float]:
    r"""Arc of contact of a mill on a circle, after the circle before has been cut, from the wall side [rad].

    With :math:`A = r_t + s\cos\psi`, :math:`B = s\sin\psi`, :math:`\delta = \operatorname{atan2}(B, A)` and

    .. math:: \cos a = \frac{2 r_t R - s^2 - 2 r_t s \cos\psi}{2 R \sqrt{A^2 + B^2}}

    the mill is in contact from :math:`\max(0, -\delta - a)` to :math:`a - \delta`.

    Parameters
    ----------
    psi : float
        Angle :math:`\psi` of the mill on its circle, from the direction of the slot [rad].
    circle, step, radius : float
        Radius :math:`r_t` of the circles, their distance s, radius R of the mill [m].

    Returns
    -------
    tuple
        First and last angle of contact [rad], counted from the right of the feed; equal where there is none.

    Notes
    -----
    Valid for circles run counter-clockwise (climb), and s below the radius of the circles and of the mill; the first circle
    is a full slot.

    Examples
    --------
    R 10, r_t 4, s 2 mm: the largest contact is 69.513 degrees.

    >>> round(math.degrees(largest_contact(0.004, 0.002, 0.010)), 3)
    69.513

    References
    ----------
    Derived here: the rim of the mill against that on the circle before.
    """
    a, b = circle + step * math.cos(psi), step * math.sin(psi)
    turn, apart = math.atan2(b, a), math.hypot(a, b)
    cosine = (2.0 * circle * radius - step * step - 2.0 * circle * step * math.cos(psi)) / (2.0 * radius * apart)
    half = math.acos(max(-1.0, min(1.0, cosine)))
    low, high = max(0.0, -turn - half), half - turn
    return (low, high) if high > low else (0.0, 0.0)


def largest_contact(circle: float, step: float, radius: float, looks: int = 20_000) -> float:
    """Largest arc of contact over a circle [rad]; parameters of :func:`trochoid_contact`."""
    found = (trochoid_contact(2.0 * math.pi * k / looks, circle, step, radius) for k in range(looks))
    return max(high - low for low, high in found)
