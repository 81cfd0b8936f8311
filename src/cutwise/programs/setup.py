"""What a program does not say itself: tools, work offsets, where the tool stands at the start, limits of patience."""

from collections.abc import Callable, Mapping
from typing import Literal, NamedTuple

from cutwise.spec.program import STEP_LIMIT

Triple = tuple[float, float, float]
_AT_ZERO: Triple = (0.0, 0.0, 0.0)


class Tool(NamedTuple):
    """A line of a tool table."""

    number: int
    pocket: int = 0
    offset: tuple[float, ...] = (0.0,) * 9  # X Y Z U V W [m], A B C [rad]; order X Y Z A B C U V W
    diameter: float = 0.0  # [m]; 0: not known
    front_angle: float = 0.0  # [rad]
    back_angle: float = 0.0  # [rad]
    orientation: int = 0
    notice: str = ""


class WorkSystem(NamedTuple):
    """Where a work coordinate system stands in the machine."""

    origin: Triple = _AT_ZERO  # [m]
    rotation: float = 0.0  # about z [rad]


class Setup(NamedTuple):
    """Everything about the machine that a program may rely on; all of it may be left out."""

    tools: Mapping[int, Tool] | None = None  # by number; None: every tool is there, its length contained in z
    systems: Mapping[int, WorkSystem] = {}  # 1 (G54) to 9 (G59.3); the others stand at the machine's zero
    start: Triple | None = None  # [m] of the tool tip in G54; None: its zero
    default_tool: int | None = None  # in the spindle where the program calls none
    inch: bool | None = (
        None  # unit of the machine and its numbered variables; None: that of the program's first unit word
    )
    dialect: Literal["auto", "rs274", "fanuc"] = "auto"  # of G-code; auto: fanuc where a program shows macro B
    library: Callable[[str], str | None] | None = None  # text of a subroutine file by its name without suffix
    step_limit: int = STEP_LIMIT  # steps that are not written out before a program counts as endless
