"""The scenario that a run file or a report of cutwise carries, as the document that it was written from."""

import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from cutwise.spec.faults import Fault, ScenarioFault


def document_of_run(path: Path, shown: str) -> Any:
    """Of a run file; ``shown`` is its name in messages."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            text = file.attrs.get("scenario")
        return json.loads(text)
    except (OSError, TypeError, ValueError):
        raise ScenarioFault([Fault((), "holds no scenario: it is not a run file of cutwise", file=shown)]) from None


class _ScenarioScript(HTMLParser):
    """Finds ``<script type="application/json" id="scenario">``."""

    def __init__(self) -> None:
        super().__init__()
        self.inside = False
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.inside = tag == "script" and ("id", "scenario") in attrs

    def handle_endtag(self, tag: str) -> None:
        self.inside = self.inside and tag != "script"

    def handle_data(self, data: str) -> None:
        self.text += data if self.inside else ""


def document_of_report(html: str, shown: str) -> Any:
    """Of the text of a report; ``shown`` is its name in messages."""
    script = _ScenarioScript()
    script.feed(html)
    try:
        return json.loads(script.text)
    except ValueError:
        raise ScenarioFault([Fault((), "holds no scenario: it is not a report of cutwise", file=shown)]) from None
