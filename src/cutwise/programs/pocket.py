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
    """Passes round the middle from the inside out, climb, joined by quarter circles tangent to both.

    Corners are as round as is asked for, as long as a pass has room for them beside its link.
    """
    place = _Place(given)
    short = place.short
    passes = max(1, math.ceil(short / given.step - _LEAST))
    step = short / passes
    at, lines = 0.0, []
    for k in range(1, passes + 1):
        hx, hy = place.long - short + k * step, k * step
        if k > 1:
            half = 0.5 * step
            lines += [f"(link to pass {k})", f"G2 {place.at(at + half, half - hy)} R{_n(half)}",
                      f"G3 {place.at(at + step, -hy)} R{_n(half)}"]  # fmt: skip
            at += step
        lines += [f"(pass {k})", *_round(place, hx, hy, min(k * step, given.corner, hx - at), at)]
    off = min(given.step, short, place.long - at)
    lines += ["(off the wall)", f"G3 {place.at(at + off, off - short)} R{_n(off)}"]
    return _program(given, "contour", place.at(0.0, -step), [f"G1 Z{_n(-given.depth)} F{_n(given.plunge)}"], lines)


def zigzag(given: Rectangle) -> str:
    """Rows to and fro along the longer side, then once round along the walls."""
    place = _Place(given)
    long, short = place.long, place.short
    rows = max(1, math.ceil(2.0 * short / given.step - _LEAST)) + 1
    gap = 2.0 * short / (rows - 1)
    lines, side = [], 1.0
    for k in range(rows):
        v = -short + k * gap
        if k:
            lines.append(f"G1 {place.at(-side * long, v)}")
        lines += [f"(row {k + 1})", f"G1 {place.at(side * long, v)}"]
        side = -side
    corners = [(long, short), (-long, short), (-long, -short), (long, -short)]
    if side > 0.0:  # the last row ends at the left: counter-clockwise from there is climb
        corners = [*corners[1:], corners[0]]
    lines += ["(round the walls)", *(f"G1 {place.at(u, v)}" for u, v in (*corners[1:], corners[0]))]
    entry = [f"G1 Z{_n(-given.depth)} F{_n(given.plunge)}"]
    return _program(given, "zigzag", place.at(-long, -short), entry, lines)


def trochoid(given: Rectangle) -> str:
    """Counter-clockwise circles along a slot, joined on its right wall; the first is entered on a helix.

    The rear of each circle is cut again by the next one: it stops at a corner of a right angle there.
    """
    place = _Place(given)
    circle = place.short
    way = 2.0 * (place.long - circle)
    count = max(1, math.ceil(way / given.step - _LEAST))
    first, middle = -0.5 * way, place.centre(0.0, circle)
    turns = max(1, math.ceil(given.depth / max(0.5 * circle, 0.1)))
    here = place.at(first, -circle)
    entry = [f"G1 Z0. F{_n(given.plunge)}"]
    entry += [f"G3 {here} Z{_n(-given.depth * k / turns)} {middle}" for k in range(1, turns + 1)]
    lines = ["(circle 1, a full slot)", f"G3 {here} {middle}"]
    for k in range(1, count + 1):
        there = place.at(min(first + k * given.step, -first), -circle)
        lines += [f"G1 {there}", f"G3 {there} {middle}"]
    return _program(given, "trochoid", here, entry, lines)


STRATEGIES = {"contour": contour, "zigzag": zigzag, "trochoid": trochoid}


class _Place:
    """Places about the middle of a pocket, u along its longer side, as words."""

    def __init__(self, given: Rectangle) -> None:
        hx, hy = given.half
        self.turned = hy > hx
        self.long, self.short = max(hx, hy), min(hx, hy)
        self.x, self.y = given.middle

    def at(self, u: float, v: float) -> str:
        """Words of a place."""
        return _xy(self.x - v, self.y + u) if self.turned else _xy(self.x + u, self.y + v)

    def centre(self, u: float, v: float) -> str:
        """Words of a centre, counted from the start of its arc."""
        i, j = (-v, u) if self.turned else (u, v)
        return f"I{_n(i)} J{_n(j)}"


def _round(place: _Place, hx: float, hy: float, r: float, at: float) -> Iterator[str]:
    """Once round a rectangle with round corners, counter-clockwise from and back to a place of its lower side."""
    if r <= _LEAST:
        yield from (f"G1 {place.at(u * hx, v * hy)}" for u, v in ((1, -1), (1, 1), (-1, 1), (-1, -1)))
        yield f"G1 {place.at(at, -hy)}"
        return
    if hx - r - at > _LEAST:
        yield f"G1 {place.at(hx - r, -hy)}"
    yield f"G3 {place.at(hx, r - hy)} {place.centre(0.0, r)}"
    if hy - r > _LEAST:
        yield f"G1 {place.at(hx, hy - r)}"
    yield f"G3 {place.at(hx - r, hy)} {place.centre(-r, 0.0)}"
    if hx - r > _LEAST:
        yield f"G1 {place.at(r - hx, hy)}"
    yield f"G3 {place.at(-hx, hy - r)} {place.centre(0.0, -r)}"
    if hy - r > _LEAST:
        yield f"G1 {place.at(-hx, r - hy)}"
    yield f"G3 {place.at(r - hx, -hy)} {place.centre(r, 0.0)}"
    if at + hx - r > _LEAST:
        yield f"G1 {place.at(at, -hy)}"


def _program(given: Rectangle, name: str, start: str, entry: list[str], lines: list[str]) -> str:
    sides = f"{_n(given.x[1] - given.x[0])} x {_n(given.y[1] - given.y[0])} mm, {_n(given.depth)} deep, mill {_n(given.tool)}"
    head = [f"(pocket {sides}: {name})", "G21 G17 G90 G94 G40 G61", f"S{given.speed:.6g} M3",
            f"G0 {start} Z{_n(given.clear)}", *entry, f"F{_n(given.feed)}"]  # fmt: skip
    return "\n".join([*head, *lines, f"G0 Z{_n(given.clear)}", "M5", "M2", ""])


def _xy(x: float, y: float) -> str:
    return f"X{_n(x)} Y{_n(y)}"


def _n(value: float) -> str:
    text = f"{value:.6f}".rstrip("0")
    return "0." if text in ("-0.", "0.") else text
