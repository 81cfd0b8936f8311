"""One thing of a run as one file: its lines as a table, its machined stock as a solid."""

from pathlib import Path
from typing import TYPE_CHECKING

from cutwise.io.export import csv
from cutwise.io.solid_files import ENDINGS, NoSurface, surface_bytes, surface_of

if TYPE_CHECKING:
    import xarray as xr

KINDS = ("lines", "surface")


class NothingThere(ValueError):
    """What is asked for is not in the run, or is not known."""


def one_file(what: str, stages: "xr.DataTree", source: Path, output: Path | None) -> tuple[Path, bytes]:
    """Where it goes, and its bytes.

    Raises
    ------
    NothingThere
        The run holds none of it, or the word or the ending is not known.
    """
    if what == "lines":
        if "lines" not in stages.children:
            raise NothingThere(f"{source}: holds no lines: that takes a program in a stock in 3D")
        return output or source.with_name("lines.csv"), csv(stages["lines"].to_dataset(), ("move",)).encode()
    if what == "surface":
        target = output or source.with_name("surface.ply")
        if target.suffix.lower() not in ENDINGS:
            raise NothingThere(f"{target}: its ending says no format; write {', '.join(ENDINGS)}")
        if "sweep_2" in stages.children:
            raise NothingThere(
                f"{source}: what several set-ups have left is no surface over one plan: no file of it is written; the next run "
                "goes on from it with stock: {run: ...}"
            )
        try:
            return target, surface_bytes(surface_of(stages), target.suffix.lower())
        except NoSurface as fault:
            raise NothingThere(f"{source}: {fault}") from None
    raise NothingThere(f'"{what}" cannot be exported by itself; there are {", ".join(KINDS)}')
