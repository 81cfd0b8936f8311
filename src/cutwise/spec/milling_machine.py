"""A machine that mills as a whole: its feed drives, and the bodies that yield between part and tool."""

from collections.abc import Iterator, Mapping
from typing import Any, ClassVar

from pydantic import Field

from cutwise.spec.base import LibrarySpec, Remark, Spec
from cutwise.spec.drives import CncMachine
from cutwise.spec.machine import Machine, Place
from cutwise.spec.machine_checks import chain_faults

AXES = ("X", "Y", "Z")


class MillingMachine(Machine):
    """A machine tool as a chain of bodies that yield, moved by its feed drives."""

    stands_for: ClassVar[Mapping[str, str]] = dict.fromkeys(("reading", "limits", "control"), "drives")

    drives: CncMachine | None = Field(
        default=None,
        description="feed drives: their controllers, limits and friction",
        examples=["{library: fadal2216}"],
    )
    tip: Place | None = Field(
        default=None, description="tool point in the frame of the last body", examples=["[0 mm, 0 mm, -45 mm]"]
    )

    def contradictions(self) -> Iterator[Remark]:
        """A chain that holds together, with a tool point, moved along x, y and z, that answers at once."""
        yield from chain_faults(self)
        if self.tip is None:
            yield Remark(("tip",), "missing; where the tool point is in the frame of the last body, for example "
                         "[0 mm, 0 mm, -45 mm] (demec_mill has it)")  # fmt: skip
        there = self.axes()
        missing = [letter for letter in AXES if letter not in there]
        if missing:
            yield Remark(("chain",), f"has no axis {' and '.join(missing)}; a mill is moved along x, y and z")
        for place, body in enumerate(self.chain):
            for number, element in enumerate(body.elements):
                if element.contact is not None:
                    yield Remark(
                        ("chain", place, "elements", number, "contact"),
                        "the contact law of pads is for process: machine (still mode only); write pads with their stiffness",
                    )

    def remarks(self) -> Iterator[Remark]:
        """What is left out."""
        if self.geometry_errors is not None:
            yield Remark(("geometry_errors",), "do not count in milling; process: machine has them")


class MillingLoad(Spec):
    """Loads on the machine besides the cut."""

    weights: bool = Field(
        default=False, description="weights of bodies and part; left out in milling", examples=[False]
    )

    def contradictions(self) -> Iterator[Remark]:
        """What milling leaves out."""
        if self.weights:
            yield Remark(("weights",), "true is for process: machine; in milling the wall is set against the machine as it "
                         "stands under its weights: write false")  # fmt: skip


def machine_kind(value: Any) -> str:
    """Which of the two a machine section is: drives alone, or bodies with their drives."""
    if isinstance(value, LibrarySpec):
        return "<bodies>" if isinstance(value, MillingMachine) else "<drives>"
    written = value if isinstance(value, dict) else {}
    return "<bodies>" if {"chain", "drives", "tip", "gravity"} & set(written) else "<drives>"
