"""What a file is that is not a program which can be run: said once, instead of one fault for every line."""

import re
from typing import NamedTuple

_LOOKED_AT = 40_000  # characters
_SUPPORTED = "G-code (RS274/NGC or Fanuc) and APT cutter location data are read"
_POSTED = f"let the CAM system post it as G-code or write CL data; {_SUPPORTED}"
_LINE = r"^[ \t]*(?:/\d?[ \t]*)?(?:N?\d+[ \t]+|N\d+[ \t]*)?"

_FILES = (  # first characters of files that are no programs
    ("ISO-10303-21", "a STEP file; cutwise part lists what is in it"),
    ("%PDF-", "a PDF document"),
    ("PK\x03\x04", "a packed (zip) file; unpack it first"),
    ("\x1f\x8b", "a packed (gzip) file; unpack it first"),
    ("<!DOCTYPE", "a page of the web, not what it links to; save the program itself"),
    ("<html", "a page of the web, not what it links to; save the program itself"),
    ("<?xml", f"an XML document; {_SUPPORTED}"),
    ("{", f"a JSON document; {_SUPPORTED}"),
    ("process:", "a cutwise scenario; name the program file in it"),
)


class _Kind(NamedTuple):
    """A language that is not read: signs of which one line is enough, and some of which it takes three."""

    words: str
    strong: re.Pattern[str]
    weak: re.Pattern[str] | None = None


_HEIDENHAIN = (
    _LINE + r"(?:(?:BEGIN|END)[ \t]+PGM\b|(?:BLK[ \t]+FORM|CYCL[ \t]+DEF|TOOL[ \t]+CALL|CALL[ \t]+LBL)[ \t])",
    _LINE + r"(?:L|C|CC|CR|CT|CP|LP|FL|FC|RND|CHF)[ \t]+(?:[XYZABCIR][ \t]*[-+]?[.\dQ]|PA|PR|IPA|DR)",
)
_SIEMENS = (
    r"^%_N_\w+_(?:MPF|SPF)|^;\$PATH=|" + _LINE + r"(?:MCALL\b|DEF[ \t]+(?:REAL|INT|BOOL|STRING|CHAR|AXIS|FRAME)\b"
    r"|(?:CYCLE|POCKET|HOLES|LONGHOLE|SLOT)\d*[ \t]*\(|MSG[ \t]*\(\"|WORKPIECE[ \t]*\(|TRAORI|TRAFOOF"
    r"|A?TRANS[ \t]+[XYZ]|A?R(?:OT|PL)[ \t]+[XYZ]|GOTO[FB][ \t]+\w|EXTERN\b|PROC[ \t]+\w|R\d+[ \t]*=|T[ \t]*=[ \t]*\""
    r"|ENDFOR\b|STOPRE\b)",
    r"^[^;(#\n]*\b(?:[XYZABCIJK][ \t]*=[ \t]*(?:R\d|[AID]C[ \t]*\()|CR[ \t]*=|G64[123]\b|SUPA\b)",
)
_KINDS = (
    _Kind(
        f"a Heidenhain program in plain language (BEGIN PGM, TOOL CALL, L X+...); {_POSTED}",
        re.compile(_HEIDENHAIN[0], re.IGNORECASE | re.MULTILINE),
        re.compile(_HEIDENHAIN[1], re.MULTILINE),
    ),
    _Kind(
        f"a Heidenhain program in DIN/ISO (lines end with *); {_POSTED}",
        re.compile(r"\A\s*%[^\n*]*[ \t]G7[01][ \t]*\*", re.IGNORECASE),
        re.compile(r"^[ \t]*N\d+[^\n(]*\*[ \t]*\r?$", re.MULTILINE),
    ),
    _Kind(
        f"an ABB robot program (RAPID); {_POSTED}",
        re.compile(r"^[ \t]*(?:MODULE[ \t]+\w+|Move(?:Abs)?[LJC][ \t]+[\[\w])", re.IGNORECASE | re.MULTILINE),
    ),
    _Kind(
        f"a Siemens (SINUMERIK) program; {_POSTED}",
        re.compile(_SIEMENS[0], re.IGNORECASE | re.MULTILINE),
        re.compile(_SIEMENS[1], re.IGNORECASE | re.MULTILINE),
    ),
    _Kind(
        f"an Okuma (OSP) program; {_POSTED}",
        re.compile(
            r"^\$[\w.-]+\.(?:MIN|SUB|SSB|LIB)%|"
            + _LINE
            + r"(?:VC\d+[ \t]*=|LET[ \t]+\w+[ \t]*=|NOEX\b|DEF[ \t]+WORK\b|CLEAR\b)",
            re.IGNORECASE | re.MULTILINE,
        ),
        re.compile(r"\bG15[ \t]+H\d|\bCALL[ \t]+O\w|\bGOTO[ \t]+N[A-Z]|\bV[CS]\d+\b|\bVZOF[XYZ]", re.IGNORECASE),
    ),
    _Kind(
        f"a Fagor program; {_POSTED}",
        re.compile(r"\A\s*%[^,\n]*,[-M][-X]", re.IGNORECASE),
    ),
    _Kind(
        f"a KUKA robot program (KRL); {_POSTED}",
        re.compile(
            r"^[ \t]*(?:&ACCESS\b|(?:LIN|PTP|CIRC|SLIN|SPTP)[ \t]+\{|DEF[ \t]+\w+[ \t]*\()",
            re.IGNORECASE | re.MULTILINE,
        ),
    ),
    _Kind(
        f"a drawing (DXF), not a program; {_POSTED}",
        re.compile(r"\A\s*(?:999[ \t]*\r?\n[^\n]*\n\s*)*0[ \t]*\r?\n[ \t]*SECTION\b"),
    ),
    _Kind(
        f"a mesh (STL), not a program; {_POSTED}",
        re.compile(r"\A\s*solid\b[^\n]*\r?\n\s*facet[ \t]+normal\b", re.IGNORECASE),
    ),
    _Kind(
        "a program of a 3D printer (temperatures, extruder E); nothing is cut with it",
        re.compile(_LINE + r"M(?:104|109|140|190)[ \t]+S\d", re.IGNORECASE | re.MULTILINE),
    ),
)
_ENOUGH = 3  # lines with a weak sign


def foreign_bytes(content: bytes) -> str | None:
    """What a file of a foreign encoding is, or None if it may be a program."""
    if content.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        return "is UTF-32 text; save it as UTF-8 or plain ASCII"
    head = content[:2000]
    if content.startswith((b"\xff\xfe", b"\xfe\xff")) or _alternates(head):
        return "is UTF-16 text; save it as UTF-8 or plain ASCII"
    return None


def _alternates(head: bytes) -> bool:
    """Whether every other byte is empty: UTF-16 without its mark."""
    even, odd = head[::2], head[1::2]
    return (
        len(head) > 3 and max(even.count(0), odd.count(0)) > 0.4 * len(even) and min(even.count(0), odd.count(0)) == 0
    )


def foreign_text(text: str, *, apt: bool) -> str | None:
    """What a text is that is no program to be run here, in one sentence; None if it may be one.

    Parameters
    ----------
    text : str
        The text of the file.
    apt : bool
        Whether it looks like APT cutter location data; then only signs are taken that CL data never has.
    """
    head = text[:_LOOKED_AT]
    start = head.lstrip(" \t\r\n\ufeff")
    for first, words in _FILES:
        if start[: len(first)].lower() == first.lower():
            return f"is {words}"
    if "\0" in head:
        return f"is a binary file, not text; {_SUPPORTED}"
    if apt:
        return None
    for kind in _KINDS:
        if kind.strong.search(head) or (kind.weak is not None and _times(kind.weak, head) >= _ENOUGH):
            return f"is {kind.words}"
    return None


def _times(pattern: re.Pattern[str], text: str) -> int:
    """How often a pattern is found, up to what is enough."""
    count = 0
    for _ in pattern.finditer(text):
        count += 1
        if count >= _ENOUGH:
            break
    return count
