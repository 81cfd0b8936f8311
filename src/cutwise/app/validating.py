"""``cutwise validate``: a scenario held against a measurement."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cutwise.app import outputs
from cutwise.app.exits import OK, REQUIREMENT_FAILED
from cutwise.app.options import SET, Overrides
from cutwise.disk import write_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from cutwise.study.recording import Recording
    from cutwise.study.validate import Figures, Validation

_OWN = ("validate.", "data.")  # settings that are none of the scenario


def validate(
    data: Annotated[
        Path, typer.Argument(metavar="DATA", help="measured data (CSV, units in the titles): a run for each row, or time first")
    ],
    file: Annotated[Path, typer.Argument(metavar="SCENARIO", help="scenario that stands for what no column says")],
    overrides: Overrides = None,
    report: Annotated[
        Path | None, typer.Option("--report", metavar="FILE", help="write a page: measured over predicted, or the overlay")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="print one JSON object (SI) and nothing else on standard output")
    ] = False,
) -> None:  # fmt: skip
    """Hold a scenario against a measurement: one run for each row, or a recording laid over a run."""
    from cutwise.app.console import Console
    from cutwise.io.scenario import load, settings
    from cutwise.spec.calibration import Validation as Settings
    from cutwise.spec.faults import all_faults
    from cutwise.study.recording import is_recording, recorded
    from cutwise.study.validate import validated

    given = overrides or []
    own = [text for text in given if text.startswith(_OWN)]
    read: dict[str, object] = {}
    all_faults(
        lambda: read.update(scenario=load(file, [text for text in given if text not in own], named=SET)),
        lambda: read.update(settings=settings(Settings, own, named=SET)[0]),
    )
    scenario, said = read["scenario"], read["settings"]
    outputs.checked([report], [data, file, *scenario.files])  # type: ignore[attr-defined]
    console = Console()
    over_time = is_recording(data)
    chosen = said.validate  # type: ignore[attr-defined]
    with console.progress(f"validate {data.name}") as progress:
        found: Recording | Validation = (
            recorded(scenario, data, chosen.delay, said.data, progress)  # type: ignore[arg-type, attr-defined]
            if over_time
            else validated(scenario, data, chosen.noise, progress, named=SET)  # type: ignore[arg-type]
        )
        files = {}
        if report is not None:
            from cutwise.app.validation_page import page

            files["report"] = str(write_text(report, page(found)))
    if as_json:
        import json

        print(json.dumps(found.as_json(files), allow_nan=False))
    else:
        for line in shown(found):
            console.line(line)
        for path in files.values():
            console.line(f"report: {path}")
    raise typer.Exit(REQUIREMENT_FAILED if getattr(found, "failed", ()) else OK)


def shown(found: "Recording | Validation") -> "Iterator[str]":
    """A validation as text."""
    from cutwise import units
    from cutwise.study.recording import Recording

    if isinstance(found, Recording):
        how = "fitted" if found.fitted else "as stated"
        yield f"{found.data.file}: {len(found.time)} samples over a run of {found.result.scenario.name}"
        yield f"the recording lags by {units.show(found.delay, 'time', 6)} ({how}); channels that are +x, +y, +z: {found.axes}"
    else:
        yield f"{found.data.file}: {found.data.rows} rows, runs of {found.scenario.name}"
    yield from _aligned(list(table(found)))
    yield from (f"not run: {text}" for text in getattr(found, "failed", ()))
    yield from (f"warning: {text}" for text in found.warnings)


def table(found: "Recording | Validation") -> "Iterator[tuple[str, ...]]":
    """Figures of all columns, titles first."""
    from cutwise import units
    from cutwise.study.recording import Recording

    if isinstance(found, Recording):
        yield "column", "mean", "measured", "peak to peak", "measured", "rms of difference", "correlation"
        for name, one in found.laid.items():
            told = one.as_json()
            keys = ("mean", "measured_mean", "peak_to_peak", "measured_peak_to_peak", "rms")
            correlation = f"{told['correlation']:.4f}" if "correlation" in told else "-"
            yield (name, *(units.show(told[key], one.dimension, 4) for key in keys), correlation)
        return
    known = type(found.scenario).measures
    yield "measure", "rows", "rms of error", "bias", "correlation", "inside the 90 % band"
    for name, figures in found.figures.items():
        yield (name, *_row(figures, known[name].dimension))
    for group, of in found.groups.items():
        for name, figures in of.items():
            yield (f"{name} ({group})", *_row(figures, known[name].dimension))


def _row(figures: "Figures", dimension: str) -> tuple[str, ...]:
    from cutwise import units

    correlation = "-" if figures.correlation is None else f"{figures.correlation:.4f}"
    inside = "-" if figures.inside is None else f"{figures.inside:.1%}"
    return (
        str(figures.rows), units.show(figures.rms, dimension, 4), units.show(figures.bias, dimension, 3), correlation, inside,
    )  # fmt: skip


def _aligned(rows: "list[tuple[str, ...]]") -> "Iterator[str]":
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        yield "  ".join(f"{cell:<{width}}" for cell, width in zip(row, wide, strict=True)).rstrip()
