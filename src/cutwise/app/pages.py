"""Pages as one file without outside requests: their templates."""

import re
from functools import lru_cache
from importlib.resources import files

import jinja2


def breakable(name: str) -> str:
    """A long name that may break after an underscore or a dot."""
    from markupsafe import Markup, escape

    return Markup(re.sub(r"([_.])", r"\1<wbr>", str(escape(name))))


@lru_cache(maxsize=8)
def template(name: str) -> jinja2.Template:
    """The template of a page; text is escaped, and a name that is not given is an error."""
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.filters["breakable"] = breakable
    return environment.from_string((files("cutwise.app") / "templates" / f"{name}.html.j2").read_text(encoding="utf-8"))
