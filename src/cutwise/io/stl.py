"""STL files: triangles in, triangles out."""

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cutwise.io.occ import MM, CadFault

FloatArray = npt.NDArray[np.float64]

_RECORD = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84
_VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)
_SAME = 1e-4  # [mm] corners that are one


def read_stl(path: str | Path) -> FloatArray:
    """Corners of the triangles of an STL file in mm, shape (n, 3, 3) [m]; the surface must be closed.

    Raises
    ------
    CadFault
        It cannot be read, holds no triangles, is cut short, or is not closed.
    """
    path = Path(path)
    try:
        raw = path.read_bytes()
    except OSError as fault:
        raise CadFault(f"{path}: cannot be read ({fault.strerror})") from None
    corner = _binary(raw) if _is_binary(raw) else _text(raw)
    if corner is None or not len(corner):
        raise CadFault(f"{path.name}: no STL file, or one without triangles (is it cut short?)")
    if not np.isfinite(corner).all():
        raise CadFault(f"{path.name}: has coordinates that are no numbers")
    if gaps := open_edges(corner):
        raise CadFault(
            f"{path.name}: is not closed: {gaps} edges do not lie between two triangles of the same sense; mend it, or export "
            "it again as a solid"
        )
    return corner * MM


def _is_binary(raw: bytes) -> bool:
    if len(raw) < _HEADER:
        return False
    count = int.from_bytes(raw[80:84], "little")
    return len(raw) == _HEADER + count * _RECORD.itemsize or not raw.lstrip().lower().startswith(b"solid")


def _binary(raw: bytes) -> FloatArray | None:
    count = int.from_bytes(raw[80:84], "little")
    if len(raw) < _HEADER + count * _RECORD.itemsize:
        return None
    return np.asarray(np.frombuffer(raw, _RECORD, count, _HEADER)["corner"], float)


def _text(raw: bytes) -> FloatArray | None:
    found = _VERTEX.findall(raw)
    if not found or len(found) % 3:
        return None
    try:
        return np.array([[float(number) for number in vertex] for vertex in found]).reshape(-1, 3, 3)
    except ValueError:
        return None


def open_edges(corner: FloatArray) -> int:
    """Edges that do not lie between two triangles that run through them in opposite senses; corners in mm."""
    _, name = np.unique(np.round(corner.reshape(-1, 3) / _SAME).astype(np.int64), axis=0, return_inverse=True)
    triangle = np.asarray(name).reshape(-1, 3)
    triangle = triangle[(triangle != np.roll(triangle, 1, axis=1)).all(axis=1)]
    start, end = triangle.reshape(-1), np.roll(triangle, -1, axis=1).reshape(-1)
    most = int(triangle.max()) + 1 if triangle.size else 1
    there, count = np.unique(start * most + end, return_counts=True)
    back, counted = np.unique(end * most + start, return_counts=True)
    if there.size == back.size and (there == back).all():
        return int((count != counted).sum()) // 2  # an edge is met in both senses
    return int(np.setxor1d(there, back).size) // 2


def stl_bytes(corner: FloatArray) -> bytes:
    """A binary STL file of triangles [m], in mm."""
    triangles = np.asarray(corner, float) / MM
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    table = np.zeros(len(triangles), _RECORD)
    table["normal"] = normal / np.where(length > 0.0, length, 1.0)
    table["corner"] = triangles
    return b"cutwise".ljust(80) + len(triangles).to_bytes(4, "little") + table.tobytes()
