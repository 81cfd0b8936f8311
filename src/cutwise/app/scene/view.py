"""The view file of a run: its scene in millimetres, its numbers in words, and everything in the units of people."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cutwise import units
from cutwise.app import surety
from cutwise.app.findings import notices, reasons
from cutwise.app.measured import Line, listed
from cutwise.app.numbers import at_a_place, form, titled, typed_unit
from cutwise.app.scene import colours
from cutwise.app.scene.in_force import InForce, in_force
from cutwise.app.scene.packed import Array, as_text, pack
from cutwise.app.scene.rows import of
from cutwise.app.scene.scene import FloatArray, History, Map, Scene
from cutwise.app.scene.thinned import halved, kept
from cutwise.app.scene.worst import badness, magnification, worst
from cutwise.app.verdict_text import verdict_line
from cutwise.later import later

if TYPE_CHECKING:
    from cutwise.results import Result
    from cutwise.spec.scenario import Scenario
else:
    surety = later("cutwise.app.surety")

VERSION = 1
REPORT_ROOM = 2_200_000  # characters of base64 in a report
_MM = units.displayed(1.0, "length")[0]
_LENGTHS = ("length", "small_length")
_APART = 0.1  # of the extent of the places: worst places of a tool without a diameter are no nearer


def view_file(result: "Result") -> bytes:
    """Everything that there is to see of a run, in full."""
    scene = of(result)
    return _packed(result, scene, in_force(result, scene))


def for_report(result: "Result", room: int = REPORT_ROOM) -> str:
    """The view file of a run as text for a page; longer histories are thinned and maps halved until it fits."""
    whole = of(result)
    program = in_force(result, whole)
    scene, text = whole, as_text(_packed(result, whole, program))
    buckets = min(20_000, max(500, whole.clock.size // 8))
    while len(text) > room:
        if scene.map is not None and scene.map.height.size > 40_000:
            scene = _coarser(scene)
        elif buckets >= 100:
            keep = kept([one.values for one in whole.histories.values()], buckets)
            shown = scene.map
            scene = whole.cut_short(keep)
            if shown is not None:  # halved before; owners are those of the whole clock
                scene = _with_map(scene, shown, keep, whole.clock.size)
            buckets //= 2
        elif scene.surfaces:
            scene = _without_the_largest(scene)
        else:
            break
        text = as_text(_packed(result, scene, program))
    return text


def _without_the_largest(scene: Scene) -> Scene:
    """The scene without the surface of most triangles, and a word about it."""
    sizes = [len(one.triangles) for one in scene.surfaces]
    most = sizes.index(max(sizes))
    said = f"{scene.surfaces[most].title} is left out: its {sizes[most]} triangles are too many for a report"
    left = tuple(one for k, one in enumerate(scene.surfaces) if k != most)
    return replace(scene, surfaces=left, said=(*scene.said, said))


def _with_map(scene: Scene, shown: Map, keep: "np.ndarray", count: int) -> Scene:
    if shown.owner is None:
        return replace(scene, map=shown)
    back = np.clip(np.searchsorted(keep, np.arange(count)), 0, keep.size - 1)
    return replace(scene, map=shown._replace(owner=np.where(shown.owner >= 0, back[np.maximum(shown.owner, 0)], -1)))


def _coarser(scene: Scene) -> Scene:
    old = scene.map
    assert old is not None
    error = old.values if old.values is not None else np.full(old.height.shape, np.nan)
    owner = (
        None if old.owner is None else np.nan_to_num(halved(old.owner.astype(float), error), nan=-1.0).astype(np.int64)
    )
    new = old._replace(
        dx=2.0 * old.dx, dy=2.0 * old.dy, height=halved(old.height, error),
        values=None if old.values is None else halved(error, error), owner=owner,
    )  # fmt: skip
    return replace(scene, map=new)


def _packed(result: "Result", scene: Scene, program: InForce | None) -> bytes:
    arrays = dict(_arrays(scene, result.scenario))
    if program is not None:
        arrays["modal"] = Array(program.of_line, "u4", "which of the words in force belong to a line, 0: none")
    return pack(_header(result, scene, program), arrays)


def _header(result: "Result", scene: Scene, program: InForce | None) -> dict[str, Any]:
    scenario = result.scenario
    lines = listed(result)
    return {
        "version": VERSION,
        "name": scenario.name,
        "process": scenario.process,
        "verdict": result.verdict,
        "verdict_text": verdict_line(result),
        "certainty": result.certainty,
        "requirements": [_required(line) for line in lines[""]],
        "measures": {
            line.name: {"value": result.measures[line.name].value, "text": line.text, "title": titled(line.name),
                        "meaning": line.meaning, "group": group}
            for group, members in lines.items() for line in members if line.name in result.measures
        },
        "warnings": [*result.infeasible, *reasons(result), *notices(result), *result.warnings],
        "clock": _clock(scene),
        "program": None if program is None else {"file": program.file, "text": program.text, "modal": program.words},
        "scene": _scene(result, scene),
        "tools": [
            {"cutter": (_MM * tool.cutter).tolist(), "holder": (_MM * tool.holder).tolist(),
             "fixed": (_MM * tool.fixed).tolist(), "rods": (_MM * tool.rods).tolist(), "pivot": _MM * tool.pivot,
             "bodies": [one.holds for one in tool.bodies]}
            for tool in scene.tools
        ],
        "deflection": _deflection(scene),
        "colour": _colour(scene, scenario),
        "worst": list(_worst(scene, scenario)),
    }  # fmt: skip


def _required(line: Line) -> dict[str, Any]:
    check = line.check
    return {
        "measure": line.name, "title": titled(line.name), "text": line.text, "asked": line.asked, "meaning": line.meaning,
        "pass": None if check is None else check.passed, "implied": check is not None and check.implied,
    }  # fmt: skip


def _clock(scene: Scene) -> dict[str, Any]:
    """Beginning and step of an even clock; null steps where the array ``time`` tells each instant."""
    dimension = "time" if scene.clock_is == "time" else "length"
    factor, unit = units.displayed(1.0, dimension)
    told = {"is": scene.clock_is, "unit": unit, "factor": factor, "n": int(scene.clock.size), "t0": None, "dt": None}
    if _even(scene.clock):
        n = scene.clock.size
        told |= {"t0": float(scene.clock[0]), "dt": float((scene.clock[-1] - scene.clock[0]) / max(1, n - 1))}
    return told


def _even(clock: FloatArray) -> bool:
    if clock.size < 2:
        return True
    even = np.linspace(clock[0], clock[-1], clock.size)
    return bool(clock[-1] > clock[0] and np.abs(clock - even).max() <= 1e-6 * (clock[-1] - clock[0]) / clock.size)


def _scene(result: "Result", scene: Scene) -> dict[str, Any]:
    shown = scene.map
    return {
        "surfaces": [
            {"title": one.title, "tint": one.tint, "coloured": one.coloured if one.values is not None else "",
             "faces": {str(number): name for number, name in one.names.items()}}
            for one in scene.surfaces
        ],
        "map": None if shown is None else {
            "x": _MM * shown.x, "y": _MM * shown.y, "dx": _MM * shown.dx, "dy": _MM * shown.dy, "top": _MM * shown.top,
            "bottom": _MM * shown.bottom, "coloured": shown.coloured if shown.values is not None else "",
            "removed": _removed(shown),
        },
        "outlines": len(scene.outlines),
        "links": None if scene.links is None else list(scene.links.shape[:2]),
        "links_are": scene.links_are,
        "focus": None if scene.focus is None else [(_MM * corner).tolist() for corner in scene.focus],
        "path": scene.path,
        "front": list(scene.front or FRONT.get(result.scenario.process, (0.0, -1.0, 0.0))),
        "said": list(scene.said),
        "unit": units.displayed(1.0, "length")[1],
    }  # fmt: skip


FRONT: Mapping[str, tuple[float, float, float]] = {"deburr": (0.0, 1.0, 0.0)}  # from where the front is seen


def _removed(shown: Map) -> str:
    left = np.where(np.isnan(shown.height), shown.bottom, shown.height)
    return units.show(float((shown.top - left).sum() * shown.dx * shown.dy), "volume", 5)


def _deflection(scene: Scene) -> dict[str, Any] | None:
    if scene.deflection is None or not scene.tools:
        return None
    largest = float(np.nanmax(np.linalg.norm(scene.deflection, axis=1), initial=0.0))
    return {
        "k": scene.magnified or magnification(scene.radius, largest),
        "largest": units.show(largest, "small_length", 3),
    }


def _colour(scene: Scene, scenario: "Scenario") -> dict[str, Any]:
    """The tables, and the range of each history that something may be coloured by."""
    choices = {}
    for name, one in scene.histories.items():
        factor, unit = _unit_of(one, scenario)
        found = colours.spread(one.values, one.low, one.high, one.nominal)
        choices[name] = {
            "title": one.title, "table": found.table, "low": found.low, "high": found.high,
            "ticks": [{"at": at, "text": _number(factor * at)} for at in (found.low, *found.ticks, found.high)],
            "limits": [end for end in (one.low, one.high) if end is not None],
            "unit": unit, "factor": factor, "ends": list(one.ends), "path": one.coloured, "plot": one.drawn,
        }  # fmt: skip
    first = next((n for n in (f"{scene.judged}_period", scene.judged) if n in scene.histories), "")
    return {"tables": colours.as_header(), "choices": choices, "first": first, "judged": scene.judged}


def _unit_of(one: History, scenario: "Scenario") -> tuple[float, str]:
    """Factor and unit in which a history is shown: those of its limit as it was typed, else of its largest value."""
    typed = typed_unit(scenario, one.measures)
    if typed is not None:
        return 1.0 / typed[1], typed[0]
    ends = [abs(end) for end in (one.low, one.high) if end is not None]
    known = one.values[np.isfinite(one.values)]
    shape = form(one.dimension, ends or [float(np.abs(known).max()) if known.size else 0.0])
    return 1.0 / shape.scale, shape.unit


def _number(value: float) -> str:
    text = f"{value:.4g}"
    return f"{float(text):.0f}" if "e+0" in text else text


def _worst(scene: Scene, scenario: "Scenario") -> Iterator[dict[str, Any]]:
    one = scene.histories.get(scene.judged)
    if one is None:
        return
    factor, unit = _unit_of(one, scenario)
    bad = badness(one.values, one.low, one.high)
    if scene.counted is not None:
        bad = np.where(scene.counted, bad, np.nan)
    for sample in worst(bad, scene.place, scene.line, 2.0 * scene.radius or _APART * _extent(scene)):
        at = units.show(float(scene.clock[sample]), "time" if scene.clock_is == "time" else "length", 5)
        value = at_a_place(float(one.values[sample]), 1.0 / factor, one.low, one.high)
        yield {
            "sample": sample, "value": float(one.values[sample]), "text": f"{value} {unit}".strip(), "at": at,
            "line": 0 if scene.line is None else int(scene.line[sample]),
            "beyond": bool(bad[sample] > 0.0) and (one.low, one.high) != (None, None),
        }  # fmt: skip


def _extent(scene: Scene) -> float:
    """Diagonal of the box about all places [m]."""
    return float(np.linalg.norm(np.ptp(scene.place, axis=0)))


def _arrays(scene: Scene, scenario: "Scenario") -> Iterator[tuple[str, Array]]:
    """Every array by its name; places in mm, histories in SI with the factor for people."""
    if not _even(scene.clock):
        yield "time", Array(scene.clock, "f8", "time", units.displayed(1.0, "time")[1])
    yield "place", Array(_MM * scene.place.T, "u2", "place of the tool", "mm")
    if scene.trace is not None:
        yield "trace", Array(_MM * scene.trace.T, "u2", "path on the part", "mm")
    if scene.axis.shape[0] > 1:
        yield "axis", Array(scene.axis.T, "u2", "tool axis")
    else:
        yield "axis", Array(scene.axis.T, "f8", "tool axis")
    if scene.tool_of is not None:
        yield "tool_of", Array(scene.tool_of, "u1", "tool in the spindle")
    if scene.line is not None:
        yield "line", Array(scene.line, "u4", "line of the program")
    if scene.kind is not None:
        yield "kind", Array(scene.kind, "u1", "kind of the move")
    if scene.deflection is not None:
        yield "deflection", Array(_MM * scene.deflection.T, "u2", "deflection of the tip", "mm")
    for name, one in scene.histories.items():
        factor, unit = _unit_of(one, scenario)
        yield f"h/{name}", Array(one.values, "u2", one.title, unit, factor)
    for number, surface in enumerate(scene.surfaces):
        yield f"s/{number}/point", Array(_MM * surface.points, "f4")
        yield f"s/{number}/corner", Array(surface.triangles, "u4")
        if surface.values is not None:
            yield f"s/{number}/value", Array(surface.values, "u2")
        if surface.face is not None:
            yield f"s/{number}/face", Array(surface.face, "u4")
    for k, tool in enumerate(scene.tools):
        for number, body in enumerate(tool.bodies):
            yield f"t/{k}/{number}/point", Array(_MM * body.points, "f4")
            yield f"t/{k}/{number}/corner", Array(body.triangles, "u4")
    if scene.map is not None:
        yield from _of_map(scene.map)
    for number, line in enumerate(scene.outlines):
        yield f"o/{number}", Array(_MM * line, "f4")
    if scene.links is not None:
        yield "links", Array(_MM * scene.links, "f4")
        yield "link_of", Array(scene.link_of if scene.link_of is not None else np.zeros(scene.clock.size, int), "u4")


def _of_map(shown: Map) -> Iterator[tuple[str, Array]]:
    yield "m/height", Array(_MM * shown.height, "u2", "height", "mm")
    if shown.values is not None:
        yield "m/value", Array(shown.values, "u2")
    if shown.owner is not None:
        yield "m/owner", Array(np.where(shown.owner < 0, 0xFFFFFFFF, shown.owner), "u4", "sample that cut it last")
