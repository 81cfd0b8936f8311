"""An edge that is deburred: work, burr before, edge left, mill; along a line or round an arc."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, FEED, UP, FloatArray, History, Scene, Surface, Tool, limits
from cutwise.app.scene.shapes import band, cylinder, strip
from cutwise.app.scene.spindle import in_spindle
from cutwise.app.scene.thinned import kept
from cutwise.app.scene.toolpath import Toolpath, toolpath_of
from cutwise.app.scene.worst import magnification
from cutwise.spec.tables import Table

if TYPE_CHECKING:
    from cutwise.results import Result

ENDS = ("cut into the part", "burr left")
_STRIPS = 400  # buckets of an edge that is drawn
_FLUTES = 2.5  # length of a mill whose flute length is not said, in diameters


def scene(result: "Result") -> Scene:
    """The pass as it went over time, or place by place at rest."""
    scenario = result.scenario
    motion, surface = result["motion"].dataset, result["surface"].dataset
    radius = 0.5 * scenario.tool.diameter  # type: ignore[attr-defined]
    timed = "time" in motion
    along = motion["feed_position"].values if timed else motion["w"].values
    off = radius + motion["programmed_height"].values
    toolpath = toolpath_of(result)
    on = _placed(result, toolpath)
    deflection = _deflection(result, along, toolpath)
    error = surface["error_at_tool"].values if timed else surface["error"].values
    work, burr = (result["cutting"][f"{name}_force"].values for name in ("work", "burr"))
    histories = {
        "error": History("edge error", error, "length", *limits(result, "surface_error_max", "surface_error_min"), ends=ENDS,
                         measures=("surface_error_max", "surface_error_min")),
        "power": History("cutting power", result["cutting"]["power"].values, "power", *limits(result, "cutting_power_mean"),
                         measures=("cutting_power_mean",)),
        "force": History("force on the mill", np.linalg.norm(work + burr, axis=1), "force"),
    }  # fmt: skip
    if deflection is not None:
        histories["deflection"] = History("tip deflection", np.linalg.norm(deflection, axis=1), "length")
    surfaces, said = _edge(result, on)
    met = (result["engagement"]["burr_depth"].values > 0.0) | (result["engagement"]["work_depth"].values > 0.0)
    return Scene(
        clock=motion["time"].values if timed else along,
        clock_is="time" if timed else "way",
        place=on(along, off, np.zeros(along.size)),
        axis=UP[None] if toolpath is None else toolpath.up(along),
        front=None if toolpath is None else toolpath.front,
        histories=histories,
        kind=np.where(met, CUT, FEED).astype(np.uint8),
        deflection=deflection,
        tools=(_mill(result, radius),),
        surfaces=surfaces,
        judged="error",
        counted=_steady(result, motion["time"].values) if timed else None,
        said=said,
        path=False,
    )


def _steady(result: "Result", time: FloatArray) -> "np.ndarray":
    """Where the error counts: after the lead-in, and before the lead-out where there is one."""
    operation = result.scenario.operation  # type: ignore[attr-defined]
    return np.asarray(
        (time >= operation.lead_in_time) & (time <= time[-1] - (getattr(operation, "lead_out_time", 0.0) or 0.0))
    )


def _placed(result: "Result", toolpath: Toolpath | None) -> Callable[..., FloatArray]:
    """Where a place along, off and above the edge is: on its path in the part, else along x, or round an arc."""
    if toolpath is not None:
        return toolpath.on
    ring = _ring(result)

    def on(along: FloatArray, off: FloatArray, up: FloatArray) -> FloatArray:
        if ring == 0.0:
            return np.column_stack([along, off, up])
        turned = along / ring
        return np.column_stack([(ring + off) * np.sin(turned), (ring + off) * np.cos(turned), up])

    return on


def _ring(result: "Result") -> float:
    """Radius of the edge [m]; 0: straight."""
    arc = getattr(getattr(result.scenario, "path", None), "arc", None)
    return float(arc.radius) if arc is not None else 0.0


def _deflection(result: "Result", along: FloatArray, toolpath: Toolpath | None) -> FloatArray | None:
    """Displacement of the tip in the axes of the scene; on an arc those of the process turn with the edge."""
    structure, ring = result["structure"].dataset, _ring(result)
    if "tip_deflection" in structure:
        found = np.pad(structure["tip_deflection"].values, ((0, 0), (0, 1)))
    else:
        terms = [a.values for name, a in structure.data_vars.items() if str(name).startswith("deflection_")]
        if not terms:
            return None
        found = np.sum(terms, axis=0)
    if toolpath is not None:
        return toolpath.turned(along, found)
    if ring == 0.0:
        return found
    c, s = np.cos(along / ring), np.sin(along / ring)
    return np.column_stack([found[:, 0] * c + found[:, 1] * s, found[:, 1] * c - found[:, 0] * s, found[:, 2]])


def _mill(result: "Result", radius: float) -> Tool:
    scenario = result.scenario
    part = scenario.part  # type: ignore[attr-defined]
    length = scenario.tool.flute_length or _FLUTES * 2.0 * radius  # type: ignore[attr-defined]
    length = max(length, part.axial_start + 1.5 * part.contact_length)
    return in_spindle(cylinder(radius, length), getattr(scenario, "spindle", None))


def _edge(result: "Result", on: Callable[..., FloatArray]) -> tuple[tuple[Surface, ...], tuple[str, ...]]:
    """Work, burr before and edge left; and what is not drawn as it is."""
    surface, part = result["surface"].dataset, result.scenario.part  # type: ignore[attr-defined]
    radius = 0.5 * result.scenario.tool.diameter  # type: ignore[attr-defined]
    keep = kept([surface["error"].values, surface["burr_height"].values], _STRIPS)
    w, error, height = (surface[name].values[keep] for name in ("w", "error", "burr_height"))
    bottom, top = part.axial_start, part.axial_start + part.contact_length
    deep = max(1.2 * part.contact_length, 2.0 * radius)
    arc = getattr(getattr(result.scenario, "path", None), "arc", None)
    if arc is not None:
        deep = min(deep, 0.8 * arc.radius)
    times = magnification(radius, float(np.nanmax(np.abs(error), initial=0.0)))

    def at(off: FloatArray | float, up: float) -> FloatArray:
        return on(w, np.broadcast_to(off, w.shape), np.full(w.size, up))

    left = times * error
    judged, said_of_leads = _judged(result, w)
    face, corners = band([at(left, bottom), at(left, top)])
    body = strip([at(left, top), at(-deep, top), at(-deep, bottom), at(left, bottom)])
    width, said = _width(result, w)
    lowest = part.burr.axial_start
    before, burr_corners = band(
        [at(np.zeros(w.size), lowest), at(height, lowest), on(w, height, lowest + width), on(w, np.zeros(w.size), lowest + width)]
    )  # fmt: skip
    said = (*said, *said_of_leads)
    if times != 1.0:
        said = (*said, f"error of the edge drawn {times:g} times")
    if part.step is not None:
        said = (*said, "the part of the STEP file is not drawn, its edge is")
    return (
        Surface("work", *body),
        Surface("edge left", face, corners, "work", np.tile(np.where(judged, error, np.nan), 2), "error"),
        Surface("burr before", before, burr_corners, "burr"),
    ), said


def _judged(result: "Result", w: FloatArray) -> tuple["np.ndarray", tuple[str, ...]]:
    """Places of the edge that the limits are about: those that the mill passes neither leading in nor leading out."""
    motion = result["motion"].dataset
    if "time" not in motion:
        return np.ones(w.size, bool), ()
    steady = np.flatnonzero(_steady(result, motion["time"].values))
    if steady.size == 0:
        return np.ones(w.size, bool), ()
    first, last = motion["feed_position"].values[[steady[0], steady[-1]]]
    found = (w >= min(first, last)) & (w <= max(first, last))
    return found, () if found.all() else ("grey: led in or out, not judged",)


def _width(result: "Result", w: FloatArray) -> tuple[FloatArray, tuple[str, ...]]:
    width = result.scenario.part.burr.width  # type: ignore[attr-defined]
    if isinstance(width, float):
        return np.full(w.size, width), ()
    if isinstance(width, Table):
        return np.interp(w, *width.points()), ()
    return np.full(w.size, width.mean), ("the burr is drawn with its mean width",)
