"""Centre paths of pocket corners."""

import math

from cutwise.maths.linearc import Block, arc, line


def corner(lead: float, turn: float, fillet: float) -> list[Block]:
    """Along +x to the corner point (0, 0), left by ``turn`` [rad] about an arc of radius ``fillet`` [m], and on.

    Both legs reach ``lead`` [m] from the corner point; a fillet of zero is a sharp corner.

    Examples
    --------
    A fillet of 10 mm in a right angle, legs of 100 mm: 90 mm, a quarter of a turn, 90 mm.

    >>> [round(1e3 * block.length, 6) for block in corner(0.1, 0.5 * math.pi, 0.01)]
    [90.0, 15.707963, 90.0]
    """
    dx, dy = math.cos(turn), math.sin(turn)
    start, end = (-lead, 0.0), (lead * dx, lead * dy)
    if fillet == 0.0:
        return [line(start, (0.0, 0.0)), line((0.0, 0.0), end)]
    cut = fillet * math.tan(0.5 * turn)
    return [
        line(start, (-cut, 0.0)),
        arc((-cut, 0.0), (-cut, fillet), turn),
        line((cut * dx, cut * dy), end),
    ]
