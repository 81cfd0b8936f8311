"""Pages as one file without outside requests: their templates."""

import re
from functools import lru_cache
from importlib.resources import files

import jinja2


def breakable(name: str) -> str:
    """A long name that may break after an underscore or a dot."""
    from markupsafe import Markup, escape

    return Markup(re.sub(r"([_.])", r"\1<wbr>", str(escape(name))))


def sentence(text: str) -> str:
    """A capital at the beginning, unless what stands there is a key or a measure: those are written as they are.

    Examples
    --------
    >>> sentence("all are met"), sentence("robot.tool_rotation is off"), sentence("skating_ratio is large")
    ('All are met', 'robot.tool_rotation is off', 'skating_ratio is large')
    """
    first = text.split(maxsplit=1)[0] if text.strip() else ""
    return text if re.search(r"[_=]|\.\w", first) else text[:1].upper() + text[1:]


@lru_cache(maxsize=8)
def template(name: str) -> jinja2.Template:
    """The template of a page; text is escaped, and a name that is not given is an error."""
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters["breakable"] = breakable
    environment.filters["sentence"] = sentence
    return environment.from_string((files("cutwise.app") / "templates" / f"{name}.html.j2").read_text(encoding="utf-8"))
