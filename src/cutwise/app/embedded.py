"""The viewer inside a page that is one file: its script with the digest that a policy allows, its style, its data."""

import base64
import hashlib
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, NamedTuple

from cutwise.later import later

if TYPE_CHECKING:
    from cutwise.app.scene import rows, view
    from cutwise.results import Result
else:
    rows, view = later("cutwise.app.scene.rows"), later("cutwise.app.scene.view")


class Embedded(NamedTuple):
    """What a page holds of the viewer; nothing where there is none."""

    script: str = ""
    digest: str = ""  # of the script, as a Content-Security-Policy names it
    style: str = ""
    data: str = ""
    program: bool = False  # whether the text of a program is in the data
    why: str = ""  # there is none


@lru_cache(maxsize=2)
def static(name: str) -> str:
    """A file of the bundle."""
    return (files("cutwise.app") / "page" / "static" / name).read_text(encoding="utf-8")


def embedded(result: "Result") -> Embedded:
    """The viewer of a run; the reason where the run has nothing to be seen."""
    try:
        data = view.for_report(result)
    except rows.NothingToSee as missing:
        return Embedded(why=f"There is nothing to be seen in 3D of this run: {missing}.")
    except Exception as error:  # a picture that fails must not cost the run
        return Embedded(
            why=f"The view of this run could not be made ({type(error).__name__}: {error}); its pictures could."
        )
    script = static("view.js")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    program = getattr(getattr(result.scenario, "program", None), "text", None)
    return Embedded(script, f"sha256-{digest}", static("view.css"), data, bool(program))
