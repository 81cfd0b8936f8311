"""The pictures of the documentation, drawn from runs of the program: ``python docs/pictures/draw.py [FOLDER]``."""

import ast
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

import cutwise

HERE = Path(__file__).resolve().parent
EXAMPLE = HERE.parent.parent / "examples" / "deburr_compliant_spindle.yaml"
AMPLITUDE = 0.2  # [mm] of the path error
FREQUENCIES = (0.5, 2.0, 5.0, 10.0, 20.0)  # [Hz]
LAWS = {"set_valued": "seals stick and slip", "presliding": "elastic seals, 50 µm", "none": "no seal friction"}
ROOMS = {  # of the code, and where they stand in its picture
    "app": (1.6, 7.2), "study": (1.6, 6.3), "process": (1.6, 5.4), "results": (0.0, 4.5), "io": (1.0, 4.5), "still": (3.0, 4.9),
    "loop": (3.0, 4.1), "paths": (4.3, 4.1), "run_file": (0.0, 3.5), "physics": (4.3, 3.2), "balance": (3.0, 3.2),
    "programs": (-0.2, 1.5), "spec": (1.0, 1.5), "stages": (3.6, 2.3), "records": (4.3, 1.5), "units": (1.0, 0.3),
    "maths": (3.0, 0.3),
}  # fmt: skip
COLOURS = {"set_valued": "#c0392b", "presliding": "#2c6fbb", "none": "#3a8f4d"}
STYLE = {
    "svg.fonttype": "none", "svg.hashsalt": "cutwise", "font.size": 9, "axes.spines.top": False,
    "axes.spines.right": False, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.2,
    "path.simplify_threshold": 0.5,
}  # fmt: skip


def edge_error(frequency: float, law: str, periods: float = 4.0) -> tuple[np.ndarray, np.ndarray]:
    """Time since the end of the lead-in [s] and edge error at the tool [mm] under a sine path error."""
    lead_in = 0.2
    scenario = cutwise.load(
        EXAMPLE,
        [
            f"operation.path_error={{amplitude: {AMPLITUDE} mm, frequency: {frequency} Hz}}",
            f"operation.duration={lead_in + periods / frequency} s",
            f"spindle.friction={law}",
            "numerics.time_step=50 us",
        ],
    )
    surface = cutwise.simulate(scenario)["surface"]
    return surface.time.values - lead_in, 1e3 * surface.error_at_tool.values


def absorbed(frequency: float, law: str) -> tuple[float, float]:
    """Edge error peak to peak and its mean over the last two of four periods [mm]."""
    time, error = edge_error(frequency, law)
    late = error[time >= 2.0 / frequency]
    return float(np.ptp(late)), float(late.mean())


def path_error() -> Figure:
    """What compliance does and does not absorb of a path error of 0.2 mm."""
    figure, (wave, whole, middle) = plt.subplots(1, 3, figsize=(9.6, 3.1), layout="constrained")
    for law, label in LAWS.items():
        time, error = edge_error(2.0, law)
        shown = slice(int(np.searchsorted(time, 1.0)), None, 50)
        wave.plot(time[shown], error[shown], color=COLOURS[law], label=label)
        found = np.array([absorbed(f, law) for f in FREQUENCIES])
        whole.semilogx(FREQUENCIES, found[:, 0], "o-", color=COLOURS[law], ms=4)
        middle.semilogx(FREQUENCIES, found[:, 1], "o-", color=COLOURS[law], ms=4)
    time = np.linspace(1.0, 2.0, 200)
    wave.plot(time, AMPLITUDE * np.sin(4 * np.pi * time), "k:", lw=0.9, label="path of the robot")
    whole.axhline(2 * AMPLITUDE, color="k", ls=":", lw=0.9)
    middle.axhline(0.0, color="k", ls=":", lw=0.9)
    wave.set(title="2 Hz", xlabel="time [s]", ylabel="edge error e [mm]")
    whole.set(title="peak to peak", ylabel="e peak to peak [mm]", ylim=(0, 0.44))
    middle.set(title="mean", ylabel="mean e [mm]")
    for axes in (whole, middle):
        axes.set_xlabel("frequency of the path error [Hz]")
        axes.set_xticks(FREQUENCIES, [f"{f:g}" for f in FREQUENCIES])
        axes.minorticks_off()
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure


def reference() -> Figure:
    """Burr forces and edge error of the reference case: Figs. 15 and 16 of Berselli et al. 2016."""
    result = cutwise.simulate(cutwise.load(EXAMPLE))
    figure, (forces, edge) = plt.subplots(1, 2, figsize=(9.6, 3.1), layout="constrained")
    force = result["cutting"].burr_force.isel(time=slice(None, None, 150))
    for axis, name in zip("xyz", ("along the feed", "off the work", "along the spindle"), strict=True):
        forces.plot(force.time, force.sel(axis=axis), label=f"{axis}, {name}")
    forces.set(xlabel="time [s]", ylabel="burr force on the mill [N]", title="force of the burr")
    forces.legend(frameon=False, fontsize=8)
    surface = result["surface"]
    low, high = (1e3 * result.measures[f"surface_error_{end}"].value for end in ("loaded", "unloaded"))
    along = surface.w.values[::12] * 1e3
    edge.fill_between(along, low, high, color="0.88", label="band in which friction can hold the tool")
    edge.plot(along, 1e3 * surface.burr_height.values[::12], color="0.5", ls="--", label="burr before the pass")
    edge.plot(along, 1e3 * surface.error.values[::12], color=COLOURS["set_valued"], label="edge left behind")
    edge.set(xlabel="position along the edge [mm]", ylabel="height above the nominal edge [mm]", title="edge")
    edge.legend(frameon=False, fontsize=8, loc="upper right", bbox_to_anchor=(1.0, 0.94))
    return figure


def imports(source: Path = Path(cutwise.__file__).parent) -> set[tuple[str, str]]:
    """Which room of the code imports which: folders and modules of `src/cutwise`, as its import statements say."""
    found = set()
    for file in source.rglob("*.py"):
        room = file.relative_to(source).with_suffix("").parts[0]
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.ImportFrom) or (node.module or "").split(".")[0] != "cutwise":
                continue
            inner = (node.module or "").split(".")[1:2]
            found |= {(room, other) for other in inner or [name.name for name in node.names]}
    return {(a, b) for a, b in found if a != b and {a, b} <= set(ROOMS)}


def needed(arrows: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """The arrows without those that others lead to as well."""
    left = set(arrows)

    def leads(a: str, b: str, seen: frozenset[str] = frozenset()) -> bool:
        return any(y == b or (y not in seen and leads(y, b, seen | {y})) for x, y in left if x == a)

    for arrow in sorted(arrows):
        left.discard(arrow)
        if not leads(*arrow):
            left.add(arrow)
    return left


def architecture() -> Figure:
    """The rooms of the code and who imports whom; every arrow bears its name in the file."""
    figure, plot = plt.subplots(figsize=(8.2, 6.4), layout="constrained")
    boxes = {}
    for name, place in ROOMS.items():
        kernel = name in ("physics", "loop", "still", "balance", "stages", "records", "paths", "maths")
        box = {"boxstyle": "round,pad=0.5", "facecolor": "#dfeaf6" if kernel else "#f4ead9", "edgecolor": "0.4"}
        boxes[name] = plot.text(*place, name, ha="center", va="center", fontsize=10, bbox=box).get_bbox_patch()
    for a, b in sorted(needed(imports())):
        style = {
            "arrowstyle": "-|>",
            "color": "0.45",
            "patchA": boxes[a],
            "patchB": boxes[b],
            "shrinkA": 0,
            "shrinkB": 1,
        }
        patch = plot.annotate("", ROOMS[b], ROOMS[a], arrowprops=style).arrow_patch
        assert patch is not None
        patch.set_gid(f"import-{a}-{b}")
    plot.set(xlim=(-0.6, 4.6), ylim=(-0.5, 7.5))
    plot.axis("off")
    return figure


PICTURES: Mapping[str, Callable[[], Figure]] = {
    "path_error.svg": path_error,
    "reference.svg": reference,
    "imports.svg": architecture,
}


def main(folder: Path) -> None:
    """Draw all pictures into a folder."""
    with plt.rc_context(STYLE):
        for name, draw in PICTURES.items():
            figure = draw()
            figure.savefig(folder / name, metadata={"Date": None})
            plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
