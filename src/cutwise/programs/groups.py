"""G and M words, the modal groups they form, and the words that each of them makes use of. Codes are ten times the G."""

MOTION = {
    0: "G0", 10: "G1", 20: "G2", 30: "G3", 50: "G5", 51: "G5.1", 52: "G5.2", 53: "G5.3", 330: "G33", 331: "G33.1",
    382: "G38.2", 383: "G38.3", 384: "G38.4", 385: "G38.5", 730: "G73", 740: "G74", 800: "G80", 810: "G81", 820: "G82",
    830: "G83", 840: "G84", 850: "G85", 860: "G86", 880: "G88", 890: "G89",
}  # fmt: skip
CYCLES = frozenset({730, 740, 810, 820, 830, 840, 850, 860, 880, 890})
PROBES = frozenset({382, 383, 384, 385})
STRAIGHT = frozenset({0, 10})

_G_GROUPS = {
    "motion": tuple(MOTION),
    "non-modal": (40, 100, 280, 281, 300, 301, 520, 530, 920, 921, 922, 923),
    "plane": (170, 180, 190),
    "units": (200, 210),
    "distance mode": (900, 910),
    "arc distance mode": (901, 911),
    "feed mode": (930, 940, 950),
    "cutter compensation": (400, 410, 411, 420, 421),
    "tool length": (430, 431, 432, 490),
    "work coordinates": (540, 550, 560, 570, 580, 590, 591, 592, 593),
    "path control": (610, 611, 640),
    "return of cycles": (980, 990),
    "spindle mode": (960, 970),
}
G_GROUP = {code: group for group, codes in _G_GROUPS.items() for code in codes}

_M_GROUPS = {
    "stop": (0, 1, 2, 30, 60, 98, 99),
    "tool change": (6, 61),
    "spindle": (3, 4, 5, 19, 70, 71, 72, 73),
    "coolant": (7, 8, 9),
    "overrides": (48, 49, 50, 51, 52, 53),
    "inputs and outputs": (62, 63, 64, 65, 66, 67, 68),
}
M_GROUP = {code: group for group, codes in _M_GROUPS.items() for code in codes}

LATHE = frozenset({70, 80, 700, 710, 711, 712, 720, 721, 722, 760})

TAKES_AXES = frozenset({100, 280, 300, 520, 920})
"""Codes outside of the motion group that the axis words of their block belong to."""
SHARES_AXES = frozenset({431, 432})
"""Codes that keep the modal motion from using the axis words, but not a motion of the same block."""

_TOOL_SIDE = frozenset({410, 411, 420, 421})
_ARCS = frozenset({20, 30})

G_WORDS: dict[str, frozenset[int]] = {  # letter: G codes that make use of it
    "d": _TOOL_SIDE | {960},
    "h": frozenset({430, 432}),
    "i": _ARCS | {50, 51, 100},
    "j": _ARCS | {50, 51, 100},
    "k": _ARCS | {330, 331},
    "l": CYCLES | {52, 100},
    "p": _ARCS | {40, 50, 52, 100, 640, 740, 820, 840, 860, 880, 890},
    "q": frozenset({50, 100, 640, 730, 830}),
    "r": _ARCS | CYCLES | {100},
}
M_WORDS: dict[str, frozenset[int]] = {  # letter: M codes that make use of it
    "e": frozenset({66, 67, 68}),
    "l": frozenset({66, 98}),
    "p": frozenset({19, 50, 51, 52, 53, 62, 63, 64, 65, 66, 98}),
    "q": frozenset({19, 61, 66, 67, 68}),
    "r": frozenset({19}),
}
BOUND_LETTERS = G_WORDS.keys() | M_WORDS.keys()  # letters that need one of those codes in their block


def name(code: int) -> str:
    """A code as it is written: 611 is G61.1."""
    return f"G{code // 10}" + (f".{code % 10}" if code % 10 else "")
