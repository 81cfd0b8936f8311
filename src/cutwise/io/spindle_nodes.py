"""Mass, centre and inertia of a spindle put into its section, from the solid that the section describes."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cutwise import units
from cutwise.io.occ import CadFault
from cutwise.io.spindle_body import DERIVED, Body, Misfit, parametric_body, step_body, text_of
from cutwise.io.tree import Node, from_data
from cutwise.spec import faults as spec_faults
from cutwise.spec.faults import Fault
from cutwise.spec.scenario import Origin
from cutwise.spec.spindle_solid import SpindleSolid, SpindleStep

_AGREES = 0.02  # values closer than this agree with what a solid gives


def with_solid(node: Node, path: spec_faults.Path) -> tuple[Node, list[Fault], bool]:
    """The section with mass, centre and inertia from its solid; what the engineer wrote stays.

    Returns
    -------
    tuple
        The section, faults of the solid, and whether the derived values are known (or there is no solid).
    """
    solid, reach = node.value.get("solid"), node.value.get("tool_reach")
    if solid is None or reach is None or not isinstance(solid.value, dict):
        return node, [], True
    try:
        if "step" in solid.value:
            wanted = SpindleStep.model_validate(solid.plain())
            body, said = step_body(wanted, Path(wanted.step)), f"STEP {solid.value['step'].text} and its density"
        else:
            length = units.parse(reach.value, "length")
            body = parametric_body(SpindleSolid.model_validate(solid.plain()), length)
            said = "cylinders of spindle.solid, about the joint"
    except (ValidationError, units.UnitFault):
        return node, [], False  # what is wrong with the sizes is said elsewhere
    except (CadFault, Misfit) as fault:
        key = fault.key if isinstance(fault, Misfit) else "step"
        return node, [solid.fault((*path, "solid", key), str(fault))], False
    return _filled_in(node, body, Origin("derived", source=said)), [], True


def _filled_in(node: Node, body: Body, origin: Origin) -> Node:
    value, notices = dict(node.value), list(body.notices)
    for key, text in text_of(body.found).items():
        given = value.get(key)
        shown = units.show(units.parse(text, DERIVED[key]), DERIVED[key], 5)
        if given is None or not _written(given):
            value[key] = replace(from_data(text, node.file, node.layer), origin=origin, text=shown)
            continue
        difference = _difference(given.value, text, DERIVED[key])
        if difference is not None and abs(difference) > _AGREES:
            notices.append(
                f"{key} as written ({given.text}) is {100 * difference:+.0f} % off what the solid gives "
                f"({units.show(units.parse(text, DERIVED[key]), DERIVED[key], 4)})"
            )
    value["solid_remarks"] = replace(from_data(notices, node.file, node.layer), origin=origin)
    return replace(node, value=value)


def _written(given: Node) -> bool:
    """True for a value that the engineer wrote: not from a library, and not from a solid in a run file."""
    if given.layer == 0:
        return False
    return given.origin is None or (given.origin.status != "derived" and not given.origin.library)


def _difference(given: Any, derived: str, dimension: str) -> float | None:
    """How far a value is off another, relative to that; None if it cannot be read."""
    try:
        other = units.parse(derived, dimension)
        return units.parse(given, dimension) / other - 1.0
    except (units.UnitFault, ZeroDivisionError):
        return None
