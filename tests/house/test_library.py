"""Every value of the library says where it is from, can be read, and is plausible."""

import contextlib

import pytest
from pydantic import ValidationError

from cutwise import units
from cutwise.io import library
from cutwise.io.assembly import shelf_keys, shelf_sections
from cutwise.io.scenario import load, revised
from cutwise.io.spindle_body import parametric_body, text_of
from cutwise.io.tree import compose
from cutwise.spec.material import Material
from cutwise.spec.notices import notices
from cutwise.spec.spindle_solid import SpindleSolid

ENTRIES = [(kind, name) for kind in library.SHELVES for name in library.names(kind)]
MATERIALS = [name for kind, name in ENTRIES if kind == "materials"]


@pytest.mark.parametrize(("kind", "name"), ENTRIES)
def test_every_value_has_status_and_source(kind, name):
    entry = library.entry(kind, name)
    assert entry.name == name
    assert entry.describes
    for key, text, origin in entry.origins():
        assert origin.status != "user", key
        assert len(origin.source) > 5, key
        assert text, key


@pytest.mark.parametrize(("kind", "name"), ENTRIES)
def test_every_key_is_known_and_every_value_can_be_read(kind, name):
    known = shelf_keys(kind)
    values = library.entry(kind, name).values.plain()
    assert set(values) <= known
    read = [section for section in shelf_sections(kind) if set(values) <= set(section.model_fields)]
    assert read
    for section in read:
        if "solid" in values:  # a spindle as a solid gives what the loader works out of it
            solid = SpindleSolid.model_validate(values["solid"])
            values |= text_of(parametric_body(solid, units.parse(values["tool_reach"], "length")).found)
        lacking = {key for key, info in section.model_fields.items() if info.is_required()} - set(values)
        lacking |= {key for key in section.model_fields if f"give {key}" in library.entry(kind, name).describes} - set(
            values
        )
        for key in lacking:  # an entry may leave a value to the engineer, and says so
            assert f"give {key}" in library.entry(kind, name).describes
            values[key] = compose(section.model_fields[key].examples[0], "example")[0].plain()
        if "chain" in values and "tip" in section.model_fields and "tip" not in values:
            # a machine that mills asks where the tool point is; one whose tool is given by the scenario need not know
            section.model_validate({**values, "tip": ["0 mm", "0 mm", "-45 mm"], "library": name})
            continue
        section.model_validate({**values, "library": name})


def material(name):
    return Material.model_validate(library.entry("materials", name).values.plain())


# Rules for cutting coefficients, of which an entry may break one only for a reason that is known.
KNOWN_TO_STAND_OUT = {
    ("al7075_insert", "energy"),  # an insert mill of low rake, described as high
    ("kienzle_1045", "energy"),  # 2.5 GPa, normalised steel at neutral rake
    ("kienzle_wrought_al", "energy"),  # 1.4 GPa at neutral rake
    ("kienzle_cast_al", "energy"),
}

# Specific cutting energy at 0.1 mm [GPa] by ISO 513 group, as recalled from Kalpakjian's table, widened by nothing.
ENERGY = {"P": (2.7, 9.3), "M": (3.0, 5.2), "K": (1.1, 5.4), "N": (0.4, 1.1), "S": (2.0, 6.8)}


def stands_out(name):
    values = material(name)
    if values.law == "linear":
        if not 0.05 <= values.K_rc / values.K_tc <= 0.7:
            yield "K_rc/K_tc"
        if not (values.K_te == 0 or 1e3 <= values.K_te <= 120e3):
            yield "K_te (unit?)"
        if values.K_ae is not None and values.K_ae > 0.22 * values.K_te:  # al6082t6: 0.215, as printed
            yield "K_ae above 0.22 K_te"
        energy = values.K_tc + values.K_te / 1e-4
        fitted_at = values.chip_thickness_max or 1.0
        if values.group == "N" and "7075" in name and values.K_tc < 2 * 0.8391 * 331e6:  # shear bound at 10° rake
            yield "below the shear bound"
    else:
        energy = values.k_c11 * 0.1**-values.m_c
        fitted_at = 1.0
        if not 0.1 <= values.m_c <= 0.4:
            yield "m_c"
    if values.group and fitted_at >= 1e-4 and not ENERGY[values.group][0] <= energy / 1e9 <= ENERGY[values.group][1]:
        yield "energy"


def test_cutting_coefficients_are_plausible():
    found = {(name, rule) for name in MATERIALS for rule in stands_out(name)}
    assert found == KNOWN_TO_STAND_OUT


@pytest.mark.parametrize(("kind", "name"), ENTRIES)
def test_no_entry_is_remarked_upon_for_its_own_values(kind, name):
    """What stands in the library has its source; only what an entry says about itself (robot.pairing) is shown."""
    values = library.entry(kind, name).values.plain()
    for section in shelf_sections(kind):
        own = {key: value for key, value in values.items() if key in section.model_fields}
        with contextlib.suppress(ValidationError):  # entries that leave a value to the engineer
            said = [notice.path for notice in section.model_validate(own).notices()]
            assert [path for path in said if path not in (("pairing",), ("gravity",), ("accuracy",))] == [], section


def test_unusual_values_are_those_that_the_engineer_wrote(examples):
    of_library = load(examples / "deburr_compliant_spindle.yaml")
    assert not any("material" in said for said in notices(of_library))  # K_te 0, of the paper
    written = revised(of_library, ["material.K_te=0 N/mm"])
    assert "material.K_te: 0 N/mm is unusual; usual is 0.5 N/mm to 120 N/mm" in notices(written)


@pytest.mark.parametrize(
    ("name", "kienzle"),
    [
        ("deburr_aluminium", "kienzle_wrought_al"),
        ("deburr_1045", "kienzle_1045"),
        ("deburr_ti6al4v", "kienzle_ti6al4v"),
        ("deburr_gg25", "kienzle_gg25"),
        ("deburr_304", "kienzle_304"),
    ],
)
def test_deburring_sets_are_the_straight_line_through_kienzles_law(name, kienzle):
    numpy = pytest.importorskip("numpy")
    line, curve = material(name), material(kienzle)
    chip = numpy.linspace(0.5, 6, 2001) * 1e-3  # [mm]
    force = curve.k_c11 / 1e6 * chip ** (1 - curve.m_c)  # [N/mm]
    slope, edge = numpy.polyfit(chip, force, 1)
    assert units.displayed(line.K_tc, "stress")[0] == pytest.approx(slope, rel=1e-3)
    assert units.displayed(line.K_te, "edge_force")[0] == pytest.approx(edge, abs=0.05)
