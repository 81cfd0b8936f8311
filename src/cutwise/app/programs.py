"""What ``cutwise program`` does with an NC program: read it with what stands beside it, and draw it."""

import io
import math
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from cutwise.io.files import as_text, read_bytes
from cutwise.io.program_setup import library_beside, read_program, table_in_inches
from cutwise.programs.interpreter import Reading, reading
from cutwise.programs.moves import Move
from cutwise.programs.setup import Setup
from cutwise.programs.summary import arc_points
from cutwise.programs.tools import read_tool_table
from cutwise.spec.program import STEP_LIMIT

_ARC_STEP = math.radians(5.0)
_FINEST = 1.0 / 3000.0  # of the drawing: points nearer to each other are left out


class Opened(NamedTuple):
    """A program that is ready to run."""

    run: Reading
    setup: Setup
    notices: tuple[str, ...]


def opened(
    file: Path,
    tool_table: Path | None,
    dialect: Literal["auto", "rs274", "fanuc"] = "auto",
    step_limit: int | None = None,
) -> Opened:
    """Read a program, and a tool table if one is named.

    Raises
    ------
    ScenarioFault
        A file cannot be read, or the tool table is wrong.
    """
    text = read_program(file, str(file))
    setup = Setup(dialect=dialect, library=library_beside(file.parent), step_limit=step_limit or STEP_LIMIT)
    notices = []
    if tool_table is not None:
        table = as_text(read_bytes(tool_table, str(tool_table)), str(tool_table))
        inch = table_in_inches(table, text)
        setup = setup._replace(tools=read_tool_table(table, str(tool_table), inch=inch), inch=inch or None)
        notices.append(f"lengths of the tool table are taken as {'inches' if inch else 'mm'}")
    return Opened(reading(text, str(file), setup), setup, tuple(notices))


class Sketch:
    """Lines of a program, kept for drawing: one list of polylines for rapid moves, one for all others."""

    def __init__(self) -> None:
        self.rapid: list[list[tuple[float, float, float]]] = []
        self.feed: list[list[tuple[float, float, float]]] = []
        self._last = ""

    def add(self, move: Move) -> None:
        """Take up a move."""
        if move.kind == "dwell":
            return
        kind = "rapid" if move.kind == "rapid" else "feed"
        lines = self.rapid if kind == "rapid" else self.feed
        if kind != self._last:
            lines.append([move.start])
        self._last = kind
        if move.kind == "arc":
            count = max(2, math.ceil(abs(move.sweep) / _ARC_STEP))
            lines[-1] += arc_points(move, (move.sweep * k / count for k in range(1, count)))
        lines[-1].append(move.end)

    def svg(self, title: str) -> str:
        """Top view and front view, in millimetres."""
        import matplotlib as mpl
        from matplotlib.figure import Figure

        from cutwise.app.plots.figures import LOOK, SERIES, SOFT

        points = np.array([point for line in (*self.rapid, *self.feed) for point in line] or [(0.0, 0.0, 0.0)]) * 1e3
        size = np.maximum(np.ptp(points, axis=0), 1e-6)
        finest = float(size.max()) * _FINEST
        with mpl.rc_context({**LOOK, "svg.hashsalt": "cutwise"}):
            width = 8.0
            high, low = (min(max(width * size[i] / size[0], 1.5), 9.0) for i in (1, 2))
            drawn = Figure(figsize=(width, high + low + 1.4), layout="constrained")
            views = drawn.subplots(2, 1, height_ratios=(high, low), sharex=True)
            for axes, i, name in zip(views, (1, 2), "yz", strict=True):
                for lines, style in (
                    (self.rapid, {"color": SOFT, "linewidth": 0.6, "linestyle": "--"}),
                    (self.feed, {"color": SERIES[0], "linewidth": 0.9}),
                ):
                    for line in lines:
                        flat = _thinned(np.array(line)[:, [0, i]] * 1e3, finest)
                        axes.plot(flat[:, 0], flat[:, 1], **style)
                axes.set_aspect("equal", adjustable="datalim")
                axes.set_ylabel(f"{name} [mm]")
            views[0].set_title(title)
            views[1].set_xlabel("x [mm]; dashed: rapid")
            stream = io.StringIO()
            drawn.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        return stream.getvalue()


def _thinned(points: np.ndarray, finest: float) -> np.ndarray:
    """Points of a line without those that come nearer than a hair to the one kept before; the ends stay."""
    if len(points) < 100:
        return points
    kept = [0]
    for i in range(1, len(points) - 1):
        if abs(points[i] - points[kept[-1]]).max() >= finest:
            kept.append(i)
    return points[[*kept, len(points) - 1]]
