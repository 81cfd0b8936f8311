"""A program of a CNC machine, what is given to it, how it runs through its corners, and the stock that it cuts."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field

from cutwise.spec.base import Angle, Count, Length, Notice, Spec
from cutwise.spec.fields import tag

WORK_SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
STEP_LIMIT = 500_000
"""Steps that a program may take without writing them out: lines run again, repeats, pecks, turns."""


class ProgramTool(Spec):
    """A tool that a program calls by its number."""

    number: Count = Field(description="number of the tool (T)", examples=[1], ge=1)
    diameter: Length | None = Field(
        default=None, description="diameter, for cutter compensation (G41, G42)", examples=["10 mm"], ge=0
    )
    x: Length = Field(default=0.0, description="tool offset in x (G43)", examples=["0 mm"])
    y: Length = Field(default=0.0, description="tool offset in y (G43)", examples=["0 mm"])
    z: Length = Field(default=0.0, description="tool length (G43)", examples=["80 mm"])


class WorkOffset(Spec):
    """Where a work coordinate system stands in the machine."""

    x: Length = Field(default=0.0, description="x of its origin in the machine", examples=["100 mm"])
    y: Length = Field(default=0.0, description="y of its origin in the machine", examples=["50 mm"])
    z: Length = Field(default=0.0, description="z of its origin in the machine", examples=["-200 mm"])
    rotation: Angle = Field(default=0.0, description="rotation about z", examples=["0 deg"])


class StartPosition(Spec):
    """Where the tool tip stands before the program, in G54."""

    x: Length = Field(description="x of the tool tip", examples=["0 mm"])
    y: Length = Field(description="y of the tool tip", examples=["0 mm"])
    z: Length = Field(description="z of the tool tip", examples=["50 mm"])


class Program(Spec):
    """An NC program: G-code, or APT cutter location data."""

    many_lines: ClassVar[tuple[str, ...]] = ("text", "subroutines")

    file: str = Field(description="the program: G-code, or APT (.apt, .cls)", examples=["pocket.nc"])
    text: str = Field(
        default="", description="the text of the program (read from the file)", examples=["G21 G90 G1 X10 F600"]
    )
    dialect: Literal["auto", "rs274", "fanuc"] = Field(
        default="auto", description="dialect of G-code: rs274 (LinuxCNC), fanuc (with macro B), or auto: fanuc where the "
        "program shows macro B, which is said, and rs274 elsewhere", examples=["fanuc"],
    )  # fmt: skip
    subroutines: dict[str, str] | None = Field(
        default=None, description="texts of the subroutine files that the program calls (read from beside it)",
        examples=["{}"],
    )  # fmt: skip
    tools: tuple[ProgramTool, ...] | None = Field(
        default=None, description="tools that the program calls, a list or a tool table file; left out: every tool is there",
        examples=["[{number: 2, diameter: 10 mm, z: 62 mm}]"],
    )  # fmt: skip
    offsets: dict[str, WorkOffset] | None = Field(
        default=None, description="where work coordinate systems (G54 to G59.3) stand in the machine; left out: at its zero",
        examples=["{G55: {x: 100 mm}}"],
    )  # fmt: skip
    start: StartPosition | None = Field(
        default=None, description="where the tool tip stands before the program; left out: at the machine's zero"
    )
    top: Length = Field(
        default=0.0, description="top of the material in the program: feed moves below it cut (a stock has its own)",
        examples=["0 mm"],
    )  # fmt: skip
    default_tool: Count | None = Field(
        default=None, description="number of the tool in the spindle before the program calls one", examples=[1], ge=1
    )

    step_limit: Count = Field(
        default=STEP_LIMIT, description="steps that the program may take without writing them out (lines run again, "
        "repeats and pecks of cycles, turns of arcs) before it counts as endless", examples=[2_000_000], ge=1,
    )  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """Work coordinate systems that do not exist; a tool twice; a default tool that is not there."""
        for name in self.offsets or ():
            if name not in WORK_SYSTEMS:
                yield Notice(
                    ("offsets",), f'"{name}" is not a work coordinate system; they are {", ".join(WORK_SYSTEMS)}'
                )
        numbers = [tool.number for tool in self.tools or ()]
        for number in sorted({n for n in numbers if numbers.count(n) > 1}):
            yield Notice(("tools",), f"tool {number} is there twice")
        if self.default_tool is not None and numbers and self.default_tool not in numbers:
            yield Notice(("default_tool",), f"tool {self.default_tool} is not among the tools")


class WantedPath(Spec):
    """The program before its path was corrected."""

    many_lines: ClassVar[tuple[str, ...]] = ("text",)

    file: str = Field(description="the program whose path the part is meant to have", examples=["pocket.nc"])
    text: str = Field(
        default="", description="the text of that program (read from the file)", examples=["G21 G90 G1 X10 F600"]
    )


class MilledProgram(Program):
    """An NC program that drives follow, and the path that it was corrected from."""

    wanted: WantedPath | None = Field(
        default=None, description="of a program with a corrected path: the program before, whose path the part is meant to "
        "have; errors and contact count from it", examples=["pocket.nc"],
    )  # fmt: skip


class Blend(Spec):
    """Corners rounded within a tolerance."""

    blend: Length = Field(description="largest distance from the programmed corner", examples=["0.02 mm"], gt=0)
    shape: Literal["arc", "clothoid"] = Field(
        default="arc",
        description="arc, at whose ends the normal acceleration jumps, or two clothoids, which keep the jerk limit (between lines)",
        examples=["clothoid"],
    )


def _mode_kind(value: Any) -> str:
    return "<blend>" if isinstance(value, dict | Blend) else "<mode>"


PathMode = Annotated[
    Annotated[Literal["exact_path", "exact_stop"], tag("mode")] | Annotated[Blend, tag("blend")],
    Discriminator(_mode_kind),
]


class StockBlock(Spec):
    """A rectangular block before the first move, in the coordinates of the program."""

    x: tuple[Length, Length] = Field(description="least and greatest x", examples=["[-10 mm, 110 mm]"])
    y: tuple[Length, Length] = Field(description="least and greatest y", examples=["[-10 mm, 70 mm]"])
    z: tuple[Length, Length] = Field(description="bottom and top", examples=["[-20 mm, 0 mm]"])

    def contradictions(self) -> Iterator[Notice]:
        """Sides that run backwards."""
        for side in ("x", "y", "z"):
            low, high = getattr(self, side)
            if low >= high:
                yield Notice((side,), "ends before it begins: write the smaller value first")


def top_of(program: Program, stock: StockBlock | None) -> float:
    """Top of the material [m]: that of the stock, or what the program is given."""
    return program.top if stock is None else stock.z[1]
