"""A machine that carries a tool as a whole: its feed drives, and the bodies that yield between part and tool."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Field

from cutwise.spec.base import LibrarySpec, Notice, Spec
from cutwise.spec.chained import CarryingMachine
from cutwise.spec.drives import CncMachine
from cutwise.spec.fields import tag

AXES = ("X", "Y", "Z")


class MillingMachine(CarryingMachine):
    """A machine tool as a chain of bodies that yield, moved by its feed drives."""

    stands_for: ClassVar[Mapping[str, str]] = dict.fromkeys(("reading", "limits", "control"), "drives")

    drives: CncMachine | None = Field(
        default=None,
        description="feed drives: their controllers, limits and friction",
        examples=["{library: fadal2216}"],
    )

    def contradictions(self) -> Iterator[Notice]:
        """A chain that holds together, moved along x, y and z, that answers at once."""
        yield from super().contradictions()
        there = self.axes()
        missing = [letter for letter in AXES if letter not in there]
        if missing:
            yield Notice(("chain",), f"has no axis {' and '.join(missing)}; a mill is moved along x, y and z")


class MillingLoad(Spec):
    """Loads on the machine besides the cut."""

    weights: bool = Field(
        default=False, description="weights of bodies and part; left out in milling", examples=[False]
    )

    def contradictions(self) -> Iterator[Notice]:
        """What milling leaves out."""
        if self.weights:
            yield Notice(("weights",), "true is for process: machine; in milling the wall is set against the machine as it "
                         "stands under its weights: write false")  # fmt: skip


def machine_kind(value: Any) -> str:
    """Which of the two a machine section is: drives alone, or bodies with their drives."""
    if isinstance(value, LibrarySpec):
        return "<bodies>" if isinstance(value, MillingMachine) else "<drives>"
    written = value if isinstance(value, dict) else {}
    return "<bodies>" if {"chain", "drives", "tip", "gravity"} & set(written) else "<drives>"


ToolMachine = Annotated[
    Annotated[CncMachine, tag("drives")] | Annotated[MillingMachine, tag("bodies")], Discriminator(machine_kind)
]
"""A machine that moves a tool: its drives alone, or bodies that yield, with or without drives."""


def bodies_of(machine: CncMachine | MillingMachine | None) -> MillingMachine | None:
    """The machine, if it has bodies that yield."""
    return machine if isinstance(machine, MillingMachine) else None


def drives_of(machine: CncMachine | MillingMachine | None) -> CncMachine | None:
    """The feed drives of a machine, if it has any."""
    return machine.drives if isinstance(machine, MillingMachine) else machine


def drives_key(machine: CncMachine | MillingMachine | None) -> str:
    """Dotted key of the feed drives."""
    return "machine.drives" if isinstance(machine, MillingMachine) else "machine"
