"""Canned cycles, resolved into motions: G73, G74, G81 to G86, G88, G89 in every plane, with G98, G99 and repeats."""

from collections.abc import Callable
from typing import Literal

from cutwise.programs.block import Block
from cutwise.programs.canon import DrawnOut, Dwell, NaiveTolerance, PathControl, Signal, SpindleTurn, Stop, TapStroke
from cutwise.programs.controller import INCH, MILLIMETRE, PLANES, Controller, Cycle
from cutwise.programs.groups import CYCLES, MOTION
from cutwise.programs.motions import check_feed, go, polar

_CLEAR_INCHES = 0.010  # how far a peck stays off the bottom reached before, and how far G73 draws back
_DWELLS = (820, 860, 880, 890)


def cycle(c: Controller, block: Block, *, before: int) -> None:
    """One block of a canned cycle.

    Parameters
    ----------
    c : Controller
        Its motion is already that of the cycle.
    block : Block
        Words of the cycle; R, the depth and others hold on as long as the cycle stays the same.
    before : int
        The motion before: the level to return to (G98) is that at which a series of cycles, of any kind, began.
    """
    _check(c, block)
    u, v, w = PLANES[c.plane]
    if before != c.motion:
        c.cycle = Cycle(level=c.cycle.level if before in CYCLES else c.at[w], dwell=c.cycle.dwell)
    _keep_words(c, block, "xyz"[w], begins=before != c.motion)
    clearance, bottom = _heights(c, block)
    repeats = block.whole("l") if "l" in block.values else 1
    if not repeats and c.stores_cycles:
        return
    if not repeats:
        raise block.fault("a cycle cannot be repeated 0 times (L0)", "l")
    _count(c, block, repeats, (clearance - bottom))
    top = max(c.cycle.level, clearance) if c.retract_to_start else clearance
    height = c.at[w] if c.at[w] > clearance else top
    if c.cycle.level < clearance:  # said in every block of the series
        height = clearance
        _up(c, w, height)
    exact = c.path_mode == "exact_path"
    if not exact:
        c.out.append(PathControl("exact_path", 0.0, c.line, c.number))
    for _ in range(repeats):
        go(c, _place(c, block, (u, v), w, height), rapid=True)
        if height != clearance:
            _up(c, w, clearance)
        _HOLES[c.motion](c, block, (w, clearance, bottom, top))
        height = top
    if not exact:
        c.out.append(PathControl(c.path_mode, c.tolerance, c.line, c.number, c.path_mode_said))
        c.out.append(NaiveTolerance(c.naive_tolerance, c.line, c.number))


def _count(c: Controller, block: Block, repeats: int, depth: float) -> None:
    """Repeats and pecks count as steps before any of them is made."""
    pecks = depth / c.cycle.peck if c.motion in (730, 830) and c.cycle.peck else 0.0
    each = 3.0 * (1.0 + pecks)
    if repeats > 1 or each > 3.0:
        what = f"{MOTION[c.motion]} repeated {repeats} times" + (
            f" with {pecks:.0f} pecks each" if pecks >= 1.0 else ""
        )
        c.spend(repeats * each, what, block.place("l", "q", *block.axes()))


def _check(c: Controller, block: Block) -> None:
    word = MOTION[c.motion]
    for letter in "abcuvw":
        if letter in block.values:
            raise block.fault(f"{word}: {letter.upper()} cannot stand in a canned cycle", letter)
    if c.compensation is not None:
        raise block.fault(f"{word} cannot be used with cutter compensation; write G40 before", *block.axes())
    if c.feed_mode == 93:
        raise block.fault(f"{word} cannot be used with inverse time (G93)", *block.axes())
    check_feed(c, block)


def _keep_words(c: Controller, block: Block, depth: str, *, begins: bool) -> None:
    held = c.cycle
    held.bottom = block.values.get(depth, held.bottom)
    held.clearance = block.values.get("r", held.clearance)
    held.peck = block.values.get("q", held.peck)
    held.dwell = block.values.get("p", held.dwell)
    word, places = MOTION[c.motion], block.axes()
    for value, missing in ((held.clearance, "R, the clearance plane,"), (held.bottom, f"{depth.upper()}, the depth,")):
        if value is None:
            raise block.fault(f"{word} needs {depth.upper()} and R; {missing} is missing", *places)
    if c.motion in (730, 830) and (held.peck is None or held.peck <= 0.0):
        raise block.fault(f"{word} needs a positive peck Q", "q", *places)
    if c.motion in _DWELLS and begins and "p" not in block.values:
        raise block.fault(f"{word} needs a dwell time P in seconds", *places)


def _heights(c: Controller, block: Block) -> tuple[float, float]:
    """Heights of the clearance plane and of the bottom; incremental ones build on each other."""
    assert c.cycle.clearance is not None
    assert c.cycle.bottom is not None
    clearance, bottom = c.cycle.clearance, c.cycle.bottom
    if c.incremental:
        clearance += c.cycle.level
        bottom += clearance
    if clearance < bottom:
        raise block.fault(f"{MOTION[c.motion]}: the clearance plane R ({clearance:g}) is below the bottom ({bottom:g})",
                          "r", *block.axes())  # fmt: skip
    return clearance, bottom


def _place(c: Controller, block: Block, axes: tuple[int, int], w: int, height: float) -> list[float]:
    """Where the hole is, at a height above it."""
    at = list(c.at)
    at[w] = height
    if "@" in block.values or "^" in block.values:
        at[0], at[1] = polar(c, block, at)
        return at
    for i in axes:
        letter = "xyz"[i]
        if letter in block.values:
            at[i] = at[i] + block.values[letter] if c.incremental else block.values[letter]
    return at


def _up(c: Controller, w: int, height: float) -> None:
    at = list(c.at)
    at[w] = height
    go(c, at, rapid=True)


def _down(c: Controller, w: int, height: float) -> None:
    at = list(c.at)
    at[w] = height
    go(c, at, rapid=False)


Levels = tuple[int, float, float, float]  # axis, clearance plane, bottom, height to end at


def _drill(c: Controller, block: Block, levels: Levels) -> None:  # noqa: ARG001
    """G81, G82 with a dwell."""
    w, _, bottom, top = levels
    _down(c, w, bottom)
    if c.motion == 820:
        _dwell(c)
    _up(c, w, top)


def _peck(c: Controller, block: Block, levels: Levels) -> None:  # noqa: ARG001
    """G83 clears the hole after each peck, G73 breaks the chip."""
    w, clearance, bottom, top = levels
    step = c.cycle.peck
    assert step is not None
    clear = _CLEAR_INCHES * (1.0 if c.inch else INCH / MILLIMETRE)
    depth = clearance - step
    while depth > bottom:
        _down(c, w, depth)
        if c.motion == 830:
            _up(c, w, clearance)
        _up(c, w, depth + clear)
        depth -= step
    _down(c, w, bottom)
    _up(c, w, top)


def _stroke(c: Controller, w: int, height: float) -> None:
    c.at[w] = height
    c.out.append(TapStroke(c.at[0], c.at[1], c.at[2], c.plane, c.rotary, c.extra, c.line, c.number))


def _tap(c: Controller, block: Block, levels: Levels) -> None:
    """G84 right-hand, G74 left-hand thread: down turning one way, up the other."""
    w, _, bottom, top = levels
    way: Literal[-1, 1] = 1 if c.motion == 840 else -1
    word = MOTION[c.motion]
    if c.spindle.turning != way:
        needed = "M3" if way == 1 else "M4"
        raise block.fault(f"{word} needs the spindle turning by {needed}", *block.axes())
    s = c.switches
    feed, speed = s.feed_override, s.speed_override
    c.out.append(Signal("DISABLE_FEED_OVERRIDE", "", c.line, c.number))
    c.out.append(Signal("DISABLE_SPEED_OVERRIDE", "0", c.line, c.number))
    _stroke(c, w, bottom)
    c.out.append(SpindleTurn(0, c.line, c.number))
    c.out.append(SpindleTurn(-1 if way == 1 else 1, c.line, c.number))
    c.out.append(Dwell(c.cycle.dwell or 0.0, c.line, c.number))
    _stroke(c, w, top)
    c.out.append(SpindleTurn(0, c.line, c.number))
    c.out.append(SpindleTurn(way, c.line, c.number))
    if feed:
        c.out.append(Signal("ENABLE_FEED_OVERRIDE", "", c.line, c.number))
    if speed:
        c.out.append(Signal("ENABLE_SPEED_OVERRIDE", "0", c.line, c.number))


def _bore(c: Controller, block: Block, levels: Levels) -> None:  # noqa: ARG001
    """G85 feeds out to the clearance plane; G89 dwells, then feeds out all the way."""
    w, clearance, bottom, top = levels
    _down(c, w, bottom)
    if c.motion == 890:
        _dwell(c)
        _down(c, w, top)
    else:
        _down(c, w, clearance)
        _up(c, w, top)


def _bore_stopped(c: Controller, block: Block, levels: Levels) -> None:
    """G86: the spindle stands while the tool is drawn out; G88: the operator draws it out."""
    w, _, bottom, top = levels
    turning = c.spindle.turning
    if not turning:
        raise block.fault(f"{MOTION[c.motion]} needs a turning spindle; write M3 or M4 before", *block.axes())
    _down(c, w, bottom)
    _dwell(c)
    c.out.append(SpindleTurn(0, c.line, c.number))
    if c.motion == 880:
        c.out.append(Stop("stop", c.line, c.number))
        c.at[w] = top
        c.out.append(DrawnOut(c.at[0], c.at[1], c.at[2], c.line, c.number))
    else:
        _up(c, w, top)
    c.out.append(SpindleTurn(turning, c.line, c.number))


def _dwell(c: Controller) -> None:
    c.out.append(Dwell(c.cycle.dwell or 0.0, c.line, c.number))


_HOLES: dict[int, Callable[[Controller, Block, Levels], None]] = {
    730: _peck, 740: _tap, 810: _drill, 820: _drill, 830: _peck, 840: _tap, 850: _bore, 860: _bore_stopped,
    880: _bore_stopped, 890: _bore,
}  # fmt: skip
