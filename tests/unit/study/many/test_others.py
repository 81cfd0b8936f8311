"""Who works on a study may be lost: dask's workers and scheduler, workers on the folder; and studies as tables."""

import runpy
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import cutwise
from cutwise.app.cli import main
from cutwise.spec.faults import ScenarioFault
from cutwise.study.many import distributed, engine
from cutwise.study.many.answers import answers
from cutwise.study.many.columns import collected
from cutwise.study.many.held import against_full_runs
from cutwise.study.many.reading import read_study

BURRS = Path(__file__).parents[4] / "examples/studies/burrs.yaml"
CHUNK = 8


def same(a, b):
    return all(np.array_equal(a[name], b[name], equal_nan=a[name].dtype.kind == "f") for name in a)


@pytest.mark.slow
def test_killed_workers_tear_nothing_and_lose_nothing():
    outcome, equal = runpy.run_path(str(Path(__file__).with_name("kills.py")))["trials"](3)
    assert (outcome.kills, outcome.torn, outcome.lost) == (3, 0, 0)
    assert equal


def _daemon(*words):
    code = f"from distributed.cli.dask_{words[0]} import main; main()"
    return subprocess.Popen([sys.executable, "-c", code, *words[1:], "--no-dashboard"], stderr=subprocess.DEVNULL)


def _cluster(count):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    scheduler = _daemon("scheduler", "--host", "127.0.0.1", "--port", str(port))
    time.sleep(2.0)
    return scheduler, [_daemon("worker", address, "--nthreads", "1", "--no-nanny") for _ in range(count)], address


@pytest.mark.slow
def test_dask_may_lose_a_worker_and_its_scheduler(tmp_path, monkeypatch):
    """Its scheduler keeps what it knows in memory alone: the folder is the truth, and another cluster goes on."""
    pytest.importorskip("distributed")
    import threading

    monkeypatch.setattr(distributed, "_CONNECTED", 5.0)
    study = read_study(BURRS, cases=512)
    engine.run_study(study, tmp_path / "whole", chunk=CHUNK)
    scheduler, workers, address = _cluster(2)

    def parts():
        return len(list((tmp_path / "dask").glob("parts/part-*.nc")))

    def kill():
        for process, least in ((workers[0], 2), (scheduler, 5)):
            while parts() < least:
                time.sleep(0.01)
            process.kill()

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    ran = engine.run_study(study, tmp_path / "dask", chunk=CHUNK, executor="dask", address=address)
    killer.join()
    for process in (*workers, scheduler):
        process.kill()
        process.wait()
    assert "the scheduler is lost" in ran.stopped
    assert 0 < ran.done < 512
    ran = engine.run_study(study, tmp_path / "dask", resume=True, executor="dask", jobs=2)  # a cluster of this machine
    assert (ran.done, ran.stopped) == (512, "")
    assert same(collected(study, tmp_path / "whole", CHUNK)[0], collected(study, tmp_path / "dask", CHUNK)[0])


def test_dask_that_is_not_installed_is_refused_before_anything_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(engine.importlib.util, "find_spec", lambda _: None)
    study = read_study(BURRS, cases=8)
    with pytest.raises(ScenarioFault, match=r"cutwise\[distributed\]"):
        engine.run_study(study, tmp_path / "s", executor="dask")
    assert not (tmp_path / "s").exists()
    with pytest.raises(ScenarioFault, match="is not one of local, dask"):
        engine.run_study(study, tmp_path / "s", executor="ray")
    with pytest.raises(ScenarioFault, match="goes with --executor dask"):
        engine.run_study(study, tmp_path / "s", address="tcp://host:8786")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study") / "s"
    study = read_study(BURRS, cases=16)
    engine.run_study(study, folder, chunk=CHUNK)
    return study, folder


def test_a_study_is_held_against_full_runs(small):
    found = answers(*small, CHUNK)
    against = against_full_runs(found)
    assert 0.0 < against.changes["surface_error_max"] < 1e-6  # what the coarse step costs
    assert not against.too_coarse
    shifted = {**found.table, "measure surface_error_max": found.table["measure surface_error_max"] + 1e-5}
    assert against_full_runs(found._replace(table=shifted)).too_coarse


def call(capsys, *words):
    with pytest.raises(SystemExit) as end:
        main(list(map(str, words)))
    return end.value.code, capsys.readouterr()


def test_a_folder_is_told_and_exported_at_any_time(small, tmp_path, capsys):
    study, folder = small
    code, told = call(capsys, "report", folder, "-o", tmp_path / "page.html")
    assert code == 1  # 0.99 is wanted
    assert "P(good)" in told.out
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "The worst cases" in page
    assert page.count("<code>cutwise run ") == 10
    table = collected(study, folder, CHUNK)[0]
    for ending, read in (("csv", pd.read_csv), ("parquet", pd.read_parquet)):
        assert call(capsys, "export", folder, "-o", tmp_path / f"t.{ending}")[0] == 0
        frame = read(tmp_path / f"t.{ending}")
        name = "surface_error_max [m]" if ending == "csv" else "surface_error_max"
        assert frame[name].to_numpy() == pytest.approx(table["measure surface_error_max"], rel=1e-15)
    assert call(capsys, "export", folder, "-o", tmp_path / "t.nc")[0] == 0
    with xr.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as arrays:
        assert np.array_equal(arrays["part.burr.height"], table["lever part.burr.height"])
        assert arrays["part.burr.height"].attrs["units"] == "m"
    code, told = call(capsys, "export", folder, "-o", tmp_path / "t.xls")
    assert (code, "its ending says no format" in told.err) == (2, True)


def test_a_new_study_is_one(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call(capsys, "new", "study")[0] == 0
    assert call(capsys, "check", "study.yaml")[0] == 0
    assert call(capsys, "new", "study")[0] == 2


def test_a_study_of_a_scenario_in_python(examples):
    scenario = cutwise.load(examples / "deburr_compliant_spindle.yaml")
    levers = {
        "spindle.pressure": cutwise.grid("4 bar", "6 bar", 2),
        "part.burr.height": cutwise.normal("0.8 mm", "0.1 mm"),
    }
    found = cutwise.run_study(scenario, levers, cases=8, seed=1)
    assert found.probability.dims == ("spindle.pressure", "end")
    values = found.data["surface_error_max"]
    between = values.interp({"spindle.pressure": 5e5})
    assert between.to_numpy() == pytest.approx(values.mean("spindle.pressure").to_numpy())
    assert found.data_in({"spindle.pressure": "bar"})["spindle.pressure"].to_numpy() == pytest.approx([4.0, 6.0])
    with pytest.raises(ValueError, match="is no quantity"):
        found.data_in({"state": "bar"})


@pytest.mark.parametrize(("name", "words"), [("cdf", "share of cases below"), ("scatter", "part.burr.height [mm]")])
def test_pictures_of_a_study(small, name, words):
    fig = getattr(cutwise.plots, name)(answers(*small, CHUNK))
    axes = fig.axes[0]
    assert words in {axes.get_xlabel(), axes.get_ylabel()}


def test_a_page_of_one_number_beside_a_curve(examples):
    """A scatter has two numbers: with a curve and one number there is none, and the page is written all the same."""
    from cutwise.app.study_page import page

    found = cutwise.run_study(examples / "studies" / "burr_curves.yaml", cases=4)
    assert "Distributions" in page(found.answers, [])
    with pytest.raises(ValueError, match="two inputs"):
        cutwise.plots.scatter(found)


def test_where_the_good_band_ends(examples):
    from cutwise.study.many.answers import good_bands
    from cutwise.study.many.statements import Share

    scenario = str(examples / "deburr_compliant_spindle.yaml")
    found = cutwise.run_study({
        "scenario": scenario, "cases": 8, "want": {"probability": {"min": 0.8}},
        "vary": {"spindle.pressure": ["4 bar", "4.5 bar", "5 bar", "5.5 bar"],
                 "part.burr.height": cutwise.normal("0.8 mm", "0.1 mm")},
    }).answers  # fmt: skip

    def bands(*values):
        settings = [values for values, _ in found.shares]
        told = [(one, Share(v, v, v)) for one, v in zip(settings, values, strict=True)]
        return good_bands(found._replace(shares=tuple(told)))

    (band,) = bands(0.7, 0.9, 0.9, 0.5)
    assert (band.low, band.high) == pytest.approx((4.25e5, 5.125e5))
    assert not band.open_low
    assert [(one.open_low, one.open_high) for one in bands(0.9, 0.1, 0.1, 0.9)] == [(True, False), (False, True)]
    assert bands(0.1, 0.1, 0.1, 0.1) == []


def test_the_line_of_a_study_that_runs(small):
    from cutwise.app.live import Live

    bars = []
    study, folder = small
    live = Live(study, folder, bars.append)
    live(0, 16)
    live(8, 16)
    assert bars == [0.0, 0.5]
    (_, share), *_ = answers(study, folder, CHUNK).shares
    said = live.line(16, 16)
    assert said.startswith(f"16 of 16   P(good) {share.value:.3f} ± {share.half_width:.3f}   0 failed")
    assert live.done() == 16


def test_only_draws_make_a_share(examples):
    """Rows between A and B of indices repeat their numbers, and the points of morris are levels: neither is a draw."""
    base = {
        "scenario": str(examples / "deburr_compliant_spindle.yaml"), "cases": 8,
        "vary": {"spindle.pressure": cutwise.uniform("4 bar", "5 bar"), "part.burr.height": cutwise.normal("0.8 mm", "0.1 mm")},
    }  # fmt: skip
    found = cutwise.run_study({**base, "method": "indices"}).answers
    state = found.table["state"].reshape(-1, 4)[:, :2]
    assert found.shares[0][1].value == pytest.approx((state == 0).mean())
    assert cutwise.run_study({**base, "method": "morris"}).answers.shares == ()
    with pytest.raises(ScenarioFault, match="no draws"):
        cutwise.run_study({**base, "method": "morris", "want": {"probability": {"min": 0.9}}})
