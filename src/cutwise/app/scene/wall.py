"""A straight wall that is milled: work, floor and the wall that is left along the path of the tool's centre."""

import numpy as np

from cutwise.app.scene.scene import FloatArray, Surface
from cutwise.app.scene.shapes import band, strip
from cutwise.app.scene.thinned import kept
from cutwise.app.scene.toolpath import Toolpath
from cutwise.app.scene.worst import magnification

ENDS = ("wall left standing", "cut into the wall")
_STRIPS = 400  # buckets of a wall that is drawn


def milled_wall(
    toolpath: Toolpath,
    along: FloatArray,
    error: FloatArray,
    depth: float,
    radius: float,
    coloured: str,
    *,
    within: bool = False,
) -> tuple[tuple[Surface, ...], tuple[str, ...]]:
    """Surfaces, and what is drawn larger than it is.

    Parameters
    ----------
    toolpath : Toolpath
        Of the centre of the tool.
    along, error : array, shape (n,)
        Places along it, rising, and the error of the wall there, positive into the work [m]; NaN where none is left.
    depth, radius : float
        Axial depth of the cut and radius of the tool [m].
    coloured : str
        The history whose colours the wall takes.
    within : bool
        The part about it is drawn: the work behind the wall is not.
    """
    times = magnification(radius, float(np.nanmax(np.abs(error), initial=0.0)))
    keep = kept([error], _STRIPS)
    s, left = along[keep], error[keep]
    face = -radius - times * np.nan_to_num(left)

    def at(off: FloatArray | float, up: float) -> FloatArray:
        return toolpath.on(s, off, up)

    wall, corners = band([at(face, 0.0), at(face, depth)])
    back = -3.0 * radius
    bodies = {
        "floor": [at(face, 0.0), at(radius, 0.0), at(radius, -depth), at(face, -depth)],
        "work": [at(face, depth), at(back, depth), at(back, -depth), at(face, -depth)],
    }
    shown = [Surface(title, *strip(rows)) for title, rows in bodies.items() if title != "work" or not within]
    said = (f"error of the wall drawn {times:g} times",) if times != 1.0 else ()
    return (*shown, Surface("wall", wall, corners, "work", np.tile(left, 2), coloured)), said
