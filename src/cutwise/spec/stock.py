"""What stands on the table besides the program: stock of other forms than a block, the nominal part, and fixtures."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import Angle, Count, Length, Notice, Number, SmallLength, Spec, Usual
from cutwise.spec.cutter import Cutter
from cutwise.spec.fields import tag
from cutwise.spec.part_block import PartBlock, PartSpring
from cutwise.spec.program import Program, StockBlock

_MODELS = (".step", ".stp", ".stl")


class Cylinder(Spec):
    """A round bar, standing."""

    diameter: Length = Field(description="diameter", examples=["60 mm"], gt=0)
    axis: tuple[Length, Length] = Field(description="x and y of its axis", examples=["[0 mm, 0 mm]"])
    z: tuple[Length, Length] = Field(description="bottom and top", examples=["[-20 mm, 0 mm]"])

    def contradictions(self) -> Iterator[Notice]:
        """A top below the bottom."""
        if self.z[0] >= self.z[1]:
            yield Notice(("z",), "ends before it begins: write the smaller value first")


class StockCylinder(Spec):
    """A round bar as stock."""

    cylinder: Cylinder = Field(
        description="a standing round bar", examples=["{diameter: 60 mm, axis: [0 mm, 0 mm], z: [-20 mm, 0 mm]}"]
    )


class StockFile(Spec):
    """Stock of any form, in the coordinates of the program."""

    beside: ClassVar[tuple[str, ...]] = ("file",)

    file: str = Field(description="STEP or STL file of the raw part, in mm where STL", examples=["raw.step"])

    def contradictions(self) -> Iterator[Notice]:
        """A file of another kind."""
        yield from model_file(("file",), self.file)


class StockRun(Spec):
    """What an earlier run has left."""

    beside: ClassVar[tuple[str, ...]] = ("run",)

    run: str = Field(description="run file whose stock is machined further", examples=["roughing.nc"])


def stock_kind(value: Any) -> str:
    """Which form of stock is written."""
    for name, kind in (("cylinder", StockCylinder), ("file", StockFile), ("run", StockRun)):
        if isinstance(value, kind) or (isinstance(value, dict) and name in value):
            return f"<{name}>"
    return "<block>"


AnyStock = Annotated[
    Annotated[StockBlock, tag("block")]
    | Annotated[StockCylinder, tag("cylinder")]
    | Annotated[StockFile, tag("file")]
    | Annotated[StockRun, tag("run")],
    Discriminator(stock_kind),
]


class FixtureBlock(StockBlock):
    """A clamp or vice jaw as a block, in the coordinates of the program."""


class FixtureFile(StockFile):
    """A clamp or vice of any form, in the coordinates of the program."""


def fixture_kind(value: Any) -> str:
    """Which form of fixture is written."""
    there = isinstance(value, FixtureFile) or (isinstance(value, dict) and "file" in value)
    return "<file>" if there else "<block>"


AnyFixture = Annotated[
    Annotated[FixtureBlock, tag("block")] | Annotated[FixtureFile, tag("file")], Discriminator(fixture_kind)
]


class NominalPart(Spec):
    """The part as it should be: a CAD model, and where its origin lies in the coordinates of the program."""

    beside: ClassVar[tuple[str, ...]] = ("file", "step")

    file: str | None = Field(default=None, description="STEP file of the nominal part", examples=["part.step"])
    step: str | None = Field(default=None, description="the same as file", examples=["part.step"])
    solid: Annotated[Count, Usual(1, 1000)] | None = Field(
        default=None, description="which solid of the file, from 1; left out: the only one", examples=[1], ge=1
    )
    tolerance: Annotated[SmallLength, Usual("1 um", "1 mm")] | None = Field(
        default=None, description="the surface may lie this much too high or too low; left out: no verdict", examples=["50 um"],
        gt=0,
    )  # fmt: skip
    origin: tuple[Length, Length, Length] = Field(
        default=(0.0, 0.0, 0.0),
        description="where the origin of the CAD model lies in the program",
        examples=["[0 mm, 0 mm, 0 mm]"],
    )
    rotation: tuple[Angle, Angle, Angle] = Field(
        default=(0.0, 0.0, 0.0), description="roll, pitch and yaw of the CAD model about the program axes, before it is shifted",
        examples=["[0 deg, 0 deg, 0 deg]"],
    )  # fmt: skip
    samples: Annotated[Count, Usual(1_000, 10_000_000)] = Field(
        default=1_000_000,
        description="points of its surface at which the deviation is taken",
        examples=[100_000],
        ge=100,
    )

    @property
    def model(self) -> str:
        """The file."""
        return self.file or self.step or ""

    def contradictions(self) -> Iterator[Notice]:
        """One file."""
        if (self.file is None) == (self.step is None):
            yield Notice(("file",), "write one file of the nominal part, for example file: part.step")
        elif not self.model.lower().endswith((".step", ".stp")):
            yield Notice(
                ("file",), f"{self.model} is no STEP file (.step, .stp): the deviation is taken from exact surfaces"
            )


def part_kind(value: Any) -> str:
    """Which kind of part is written: one that yields, or the nominal one."""
    written = value if isinstance(value, dict) else {}
    if isinstance(value, NominalPart) or {"file", "step", "tolerance"} & set(written):
        return "<nominal>"
    return "<spring>" if isinstance(value, PartSpring) or "stiffness" in written else "<block>"


AnyPart = Annotated[
    Annotated[PartBlock, tag("block")] | Annotated[PartSpring, tag("spring")] | Annotated[NominalPart, tag("nominal")],
    Discriminator(part_kind),
]


class SetUp(Spec):
    """One clamping of the part: the program that is run, and how its axes lie in the part."""

    program: Program = Field(description="the program: G-code, or APT", examples=["top.nc"])
    axis: tuple[Number, Number, Number] = Field(
        default=(0.0, 0.0, 1.0), description="direction to the spindle in the part; x of the program is x of the part across it "
        "(y where that is the axis)", examples=["[0, 1, 0]"],
    )  # fmt: skip
    zero: tuple[Length, Length, Length] = Field(
        default=(0.0, 0.0, 0.0), description="zero of the program in the part", examples=["[0 mm, 0 mm, 0 mm]"]
    )
    rotation: Angle = Field(
        default=0.0, description="angle by which the program is turned about the axis", examples=["0 deg"]
    )
    tools: tuple[Cutter, ...] = Field(
        default=(), description="tools of this set-up; left out: those of all",
        examples=["[{number: 1, shape: flat, diameter: 10 mm, flutes: 3, helix: 30 deg}]"],
    )  # fmt: skip
    fixtures: tuple[AnyFixture, ...] = Field(
        default=(), description="clamps and jaws of this set-up, in the coordinates of its program",
        examples=["[{x: [-30 mm, -5 mm], y: [0 mm, 20 mm], z: [-20 mm, 10 mm]}]"],
    )  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """No direction; tools twice."""
        if not any(self.axis):
            yield Notice(("axis",), "is zero; write the direction to the spindle in the part, for example [0, 0, 1]")
        numbers = [tool.number for tool in self.tools]
        for number in sorted({n for n in numbers if numbers.count(n) > 1}):
            yield Notice(("tools",), f"tool {number} is there twice")


class StockNumerics(Spec):
    """How a stock in 3D is computed."""

    grid: Length | Literal["auto"] = Field(
        default="auto", description="width of a cell of the height map, or auto: a quarter of the smallest tool radius, at most a "
        "hundredth of the shorter side of the stock", examples=["0.25 mm"],
    )  # fmt: skip
    engagement: Literal["none", "coarse", "refined"] = Field(
        default="refined", description="contact along the program: none (the surface alone), coarse (to 5.6°), refined (exact)",
        examples=["refined"],
    )  # fmt: skip
    sweep: Literal["real", "ideal"] = Field(
        default="real", description="which way of the tool makes the surface: real (as drives, the bending of the tool, bodies of "
        "the machine and a robot have it, where there are any) or ideal (as planned)", examples=["real"],
    )  # fmt: skip
    elements: Annotated[Count, Usual(4, 100)] = Field(
        default=12, description="elements of the cutting edges below the cylinder", examples=[12], ge=1, le=1000
    )
    station: Annotated[Length, Usual("0.05 mm", "10 mm")] = Field(
        default=0.5e-3,
        description="largest distance of the places of a move that are looked at",
        examples=["0.5 mm"],
        gt=0,
    )
    check: Count = Field(
        default=10_000,
        description="random points at which the surface is held against all moves",
        examples=[10_000],
        ge=0,
    )
    memory_limit: Annotated[Count, Usual(50, 100_000)] = Field(
        default=500, description="memory that map, moves and samples may take [MB]", examples=[500], ge=1
    )

    def contradictions(self) -> Iterator[Notice]:
        """A grid that is nothing."""
        if not isinstance(self.grid, str) and self.grid <= 0.0:
            yield Notice(("grid",), "is not positive; write a width of the cells, or auto")


def model_file(path: tuple[str, ...], name: str) -> Iterator[Notice]:
    """A file that is no CAD model."""
    if not name.lower().endswith(_MODELS):
        yield Notice(path, f"{name} is neither STEP nor STL (.step, .stp, .stl)")
