"""The pictures of the documentation, drawn from runs of the program: ``python docs/pictures/draw.py [FOLDER]``."""

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


PICTURES: Mapping[str, Callable[[], Figure]] = {"path_error.svg": path_error, "reference.svg": reference}


def main(folder: Path) -> None:
    """Draw all pictures into a folder."""
    with plt.rc_context(STYLE):
        for name, draw in PICTURES.items():
            figure = draw()
            figure.savefig(folder / name, metadata={"Date": None})
            plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
