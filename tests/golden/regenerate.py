"""Write golden files anew: python tests/golden/regenerate.py [EXAMPLE ...]. Read the diff before you commit it."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cutwise.results import Result

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent.parent / "src"))


def run(scenario: Path) -> Result:
    """The run of an example."""
    from cutwise.io.scenario import load
    from cutwise.process.recipes import simulate

    return simulate(load(scenario))


def golden(result: Result) -> dict[str, object]:
    """What a golden file holds: verdict, warnings and measures in SI to nine figures."""
    return {
        "verdict": result.verdict,
        "warnings": list(result.warnings),
        "findings": [
            " ".join(filter(None, (found.code, found.where.name, found.measure))) for found in result.findings
        ],
        "measures": {name: float(f"{measure.value:.9g}") for name, measure in result.measures.items()},
    }


def of_study(file: Path) -> dict[str, float]:
    """What the golden file of a study holds: its numbers in SI to nine figures, of as few cases as tell a change."""
    import cutwise

    few = {"burrs_rare": 100, "burrs_decide": 16}.get(file.stem, 32)
    found = (
        cutwise.run_study(file) if "between" in file.read_text(encoding="utf-8") else cutwise.run_study(file, cases=few)
    )
    return {
        name: float(f"{value:.9g}") for name, value in found.measures.items() if name != "settings_tried"
    }  # the last digits of a run decide how many


def studies() -> list[Path]:
    """Every example of a study."""
    return sorted((HERE.parent.parent / "examples" / "studies").glob("*.yaml"))


def examples() -> list[Path]:
    """Every example scenario."""
    return sorted((HERE.parent.parent / "examples").glob("*.yaml"))


if __name__ == "__main__":
    for path in (one for one in examples() if one.stem in sys.argv[1:] or not sys.argv[1:]):
        target = HERE / f"{path.stem}.json"
        target.write_text(json.dumps(golden(run(path)), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(target.name)
    for path in (one for one in studies() if one.stem in sys.argv[1:] or not sys.argv[1:]):
        target = HERE / f"study_{path.stem}.json"
        target.write_text(json.dumps(of_study(path), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(target.name)
