"""The words in force along the program of a run, each text once: what the program pane shows of the line at now."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.app.scene.scene import IntArray, Scene
from cutwise.io.program_setup import setup_of
from cutwise.programs.modal import modal
from cutwise.spec.faults import ScenarioFault

if TYPE_CHECKING:
    from cutwise.results import Result


class InForce(NamedTuple):
    """A program, and its modal state by line."""

    file: str
    text: str
    words: tuple[str, ...]
    of_line: IntArray  # by line from 1: number of the words from 1, 0 where a line does not run


def in_force(result: "Result", scene: Scene) -> InForce | None:
    """The program as the scenario holds it, and what is in force behind its lines; None where the scene follows none.

    A program of an older run that could not be run any more has no words.
    """
    given = getattr(result.scenario, "program", None)
    text = getattr(given, "text", None)
    if scene.line is None or given is None or not text:
        return None
    file = str(getattr(given, "file", None) or "program")
    try:
        states = modal(text, file, setup_of(given))
    except ScenarioFault:
        states = {}
    words = {told: k for k, told in enumerate(dict.fromkeys(states.values()), 1)}
    of_line = np.zeros(text.count("\n") + 2, np.int64)
    for line, told in states.items():
        of_line[line] = words[told]
    return InForce(file, text, tuple(words), of_line)
