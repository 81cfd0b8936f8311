"""A block with its numbers computed: which codes of which groups, which words, and what they belong to."""

from collections.abc import Sequence

from cutwise.programs.expressions import BlockFault, Variables, computed, in_scale, whole
from cutwise.programs.groups import (
    BOUND_LETTERS,
    G_GROUP,
    G_WORDS,
    LATHE,
    M_GROUP,
    M_WORDS,
    MOTION,
    SHARES_AXES,
    STRAIGHT,
    TAKES_AXES,
    name,
)
from cutwise.programs.words import Word

AXIS_LETTERS = "xyzabcuvw@^"


class Block:
    """The words of one line, each with its value and its place."""

    __slots__ = ("g", "left_in_force", "m", "motion", "places", "values")

    def __init__(self) -> None:
        self.values: dict[str, float] = {}
        self.g: dict[str, int] = {}  # group: ten times the code
        self.m: dict[str, int] = {}  # group: the code
        self.places: dict[str, int] = {}  # of letters, and of groups as g.GROUP and m.GROUP
        self.motion: int | None = None  # the motion of this block
        self.left_in_force: int | None = None  # a motion that the block names without running it

    def get(self, letter: str) -> float | None:
        """The value of a word, if it is there."""
        return self.values.get(letter)

    def place(self, *keys: str) -> int:
        """Where the first of some words or groups stands; the beginning if none is there."""
        return next((self.places[key] for key in keys if key in self.places), 0)

    def fault(self, message: str, *keys: str) -> BlockFault:
        """Something that cannot be run, at the place of the first of some words or groups."""
        return BlockFault(message, self.place(*keys))

    def whole(self, letter: str) -> int | None:
        """The value of a word that must be whole and not negative."""
        if letter not in self.values:
            return None
        value = whole(self.values[letter], self.places[letter], letter.upper())
        if value < 0:
            raise self.fault(f"{letter.upper()} must not be negative, found {value}", letter)
        return value

    def axes(self) -> list[str]:
        """Letters of the axis words, polar ones included."""
        return [letter for letter in AXIS_LETTERS if letter in self.values]

    def codes(self) -> set[int]:
        """All G codes in force in this block only, and its motion."""
        motion = set() if self.motion is None else {self.motion}
        return {code for group, code in self.g.items() if group != "motion"} | motion


def computed_block(words: Sequence[Word], variables: Variables) -> Block:
    """The words of a line with their numbers.

    Raises
    ------
    BlockFault
        A word twice, two codes of one group, an unknown code, a number that does not exist.
    """
    block = Block()
    for letter, value, place in words:
        number = in_scale(computed(value, variables), place)
        if letter == "g":
            _add_g(block, number, place)
        elif letter == "m":
            _add_m(block, number, place)
        elif letter in block.values:
            raise BlockFault(f"word {letter.upper()} twice in one block", place)
        else:
            block.values[letter] = number
            block.places[letter] = place
    return block


def _add_g(block: Block, number: float, place: int) -> None:
    code = whole(10.0 * number, place, "ten times a G code")
    group = G_GROUP.get(code)
    if group is None:
        reason = "is for lathes, which are not supported" if code in LATHE else "is unknown or not supported"
        raise BlockFault(f"G{number:g} {reason}", place)
    if group == "motion" and 800 in (code, block.g.get(group)):  # G80 gives way to a motion of its block
        code = code if block.g.get(group, 800) == 800 else block.g[group]
    elif group in block.g:
        both = f"{name(block.g[group])} and {name(code)}"
        raise BlockFault(f"{both} are of one modal group ({group}); one of them per block", place)
    block.g[group] = code
    block.places["g." + group] = place


def _add_m(block: Block, number: float, place: int) -> None:
    code = whole(number, place, "an M code")
    group = M_GROUP.get(code)
    if group is None:
        reason = "are for the user to define and not known here" if 100 <= code <= 199 else ""
        raise BlockFault(
            f"M{code} is unknown or not supported" if not reason else f"M{code}: M100 to M199 {reason}", place
        )
    if group in block.m:
        raise BlockFault(
            f"M{block.m[group]} and M{code} are of one modal group ({group}); one of them per block", place
        )
    block.m[group] = code
    block.places["m." + group] = place


def without_call(block: Block) -> Block | None:
    """What stands in a block beside M98 P L or M99; None if nothing does."""
    rest = Block()
    rest.values = {letter: value for letter, value in block.values.items() if letter not in ("p", "l")}
    rest.g = dict(block.g)
    rest.m = {group: code for group, code in block.m.items() if group != "stop"}
    rest.places = block.places
    return rest if rest.values or rest.g or rest.m else None


def settle(block: Block, modal: int) -> None:
    """Decide what the axis words of a block belong to, and that every word is of use.

    Parameters
    ----------
    block : Block
        Its ``motion`` is set: the code of its own motion word, or the modal one if axis words want it.
    modal : int
        Motion in force.

    Raises
    ------
    BlockFault
        Axis words without a use, or wanted twice; a word that nothing makes use of.
    """
    axes = block.axes()
    own = block.g.get("motion")
    taker = next((code for code in block.g.values() if code in TAKES_AXES), None)
    if own is not None:
        _own_motion(block, own, taker, axes)
    elif axes and taker is None and not SHARES_AXES & set(block.g.values()):
        if modal == 800:
            raise block.fault("axis words, but no motion is in force; write G0 or G1", axes[0])
        block.motion = modal
    elif taker is None and modal in (20, 30) and any(letter in block.values for letter in "ijk"):
        block.motion = modal
    _all_used(block)


def _own_motion(block: Block, own: int, taker: int | None, axes: Sequence[str]) -> None:
    if own == 800:
        if axes and taker is None:
            raise block.fault("axis words while motion is cancelled (G80); write G0 or G1", axes[0])
    elif taker is not None and own not in STRAIGHT:
        raise block.fault(
            f"{name(taker)} and {MOTION[own]} both want the axis words; one of them per block", "g.motion"
        )
    if taker is not None and own in STRAIGHT:  # G0 G91 G28 Z0: the axes are those of G28, G0 holds from here on
        block.left_in_force = own
    else:
        block.motion = own


def _all_used(block: Block) -> None:
    bound = block.values.keys() & BOUND_LETTERS
    if not bound:
        return
    codes, machine = block.codes(), set(block.m.values())
    for letter in block.values:
        if (
            letter in bound
            and codes.isdisjoint(G_WORDS.get(letter, ()))
            and machine.isdisjoint(M_WORDS.get(letter, ()))
        ):
            raise block.fault(_useless(letter, block), letter)


def _useless(letter: str, block: Block) -> str:
    users = sorted(G_WORDS.get(letter, ()))
    names = [name(code) for code in users] + [f"M{code}" for code in sorted(M_WORDS.get(letter, ()))]
    with_what = f" with {MOTION[block.motion]}" if block.motion is not None else ""
    return f"{letter.upper()} has no meaning{with_what or ' here'}; it belongs to {', '.join(names)}"
