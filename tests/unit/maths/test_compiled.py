"""The kernel cache: a kernel is void when what it uses has changed, and only then."""

import os
import subprocess
import sys

import pytest

from cutwise.maths import compiled

CALLEE = '''
"""A callee."""
from cutwise.maths.compiled import compiled

FACTOR = {factor}

{comment}
@compiled
def inner(x):
    """{doc}"""
    return FACTOR * x {more}
'''
CALLER = """
from cutwise_callee import inner
from cutwise.maths.compiled import compiled

@compiled
def outer(x):
    return inner(x) + 1.0

print(outer(2.0), sum(outer.stats.cache_hits.values()))
"""


@pytest.fixture
def run(tmp_path):
    """Write a callee and its caller, run the caller in a process of its own; returns value and cache hits."""

    def _run(factor="3.0", comment="", doc="Text.", more=""):
        callee = CALLEE.format(factor=factor, comment=comment, doc=doc, more=more)
        (tmp_path / "cutwise_callee.py").write_text(callee)
        (tmp_path / "caller.py").write_text(CALLER)
        said = subprocess.run(
            [sys.executable, "caller.py"],
            cwd=tmp_path,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
            capture_output=True,
            text=True,
            check=True,
        )
        value, hits = said.stdout.split()
        return float(value), int(hits)

    _run.cache = tmp_path / "cache" / "kernels"
    return _run


def test_a_second_process_finds_the_kernel(run):
    assert run() == (7.0, 0)
    assert run() == (7.0, 1)


def test_comments_docstrings_and_lines_void_nothing(run):
    run()
    assert run(comment="# why\n\n# and why", doc="Other text.") == (7.0, 1)


@pytest.mark.parametrize(("change", "value"), [({"factor": "4.0"}, 9.0), ({"more": "+ 1.0"}, 8.0)])
def test_a_change_in_what_is_used_voids_the_caller(run, change, value):
    run()
    assert run(**change) == (value, 0)
    assert run() == (7.0, 1), "the kernel of the first text is still there"


def test_a_damaged_file_is_not_believed(run):
    run()
    for file in run.cache.iterdir():
        file.write_bytes(file.read_bytes()[:-100])
    assert run() == (7.0, 0)
    assert run() == (7.0, 1)


def test_writers_at_the_same_time_leave_whole_kernels(run, tmp_path):
    run()
    for file in run.cache.iterdir():
        file.unlink()
    env = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    together = [subprocess.Popen([sys.executable, "caller.py"], cwd=tmp_path, env=env, stdout=-1) for _ in range(3)]
    assert {process.communicate()[0].split()[0] for process in together} == {b"7.0"}
    assert run() == (7.0, 1)
    assert not list(run.cache.glob("*.tmp"))


def test_kernels_can_be_cleared(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path / "kernels")
    (tmp_path / "kernels" / "older").mkdir(parents=True)
    (tmp_path / "kernels" / "older" / "a.nbc").write_bytes(b"123")
    assert compiled.clear_kernels() == 3
    assert compiled.cached_kernels() == []


@compiled.compiled
def _counted(count, twice):
    return 2 * count if twice else count


@compiled.compiled
def _counts(n):
    return _counted(3, True) + _counted(n, n > 2)


def test_a_number_that_is_written_down_makes_no_kernel_of_its_own(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path)  # a kernel that is read compiles nothing below it
    assert _counts(4) == 14
    assert len(_counted.signatures) == 1
