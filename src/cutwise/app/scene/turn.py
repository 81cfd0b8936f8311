"""A shaft that is turned: its finished shape with the error of its diameter, and the insert along it, pass by pass."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, FloatArray, History, Scene, Surface, limits
from cutwise.app.scene.shapes import band

if TYPE_CHECKING:
    from cutwise.results import Result

_ROUND = 72  # sides of a shaft
_ENDS = ("too thin", "too thick")


def scene(result: "Result") -> Scene:
    """The passes one behind the other, each from the far end to the headstock."""
    surface = result["surface"].dataset
    z, error = surface["z"].values, surface["diameter_error"].values
    passes = error.shape[1]
    order = np.argsort(-z)
    radius = _radius(result, z)
    cutting, structure = result["cutting"].dataset, result["structure"].dataset

    def over(values: FloatArray) -> FloatArray:
        return np.asarray(values[order].T.reshape(-1))

    bent = np.sum([a.values for name, a in structure.data_vars.items() if str(name).startswith("deflection_")], axis=0)
    along = np.tile(z[order], passes)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(along)))])
    low, high = limits(result, "diameter_error_min")[0], limits(result, "diameter_error_max")[1]
    histories = {
        "error": History(
            "diameter error",
            over(error),
            "small_length",
            low,
            high,
            ends=_ENDS,
            measures=("diameter_error_max", "diameter_error_min"),
        ),
        "bent": History("shaft and tool bent", over(bent), "small_length"),
        "passive": History("force off the shaft", over(cutting["force_passive"].values), "force"),
        "depth": History("depth of cut", over(result["engagement"]["depth"].values), "length"),
    }
    last = np.zeros(along.size, bool)
    last[(passes - 1) * z.size :] = True
    place = np.column_stack([along, np.zeros(along.size), np.tile(radius[order], passes)])
    return Scene(
        clock=way, clock_is="way", place=place, histories=histories, kind=np.full(along.size, CUT, np.uint8),
        surfaces=(_shaft(z, radius, error[:, -1]),), judged="error", counted=last,
        said=("the shaft is drawn as finished, coloured by the error of the last pass", "the insert is a dot"), path=False,
    )  # fmt: skip


def _radius(result: "Result", z: FloatArray) -> FloatArray:
    """Finished radius at each distance from the headstock end; the part's sections stand one behind the other."""
    found, before = np.zeros(z.size), 0.0
    for section in result.scenario.part.sections:  # type: ignore[attr-defined]
        found[z >= before - 1e-12] = 0.5 * section.diameter
        before += section.length
    return found


def _shaft(z: FloatArray, radius: FloatArray, error: FloatArray) -> Surface:
    """The surface of revolution through the stations, along x of the scene, with flat ends."""
    steps = np.flatnonzero(np.diff(radius) != 0.0)
    at, wide = np.insert(z, steps + 1, z[steps + 1]), np.insert(radius, steps + 1, radius[steps])
    shown = np.insert(error, steps + 1, np.nan)
    at, wide, shown = (np.concatenate([[v[0]], v, [v[-1]]]) for v in (at, wide, shown))
    wide[0] = wide[-1] = 0.0
    shown[0] = shown[-1] = np.nan
    angle = np.linspace(0.0, 2.0 * np.pi, _ROUND + 1)
    rows = [
        np.column_stack([np.full(angle.size, a), r * np.cos(angle), r * np.sin(angle)])
        for a, r in zip(at, wide, strict=True)
    ]
    points, corners = band(rows)
    return Surface("shaft", points, corners, "work", np.repeat(shown, _ROUND + 1), "error")
