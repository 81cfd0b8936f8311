"""STEP files through OpenCascade (the ``cad`` extra), read with every way in which such a file can fail."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cutwise.io.occ import MISSING, MM, CadFault, explored, occ
from cutwise.io.part21 import Exchange, TextFault, exchange, listed
from cutwise.io.step_process import READER, shape_of

_METRES = {
    "millimetre": 1e-3, "centimetre": 1e-2, "micrometre": 1e-6, "metre": 1.0, "inch": 0.0254, "foot": 0.3048,
}  # fmt: skip
_LOOSEST = 1e-4  # [m] that a file is believed when it says within which distance points are one


class StepPart(NamedTuple):
    """A part as read; the shape is OpenCascade's, in millimetres."""

    shape: Any
    name: str
    unit: str  # length unit that the file is written in
    solids: int
    open_shells: int
    faces: int
    tolerance: float = 0.0  # [m] within which the file says that points are one; 0: it does not say
    lost: int = 0  # faces of the file that could not be translated
    loose: tuple[str, ...] = ()  # references of the file that lead nowhere, but are not needed for the shape

    @property
    def notices(self) -> tuple[str, ...]:
        """What the user should know about the file."""
        found = []
        if self.unit.lower() not in ("millimetre", "mm", ""):
            found.append(f"{self.name} is written in {self.unit}; it was converted")
        if self.open_shells:
            found.append(
                f"{self.name} has {self.open_shells} open shell(s): edges at the gaps have one face only and are left "
                "out, volume and mass are unknown"
            )
        if self.lost:
            found.append(f"{self.name}: {self.lost} face(s) of the file could not be translated and are missing")
        if self.loose:
            found.append(f"{self.name} is damaged where the shape is not touched: {listed(self.loose)}")
        return tuple(found)


def read_step(path: str | Path) -> StepPart:
    """Read a STEP file: first as text, then by OpenCascade in a process of its own, which a bad file may end.

    Raises
    ------
    CadFault
        The file is missing, empty, not STEP, truncated, refers to lines that are missing, has parameters of a wrong
        type, has no geometry, a wireframe, or coordinates that are no numbers or beyond all measure; the message says
        which.
    """
    path = Path(path)
    text = _text(path)
    try:
        found = exchange(text)
        READER.start()  # it loads OpenCascade while this process does so too
        occ("TopoDS")
        shape, types = shape_of(path, [k for k, n in enumerate(found.order) if n in found.shape])
    except (TextFault, CadFault) as fault:
        raise CadFault(str(fault) if str(fault) == MISSING else f"{path.name}: {fault}") from None
    if types:
        raise CadFault(f"{path.name}: {_types_told(found, types)}")
    part = part_from_shape(shape, path.name, unit=_unit(text))
    tolerance = min(found.uncertainty() * _METRES.get(part.unit, MM), _LOOSEST)
    lost = max(0, found.faces() - _written_faces(shape))
    return part._replace(tolerance=tolerance, lost=lost, loose=found.loose)


def _written_faces(shape: Any) -> int:
    """Faces of a shape, those of a body that is placed several times counted once."""
    faces = explored(shape, occ("TopAbs").TopAbs_ShapeEnum.TopAbs_FACE)
    away = occ("TopLoc").TopLoc_Location()
    return len({hash(face.Located(away)) for face in faces})


def part_from_shape(shape: Any, name: str, *, unit: str = "") -> StepPart:
    """A shape of OpenCascade, in millimetres, as a part.

    Raises
    ------
    CadFault
        The shape has no faces.
    """
    kinds = occ("TopAbs").TopAbs_ShapeEnum
    faces = len(explored(shape, kinds.TopAbs_FACE))
    if not faces:
        edges = len(explored(shape, kinds.TopAbs_EDGE))
        counted = f"{edges} edge{'' if edges == 1 else 's'}"
        raise CadFault(
            f"{name}: a wireframe ({counted}, no faces): an edge needs two faces to tell how it is to be cut"
        )
    closed = occ("BRep").BRep_Tool.IsClosed_s
    shells = explored(shape, kinds.TopAbs_SHELL)
    solids = len(explored(shape, kinds.TopAbs_SOLID))
    return StepPart(shape, name, unit, solids, sum(not closed(shell) for shell in shells), faces)


def _text(path: Path) -> str:
    """Text of the file."""
    try:
        raw = path.read_bytes()
    except FileNotFoundError:
        raise CadFault(f"{path}: no such file") from None
    except OSError as fault:
        raise CadFault(f"{path}: cannot be read ({fault.strerror})") from None
    if not raw.strip():
        raise CadFault(f"{path.name}: the file is empty")
    return raw.decode("latin-1")


def _types_told(found: Exchange, types: Sequence[tuple[int, str]]) -> str:
    """Parameters of a wrong type in words, with their lines."""
    said = []
    for place, what in dict.fromkeys(types):
        number = found.order[place]
        parameter = re.search(r"(\d+)\s*\((.*?)\)", what)
        which = f"parameter {parameter[1]} ({parameter[2]})" if parameter else what
        said.append(
            f"line {found.line(number)}: #{number} = {found.instances[number].kind}: {which} is missing or not of its type"
        )
    return f"{listed(dict.fromkeys(said))}; the file is damaged: export it again"


def _unit(text: str) -> str:
    """Length unit of the file, by the name that it gives."""
    flat = text.replace("\n", "").replace("\r", "").replace(" ", "").upper()
    for name in ("INCH", "FOOT"):
        if f"CONVERSION_BASED_UNIT('{name}'" in flat:
            return name.lower()
    prefixes = {".MILLI.": "millimetre", ".CENTI.": "centimetre", ".MICRO.": "micrometre", "$": "metre"}
    for prefix, unit in prefixes.items():
        if f"SI_UNIT({prefix},.METRE.)" in flat:
            return unit
    return ""


def write_step(shape: Any, path: str | Path) -> Path:
    """Write a shape, given in millimetres, as STEP.

    Raises
    ------
    CadFault
        The file could not be written.
    """
    control = occ("STEPControl")
    writer = control.STEPControl_Writer()
    writer.Transfer(shape, control.STEPControl_AsIs)
    if writer.Write(str(path)) != occ("IFSelect").IFSelect_RetDone:
        raise CadFault(f"{path}: cannot be written")
    return Path(path)


class MassProperties(NamedTuple):
    """Mass of a solid of uniform density."""

    mass: float  # [kg]
    centre: tuple[float, float, float]  # [m]
    inertia: tuple[tuple[float, float, float], ...]  # [kg m^2] tensor about the centre, products as -int xy dm


def mass_properties(part: StepPart, density: float) -> MassProperties:
    """Mass, centre and inertia of the solids of a part.

    Parameters
    ----------
    part : StepPart
        The part; every shell must be closed.
    density : float
        [kg/m^3].

    Raises
    ------
    CadFault
        There is no solid, or a shell is open: such volumes are nonsense.
    """
    if not part.solids or part.open_shells:
        raise CadFault(f"{part.name}: no closed solid, so it has no mass")
    total = occ("GProp").GProp_GProps()
    occ("BRepGProp").BRepGProp.VolumeProperties_s(part.shape, total, True)
    if not total.Mass() > 0.0 or not math.isfinite(total.Mass()):
        raise CadFault(f"{part.name}: its volume is not positive: the solids are inside out or open")
    centre = total.CentreOfMass()
    matrix = total.MatrixOfInertia()
    scale = density * MM**5
    return MassProperties(
        density * total.Mass() * MM**3,
        (centre.X() * MM, centre.Y() * MM, centre.Z() * MM),
        tuple(tuple(matrix.Value(i, j) * scale for j in (1, 2, 3)) for i in (1, 2, 3)),
    )
