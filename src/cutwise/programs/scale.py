"""Numbers that no machine tool means: a file that is damaged, or not a program."""

MOST = 1e9
"""Greatest number in a program: a thousand kilometres in mm; spindle speeds, feeds and labels stay far below it."""


def out_of_scale(value: float) -> str:
    """What is said of a number beyond :data:`MOST`."""
    return f"{value:.6g} is out of scale: numbers in a program go up to {MOST:g}"


LEAST_FEED = 1e-6
"""Least feed in the unit of a program: at less than that a millimetre takes two years."""


def feed_too_small(value: float) -> bool:
    """Whether a feed is a slip of the pen rather than slow."""
    return 0.0 < value < LEAST_FEED


def feed_out_of_scale(value: float) -> str:
    """What is said of such a feed."""
    return f"a feed of {value:g} is out of scale: feeds begin at {LEAST_FEED:g}"
