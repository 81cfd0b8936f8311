"""By hand: ``PYTHONPATH=src:tests python -m fuzz [KIND ...] [--count N] [--seed S]``; prints every harm, exits 1 if any."""

import argparse
import random
import sys
import tempfile
import time
from itertools import islice
from pathlib import Path

from fuzz.kinds import ALL
from fuzz.trial import harms


def main() -> int:
    """Try inputs of some kinds."""
    parser = argparse.ArgumentParser(prog="fuzz", description=__doc__)
    parser.add_argument("kinds", nargs="*", choices=[*ALL, []], help="kinds of input; all if left out")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    asked = parser.parse_args()
    total = 0
    for kind in asked.kinds or ALL:
        with tempfile.TemporaryDirectory() as folder:
            trials = islice(ALL[kind](random.Random(asked.seed)), asked.count)
            begun = time.monotonic()
            for harm in harms(trials, Path(folder), most=10**6):
                total += 1
                print(harm, "\n", flush=True)
        print(f"{kind}: {asked.count} inputs, seed {asked.seed}, {time.monotonic() - begun:.0f} s", flush=True)
    print(f"{total} harms")
    return 1 if total else 0


if __name__ == "__main__":
    sys.exit(main())
