"""STEP files through OpenCascade (the ``cad`` extra), read with every way in which such a file can fail."""

import importlib
import math
import re
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

MM = 1e-3  # OpenCascade converts whatever the file says to millimetres

_LARGEST = 1e6  # [mm] of a part: nothing larger is machined, and OpenCascade does not come back from 1e300
_POINT = re.compile(r"CARTESIAN_POINT\s*\(\s*'[^']*'\s*,\s*\(([^()]*)\)", re.IGNORECASE)
_NO_NUMBER = re.compile(r"[(,]\s*([-+]?(?:nan|inf(?:inity)?))\s*[,)]", re.IGNORECASE)

# Printed once by the importing of OpenCascade if the extra is missing.
_MISSING = "reading CAD files needs the extra: pip install 'cutwise[cad]'"


class CadFault(ValueError):
    """A CAD file that cannot be used, in plain words."""


class StepPart(NamedTuple):
    """A part as read; the shape is OpenCascade's, in millimetres."""

    shape: Any
    name: str
    unit: str  # length unit that the file is written in
    solids: int
    open_shells: int
    faces: int

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the user should know about the file."""
        found = []
        if self.unit.lower() not in ("millimetre", "mm", ""):
            found.append(f"{self.name} is written in {self.unit}; it was converted")
        if self.open_shells:
            found.append(
                f"{self.name} has {self.open_shells} open shell(s): edges at the gaps have one face only and are left "
                "out, volume and mass are unknown"
            )
        return tuple(found)


@lru_cache(maxsize=64)
def occ(module: str) -> Any:
    """A module of the OpenCascade bindings, imported at its first use (1 to 5 s).

    Raises
    ------
    CadFault
        The extra is not installed.
    """
    try:
        loaded = importlib.import_module(f"OCP.{module}")
    except ImportError:
        raise CadFault(_MISSING) from None
    _silence()
    return loaded


_silent = False


def _silence() -> None:
    """Take the message printers of OpenCascade away: they write to standard output, between our JSON."""
    global _silent
    if _silent:
        return
    _silent = True
    messenger = importlib.import_module("OCP.Message").Message.DefaultMessenger_s()
    for printer in list(messenger.Printers()):
        messenger.RemovePrinter(printer)


def read_step(path: str | Path) -> StepPart:
    """Read a STEP file.

    Raises
    ------
    CadFault
        The file is missing, empty, not STEP, truncated, without geometry, a wireframe, or has coordinates that are no
        numbers or beyond all measure; the message says which.
    """
    path = Path(path)
    text = _header(path)
    reader = occ("STEPControl").STEPControl_Reader()
    status = reader.ReadFile(str(path))
    if status != occ("IFSelect").IFSelect_RetDone:  # asking such a reader for its roots would crash
        raise CadFault(f"{path.name}: not a readable STEP file (damaged or cut short)")
    if reader.NbRootsForTransfer() < 1:
        raise CadFault(f"{path.name}: a STEP file without geometry: it has a header and no shapes")
    reader.TransferRoots()
    shape = reader.OneShape()
    if shape is None or shape.IsNull():
        raise CadFault(f"{path.name}: its shapes could not be translated; export it as AP203, AP214 or AP242 solids")
    _check_size(shape, path.name)
    return part_from_shape(shape, path.name, unit=_unit(text))


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


def explored(shape: Any, kind: Any) -> list[Any]:
    """All different sub-shapes of a kind, each with its orientation in the shape."""
    topology = occ("TopoDS").TopoDS
    typed = getattr(topology, kind.name.removeprefix("TopAbs_").capitalize())
    found = shape_map(shape, kind)
    return [typed(found.FindKey(i)) for i in range(1, found.Extent() + 1)]


def shape_map(shape: Any, kind: Any) -> Any:
    """All different sub-shapes of a kind, counted from 1; both uses of an edge are the same."""
    found = occ("collections").IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    occ("TopExp").TopExp.MapShapes_s(shape, kind, found)
    return found


def _header(path: Path) -> str:
    """Text of the file, after the checks that a reader may not survive."""
    try:
        raw = path.read_bytes()
    except FileNotFoundError:
        raise CadFault(f"{path}: no such file") from None
    except OSError as fault:
        raise CadFault(f"{path}: cannot be read ({fault.strerror})") from None
    if not raw.strip():
        raise CadFault(f"{path.name}: the file is empty")
    text = raw.decode("latin-1")
    if "ISO-10303-21" not in text[:2000]:
        raise CadFault(f"{path.name}: not a STEP file (it does not begin with ISO-10303-21)")
    if "DATA;" not in text:
        raise CadFault(f"{path.name}: a STEP file without geometry: it has a header and no data section")
    _check_points(text, path.name)
    return text


def _check_points(text: str, name: str) -> None:
    """Refuse numbers that are none, and coordinates so large in any unit that reading them would not end."""
    damaged = "the file is damaged: export it again"
    bad = _NO_NUMBER.search(text)
    if bad is not None:
        line = text.count("\n", 0, bad.start()) + 1
        raise CadFault(f"{name}: line {line}: {bad[1]} is not a number; {damaged}")
    for found in _POINT.finditer(text):
        for word in found[1].split(","):
            try:
                value = float(word)
            except ValueError:
                value = math.nan
            if not math.isfinite(value) or abs(value) > 1e3 * _LARGEST:
                line = text.count("\n", 0, found.start()) + 1
                raise CadFault(
                    f"{name}: line {line}: the coordinate {word.strip() or 'that is missing'} is no length of a part; {damaged}"
                )


def _check_size(shape: Any, name: str) -> None:
    box = occ("Bnd").Bnd_Box()
    occ("BRepBndLib").BRepBndLib.Add_s(shape, box, False)
    if box.IsVoid():
        return
    low, high = box.CornerMin(), box.CornerMax()
    ends = [low.X(), low.Y(), low.Z(), high.X(), high.Y(), high.Z()]
    if not all(map(math.isfinite, ends)) or max(map(abs, ends)) > _LARGEST:
        raise CadFault(f"{name}: the part reaches farther than {_LARGEST * MM * 1e-3:g} km: check the unit of the file")


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
