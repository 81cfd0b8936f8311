"""Numbers that no machine tool means: a file that is damaged, or not a program."""

MOST = 1e9
"""Greatest number in a program: a thousand kilometres in mm; spindle speeds, feeds and labels stay far below it."""


def out_of_scale(value: float) -> str:
    """What is said of a number beyond :data:`MOST`."""
    return f"{value:.6g} is out of scale: numbers in a program go up to {MOST:g}"
