"""Robot programs: KUKA KRL and ABB RAPID, with tool and frame data. Lengths in mm, angles in degrees there."""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.programs.written_moves import plain

FloatArray = NDArray[np.float64]

_MM = 1e3
_LEVEL = 1e-12  # square of the cosine of B below which A and C are not told apart
_FREE = "9E9,9E9,9E9,9E9,9E9,9E9"  # no external axes


class Frame(NamedTuple):
    """A frame seen from another."""

    origin: FloatArray  # [m], shape (3,)
    rotation: FloatArray  # its axes as columns, shape (3, 3)


class RobotMove(NamedTuple):
    """One move of the tool."""

    pose: Frame  # of the tool in the work frame
    joints: FloatArray  # angles of the motors there [rad], shape (6,)
    speed: float  # along the path [m/s]; 0: a move of the joints to here
    exact: bool  # the tool passes through here: a hole, an entry, an end
    turn: int = 0  # cfx of ABB, which of the eight postures


class RobotProgram(NamedTuple):
    """A program of a robot."""

    name: str
    tool: Frame  # seen from the flange
    work: Frame  # seen from the base of the robot
    moves: Sequence[RobotMove]
    blend: float  # [m] within which corners that are not exact may be cut
    comments: Sequence[str] = ()


def abc_of(rotation: FloatArray) -> tuple[float, float, float]:
    r"""Angles A, B, C [degree] of axes as columns, :math:`R = R_z(A) R_y(B) R_x(C)`.

    .. math:: A = \operatorname{atan2}(r_{21}, r_{11}), \quad B = \operatorname{atan2}(-r_{31}, \sqrt{r_{11}^2 + r_{21}^2}),
              \quad C = \operatorname{atan2}(r_{32}, r_{33})

    With B at a right angle A and C turn about one line: A is 0 then, :math:`C = \operatorname{atan2}(-r_{23}, r_{22})`.

    Examples
    --------
    >>> from cutwise.maths.frames import rotation_from_rpy
    >>> [round(angle, 9) for angle in abc_of(rotation_from_rpy(*np.radians([-20.0, 90.0, 15.0])))]
    [0.0, 90.0, -35.0]
    """
    r = rotation
    level = r[0, 0] ** 2 + r[1, 0] ** 2
    b = math.atan2(-r[2, 0], math.sqrt(level))
    if level < _LEVEL:
        return 0.0, math.degrees(b), math.degrees(math.atan2(-r[1, 2], r[1, 1]))
    return math.degrees(math.atan2(r[1, 0], r[0, 0])), math.degrees(b), math.degrees(math.atan2(r[2, 1], r[2, 2]))


def quaternion_of(rotation: FloatArray) -> FloatArray:
    """Unit quaternion of axes as columns, scalar first and not negative; if it is 0, the first other part is positive.

    Examples
    --------
    >>> from cutwise.maths.frames import rotation_from_rpy
    >>> quaternion_of(rotation_from_rpy(*np.radians([180.0, 0.0, 26.0]))).round(6).tolist()
    [0.0, 0.97437, 0.224951, 0.0]
    """
    r = rotation
    squares = np.array([
        1.0 + r[0, 0] + r[1, 1] + r[2, 2], 1.0 + r[0, 0] - r[1, 1] - r[2, 2],
        1.0 - r[0, 0] + r[1, 1] - r[2, 2], 1.0 - r[0, 0] - r[1, 1] + r[2, 2],
    ])  # fmt: skip
    k = int(np.argmax(squares))
    rows = np.array([
        [squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
        [r[2, 1] - r[1, 2], squares[1], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
        [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], squares[2], r[1, 2] + r[2, 1]],
        [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], squares[3]],
    ])  # fmt: skip
    q = rows[k] / np.linalg.norm(rows[k])
    q = np.where(np.abs(q) < 1e-15, 0.0, q)
    first = q[np.flatnonzero(q)[0]]
    return np.asarray(q if first > 0.0 else -q) + 0.0


def quarters(angle: float) -> int:
    """Quarter turn in which an axis stands: 0 from 0 to 90 degrees, -1 from -90 to 0 [rad in].

    >>> [quarters(math.radians(x)) for x in (10.0, 100.0, -10.0, -130.0)]
    [0, 1, -1, -2]
    """
    return math.floor(math.degrees(angle) / 90.0)


def krl(program: RobotProgram, *, decimals: int = 4) -> str:
    """A program in the KUKA robot language, one file with its data.

    The approach of every hole is a move of the axes (PTP), since LIN carries no branch; exact places are not approximated.
    """
    name = identifier(program.name, 24)
    lines = [f"DEF {name} ( )", *(f"; {plain(text)}" for text in program.comments),
             f"$BASE = {_krl_frame(program.work, decimals)}", f"$TOOL = {_krl_frame(program.tool, decimals)}",
             f"$APO.CDIS = {program.blend * _MM:.{decimals}f}"]  # fmt: skip
    speed = ""
    for move in program.moves:
        if move.speed == 0.0:
            angles = ",".join(
                f"A{k} {math.degrees(angle) + 0.0:.{decimals}f}" for k, angle in enumerate(move.joints, 1)
            )
            lines.append(f"PTP {{{angles}}}")
            continue
        if (wanted := f"$VEL.CP = {move.speed:.6f}") != speed:
            speed = wanted
            lines.append(wanted)
        lines.append(f"LIN {_krl_frame(move.pose, decimals)}{'' if move.exact else ' C_DIS'}")
    return "\n".join([*lines, "END", ""])


def _krl_frame(frame: Frame, decimals: int) -> str:
    values = [*(frame.origin * _MM), *abc_of(frame.rotation)]
    parts = (f"{letter} {_fixed(value, decimals)}" for letter, value in zip("XYZABC", values, strict=True))
    return f"{{{','.join(parts)}}}"


def rapid(program: RobotProgram, *, decimals: int = 4) -> str:
    """A module in the ABB language RAPID, with tool and work object."""
    name = identifier(program.name, 32)
    lines = [f"MODULE {name}", *(f"  ! {plain(text)}" for text in program.comments),
             f"  PERS tooldata tCut := [TRUE,{_rapid_frame(program.tool, decimals)},[1,[0,0,1],[1,0,0,0],0,0,0]];",
             f'  PERS wobjdata wPart := [FALSE,TRUE,"",{_rapid_frame(program.work, decimals)},[[0,0,0],[1,0,0,0]]];',
             "  PROC main()"]  # fmt: skip
    for move in program.moves:
        if move.speed == 0.0:
            angles = ",".join(_fixed(math.degrees(angle), decimals) for angle in move.joints)
            lines.append(f"    MoveAbsJ [[{angles}],[{_FREE}]],v100,fine,tCut\\WObj:=wPart;")
            continue
        quarter = ",".join(str(quarters(float(move.joints[k]))) for k in (0, 3, 5))
        target = f"[{_rapid_frame(move.pose, decimals)[1:-1]},[{quarter},{move.turn}],[{_FREE}]]"
        speed = f"[{_fixed(move.speed * _MM, 3)},500,5000,1000]"
        zone = "fine" if move.exact else f"[FALSE,{','.join([f'{program.blend * _MM:.3f}'] * 3)},1,1,1]"
        lines.append(f"    MoveL {target},{speed},{zone},tCut\\WObj:=wPart;")
    return "\n".join([*lines, "  ENDPROC", "ENDMODULE", ""])


def _rapid_frame(frame: Frame, decimals: int) -> str:
    place = ",".join(_fixed(value, decimals) for value in frame.origin * _MM)
    turn = ",".join(f"{value + 0.0:.10f}" for value in quaternion_of(frame.rotation))
    return f"[[{place}],[{turn}]]"


def _fixed(value: float, decimals: int) -> str:
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def identifier(name: str, longest: int) -> str:
    """A name that a robot language takes: letters, digits and underscores, a letter first.

    >>> identifier("drill\\n2 holes", 24)
    'drill_2_holes'
    """
    kept = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return (kept if kept[:1].isalpha() else f"p_{kept}")[:longest]
