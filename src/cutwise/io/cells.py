"""Cells of CSV tables that cutwise writes: a spreadsheet must not take a text for a formula."""

import re

import numpy as np

_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_QUANTITY = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?:\s+[^\s=+@].*)?")


def cell(value: object) -> str:
    """A value as a cell: numbers in full, texts quoted where need be and never the beginning of a formula.

    A quantity keeps its meaning: its sign is written as the minus of typography, which cutwise reads as well.

    >>> cell("=1+1"), cell("-5 deg"), cell(-5.0), cell("a, b")
    ("'=1+1", '−5 deg', '-5.0', '"a, b"')
    """
    if isinstance(value, bool | np.bool_):
        return str(value)
    if isinstance(value, float | np.floating):
        return repr(float(value))
    if isinstance(value, int | np.integer):
        return str(int(value))
    return quoted(harmless(value.decode("utf-8", errors="replace") if isinstance(value, bytes) else str(value)))


def harmless(text: str) -> str:
    """A text that no spreadsheet takes for a formula."""
    if not text.lstrip(" ").startswith(_FORMULA):
        return text
    if _QUANTITY.fullmatch(text):
        return text.replace("-", "\u2212", 1) if text.startswith("-") else text[1:]
    return f"'{text}"


def quoted(text: str) -> str:
    """A text as one cell, whatever it holds."""
    if any(letter in text for letter in ',"\n\r'):
        return '"' + text.replace('"', '""') + '"'
    return text
