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

DEMEC = register(
    Source(
        "demec",
        "P. Demeč, K. Madáč, Virtual machining - the mean of machine tools virtual prototyping, Technical University "
        "of Košice (no year printed; project VEGA 1/4162/07)",
        implements=(
            "Eqs. 1, 8: ideal surface and tool vectors of a serial chain",
            "Eqs. 2-7: first-order error of the tool point, by body",
            "Eq. 9: machined surface",
            "Eqs. 10-14: the vertical mill",
        ),
        errata=(
            Erratum(
                "Eq. 1",
                "products to n-1 (tool) and i-1 (sum)",
                "products to n and i",
                "tests/papers/test_demec.py::test_eq_1_as_printed_drops_a_rotation_and_shifts_the_sum",
            ),
            Erratum(
                "Eq. 5",
                "product to n",
                "product to i",
                "tests/papers/test_demec.py::test_eq_5_with_the_printed_limit_contradicts_eq_2",
            ),
            Erratum(
                "Eqs. 2, 3",
                "errors of every body and of the part added",
                "errors of bodies between part and ground, and the deformation of the part, taken off",
                "tests/papers/test_demec.py::test_eq_2_literal_adds_what_the_table_takes_away",
            ),
            Erratum(
                "Fig. 4 and conclusion",
                "errors in Y and Z largest in the middle of the travel",
                "not with physical signs: cutting force times error is convex along the travel",
                "tests/papers/test_demec.py::test_figure_4_is_not_a_result_of_the_physical_signs",
            ),
            Erratum(
                "practical demonstration",
                "G1 upper part of table y, G2 bottom part of table x",
                "T1 moves in x on T2: the letters of the axes are exchanged",
                "tests/papers/test_demec.py::test_eqs_1_8_12_13_tool_point_and_vectors_of_the_example",
            ),
        ),
    )
)
