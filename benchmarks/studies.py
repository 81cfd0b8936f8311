"""Studies: CPU seconds of a case and of what is around it, two workers beside one, peak memory of many rows.

Run: python benchmarks/studies.py [CASES] [memory]

All times are CPU seconds. What two workers come to is told for a machine of which they are alone: the process that
starts the study is one of them, and its CPU seconds, with a whole part to wait for at last, are the time that passes.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cutwise import loop
from cutwise.study.many import cases as of_cases
from cutwise.study.many import engine
from cutwise.study.many import folder as at
from cutwise.study.many.answers import answers, measures
from cutwise.study.many.cases import Chunk
from cutwise.study.many.definition import Study, columns
from cutwise.study.many.packing import pack
from cutwise.study.many.reading import read_study

STUDY = Path(__file__).parent.parent / "examples/studies/burrs.yaml"
ROWS = (20_000, 100_000, 400_000)


class Clock:
    """CPU seconds inside of a function that is called again and again."""

    def __init__(self, module: Any, name: str) -> None:
        self.seconds, self._inner = 0.0, getattr(module, name)
        setattr(module, name, self)

    def __call__(self, *given: Any, **named: Any) -> Any:
        start = time.process_time()
        try:
            return self._inner(*given, **named)
        finally:
            self.seconds += time.process_time() - start


def one_process(study: Study, folder: Path) -> None:
    """A case, its share in compiled loops, and what is around the cases."""
    loops, inside = Clock(loop, "advance"), Clock(of_cases, "evaluate_levers")
    marks: list[tuple[int, float]] = []
    start = time.process_time()
    engine.run_study(study, folder, progress=lambda done, _: marks.append((done, time.process_time())))
    ran = time.process_time() - start
    found = answers(study, folder, int((at.identity_in(folder) or {})["chunk"]))
    measures(found)
    told = time.process_time() - start - ran
    half = next(mark for mark in marks if mark[0] >= study.cases // 2)
    each = (marks[-1][1] - half[1]) / (marks[-1][0] - half[0])
    print(f"{study.cases:,} cases: {ran:.1f} s, slope of the second half {1e3 * each:.2f} ms a case")
    print(f"  10^6 cases on two cores at that slope, efficiency 1: {each * 1e6 / 120.0:.0f} min")
    print(f"  of a case in the compiled loop {1e3 * loops.seconds / study.cases:.2f} ms")
    around = ran - inside.seconds + told
    print(
        f"  beyond the cases {around:.2f} s, {100 * around / inside.seconds:.1f} % (numbers, parts, leases, answers {told:.2f} s)"
    )


def two_processes(study: Study, folder: Path) -> None:
    """Two workers beside one, from the CPU seconds of both."""
    mine: list[int] = []
    begun: list[float] = []
    worked = engine._worked

    def counted(*given: Any) -> int:
        begun.append(time.process_time())
        mine.append(worked(*given))
        return mine[-1]

    engine._worked = counted
    start = time.process_time()
    before = _children()
    engine.run_study(study, folder, jobs=2)
    parent, child = time.process_time() - start, _children() - before
    serial = begun[0] - start
    each = (parent - serial) / mine[0]
    size = int((at.identity_in(folder) or {})["chunk"])
    alone, together = serial + study.cases * each, parent + size * each
    print(
        f"two processes: {mine[0]:,} cases in the first ({parent:.1f} s), {study.cases - mine[0]:,} in the other ({child:.1f} s)"
    )
    print(f"  to begin {serial:.2f} s; parts of {size} cases; efficiency {alone / (2.0 * together):.3f}")


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def memory(study: Study, rows: int) -> None:
    """Peak memory and CPU seconds of answers and page of made-up rows, in a process of its own."""
    with tempfile.TemporaryDirectory() as kept:
        folder = Path(kept)
        study = study._replace(draws=rows, method="monte_carlo")
        at.started(folder, json.dumps(pack(study)), at.identity_of(study, "0", 2048, {}, {}))
        for first, count in at.chunks(study, 2048):
            at.write_part(folder, _made_up(study, columns(study, first, count), first, count))
        code = (
            "import resource, sys, time\nfrom pathlib import Path\nfrom cutwise.app.study_page import page\n"
            "from cutwise.study.many.answers import answers, measures\nfrom cutwise.study.many.beginning import in_folder\n"
            "study, _ = in_folder(Path(sys.argv[1]))\nstart = time.process_time()\n"
            "found = answers(study, Path(sys.argv[1]), 2048)\nmeasures(found)\ntext = page(found, [])\n"
            "most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024\n"
            "print(f'  {found.done:,} rows: {most:.0f} MB, {time.process_time() - start:.1f} s, page {len(text) / 1e6:.2f} MB')"
        )
        subprocess.run([sys.executable, "-c", code, str(folder)], check=True)


def _made_up(study: Study, levers: dict[str, list[Any]], first: int, count: int) -> Chunk:
    height = np.array(levers["part.burr.height"])
    value = 0.5 * (height - 0.8e-3)
    found: Mapping[str, np.ndarray] = dict.fromkeys(study.measures, value)
    state = (np.abs(value) > 5e-5).astype(np.int64)
    return Chunk(first, levers, dict(found), state, np.abs(value) - 5e-5, state > 1, [""] * count)


if __name__ == "__main__":
    wanted = read_study(STUDY, cases=int(sys.argv[1]) if len(sys.argv) > 1 else 4096)
    if sys.argv[2:] != ["memory"]:
        with tempfile.TemporaryDirectory() as place:
            two_processes(wanted, Path(place, "two"))
            one_process(wanted, Path(place, "one"))
    print("peak memory of answers and page")
    for many in ROWS:
        memory(wanted, many)
