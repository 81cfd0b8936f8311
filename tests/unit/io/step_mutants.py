"""Damaged STEP files for tests: one change to a sound file, chosen by a seed."""

import random
import re
from collections.abc import Callable

_INSTANCE = re.compile(r"^#\d+ ?=.*?;[^\S\n]*$", re.MULTILINE | re.DOTALL)
_ARGUMENT = re.compile(r"(?<=[(,])\s*('[^']*'|[^(),']+)\s*(?=[,)])")
_NUMBER = re.compile(r"(?<=[(,])\s*[-+]?\d[\d.Ee+-]*\s*(?=[,)])")
_REFERENCE = re.compile(r"#\d+(?=[,)])")

_ODD_NUMBERS = (
    "0.",
    "-1.",
    "1.E-300",
    "1.E+300",
    "-1.E+38",
    "1.E+09",
    "99999999",
    "1.E",
    "1..2",
    "NAN",
    "'x'",
    "-7",
    "2",
)

Damage = Callable[[str, random.Random], str]


def _one(pattern: re.Pattern[str], text: str, dice: random.Random, new: Callable[[re.Match[str]], str]) -> str:
    found = dice.choice(list(pattern.finditer(text, text.index("DATA;") + 5)))
    return text[: found.start()] + new(found) + text[found.end() :]


def a_line_less(text: str, dice: random.Random) -> str:
    """Any line of the file is missing, the whole statement or a piece of it."""
    lines = text.splitlines(keepends=True)
    del lines[dice.randrange(len(lines))]
    return "".join(lines)


def a_statement_less(text: str, dice: random.Random) -> str:
    return _one(_INSTANCE, text, dice, lambda _: "")


def an_argument_unset(text: str, dice: random.Random) -> str:
    return _one(_ARGUMENT, text, dice, lambda _: "$")


def an_argument_of_another_type(text: str, dice: random.Random) -> str:
    new = dice.choice(["'text'", "1.5", "3", ".T.", ".U.", "*", "()", "(1.,2.)", "(#10,#11)", "#1", '"0F"', ".WRONG."])
    return _one(_ARGUMENT, text, dice, lambda _: new)


def a_reference_elsewhere(text: str, dice: random.Random) -> str:
    other = dice.choice(_REFERENCE.findall(text))
    return _one(_REFERENCE, text, dice, lambda _: other)


def a_reference_to_itself(text: str, dice: random.Random) -> str:
    def looped(m: re.Match[str]) -> str:
        return m[0][: m[0].index("=")].strip() if "=" in m[0] else m[0]

    def statement(m: re.Match[str]) -> str:
        own = looped(m)
        head, _, rest = m[0].partition("=")
        return head + "=" + _REFERENCE.sub(own, rest, count=1)

    return _one(_INSTANCE, text, dice, statement)


def a_reference_to_nothing(text: str, dice: random.Random) -> str:
    return _one(_REFERENCE, text, dice, lambda _: "#987654")


def an_odd_number(text: str, dice: random.Random) -> str:
    new = dice.choice(_ODD_NUMBERS)
    return _one(_NUMBER, text, dice, lambda _: new)


def cut_short(text: str, dice: random.Random) -> str:
    return text[: dice.randrange(len(text))]


def a_keyword_for_another(text: str, dice: random.Random) -> str:
    words = sorted(set(re.findall(r"= *([A-Z][A-Z0-9_]+)", text)))
    return _one(re.compile(r"= *[A-Z][A-Z0-9_]+"), text, dice, lambda _: "= " + dice.choice(words))


def two_swapped_arguments(text: str, dice: random.Random) -> str:
    pattern = re.compile(r"(?<=[(,])(#\d+),(#\d+)(?=[,)])")
    return _one(pattern, text, dice, lambda m: f"{m[2]},{m[1]}")


def a_list_of_another_length(text: str, dice: random.Random) -> str:
    pattern = re.compile(r"\(([^()]*,)?[^()]*\)(?=[,)])")
    return _one(pattern, text, dice, lambda m: dice.choice(["()", m[0][:-1] + "," + m[0][1:]]))


def letters_garbled(text: str, dice: random.Random) -> str:
    letters = list(text)
    for _ in range(dice.choice([1, 1, 3, 20])):
        letters[dice.randrange(len(letters))] = chr(dice.randrange(256))
    return "".join(letters)


DAMAGES: tuple[Damage, ...] = (
    a_line_less, a_statement_less, an_argument_unset, an_argument_of_another_type, a_reference_elsewhere,
    a_reference_to_itself, a_reference_to_nothing, an_odd_number, cut_short, a_keyword_for_another,
    two_swapped_arguments, a_list_of_another_length, letters_garbled,
)  # fmt: skip


def mutant(text: str, seed: int) -> tuple[str, str]:
    """A damaged copy of a STEP file, and what was done to it; the kinds take turns, the places are drawn."""
    damage = DAMAGES[seed % len(DAMAGES)]
    return damage(text, random.Random(seed)), damage.__name__
