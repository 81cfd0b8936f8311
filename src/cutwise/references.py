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

_FORCES = "tests/papers/test_berselli2016_forces.py"
_SPINDLE = "tests/papers/test_berselli2016_spindle.py"
_MISPRINTS = "tests/papers/test_berselli2016_misprints.py"


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
        errata=(
            Erratum(
                "Eq. 5",
                "the integral of dF dz",
                "the integral of dF, which already holds dz (Eq. 3)",
                f"{_MISPRINTS}::test_eq5_as_printed_has_a_second_dz",
            ),
            Erratum(
                "before Eq. 6",
                "d phi_j = -k_beta z",
                "d phi_j = -k_beta dz",
                f"{_FORCES}::test_eq6_fx_and_fz_are_antiderivatives",
            ),
            Erratum(
                "Eq. 6, F_y",
                "-K_tc (2 phi - sin 2 phi) inside the bracket",
                "+K_tc (2 phi - sin 2 phi); the printed form is off by -2 K_tc c sin^2 phi per height",
                f"{_FORCES}::test_eq6_fy_as_printed_has_the_wrong_sign_of_k_tc",
            ),
            Erratum(
                "integration limits, line 3",
                "if phi_j(a) < phi_ex",
                "if phi_j(a) < phi_st and phi_j(0) > phi_st; flutes out of cut below phi_st are left out",
                f"{_FORCES}::test_boundary_algorithm_as_printed_calls_a_flute_out_of_cut_that_cuts",
            ),
            Erratum(
                "sec. 3.1, h_r",
                "h_r = h_n - h_b",
                "h_r = h_n + h_b, so that p_r = h_n + h_b - h_pci and e = h_b - max(p_r, 0)",
                f"{_SPINDLE}::test_hn_as_printed_contradicts_the_error_definition",
            ),
            Erratum(
                "sec. 3.1, cases",
                "three cases of the depth p_r",
                "a fourth, p_r <= 0: no contact, no force, e = h_b",
                f"{_MISPRINTS}::test_no_contact_is_a_fourth_case",
            ),
            Erratum(
                "sec. 3.2, v_F",
                "theta = atan(y_F' / x_F') with v_F = v_p - v_A",
                "theta = atan2(-V_y, V_x), V of the tool relative to the work; the printed one has the opposite sign "
                "and loses the quadrant",
                f"{_MISPRINTS}::test_feed_direction_as_printed_has_the_opposite_sign",
            ),
            Erratum(
                "text after Eq. 9",
                "c = x_F'",
                "c = x_F' / (N n), n in revolutions per second",
                f"{_FORCES}::test_eq8_counts_revolutions_per_second",
            ),
            Erratum(
                "Eq. 10, F_y",
                "the line of F_x again",
                "K_tc and K_rc terms of its own",
                f"{_FORCES}::test_eq10_as_printed_repeats_fx_and_drops_the_edge_terms",
            ),
            Erratum(
                "Eq. 10",
                "no edge terms",
                "the edge terms of Eq. 6; only then does it reduce to Eq. 6 at theta = 0",
                f"{_FORCES}::test_eq10_as_printed_repeats_fx_and_drops_the_edge_terms",
            ),
            Erratum(
                "Eq. 11",
                "one burr arc, limits free of theta beyond delta_p",
                "limits clamped by theta, and a second burr arc behind a plunging tool",
                f"{_FORCES}::test_eq11_as_printed_holds_only_within_the_work_arc",
            ),
            Erratum(
                "sec. 4, h_n",
                "h_n = 5 mm with respect to O",
                "not usable: the undeflected mill is lowest 4 mm below the axis through O and would stand deeper than "
                "its diameter; an explicit preset takes its place",
                f"{_MISPRINTS}::test_hn_of_section_4_buries_the_mill",
            ),
            Erratum(
                "sec. 4, n",
                "40.000 rpm",
                "40 000 rpm",
                f"{_FORCES}::test_eq8_counts_revolutions_per_second",
            ),
        ),
    )
)

SATO2016 = register(
    Source(
        "sato2016",
        "T. Sato, Y. Sato, T. Maekawa, Tool path generation for chamfering drill holes of a pipe with constant width, "
        "Computer-Aided Design 78 (2016) 26-35",
        implements=(
            "Eqs. 1-6: edges of a drilled pipe",
            "Eq. 9: curvature of the edge",
            "sec. 3.2: ball cutter with a limited knife",
        ),
        errata=(
            Erratum(
                "Eq. 12", "N_H = (cos, sin, 0)", "points into the material; outward it is -(cos, sin, 0)",
                "tests/papers/test_sato2016.py::test_eq12_normal_points_into_the_material",
            ),
        ),
    )
)
