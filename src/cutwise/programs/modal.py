"""Modal state along a program: at each line the words that are in force behind it, as the screen of a controller shows them."""

from collections.abc import Mapping

from cutwise.programs.canon import Feed, FeedRate, Traverse
from cutwise.programs.controller import INCH, MILLIMETRE, Controller
from cutwise.programs.interpreter import reading
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup

_PLANES: Mapping[str, str] = {"XY": "G17", "XZ": "G18", "YZ": "G19"}
_PATHS: Mapping[str, str] = {"exact_path": "G61", "exact_stop": "G61.1", "continuous": "G64"}
_SYSTEMS = ("", "G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
_TURNS: Mapping[int, str] = {-1: "M4", 0: "M5", 1: "M3"}
_MOST = 3  # states that are told of a line which runs in several


def words(c: Controller, feed: float, motion: int | None = None) -> str:
    """The words in force, one of each modal group; feed in the unit of the program, motion ten times the G."""
    on, spindle, switches = c.compensation, c.spindle, c.switches
    found = [
        f"G{(c.motion if motion is None else motion) / 10:g}",
        _PLANES[c.plane],
        "G20" if c.inch else "G21",
        "G91" if c.incremental else "G90",
        f"G{c.feed_mode}",
        "G40" if on is None else "G41" if on.left else "G42",
        _SYSTEMS[c.offsets.system],
        "G43" if any(c.offsets.tool) else "G49",
        _PATHS[c.path_mode],
        f"F{feed:.6g}" if feed > 0.0 else "",
        "G96" if spindle.surface_limit > 0.0 else "",
        f"S{spindle.speed:.10g}" if spindle.speed > 0.0 else "",
        _TURNS[spindle.turning],
        f"T{c.tool.number}" if c.tool.number else "",
        "M7" if switches.mist else "",
        "M8" if switches.flood else "" if switches.mist else "M9",
    ]
    return " ".join(word for word in found if word)


class _Watch:
    """Keeps what is in force behind every line of the main program."""

    closely = False

    def __init__(self, run: Rs274) -> None:
        self.run = run
        self.moved: dict[
            int, tuple[int, float]
        ] = {}  # lines of straight motions since the last other one: motion, feed
        self.found: dict[int, list[str]] = {}
        self.inch = run.controller.inch
        self.rate = run.controller.feed
        self.factor = 1.0  # of a feed that was given in another unit: it stays, and its number is another

    def told(self, line: int, text: str) -> None:
        """A state behind a line; one that runs several times may have several."""
        states = self.found.setdefault(line, [])
        if text not in states and len(states) <= _MOST:
            states.append(text)

    def ran_plain(self, first: int, end: int) -> None:
        """Lines of straight motions: only motion and feed change in them."""
        for line in range(first + 1, end + 1):
            motion, feed = self.moved[line]
            self.told(line, words(self.run.controller, feed, motion))
        self.moved.clear()

    def ran(self, at: int, controller: Controller) -> None:
        """Any other line."""
        if controller.feed != self.rate or any(word.letter == "f" for word in self.run.flow.main.line(at).words):
            self.factor = 1.0
        elif controller.inch != self.inch:
            self.factor *= MILLIMETRE / INCH if controller.inch else INCH / MILLIMETRE
        self.inch, self.rate = controller.inch, controller.feed
        self.told(at + 1, words(controller, self.factor * controller.feed))
        self.moved.clear()


def modal(text: str, name: str, setup: Setup) -> dict[int, str]:
    """The words in force behind each line that runs, by the number of the line; nothing for APT, which has no such words.

    A line that runs in several states, as in a loop, tells up to three of them.

    Raises
    ------
    ScenarioFault
        With everything in the program that cannot be run.

    Examples
    --------
    >>> modal("G21 G90\\nS800 M3\\nG1 X10 F200\\nX20\\nM2", "a.nc", Setup())[4]
    'G1 G17 G21 G90 G94 G40 G54 G49 G64 F200 S800 M3 M9'
    """
    run = reading(text, name, setup)
    if not isinstance(run, Rs274):
        return {}
    watch = _Watch(run)
    run.watch = watch
    for command in run.commands():
        if isinstance(command, FeedRate):
            watch.rate, watch.factor = command.rate, 1.0
        elif isinstance(command, Traverse | Feed):
            watch.moved[command.line] = (0 if isinstance(command, Traverse) else 10, watch.factor * watch.rate)
    return {line: _joined(states) for line, states in watch.found.items()}


def _joined(states: list[str]) -> str:
    more = " …" if len(states) > _MOST else ""
    return states[0] if len(states) == 1 else "from run to run: " + "; ".join(states[:_MOST]) + more
