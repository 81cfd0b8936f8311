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

GARNIER2017 = register(
    Source(
        "garnier2017",
        "S. Garnier, K. Subrin, K. Waiyagan, Modelling of robotic drilling, 16th CIRP Conference on Modelling of "
        "Machining Operations, Procedia CIRP, 2017",
        implements=(
            "Eqs. 1-5: forces of lip elements, corrected; extended by torque, chisel edge, margin, entry and exit",
            "sec. 3, 4 (outline only): elastic robot joints and their effect on the hole",
        ),
        errata=(
            Erratum(
                "Eq. 2, first matrix",
                "cos p, sin p; sin p, cos p (determinant cos 2p)",
                "a rotation about y by p: -sin p below, so that the lip is pushed inward",
                "papers/test_garnier2017.py::test_eq2_as_printed_is_no_rotation",
            ),
            Erratum(
                "Eq. 4",
                "F_a = 2 F_z = (F_n sin g - F_f cos g) cos p",
                "twice that: two lips",
                "papers/test_garnier2017.py::test_eq4_as_printed_lacks_the_second_lip",
            ),
            Erratum(
                "Eq. 5",
                "chip section (R - r_a) f_z / cos p",
                "(R - r_a) f_z; the printed one is 16.7 % too large at 118 degrees",
                "papers/test_garnier2017.py::test_eq5_as_printed_has_a_section_too_large",
            ),
            Erratum(
                "sec. 2.1.1",
                "R_3 from R_2 about z_2",
                "about x_2, as the second matrix of Eq. 2 has it",
                "papers/test_garnier2017.py::test_rake_turns_about_the_lip",
            ),
        ),
    )
)

CHEN_KAO2000 = register(
    Source(
        "chen_kao2000",
        "S. F. Chen, I. Kao, Conservative congruence transformation for joint and Cartesian stiffness matrices of "
        "robotic hands and fingers, The International Journal of Robotics Research 19 (2000)",
        implements=("complementary stiffness of elastic joints under load, as a check",),
    )
)

DUMAS2011 = register(
    Source(
        "dumas2011",
        "C. Dumas, S. Caro, M. Cherif, S. Garnier, B. Furet, Joint stiffness identification of industrial serial "
        "robots, Robotica, 2011",
        implements=("Cartesian compliance J K^-1 J^T of elastic joints",),
    )
)
