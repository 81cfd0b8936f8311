"""Centre paths of pocket corners."""

import math

from cutwise.maths.linearc import Block, arc, line


def corner(lead: float, turn: float, fillet: float) -> list[Block]:
    """Along +x to the corner point (0, 0), left by ``turn`` [rad] about an arc of radius ``fillet`` [m], and on.

    Both legs reach ``lead`` [m] from the corner point; a fillet of zero is a sharp corner.
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
