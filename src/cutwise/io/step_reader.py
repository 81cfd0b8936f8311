"""The process in which STEP files are read: whatever OpenCascade does to it, the program that asked lives on.

Run by :mod:`cutwise.io.step_process` as ``python -c "from cutwise.io.step_reader import serve; serve()"``: one request
a line on the standard input, one answer a line on what was the standard output. A shape comes back as a file in the
binary format of OpenCascade, which holds every number as it is.
"""

import json
import math
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cutwise.io.occ import CadFault, explored, occ

LARGEST = 1e6  # [mm] of a part

# What the parent may be asked for is limited in the child: a damaged file can make OpenCascade run or grow for ever.
SECONDS, SECONDS_PER_MB = 15.0, 10.0  # of CPU
_BYTES, _BYTES_PER_BYTE = 800_000_000, 100  # of memory


def serve() -> None:
    """Answer requests until the standard input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for descriptor in (1, 2):  # C++ libraries print there
        os.dup2(nowhere, descriptor)
    for line in sys.stdin:
        request = json.loads(line)
        try:
            limited(os.path.getsize(request["file"]))
            answer = read(request["file"], request["shape"], frozenset(request["places"]))
        except CadFault as fault:
            answer = {"fault": str(fault)}
        except Exception as fault:  # the errors of OpenCascade have no common base
            answer = {"fault": f"it cannot be translated ({type(fault).__name__})"}
        print(json.dumps(answer), file=answers, flush=True)


def allowed(size: int) -> float:
    """CPU time that reading a file of some bytes may take [s]."""
    return SECONDS + SECONDS_PER_MB * size / 1e6


def limited(size: int) -> None:
    """Let this process end when it computes or grows beyond what a file of some bytes needs; POSIX only."""
    if os.name != "posix":
        return
    import resource  # not there on Windows
    import signal

    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, allowed(size))
    most = _BYTES + _BYTES_PER_BYTE * size
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if hard == resource.RLIM_INFINITY or most < hard:
        resource.setrlimit(resource.RLIMIT_DATA, (most, hard))


def read(file: str, shape_file: str, places: frozenset[int]) -> dict[str, Any]:
    """Read a STEP file, translate it, try its faces and edges, and write the shape.

    Parameters
    ----------
    file, shape_file : str
        The STEP file, and where the shape is to be written.
    places : set of int
        Instances of the data section, counted from 0, that the shapes are made of.

    Returns
    -------
    dict
        ``types``: parameters that are not what the standard asks for, as pairs of instance and words; else nothing.

    Raises
    ------
    CadFault
        What cannot be read or translated.
    """
    reader = occ("STEPControl").STEPControl_Reader()
    if reader.ReadFile(file) != occ("IFSelect").IFSelect_RetDone:  # asking such a reader for its roots would crash
        raise CadFault("not a readable STEP file (damaged or cut short)")
    types = [(place, said) for place, said in _type_faults(reader) if place in places]
    if types:
        return {"types": types}
    if reader.NbRootsForTransfer() < 1:
        raise CadFault("a STEP file without geometry: it has a header and no shapes")
    reader.TransferRoots()
    shape = reader.OneShape()
    if shape is None or shape.IsNull():
        raise CadFault("its shapes could not be translated; export it as AP203, AP214 or AP242 solids")
    _check_size(shape)
    shape = _placed(shape)
    _try_faces_and_edges(shape)
    tools = occ("BinTools").BinTools
    if not tools.Write_s(shape, shape_file):
        raise CadFault(f"its shape could not be handed over through {Path(shape_file).parent} (is the disk full?)")
    return {}


def _type_faults(reader: Any) -> Iterator[tuple[int, str]]:
    """What OpenCascade finds wrong with the parameters of statements: too few of them, or of another type."""
    checks = reader.WS().ModelCheckList(False)
    checks.Start()
    while checks.More():
        check = checks.Value()
        for i in range(1, check.NbFails() + 1):
            yield checks.Number() - 1, str(check.CFail(i))
        checks.Next()


def _placed(shape: Any) -> Any:
    """The shape with bodies that are placed mirrored or scaled worked out, each with geometry of its own.

    A placement (CARTESIAN_TRANSFORMATION_OPERATOR) may turn a body inside out or change its size; left as a placement,
    the normals of a mirrored body point inward and parameters of a scaled one are not lengths.
    """
    kinds = occ("TopAbs").TopAbs_ShapeEnum
    ladder = (kinds.TopAbs_SOLID, kinds.TopAbs_SHELL, kinds.TopAbs_FACE, kinds.TopAbs_WIRE, kinds.TopAbs_EDGE)
    bodies = []
    for kind, outer in zip(ladder, (kinds.TopAbs_SHAPE, *ladder[:-1]), strict=True):
        explorer = occ("TopExp").TopExp_Explorer(shape, kind, outer)
        while explorer.More():
            bodies.append(explorer.Current())
            explorer.Next()
    if not any(_distorts(body.Location().Transformation()) for body in bodies):
        return shape
    whole, builder = occ("TopoDS").TopoDS_Compound(), occ("BRep").BRep_Builder()
    builder.MakeCompound(whole)
    for body in bodies:
        trsf = body.Location().Transformation()
        if _distorts(trsf):
            plain = body.Located(occ("TopLoc").TopLoc_Location())
            body = occ("BRepBuilderAPI").BRepBuilderAPI_Transform(plain, trsf, True).Shape()
        builder.Add(whole, body)
    return whole


def _distorts(trsf: Any) -> bool:
    return bool(trsf.IsNegative()) or abs(trsf.ScaleFactor() - 1.0) > 1e-9


def _check_size(shape: Any) -> None:
    box = occ("Bnd").Bnd_Box()
    occ("BRepBndLib").BRepBndLib.Add_s(shape, box, False)
    if box.IsVoid():
        return
    low, high = box.CornerMin(), box.CornerMax()
    ends = [low.X(), low.Y(), low.Z(), high.X(), high.Y(), high.Z()]
    if not all(map(math.isfinite, ends)) or max(map(abs, ends)) > LARGEST:
        raise CadFault(f"the part reaches farther than {LARGEST * 1e-6:g} km: check the unit of the file")


def _try_faces_and_edges(shape: Any) -> None:
    """Ask everything of every face and edge that is asked of them later: what ends a process shall end this one."""
    kinds, gp, adaptors = occ("TopAbs").TopAbs_ShapeEnum, occ("gp"), occ("BRepAdaptor")
    tool = occ("BRep").BRep_Tool
    for number, face in enumerate(explored(shape, kinds.TopAbs_FACE), start=1):
        if tool.Surface_s(face) is None:
            raise CadFault(f"face {number} of its shape has no surface: the file is damaged")
        surface = adaptors.BRepAdaptor_Surface(face)
        ends = surface.FirstUParameter(), surface.LastUParameter(), surface.FirstVParameter(), surface.LastVParameter()
        if not all(map(math.isfinite, ends)):
            raise CadFault(f"face {number} of its shape has no ends: the file is damaged")
        p, du, dv = gp.gp_Pnt(), gp.gp_Vec(), gp.gp_Vec()
        for s in (0.21, 0.57):
            surface.D1(_between(*ends[:2], s), _between(*ends[2:], s), p, du, dv)
        for edge in explored(face, kinds.TopAbs_EDGE):
            if not tool.Degenerated_s(edge):
                flat = adaptors.BRepAdaptor_Curve2d(edge, face)
                flat.Value(flat.FirstParameter()), flat.Value(flat.LastParameter())
    for number, edge in enumerate(explored(shape, kinds.TopAbs_EDGE), start=1):
        if tool.Degenerated_s(edge):
            continue
        curve = adaptors.BRepAdaptor_Curve(edge)
        first, last = curve.FirstParameter(), curve.LastParameter()
        if not all(math.isfinite(end) and abs(end) < 1e50 for end in (first, last)):
            raise CadFault(f"edge {number} of its shape has no ends: the file is damaged")
        p, d = gp.gp_Pnt(), gp.gp_Vec()
        for s in (0.0, 0.37, 1.0):
            curve.D1(first + s * (last - first), p, d)


def _between(first: float, last: float, share: float) -> float:
    """A parameter of a face that may reach to infinity."""
    low, high = max(first, -1e4), min(last, 1e4)
    return low + share * (high - low)
