"""Sharp edges between two surfaces: point, tangent, outward normals, and the wedge of material between them."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.maths.surfaces import SECTION_TERMS, IntArray, Surfaces


class EdgeFrames(NamedTuple):
    """Samples along one edge; the normal plane of the edge contains both normals and both directions ``into``."""

    parameter: FloatArray  # rising, shape (n,)
    period: float  # of the parameter of a closed edge, whose first sample is not repeated; 0 for an open edge
    point: FloatArray  # [m], shape (n, 3)
    tangent: FloatArray  # unit, along the rising parameter, shape (n, 3)
    normal: FloatArray  # unit, out of the material, of the first and the second surface, shape (n, 2, 3)
    into: FloatArray  # unit, in each surface, at right angles to the edge, away from it, shape (n, 2, 3)
    wedge: FloatArray  # [rad] angle of the material between the surfaces, shape (n,)
    surfaces: Surfaces
    face: IntArray  # rows of the two surfaces in that table, shape (n, 2)
    section: FloatArray  # section polynomials of free-form surfaces, shape (n, 2, 8)

    @property
    def closed(self) -> bool:
        """Whether the edge runs back into itself."""
        return self.period > 0.0

    @property
    def air(self) -> FloatArray:
        """Unit bisector of the wedge, out of the material; shape (n, 3)."""
        return unit(self.normal[:, 0] + self.normal[:, 1])

    @property
    def across(self) -> FloatArray:
        """Unit vector from the second surface to the first, at right angles to the bisector; shape (n, 3)."""
        return unit(self.into[:, 0] - self.into[:, 1])


def unit(vector: FloatArray) -> FloatArray:
    """Vectors divided by their length, over the last axis."""
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def arc_lengths(point: FloatArray, tangent: FloatArray, *, closed: bool) -> FloatArray:
    r"""Length of a smooth curve between its samples, :math:`|\Delta P|\, \tfrac{\alpha/2}{\sin(\alpha/2)}` [m].

    :math:`\alpha` is the angle between the tangents: exact for arcs, elsewhere of the fourth order in the step.
    """
    after = np.roll(tangent, -1, axis=0) if closed else tangent[1:]
    before = tangent if closed else tangent[:-1]
    half = np.arcsin(np.minimum(1.0, 0.5 * np.linalg.norm(after - before, axis=1)))
    return lengths(point, closed=closed) / np.sinc(half / np.pi)


def edge_frames(
    parameter: FloatArray, point: FloatArray, tangent: FloatArray, normal: FloatArray, *,
    surfaces: Surfaces, face: IntArray, period: float = 0.0, section: FloatArray | None = None,
) -> EdgeFrames:  # fmt: skip
    r"""Complete the frames of a convex edge from tangent and outward normals.

    .. math:: u_1 = \pm n_1 \times t \ \text{with}\ u_1 \cdot n_2 < 0, \qquad
              \varphi = \pi - \angle(n_1, n_2) = \operatorname{atan2}(|n_1 \times n_2|, -n_1 \cdot n_2)

    Parameters
    ----------
    parameter, point, tangent : array
        Parameter, points [m] and tangents along the edge, shapes (n,), (n, 3), (n, 3).
    normal : array
        Outward unit normals of both surfaces, shape (n, 2, 3).
    surfaces, face : Surfaces, array
        The surfaces, and which two meet at each sample, shape (n, 2).
    period : float
        Period of the parameter of a closed edge.
    section : array, optional
        Section polynomials where surfaces are free-form.

    References
    ----------
    Sato et al. 2016, sec. 2, for the curve; the frame of the normals replaces the Frenet frame, whose normal does not
    lie on the bisector of the wedge.
    """
    n1, n2 = normal[:, 0], normal[:, 1]
    tangent = unit(tangent)
    into1 = unit(np.cross(n1, tangent))
    into1 *= -np.sign(np.einsum("ij,ij->i", into1, n2))[:, None]
    into2 = unit(np.cross(n2, tangent))
    into2 *= -np.sign(np.einsum("ij,ij->i", into2, n1))[:, None]
    wedge = np.arctan2(np.linalg.norm(np.cross(n1, n2), axis=1), -np.einsum("ij,ij->i", n1, n2))
    if section is None:
        section = np.zeros((len(point), 2, SECTION_TERMS))
    return EdgeFrames(
        np.ascontiguousarray(parameter, float), float(period), np.ascontiguousarray(point), tangent,
        np.ascontiguousarray(normal), np.stack([into1, into2], axis=1), wedge, surfaces,
        np.ascontiguousarray(face, np.int64), section,
    )  # fmt: skip


def reversed_edge(frames: EdgeFrames) -> EdgeFrames:
    """The same edge run the other way; first and second surface stay."""
    first = frames.parameter[0]
    turned = _picked(frames, slice(None, None, -1))
    return turned._replace(parameter=first + frames.parameter[-1] - turned.parameter, tangent=-turned.tangent)


def swapped_sides(frames: EdgeFrames) -> EdgeFrames:
    """The same edge with its two surfaces exchanged."""
    return frames._replace(
        normal=np.ascontiguousarray(frames.normal[:, ::-1]), into=np.ascontiguousarray(frames.into[:, ::-1]),
        face=np.ascontiguousarray(frames.face[:, ::-1]), section=np.ascontiguousarray(frames.section[:, ::-1]),
    )  # fmt: skip


def part_of(frames: EdgeFrames, keep: slice | npt.NDArray[np.integer]) -> EdgeFrames:
    """Some samples of an edge as an open edge."""
    return _picked(frames, keep)._replace(period=0.0)


def _picked(frames: EdgeFrames, keep: slice | npt.NDArray[np.integer]) -> EdgeFrames:
    names = ("parameter", "point", "tangent", "normal", "into", "wedge", "face", "section")
    return frames._replace(**{name: np.ascontiguousarray(getattr(frames, name)[keep]) for name in names})  # type: ignore[arg-type]


def lengths(point: FloatArray, *, closed: bool) -> FloatArray:
    """Lengths of the segments of a polyline; a closed one has as many as it has points [m]."""
    ends = np.roll(point, -1, axis=0) if closed else point[1:]
    starts = point if closed else point[:-1]
    return np.linalg.norm(ends - starts, axis=1)
