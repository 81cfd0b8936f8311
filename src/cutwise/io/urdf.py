"""Robots from URDF files: the turning joints of an arm, with everything that such files are known to get wrong.

Only kinematics is read. Public models copy data sheets: masses are often made up and effort limits zero, so neither is
used, and both are pointed out.
"""

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

from cutwise.io.files import read_bytes
from cutwise.spec.faults import Fault, ScenarioFault

_MOVING = ("revolute", "continuous", "prismatic", "planar", "floating")
_ARM_AXES = 6
_HEAVIEST_ARM = 3000.0  # kg: the heaviest usual arms (500 kg payload) have about 2500 kg
_WIDEST_LIMIT = 12.0 * math.pi  # rad: more is degrees taken for radians; wrists turn three times either way at most
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_MACRO = re.compile(rb"<\s*/?\s*xacro:|\$\{|\$\(")

Matrix = tuple[tuple[float, ...], ...]
Vector = tuple[float, ...]


class _Joint(NamedTuple):
    name: str
    kind: str
    parent: str
    child: str
    position: Vector
    rotation: Matrix
    axis: Vector
    lower: float | None
    upper: float | None
    effort: float | None
    mimic: Mapping[str, Any] | None  # joint, multiplier, offset as a scenario writes them


class UrdfArm(NamedTuple):
    """The arm in a URDF file."""

    joints: tuple[Mapping[str, Any], ...]  # name, origin, rotation, axis, limits as a scenario writes them
    flange: Mapping[str, Any]  # origin and rotation of the tip link in the last moving link
    notices: tuple[str, ...]  # what is unusual about the file


def read_urdf(
    path: Path, shown: str, tip_link: str | None = None, held: Mapping[str, float | None] | None = None
) -> UrdfArm:
    """Read the arm of a URDF file.

    Parameters
    ----------
    tip_link : str, optional
        Link that carries the tool. Left out: the last moving link; frames fixed to it, such as ``tool0``, are then not
        used, since they are often turned by 90 degrees.
    held : mapping, optional
        Joints that do not move: position of a sliding one [m], None for a turning one.

    Raises
    ------
    ScenarioFault
        With everything that keeps the file from being an arm with six motors, each fault with the joint it is about.
    """
    root = _root(read_bytes(path, shown), shown)
    faults: list[str] = []
    joints = [joint for element in root.findall("joint") if (joint := _joint(element, faults)) is not None]
    if faults:
        raise _fault(faults, shown)
    held = held or {}
    chain = list(_chain(joints, tip_link, faults))
    moving = [joint for joint in chain if joint.kind != "fixed"]
    for joint in moving:
        faults += _joint_faults(joint, moving, held)
    faults += [f"has no joint {name} to hold between base and tip" for name in held if name not in _names(chain)]
    if not faults and len(_own(moving, held)) != _ARM_AXES:
        faults.append(_count(chain, moving, held))
    if faults:
        raise _fault(faults, shown)
    return _arm(chain, held, tip_link is not None, tuple(_notices(root, chain, moving)))


def _names(joints: list[_Joint]) -> list[str]:
    return [joint.name for joint in joints]


def _own(moving: list[_Joint], held: Mapping[str, float | None]) -> list[_Joint]:
    """Joints that move on their own."""
    return [joint for joint in moving if joint.mimic is None and joint.name not in held]


def _count(chain: list[_Joint], moving: list[_Joint], held: Mapping[str, float | None]) -> str:
    """Too many or too few joints, and what to write."""
    own = _own(moving, held)
    fixed = ", ".join(joint.name for joint in chain if joint.kind == "fixed") or "none"
    text = (
        f"has {len(own)} moving joints from base to tip, an arm needs six; moving: {', '.join(_names(own)) or 'none'}; "
        f"fixed: {fixed}"
    )
    if len(own) <= _ARM_AXES:
        return text
    behind = own[_ARM_AXES - 1].child
    return (
        f"{text}; hold the others, for example robot.held_joints: [{{joint: {own[2].name}, angle: 0 deg}}], or, if the "
        f"tool sits behind the sixth, write robot.tip_link: {behind}"
    )


def _behind_six(before: list[_Joint]) -> str:
    """The remedy for what hangs on an arm: the link behind its sixth turning joint, if six stand before it."""
    six = [joint for joint in before if joint.mimic is None][:_ARM_AXES]
    if len(six) < _ARM_AXES or any(joint.kind == "prismatic" for joint in six):
        return ""
    return f"if the tool sits behind the sixth, write robot.tip_link: {six[-1].child}; or "


def _fault(messages: list[str], shown: str) -> ScenarioFault:
    return ScenarioFault([Fault((), message, file=shown) for message in messages])


def _root(content: bytes, shown: str) -> ElementTree.Element:
    plain = _COMMENT.sub(b"", content)
    if b"<!ENTITY" in plain:
        raise _fault(["declares XML entities, which a URDF has no use for"], shown)
    if _MACRO.search(plain):
        raise _fault(["holds xacro macros; expand it first: xacro robot.xacro > robot.urdf"], shown)
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        line, column = error.position
        raise ScenarioFault([Fault((), f"is not well-formed XML: {error}", line, column + 1, shown)]) from None
    if root.tag != "robot":
        raise _fault([f"begins with <{root.tag}>, a URDF begins with <robot>"], shown)
    return root


def _joint(element: ElementTree.Element, faults: list[str]) -> _Joint | None:
    """A joint element; what cannot be read of it is added to ``faults``."""
    name, kind = element.get("name", "unnamed"), element.get("type", "")
    if kind not in (*_MOVING, "fixed"):
        faults.append(f'joint {name}: type "{kind}" is not one of URDF')
        return None
    parent, child = element.find("parent"), element.find("child")
    if parent is None or child is None:
        faults.append(f"joint {name}: has no parent or no child link")
        return None
    origin, axis, limit = element.find("origin"), element.find("axis"), element.find("limit")
    position = _numbers(origin, "xyz", "0 0 0", name, faults)
    angles = _numbers(origin, "rpy", "0 0 0", name, faults)
    direction = _numbers(axis, "xyz", "1 0 0", name, faults)
    ends: dict[str, float | None] = {}
    for key in ("lower", "upper", "effort"):
        text = limit.get(key) if limit is not None else None
        ends[key] = None if text is None else _numbers(limit, key, "0", name, faults, count=1)[0]
    mimic = element.find("mimic")
    follows = None
    if mimic is not None:
        defaults = (("multiplier", "1"), ("offset", "0"))
        multiplier, offset = (_numbers(mimic, key, text, name, faults, count=1)[0] for key, text in defaults)
        follows = {"joint": mimic.get("joint", ""), "multiplier": multiplier, "offset": f"{offset!r} rad"}
    return _Joint(
        name, kind, parent.get("link", ""), child.get("link", ""), position, _from_rpy(angles), direction,
        ends["lower"], ends["upper"], ends["effort"], follows,
    )  # fmt: skip


def _numbers(
    element: ElementTree.Element | None, key: str, default: str, joint: str, faults: list[str], count: int = 3
) -> Vector:
    text = default if element is None else element.get(key, default)
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        faults.append(f'joint {joint}: {key}="{text}" is not {count} finite number{"s" if count > 1 else ""}')
        return (0.0,) * count
    return values


def _chain(joints: list[_Joint], tip_link: str | None, faults: list[str]) -> Iterator[_Joint]:
    """The joints from the base to the tip."""
    above: dict[str, _Joint] = {}
    for joint in joints:
        if joint.child in above:
            faults.append(f"link {joint.child} hangs on two joints, {above[joint.child].name} and {joint.name}")
        above[joint.child] = joint
    if faults:
        return
    tips = {joint.child for joint in joints} - {joint.parent for joint in joints}
    if tip_link is not None:
        if tip_link not in above:
            faults.append(f"has no link {tip_link} that a joint carries; there are: {', '.join(above) or 'none'}")
            return
        tips = {tip_link}
    found: list[list[_Joint]] = []
    for tip in sorted(tips):
        path: list[_Joint] = []
        link = tip
        while link in above and len(path) <= len(joints):
            path.append(above[link])
            link = above[link].parent
        found.append(path[::-1])
    if any(len(path) > len(joints) for path in found) or (joints and not found):
        faults.append("its joints form a ring without a base")
        return
    if found:
        yield from _longest(found, faults)


def _longest(found: list[list[_Joint]], faults: list[str]) -> list[_Joint]:
    """The path with most moving joints; two arms on one base are no arm until one of them is named."""
    moved = [[joint for joint in path if joint.kind != "fixed"] for path in found]
    most = max(map(len, moved))
    arms = {tuple(_names(joints)): joints for joints in moved if len(joints) == most}
    first = next(iter(arms.values()))
    if any(joints[:_ARM_AXES] != first[:_ARM_AXES] for joints in arms.values()):  # not two fingers of one hand
        tips = " or ".join(f"robot.tip_link: {joints[-1].child}" for joints in arms.values())
        faults.append(f"has {len(arms)} tips with {most} moving joints each; write which carries the tool: {tips}")
        return []
    return max(found, key=lambda path: (sum(joint.kind != "fixed" for joint in path), -len(path)))


def _joint_faults(joint: _Joint, moving: list[_Joint], held: Mapping[str, float | None]) -> Iterator[str]:
    """Why a joint cannot be one of an arm."""
    what = f"joint {joint.name}"
    if joint.kind in ("floating", "planar"):
        yield f"{what}: is {joint.kind}, held by nothing; an arm has revolute joints (or is it meant to be fixed?)"
    if joint.kind == "prismatic" and held.get(joint.name) is None:
        remedy = _behind_six(moving[: moving.index(joint)])
        yield (
            f"{what}: is prismatic; posture search and stiffness in N m/rad need six turning joints; {remedy}hold it: "
            f"robot.held_joints: [{{joint: {joint.name}, position: 0 mm}}]"
        )
    if joint.kind != "prismatic" and held.get(joint.name) is not None:
        yield f"{what}: turns; robot.held_joints holds it by an angle, not by a position"
    if joint.mimic is not None and joint.mimic["joint"] not in _names(moving):
        yield f"{what}: follows {joint.mimic['joint'] or 'nothing'} (mimic), which is not between base and tip"
    if math.hypot(*joint.axis) < 1e-9:
        yield f"{what}: its axis has no length"
    if joint.kind == "revolute" and joint.mimic is None:
        if joint.lower is None or joint.upper is None:
            yield f"{what}: has no limits; a revolute joint needs lower and upper (or is it continuous?)"
        elif joint.lower >= joint.upper:
            yield f"{what}: lower limit {joint.lower:g} rad is not below the upper one, {joint.upper:g} rad"


def _notices(root: ElementTree.Element, chain: list[_Joint], moving: list[_Joint]) -> Iterator[str]:
    """What is possible but a known trap of public models."""
    for joint in moving:
        if joint.kind == "continuous":
            yield f"joint {joint.name} is continuous; it is taken as -360 to 360 deg"
        elif joint.lower is not None and joint.upper is not None and joint.upper - joint.lower > _WIDEST_LIMIT:
            yield f"joint {joint.name} turns through {joint.upper - joint.lower:g} rad; are its limits in degrees?"
    if moving and all(joint.effort == 0.0 for joint in moving):
        yield "all effort limits are 0, which means not given; joint torques are not checked"
    masses = {link.get("name", "unnamed"): _mass(link) for link in root.findall("link")}
    given = {name: mass for name, mass in masses.items() if mass is not None}
    total = sum(given.values())
    if total > _HEAVIEST_ARM:
        yield f"the links weigh {total:.4g} kg together; usual is up to {_HEAVIEST_ARM:g} kg; masses are not used"
    negative = [name for name, mass in given.items() if mass <= 0.0]
    if negative:
        yield f"links without or with negative mass: {', '.join(negative)}; masses are not used"
    last = chain.index(moving[-1])
    between = [joint.name for joint in chain[:last] if joint.kind == "fixed"]
    if between and any(name != joint.name for name, joint in zip(between, chain, strict=False)):
        yield f"fixed joints between moving ones: {', '.join(between)}; are they meant to be fixed?"


def _mass(link: ElementTree.Element) -> float | None:
    element = link.find("inertial/mass")
    try:
        return None if element is None else float(element.get("value", ""))
    except ValueError:
        return None


def _arm(chain: list[_Joint], held: Mapping[str, float | None], to_tip: bool, notices: tuple[str, ...]) -> UrdfArm:
    """Fold fixed joints and held slides into the next turning one, and those behind the last one into the flange."""
    joints = []
    position: Vector = (0.0, 0.0, 0.0)
    rotation = _IDENTITY
    for joint in chain:
        position = tuple(p + q for p, q in zip(position, _turned(rotation, joint.position), strict=True))
        rotation = _product(rotation, joint.rotation)
        if joint.kind == "fixed":
            continue
        if joint.kind == "prismatic":
            travel = (held[joint.name] or 0.0) / math.hypot(*joint.axis)
            along = tuple(travel * x for x in joint.axis)
            position = tuple(p + q for p, q in zip(position, _turned(rotation, along), strict=True))
            continue
        ends = (joint.lower, joint.upper)
        if joint.kind == "continuous" or None in ends:  # a follower has the limits of its leader
            ends = (-2 * math.pi, 2 * math.pi)
        joints.append({
            "name": joint.name, **_placed(position, rotation), "axis": list(joint.axis),
            "limits": [f"{end!r} rad" for end in ends], **({"mimic": dict(joint.mimic)} if joint.mimic else {}),
        })  # fmt: skip
        position, rotation = (0.0, 0.0, 0.0), _IDENTITY
    if not to_tip:
        position, rotation = (0.0, 0.0, 0.0), _IDENTITY
    return UrdfArm(tuple(joints), _placed(position, rotation), notices)


def _placed(position: Vector, rotation: Matrix) -> dict[str, list[str]]:
    return {"origin": [f"{x + 0.0!r} m" for x in position], "rotation": [f"{a + 0.0!r} rad" for a in _to_rpy(rotation)]}


_IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _product(a: Matrix, b: Matrix) -> Matrix:
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def _turned(a: Matrix, v: Vector) -> Vector:
    return tuple(sum(a[i][k] * v[k] for k in range(3)) for i in range(3))


def _from_rpy(angles: Vector) -> Matrix:
    (cr, cp, cy), (sr, sp, sy) = (tuple(map(f, angles)) for f in (math.cos, math.sin))
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def _to_rpy(r: Matrix) -> Vector:
    """Fixed-axis roll, pitch and yaw; at a pitch of 90 degrees the yaw is put to zero."""
    cosine = math.hypot(r[0][0], r[1][0])
    if cosine < 1e-9:
        return math.atan2(-r[1][2], r[1][1]), math.atan2(-r[2][0], cosine), 0.0
    return math.atan2(r[2][1], r[2][2]), math.atan2(-r[2][0], cosine), math.atan2(r[1][0], r[0][0])
