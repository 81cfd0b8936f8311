"""How a study begins in its folder: what it is, how large its parts are; and whether a folder holds the same one."""

import json
import time
from pathlib import Path
from typing import Any

from cutwise import __version__
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.many import folder as at
from cutwise.study.many.cases import evaluate, limit_scales, step_errors
from cutwise.study.many.definition import SEARCHES, Study, in_the_middle
from cutwise.study.many.packing import pack, unpack

_LASTS = 10.0  # [s] that a part should take
_SMALLEST, _LARGEST = 32, 4096
_PARTS = 64  # that there should be, so that workers end together
_NAMED = 3  # keys that are named where scenarios differ


def chunk_size(study: Study) -> int:
    """Cases of a part, so that it takes some seconds and there are some dozens of parts; found from a few cases."""
    count = min(4, study.cases)
    evaluate(study, 0, count, {})  # compiles, too
    start = time.process_time()
    evaluate(study, 0, count, {})
    each = max(1e-4, (time.process_time() - start) / count)
    size = _SMALLEST
    while size < _LARGEST and 2 * size * each < _LASTS and 2 * size * _PARTS <= study.cases:
        size *= 2
    return size


def begun(
    study: Study, folder: Path, *, resume: bool, chunk: int | None = None, accept_version: bool = False
) -> dict[str, Any]:  # fmt: skip
    """The identity of a study in its folder, which is made where it is not there.

    Raises
    ------
    ScenarioFault
        The folder holds another study, or parts of this one without ``resume``.
    """
    return made(study, folder, known(study, folder, resume=resume, accept_version=accept_version), chunk)


def known(study: Study, folder: Path, *, resume: bool, accept_version: bool = False) -> dict[str, Any] | None:
    """The identity of the study that is in its folder already; None if the folder is free.

    Raises
    ------
    ScenarioFault
        As :func:`begun`.
    """
    found = at.identity_in(folder)
    if found is not None:
        return _same(study, folder, found, resume=resume, accept_version=accept_version)
    if (folder / "parts").exists() and any((folder / "parts").iterdir()):
        raise refused(folder, "holds parts of a study without its identity; take another folder (-o)")
    return None


def made(study: Study, folder: Path, there: dict[str, Any] | None, chunk: int | None) -> dict[str, Any]:
    """The identity, made where there is none, with all that a worker needs in the folder."""
    if there is None:
        errors = step_errors(in_the_middle(study))
        size = chunk or (1 if study.method in SEARCHES else chunk_size(study))
        there = at.identity_of(study, __version__, size, errors, limit_scales(in_the_middle(study)))
    at.started(folder, json.dumps(pack(study)), there)
    return there


def refused(folder: Path, message: str) -> ScenarioFault:
    """A fault of a folder."""
    return ScenarioFault([Fault((), message, file=str(folder))])


def _same(
    study: Study, folder: Path, known: dict[str, Any], *, resume: bool, accept_version: bool
) -> dict[str, Any]:  # fmt: skip
    """The identity of the folder, if it holds this study and the user means to go on with it."""
    elsewhere = "take another folder (-o)"
    if __version__ not in at.versions(known):
        if not accept_version:
            raise refused(
                folder, f"was begun with cutwise {known['version']}, this is {__version__}, whose numbers may differ: "
                f"--accept-version goes on all the same, or {elsewhere}",
            )  # fmt: skip
        known = {**known, "also": [*known["also"], __version__]}
    mine = at.identity_of(study, __version__, int(known["chunk"]), known["step_errors"], known["scales"])
    if known["study"] != mine["study"]:
        raise refused(folder, f"holds another study: {_differs(study, folder)}; {elsewhere}")
    if study.method in SEARCHES:
        there = len(at.trials(folder)) + len(list((folder / "parts").glob("*.nc")))
        if there and not resume:
            raise refused(folder, f"{there:,} trials are there: add --resume, or {elsewhere}")
        return known
    there = done(study, folder, int(known["chunk"]))
    if there and not resume:
        raise refused(folder, f"{there:,} of {study.cases:,} cases are there: add --resume, or {elsewhere}")
    return known


def _differs(study: Study, folder: Path) -> str:
    """What is not the same in the study of a folder, in words."""
    try:
        there = at.said_of(in_folder(folder)[0])
    except ScenarioFault:
        return "scenario, levers, method, seed or measures differ"
    mine = at.said_of(study)
    names = [name for name in dict.fromkeys((*there, *mine)) if _plain(there.get(name)) != _plain(mine.get(name))]
    told = []
    for name in names:
        a, b = _plain(there.get(name)), _plain(mine.get(name))
        if isinstance(a, dict) and isinstance(b, dict):
            keys = [key for key in dict.fromkeys((*a, *b)) if a.get(key) != b.get(key)]
            told.append(f"{name} ({', '.join(keys[:_NAMED])}{', ...' if len(keys) > _NAMED else ''})")
        else:
            told.append(f"{name} ({a}, now {b})" if isinstance(a, str | int) and isinstance(b, str | int) else name)
    if not told:
        return "cutwise reads it in another way now"
    *most, last = told
    return f"{', '.join(most)} and {last} differ" if most else f"{last} differs"


def _plain(value: Any, within: str = "") -> Any:
    """Plain values, sections of sections as dotted keys."""
    if not isinstance(value, dict):
        return json.loads(json.dumps(value, default=str))
    found: dict[str, Any] = {}
    for key, one in value.items():
        name = f"{within}{key}"
        found |= _plain(one, f"{name}.") if isinstance(one, dict) else {name: _plain(one)}
    return found


def done(study: Study, folder: Path, size: int) -> int:
    """Cases whose parts are there."""
    return sum(count for _, count in at.finished(folder, study, size))


def in_folder(folder: Path) -> tuple[Study, dict[str, Any]]:
    """The study that a folder holds, and its identity.

    Raises
    ------
    ScenarioFault
        There is none.
    """
    there = at.identity_in(folder)
    if there is None or not (folder / "study.json").exists():
        raise refused(folder, "holds no study; cutwise study begins one")
    try:
        return unpack(json.loads((folder / "study.json").read_text(encoding="utf-8"))), there
    except (ValueError, KeyError, TypeError, AttributeError):
        raise refused(folder / "study.json", "is damaged; take another folder (-o)") from None


def to_work_on(folder: Path) -> tuple[Study, dict[str, Any]]:
    """The same, for those who are to add cases to it.

    Raises
    ------
    ScenarioFault
        There is none, or it is of another version of cutwise.
    """
    study, there = in_folder(folder)
    if __version__ not in at.versions(there):
        raise refused(
            folder, f"was begun with cutwise {there['version']}, this is {__version__}, whose numbers may differ: "
            "cutwise study FILE -o DIR --resume --accept-version lets it take part",
        )  # fmt: skip
    return study, there
