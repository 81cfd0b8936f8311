"""Motions: straight lines, probing, threading, reference points; where the axis words of a block lead."""

import math
from collections.abc import Sequence

from cutwise.programs import compensation
from cutwise.programs.block import Block
from cutwise.programs.canon import Feed, FeedRate, Probe, RigidTap, Signal, SpindleSync, Traverse
from cutwise.programs.controller import AXES, Controller, from_machine, to_machine
from cutwise.programs.groups import MOTION, name
from cutwise.programs.offsets import HOMES, home

_LEAST_RATE = 0.1  # [length/min] of a feed by inverse time


def present(c: Controller) -> list[float]:
    """Where the program stands: the programmed point, not that of the compensated tool."""
    at = list(c.at)
    if c.compensation is not None and c.compensation.programmed is not None:
        at[c.compensation.u], at[c.compensation.v] = c.compensation.programmed
    return at


def target(c: Controller, block: Block) -> list[float]:
    """Where the axis words of a block lead, in work coordinates.

    Raises
    ------
    BlockFault
        Polar words with X or Y, or from the origin without a direction; G53 with incremental distances.
    """
    at = present(c)
    if block.g.get("non-modal") == 530:
        return _machine_target(c, block, at)
    if "@" in block.values or "^" in block.values:
        at[0], at[1] = polar(c, block, at)
    for i, letter in enumerate(AXES):
        if letter in block.values:
            at[i] = at[i] + block.values[letter] if c.incremental else block.values[letter]
    return at


def _machine_target(c: Controller, block: Block, at: Sequence[float]) -> list[float]:
    if block.motion not in (0, 10):
        raise block.fault("G53 needs G0 or G1", "g.non-modal")
    if c.incremental:
        raise block.fault("G53 gives machine coordinates; it needs absolute distances (G90)", "g.non-modal")
    if c.compensation is not None:
        raise block.fault("G53 cannot be used with cutter compensation; write G40 before", "g.non-modal")
    for letter in "@^":
        if letter in block.values:
            raise block.fault("G53 does not take polar words (@ ^)", letter)
    place = to_machine(c.offsets, at)
    for i, letter in enumerate(AXES):
        if letter in block.values:
            place[i] = block.values[letter]
    return from_machine(c.offsets, place)


def polar(c: Controller, block: Block, at: Sequence[float]) -> tuple[float, float]:
    """Where polar words lead: a distance (@) from the origin and an angle (^), or steps of them."""
    if c.plane != "XY":
        raise block.fault("polar words (@ ^) need the XY plane (G17)", "@", "^")
    for letter in "xy":
        if letter in block.values:
            raise block.fault("X and Y cannot be mixed with polar words (@ ^)", letter)
    radius, angle = block.get("@"), block.get("^")
    here = math.hypot(at[0], at[1])
    if here == 0.0 and (angle is None or c.incremental):
        raise block.fault("a polar motion from the origin needs an absolute angle (^)", "@", "^")
    direction = math.degrees(math.atan2(at[1], at[0]))
    if c.incremental:
        radius, angle = here + (radius or 0.0), direction + (angle or 0.0)
    r, a = here if radius is None else radius, math.radians(direction if angle is None else angle)
    return r * math.cos(a), r * math.sin(a)


def length(start: Sequence[float], end: Sequence[float]) -> float:
    """Length of a straight motion: of X Y Z, else of U V W, else the angle of A B C."""
    for axes in ((0, 1, 2), (6, 7, 8), (3, 4, 5)):
        distance = math.sqrt(sum((end[i] - start[i]) ** 2 for i in axes))
        if distance > 0.0:
            return distance
    return 0.0


def check_feed(c: Controller, block: Block) -> None:
    """A feed motion has a feed.

    Raises
    ------
    BlockFault
        There is none; or there is none in the block under inverse time (G93).
    """
    assert block.motion is not None
    if c.feed_mode == 93 and "f" not in block.values:
        raise block.fault(f"{MOTION[block.motion]} under inverse time (G93) needs F in its block", "g.motion", *AXES)
    if c.feed_mode == 95 and c.spindle.speed == 0.0:
        raise block.fault(
            "feed per revolution (G95) without a spindle speed; write S before", *block.axes(), "g.motion"
        )
    feed = block.values["f"] if c.feed_mode == 93 else c.feed
    if feed > 0.0 or c.feedless:
        return
    c.feedless = True  # said once, not for every block that follows
    if "f" in block.values:
        raise block.fault("the feed must be positive", "f")
    raise block.fault("feed motion without a feed; write F before it or in its block", *block.axes(), "g.motion")


def inverse_time(c: Controller, block: Block, distance: float) -> None:
    """The feed that runs a distance in 1/F minutes (G93)."""
    c.out.append(FeedRate(max(_LEAST_RATE, distance * block.values["f"]), c.line, c.number))


def straight(c: Controller, block: Block) -> None:
    """G0 and G1."""
    end = target(c, block)
    if block.motion == 10:
        check_feed(c, block)
        if c.feed_mode == 93:
            inverse_time(c, block, length(present(c), end))
    c.no_arc_yet = False
    if c.compensation is not None and c.compensation.radius > 0.0:
        compensation.straight(c, block, end)
    else:
        go(c, end, rapid=block.motion == 0)


def go(c: Controller, end: list[float], *, rapid: bool) -> None:
    """Straight to a place."""
    kind = Traverse if rapid else Feed
    c.at[:] = end
    c.out.append(kind(end[0], end[1], end[2], c.rotary, c.extra, c.line, c.number))


def reference(c: Controller, block: Block, code: int) -> None:
    """G28 and G30: to the stored position, by way of that of the axis words."""
    if c.compensation is not None:
        raise block.fault(f"{name(code)} cannot be used with cutter compensation; write G40 before", "g.non-modal")
    letters = block.axes()
    go(c, target(c, block), rapid=True)
    end = from_machine(c.offsets, home(c, HOMES[code]))
    if letters:
        end = [new if AXES[i] in letters else old for i, (old, new) in enumerate(zip(c.at, end, strict=True))]
    if not any(c.numbers.get(HOMES[code] + i) for i in range(9)):
        c.notice(f"{name(code)} goes to a position that was not given; the machine's zero was taken")
    go(c, end, rapid=True)


def probe(c: Controller, block: Block) -> None:
    """G38.2 to G38.5: recorded; what is found is taken to be the target."""
    assert block.motion is not None
    word = MOTION[block.motion]
    if not block.axes():
        raise block.fault(f"{word} needs axis words", "g.motion")
    if c.compensation is not None:
        raise block.fault(f"{word} cannot be used with cutter compensation; write G40 before", "g.motion")
    check_feed(c, block)
    end = target(c, block)
    if c.feed_mode == 93:
        inverse_time(c, block, length(c.at, end))
    c.notice(f"{word} is not simulated: the probe is taken to touch at its target")
    c.at[:] = end
    c.out.append(Signal("TURN_PROBE_ON", "", c.line, c.number))
    c.out.append(Probe(end[0], end[1], end[2], c.rotary, c.extra, c.line, c.number))
    c.out.append(Signal("TURN_PROBE_OFF", "", c.line, c.number))
    for i, value in enumerate(end):
        c.numbers[5061 + i] = value
    c.numbers[5070] = 1.0


def synchronised(c: Controller, block: Block) -> None:
    """G33 and G33.1: a feed in step with the spindle."""
    assert block.motion is not None
    word = MOTION[block.motion]
    if "k" not in block.values:
        raise block.fault(f"{word} needs the distance per revolution K", "g.motion", *AXES)
    if not c.spindle.turning:
        raise block.fault(f"{word} needs a turning spindle; write M3 or M4 before", "g.motion", *AXES)
    if c.compensation is not None:
        raise block.fault(f"{word} cannot be used with cutter compensation; write G40 before", "g.motion")
    end = target(c, block)
    c.out.append(SpindleSync(block.values["k"], c.line, c.number))
    if block.motion == 330:
        go(c, end, rapid=False)
    else:
        c.out.append(RigidTap(end[0], end[1], end[2], c.line, c.number))
    c.out.append(SpindleSync(0.0, c.line, c.number))
