"""What a verdict is sure of: histories of friction and set-up, assumed values, requirements on the whole band."""

import pytest

from cutwise.bands import Spread
from cutwise.results import Check, Finding, Histories, Place, Remedy, _check_from_json


def check(value=0.0, low=None, high=None, off=None, minimum=None, maximum=None):
    histories = None if low is None and high is None else Histories(low, high, "friction")
    one = Check("m", value, "length", minimum, maximum, False, histories=histories, off=off)
    return Check("m", value, "length", minimum, maximum, one.keeps(value), histories=histories, off=off)


@pytest.mark.parametrize(
    ("given", "certainty"),
    [
        ({"maximum": 1.0}, "unknown"),
        ({"maximum": 1.0, "low": -0.5, "high": 0.5}, "sure"),
        ({"maximum": 1.0, "low": -0.5, "high": 1.5}, "not_every_history"),
        ({"maximum": 1.0, "low": -0.5, "high": None}, "not_every_history"),  # an end that is not known
        ({"value": 2.0, "maximum": 1.0, "low": 1.5, "high": 3.0}, "sure"),  # fails everywhere
        ({"value": 2.0, "maximum": 1.0, "low": 0.5, "high": 3.0}, "not_every_history"),  # some history would pass
        ({"value": 2.0, "minimum": 0.0, "maximum": 1.0, "low": -1.0, "high": 3.0}, "not_every_history"),  # between both
        ({"maximum": 1.0, "off": ("a", 1.5)}, "not_every_history"),
        ({"maximum": 1.0, "off": ("a", 0.9)}, "sure"),
    ],
)
def test_certainty(given, certainty):
    assert check(**given).certainty == certainty


def test_a_finding_reads_back_as_it_was_written():
    finding = Finding(
        "unstable", Place("corner", line=14), 1.62, 1.0, measure="chatter_growth_corner",
        remedy=Remedy("operation.axial_depth", "2.5 mm", tried=True),
    )  # fmt: skip
    assert Finding.from_json(finding.as_json()) == finding
    assert finding.as_json()["where"] == {"name": "corner", "line": 14}


def test_a_band_of_the_inputs_counts_unless_a_probability_judges():
    band = Spread(0.2, 0.6, 1.4)
    wide = Check("m", 0.9, "length", None, 1.0, True, band=band)
    assert wide.certainty == "not_every_history"
    assert wide.as_json()["histories"] == {"low": 0.6, "high": 1.4, "cause": "parameters"}
    assert _check_from_json(wide.as_json(), {}).histories is None  # its ends stand in the band
    asked = Check("m", 0.9, "length", None, 1.0, True, band=band, probability=0.8, probability_reached=0.85)
    assert asked.certainty == "sure"
    assert "histories" not in asked.as_json()
    assert Check("m", 0.9, "length", None, 1.5, True, band=band).certainty == "sure"
