"""Tool paths written as G-code, APT and robot poses; lengths in mm and feeds in mm/min there.

Paths hold the centre of the ball. G-code and APT name the tip, one ball radius below it along the rod.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MM = 1e3
_PER_MINUTE = 60e3  # m/s to mm/min

POSE_COLUMNS = (
    "path", "x [mm]", "y [mm]", "z [mm]", "xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz", "press_x", "press_y",
    "press_z", "feed [mm/min]",
)  # fmt: skip


WORK_OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")


class SetupFault(ValueError):
    """More set-ups than a control has work offsets, in plain words."""


class Program(NamedTuple):
    """Moves in their order; n of them."""

    name: str
    ball_radius: float  # [m]
    position: FloatArray  # [m] of the ball centre, shape (n, 3)
    axis: FloatArray  # unit, from the ball along the rod, shape (n, 3)
    feed: FloatArray  # [m/s] of the move to here; 0: rapid, shape (n,)
    travel: FloatArray  # unit, along the edge, shape (n, 3)
    press: FloatArray  # unit, into the chamfer, shape (n, 3)
    path: NDArray[np.int64]  # number of the path, from 0, shape (n,)
    spindle_speed: float | None = None  # [rad/s] to the right


def tool_frame(axis: FloatArray) -> FloatArray:
    """Rows x, y, z of a right-handed frame whose z is the rod; the part's own frame where the rod is its z."""
    if abs(axis[2] - 1.0) < 1e-12:
        return np.eye(3)
    across = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = across - (across @ axis) * axis
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(axis, x), axis])


def setups(program: Program) -> list[NDArray[np.int64]]:
    """Moves of each set-up, one for each run of moves on the same tool axis."""
    change = np.linalg.norm(np.diff(program.axis, axis=0), axis=1) > 1e-9
    return np.split(np.arange(len(program.path)), np.flatnonzero(change) + 1)


def gcode(program: Program, *, decimals: int = 4) -> str:
    """G-code of a three-axis machine: tool tip, G21 G90 G94.

    Each tool axis is a set-up of its own, with its own work offset and a stop before it: its coordinates are in a frame
    whose z is the rod (a part turned over, a tilted table or head), and a comment says how that frame stands in the
    part. Rapids from where the tool may be anywhere go along Z first, to a height that is clear of the part.

    Parameters
    ----------
    program : Program
        The moves.
    decimals : int
        Of the millimetre.

    Raises
    ------
    SetupFault
        There are more set-ups than work offsets.
    """
    groups = setups(program)
    if len(groups) > len(WORK_OFFSETS):
        raise SetupFault(
            f"{len(groups)} set-ups are more than the {len(WORK_OFFSETS)} work offsets of a control: write a program for "
            "some of the edges at a time (part.edges), or for one tool.axis"
        )
    lines = ["%", f"(cutwise: {_plain(program.name)})", "(X Y Z of the tool tip, mm and mm/min; ball radius "
             f"{program.ball_radius * _MM:.4f}; call the tool and its length before)", "G21 G90 G17 G94"]  # fmt: skip
    for number, moves in enumerate(groups):
        lines += _setup_head(program, number, moves, len(groups))
        lines += _setup_moves(program, moves, decimals)
    return "\n".join([*lines, "M5", "M30", "%", ""])


def _setup_head(program: Program, number: int, moves: NDArray[np.int64], count: int) -> list[str]:
    """Stop, frame, work offset and spindle of a set-up."""
    axis, offset = program.axis[moves[0]], WORK_OFFSETS[number]
    rod = " ".join(f"{c:.9g}" for c in axis + 0.0)
    lines = [f"(set-up {number + 1} of {count}: {offset}, rod along {rod} of the part)"]
    frame = tool_frame(axis)
    if np.array_equal(frame, np.eye(3)):
        lines.append(f"({offset} is the frame of the part)")
    else:
        shown = "; ".join(" ".join(f"{c:.9f}" for c in row) for row in frame + 0.0)
        lines.append(f"({offset} has the origin of the part, and as x; y; z in the part: {shown})")
    lines.append(offset)
    to_do = [f"set the part up for {offset}"] if number else []
    if program.spindle_speed is None:
        to_do.append("start the spindle to the right, M3: the scenario gives no operation.spindle_speed")
    if to_do:
        lines += ["M5", f"M0 ({', and '.join(to_do)})"]
    if program.spindle_speed is not None:
        lines.append(f"S{program.spindle_speed * 30.0 / np.pi:.0f} M3")
    return lines


def _setup_moves(program: Program, moves: NDArray[np.int64], decimals: int) -> list[str]:
    tips = _tips(program, moves) @ tool_frame(program.axis[moves[0]]).T * _MM
    tips = np.round(tips, decimals) + 0.0  # no -0.0000
    clear = tips[program.feed[moves] == 0.0, 2].max(initial=tips[:, 2].max())
    lines: list[str] = []
    last_feed, path = "", -1
    for place, (i, tip) in enumerate(zip(moves, tips, strict=True)):
        x, y, z = (f"{letter}{value:.{decimals}f}" for letter, value in zip("XYZ", tip, strict=True))
        if program.path[i] != path:
            path = program.path[i]
            lines.append(f"(path {path + 1})")
        if program.feed[i] == 0.0:
            unknown = place == 0 or program.feed[i - 1] == 0.0
            if unknown and (place == 0 or np.abs(tips[place - 1, :2] - tip[:2]).max() > 10.0**-decimals):
                lines += [f"G0 Z{clear:.{decimals}f}", f"G0 {x} {y}"]
            lines.append(f"G0 {x} {y} {z}")
            continue
        feed = f"{program.feed[i] * _PER_MINUTE:.2f}"
        lines.append(f"G1 {x} {y} {z}" + ("" if feed == last_feed else f" F{feed}"))
        last_feed = feed
    return lines


def apt(program: Program) -> str:
    """APT (CL data): GOTO of the tool tip with the tool axis, for five-axis posts; a stop where the axis changes."""
    lines = [f"PARTNO/{_plain(program.name)}", "$$ GOTO gives the tool tip and the tool axis, in the frame of the part",
             "$$ mm and mm/min; RAPID holds for one GOTO", "UNITS/MM",
             f"CUTTER/{2.0 * program.ball_radius * _MM:.4f},{program.ball_radius * _MM:.4f}", "MULTAX/ON"]  # fmt: skip
    tips = _tips(program, np.arange(len(program.position))) * _MM
    last_feed = None
    for number, moves in enumerate(setups(program)):
        if number:
            lines += ["SPINDL/OFF", "STOP", "$$ another tool axis: bring the tool clear round the part before going on"]
        if program.spindle_speed is not None:
            lines.append(f"SPINDL/{program.spindle_speed * 30.0 / np.pi:.0f},RPM,CLW")
        for i in moves:
            if program.feed[i] == 0.0:
                lines.append("RAPID")
            else:
                feed = f"{program.feed[i] * _PER_MINUTE:.2f}"
                if feed != last_feed:
                    lines.append(f"FEDRAT/{feed},MMPM")
                last_feed = feed
            words = (*(tips[i] + 0.0), *(program.axis[i] + 0.0))
            lines.append("GOTO/" + ",".join(f"{value:.6f}" for value in words))
    return "\n".join([*lines, "SPINDL/OFF", "FINI", ""])


def poses_csv(program: Program) -> str:
    """Robot poses of the ball centre: x along the travel, z along the tool (against the rod), y to complete them."""
    speed = program.spindle_speed
    lines = [
        "# position: centre of the ball in the frame of the part [mm]; the tip is one ball radius "
        f"({program.ball_radius * _MM:.4f} mm) further along z of the pose",
        "# xx xy xz, yx yy yz, zx zy zz: axes of the pose in the part; z goes from the rod into the part, x along the travel",
        "# press: direction into the chamfer; feed: of the ball centre on the way to this row [mm/min], 0 is a rapid move",
        "# spindle: " + ("speed not given" if speed is None else f"{speed * 30.0 / np.pi:.0f} rpm to the right (M3)"),
        ",".join(POSE_COLUMNS),
    ]
    for i, (frame, position) in enumerate(zip(pose_frames(program), program.position, strict=True)):
        values = [*(position * _MM), *frame.T.ravel(), *program.press[i], program.feed[i] * _PER_MINUTE]
        lines.append(f"{program.path[i] + 1}," + ",".join(f"{value + 0.0:.9g}" for value in values))
    return "\n".join([*lines, ""])


def pose_frames(program: Program) -> FloatArray:
    """Rotation matrices of the poses, columns x, y, z; shape (n, 3, 3)."""
    z = -program.axis
    x = program.travel - np.einsum("ij,ij->i", program.travel, z)[:, None] * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)


def _tips(program: Program, moves: NDArray[np.int64]) -> FloatArray:
    return program.position[moves] - program.ball_radius * program.axis[moves]


def _plain(text: str) -> str:
    """Text that is safe inside a comment of G-code and a statement of APT: one line, and none of their signs."""
    return "".join(letter if " " <= letter <= "~" and letter not in "()%$;" else "_" for letter in text)
