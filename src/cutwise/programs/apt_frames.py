"""Coordinate systems of CL data: that of the part (TRNTYP/WORLD) or of a setup (CSYS, MSYS), brought into one frame.

All moves of a program stand in one frame: the axes of the setup in which it begins. What a later setup says is turned
into that frame, and so its tool axis tilts.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

from cutwise.programs.cldata import Statement, StatementFault
from cutwise.programs.moves import Point

_SQUARE = 1e-3  # by which axes may miss being of unit length and square to each other
_WORLD, _LOCAL = ("WORLD",), ("LOCAL", "CSYS", "SETUP", "PART", "MACHIN")
_ZERO: Point = (0.0, 0.0, 0.0)
Z: Point = (0.0, 0.0, 1.0)


class Axes(NamedTuple):
    """A coordinate system in that of the part: its origin and its unit vectors."""

    origin: Point = _ZERO
    x: Point = (1.0, 0.0, 0.0)
    y: Point = (0.0, 1.0, 0.0)
    z: Point = Z

    def out(self, vector: Point) -> Point:
        """A vector of this system in that of the part."""
        a, b, c = vector
        i, j, k = (a * self.x[n] + b * self.y[n] + c * self.z[n] for n in range(3))
        return i, j, k

    def into(self, vector: Point) -> Point:
        """A vector of the part in this system."""
        return _dot(vector, self.x), _dot(vector, self.y), _dot(vector, self.z)

    def turned(self) -> bool:
        """Whether its axes are not those of the part."""
        return (self.x, self.y, self.z) != (_AXES.x, _AXES.y, _AXES.z)


_AXES = Axes()


class Frames:
    """Where points of CL data stand, statement by statement."""

    def __init__(self) -> None:
        self.setup = _AXES
        self.world = False
        self.base: Axes | None = None  # frame of all moves: that of the first point

    def take(self, s: Statement) -> str:
        """CSYS, MSYS, TRNTYP; what is worth saying about it, if anything.

        Raises
        ------
        StatementFault
            Not a coordinate system.
        """
        if s.word == "TRNTYP":
            words = s.words()
            if len(words) != 1 or words[0] not in _WORLD + _LOCAL:
                raise StatementFault(f"TRNTYP/{s.text}: known are {', '.join(_WORLD + _LOCAL)}", s.column)
            self.world = words[0] in _WORLD
            return ""
        n = s.numbers()
        self.setup = _axes(s, n)
        if self.base is None:
            if self.world and self.setup.turned():
                return (
                    "points of the part (TRNTYP/WORLD) are turned into the axes of the setup, about the part's origin"
                )
            return ""
        now = self._base()
        if (now.x, now.y, now.z) == (self.base.x, self.base.y, self.base.z) and (self.world or now == self.base):
            return ""
        return "more than one setup: all moves stand in the axes of the first one, in which later tool axes are tilted"

    def _base(self) -> Axes:
        return self.setup._replace(origin=_ZERO) if self.world else self.setup

    def point(self, point: Point) -> Point:
        """A point as written, in the frame of all moves."""
        if self.base is None:
            self.base = self._base()
        if not self.world:
            if self.setup == self.base:
                return point
            o = self.setup.origin
            x, y, z = (a + b for a, b in zip(self.setup.out(point), o, strict=True))
            point = (x, y, z)
        b = self.base
        if b == _AXES:
            return point
        return b.into((point[0] - b.origin[0], point[1] - b.origin[1], point[2] - b.origin[2]))

    def vector(self, vector: Point) -> Point:
        """A direction as written, in the frame of all moves."""
        if self.base is None:
            self.base = self._base()
        if not self.world:
            if self.setup == self.base:
                return vector
            vector = self.setup.out(vector)
        return vector if self.base == _AXES else self.base.into(vector)

    def tool_axis(self) -> Point:
        """The tool axis of the setup, in the frame of all moves."""
        if self.base is None:
            self.base = self._base()
        if (self.setup.x, self.setup.y, self.setup.z) == (self.base.x, self.base.y, self.base.z):
            return Z
        return self.base.into(self.setup.z)


def _axes(s: Statement, n: Sequence[float]) -> Axes:
    """Three rows of axes and origin (CSYS: x x, y x, z x, origin x and so on), or origin, x and y axis (MSYS)."""
    if s.word == "CSYS" and len(n) == 12:
        x, y, z, origin = ((n[i], n[i + 4], n[i + 8]) for i in range(4))
    elif s.word == "MSYS" and len(n) == 9:
        origin, x, y = ((n[i], n[i + 1], n[i + 2]) for i in (0, 3, 6))
        z = _cross(x, y)
    else:
        wanted = "12 numbers: three rows of axes and origin" if s.word == "CSYS" else "9 numbers: origin, x and y axis"
        raise StatementFault(f"{s.word} needs {wanted}; found {len(n)}", s.column)
    square = all(abs(_dot(a, b) - (i == j)) < _SQUARE for i, a in enumerate((x, y, z)) for j, b in enumerate((x, y, z)))
    if not square or _dot(_cross(x, y), z) < 0.0:
        raise StatementFault(
            f"{s.word}: its axes are not of unit length and square to each other, right-handed", s.column
        )
    z = _unit(z)
    x = _unit(_cross(y, z))
    return Axes(origin, x, _cross(z, x), z)


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _unit(a: Point) -> Point:
    size = math.hypot(*a)
    return a[0] / size, a[1] / size, a[2] / size
