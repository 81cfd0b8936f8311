"""The machined stock of a run file as a closed surface: PLY with colours, VTK with fields, STL for the next program.

Corners of cells stand at the height of the surface there; a wall between two of them leans over one cell.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.io.stl import stl_bytes

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

ENDINGS = (".ply", ".vtk", ".stl")
_GREY = (150, 150, 150)
_ENDS = {"cut into the part": (33, 102, 172), "in between": (247, 247, 247), "material left": (178, 24, 43)}
_NEAR = 3.0  # steps between samples: a farther one says nothing about a corner


class NoSurface(ValueError):
    """A run without a machined stock, or an ending that is not known."""


class Surface(NamedTuple):
    """A closed surface with what is known at its corners."""

    point: FloatArray  # [m], shape (n, 3)
    triangle: IntArray  # shape (m, 3)
    deviation: FloatArray  # [m]; NaN where there is no part near, shape (n,)
    line: IntArray  # of the program; 0 the stock, shape (n,)
    tool: IntArray
    face: IntArray  # of the part, 0: none near
    limit: float  # of the colours [m]


def surface_of(stages: "xr.DataTree") -> Surface:
    """The machined stock of a run.

    Raises
    ------
    NoSurface
        The run has none.
    """
    if "stock" not in stages.children or "height_corner" not in stages["stock"]:
        raise NoSurface("the run holds no machined stock: that takes a stock in 3D (tools, or a nominal part)")
    stock = stages["stock"].to_dataset()
    solid = ~np.isnan(stock["height"].values)
    point, triangle, at = closed(
        stock["x_corner"].values, stock["y_corner"].values, stock["height_corner"].values.astype(float),
        stock["bottom_corner"].values.astype(float), solid,
    )  # fmt: skip
    rows, columns = solid.shape
    j, i = np.minimum(at // (columns + 1), rows - 1), np.minimum(at % (columns + 1), columns - 1)
    line = stock["line"].values[j, i].astype(np.int64)
    deviation, face = np.full(len(point), np.nan), np.zeros(len(point), np.int64)
    limit = 1e-5
    if "surface" in stages.children:
        deviation, face = _near(stages["surface"].to_dataset(), point)
        limit = float(stages["surface"].attrs.get("tolerance", 0.0)) or max(
            float(np.nanmax(np.abs(deviation), initial=0.0)), 1e-9
        )
    return Surface(point, triangle, deviation, line, _tools(stages, line), face, limit)


def _tools(stages: "xr.DataTree", line: IntArray) -> IntArray:
    """Tool of each line."""
    if "lines" not in stages.children:
        return np.zeros(len(line), np.int64)
    table = stages["lines"].to_dataset()
    known, first = np.unique(table["line"].values, return_index=True)
    place = np.clip(np.searchsorted(known, line), 0, len(known) - 1)
    return np.where(known[place] == line, table["tool"].values[first][place], 0)


def _near(samples: "xr.Dataset", point: FloatArray) -> tuple[FloatArray, IntArray]:
    """Deviation and face of the sample nearest to each point."""
    from scipy.spatial import cKDTree

    where = samples["point"].values.astype(float)
    tree = cKDTree(where)
    some = where[:: max(1, len(where) // 200)]
    step = float(np.median(tree.query(some, k=2)[0][:, 1])) if len(where) > 1 else 1.0
    away, index = tree.query(point, distance_upper_bound=_NEAR * step + 1e-3)
    there = np.isfinite(away)
    index = np.where(there, index, 0)
    deviation = np.where(there, samples["deviation"].values[index].astype(float), np.nan)
    return deviation, np.where(there, samples["face"].values[index], 0).astype(np.int64)


def closed(
    x: FloatArray, y: FloatArray, top: FloatArray, bottom: FloatArray, solid: npt.NDArray[np.bool_]
) -> tuple[FloatArray, IntArray, IntArray]:
    """Points and triangles of cells that are solid, and the corner that each point stands at.

    Parameters
    ----------
    x, y : array
        Corners of cells [m], shapes (columns + 1,), (rows + 1,).
    top, bottom : array (rows + 1, columns + 1)
        Heights there [m].
    solid : array (rows, columns)
        Which cells are there.
    """
    rows, columns = solid.shape
    wide = columns + 1
    corner = np.arange((rows + 1) * wide).reshape(rows + 1, wide)
    below = (rows + 1) * wide
    a, b, c, d = corner[:-1, :-1][solid], corner[:-1, 1:][solid], corner[1:, 1:][solid], corner[1:, :-1][solid]
    faces = [_quads(a, b, c, d), _quads(d + below, c + below, b + below, a + below)]
    edge = np.pad(solid, 1)
    for (dj, di), (first, second) in (
        ((-1, 0), (a, b)), ((0, 1), (b, c)), ((1, 0), (c, d)), ((0, -1), (d, a)),
    ):  # fmt: skip
        open_ = ~edge[1 + dj : 1 + dj + rows, 1 + di : 1 + di + columns][solid]
        s, e = first[open_], second[open_]
        faces.append(_quads(s + below, e + below, e, s))
    triangle = np.concatenate(faces)
    grid_y, grid_x = np.meshgrid(y, x, indexing="ij")
    upper = np.column_stack([grid_x.ravel(), grid_y.ravel(), np.maximum(top, bottom).ravel()])
    lower = np.column_stack([grid_x.ravel(), grid_y.ravel(), bottom.ravel()])
    used, index = np.unique(triangle, return_inverse=True)
    return np.concatenate([upper, lower])[used], np.asarray(index).reshape(-1, 3), used % below


def _quads(a: IntArray, b: IntArray, c: IntArray, d: IntArray) -> IntArray:
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def colours(deviation: FloatArray, limit: float) -> npt.NDArray[np.uint8]:
    """Blue where it is cut into the part, red where material is left, grey where nothing is known; shape (n, 3)."""
    low, middle, high = (np.array(colour, float) for colour in _ENDS.values())
    share = np.clip(np.nan_to_num(deviation) / limit, -1.0, 1.0)[:, None]
    mixed = np.where(share < 0.0, middle + (low - middle) * -share, middle + (high - middle) * share)
    mixed[np.isnan(deviation)] = _GREY
    return np.asarray(mixed.round(), np.uint8)


def surface_bytes(surface: Surface, ending: str) -> bytes:
    """The surface as a file of an ending.

    Raises
    ------
    NoSurface
        The ending is not known.
    """
    if ending == ".stl":
        return stl_bytes(surface.point[surface.triangle])
    if ending == ".ply":
        return _ply(surface)
    if ending == ".vtk":
        return _vtk(surface)
    raise NoSurface(f'the ending "{ending}" is not known; write {", ".join(ENDINGS)}')


def _ply(surface: Surface) -> bytes:
    vertex = np.dtype([("p", "<f4", 3), ("c", "u1", 3), ("d", "<f4"), ("n", "<i4", 3)])
    table = np.zeros(len(surface.point), vertex)
    table["p"], table["c"] = 1e3 * surface.point, colours(surface.deviation, surface.limit)
    table["d"] = 1e3 * surface.deviation
    table["n"] = np.column_stack([surface.line, surface.tool, surface.face])
    faces = np.zeros(len(surface.triangle), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    faces["n"], faces["i"] = 3, surface.triangle
    header = "\n".join([
        "ply", "format binary_little_endian 1.0",
        f"comment cutwise, mm; colours: deviation within {1e3 * surface.limit:g} mm, blue cut into the part, red material left",
        f"element vertex {len(table)}", "property float x", "property float y", "property float z", "property uchar red",
        "property uchar green", "property uchar blue", "property float deviation", "property int line", "property int tool",
        "property int face", f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", "",
    ])  # fmt: skip
    return header.encode() + table.tobytes() + faces.tobytes()


def _vtk(surface: Surface) -> bytes:
    points, cells = len(surface.point), len(surface.triangle)
    parts = [
        f"# vtk DataFile Version 3.0\ncutwise machined stock, m; deviation positive: material left\nBINARY\nDATASET POLYDATA\n"
        f"POINTS {points} float\n".encode(),
        surface.point.astype(">f4").tobytes(),
        f"\nPOLYGONS {cells} {4 * cells}\n".encode(),
        np.column_stack([np.full(cells, 3), surface.triangle]).astype(">i4").tobytes(),
        f"\nPOINT_DATA {points}\nSCALARS deviation float 1\nLOOKUP_TABLE default\n".encode(),
        surface.deviation.astype(">f4").tobytes(),
    ]
    for name in ("line", "tool", "face"):
        parts += [
            f"\nSCALARS {name} int 1\nLOOKUP_TABLE default\n".encode(),
            getattr(surface, name).astype(">i4").tobytes(),
        ]
    return b"".join(parts)
