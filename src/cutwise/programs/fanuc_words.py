"""Words of Fanuc controls that differ from RS274/NGC, brought into its terms before a block is run."""

from cutwise.programs.controller import Controller
from cutwise.programs.expressions import BlockFault
from cutwise.programs.groups import CYCLES

Given = tuple[str, float, int]  # letter, value, place

_DWELLING = frozenset({820, 860, 880, 890})
_IGNORED = {  # ten times the code: letters that go with it
    51: "pqr", 80: "p", 150: "", 230: "", 500: "", 501: "xyz", 670: "", 690: "",
}  # fmt: skip
"""Look-ahead (G5.1, G8), and cancelling what is not supported anyway: G15, G23, G50, G50.1, G67, G69."""
_REFUSED = {
    50: "high-speed machining and splines (G5) are not supported", 90: "exact stop in one block (G9) is not supported",
    160: "polar coordinates (G16) are not supported", 310: "skipping (G31) is not supported",
    330: "threads (G33) are not supported", 510: "scaling (G51) is not supported",
    511: "mirror images (G51.1) are not supported", 541: "additional work offsets (G54.1) are not supported",
    600: "one-sided approach (G60) is not supported", 660: "modal macro calls (G66) are not supported; call with G65",
    661: "modal macro calls (G66.1) are not supported; call with G65",
    680: "rotation of coordinates (G68) is not supported", 682: "tilted working planes (G68.2) are not supported",
    760: "fine boring (G76) is not supported", 870: "back boring (G87) is not supported",
}  # fmt: skip
_ELSEWHERE = frozenset(
    {52, 53, 281, 301, 331, 382, 383, 384, 385, 411, 421, 431, 432, 591, 592, 593, 611, 901, 911, 921, 922, 923}
)
"""Codes of LinuxCNC that mean something else on a Fanuc control, or nothing."""
_M_ELSEWHERE = frozenset({61, 70, 71, 72, 73})
_MILLISECONDS = 1e-3  # [s]


def adapted(c: Controller, words: list[Given]) -> list[Given]:
    """The words of a block as RS274/NGC would write them.

    Raises
    ------
    BlockFault
        A code that is not supported in this dialect, by its name.
    """
    codes = {round(10.0 * value): place for letter, value, place in words if letter == "g"}
    for code, place in codes.items():
        if code == 51 or code in _IGNORED:
            continue
        if code in _REFUSED:
            raise BlockFault(_REFUSED[code], place)
        if code in _ELSEWHERE:
            raise BlockFault(f"G{code / 10:g} is a word of the dialect rs274, not of fanuc", place)
    for letter, value, place in words:
        if letter == "m" and round(value) in _M_ELSEWHERE:
            raise BlockFault(
                f"M{value:g} is a word of the dialect rs274; on a Fanuc control it is the machine builder's", place
            )
    words = _without_ignored(c, words, codes)
    if 100 in codes:
        _check_data(words, codes[100])
    if 300 in codes:
        words = _second_reference(words)
    if 40 in codes:
        return _dwell(words)
    own = next((code for code in codes if code in CYCLES), None)
    if own is not None or (c.motion in CYCLES and not codes.keys() & {0, 10, 20, 30, 800, 280, 300, 920, 520}):
        words = _cycle(words, own)
    return [
        ("g", 61.1, place) if (letter, value) == ("g", 61.0) else (letter, value, place)
        for letter, value, place in words
    ]


def _without_ignored(c: Controller, words: list[Given], codes: dict[int, int]) -> list[Given]:
    for code in codes.keys() & _IGNORED.keys():
        c.notice(f"G{code / 10:g} (look-ahead, or cancelling what is not in force) changes no path; it is left out")
        letters = _IGNORED[code]
        words = [w for w in words if w[0] not in letters and not (w[0] == "g" and round(10.0 * w[1]) == code)]
    return words


def _check_data(words: list[Given], place: int) -> None:
    """G10 L2 P1 to P6 only: the other forms set other data than those of RS274/NGC."""
    form = next((value for letter, value, _ in words if letter == "l"), None)
    system = next((value for letter, value, _ in words if letter == "p"), None)
    if form != 2.0 or system not in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):
        raise BlockFault("of G10 only L2 P1 to P6 (origins of G54 to G59) is supported in the dialect fanuc", place)
    if any(letter == "r" for letter, _, _ in words):
        raise BlockFault("G10 L2 takes no R in the dialect fanuc", place)


def _second_reference(words: list[Given]) -> list[Given]:
    kept = [w for w in words if w[0] != "p"]
    for letter, value, place in words:
        if letter == "p" and value != 2.0:
            raise BlockFault("third and fourth reference points (G30 P3, P4) are not supported", place)
    return kept


def _dwell(words: list[Given]) -> list[Given]:
    """G4: X or U in seconds, P in milliseconds."""
    found = []
    for letter, value, place in words:
        if letter in "xu":
            found.append(("p", value, place))
        elif letter == "p":
            found.append(("p", value * _MILLISECONDS, place))
        else:
            found.append((letter, value, place))
    return found


def _cycle(words: list[Given], own: int | None) -> list[Given]:
    """Canned cycles: K repeats, P in milliseconds; no P means no dwell."""
    found = [
        ("l", value, place)
        if letter == "k"
        else ("p", value * _MILLISECONDS, place)
        if letter == "p"
        else (letter, value, place)
        for letter, value, place in words
    ]
    if own in _DWELLING and not any(letter == "p" for letter, _, _ in found):
        found.append(("p", 0.0, 0))
    return found
