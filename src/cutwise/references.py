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

ERKORKMAZ2001 = register(
    Source(
        "erkorkmaz2001",
        "K. Erkorkmaz, Y. Altintas, High speed CNC system design. Part II: modeling and identification of feed drives, "
        "Int. J. Mach. Tools Manuf. 41 (2001)",
        implements=("feed drive model, Stribeck friction law (form of the law)",),
    )
)

OZCAN2017 = register(
    Source(
        "ozcan2017",
        "A. Ozcan, E. Rivière-Lorphèvre, H. N. Huynh, F. Ducobu, O. Verlinden, E. Filippi, Modelling of pocket milling "
        "operation considering cutting forces and CNC control inputs, Procedia CIRP 58 (2017) 239-244, "
        "doi 10.1016/j.procir.2017.03.187",
        implements=("Tables 1-3, Figs. 1-2: feed drives with PID control and feedforward",),
        errata=(
            Erratum(
                "sec. 2.2",
                "cutting feed rate up to 10160 mm/s",
                "10160 mm/min, which is 400 in/min",
                "tests/papers/test_ozcan2017.py::test_feed_range_must_be_per_minute",
            ),
            Erratum(
                "Table 3",
                "K_p 500 and K_i 70 (x), 462.539 and 64.75 (y)",
                "rows exchanged, most probably; three readings are offered",
                "tests/papers/test_ozcan2017.py::test_table3_as_printed_leaves_no_margin",
            ),
            Erratum(
                "Table 1",
                "B of the y axis 0.28438",
                "0.028438, most probably: it makes the loops alike; the printed value is used",
                "tests/papers/test_ozcan2017.py::test_table1_viscous_damping_of_y_slipped_a_decimal",
            ),
        ),
    )
)
