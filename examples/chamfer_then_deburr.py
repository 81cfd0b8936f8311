"""From a chamfer path to the width that a compliant spindle leaves on it: three cases, one table.

1. The base chamfer at 5 bar: its force is far below breakaway, the spindle does not move, the width is the rigid one.
2. A wide chamfer at 2 bar on a part that stands 0.1 mm too near, with a preset: the spindle yields.
3. The same with a burr along the edge.

Run: python examples/chamfer_then_deburr.py
"""

from pathlib import Path

import cutwise

HERE = Path(__file__).parent
CASES = {
    "base, 5 bar": ("chamfer.width=0.3 mm", "spindle.pressure=5 bar", "operation.preset=0 mm", "operation.part_error=0 mm",
                    "requirements={}"),
    "0.9 mm, 2 bar": (),
    "with a burr": ("part.burr={height: 0.3 mm, width: 0.2 mm, on: face}",),
}  # fmt: skip
SHOWN = {
    "lateral_force_max": (1.0, "N"), "breakaway_force": (1.0, "N"), "tip_deflection_max": (1e3, "mm"),
    "width_min": (1e3, "mm"), "width_max": (1e3, "mm"), "width_deflected_min": (1e3, "mm"),
    "width_deflected_max": (1e3, "mm"),
}  # fmt: skip


def main() -> None:
    """Run all cases and print what they come to."""
    results = {
        name: cutwise.simulate(cutwise.load(HERE / "chamfer_compliant_spindle.yaml", changes))
        for name, changes in CASES.items()
    }
    print(f"{'':20}" + "".join(f"{name:>16}" for name in CASES))
    for measure, (factor, unit) in SHOWN.items():
        values = "".join(f"{factor * result.measures[measure].value:16.4f}" for result in results.values())
        print(f"{measure:20}{values}  {unit}")


if __name__ == "__main__":
    main()
