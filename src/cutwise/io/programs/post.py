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


def tool_frame(axis: FloatArray) -> FloatArray:
    """Rows x, y, z of a right-handed frame whose z is the rod; the part's own frame where the rod is its z."""
    if abs(axis[2] - 1.0) < 1e-12:
        return np.eye(3)
    across = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = across - (across @ axis) * axis
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(axis, x), axis])


def gcode(program: Program, *, decimals: int = 4) -> str:
    """G-code of a three-axis machine: tool tip, G21 G90 G94.

    Where the rod is not the z axis of the part, the coordinates of that path are in a frame whose z is the rod (a
    tilted table or head); the comment before it says how that frame stands in the part.

    Parameters
    ----------
    program : Program
        The moves.
    decimals : int
        Of the millimetre.
    """
    lines = ["%", f"(cutwise: {_plain(program.name)})", "(X Y Z of the tool tip, mm and mm/min; tool radius "
             f"{program.ball_radius * _MM:.4f})", "G21 G90 G17 G94"]  # fmt: skip
    last_feed = None
    for moves in np.split(np.arange(len(program.path)), np.flatnonzero(np.diff(program.path)) + 1):
        frame = tool_frame(program.axis[moves[0]])
        lines.append(f"(path {program.path[moves[0]] + 1})")
        if not np.array_equal(frame, np.eye(3)):
            shown = "; ".join(" ".join(f"{c:.9f}" for c in row) for row in frame)
            lines.append(f"(frame of this path, rows x; y; z in the part: {shown})")
        tips = _tips(program, moves) @ frame.T * _MM
        for i, tip in zip(moves, tips, strict=True):
            words = " ".join(f"{letter}{value:.{decimals}f}" for letter, value in zip("XYZ", tip + 0.0, strict=True))
            if program.feed[i] == 0.0:
                lines.append(f"G0 {words}")
                continue
            feed = f"{program.feed[i] * _PER_MINUTE:.2f}"
            lines.append(f"G1 {words}" + ("" if feed == last_feed else f" F{feed}"))
            last_feed = feed
    return "\n".join([*lines, "M30", "%", ""])


def apt(program: Program) -> str:
    """APT (CL data): GOTO of the tool tip with the tool axis, for five-axis posts."""
    lines = [f"PARTNO/{_plain(program.name)}", "UNITS/MM", f"CUTTER/{2.0 * program.ball_radius * _MM:.4f},"
             f"{program.ball_radius * _MM:.4f}", "MULTAX/ON"]  # fmt: skip
    tips = _tips(program, np.arange(len(program.position))) * _MM
    last_feed = None
    for i, tip in enumerate(tips):
        if program.feed[i] == 0.0:
            lines.append("RAPID")
        else:
            feed = f"{program.feed[i] * _PER_MINUTE:.2f}"
            if feed != last_feed:
                lines.append(f"FEDRAT/{feed},MMPM")
            last_feed = feed
        lines.append("GOTO/" + ",".join(f"{value:.6f}" for value in (*(tip + 0.0), *(program.axis[i] + 0.0))))
    return "\n".join([*lines, "FINI", ""])


def poses_csv(program: Program) -> str:
    """Robot poses of the ball centre: x along the travel, z along the tool (against the rod), y to complete them."""
    lines = [",".join(POSE_COLUMNS)]
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
    """Text that is safe inside a comment of G-code."""
    return "".join(letter if letter.isascii() and letter not in "()%\n" else "_" for letter in text)
