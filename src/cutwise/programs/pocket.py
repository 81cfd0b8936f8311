"""Programs that clear a rectangular pocket without islands: contour-parallel, zigzag, trochoidal; in mm."""

import math
from collections.abc import Iterator
from typing import NamedTuple

_LEAST = 1e-9  # [mm]


class Rectangle(NamedTuple):
    """A pocket and how it is cut; lengths in mm, feeds in mm/min."""

    x: tuple[float, float]
    y: tuple[float, float]
    depth: float
    tool: float  # diameter
    step: float  # of passes, or of the centres of circles
    corner: float  # radius of the centre path in the corners
    feed: float
    plunge: float
    speed: float  # [rpm]
    clear: float  # height above the pocket at which the tool travels

    @property
    def half(self) -> tuple[float, float]:
        """Half of the sides that the centre of the tool reaches."""
        return (
            0.5 * (self.x[1] - self.x[0] - self.tool),
            0.5 * (self.y[1] - self.y[0] - self.tool),
        )

    @property
    def middle(self) -> tuple[float, float]:
        """Its centre."""
        return 0.5 * (self.x[0] + self.x[1]), 0.5 * (self.y[0] + self.y[1])


def contour(given: Rectangle) -> str:
    """Passes round the middle from the inside out, climb, joined by quarter circles tangent to both."""
    long, short = given.half
    passes = max(1, math.ceil(short / given.step - _LEAST))
    step = short / passes
    cx, cy = given.middle
    at_x, lines = cx, []
    for k in range(1, passes + 1):
        hx, hy = long - short + k * step, k * step
        if k > 1:
            half = 0.5 * step
            lines += [f"(link to pass {k})", f"G2 {_xy(at_x + half, cy - hy + half)} R{_n(half)}",
                      f"G3 {_xy(at_x + step, cy - hy)} R{_n(half)}"]  # fmt: skip
            at_x += step
        lines += [f"(pass {k})", *_round(cx, cy, hx, hy, min(k * step, given.corner), at_x)]
    off = min(given.step, short)
    lines += ["(off the wall)", f"G3 {_xy(at_x + off, cy - short + off)} R{_n(off)}"]
    return _program(given, "contour", (cx, cy - step), [f"G1 Z{_n(-given.depth)} F{_n(given.plunge)}"], lines)


def zigzag(given: Rectangle) -> str:
    """Rows to and fro along the longer side, then once round along the walls."""
    long, short = given.half
    (cx, cy), along_x = given.middle, given.x[1] - given.x[0] >= given.y[1] - given.y[0]
    if not along_x:
        long, short = short, long
    rows = max(1, math.ceil(2.0 * short / given.step - _LEAST)) + 1
    gap = 2.0 * short / (rows - 1) if rows > 1 else 0.0

    def at(u: float, v: float) -> str:
        return _xy(cx + u, cy + v) if along_x else _xy(cx - v, cy + u)

    lines, side = [], 1.0
    for k in range(rows):
        v = -short + k * gap
        if k:
            lines.append(f"G1 {at(-side * long, v)}")
        lines += [f"(row {k + 1})", f"G1 {at(side * long, v)}"]
        side = -side
    corners = [(-side * long, short), (side * long, short), (side * long, -short), (-side * long, -short)]
    if side > 0.0:  # it ends at the left: counter-clockwise is climb
        corners = [(-long, short), (-long, -short), (long, -short), (long, short), (-long, short)]
    else:
        corners = [(long, short), (-long, short), (-long, -short), (long, -short), (long, short)]
    lines += ["(round the walls)", *(f"G1 {at(u, v)}" for u, v in corners[1:])]
    start = (cx - long, cy - short) if along_x else (cx + short, cy - long)
    return _program(given, "zigzag", start, [f"G1 Z{_n(-given.depth)} F{_n(given.plunge)}"], lines)


def trochoid(given: Rectangle) -> str:
    """Counter-clockwise circles along a slot, joined on its right wall; the first is entered on a helix.

    The rear of each circle is cut again by the next one: it stops at a corner of a right angle there.
    """
    along_x = given.x[1] - given.x[0] >= given.y[1] - given.y[0]
    long, circle = given.half if along_x else given.half[::-1]
    way = 2.0 * (long - circle)
    count = max(1, math.ceil(way / given.step - _LEAST))
    cx, cy = given.middle

    def at(u: float, v: float) -> str:
        return _xy(cx + u, cy + v) if along_x else _xy(cx - v, cy + u)

    def centre(u: float, v: float) -> str:
        i, j = (u, v) if along_x else (-v, u)
        return f"I{_n(i)} J{_n(j)}"

    first = -0.5 * way
    turns = max(1, math.ceil(given.depth / max(0.5 * circle, 0.1)))
    entry = [f"G1 Z0. F{_n(given.plunge)}"]
    entry += [
        f"G3 {at(first, -circle)} Z{_n(-given.depth * k / turns)} {centre(0.0, circle)}" for k in range(1, turns + 1)
    ]
    lines = ["(circle 1, a full slot)", f"G3 {at(first, -circle)} {centre(0.0, circle)}"]
    for k in range(1, count + 1):
        u = min(first + k * given.step, -first)
        lines += [f"G1 {at(u, -circle)}", f"G3 {at(u, -circle)} {centre(0.0, circle)}"]
    start = (cx + first, cy - circle) if along_x else (cx + circle, cy + first)
    return _program(given, "trochoid", start, entry, lines)


STRATEGIES = {"contour": contour, "zigzag": zigzag, "trochoid": trochoid}


def _round(cx: float, cy: float, hx: float, hy: float, r: float, at_x: float) -> Iterator[str]:
    """Once round a rectangle with round corners, counter-clockwise from and back to a place of its lower side."""
    if r <= _LEAST:
        yield from (f"G1 {_xy(cx + u * hx, cy + v * hy)}" for u, v in ((1, -1), (1, 1), (-1, 1), (-1, -1)))
        yield f"G1 {_xy(at_x, cy - hy)}"
        return
    yield f"G1 {_xy(cx + hx - r, cy - hy)}"
    yield f"G3 {_xy(cx + hx, cy - hy + r)} I0. J{_n(r)}"
    if hy - r > _LEAST:
        yield f"G1 {_xy(cx + hx, cy + hy - r)}"
    yield f"G3 {_xy(cx + hx - r, cy + hy)} I{_n(-r)} J0."
    yield f"G1 {_xy(cx - hx + r, cy + hy)}"
    yield f"G3 {_xy(cx - hx, cy + hy - r)} I0. J{_n(-r)}"
    if hy - r > _LEAST:
        yield f"G1 {_xy(cx - hx, cy - hy + r)}"
    yield f"G3 {_xy(cx - hx + r, cy - hy)} I{_n(r)} J0."
    yield f"G1 {_xy(at_x, cy - hy)}"


def _program(given: Rectangle, name: str, start: tuple[float, float], entry: list[str], lines: list[str]) -> str:
    sides = f"{_n(given.x[1] - given.x[0])} x {_n(given.y[1] - given.y[0])} mm, {_n(given.depth)} deep, mill {_n(given.tool)}"
    head = [f"(pocket {sides}: {name})", "G21 G17 G90 G94 G40 G61", f"S{given.speed:.6g} M3",
            f"G0 {_xy(*start)} Z{_n(given.clear)}", *entry, f"F{_n(given.feed)}"]  # fmt: skip
    return "\n".join([*head, *lines, f"G0 Z{_n(given.clear)}", "M5", "M2", ""])


def _xy(x: float, y: float) -> str:
    return f"X{_n(x)} Y{_n(y)}"


def _n(value: float) -> str:
    text = f"{value:.6f}".rstrip("0")
    return "0." if text in ("-0.", "0.") else text
