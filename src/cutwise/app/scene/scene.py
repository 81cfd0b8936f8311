"""What there is to see of a run: places over time, histories with their limits, solids, surfaces; SI throughout."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from cutwise.results import Result

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Kept = TypeVar("Kept", bound=np.generic)

RAPID, FEED, CUT, DWELL = range(4)  # kinds of a sample; nothing is drawn from one at which the tool stands to the next
UP = np.array([0.0, 0.0, 1.0])
_STRAIGHT_UP = np.broadcast_to(UP, (1, 3))


class History(NamedTuple):
    """Values over the samples, with their limits and what the ends of their range mean."""

    title: str
    values: FloatArray  # SI, shape (n,); NaN is missing
    dimension: str
    low: float | None = None  # limits, SI
    high: float | None = None
    nominal: float | None = None
    ends: tuple[str, str] = ("", "")  # in words: below, above
    drawn: bool = True  # as a curve below the scene
    coloured: bool = True  # the path may be coloured by it
    measures: tuple[str, ...] = ()  # whose limits these are: its numbers stand in their unit, as it was typed


class Surface(NamedTuple):
    """Triangles, of one tint or coloured by values at their corners."""

    title: str
    points: FloatArray  # [m], shape (k, 3)
    triangles: IntArray  # shape (m, 3)
    tint: str = "work"  # work, burr, part, glass, ghost, machine, robot
    values: FloatArray | None = None  # SI, shape (k,)
    coloured: str = ""  # the history whose colours they take
    face: IntArray | None = None  # number of the face of each triangle, shape (m,)
    names: dict[int, str] = {}  # noqa: RUF012  what a face is called in a scenario


class Body(NamedTuple):
    """Triangles that move with a tool."""

    points: FloatArray  # from its tip, z up the tool [m], shape (k, 3)
    triangles: IntArray  # shape (m, 3)
    holds: bool = False  # the holder, else what cuts


class Map(NamedTuple):
    """Heights of a stock at the middles of cells, shape (along y, along x)."""

    x: float  # least corner [m]
    y: float
    dx: float
    dy: float
    height: FloatArray  # [m]; NaN where nothing is left
    top: float  # of the stock before [m]
    bottom: float
    values: FloatArray | None = None  # SI, what the cells are coloured by; NaN: not coloured
    coloured: str = ""
    owner: IntArray | None = None  # the sample that lowered the cell last, -1: none


class Tool(NamedTuple):
    """Turned profiles: height above the tip and radius [m], from the tip upward; shape (k, 2)."""

    cutter: FloatArray
    holder: FloatArray
    fixed: FloatArray = np.zeros((0, 2))  # round the holder, and not deflected with it
    rods: FloatArray = np.zeros((0, 7))  # of the fixed part: both ends from the tip and radius [m]
    pivot: float = 0.0  # height above the tip about which a deflected tool tilts [m]; 0: it is shifted
    bodies: tuple[Body, ...] = ()  # what is not turned, as an insert


@dataclass(frozen=True)
class Scene:
    """All of it; arrays over the n samples unless said otherwise."""

    clock: FloatArray  # [s], or [m] of way where a run knows no time
    clock_is: str  # time or way
    place: FloatArray  # tip of the tool as programmed or driven [m], (n, 3)
    trace: FloatArray | None = None  # where the ribbon is drawn, (n, 3); left out: the places
    axis: FloatArray = field(default_factory=lambda: _STRAIGHT_UP)  # of the tool, up; (n, 3) or (1, 3)
    histories: dict[str, History] = field(default_factory=dict)
    line: IntArray | None = None  # of the program, 0: none
    kind: npt.NDArray[np.uint8] | None = None
    deflection: FloatArray | None = None  # of the tip [m], (n, 3)
    magnified: float | None = None  # times that it is drawn at first; left out: as the radius of the tool bears
    tools: tuple[Tool, ...] = ()
    tool_of: IntArray | None = None  # which of them a sample has, (n,); left out: the first
    counted: npt.NDArray[np.bool_] | None = (
        None  # samples that the worst places are looked for among, (n,); left out: all
    )
    surfaces: tuple[Surface, ...] = ()
    map: Map | None = None
    links: FloatArray | None = None  # joint points of what carries the tool [m], (n or fewer, points, 3)
    link_of: IntArray | None = None  # which row of links a sample has, (n,)
    outlines: tuple[FloatArray, ...] = ()  # lines to be drawn [m], each (k, 3)
    judged: str = ""  # the history by which the worst places are found; the colours of the scene at first
    focus: tuple[FloatArray, FloatArray] | None = (
        None  # corners of what the view is fitted to [m]; left out: part and stock
    )
    front: tuple[float, float, float] | None = None  # from where its front is seen; left out: as the process has it
    links_are: str = "arm"  # or bodies: the lines between their origins
    said: tuple[str, ...] = ()  # what is not shown, and what is drawn larger than it is
    path: bool = True  # whether the places are drawn as a ribbon

    @property
    def radius(self) -> float:
        """The largest radius of a tool [m]; 0 without one."""
        return max((float(tool.cutter[:, 1].max(initial=0.0)) for tool in self.tools), default=0.0)

    def cut_short(self, keep: IntArray) -> "Scene":
        """The scene with some of its samples; a map keeps the nearest one that stays."""
        back = np.clip(np.searchsorted(keep, np.arange(self.clock.size)), 0, keep.size - 1)

        def taken(array: "npt.NDArray[Kept] | None") -> "npt.NDArray[Kept] | None":
            return array[keep] if array is not None and len(array) == self.clock.size else array

        owned = self.map
        if owned is not None and owned.owner is not None:
            owned = owned._replace(owner=np.where(owned.owner >= 0, back[np.maximum(owned.owner, 0)], -1))
        return replace(
            self, clock=self.clock[keep], place=self.place[keep], trace=taken(self.trace),
            axis=self.axis[keep] if len(self.axis) == self.clock.size else self.axis, line=taken(self.line),
            kind=taken(self.kind), deflection=taken(self.deflection), link_of=taken(self.link_of), map=owned,
            tool_of=taken(self.tool_of), counted=taken(self.counted),
            histories={name: one._replace(values=one.values[keep]) for name, one in self.histories.items()},
        )  # fmt: skip


def limits(result: "Result", *names: str) -> tuple[float | None, float | None]:
    """The least upper and the greatest lower limit that the scenario puts on any of these measures [SI]."""
    found = [result.scenario.asked[name] for name in names if name in result.scenario.asked]
    lows = [limit.min for limit in found if limit.min is not None]
    highs = [limit.max for limit in found if limit.max is not None]
    return max(lows, default=None), min(highs, default=None)


def mirrored(result: "Result", name: str) -> tuple[float | None, float | None]:
    """Limits of a signed history whose magnitude is limited."""
    high = limits(result, name)[1]
    return (None, None) if high is None else (-high, high)
