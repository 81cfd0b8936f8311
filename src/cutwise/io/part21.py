"""The text of a STEP file (ISO 10303-21): whole statements, references that lead somewhere, numbers that are some.

Looked at before any library reads the file, since a library may not survive what it finds: a statement cut off, a
reference to a line that is missing, a coordinate that is no number.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

LARGEST = 1e9  # of a coordinate in any unit of a part: nothing larger is machined, and readers do not come back from it

_MOST_SAID = 8  # faults of one kind that are told one by one
_NOISE = re.compile(r"/\*.*?\*/|'[^']*'|\"[^\"]*\"|\s+", re.DOTALL)
_STATEMENT = re.compile(r"(?:[^;'\"/]|'[^']*'|\"[^\"]*\"|/\*.*?\*/|/)*+;", re.DOTALL)
_DATA = re.compile(r"(?<![\w'])DATA\s*(?:\([^;]*\)\s*)?;", re.IGNORECASE)
_REFERENCE = re.compile(r"#(\d+)")
_INSTANCE = re.compile(r"#(\d+)=([A-Z!][A-Z0-9_!]*)?(\(.*\))", re.DOTALL | re.IGNORECASE)
_VALUE = r"(?:#\d+|[-+]?\d+(?:\.\d*)?(?:[EeDd][-+]?\d+)?|\.\w+\.|''|\"\"|\$|\*|@\d+|<[^<>,()]*>|_)"
_FLAT_LIST = re.compile(rf"[A-Z!]?[A-Z0-9_!]*\((?:{_VALUE}(?:,{_VALUE})*)?\)", re.IGNORECASE)
_COMPLEX = re.compile(r"\(_+\)|_")  # a statement whose lists are all read: one list, or the lists of a complex entity
_WORDS = re.compile(r"[A-Z][A-Z0-9_]*(?<!_MEASURE)(?=\()", re.IGNORECASE)
_POINT = re.compile(r"CARTESIAN_POINT\s*\(\s*(?:'[^']*'|\$)\s*,\s*\(([^()]*)\)", re.IGNORECASE)
_NO_NUMBER = re.compile(r"[(,]\s*([-+]?(?:nan|inf(?:inity)?))\s*[,)]", re.IGNORECASE)

_UNCERTAINTY = re.compile(
    r"UNCERTAINTY_MEASURE_WITH_UNIT\s*\(\s*LENGTH_MEASURE\s*\(\s*([-+]?\d+\.?\d*(?:E[-+]?\d+)?)\s*\)", re.IGNORECASE
)
_ROOT = re.compile(
    r"SHAPE_DEFINITION_REPRESENTATION|CONTEXT_DEPENDENT_SHAPE_REPRESENTATION|\w*SHAPE_REPRESENTATION\w*"
    r"|NEXT_ASSEMBLY_USAGE_OCCURRENCE|MAPPED_ITEM"
)  # fmt: skip


class TextFault(ValueError):
    """A file that is no whole STEP file, in plain words without its name."""


class Instance(NamedTuple):
    """One statement of the data section."""

    number: int  # as the file counts, #number
    place: int  # of the statement in the data section, from 0
    kind: str  # keyword; of a complex entity all of them, joined by +
    refers: tuple[int, ...]  # numbers of the instances that it names


class Exchange(NamedTuple):
    """The data section of a STEP file."""

    text: str  # the whole file
    start: int  # of the data section in the text
    instances: Mapping[int, Instance]
    order: tuple[int, ...]  # numbers in the order of the file
    shape: frozenset[int]  # numbers of all instances that the shapes are made of
    loose: tuple[str, ...]  # references that lead nowhere, outside of the shapes

    def line(self, number: int) -> int:
        """Line of the file in which an instance begins, from 1."""
        return _line_of(self.text, self.start, self.instances[number].place)

    def uncertainty(self) -> float:
        """Largest distance, in the length unit of the file, within which the file says that points are one; or 0."""
        return max((float(found[1]) for found in _UNCERTAINTY.finditer(self.text)), default=0.0)

    def faces(self) -> int:
        """How many faces the shapes have in the file."""
        kinds = ("ADVANCED_FACE", "FACE_SURFACE")
        return sum(self.instances[n].kind in kinds for n in self.shape)


def exchange(text: str) -> Exchange:
    """Read the data section of a STEP file as statements and references.

    Raises
    ------
    TextFault
        A statement cannot be read, an instance is there twice, what the shapes are made of refers to instances that
        are missing, or the file ends too early; the message says where.
    """
    if "ISO-10303-21" not in text[:2000]:
        raise TextFault("not a STEP file (it does not begin with ISO-10303-21)")
    section = _DATA.search(text)
    if section is None:
        raise TextFault("a STEP file without geometry: it has a header and no data section")
    _check_numbers(text)
    start = section.end()
    instances, faults, ended = _instances(text, start)
    shape = _reached(instances)
    missing = [(i.number, n) for i in instances.values() for n in i.refers if n not in instances]
    faults += [
        (instances[a].place, f"#{a} = {_short(instances[a].kind)} refers to #{b}, which is missing")
        for a, b in missing if a in shape and ended
    ]  # fmt: skip
    if faults:
        raise TextFault(_told(text, start, sorted(faults)))
    if not instances:
        raise TextFault("a STEP file without geometry: its data section is empty")
    loose = tuple(
        f"#{a} = {_short(instances[a].kind)} refers to #{b}, which is missing" for a, b in missing if a not in shape
    )
    return Exchange(text, start, instances, tuple(instances), shape, loose)


def _instances(text: str, start: int) -> tuple[dict[int, Instance], list[tuple[int, str]], bool]:
    """All statements of the data section, what is wrong with them by their places, and whether the section ends."""
    flat = _NOISE.sub(lambda m: m[0][0] * 2 if m[0][0] in "'\"" else "", text[start:]).replace("''''", "''")
    found: dict[int, Instance] = {}
    faults: list[tuple[int, str]] = []
    ended = False
    for place, statement in enumerate(flat.split(";")):
        if statement[:6].upper() == "ENDSEC":
            ended = True
            break
        read = _INSTANCE.fullmatch(statement)
        if read is None or not _whole(read):
            what = statement[:60] + ("..." if len(statement) > 60 else "")
            if what:
                faults.append((place, f"is no whole statement: {what}"))
            continue
        number = int(read[1])
        if number in found:
            faults.append((place, f"#{number} is there twice"))
        kind = (read[2] or "+".join(_WORDS.findall(read[3]))).upper()
        found[number] = Instance(number, place, kind, tuple(map(int, _REFERENCE.findall(read[3]))))
    if not ended:  # whatever else is wrong follows from that
        last = max((i.place for i in found.values()), default=0)
        faults = [(last, "the last whole statement: the file is cut short, its data section does not end")]
    return found, faults, ended


def _whole(read: re.Match[str]) -> bool:
    """Whether the parameters of a statement are lists of values, however deep."""
    left, before = read[3], ""
    while left != before:
        before, left = left, _FLAT_LIST.sub("_", left)
    return _COMPLEX.fullmatch(left) is not None


def _reached(instances: Mapping[int, Instance]) -> frozenset[int]:
    """What the shapes of the file are made of: everything that their representations refer to."""
    waiting = [n for n, i in instances.items() if any(_ROOT.fullmatch(word) for word in i.kind.split("+"))]
    seen = set(waiting)
    while waiting:
        for n in instances[waiting.pop()].refers:
            if n not in seen and n in instances:
                seen.add(n)
                waiting.append(n)
    return frozenset(seen)


def _told(text: str, start: int, faults: Sequence[tuple[int, str]]) -> str:
    """All faults as one message, the first of them with their lines."""
    said = [f"line {_line_of(text, start, place)}: {what}" for place, what in faults[:_MOST_SAID]]
    more = len(faults) - len(said)
    return "; ".join([*said, *([f"and {more} more"] if more > 0 else [])]) + "; the file is damaged: export it again"


def _line_of(text: str, start: int, place: int) -> int:
    """Line in which a statement of the data section begins, from 1."""
    at = start
    for _ in range(place):
        found = _STATEMENT.match(text, at)
        if found is None:
            break
        at = found.end()
    while at < len(text) and text[at].isspace():
        at += 1
    return text.count("\n", 0, at) + 1


def _short(kind: str) -> str:
    return kind if len(kind) <= 60 else kind[:57] + "..."


def _check_numbers(text: str) -> None:
    """Refuse numbers that are none, and coordinates so large in any unit that reading them would not end."""
    damaged = "the file is damaged: export it again"
    bad = _NO_NUMBER.search(text)
    if bad is not None:
        raise TextFault(f"line {text.count(chr(10), 0, bad.start()) + 1}: {bad[1]} is not a number; {damaged}")
    for found in _POINT.finditer(text):
        for word in found[1].split(","):
            if not _is_length(word):
                line = text.count("\n", 0, found.start()) + 1
                shown = word.strip() or "that is missing"
                raise TextFault(f"line {line}: the coordinate {shown} is no length of a part; {damaged}")


def _is_length(word: str) -> bool:
    try:
        value = float(word)
    except ValueError:
        return False
    return math.isfinite(value) and abs(value) <= LARGEST


def listed(items: Iterable[str], most: int = 3) -> str:
    """Some of many things, and how many more there are."""
    found = list(items)
    return "; ".join(found[:most]) + (f"; and {len(found) - most} more" if len(found) > most else "")
