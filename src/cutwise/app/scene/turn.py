"""A shaft that is turned: its finished shape with the error of its diameter, and the insert along it, pass by pass."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, Body, FloatArray, History, Scene, Surface, Tool, limits
from cutwise.app.scene.shapes import plate, revolved
from cutwise.app.scene.worst import magnification

if TYPE_CHECKING:
    from cutwise.results import Result

_ROUND = 72  # sides of a shaft
_EDGE = 0.011  # [m] length of an edge of an insert whose size the scenario does not say
_ENDS = ("too thin", "too thick")


def scene(result: "Result") -> Scene:
    """The passes one behind the other, each in the direction of the feed."""
    surface = result["surface"].dataset
    z, error = surface["z"].values, surface["diameter_error"].values
    passes = error.shape[1]
    order = np.argsort(-z if result.scenario.operation.towards == "headstock" else z)  # type: ignore[attr-defined]
    radius = _radius(result, z)
    times = magnification(float(radius.max()), 0.5 * float(np.nanmax(np.abs(error[:, -1]))))
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
    off = np.column_stack([np.zeros((along.size, 2)), np.tile(0.5 * error[order, -1], passes)])
    return Scene(
        clock=way, clock_is="way", place=place, histories=histories, kind=np.full(along.size, CUT, np.uint8),
        surfaces=(_shaft(z, radius, error[:, -1], times), *_holding(result, float(z.max()), radius)),
        deflection=off, magnified=times, tools=(_insert(result),), judged="error", counted=last, path=False,
        said=("the shaft is drawn as finished, coloured by the error of the last pass",
              f"its error drawn {times:g} times, and the insert with it",
              "sizes of insert, holder, chuck and centre are not said"),
    )  # fmt: skip


def _radius(result: "Result", z: FloatArray) -> FloatArray:
    """Finished radius at each distance from the headstock end; the part's sections stand one behind the other."""
    found, before = np.zeros(z.size), 0.0
    for section in result.scenario.part.sections:  # type: ignore[attr-defined]
        found[z >= before - 1e-12] = 0.5 * section.diameter
        before += section.length
    return found


def _shaft(z: FloatArray, radius: FloatArray, error: FloatArray, times: float) -> Surface:
    """The surface of revolution through the stations, along x of the scene, with flat ends; its error drawn ``times``."""
    steps = np.flatnonzero(np.diff(radius) != 0.0)
    wide = radius + 0.5 * times * error
    at, wide = (
        np.insert(z, steps + 1, z[steps + 1]),
        np.insert(wide, steps + 1, (wide - radius)[steps + 1] + radius[steps]),
    )
    shown = np.insert(error, steps + 1, np.nan)
    at, wide, shown = (np.concatenate([[v[0]], v, [v[-1]]]) for v in (at, wide, shown))
    wide[0] = wide[-1] = 0.0
    shown[0] = shown[-1] = np.nan
    points, corners = revolved(at, wide, _ROUND)
    return Surface("shaft", points, corners, "work", np.repeat(shown, _ROUND + 1), "error")


def _holding(result: "Result", length: float, radius: FloatArray) -> tuple[Surface, ...]:
    """The chuck or centre at the headstock and the centre at the tailstock, as large as the shaft asks for."""
    lathe = result.scenario.lathe  # type: ignore[attr-defined]
    near, far, large = float(radius[0]), float(radius[-1]), 2.5 * float(radius.max())
    cone = np.array(
        [[0.0, 0.0], [0.8, 0.8], [0.8, 1.6], [4.0, 1.6], [4.0, 0.0]]
    )  # outward, wide; of the end of the shaft
    chuck = np.array([[0.0, near], [0.0, large], [large, large], [large, 0.0]])
    head = chuck if lathe.headstock == "chuck" else near * cone
    found = [Surface(lathe.headstock, *revolved(-head[:, 0], head[:, 1]), "machine")]
    if lathe.tailstock == "centre":
        found.append(Surface("live centre", *revolved(length + far * cone[:, 0], far * cone[:, 1]), "machine"))
    return tuple(found)


def _insert(result: "Result") -> Tool:
    """The insert with its edges where the angles put them, and its holder; the tip is the lowest point of the nose."""
    tool = result.scenario.tool  # type: ignore[attr-defined]
    towards = -1.0 if result.scenario.operation.towards == "headstock" else 1.0  # type: ignore[attr-defined]
    nose, lead, trail = tool.nose_radius, tool.lead_angle, tool.trail_angle
    long = max(_EDGE, 8.0 * nose)
    angle = np.linspace(-trail, lead, 25)
    round_ = nose * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])
    major, minor = np.array([np.cos(lead), np.sin(lead)]), np.array([-np.cos(trail), np.sin(trail)])
    edge = np.concatenate([round_, [round_[-1] + long * major, long * (major + minor), round_[0] + long * minor]])
    lean = 0.95 * major[0] - 0.05
    shank = long * np.array([
        [-0.15, 0.35], [lean, 0.95 * major[1]], [lean, 5.0], [lean - 1.5, 5.0], [lean - 1.5, 1.3]
    ])  # fmt: skip
    turn = np.array([towards, 1.0])
    return Tool(np.zeros((0, 2)), np.zeros((0, 2)), bodies=(
        Body(*plate(edge * turn, 0.0, 0.35 * long)), Body(*plate(shank * turn, 0.35 * long, 1.6 * long), holds=True)
    ))  # fmt: skip
