"""How plots are made: the look they share, long curves that keep their peaks, and SVG that sits inside a page."""

import io
import re
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

from cutwise import units
from cutwise.app.plots.margins import Margins

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

    from cutwise.results import Result

Draw = Callable[["Result"], Figure]
Drawn = TypeVar("Drawn")


class Plot(NamedTuple):
    """A plot of the report. It is left out if a result lacks one of the arrays or measures that it needs."""

    title: str
    caption: str
    draw: Draw
    needs: tuple[str, ...] = ()  # "group/variable", "measures/name"

    def applies(self, result: "Result") -> bool:
        """Whether the result holds everything that is drawn."""
        return all(holds(result, path) for path in self.needs)


def holds(result: "Result", path: str) -> bool:
    """Whether a result has an array (``group/variable``) or a measure (``measures/name``)."""
    group, _, name = path.partition("/")
    if group == "measures":
        return name in result.measures
    if group not in result.stages.children:
        return False
    array = result.stages[group].dataset.get(name)
    return array is not None and array.size > 0


# Each colour of a plot is a variable of the page, so that one drawing serves light, dark and print.
COLOURS = {
    "--card": "#fffffe", "--ink": "#1d2733", "--soft": "#5b6876", "--grid": "#dfe4ea",
    "--good": "#1a7f4b", "--bad": "#b3261e", "--zone": "#d5eddf", "--shade": "#eef1f5",
    "--c1": "#1f66b0", "--c2": "#c4570c", "--c3": "#2e8b68", "--c4": "#7b4ba6", "--c5": "#a8841a", "--c6": "#b03a6c",
    "--c7": "#4c7a8c",
}  # fmt: skip
CARD, INK, SOFT, GRID = (COLOURS[f"--{name}"] for name in ("card", "ink", "soft", "grid"))
ZONE, SHADE = COLOURS["--zone"], COLOURS["--shade"]
GOOD, BAD = COLOURS["--good"], COLOURS["--bad"]
SERIES = [COLOURS[f"--c{i}"] for i in range(1, 8)]

LOOK: dict["RcKeyType", Any] = {
    "font.family": "sans-serif", "font.size": 9.0, "text.color": INK,
    "axes.edgecolor": SOFT, "axes.labelcolor": INK, "axes.linewidth": 0.8, "axes.titlesize": 9.5,
    "axes.titlelocation": "left", "axes.titleweight": "bold", "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "axes.axisbelow": True, "axes.prop_cycle": cycler(color=SERIES),
    "grid.color": GRID, "grid.linewidth": 0.7, "xtick.color": SOFT, "ytick.color": SOFT,
    "xtick.labelcolor": INK, "ytick.labelcolor": INK, "lines.linewidth": 1.5,
    "legend.frameon": False, "legend.fontsize": 8.5, "svg.fonttype": "none", "path.simplify": False,
}  # fmt: skip
_A_LINE = 2  # points of a line that marks something; a curve has more
_FLAT = 1e-9  # relative change that is rounding
WIDTH = 9.6  # [in] of a figure over the whole page


def figure(height: float, *, colour_bars: bool = False) -> Figure:
    """An empty figure as wide as the page; with colour bars, whose room matplotlib has to find."""
    return Figure(figsize=(WIDTH, height), layout="constrained" if colour_bars else Margins())


def scale(dimension: str) -> tuple[float, str]:
    """Factor and name of the display unit: SI times factor is what is drawn."""
    return units.displayed(1.0, dimension)


def decimate(x: np.ndarray, y: np.ndarray, bins: int = 500) -> tuple[np.ndarray, np.ndarray]:
    """A long curve with few points: first, smallest, largest and last of each bin, so that every peak stays."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    if x.size <= 4 * bins:
        return x, y
    edges = np.linspace(0, x.size, bins + 1).astype(int)
    kept: list[int] = []
    for start, stop in pairwise(edges):
        part = y[start:stop]
        finite = np.where(np.isnan(part), 0.0, part)
        kept += sorted({start, start + int(finite.argmin()), start + int(finite.argmax()), stop - 1})
    return x[kept], y[kept]


def curve(axes: Axes, x: np.ndarray, y: np.ndarray, **style: object) -> None:
    """Draw a curve, thinned out if it is long."""
    axes.plot(*_without_flats(*decimate(x, y)), **style)  # type: ignore[arg-type]


def _without_flats(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Leave out points that a straight line between their neighbours passes through anyway."""
    if x.size < 3:
        return x, y
    tolerance = 1e-4 * float(np.ptp(y[np.isfinite(y)]) if np.isfinite(y).any() else 0.0)
    middle = np.interp(x[1:-1:2], x[0::2], y[0::2])
    keep = np.ones(x.size, bool)
    keep[1:-1:2] = ~(np.abs(y[1:-1:2] - middle) <= tolerance)
    return x[keep], y[keep]


def line_note(
    axes: Axes, y: float, text: str, colour: str, *, above: bool = True, text_at: float | None = None
) -> None:
    """A horizontal line with its name at the right end, at the height of the line or at another."""
    axes.axhline(y, color=colour, linewidth=1.0, linestyle="--")
    height = y if text_at is None else text_at
    note(
        axes, text, (1.0, height), (-2, 3 if above else -3), xycoords=axes.get_yaxis_transform(), ha="right",
        va="bottom" if above else "top", color=colour, zorder=4,
        bbox={"facecolor": CARD, "alpha": 0.75, "edgecolor": "none", "pad": 0.6},
    )  # fmt: skip


def note(axes: Axes, text: str, place: tuple[float, float], offset: tuple[float, float], **style: object) -> None:
    """A text beside a place, offset in points."""
    axes.annotate(text, place, xytext=offset, textcoords="offset points", **{"fontsize": 8, **style})  # type: ignore[arg-type]


def legend_above(axes: Axes, columns: int) -> None:
    """Legend in one row over the axes, where it hides nothing."""
    axes.legend(loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=columns, borderaxespad=0.2, handlelength=1.6)


def flat(drawn: Figure) -> str:
    """What a figure shows, in words, if it holds nothing but curves that do not change; else nothing."""
    said = []
    for axes in drawn.axes:
        curves = [line for line in axes.lines if np.size(line.get_ydata()) > _A_LINE]
        if not curves or axes.collections or axes.patches or axes.images:
            return ""
        for line in curves:
            y = np.asarray(line.get_ydata(), float)
            y = y[np.isfinite(y)]
            if y.size == 0 or np.ptp(y) > _FLAT * float(np.abs(y).max()):
                return ""
            name, _, unit = axes.get_ylabel().partition(" [")
            label = str(line.get_label())
            named = name if label.startswith("_") or len(curves) == 1 else f"{name}, {label}"
            said.append(f"{named} is {float(y[0]):.4g} {unit.removesuffix(']')}".rstrip())
    return "; ".join(said)


def svg(draw: Callable[[Drawn], Figure], result: Drawn, name: str, title: str) -> str:
    """The drawing as an ``<svg>`` element with names of its own and the colours of the page; a sentence where all is flat.

    ``name`` must be unique in the page; it starts every id, since ids are shared by all drawings of a page.
    """
    stream = io.StringIO()
    with mpl.rc_context({**LOOK, "svg.hashsalt": name}):
        drawn = draw(result)
        if constant := flat(drawn):
            return f"<p>No curve, since nothing changes: {_escaped(constant)}.</p>"
        layout = drawn.get_layout_engine()
        if isinstance(layout, Margins):  # now, and not again: with a layout engine a figure is drawn twice
            layout.execute(drawn)
            drawn.set_layout_engine("none")
        drawn.savefig(
            stream, format="svg", transparent=True,
            metadata={"Date": None, "Creator": None, "Format": None, "Type": None},
        )  # fmt: skip
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", text, count=2)
    text = re.sub(r'\bd="[^"]*"', _rounded, text)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'(xlink:href="#|url\(#)', rf"\g<1>{name}-", text)
    for variable, colour in COLOURS.items():
        text = re.sub(colour, f"var({variable})", text, flags=re.IGNORECASE)
    text = re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', f'role="img" aria-labelledby="{name}-title"', text, count=1)
    head, mark, body = text.partition(">")
    return f'{head}{mark}<title id="{name}-title">{_escaped(title)}</title>{body}'


def _rounded(path: re.Match[str]) -> str:
    """A path to a hundredth of a point, which is finer than any screen or printer."""
    return re.sub(r"-?\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), path[0])


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
