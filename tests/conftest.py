"""Nothing shared but the place of the examples, and patience where lines are counted."""

import os
from pathlib import Path

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
