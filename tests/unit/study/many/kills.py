"""Whoever works on a study is killed (-9) at random moments; the rows must be those of a run that nobody disturbed.

python tests/unit/study/many/kills.py [TRIALS] prints what came of it; the tests do a few of them.
"""

import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from cutwise.study.many import engine
from cutwise.study.many import folder as at
from cutwise.study.many.columns import collected
from cutwise.study.many.reading import read_study

EXAMPLE = Path(__file__).parents[4] / "examples/studies/burrs.yaml"
CASES, CHUNK = 256, 8
_WORKS = (
    "from pathlib import Path; from cutwise.study.many.engine import work; print('on', flush=True); work(Path({!r}))"
)
_TWO = (  # a process that starts workers, and looks on
    "from pathlib import Path; from cutwise.study.many import engine; from cutwise.study.many.reading import read_study\n"
    "if __name__ == '__main__':\n"
    "    print('on', flush=True)\n"
    "    engine.run_study(read_study(Path({!r}), cases={}), Path({!r}), jobs=2, resume=True)\n"
)


class Outcome:
    """Counts of the trials."""

    def __init__(self) -> None:
        self.kills = self.torn = self.lost = 0

    def __repr__(self) -> str:
        return f"{self.kills} kills, {self.torn} parts torn, {self.lost} parts lost"


def trials(count: int, seed: int = 1) -> tuple[Outcome, bool]:
    """Kill that many times; what was lost, and whether all rows are those of an undisturbed run."""
    rng, outcome = random.Random(seed), Outcome()
    study = read_study(EXAMPLE, cases=CASES)
    with tempfile.TemporaryDirectory() as kept:
        whole, folder, script = Path(kept, "whole"), Path(kept, "killed"), Path(kept, "two.py")
        engine.run_study(study, whole, chunk=CHUNK)
        engine.begun(study, folder, resume=True, chunk=CHUNK)
        script.write_text(_TWO.format(str(EXAMPLE), CASES, str(folder)), encoding="utf-8")
        for number in range(count):
            before = set(folder.glob("parts/part-*.nc"))
            if len(before) > CASES // CHUNK - 4:  # nearly done: once more from a few
                for file in sorted(before)[4:]:
                    file.unlink()
                before = set(folder.glob("parts/part-*.nc"))
            words = [str(script)] if number % 3 == 2 else ["-c", _WORKS.format(str(folder))]
            process = subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE)
            process.stdout.readline()
            if number % 3 == 2:  # it has to start its workers first
                time.sleep(4.0)
            _until_a_part(folder, before)
            time.sleep(rng.uniform(0.0, 0.25))
            process.kill()
            process.wait()
            outcome.kills += 1
            outcome.lost += sum(not file.exists() for file in before)
            outcome.torn += sum(not _readable(file) for file in folder.glob("parts/part-*.nc"))
            _leases_grow_old(folder)
        engine.work(folder)
        a, _ = collected(study, whole, CHUNK)
        b, done = collected(study, folder, CHUNK)
        same = all(np.array_equal(a[name], b[name], equal_nan=a[name].dtype.kind == "f") for name in a)
        return outcome, same and done == CASES and len(list(folder.glob("parts/part-*.nc"))) == CASES // CHUNK


def _until_a_part(folder: Path, before: set[Path]) -> None:
    until = time.monotonic() + 60.0
    while set(folder.glob("parts/part-*.nc")) == before and time.monotonic() < until:
        time.sleep(0.005)


def _readable(file: Path) -> bool:
    try:
        return len(at.read_part(file)["case"]) == CHUNK
    except OSError:
        return False


def _leases_grow_old(folder: Path) -> None:
    """As if a minute had passed; the workers of a process that was killed die with it, or go on, which is harmless."""
    for lease in (folder / "lease").iterdir():
        lease.unlink(missing_ok=True)


if __name__ == "__main__":
    print(*trials(int(sys.argv[1]) if len(sys.argv) > 1 else 50))
