"""The library entry that a calibration gives: the same bytes and settings give the same entry."""

import io
import math
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

import cutwise
from cutwise import units
from cutwise.io import library
from cutwise.io.measurements import Measurement
from cutwise.spec.calibration import Calibration
from cutwise.spec.faults import split_dotted
from cutwise.spec.scenario import Origin
from cutwise.study.calibrate.kinds import Kind
from cutwise.study.calibrate.posed import Finding


def entry_text(
    kind: Kind, finding: Finding, data: Measurement, settings: Calibration, origins: dict[str, Origin], name: str
) -> str:
    """The entry as YAML.

    Parameters
    ----------
    kind, finding, data, settings
        What was calibrated, and what came out.
    origins : dict
        Of the settings: values that came from a library entry go into the new one with their sources.
    name : str
        Of the entry.
    """
    file = Path(data.file).name
    base = _base(kind, settings)
    new = {key: _sourced(block, file) for key, block in finding.written.items()}
    values = _together(_carried(kind, settings, origins, base), new)
    entry: dict[str, Any] = {
        "name": name,
        "describes": f"{kind.describes}, fitted to {file} ({data.rows} rows, model {finding.model})",
        "values": values,
    }
    covariances = {**_kept(base, new, kind.left_behind), **finding.covariances}
    if covariances:
        entry["covariances"] = covariances
    entry["measured"] = _measured(kind, finding, data, settings)
    yaml = YAML(typ="safe", pure=True)
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.default_flow_style = None  # innermost lists and mappings in one line
    yaml.width = 10_000
    yaml.allow_unicode = True
    stream = io.StringIO()
    yaml.dump(entry, stream)
    return stream.getvalue()


def _sourced(block: dict[str, Any], file: str) -> dict[str, Any]:
    """A block, or a section of blocks, whose sources name the file."""
    if "source" in block:
        return {**block, "source": block["source"].format(file=file)}
    return {key: _sourced(inner, file) for key, inner in block.items()}


def _measured(kind: Kind, finding: Finding, data: Measurement, settings: Calibration) -> dict[str, Any]:
    said: dict[str, Any] = {
        "kind": kind.name, "model": finding.model, "file": Path(data.file).name, "sha256": data.sha256, "rows": data.rows,
        "residual": units.text(finding.residual, finding.residual_dimension),
    }  # fmt: skip
    if finding.left_out_error is not None and math.isfinite(finding.left_out_error):
        relative = finding.left_out_dimension == "dimensionless"
        error = finding.left_out_error
        said["left_out_error"] = error if relative else units.text(error, finding.left_out_dimension)
    said["range"] = {
        column: [units.text(low, dimension), units.text(high, dimension)]
        for column, (dimension, low, high) in ranges(kind, data, settings).items()
    }
    date = settings.measured.date or data.date
    return {**said, **({"date": date} if date else {}), "version": cutwise.__version__}


def ranges(kind: Kind, data: Measurement, settings: Calibration) -> dict[str, tuple[str, float, float]]:
    """Dimension, least and largest value of every column that was used."""
    dimensions = {channel.name: channel.dimension for channel in kind.channels(settings)}
    return {
        name: (dimensions[name] or "dimensionless", float(values.min()), float(values.max()))
        for name, values in data.columns.items()
    }


def _base(kind: Kind, settings: Calibration) -> dict[str, Any]:
    """The library entry that the new one completes, as it is written; empty if there is none."""
    label = getattr(settings, kind.completes).library if kind.completes else None
    if not label:
        return {}
    path = Path(label) if library.is_file(label) else library.FOLDER / kind.shelf / f"{label}.yaml"
    return dict(YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8")))


def _carried(kind: Kind, settings: Calibration, origins: dict[str, Origin], base: dict[str, Any]) -> dict[str, Any]:
    """The values of the section that the new entry completes: of its library entry, and those given beside it."""
    section = kind.completes
    if not section:
        return {}
    given = getattr(settings, section)
    values: dict[str, Any] = dict(base.get("values", {}))
    said = given.model_dump(mode="json", exclude_none=True)
    for key in type(given).model_fields:
        inside = [o for path, o in origins.items() if path.startswith(f"{section}.{key}")]
        if key != "library" and inside and not any(o.library for o in inside):
            values[key] = {"value": said[key], "status": "user", "source": "given with the calibration"}
    return {key: value for key, value in values.items() if key not in kind.left_behind}


def _together(weak: dict[str, Any], strong: dict[str, Any]) -> dict[str, Any]:
    """Both in one, section by section; where both hold a value, the strong one wins."""
    both = dict(weak)
    for key, block in strong.items():
        there = both.get(key)
        sections = isinstance(there, dict) and isinstance(block, dict) and "value" not in there and "value" not in block
        both[key] = _together(there, block) if sections else block  # type: ignore[arg-type]
    return both


def _kept(base: dict[str, Any], new: dict[str, Any], left_behind: tuple[str, ...]) -> dict[str, Any]:
    """Covariances of the completed entry, of those of its values that are still there."""
    found = {}
    for name, block in base.get("covariances", {}).items():
        kept = [k for k, one in enumerate(block["of"]) if not _replaced(split_dotted(one), new, left_behind)]
        if not kept:
            continue
        each = {key: block[key] for key in ("as", "unit") if key in block}
        each = {key: [one[k] for k in kept] if isinstance(one, list) else one for key, one in each.items()}
        found[name] = {
            **block, **each, "of": [block["of"][k] for k in kept],
            "matrix": [[block["matrix"][i][j] for j in kept] for i in kept],
        }  # fmt: skip
    return found


def _replaced(path: tuple[str | int, ...], new: dict[str, Any], left_behind: tuple[str, ...]) -> bool:
    """Whether a value of the completed entry is another one now, or gone."""
    if path[0] in left_behind:
        return True
    here: Any = new
    for step in path:
        if not isinstance(here, dict) or step not in here:
            return False
        here = here[step]
        if isinstance(here, dict) and "value" in here:
            return True
    return True
