"""Bibliography: the sources that the program implements, what it took from each, and the misprints found in them."""

from typing import NamedTuple


class Erratum(NamedTuple):
    """A place where a source prints something else than what it must mean."""

    place: str
    printed: str
    correct: str
    test: str  # the test that asserts the misprint, as file::name


class Source(NamedTuple):
    """A publication, what was implemented from it, and its errata."""

    key: str
    citation: str
    implements: tuple[str, ...] = ()
    errata: tuple[Erratum, ...] = ()


SOURCES: dict[str, Source] = {}


def register(source: Source) -> Source:
    """Add a source; a key is used once."""
    if source.key in SOURCES:
        raise ValueError(f"reference {source.key} is defined twice")
    SOURCES[source.key] = source
    return source


ALTINTAS2012 = register(
    Source(
        "altintas2012",
        "Y. Altintas, Manufacturing Automation: Metal Cutting Mechanics, Machine Tool Vibrations, and CNC Design, "
        "2nd ed., Cambridge University Press, 2012",
        implements=("linear-edge force model of helical end mills (chapter 2)",),
    )
)

BERSELLI2016 = register(
    Source(
        "berselli2016",
        "G. Berselli, M. Pellicciari, G. Bigi, A. O. Andrisano, Virtual Prototyping of a Compliant Spindle for Robotic "
        "Deburring, 2016, doi 10.1007/978-981-287-988-2_2",
        implements=(
            "Eqs. 1-7: helical-flute forces",
            "Eqs. 8-10: forces under an inclined feed velocity",
            "Eq. 11: immersion arcs of burr and work",
            "Eq. 12: process error",
            "sec. 3.3: pistons of the compliance device",
        ),
    )
)
