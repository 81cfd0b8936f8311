"""Room around the panels of a figure, from the length of what stands beside them.

matplotlib's constrained layout measures every text by drawing it, and draws each figure twice: a third of the time of
a report. Texts of the report are set by the browser in a font of its own, so their exact size is not known here
anyway; characters times a width is as good.
"""

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import LayoutEngine
from matplotlib.text import Annotation, Text

_WIDE = 0.60  # width of a character over its height
_LINE = 1.45  # height of a line over that of a character
_PAD = 5.0  # [pt] between things, and at the rim


class Margins(LayoutEngine):
    """Places the panels of one grid so that labels, titles and legends fit between and around them."""

    _adjust_compatible = True
    _colorbar_gridspec = True

    def execute(self, fig: Figure) -> None:
        """Set the margins of the figure and the gaps of its grid: twice, since the size of a panel decides on its ticks."""
        for _ in range(2):
            _set(fig)


def _set(fig: Figure) -> None:
    panels = [axes for axes in fig.axes if axes.get_subplotspec() is not None]
    if not panels:
        return
    grid = panels[0].get_subplotspec().get_gridspec()  # type: ignore[union-attr]
    rows, columns = grid.nrows, grid.ncols
    left, bottom, top, right = [0.0] * columns, [0.0] * rows, [0.0] * rows, _PAD
    for axes in panels:
        spec = axes.get_subplotspec()
        assert spec is not None
        row, column = spec.rowspan.start, spec.colspan.start
        over = _sticking_out(axes)
        left[column] = max(left[column], _beside(axes), over[0] + _PAD)
        bottom[row] = max(bottom[row], _below(axes), over[1] + _PAD)
        top[row] = max(top[row], _above(axes), over[3] + _PAD)
        if spec.colspan.stop == columns:
            right = max(right, _overhang(axes), over[2] + _PAD)
    width, height = (72.0 * size for size in fig.get_size_inches())
    across = max(left[1:], default=0.0)
    between = max((top[i + 1] + bottom[i] for i in range(rows - 1)), default=0.0)
    fig.subplots_adjust(
        left=left[0] / width,
        right=1.0 - right / width,
        bottom=bottom[-1] / height,
        top=1.0 - top[0] / height,
        wspace=_share(across + _PAD, width - left[0] - right, columns),
        hspace=_share(between, height - top[0] - bottom[-1], rows),
    )


def _share(gap: float, room: float, count: int) -> float:
    """A gap as matplotlib wants it: over the mean size of the panels."""
    panel = (room - gap * (count - 1)) / count
    return gap / max(panel, 0.2 * room / count)


def _lines(text: str) -> list[str]:
    return text.split("\n") if text else []


def _wide(text: str, size: float) -> float:
    return max((len(line) for line in _lines(text)), default=0) * _WIDE * size


def _high(text: str, size: float) -> float:
    return len(_lines(text)) * _LINE * size


def _size(text: Text) -> float:
    """Size of its letters [pt]; a word for it is a number by then."""
    return float(text.get_fontsize())


def _ticks(axis: Axis) -> list[Any]:
    """Tick labels that are shown and lie within the panel."""
    return [tick.label1 for tick in axis._update_ticks() if tick.label1.get_visible()]  # type: ignore[attr-defined]


def _sticking_out(axes: Axes) -> tuple[float, float, float, float]:
    """How far notes reach over the left, lower, right and upper rim of a panel [pt]."""
    box, point = axes.bbox, 72.0 / axes.figure.dpi
    over = [0.0, 0.0, 0.0, 0.0]
    for text in axes.texts:
        if text.get_clip_on() or not text.get_text():
            continue
        if isinstance(text, Annotation):
            x, y = text._get_xy(axes.figure._get_renderer(), text.xy, text.xycoords) * point  # type: ignore[attr-defined, union-attr]
            dx, dy = text.xyann if text.anncoords == "offset points" else (0.0, 0.0)
        else:
            (x, y), dx, dy = text.get_transform().transform(text.get_position()) * point, 0.0, 0.0
        wide, high = _wide(text.get_text(), _size(text)), _high(text.get_text(), _size(text))
        left = x + dx - {"left": 0.0, "center": 0.5, "right": 1.0}[text.get_horizontalalignment()] * wide
        low = y + dy - {"top": 1.0, "center": 0.5}.get(text.get_verticalalignment(), 0.0) * high
        rims = (
            box.x0 * point - left, box.y0 * point - low,
            left + wide - box.x1 * point, low + high - box.y1 * point,
        )  # fmt: skip
        over = [max(pair) for pair in zip(over, rims, strict=True)]
    return over[0], over[1], over[2], over[3]


def _beside(axes: Axes) -> float:
    """Room that labels on the left of a panel take [pt]."""
    if not axes.axison:
        return _PAD
    labels = [_wide(label.get_text(), label.get_fontsize()) for label in _ticks(axes.yaxis)]
    name = axes.yaxis.label
    said = _high(name.get_text(), _size(name))
    return max(labels, default=0.0) + said + 2.0 * _PAD + (4.0 if labels else 0.0)


def _below(axes: Axes) -> float:
    if not axes.axison:
        return _PAD
    labels = [_high(label.get_text(), label.get_fontsize()) for label in _ticks(axes.xaxis)]
    name = axes.xaxis.label
    return max(labels, default=0.0) + _high(name.get_text(), _size(name)) + 1.5 * _PAD


def _above(axes: Axes) -> float:
    """Room that titles and a legend over a panel take [pt]."""
    titles = [title for title in (axes.title, axes._left_title, axes._right_title) if title.get_text()]  # type: ignore[attr-defined]
    over = max((_high(t.get_text(), _size(t)) for t in titles), default=0.0)
    if titles:
        over += axes.titleOffsetTrans.get_matrix()[1, 2] * 72.0 / axes.figure.dpi  # type: ignore[attr-defined]
    legend = axes.get_legend()
    if legend is not None and getattr(legend, "_loc", 0) == 3 and legend.get_bbox_to_anchor().y0 >= axes.bbox.y1 - 1.0:
        texts = legend.get_texts()
        rows = math.ceil(len(texts) / max(1, legend._ncols))  # type: ignore[attr-defined]
        over = max(over, rows * (_LINE + 0.2) * _size(texts[0]) + 2.0 if texts else 0.0)
    return over + _PAD


def _overhang(axes: Axes) -> float:
    """Half of the last tick label sticks out on the right [pt]."""
    labels = _ticks(axes.xaxis) if axes.axison else []
    return _PAD + (0.5 * _wide(labels[-1].get_text(), labels[-1].get_fontsize()) if labels else 0.0)
