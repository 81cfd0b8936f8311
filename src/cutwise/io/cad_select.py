"""Which edges of a CAD part are meant: the selectors of ``part.edges``."""

from collections.abc import Callable, Sequence

import numpy as np

from cutwise import units
from cutwise.io.cad_edges import EdgeChain
from cutwise.io.occ import CadFault
from cutwise.spec.chamfer import SELECTORS

_FACING = np.cos(np.radians(15.0))  # a face looks in a direction if its mean normal is closer to it than this
_DIRECTIONS = {sign + axis: float(sign + "1") * np.eye(3)["xyz".index(axis)] for axis in "xyz" for sign in "+-"}


def select(chains: Sequence[EdgeChain], wanted: str) -> tuple[EdgeChain, ...]:
    """Chains that a selector names.

    Parameters
    ----------
    chains : sequence of EdgeChain
        All chains of a part.
    wanted : str
        Words joined by commas and ``&``; see ``SELECTORS``. ``sharper`` looks at the smallest wedge angle of an edge,
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
        there = f"there are edges 1 to {len(chains)}" if len(chains) > 1 else "there is edge 1 only"
        raise CadFault(
            f'"{wanted}" selects no sharp edge; '
            + (there if chains else "the part has no sharp convex edge between two faces")
            + (f" and holes {', '.join(map(str, holes))}" if holes else " and no holes" if chains else "")
        )
    return found


def left_out(chains: Sequence[EdgeChain], wanted: str, chosen: Sequence[EdgeChain]) -> str:
    """What to say about rims that ``outer`` and ``inner`` do not mean, since no round hole makes them; empty if none."""
    words = {word.strip() for term in wanted.split(",") for word in term.split("&")}
    if not words & {"outer", "inner"}:
        return ""
    taken = {chain.number for chain in chosen}
    rims = [
        f"edge:{chain.number}" for chain in chains if chain.closed and not chain.where and chain.number not in taken
    ]
    if not rims:
        return ""
    return (
        f'part.edges "{wanted}" leaves out {counted(len(rims), "closed edge")} that no round hole makes, such as rims of '
        f"slots and countersinks: {', '.join(rims)}; add them by number if they are wanted"
    )


def counted(number: int, name: str) -> str:
    """A number of things."""
    return f"{number} {name}" + ("" if number == 1 else "s")


Test = Callable[[EdgeChain], bool]


def _test(word: str) -> Test:
    if word.startswith(("!", "not:")):
        test = _test(word.removeprefix("!").removeprefix("not:"))
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
        if low.isdigit() and high.isdigit() and int(high) < int(low):
            raise CadFault(f'"{word}" runs backwards: write {kind}:{high}-{low}')
        if low.isdigit() and (not high or high.isdigit()):
            numbers = set(range(int(low), int(high or low) + 1))
            return lambda c: bool(numbers & set(c.holes if kind == "hole" else (c.number,)))
    if kind == "facing" and value in _DIRECTIONS:
        direction = _DIRECTIONS[value]
        return lambda c: bool((c.frames.normal.mean(axis=0) @ direction > _FACING).any())
    measured = _measured(kind, value, word)
    if measured is not None:
        return measured
    raise CadFault(f'"{word}" selects nothing: write {SELECTORS}')


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
