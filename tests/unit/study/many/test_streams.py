"""Studies larger than memory: order statistics in bounded room, columns part by part, tallies that need no whole column."""

import json
import tracemalloc
from functools import cache

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from cutwise.io.scenario import load
from cutwise.io.tree import from_data
from cutwise.spec.faults import ScenarioFault
from cutwise.study.many import folder as at
from cutwise.study.many import order
from cutwise.study.many.answers import answers, answers_of, measures, worst
from cutwise.study.many.cases import Chunk
from cutwise.study.many.columns import aligned, collected
from cutwise.study.many.definition import columns
from cutwise.study.many.draws import shuffled
from cutwise.study.many.face import normal, run_study
from cutwise.study.many.order import in_order, percentiles
from cutwise.study.many.packing import pack
from cutwise.study.many.reading import study_of
from cutwise.study.many.statements import RowSums, share_of, sobol_indices
from cutwise.study.many.tables import dataset, write_table
from cutwise.study.many.tally import Following, Tally


@pytest.fixture(scope="module")
def made(examples, tmp_path_factory):
    """Makes a folder of a study whose cases are not run but made up, quickly."""

    @cache
    def once(text):
        cases, method, size, more = json.loads(text)
        study = study_of(from_data({
            "name": "made", "scenario": str(examples / "deburr_compliant_spindle.yaml"), "method": method, "cases": cases,
            "vary": {"part.burr.height": {"normal": {"mean": "0.8 mm", "deviation": "0.1 mm"}},
                     "spindle.pressure": {"uniform": ["4.8 bar", "5.2 bar"]}}, "seed": 1, **more,
        }, "made"), [], tmp_path_factory.mktemp("made") / "made.yaml")  # fmt: skip
        folder = tmp_path_factory.mktemp("made")
        at.started(folder, json.dumps(pack(study)), at.identity_of(study, "0", size, {}, {}))
        for first, count in at.chunks(study, size):
            write(study, folder, first, count)
        return study, folder, size

    def make(cases, method="monte_carlo", size=1000, **more):
        return once(json.dumps([cases, method, size, more]))

    return make


def write(study, folder, first, count):
    levers = columns(study, first, count)
    height = np.array(levers["part.burr.height"])
    value = (height - 0.8e-3) * (1.0 + 1e-6 * np.array(levers["spindle.pressure"]))
    state = np.where(np.abs(value) > 1e-4, 1, 0)
    state[np.arange(first, first + count) % 97 == 3] = 3
    said = ["no equilibrium" if one == 3 else "" for one in state]
    names = dict.fromkeys(study.measures, value)
    at.write_part(folder, Chunk(first, levers, names, state, np.abs(value) - 1e-4, state > 5, said))


@pytest.mark.parametrize("room", [16, 100, 10**6])
@pytest.mark.parametrize("kind", ["normal", "ties", "wild", "few"])
def test_places_in_order_are_those_of_a_sort_whatever_the_room(kind, room):
    rng = np.random.default_rng(4)
    values = {
        "normal": rng.normal(size=3000), "ties": rng.integers(-2, 3, 3000).astype(float) * 0.1,
        "wild": rng.normal(size=3000) * 10.0 ** rng.integers(-300, 300, 3000), "few": np.array([2.0, -0.0, np.nan]),
    }[kind]  # fmt: skip
    values[-1] = np.nan
    there = np.sort(values[np.isfinite(values)])

    def parts():
        return iter(np.array_split(values, 7))

    asked = np.unique(np.linspace(0, there.size - 1, 40).astype(int))
    found, count = in_order(parts, lambda _: asked, room)
    assert count == there.size
    assert np.array_equal(found, there[asked])
    assert percentiles(parts, (5, 50, 95), room) == pytest.approx(np.percentile(there, (5, 50, 95)), rel=1e-15)


def test_nothing_finite_has_no_order():
    assert percentiles(lambda: iter([np.array([np.nan])]), (50,)) is None


def test_pieces_are_cut_into_whole_groups():
    parts = ({"case": np.arange(a, b)} for a, b in ((0, 5), (5, 6), (6, 14), (14, 17)))
    found = [piece["case"].tolist() for piece in aligned(parts, 4)]
    assert found == [[0, 1, 2, 3], [4, 5, 6, 7, 8, 9, 10, 11], [12, 13, 14, 15]]


def test_answers_do_not_depend_on_parts(made):
    study, folder, size = made(3000, size=500)
    parts, whole = answers(study, folder, size), answers_of(study, dict(collected(study, folder, size)[0]))
    assert parts.shares == whole.shares
    assert parts.failed == whole.failed == {"no equilibrium": 31}
    assert parts.first == {"no equilibrium": 3}
    assert parts.wrong == whole.wrong
    assert parts.extremes == whole.extremes
    assert measures(parts) == measures(whole)
    assert worst(parts, 12) == worst(whole, 12)
    margin = np.where(whole.table["state"] == 3, -np.inf, whole.table["margin"])
    assert worst(parts, 12) == np.argsort(-margin, kind="stable")[:12].tolist()


def test_memory_does_not_grow_with_the_cases(made, tmp_path, monkeypatch):
    """Five times the cases in answers and tables: the same peak; a column of 8 bytes a case would show."""

    def peak(study, folder, size):
        tracemalloc.start()
        found = answers(study, folder, size)
        measures(found)
        worst(found, 10)
        for ending in ("csv", "nc", "parquet"):
            write_table(study, found.table, tmp_path / f"t.{ending}")
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most

    monkeypatch.setattr(order, "ROOM", 256)
    few, many = made(1000, size=500), made(5000, size=500)
    peak(*few)  # what is imported and kept once for all
    assert peak(*many) < peak(*few) + 8 * 2000


def test_tables_written_part_by_part_are_those_of_the_whole(made, tmp_path):
    settings = {"operation.milling": ["down", "up"], "part.burr.height": {"normal": {"mean": "0.8 mm", "deviation": "0.1 mm"}},
                "spindle.pressure": ["4.8 bar", "5 bar", "5.2 bar"]}  # fmt: skip
    study, folder, size = made(110, size=64, vary=settings)  # parts end amid the settings of a draw
    table = collected(study, folder, size)[0]
    for ending in ("csv", "nc", "parquet"):
        write_table(study, table, tmp_path / f"t.{ending}")
        write_table(study, dict(table), tmp_path / f"u.{ending}")
    assert (tmp_path / "t.csv").read_text() == (tmp_path / "u.csv").read_text()
    frame = pd.read_parquet(tmp_path / "t.parquet")
    pd.testing.assert_frame_equal(frame, pd.read_parquet(tmp_path / "u.parquet"))
    assert frame["part.burr.height"].tolist() == table["lever part.burr.height"].tolist()
    assert frame["said"].tolist() == table["said"].tolist()
    with (
        xr.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as t,
        xr.open_dataset(tmp_path / "u.nc", engine="h5netcdf") as u,
    ):
        xr.testing.assert_identical(t.load(), u.load())
        xr.testing.assert_identical(t.load(), dataset(study, table).assign_coords(t.coords))
        assert t.sizes == {"draw": 110, "operation.milling": 2, "spindle.pressure": 3}
    assert len(list(tmp_path.iterdir())) == 6  # nothing is left beside them


def test_a_tally_is_the_same_for_any_parts(made):
    height, pressures = {"normal": {"mean": "0.8 mm", "deviation": "0.1 mm"}}, ["4.8 bar", "5 bar", "5.2 bar"]
    settings = {"part.burr.height": height, "spindle.pressure": pressures}
    study, folder, size = made(600, method="sobol", vary=settings, size=250)
    state = collected(study, folder, size)[0]["state"]
    one, other = Tally(study), Tally(study)
    one.add(state)
    for part in np.array_split(state, 41):
        other.add(part)
    assert one.shares() == other.shares()
    ended = state.reshape(-1, 3) != 3
    assert [share for _, share in one.shares()] == [
        share_of(state.reshape(-1, 3)[ended[:, k], k] == 0, nets=bool(ended[:, k].all())) for k in range(3)
    ]


@pytest.mark.parametrize("method", ["sobol", "monte_carlo"])
def test_when_a_study_stops_depends_on_its_cases_alone(made, method):
    """Looked at in parts of 32 or of 100, the rule says the same, at the same prefix."""
    stops = []
    for size in (32, 100):
        study, folder, _ = made(1024, method=method, size=size, stop={"half_width": 0.06, "at_least": 64})
        for file in folder.glob("parts/*.nc"):
            file.rename(folder / file.name)
        ends = []
        for first, count in at.chunks(study, size):
            (folder / at.part_file(folder, first, count).name).rename(at.part_file(folder, first, count))
            if Following(study, folder, size).enough():
                ends.append(first + count)
                break
        stops.append(ends[0])
    small, large = stops
    assert small in ((128, 256, 512) if method == "sobol" else (256, 512, 768))
    assert large == -(-small // 100) * 100


def test_indices_of_more_rows_than_are_kept_apart():
    """Sums of groups scatter as rows do; the estimates themselves are the same to rounding."""
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(20000, 2)), rng.normal(size=(20000, 2))

    def f(x):
        return 3.0 + x[:, 0] + 0.5 * x[:, 1] + x[:, 0] * x[:, 1]

    rows = np.column_stack([f(a), f(b), f(np.column_stack([b[:, 0], a[:, 1]])), f(np.column_stack([a[:, 0], b[:, 1]]))])
    sums = RowSums(len(rows), 2, float(rows[:, :2].mean()))
    for part in np.array_split(rows, 13):
        sums.add(part)
    found, few = sums.indices(1), sobol_indices(rows[:4096], 1)
    less = rows - rows[:, :2].mean()
    first = (less[:, 1] * (less[:, 2] - less[:, 0])).mean() / less[:, :2].var()
    assert found.first[0] == pytest.approx(first, rel=1e-12)
    assert found.total_width == pytest.approx(few.total_width * np.sqrt(4096 / 20000), rel=0.2)
    assert not sobol_indices(np.full((8, 4), 0.1), 1).total.any()
    groups = np.bincount(shuffled(np.arange(20000)) % 16)
    assert abs(groups - 1250).max() < 150


def test_a_study_without_a_folder_has_a_most(examples):
    with pytest.raises(ScenarioFault, match="want a folder"):
        run_study(
            load(examples / "deburr_compliant_spindle.yaml"),
            {"part.burr.height": normal("0.8 mm", "0.1 mm")},
            cases=200_000,
        )
