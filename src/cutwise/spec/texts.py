"""Characters that no text of a scenario may hold: they end lines, or make a text read otherwise than it is written."""

import unicodedata

_TURNING = frozenset("\u200e\u200f\u061c\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")  # writing direction
_KINDS = frozenset(("Cc", "Cs", "Zl", "Zp"))  # control characters, halves of characters, line and paragraph ends
HALF = "half of a character"


def hidden(letter: str) -> bool:
    """Whether a character ends a line, steers a device, turns the writing direction, or is half of one."""
    return not (" " <= letter <= "~") and (unicodedata.category(letter) in _KINDS or letter in _TURNING)


def hidden_fault(text: str, *, lines: bool = False) -> str | None:
    """What is wrong with a text that holds such a character; with ``lines`` it may have several lines and tabs.

    >>> hidden_fault("part 7\\rM3 S20000")
    'holds a control character (U+000D) after "part 7"; leave it out'
    """
    if text.isprintable():
        return None
    for place, letter in enumerate(text):
        if hidden(letter) and not (lines and letter in "\n\r\t"):
            kind = HALF if unicodedata.category(letter) == "Cs" else "a control character"
            after = f' after "{text[max(0, place - 20) : place]}"' if place else " at its beginning"
            return f"holds {kind} (U+{ord(letter):04X}){after}; leave it out"
    return None


def visible(text: str, *, lines: bool = True) -> str:
    """A text as it may be shown: each hidden character as its number, line ends kept unless ``lines`` is off.

    >>> visible("a\\x1b[2Jb")
    'a<U+001B>[2Jb'
    """
    if text.isprintable():
        return text
    return "".join(
        f"<U+{ord(letter):04X}>" if hidden(letter) and not (lines and letter in "\n\t") else letter for letter in text
    )
