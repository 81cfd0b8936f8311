"""The stages of a cell, and how a row takes part in one: a law registered for the class of its record.

A compiled loop calls a stage as it calls any function; while numba compiles it, the class of the first argument
chooses the law. There is no closure, no code of laws handed through, and no cost at run time: a loop compiled for a
cell is the loop that one would write for that cell alone.

    @stepped.of(Pistons)
    def _(structure, state, load, dt): ...

To see what can be put into a slot, search for ``stepped.of``. numba refuses a law whose parameters are not named as
those of its stage, so the protocol checks itself.

What passes between the stages of one step are the records of :mod:`cutwise.records`; a state is a tuple of arrays
that change in place. Only :func:`left` may change the stock: :func:`met` is asked several times a step.
"""

import inspect
from collections.abc import Callable
from typing import Any

from numba.core.types import BaseNamedTuple
from numba.extending import overload

Law = Callable[..., Any]


class MissingLawError(TypeError):
    """No law was registered for a record in this stage."""


def stage(signature: Law) -> Any:
    """Make a stage out of a function that has a signature and a docstring, and no body.

    The stage is called with a record first; ``stage.of(Record)`` registers the law of a class, ``stage.laws`` lists
    them. Called from Python it runs the law as plain Python, which is what tests compare the compiled one with.
    """
    laws: dict[type, Law] = {}
    name = getattr(signature, "__name__", "stage")

    def chosen(*arguments: Any) -> Any:
        return _law_of(laws, type(arguments[0]), name)(*arguments)

    def of(*records: type) -> Callable[[Law], Law]:
        def register(law: Law) -> Law:
            for record in records:
                if record in laws:
                    raise TypeError(f"{name} has a law for {record.__name__} already")
                laws[record] = law
            return law

        return register

    def choose(*arguments: Any) -> Law | None:
        kind = arguments[0]
        if not isinstance(kind, BaseNamedTuple):
            return None
        return _law_of(laws, kind.instance_class, name)  # type: ignore[attr-defined]

    choose.__signature__ = inspect.signature(signature)  # type: ignore[attr-defined]
    chosen.__name__ = chosen.__qualname__ = name
    chosen.__doc__ = signature.__doc__
    chosen.__module__ = signature.__module__
    chosen.of = of  # type: ignore[attr-defined]
    chosen.laws = laws  # type: ignore[attr-defined]
    overload(chosen, jit_options={"error_model": "numpy", "forceinline": True, "_nrt": False}, inline="never")(choose)  # type: ignore[typeddict-unknown-key]
    return chosen


def _law_of(laws: dict[type, Law], record: type, name: str) -> Law:
    try:
        return laws[record]
    except KeyError:
        known = ", ".join(sorted(r.__name__ for r in laws)) or "none"
        raise MissingLawError(f"{name}: no law for {record.__name__}; there are laws for {known}") from None


@stage
def moved(motion, time):
    """Pose of the tool before its structure yields, at a time [s]: where the carrier has it."""


@stage
def driven(motion, pose, load, dt):
    """One time step [s] of what moves the tool, under the load of the cut; a programmed motion goes on by itself."""


@stage
def probed(engagement, pose):
    """Height over the tool tip at which the surface is read, as two numbers to be added [m]."""


@stage
def spatial(engagement):
    """Whether the contact changes with every displacement of the tool, or with the one off the work alone."""


@stage
def met(engagement, stock, pose, structure, flexed, contact):
    """Fill the rows of contact at a pose, the tool displaced as its structure stands; returns their number.

    Asked several times in a step, so it reads the stock and never changes it.
    """


@stage
def cut(cutting, contact, count, time, pivot, load):
    """Add the force of some rows of contact on the tool to a load, its moments about a height over the tip [m]."""


@stage
def pivot(structure):
    """Height over the tool tip [m] about which a structure wants its moments: the joint of a tilting spindle."""


@stage
def displaced(structure, flexed, foot, above):
    """Displacement and rate of the tool's axis at the height ``foot + above`` over its tip [m], as things stand."""


@stage
def stepped(structure, flexed, pose, load, dt):
    """One time step [s] of the terms with mass or memory under a load; returns the effort of their solver."""


@stage
def yielding(structure):
    """Whether a structure has terms without inertia, whose displacement has to be solved for with the force."""


@stage
def held(structure, flexed, height):
    """Displacement along x, y and z [m] at a height over the tip of the terms without inertia, as they stand."""


@stage
def yielded(structure, flexed, pose, load, pivot, height):
    """What the terms without inertia want under a load; returns its displacement along x, y and z at a height [m]."""


@stage
def settled(structure, flexed, extra_x, extra_y, extra_z):
    """Let the terms without inertia take what they want, and a displacement along x, y and z [m] besides."""


@stage
def left(engagement, stock, contact, count):
    """Take away what some rows of contact took, and note where that was; alone in changing the stock, once a step."""


@stage
def noted(structure, flexed, table, row, at):
    """Write the state of a structure into columns of a row, from ``at`` on; returns the next free column."""
