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

ENGIN2001 = register(
    Source(
        "engin2001",
        "S. Engin, Y. Altintas, Mechanics and dynamics of general milling cutters. Part I: helical end mills, International "
        "Journal of Machine Tools and Manufacture 41 (2001) 2195-2212, doi 10.1016/S0890-6955(01)00045-1",
        implements=("forces of edge elements along the meridian of a general end mill",),
    )
)

GRADISEK2004 = register(
    Source(
        "gradisek2004",
        "J. Gradišek, M. Kalveram, K. Weinert, Mechanistic identification of specific force coefficients for a general end mill, "
        "International Journal of Machine Tools and Manufacture 44 (2004) 401-414, doi 10.1016/j.ijmachtools.2003.10.001",
        implements=("mean forces of a general end mill over its contact arcs",),
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
                "Eq. 12",
                "N_H = (cos, sin, 0)",
                "points into the material; outward it is -(cos, sin, 0)",
                "tests/papers/test_sato2016.py::test_eq12_normal_points_into_the_material",
            ),
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
                "tests/papers/test_garnier2017.py::test_eq2_as_printed_is_no_rotation",
            ),
            Erratum(
                "Eq. 4",
                "F_a = 2 F_z = (F_n sin g - F_f cos g) cos p",
                "twice that: two lips",
                "tests/papers/test_garnier2017.py::test_eq4_as_printed_lacks_the_second_lip",
            ),
            Erratum(
                "Eq. 5",
                "chip section (R - r_a) f_z / cos p",
                "(R - r_a) f_z; the printed one is 16.7 % too large at 118 degrees",
                "tests/papers/test_garnier2017.py::test_eq5_as_printed_has_a_section_too_large",
            ),
            Erratum(
                "sec. 2.1.1",
                "R_3 from R_2 about z_2",
                "about x_2, as the second matrix of Eq. 2 has it",
                "tests/papers/test_garnier2017.py::test_rake_turns_about_the_lip",
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

RAGHAVAN_ROTH1993 = register(
    Source(
        "raghavan_roth1993",
        "M. Raghavan, B. Roth, Inverse kinematics of the general 6R manipulator and related linkages, Journal of "
        "Mechanical Design 115 (1993) 502-508",
        implements=(
            "14 equations of a pose in which sines and cosines stand to first power, without two of the joints",
        ),
    )
)

MANOCHA_CANNY1994 = register(
    Source(
        "manocha_canny1994",
        "D. Manocha, J. F. Canny, Efficient inverse kinematics for general 6R manipulators, IEEE Transactions on Robotics "
        "and Automation 10 (1994) 648-657",
        implements=("the postures as eigenvalues of order 24",),
    )
)
