"""A machine chain as a term of the structure: what it needs to be told where it carries a tool that is not its own."""

from collections.abc import Iterator

from cutwise.spec.base import Remark
from cutwise.spec.machine import Machine, PartBlock
from cutwise.spec.machine_checks import chain_faults

ONE_CARRIER = "the tool has one carrier: write robot or machine"


def machine_faults(machine: Machine) -> Iterator[Remark]:
    """A chain that cannot stand, a tool point that is not known, pads that have no constant stiffness."""
    for remark in chain_faults(machine):
        yield Remark(("machine", *remark.path), remark.message)
    if machine.tool_point is None:
        yield Remark(
            ("machine", "tool_point"),
            "missing: where the tip of the tool is in the frame of the last body, for example [0 mm, 0 mm, -45 mm]; "
            "demec_mill has it",
        )
    for place, body in enumerate(machine.chain):
        for number, element in enumerate(body.elements):
            if element.contact is not None:
                yield Remark(
                    ("machine", "chain", place, "elements", number, "contact"),
                    "pads with the contact law are for process: machine; here they need a stiffness (pads)",
                )


def machine_remarks(machine: Machine) -> Iterator[Remark]:
    """What of a machine is not a spring, and does not count."""
    if machine.geometry_errors is not None:
        yield Remark(
            ("machine", "geometry_errors"),
            "do not count here: only what the bodies yield by does (process: machine has them)",
        )
    if any(body.weight for body in machine.chain):
        yield Remark(
            ("machine", "chain"), "weights of the bodies do not count here: the zero of the part is taken under them"
        )


def block_faults(machine: Machine | None, block: PartBlock | None, stiffness: float | None) -> Iterator[Remark]:
    """A part that yields in two ways at once, a block without a machine to stand on."""
    if block is None:
        return
    if stiffness is not None:
        yield Remark(("part", "stiffness"), "and part.block both say how the part yields; write one of them")
    if machine is None:
        yield Remark(
            ("part", "block"), "stands on the table of a machine (machine.library); otherwise write part.stiffness"
        )
