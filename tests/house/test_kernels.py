"""Every kernel says what it computes by an example that is checked: its formula in numbers."""

import doctest
import importlib
import inspect
import pkgutil
import re

import pytest
from numba.core.dispatcher import Dispatcher

import cutwise.maths
import cutwise.paths
import cutwise.physics

MODULES = sorted(
    module.name
    for package in (cutwise.physics, cutwise.paths, cutwise.maths)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not module.ispkg
)


def kernels(module):
    """The compiled functions that a module offers to others."""
    return {
        name: value
        for name, value in vars(module).items()
        if isinstance(value, Dispatcher) and value.py_func.__module__ == module.__name__ and not name.startswith("_")
    }


def examples_of(module):
    """Everything that a module defines and shows by an example."""
    for name, value in vars(module).items():
        own = value.py_func if isinstance(value, Dispatcher) else value
        if not (inspect.isfunction(own) or inspect.isclass(own)) or own.__module__ != module.__name__:
            continue
        text = inspect.getdoc(own) or ""
        if ">>>" in text:
            yield name, text


@pytest.mark.parametrize("name", MODULES)
def test_kernels_show_a_number_and_it_is_right(name):
    module = importlib.import_module(name)
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    shown = set()
    for shower, text in examples_of(module):
        said = []
        runner.run(parser.get_doctest(text, dict(vars(module)), shower, name, 0), out=said.append)
        assert not said, "".join(said)
        shown.add(shower)
    bare = sorted(kernels(module).keys() - shown)
    assert not bare, f"without an example: {', '.join(bare)}"


# Kernels of maps in 3D that do not yet say both: a module leaves this list when it does.


@pytest.mark.parametrize("name", [name for name in MODULES if name.startswith("cutwise.physics.")])
def test_kernels_of_physics_say_where_they_hold_and_whence_they_are(name):
    """A range of validity (exact is one, too) and a source, or that it is derived here."""
    silent = [
        kernel
        for kernel, value in kernels(importlib.import_module(name)).items()
        for said in [inspect.getdoc(value.py_func) or ""]
        if not (
            re.search("[Vv]alid|[Ee]xact|holds", said) and re.search(r"References\n|[Dd]erived here|[12]\d{3}", said)
        )
    ]
    assert not silent
