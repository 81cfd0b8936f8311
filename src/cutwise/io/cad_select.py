"""Which edges of a CAD part are meant: the selectors of ``part.edges``."""

from collections.abc import Callable, Sequence

import numpy as np

from cutwise import units
from cutwise.io.cad_edges import EdgeChain
from cutwise.io.step import CadFault

_FACING = np.cos(np.radians(15.0))  # a face looks in a direction if its mean normal is closer to it than this
_DIRECTIONS = {sign + axis: float(sign + "1") * np.eye(3)["xyz".index(axis)] for axis in "xyz" for sign in "+-"}

HELP = (
    "all, outer, inner, closed, open, hole:N, edge:N or edge:N-M, longer:5mm, shorter:5mm, sharper:80deg, blunter:100deg, "
    "facing:+z; joined by commas (any of them), by & (all of them), with ! before one that must not hold"
)


def select(chains: Sequence[EdgeChain], wanted: str) -> tuple[EdgeChain, ...]:
    """Chains that a selector names.

    Parameters
    ----------
    chains : sequence of EdgeChain
        All chains of a part.
    wanted : str
        Words joined by commas and ``&``; see ``HELP``. ``sharper`` looks at the smallest wedge angle of an edge,
        ``blunter`` at the largest, ``facing`` at both faces.

    Raises
    ------
    CadFault
        No chain answers to it, or it cannot be read; the message says what there is.
    """
    terms = [[_test(word) for word in term.split("&")] for term in wanted.replace(" ", "").split(",")]
    found = tuple(chain for chain in chains if any(all(test(chain) for test in term) for term in terms))
    if not found:
        holes = sorted({n for chain in chains for n in chain.holes})
        raise CadFault(
            f'"{wanted}" selects no sharp edge; there are edges 1 to {len(chains)}'
            + (f" and holes {', '.join(map(str, holes))}" if holes else " and no holes")
        )
    return found


Test = Callable[[EdgeChain], bool]


def _test(word: str) -> Test:
    if word.startswith("!"):
        test = _test(word[1:])
        return lambda chain: not test(chain)
    kind, _, value = word.partition(":")
    plain: dict[str, Test] = {
        "all": lambda _: True, "outer": lambda c: c.where == "outer", "inner": lambda c: c.where == "inner",
        "closed": lambda c: c.closed, "open": lambda c: not c.closed,
    }  # fmt: skip
    if kind in plain and not value:
        return plain[kind]
    if kind in ("hole", "edge"):
        low, _, high = value.partition("-")
        if low.isdigit() and (not high or high.isdigit()):
            numbers = set(range(int(low), int(high or low) + 1))
            return lambda c: bool(numbers & set(c.holes if kind == "hole" else (c.number,)))
    if kind == "facing" and value in _DIRECTIONS:
        direction = _DIRECTIONS[value]
        return lambda c: bool((c.frames.normal.mean(axis=0) @ direction > _FACING).any())
    measured = _measured(kind, value, word)
    if measured is not None:
        return measured
    raise CadFault(f'"{word}" selects nothing: write {HELP}')


def _measured(kind: str, value: str, word: str) -> Test | None:
    """Selectors by length or wedge angle."""
    dimension = {"longer": "length", "shorter": "length", "sharper": "angle", "blunter": "angle"}.get(kind)
    if dimension is None or not value:
        return None
    try:
        limit = units.parse(value, dimension)
    except units.UnitFault as fault:
        raise CadFault(f'"{word}" selects nothing: {fault}') from None
    tests: dict[str, Test] = {
        "longer": lambda c: c.length > limit, "shorter": lambda c: c.length < limit,
        "sharper": lambda c: float(c.frames.wedge.min()) < limit,
        "blunter": lambda c: float(c.frames.wedge.max()) > limit,
    }  # fmt: skip
    return tests[kind]
