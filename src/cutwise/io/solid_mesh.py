"""Triangles of the solids of a STEP file, all of them or one, with their normals outward."""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cutwise.io.occ import MM, CadFault, explored, occ
from cutwise.io.step import StepPart, read_step

FloatArray = npt.NDArray[np.float64]

_TURN = 0.3  # [rad] largest angle between neighbouring triangles


def solid_of(part: StepPart, number: int | None) -> Any:
    """One solid of a part, from 1; left out: the only one.

    Raises
    ------
    CadFault
        There is no solid, no such solid, several where none is chosen, or it is open.
    """
    solids = explored(part.shape, occ("TopAbs").TopAbs_ShapeEnum.TopAbs_SOLID)
    if not solids:
        raise CadFault(f"{part.name}: has no solid (faces alone do not tell what is material); export it as a solid")
    if number is None and len(solids) > 1:
        raise CadFault(f"{part.name}: has {len(solids)} solids; write which, solid: 1 to {len(solids)}")
    if number is not None and number > len(solids):
        raise CadFault(f"{part.name}: has no solid {number}; it has {len(solids)}")
    solid = solids[(number or 1) - 1]
    if part.open_shells:
        raise CadFault(
            f"{part.name}: has {part.open_shells} open shell(s): what is material is not known; mend the model"
        )
    return solid


def meshed(shape: Any, chord: float) -> None:
    """Let a shape have triangles, with a distance of chords [m]."""
    occ("BRepMesh").BRepMesh_IncrementalMesh(shape, chord / MM, False, _TURN, False)


def face_triangles(face: Any) -> tuple[FloatArray, npt.NDArray[np.int64], FloatArray | None]:
    """Nodes [m], corners of the triangles, and parameters of the nodes of a face that has been meshed."""
    place = occ("TopLoc").TopLoc_Location()
    mesh = occ("BRep").BRep_Tool.Triangulation_s(face, place)
    if mesh is None:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64), None
    points = [mesh.Node(i) for i in range(1, mesh.NbNodes() + 1)]
    if not place.IsIdentity():
        moved = place.Transformation()
        points = [p.Transformed(moved) for p in points]
    node = np.array([(p.X(), p.Y(), p.Z()) for p in points]).reshape(-1, 3) * MM
    index = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)], np.int64).reshape(-1, 3) - 1
    if face.Orientation() == occ("TopAbs").TopAbs_Orientation.TopAbs_REVERSED:
        index = index[:, ::-1].copy()
    parameter = None
    if mesh.HasUVNodes():
        parameter = np.array([(p.X(), p.Y()) for p in map(mesh.UVNode, range(1, len(node) + 1))])
    return node, index, parameter


def solid_triangles(file: str | Path, number: int | None, chord: float) -> FloatArray:
    """Corners of the triangles of the solids of a STEP file [m], shape (n, 3, 3).

    Raises
    ------
    CadFault
        The file or its solid cannot be used.
    """
    part = read_step(file)
    shape = part.shape  # all solids, together
    if number is not None or part.solids < 2 or part.open_shells:
        shape = solid_of(part, number or 1)
    meshed(shape, chord)
    found = [np.zeros((0, 3, 3))]
    for face in explored(shape, occ("TopAbs").TopAbs_ShapeEnum.TopAbs_FACE):
        node, index, _ = face_triangles(face)
        found.append(node[index])
    return np.concatenate(found)
