"""What tests of all folders share: examples and their runs, the command line in this process, time where lines are counted."""

import os
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import settings

if os.environ.get("COVERAGE"):  # which takes twice the time
    settings.register_profile("counted", deadline=None)
    settings.load_profile("counted")

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.fixture(scope="session")
def examples() -> Path:
    """Folder of the example scenarios."""
    return EXAMPLES


def _shared(factory) -> Path:
    """Folder of this run of the tests, one for all processes of xdist."""
    base = factory.getbasetemp()
    return (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "runs"


@pytest.fixture(scope="session")
def run_of(examples, tmp_path_factory):
    """The run of an example, ``run_of(name, *overrides)``: simulated once, although many tests look at it."""
    from runs import Runs

    folder = _shared(tmp_path_factory)
    folder.mkdir(exist_ok=True)
    return Runs(examples, folder)


def pytest_collection_modifyitems(items):
    """Tests of a stock in 3D come first and one after the other, which is in one process of xdist.

    Their loops take more than a minute to compile: two processes that come to them at the same time compile all of
    them twice.
    """
    items.sort(key=lambda item: not item.path.stem.startswith("test_stock"))  # the order is kept otherwise


def pytest_sessionfinish(session):
    """pytest keeps the folders of three runs; results are too large for that."""
    factory = getattr(session.config, "_tmp_path_factory", None)
    if factory is not None and not hasattr(session.config, "workerinput"):
        shutil.rmtree(factory.getbasetemp() / "runs", ignore_errors=True)


@pytest.fixture
def cutwise(capsys, tmp_path, monkeypatch):
    """The command line: called with its arguments, gives back the exit code and what it wrote."""
    from cutwise.app import cli

    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        with pytest.raises(SystemExit) as left:
            cli.main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return SimpleNamespace(code=left.value.code, out=captured.out, err=captured.err)

    return call
