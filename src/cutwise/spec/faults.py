"""What is wrong with a scenario: every fault with its place, all of them at once."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from cutwise.spec.texts import visible

_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")

Path = tuple[str | int, ...]


def dotted(path: Iterable[str | int]) -> str:
    """A path as people write it: ``("chain", 2, "mass")`` is ``chain[2].mass``."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text


def split_dotted(text: str) -> Path:
    """The path that :func:`dotted` wrote."""
    return tuple(int(index) if index else name for name, index in _STEP.findall(text))


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault of the input, in plain words, with the place where it stands."""

    path: Path
    message: str
    line: int | None = None
    column: int | None = None
    file: str = ""

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part not in ("", None))
        key = dotted(self.path)
        if key and place.endswith((f" {key}", f'["{key}"]')):  # the place is the key: --set KEY, overrides["KEY"]
            key = ""
        return visible(": ".join(part for part in (place, key, self.message) if part), lines=False)


class ScenarioFault(Exception):
    """A scenario that cannot be run. ``faults`` holds everything that is wrong with it."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__(self.faults)

    def __str__(self) -> str:
        count = len(self.faults)
        total = f"{count} fault{'s' if count != 1 else ''}, nothing was run"
        return "\n".join([*(str(fault) for fault in self.faults), total])


class NoSuchName(KeyError):
    """A name that is not there, with the one that was probably meant."""

    def __init__(self, kind: str, name: object, known: Iterable[str], where: str) -> None:
        names = [str(one) for one in known]
        near = get_close_matches(str(name), names, n=1)
        hint = (
            f"did you mean {near[0]}?"
            if near
            else f"there are {', '.join(names[:12])}{', ...' if len(names) > 12 else ''}"
        )
        super().__init__(f'no {kind} "{name}"; {hint} ({len(names)}: {where})')

    def __str__(self) -> str:
        return str(self.args[0])


def all_faults(*jobs: Callable[[], object]) -> None:
    """Run jobs that may find faults, all of them, and raise what they found together.

    Raises
    ------
    ScenarioFault
        With the faults of every job.
    """
    faults: list[Fault] = []
    for job in jobs:
        try:
            job()
        except ScenarioFault as found:
            faults += found.faults
    if faults:
        raise ScenarioFault(faults)
