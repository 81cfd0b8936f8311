"""Free-form faces of OpenCascade as rational B-spline surfaces, whose numbers our own kernels evaluate."""

from typing import Any

import numpy as np

from cutwise.io.occ import MM, CadFault, occ
from cutwise.maths.nurbs import SplineSurface

_APPROXIMATION = 1e-5  # [mm] of surfaces that are no B-splines in themselves, such as offsets


def spline_surface(face: Any, evaluator: Any) -> SplineSurface:
    """The surface of a face: exact for B-spline, Bezier, swept and revolved surfaces, else to a hundredth of a micron.

    Parameters
    ----------
    face : shape
        The face.
    evaluator : adaptor
        Its adaptor, for the range of its parameters.

    Raises
    ------
    CadFault
        The surface cannot be expressed.
    """
    geom = occ("Geom")
    base = occ("BRep").BRep_Tool.Surface_s(face)
    if not isinstance(base, geom.Geom_BSplineSurface):
        ends = (evaluator.FirstUParameter(), evaluator.LastUParameter(),
                evaluator.FirstVParameter(), evaluator.LastVParameter())  # fmt: skip
        base = _converted(geom.Geom_RectangularTrimmedSurface(base, *ends))
    else:
        base = base.Copy()
    if base.IsUPeriodic():
        base.SetUNotPeriodic()
    if base.IsVPeriodic():
        base.SetVNotPeriodic()
    nu, nv = base.NbUPoles(), base.NbVPoles()
    poles = np.array([[_xyz(base.Pole(i + 1, j + 1)) for j in range(nv)] for i in range(nu)]) * MM
    weights = np.array([[base.Weight(i + 1, j + 1) for j in range(nv)] for i in range(nu)])
    return SplineSurface(
        np.array(list(base.UKnotSequence()), float), np.array(list(base.VKnotSequence()), float), poles, weights,
        base.UDegree(), base.VDegree(),
    )  # fmt: skip


def _xyz(point: Any) -> tuple[float, float, float]:
    return point.X(), point.Y(), point.Z()


def _converted(surface: Any) -> Any:
    convert = occ("GeomConvert")
    try:
        return convert.GeomConvert.SurfaceToBSplineSurface_s(surface)
    except Exception:  # a surface that only an approximation can express; OpenCascade's errors have no common base
        smooth = occ("GeomAbs").GeomAbs_Shape.GeomAbs_C1
        near = convert.GeomConvert_ApproxSurface(surface, _APPROXIMATION, smooth, smooth, 9, 9, 400, 0)
        if not near.HasResult():
            raise CadFault("a free-form face has a surface that cannot be expressed as a B-spline") from None
        return near.Surface()
