"""The scenario that a run file or a report of cutwise carries, as the document that it was written from."""

import json
from html.parser import HTMLParser
from typing import Any

from cutwise.run_file import DamagedRun, attribute
from cutwise.spec.faults import Fault, ScenarioFault


def document_of_run(content: bytes, shown: str) -> Any:
    """Of the bytes of a run file; ``shown`` is its name in messages."""
    try:
        text = attribute(content, "scenario")
    except DamagedRun as damage:
        raise ScenarioFault([Fault((), str(damage), file=shown)]) from None
    return _read(text, shown, "run file")


def _read(text: object, shown: str, kind: str) -> Any:
    try:
        return json.loads(text)  # type: ignore[arg-type]
    except RecursionError:
        message = "its scenario is nested too deeply to be one"
    except (TypeError, ValueError):
        message = f"holds no scenario: it is not a {kind} of cutwise"
    raise ScenarioFault([Fault((), message, file=shown)])


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
    return _read(script.text, shown, "report")
