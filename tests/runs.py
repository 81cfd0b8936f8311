"""Runs of examples that several tests look at: simulated once, in whichever process of xdist that is."""

import hashlib
import os
import pickle
from pathlib import Path

from cutwise.io.scenario import load
from cutwise.process.recipes import simulate
from cutwise.results import Result


class Runs:
    """Keeps results in a folder that all processes of one test run share; each test gets a copy of its own."""

    def __init__(self, examples: Path, folder: Path) -> None:
        self._examples, self._folder = examples, folder

    def __call__(self, name: str, *overrides: str) -> Result:
        """The run of an example, with overrides if any."""
        told = hashlib.sha256(repr(overrides).encode()).hexdigest()[:16]
        file = self._folder / f"{name}-{told}.pickle"
        if not file.exists():
            result = simulate(load(self._examples / f"{name}.yaml", list(overrides)))
            scratch = file.with_suffix(f".{os.getpid()}")
            scratch.write_bytes(pickle.dumps(result))
            os.replace(scratch, file)  # two that run the same at the same time write the same
        return pickle.loads(file.read_bytes())
