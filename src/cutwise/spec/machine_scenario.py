"""The scenario of a pass on a machine tool: where its error comes from, and what it leaves on the part."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from cutwise import units
from cutwise.spec import needs
from cutwise.spec.base import (
    Count,
    Elasticity,
    Length,
    LibrarySpec,
    Notice,
    Number,
    SmallAngle,
    SmallLength,
    Spec,
    Stiffness,
    Usual,
)
from cutwise.spec.carrier import CarryingRobot, Standing
from cutwise.spec.cell import ONE_CARRIER, REFUSED
from cutwise.spec.faults import Path
from cutwise.spec.geometry_errors import LINEAR_AXES, ROTARY_AXES, SQUARENESS, GeometryErrors
from cutwise.spec.machine import Joint, Machine, Place, gantry, merged_errors, stiffnesses
from cutwise.spec.machine_checks import chain_faults
from cutwise.spec.machine_pass import AxisPosition, CutSurface, FromCutting, MachineLoad, MachinePath, ProgramPass
from cutwise.spec.material import Material
from cutwise.spec.measures import MACHINE
from cutwise.spec.needs import Needs
from cutwise.spec.part_block import PartBlock, PartSpring, YieldingPart
from cutwise.spec.program import StockBlock, top_of
from cutwise.spec.scenario import MeasureSpec, Scenario
from cutwise.spec.tables import Table
from cutwise.spec.tool import ToolMode

_ON_TOP = 1e-6  # [m]
_GANTRY = gantry()


class MachineTool(LibrarySpec):
    """The end mill, as far as the machine's error depends on it."""

    library_shelf: ClassVar[str] = "tools"

    diameter: Annotated[Length, Usual("1 mm", "80 mm")] = Field(description="diameter D", examples=["10 mm"], gt=0)
    flutes: Annotated[Count, Usual(1, 40)] | None = Field(
        default=None, description="number of flutes N, for a force from the cutting model", examples=[4], ge=1, le=200
    )
    tip: Place | None = Field(
        default=None, description="tool point in the frame of the last body of the machine; a robot has its own "
        "(robot.tool_position)", examples=["[0 mm, 0 mm, -45 mm]"],
    )  # fmt: skip
    flexible: bool = Field(description="bends as a cantilever", examples=[True])
    overhang: Length | None = Field(default=None, description="length that bends", examples=["20 mm"], gt=0)
    filling: Number | None = Field(
        default=None, description="share of the round section that the flutes leave", examples=[0.8], gt=0, le=1
    )
    youngs_modulus: Elasticity | None = Field(
        default=None, description="Young's modulus", examples=["210 kN/mm^2"], gt=0
    )
    poisson_ratio: Number | None = Field(default=None, description="Poisson's ratio", examples=[0.3], gt=-1, lt=0.5)
    shear_factor: Number | None = Field(
        default=None, description="share of the section that carries shear", examples=[0.9], gt=0, le=1
    )
    stiffness: Annotated[Stiffness, Usual("0.1 N/um", "100 N/um")] | None = Field(
        default=None, description="measured static stiffness at the tip across the tool; left out: not known",
        examples=["20 N/um"], gt=0,
    )  # fmt: skip
    modes: tuple[ToolMode, ...] = Field(
        default=(), description="vibration modes of the tip along x and y of the last body; the pass is at rest: F/k",
        examples=["[{direction: x, frequency: 950 Hz, damping: 0.03, stiffness: 18 N/um}]"],
    )  # fmt: skip

    def notices(self) -> Iterator[Notice]:
        """What of a mode is not for a pass at rest."""
        if self.modes:
            yield Notice(("modes",), "count by their stiffness: a pass at rest knows no frequency and no damping")

    def contradictions(self) -> Iterator[Notice]:
        """One way in which a tool bends, and what it needs."""
        ways = [
            key
            for key, there in (("flexible", self.flexible), ("stiffness", self.stiffness), ("modes", self.modes))
            if there
        ]
        if len(ways) > 1:
            yield Notice(
                (ways[-1],),
                f"and tool.{ways[0]} both say how the tool bends; write one of flexible: true, stiffness, modes",
            )
        for key in ("overhang", "filling", "youngs_modulus", "poisson_ratio", "shear_factor"):
            if self.flexible and getattr(self, key) is None:
                yield Notice((key,), "missing")


class Scatter(Spec):
    """Random error of one or more bodies, each component independent."""

    bodies: tuple[str, ...] = Field(description="names of the bodies", examples=["[table, saddle]"], min_length=1)
    displacement: SmallLength = Field(description="standard deviation along x, y and z", examples=["3 um"], ge=0)
    rotation: SmallAngle = Field(description="standard deviation about x, y and z", examples=["15 urad"], ge=0)
    distribution: Literal["normal", "uniform", "triangular"] = Field(
        description="law of these components", examples=["normal"]
    )


class Uncertainty(Spec):
    """How uncertain the positions of the bodies are."""

    bodies: tuple[Scatter, ...] = Field(
        description="standard deviations per body",
        examples=["[{bodies: [table], displacement: 3 um, rotation: 15 urad, distribution: normal}]"], min_length=1,
    )  # fmt: skip
    tolerance: SmallLength | None = Field(
        default=None, description="length of the error that is allowed: the run tells with which probability it holds",
        examples=["0.45 mm"], gt=0,
    )  # fmt: skip
    samples: Annotated[Count, Usual(20000, 2000000)] = Field(
        default=100_000, description="samples of the Monte Carlo", examples=[100000], ge=100, le=5_000_000
    )
    seed: Count = Field(default=1, description="seed", examples=[1], ge=0)


class Volume(Spec):
    """A map of the geometric errors over the working space."""

    points: Annotated[Count, Usual(5, 60)] = Field(
        default=11, description="points along each linear axis", examples=[11], ge=2, le=200
    )
    table_points: Annotated[Count, Usual(5, 60)] | None = Field(
        default=None, description="points along each linear axis of an error table in the control, taken off with straight lines "
        "between them: the map then shows what is left; left out: no table", examples=[11], ge=2, le=200,
    )  # fmt: skip
    at: AxisPosition = Field(
        default_factory=AxisPosition, description="commands of the rotary axes", examples=["{C: 0 deg}"]
    )
    diagonal_points: Annotated[Count, Usual(11, 1001)] = Field(
        default=101, description="points along each body diagonal", examples=[101], ge=2
    )


class StillMachine(Machine):
    """A machine tool whose pass is looked at at rest."""

    refused: ClassVar[Mapping[str, str]] = {"drives": REFUSED["machine", "drives"]}


class MachineScenario(Scenario):
    """Error budget of a machine tool along a pass, and its volumetric error (Demeč and Madáč; ISO 230)."""

    refused: ClassVar[Mapping[str, str]] = {"spindle": REFUSED["machine", "pistons"]}
    measures: ClassVar[Mapping[str, MeasureSpec]] = MACHINE
    needs: ClassVar[Needs] = needs.MACHINE
    either: ClassVar[tuple[tuple[str, ...], ...]] = (("path",), ("program",))
    starts: ClassVar[Mapping[str, str]] = {
        "machine.library": "demec_mill",
        "tool.library": "demec",
        "part.youngs_modulus": "210 kN/mm^2",
        "part.poisson_ratio": "0.3",
        "part.shear_factor": "0.8333333",
        "path.points": "[{X: 0 mm}, {X: 260 mm}]",
        "load.force": "[4000 N, 4000 N, 2000 N]",
        "surface.normal": "[0, 1, 0]",
        "uncertainty.samples": "100000",
        "requirements": "{deviation_norm_max: {max: 0.5 mm}}",
    }
    levers: ClassVar[Mapping[str, tuple[str, str]]] = {
        "load.force.axial_depth": ("0.5 mm", "20 mm"),
        "load.force.radial_depth": ("0.2 mm", "8 mm"),
        "load.force.spindle_speed": ("200 rpm", "20000 rpm"),
        "path.feed": ("1 mm/s", "100 mm/s"),
    }

    process: Literal["machine"] = Field(description="which operation is simulated", examples=["machine"])
    machine: StillMachine | None = Field(default=None, description="the machine tool (or give robot)")
    robot: CarryingRobot | None = Field(
        default=None,
        description="a robot instead of the machine; X, Y and Z are then places of the tool point in the part",
    )
    placement: Standing | None = Field(default=None, description="where the part stands before the robot")
    tool: MachineTool = Field(description="the tool")
    part: YieldingPart | None = Field(
        default=None, description="the part, a block or one stiffness off its wall; left out: rigid and without weight"
    )
    path: MachinePath | None = Field(
        default=None, description="the pass as moves of the axes (or give program; neither: a volumetric map only)"
    )
    program: ProgramPass | None = Field(default=None, description="the pass as a G-code program (or give path)")
    stock: StockBlock | None = Field(
        default=None,
        description="the block that a program cuts, in its coordinates: the cut then follows from its moves",
    )
    load: MachineLoad = Field(default_factory=MachineLoad, description="forces on the machine")
    material: Material | None = Field(default=None, description="material, for a force from the cutting model")
    surface: CutSurface | None = Field(default=None, description="the wall that the pass finishes")
    uncertainty: Uncertainty | None = Field(default=None, description="random errors of the bodies")
    geometry_errors: GeometryErrors | None = Field(
        default=None, description="geometric errors by ISO 230-1 names; they replace those of the machine"
    )
    volume: Volume | None = Field(default=None, description="map of the volumetric error")
    convention: Literal["physical", "paper_literal"] = Field(
        default="physical",
        description="paper_literal adds the errors of tables as Eq. (2) reads instead of taking them off; a demo",
        examples=["physical"],
    )

    @property
    def carrying(self) -> Machine:
        """The machine; for a robot, three axes that are the places of its tool point in the part."""
        return self.machine if self.machine is not None else _GANTRY

    @property
    def block(self) -> PartBlock | None:
        """The part, if it is a block."""
        return self.part if isinstance(self.part, PartBlock) else None

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies from the part to the tool."""
        if self.robot is None:
            return tuple(body.name for body in self.carrying.ordered)
        names = (f"joint_{name}" if name[:1].isdigit() else name for name in self.robot.names)
        return ("part", "base", *names, "spindle")

    @property
    def has_pass(self) -> bool:
        """Whether there is a pass, and not only a map of the working space."""
        return self.path is not None or self.program is not None

    @property
    def focus(self) -> str:  # type: ignore[override]
        """The largest error of the pass, or of the working space where there is none."""
        return "deviation_norm_max" if self.has_pass else "volumetric_error_max"

    def turned(self) -> Mapping[str, tuple[str, str]]:
        """The cut, and the stiffness of every element by itself."""
        stiffer = {}
        for body, element, key in stiffnesses(self.carrying):
            stiffer[f"machine.chain[{body}].elements[{element}].{key}"] = ("0.5", "5")
        levers = dict(self.levers)
        if not isinstance(self.load.force, FromCutting):
            levers = {}  # a prescribed force asks neither for the feed nor for what is cut
        elif self.path is None:
            del levers["path.feed"]  # a program has its own in its blocks
        return {**levers, **(stiffer if self.has_pass else {})}

    def unasked(self) -> int:
        """A program, a map of the working space or a chain with rotary axes takes ten times a simple pass."""
        return 100 if self.volume is None and self.program is None else 40

    def own_scatter(self) -> Mapping[str, str]:
        """The components of the error in the middle of a path, by the scatter of the bodies."""
        if self.uncertainty is None or self.path is None:
            return {}
        return {f"deviation_{axis}_middle": f"deviation_std_{axis}" for axis in "xyz"}

    def contradictions(self) -> Iterator[Notice]:
        """Everything wrong with the chain, the errors and the travel, at once."""
        for check in self.checks():
            yield from check

    def checks(self) -> Iterator[Iterator[Notice]]:
        """The chain; the pass and the map on it; loads; errors by axis; names of bodies."""
        yield self._chain_faults()
        yield self._carrier_faults()
        yield self._pass_faults()
        yield self._load_faults()
        yield self._volume_faults()
        yield self._error_faults()
        yield self._named_bodies()

    def _chain_faults(self) -> Iterator[Notice]:
        if self.machine is not None:
            for notice in chain_faults(self.machine):
                yield Notice(("machine", *notice.path), notice.message)

    def _carrier_faults(self) -> Iterator[Notice]:
        """One carrier; what a robot does not have; a part that yields off a wall that is not there."""
        if isinstance(self.part, PartSpring) and self.surface is None:
            yield Notice(("surface",), "missing; part.stiffness is that off the wall, for example surface: {normal: [0, 1, 0], "
                         "depth: 5 mm}")  # fmt: skip
        if self.robot is None:
            if self.machine is None:
                yield Notice(("machine",), "missing; write machine.library (or robot.library for a robot)")
            if self.placement is not None:
                yield Notice(("placement",), "places a part before a robot; there is none")
            if self.tool.tip is None and self.machine is not None:
                yield Notice(("tool", "tip"), "missing; where the tool point is in the frame of the last body, for example "
                             "[0 mm, 0 mm, -45 mm]")  # fmt: skip
            return
        for key, why in (
            ("body_compliance", "write joint_stiffness"),
            ("errors", "leave them out with robot.errors: null"),
        ):
            if getattr(self.robot, key) is not None:
                yield Notice(
                    ("robot", key),
                    f"a budget at rest goes joint by joint, and knows none; {why}, or use process: mill or deburr",
                )
        if self.machine is not None:
            yield Notice(("robot",), ONE_CARRIER)
        for key in ("volume", "geometry_errors"):
            if getattr(self, key) is not None:
                yield Notice((key,), "is of the axes of a machine; a robot has none: leave it out")
        if self.convention == "paper_literal":
            yield Notice(("convention",), "is a demo of tables that move; a robot carries the tool alone")

    def _volume_faults(self) -> Iterator[Notice]:
        axes = self.carrying.axes()
        if self.volume is not None:
            yield from _beyond(self.volume.at, axes, ("volume", "at"))
            for letter in LINEAR_AXES:
                if getattr(self.volume.at, letter) is not None:
                    yield Notice(("volume", "at", letter), "is mapped over its whole travel; leave it out")
            if sum(letter in LINEAR_AXES for letter in axes) != 3:
                yield Notice(("volume",), "a map of the working space needs three linear axes")

    def _named_bodies(self) -> Iterator[Notice]:
        """Bodies of random errors and of requirements, which must be there, each once."""
        known = list(self.bodies)
        there = f"there are {', '.join(known)}"
        seen: set[str] = set()
        for place, scatter in enumerate(self.uncertainty.bodies if self.uncertainty else ()):
            for number, name in enumerate(scatter.bodies):
                path: Path = ("uncertainty", "bodies", place, "bodies", number)
                if name not in known:
                    yield Notice(path, f'there is no body "{name}"; {there}')
                elif name in seen:
                    yield Notice(path, f"{name} has its random error already; write each body once")
                seen.add(name)
        for name in self.requirements:
            if name.startswith("share_") and name.removeprefix("share_") not in known:
                yield Notice(("requirements", name), f'there is no body "{name.removeprefix("share_")}"; {there}')

    def _pass_faults(self) -> Iterator[Notice]:
        axes = self.carrying.axes()
        if not self.has_pass and self.volume is None:
            words = "missing: write a path or program for a pass, or volume for a map of the working space"
            yield Notice(("path",), words)
        if self.path is not None and self.program is not None:
            yield Notice(("path",), "give one of path and program")
        if self.program is not None and sum(letter in LINEAR_AXES for letter in axes) != 3:
            there = ", ".join(axes) or "none"
            yield Notice(("program",), f"a program needs three linear axes; the machine has {there}")
        if self.path is None:
            return
        for number, point in enumerate(self.path.points):
            yield from _beyond(point, axes, ("path", "points", number))
        corners = self.path.corners()
        if all(corner == corners[0] for corner in corners):
            yield Notice(("path", "points"), "is no way: all points are the same")
        elif not any(a[axis] != b[axis] for a, b in pairwise(corners) for axis in LINEAR_AXES):
            yield Notice(("path", "points"), "moves no linear axis; the feed is theirs")

    def _load_faults(self) -> Iterator[Notice]:
        cut = self.load.force
        if self.stock is not None and (self.program is None or self.program.words != "part"):
            yield Notice(("stock",), "is cut by a program whose words are places in the part (program.words: part)")
        if not isinstance(cut, FromCutting):
            return
        if self.material is None:
            yield Notice(("material",), "missing")
        if self.tool.flutes is None:
            yield Notice(("tool", "flutes"), "missing")
        if self.stock is None and cut.axial_depth is None:
            yield Notice(("load", "force", "axial_depth"), "missing")
        if cut.spindle_speed is None and self.program is None:
            yield Notice(("load", "force", "spindle_speed"), "missing")
        if cut.radial_depth is not None and self.surface is not None and self.surface.side == "left":
            yield Notice(("surface", "side"), "the wall of this cut is on the right (load.force.radial_depth)")
        if cut.radial_depth is not None and cut.radial_depth > self.tool.diameter * (1 + 1e-9):
            yield Notice(
                ("load", "force", "radial_depth"),
                f"is more than the diameter of the tool ({units.show(self.tool.diameter, 'length')}); leave it out for a "
                "full slot",
            )

    def _error_faults(self) -> Iterator[Notice]:
        axes = self.carrying.axes()
        for section, errors in (("machine", self.carrying.geometry_errors), ("", self.geometry_errors)):
            before: Path = (*filter(None, (section,)), "geometry_errors")
            for name in type(errors).model_fields if errors is not None else ():
                value = getattr(errors, name)
                if value is None:
                    continue
                axis = SQUARENESS[name][0] if name in SQUARENESS else name[-1]
                if axis not in axes:
                    there = ", ".join(axes) or "none"
                    yield Notice(
                        (*before, name), f"is an error of axis {axis}, which the machine does not have; it has {there}"
                    )
                elif isinstance(value, Table):
                    yield from _gaps(value, axis, axes[axis], (*before, name))
                elif name.startswith("E") and value.rotary != (axis in ROTARY_AXES):
                    yield Notice((*before, name), _over_what(value, axis))

    def unused(self) -> Iterator[Notice]:
        """What a map does without, what a given force does not ask for, and what is rigid, weightless or not there."""
        yield from super().unused()
        if not self.has_pass:
            no_pass = "there is no pass (path or program), only a map of the working space"
            for key in (("load", "force"), ("load", "weights"), ("tool", "flutes"), ("part",), ("material",), ("surface",),
                        ("uncertainty",), ("stock",)):  # fmt: skip
                yield Notice(key, no_pass)
            yield from self._of_bodies(("weight", "weight_at", "elements"), no_pass)
        elif not isinstance(self.load.force, FromCutting):
            given = "it is not asked for: the force is given, not computed (load.force)"
            yield Notice(("tool", "flutes"), given)
            yield Notice(("material",), given)
        else:
            yield Notice(("material", "group"), "deburring alone holds its cutting speed against that of the group")
        if not self.load.weights:
            yield from self._of_bodies(("weight", "weight_at"), "load.weights is false")
        if self.stock is not None:
            for depth in ("axial_depth", "radial_depth") if isinstance(self.load.force, FromCutting) else ():
                yield Notice(("load", "force", depth), "the stock says what the program meets")
            yield Notice(("program", "top"), "the stock has its own top (stock.z)")
        yield from _rigid("tool", ("overhang", "filling"), self.tool.flexible)
        if self.block is not None:
            yield from _rigid("part", (), self.block.flexible)
        if self.robot is not None:
            yield from self._of_robot()
            return
        if self.path is not None:
            yield Notice(("path", "tool_axis"), "it is for a robot; the tool of a machine stands as its chain says")
        yield from self._unmoved()

    def _of_robot(self) -> Iterator[Notice]:
        """What a robot at rest does without."""
        yield Notice(("tool", "tip"), "a robot has its own tool point (robot.tool_position)")
        for key in ("dynamics", "modal_mass", "damping", "joint_acceleration"):
            yield Notice(("robot", key), "a pass at rest knows no vibration")
        yield Notice(("robot", "sag"), "weights count as load.weights says, all of them")
        assert self.robot is not None
        if self.load.weights and self.robot.links is None and self.robot.tool_mass is None:
            yield Notice(("load", "weights"), "no weight of links or tool is given (robot.links, robot.tool_mass)")

    def _of_bodies(self, keys: tuple[str, ...], reason: str) -> Iterator[Notice]:
        for place in range(len(self.carrying.chain)):
            for key in keys:
                yield Notice(("machine", "chain", place, key), reason)

    def _unmoved(self) -> Iterator[Notice]:
        """Where error motions act, of axes that have none."""
        errors = [name for name in self.errors() if name.startswith("E")]
        for place, body in enumerate(self.carrying.chain):
            if body.joint is not None and not any(name[-1] == body.joint.command for name in errors):
                path: Path = ("machine", "chain", place, "joint", "errors_act")
                yield Notice(path, "no error motions of this axis are given (geometry_errors)")

    def notices(self) -> Iterator[Notice]:
        """Conventions that are not physics, and loads that the model does not cover."""
        if self.convention == "paper_literal":
            yield Notice(("convention",), "paper_literal is a demo of the printed Eq. (2), not a prediction")
        if not self.load.feed_moment:
            yield Notice(("load", "feed_moment"), "false leaves out a moment that acts; a demo, not a prediction")
        rest = self.carrying.ordered[self.carrying.ground] if self.carrying.ordered else None
        if rest is not None and rest.weight:
            place = [body.name for body in self.carrying.chain].index(rest.name)
            path: Path = ("machine", "chain", place, "weight")
            yield Notice(path, f"{rest.name} is at rest, between part and tool side: its weight bends nothing")
        if self.geometry_errors is not None and self.carrying.geometry_errors is not None:
            names = [
                name
                for name in type(self.geometry_errors).model_fields
                if getattr(self.geometry_errors, name) is not None
                and getattr(self.carrying.geometry_errors, name) is not None
            ]
            if names:
                yield Notice(("geometry_errors",), f"replaces {', '.join(names)} of machine.geometry_errors")
        yield from self._zero_on_part()
        if self.has_pass and self.load.force is None:
            yield Notice(("load",), "no cutting force: the pass shows weights and geometric errors only")

    def _zero_on_part(self) -> Iterator[Notice]:
        """A program whose material does not end where the part does, or a stock that the part does not hold."""
        if self.program is None or self.block is None or self.program.words != "part":
            return
        x, y, z = self.program.zero
        top, height = top_of(self.program, self.stock) + z, self.block.height
        if abs(top - height) > _ON_TOP:
            key = "stock.z" if self.stock is not None else "program.top"
            yield Notice(
                ("program", "zero"),
                f"puts the top of the material ({key}) at z = {_mm(top)} of the part, which is {_mm(height)} high "
                "(part.height)",
            )
        if self.stock is None:
            return
        for axis, shift, size in (("x", x, self.block.width_x), ("y", y, self.block.width_y)):
            low, high = (end + shift for end in getattr(self.stock, axis))
            if low < -0.5 * size - _ON_TOP or high > 0.5 * size + _ON_TOP:
                yield Notice(
                    ("stock", axis),
                    f"reaches from {_mm(low)} to {_mm(high)} of the part, which is {_mm(size)} wide (part.width_{axis})",
                )
        if self.stock.z[0] + z < -_ON_TOP:
            yield Notice(("stock", "z"), f"reaches {_mm(-self.stock.z[0] - z)} below the part (program.zero)")

    def errors(self) -> dict[str, object]:
        """Geometric errors that count, by name."""
        return merged_errors(self.carrying, self.geometry_errors)


def _rigid(section: str, keys: tuple[str, ...], flexible: bool) -> Iterator[Notice]:
    """What bending asks for, of something rigid."""
    if not flexible:
        for key in (*keys, "youngs_modulus", "poisson_ratio", "shear_factor"):
            yield Notice((section, key), f"{section}.flexible is false")


def _over_what(error: Any, axis: str) -> str:
    """That an error is given over a length where its axis turns, or the other way round."""
    linear, rotary = ("scale", "angle_scale") if hasattr(error, "angle_scale") else ("wavelength", "period")
    given, wanted = (rotary, linear) if error.rotary else (linear, rotary)
    return f"axis {axis} {'moves' if error.rotary else 'turns'}: write {wanted} instead of {given}"


def _beyond(point: AxisPosition, axes: Mapping[str, Joint], path: Path) -> Iterator[Notice]:
    for axis, value in point.given().items():
        if axis not in axes:
            yield Notice((*path, axis), f"the machine has no axis {axis}; it has {', '.join(axes) or 'none'}")
            continue
        limits = axes[axis].limits
        if limits is not None and not limits[0] - 1e-12 <= value <= limits[1] + 1e-12:
            dimension = "length" if axis in LINEAR_AXES else "angle"
            low, high = (units.show(end, dimension) for end in limits)
            yield Notice(
                (*path, axis), f"{units.show(value, dimension)} is beyond the travel of axis {axis}, {low} to {high}"
            )


def _gaps(table: Table, axis: str, joint: Joint, path: Path) -> Iterator[Notice]:
    """A table that does not cover the travel, or leaves out a stretch of it."""
    wanted = "position" if axis in LINEAR_AXES else "angle"
    dimension = "length" if axis in LINEAR_AXES else "angle"
    if table.variable != wanted:
        yield Notice(path, f"axis {axis} needs a column {wanted}, found {table.variable}")
        return
    at, limits = table.points()[0], joint.limits
    if limits is not None and (at[0] > limits[0] + 1e-12 or at[-1] < limits[1] - 1e-12):
        ends = [units.show(end, dimension) for end in (at[0], at[-1], *limits)]
        yield Notice(path, f"covers {ends[0]} to {ends[1]} only; the travel of axis {axis} is {ends[2]} to {ends[3]}")
    steps = sorted(b - a for a, b in pairwise(at))
    usual = steps[len(steps) // 2]
    for low, high in pairwise(at):
        if len(steps) >= 4 and high - low > 3.5 * usual:
            ends = [units.show(end, dimension) for end in (low, high, usual)]
            yield Notice(path, f"has a gap from {ends[0]} to {ends[1]}; its usual step is {ends[2]}")


def _mm(value: float) -> str:
    return units.show(value, "length")
