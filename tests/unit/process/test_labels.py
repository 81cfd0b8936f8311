"""Tables say what a history holds; one reader makes groups of them."""

from types import SimpleNamespace

import numpy as np
import pytest

from cutwise.process import (
    drilling_stages,
    edge_stages,
    machine_stages,
    milling_stages,
    programmed_milling,
    still_deburring,
)
from cutwise.process.labels import Column, Coordinate, Group, tree
from cutwise.process.turning import GROUPS as TURNED

OVER = {"time": Coordinate(lambda run: run.time, "s", "time"), "axis": "xyz", "part": lambda run: run.names}
TABLE = {
    "motion": Group({
        "place": Column("time axis", lambda run: run.place, "m", "place of the tool"),
        "speed": Column("time", lambda run: run.speed, "m/s", "speed"),
        "share": Column("part", lambda _: np.array([0.4, 0.6]), "1", lambda run: f"share of {run.of}"),
    }, OVER, attrs=lambda _: {"stop": 1.0}),
    "none": Group({"speed": Column("time", lambda run: run.speed, "m/s", "speed")}, OVER),
    "other": Group({"place": Column("time axis", lambda run: run.place, "m", "place")}, OVER, lambda _: False),
}  # fmt: skip
RUN = SimpleNamespace(time=np.arange(4.0), place=np.zeros((4, 3)), speed=None, names=["arm", "base"], of="each")


def test_a_table_becomes_groups_with_units_and_labels():
    found = tree(RUN, TABLE)
    assert list(found.children) == ["motion"]
    motion = found["motion"].to_dataset()
    assert set(motion.data_vars) == {"place", "share"}
    assert motion["place"].dims == ("time", "axis")
    assert motion["place"].attrs == {"units": "m", "long_name": "place of the tool"}
    assert list(motion["axis"].values) == ["x", "y", "z"]
    assert list(motion["part"].values) == ["arm", "base"]
    assert motion["share"].attrs["long_name"] == "share of each"
    assert motion["time"].attrs["units"] == "s"
    assert motion.attrs == {"stop": 1.0}


@pytest.mark.parametrize(
    "table",
    [edge_stages.GROUPS, still_deburring.GROUPS, milling_stages.GROUPS, programmed_milling.GROUPS, machine_stages.GROUPS,
     drilling_stages.GROUPS, TURNED],
    ids=("deburr", "still", "mill", "programmed", "machine", "drill", "turn"),
)  # fmt: skip
def test_every_column_has_a_unit_a_name_and_a_coordinate_or_a_number(table):
    for group in table.values():
        for name, column in group.columns.items():
            assert column.unit, name
            assert column.text, name
            assert set(column.over.split()) <= {*group.over, "point", "body", "redundancy_angle", "branch"}, name
