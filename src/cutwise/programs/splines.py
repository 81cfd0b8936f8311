"""Splines in the XY plane: G5 and G5.1 (cubic, quadratic), G5.2 to G5.3 (NURBS)."""

from cutwise.programs.block import Block
from cutwise.programs.canon import Spline
from cutwise.programs.controller import Controller
from cutwise.programs.groups import MOTION
from cutwise.programs.motions import check_feed, target


def _check(c: Controller, block: Block) -> None:
    assert block.motion is not None
    word = MOTION[block.motion]
    if c.plane != "XY":
        raise block.fault(f"{word} needs the XY plane (G17)", "g.motion")
    if c.compensation is not None:
        raise block.fault(f"{word} cannot be used with cutter compensation; write G40 before", "g.motion")
    for letter in "zabcuvw@^":
        if letter in block.values:
            raise block.fault(f"{word}: splines lead in X and Y only", letter)


def spline(c: Controller, block: Block) -> None:
    """G5: cubic, its inner control points I J from the start and P Q from the end; G5.1: quadratic, I J."""
    _check(c, block)
    check_feed(c, block)
    x, y = c.at[0], c.at[1]
    end = target(c, block)
    v, word = block.values, MOTION[block.motion or 50]
    if ("i" in v) != ("j" in v) or (block.motion == 51 and "i" not in v):
        raise block.fault(f"{word} needs both I and J", "i", "j", "g.motion")
    if block.motion == 51:
        inner = [(x + v["i"], y + v["j"])]
    else:
        if "p" not in v or "q" not in v:
            raise block.fault("G5 needs both P and Q", "p", "q", "g.motion")
        i, j = (v["i"], v["j"]) if "i" in v else c.spline_tangent or (0.0, 0.0)
        inner = [(x + i, y + j), (end[0] + v["p"], end[1] + v["q"])]
        c.spline_tangent = (-v["p"], -v["q"])
    points = ((x, y), *inner, (end[0], end[1]))
    c.at[:] = end
    c.out.append(Spline(points, (1.0,) * len(points), len(points), c.line, c.number))


def control_point(c: Controller, block: Block) -> None:
    """G5.2 and the blocks behind it: control points X Y with their weight P; L on the first is the order."""
    _check(c, block)
    v = block.values
    if c.spline is None:
        check_feed(c, block)
        c.spline, c.spline_order = [(c.at[0], c.at[1], v.get("p", 1.0))], 3
    order = block.whole("l")
    c.spline_order = max(c.spline_order, order or 0)
    if "x" not in v and "y" not in v:
        return
    if "x" not in v or "y" not in v:
        raise block.fault("a control point needs both X and Y", "x", "y")
    weight = v.get("p", 1.0 if "motion" in block.g and len(c.spline) == 1 else 0.0)
    if weight <= 0.0:
        raise block.fault("a control point needs a positive weight P", "p", "x")
    end = target(c, block)
    c.spline.append((end[0], end[1], weight))


def close(c: Controller, block: Block) -> None:
    """G5.3: the NURBS through what was collected."""
    _check(c, block)
    if c.spline is None:
        raise block.fault("G5.3 closes a NURBS block, but none was opened with G5.2", "g.motion")
    points, c.spline = c.spline, None
    c.motion = 800
    if len(points) < c.spline_order:
        raise block.fault(f"a NURBS of order {c.spline_order} needs as many control points, there are {len(points)}",
                          "g.motion")  # fmt: skip
    c.at[0], c.at[1] = points[-1][:2]
    places, weights = tuple((x, y) for x, y, _ in points), tuple(w for *_, w in points)
    c.out.append(Spline(places, weights, c.spline_order, c.line, c.number))
