"""What can be wrong with a chain of bodies: loops, orphans, axes without direction, elements that could not hold."""

from collections.abc import Iterator
from itertools import pairwise

from cutwise.spec.base import Notice
from cutwise.spec.faults import Path
from cutwise.spec.geometry_errors import COMPONENTS, LINEAR_AXES
from cutwise.spec.machine import Body, ContactGroup, ElasticElement, Joint, Machine, PadGroup, Place

_LAWS = ("pads", "contact", "springs", "beam", "compliance")


def chain_faults(machine: Machine) -> Iterator[Notice]:
    """Loops, orphans, branches, and everything wrong with joints and elements, all of it."""
    places = {body.name: place for place, body in enumerate(machine.chain)}
    yield from _structure_faults(machine, places)
    seen: dict[str, str] = {}
    for place, body in enumerate(machine.chain):
        path: Path = ("chain", place)
        if places[body.name] != place:
            yield Notice((*path, "name"), f'there are two bodies "{body.name}"')
        if (body.weight is None) != (body.weight_at is None):
            yield Notice((*path, "weight"), "weight and weight_at go together")
        if body.joint is not None:
            yield from _joint_faults(body.joint, (*path, "joint"))
            letter = body.joint.command
            if letter is not None and letter in seen:
                yield Notice((*path, "joint", "command"), f"axis {letter} already moves {seen[letter]}")
            elif letter is not None:
                seen[letter] = body.name
        for number, element in enumerate(body.elements):
            yield from _element_faults(element, body, (*path, "elements", number))
    if not any(machine.gravity):
        yield Notice(("gravity",), "has no direction")


def _structure_faults(machine: Machine, places: dict[str, int]) -> Iterator[Notice]:
    first = [place for place, body in enumerate(machine.chain) if body.parent is None]
    if len(machine.chain) < 2:
        yield Notice(("chain",), "needs at least a part and a body that carries the tool")
    if not first and machine.chain:
        yield Notice(("chain",), "is a loop: no body is without a parent; the part, where the chain begins, has none")
    for extra in first[1:]:
        yield Notice(
            ("chain", extra, "parent"),
            f"missing: {machine.chain[extra].name} is an orphan, joined to nothing; the chain already begins with "
            f"{machine.chain[first[0]].name}",
        )
    children: dict[str, str] = {}
    for place, body in enumerate(machine.chain):
        path: Path = ("chain", place)
        if body.parent is None:
            if body.joint is not None and first and place == first[0]:
                yield Notice((*path, "joint"), "the first body has no joint: nothing comes before it")
            continue
        if body.joint is None:
            yield Notice((*path, "joint"), f"missing; say how {body.name} sits on {body.parent}")
        if body.parent not in places:
            known = ", ".join(name for name in places if name != body.name)
            yield Notice(
                (*path, "parent"), f'{body.name} is an orphan: there is no body "{body.parent}"; there are {known}'
            )
        elif body.parent == body.name:
            continue  # told as a loop
        elif body.parent in children:
            yield Notice(
                (*path, "parent"),
                f"{body.parent} already carries {children[body.parent]}; a serial chain has no branches",
            )
        else:
            children[body.parent] = body.name
    for loop in _loops(machine):
        place = places[loop[0]]
        yield Notice(("chain", place, "parent"), f"is a loop: {' - '.join((*loop, loop[0]))}")
    sides = [(body.name, body.joint.side) for body in machine.ordered[1:] if body.joint is not None]
    for (before, side), (name, following) in pairwise(sides):
        if side == "tool" and following == "part":
            yield Notice(
                ("chain", places[name], "joint", "side"),
                f"{name} is on the part side, but {before} before it on the tool side; the ground is between the sides",
            )


def _loops(machine: Machine) -> Iterator[tuple[str, ...]]:
    """Bodies that are their own ancestors, each loop once."""
    parents = {body.name: body.parent for body in machine.chain}
    told: set[str] = set()
    for name in parents:
        way: list[str] = []
        here: str | None = name
        while here is not None and here in parents and here not in way:
            way.append(here)
            here = parents[here]
        if here in way and here not in told:
            loop = way[way.index(here) :]
            told |= set(loop)
            if any(body.parent is None for body in machine.chain):
                yield tuple(loop)


def _joint_faults(joint: Joint, path: Path) -> Iterator[Notice]:
    moving = joint.kind != "fixed"
    if moving and joint.axis is None:
        yield Notice((*path, "axis"), "missing")
    if moving and joint.axis is not None and not any(joint.axis):
        yield Notice((*path, "axis"), "has zero length; write its direction, for example [1, 0, 0]")
    if moving and joint.command is None:
        yield Notice((*path, "command"), "missing")
    if joint.command is not None and moving:
        linear = joint.command in LINEAR_AXES
        if linear != (joint.kind == "prismatic"):
            expected = COMPONENTS[:3] if joint.kind == "prismatic" else COMPONENTS[3:]
            yield Notice(
                (*path, "command"), f"{joint.command} is no letter of a {joint.kind} axis; use {', '.join(expected)}"
            )
    if not moving and joint.command is not None:
        yield Notice((*path, "command"), "a fixed joint takes no command")
    needed = {"prismatic": "travel", "revolute": "turn"}.get(joint.kind)
    if needed and joint.limits is None:
        yield Notice((*path, needed), "missing")
    for key, kind in (("travel", "prismatic"), ("turn", "revolute")):
        if getattr(joint, key) is not None and joint.kind != kind:
            yield Notice((*path, key), f"belongs to a {kind} joint; this one is {joint.kind}")
    if not moving and joint.axis is not None:
        yield Notice((*path, "axis"), "a fixed joint has no axis")
    if joint.limits is not None and joint.limits[0] >= joint.limits[1]:
        yield Notice((*path, str(needed)), "ends before it begins")
    if joint.side == "part" and not moving and joint.positive is not None:
        yield Notice((*path, "positive"), "a fixed joint takes no command")
    if joint.side == "tool" and joint.positive is not None:
        yield Notice((*path, "positive"), "is for the part side only: on the tool side the body itself moves")
    if joint.side == "part" and moving and joint.positive is None:
        yield Notice((*path, "positive"), "missing")


def _element_faults(element: ElasticElement, body: Body, path: Path) -> Iterator[Notice]:
    laws = [name for name in _LAWS if getattr(element, name) is not None]
    if len(laws) != 1:
        yield Notice(path, f"give exactly one of {', '.join(_LAWS)}" + (f"; found {', '.join(laws)}" if laws else ""))
    if element.travels_with not in (None, body.name, body.parent):
        yield Notice((*path, "travels_with"), f"is neither {body.name} nor {body.parent}, which the joint is between")
    if body.parent is None:
        yield Notice(path, "the first body has no joint that could yield")
    for name in ("pads", "contact"):
        group = getattr(element, name)
        if group is not None:
            yield from _pad_faults(group, (*path, name))
    if element.springs is not None:
        for name in ("stiffness", "angular_stiffness"):
            if min(getattr(element.springs, name)) <= 0.0:
                yield Notice((*path, "springs", name), "is not positive definite: every spring must be above zero")
    if element.compliance is not None:
        fault = _compliance_fault(element.compliance)
        if fault:
            yield Notice((*path, "compliance"), fault)


def _pad_faults(group: PadGroup | ContactGroup, path: Path) -> Iterator[Notice]:
    if not _spans_a_plane(group.points):
        yield Notice((*path, "points"), "is not positive definite: pads need three places off one line")
    springs = group.stiffness if isinstance(group, PadGroup) else group.tangential
    key = "stiffness" if isinstance(group, PadGroup) else "tangential"
    normal = group.normal[1] if isinstance(group, ContactGroup) else None
    for axis, spring in zip("xyz", springs, strict=True):
        driven = group.drive is not None and group.drive.direction == axis
        if spring < 0.0:
            yield Notice((*path, key), f"is not positive definite: the stiffness along {axis} is negative")
        elif spring == 0.0 and not driven and axis != normal:
            yield Notice((*path, key), f"is not positive definite: no stiffness along {axis}")
        if axis == normal and spring != 0.0:
            yield Notice((*path, key), f"must be 0 along the normal {axis}: the contact law acts there")
    if normal is not None and group.drive is not None and group.drive.direction == normal:
        yield Notice((*path, "drive", "direction"), "is the normal of the pads")


def _spans_a_plane(points: tuple[Place, ...]) -> bool:
    origin = points[0]
    edges = [tuple(b - a for a, b in zip(origin, point, strict=True)) for point in points[1:]]
    size = max((max(map(abs, edge)) for edge in edges), default=0.0)
    for one in edges:
        for other in edges:
            cross = (
                one[1] * other[2] - one[2] * other[1],
                one[2] * other[0] - one[0] * other[2],
                one[0] * other[1] - one[1] * other[0],
            )
            if max(map(abs, cross)) > 1e-9 * size**2:
                return True
    return False


def _compliance_fault(matrix: tuple[tuple[float, ...], ...]) -> str:
    """What is wrong with a written 6 x 6 compliance; Cholesky's factor exists for positive definite ones only."""
    if len(matrix) != 6 or any(len(row) != 6 for row in matrix):
        return "needs 6 rows of 6 numbers"
    diagonal = [matrix[i][i] for i in range(6)]
    if min(diagonal) <= 0.0:
        return "is not positive definite: an entry of the diagonal is not above zero"
    scaled = [[matrix[i][j] / (diagonal[i] * diagonal[j]) ** 0.5 for j in range(6)] for i in range(6)]
    if any(abs(scaled[i][j] - scaled[j][i]) > 1e-9 for i in range(6) for j in range(i)):
        return "is not symmetric: displacement under a force must be reciprocal"
    factor: list[list[float]] = [[0.0] * 6 for _ in range(6)]
    for i in range(6):
        for j in range(i + 1):
            left = scaled[i][j] - sum(factor[i][k] * factor[j][k] for k in range(j))
            if i == j and left <= 1e-12:
                return "is not positive definite: some load would do negative work"
            factor[i][j] = left**0.5 if i == j else left / factor[j][j]
    return ""
