"""Words that say too little to be names: what an issue took out does not come back."""

import ast
from collections import defaultdict
from pathlib import Path

import cutwise

VAGUE = {"looking", "leaving", "remarks", "skins", "wording", "way_of", "Way", "Course", "Mover"}
SOURCE = Path(cutwise.__file__).parent


def defined(tree):
    """Names that others read: of functions, classes, their arguments and fields."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target.id


def test_vague_names_are_nowhere_defined():
    found = [
        f"{file.relative_to(SOURCE)}: {name}"
        for file in SOURCE.rglob("*.py")
        for name in {file.stem, *defined(ast.parse(file.read_text()))} & VAGUE
    ]
    assert not found


def codes(tree):
    """Names of whole numbers that a module defines, alone or side by side."""
    for node in tree.body:
        for target in node.targets if isinstance(node, ast.Assign) else ():
            both = (target, node.value)
            pairs = (
                zip(*(one.elts for one in both), strict=False)
                if all(isinstance(one, ast.Tuple) for one in both)
                else [both]
            )
            for name, value in pairs:
                if isinstance(name, ast.Name) and isinstance(value, ast.Constant) and isinstance(value.value, int):
                    yield name.id, value.value


def test_a_choice_of_the_kernels_has_one_value():
    """``AVERAGED`` was 0 in one file and 1 in another."""
    found = defaultdict(set)
    for file in (SOURCE / "physics" / "cutting").glob("*.py"):
        for name, value in codes(ast.parse(file.read_text())):
            if not name.startswith("_"):
                found[name].add(value)
    assert {"AVERAGED", "FLUTES", "DELAYED"} <= set(found)
    assert {name: values for name, values in found.items() if len(values) > 1} == {}
