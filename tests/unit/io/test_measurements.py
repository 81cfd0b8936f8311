"""Files of measurements: what can be wrong with a column."""

import pytest

from cutwise.io.measurements import Channel, read_measurement
from cutwise.spec.faults import ScenarioFault


@pytest.mark.parametrize(("value", "unit"), [("3e11", "N"), ("-2e9", "mN"), ("5e3", "kN")])
def test_a_force_that_no_machine_measures_has_another_unit(tmp_path, value, unit):
    file = tmp_path / "forces.csv"
    file.write_text(f"force_x [{unit}]\n1\n{value}\n", encoding="utf-8")
    with pytest.raises(ScenarioFault, match="more than a meganewton; is the unit right"):
        read_measurement(file, (Channel("force_x", "force"),), 1)
