"""Hostile inputs: mutations of good ones, and what has been found to hurt."""

import random
import re
from collections.abc import Callable, Iterator

HURTFUL = (
    "1e999", "-1e999", "1e308", "5e-324", "-0", "nan", ".nan", ".inf", "9" * 400, "9" * 5000, "1" + "0" * 60 + " mm",
    "0 mm", "-1 mm", "1e-300 mm", "1e60 mm", "3 mm^999", "2 mm/s**1e9", "1 m/m/m/m", "5 %", "1,5 mm", "١٢ mm", "½ mm",
    "1 1 mm", "0x10", "1_0_0 mm", "~", "null", "true", "[]", "{}", "[[]]", "''", '"\\ud800"', '"\\r"', '"\\x1b[2J"',
    '"\\0"', "!!binary x", "!!python/object:os.system x", "*a", "&a [*a]", "<<: *a", "=1+1", "@x", "- - -", "? :", "|",
    ">", "%", "`", "(" * 300, "[" * 3000, "{a: " * 400, "-" * 2000, "1 " + "mm*" * 500 + "mm", "deg rad rpm", "°", "µ",
    "1e5 rpm/rpm", "2 degC", "3 dB", "4 count", "1 mm**mm", "7 eval", "__import__('os')", "a" * 5000, "\u202e mm", "\ufeff",
)  # fmt: skip
_NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


def mutated(text: str, rng: random.Random) -> bytes:
    """A text with one to four things done to it."""
    for _ in range(rng.randint(1, 4)):
        text = rng.choice(_MUTATIONS)(text, rng)
    content = text[:300_000].encode("utf-8", errors="surrogatepass")
    return damaged(content, rng) if rng.random() < 0.15 else content


def damaged(content: bytes, rng: random.Random) -> bytes:
    """Bytes with a few of them changed, overwritten, or cut off."""
    if not content:
        return b"\0"
    found = bytearray(content)
    for _ in range(rng.randint(1, 5)):
        place, kind = rng.randrange(len(found)), rng.randrange(4)
        if kind == 0:
            found[place] ^= 1 << rng.randrange(8)
        elif kind == 1:
            found[place : place + 8] = rng.randbytes(8)
        elif kind == 2:
            found[place : place + rng.randint(1, 200)] = bytes(rng.randint(1, 200))
        else:
            found[place : place + 8] = b"\xff" * 8
    return bytes(found[: rng.randrange(len(found))] if rng.random() < 0.1 else found)


def _line_gone(text: str, rng: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    if lines:
        del lines[rng.randrange(len(lines))]
    return "".join(lines)


def _line_again(text: str, rng: random.Random) -> str:
    lines = text.splitlines(keepends=True) or [""]
    lines.insert(rng.randrange(len(lines)), rng.choice(lines) * rng.choice((1, 1, 2, 200)))
    return "".join(lines)


def _lines_swapped(text: str, rng: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    if len(lines) > 1:
        i, j = rng.sample(range(len(lines)), 2)
        lines[i], lines[j] = lines[j], lines[i]
    return "".join(lines)


def _number_hurt(text: str, rng: random.Random) -> str:
    numbers = list(_NUMBER.finditer(text))
    if not numbers:
        return text + rng.choice(HURTFUL)
    at = rng.choice(numbers)
    return text[: at.start()] + rng.choice(HURTFUL[:18]) + text[at.end() :]


def _value_hurt(text: str, rng: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    valued = [i for i, line in enumerate(lines) if ":" in line and not line.lstrip().startswith("#")]
    if valued:
        i = rng.choice(valued)
        lines[i] = lines[i].partition(":")[0] + ": " + rng.choice(HURTFUL) + "\n"
    return "".join(lines)


def _put_in(text: str, rng: random.Random) -> str:
    at = rng.randrange(len(text) + 1)
    what = rng.choice((*HURTFUL, "\0", "\r", "\x0b", "\x1b", "\u2028", "\t", "\n", " ", ":", "#", "'", '"', "\ud800"))
    return text[:at] + what + text[at:]


def _cut_out(text: str, rng: random.Random) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + text[at + rng.randint(1, 40) :]


def _deeper(text: str, rng: random.Random) -> str:
    opening, closing = rng.choice((("[", "]"), ("{a: ", "}"), ("(", ")"), ("- ", ""), ("<a>", "</a>")))
    depth, at = rng.choice((5, 60, 1500)), rng.randrange(len(text) + 1)
    return text[:at] + opening * depth + closing * depth + text[at:]


_MUTATIONS: tuple[Callable[[str, random.Random], str], ...] = (
    _line_gone, _line_again, _lines_swapped, _number_hurt, _number_hurt, _value_hurt, _value_hurt, _put_in, _cut_out,
    _deeper,
)  # fmt: skip


def quantities(rng: random.Random) -> Iterator[str]:
    """Texts that may or may not be quantities."""
    units = (
        "mm",
        "m",
        "N",
        "deg",
        "rpm",
        "rev",
        "s",
        "bar",
        "1/min",
        "/",
        "*",
        "^",
        "**",
        "(",
        ")",
        "2",
        "-1",
        "µ",
        "k",
        "%",
    )
    while True:
        number = rng.choice(("1", "2.5", "-3", "1e3", ".5", "5.", "1e", "", "1e308", "1e-308", "9" * 30, "١", "1,5"))
        yield number + rng.choice(("", " ")) + "".join(rng.choice((*units, " ")) for _ in range(rng.randint(0, 9)))
