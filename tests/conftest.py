"""Nothing shared but the place of the examples."""

from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.fixture(scope="session")
def examples() -> Path:
    """Folder of the example scenarios."""
    return EXAMPLES
