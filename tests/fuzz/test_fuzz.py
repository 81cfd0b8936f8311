"""A bounded number of hostile inputs of every kind, always the same: none crashes, hangs, swells, or ends with 3."""

import random
import sys
from itertools import islice

import pytest

from fuzz.kinds import CHEAP, run_tampered
from fuzz.trial import harms

COUNT = {"texts": 60, "keys": 60, "nc": 60, "apt": 60, "run_bytes": 25}

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no limits on processes")


@pytest.mark.parametrize("kind", CHEAP)
def test_no_input_harms(kind, tmp_path):
    trials = islice(CHEAP[kind](random.Random(20260101)), COUNT.get(kind, 40))
    assert [str(harm) for harm in harms(trials, tmp_path)] == []


@pytest.mark.slow
def test_no_tampered_run_file_harms(tmp_path):
    assert [str(harm) for harm in harms(islice(run_tampered(random.Random(1)), 8), tmp_path)] == []
