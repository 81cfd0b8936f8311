"""The bibliography: every misprint names a test that exists."""

import ast
from pathlib import Path

import pytest

from cutwise.references import SOURCES

ROOT = Path(__file__).parent.parent.parent
ERRATA = [(source.key, erratum) for source in SOURCES.values() for erratum in source.errata]


@pytest.mark.parametrize(("key", "erratum"), ERRATA, ids=[f"{key}: {erratum.place}" for key, erratum in ERRATA])
def test_erratum_is_asserted(key, erratum):
    file, _, name = erratum.test.partition("::")
    assert key in Path(file).stem
    tree = ast.parse((ROOT / file).read_text())
    assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
