"""A machine chain as a term of the structure: what it needs to be told where it carries a tool that is not its own."""

from collections.abc import Iterator

from pydantic import Field

from cutwise.spec.base import Notice
from cutwise.spec.machine import Machine, Place
from cutwise.spec.machine_checks import chain_faults
from cutwise.spec.part_block import PartBlock


class CarryingMachine(Machine):
    """A machine tool as a chain of bodies that yield, with a tool that is not its own."""

    tip: Place | None = Field(
        default=None, description="tool point in the frame of the last body", examples=["[0 mm, 0 mm, -45 mm]"]
    )

    def contradictions(self) -> Iterator[Notice]:
        """A chain that holds together and answers to a force at once."""
        yield from chain_faults(self)
        for place, body in enumerate(self.chain):
            for number, element in enumerate(body.elements):
                if element.contact is not None:
                    yield Notice(
                        ("chain", place, "elements", number, "contact"),
                        "the contact law of pads is for process: machine (still mode only); write pads with their stiffness",
                    )


def tip_faults(machine: CarryingMachine) -> Iterator[Notice]:
    """A tool point that is not known."""
    if machine.tip is None:
        yield Notice(("machine", "tip"), "missing; where the tool point is in the frame of the last body, for example "
                     "[0 mm, 0 mm, -45 mm] (demec_mill has it)")  # fmt: skip


def what_yields_alone(machine: CarryingMachine, *, weights: bool = True) -> Iterator[Notice]:
    """What of a machine is no spring, and does not count; ``weights``: those of its bodies are among it."""
    if machine.geometry_errors is not None:
        yield Notice(
            ("machine", "geometry_errors"),
            "do not count here, only what the bodies yield by; process: machine has them",
        )
    if weights and any(body.weight for body in machine.chain):
        yield Notice(
            ("machine", "chain"), "weights of the bodies do not count: the zero of the part is taken under them"
        )


def block_faults(machine: Machine | None, block: PartBlock | None, stiffness: float | None) -> Iterator[Notice]:
    """A part that yields in two ways at once, a block without a machine to stand on."""
    if block is None:
        return
    if stiffness is not None:
        yield Notice(("part", "stiffness"), "and part.block both say how the part yields; write one of them")
    if machine is None:
        yield Notice(
            ("part", "block"), "stands on the table of a machine (machine.library); otherwise write part.stiffness"
        )
