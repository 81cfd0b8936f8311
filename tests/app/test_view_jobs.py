"""Runs of the page: begun, superseded, cancelled, killed; saved, kept; and that they are the numbers of the command line."""

import json
import os
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import time
import zlib
from pathlib import Path

import pytest

from app.viewed import viewing
from cutwise.io.scenario import load
from cutwise.results import Result
from cutwise.study.band import simulate

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
LONG = {"operation.duration": "60 s"}  # of deburring: minutes of computing


@pytest.fixture(scope="module")
def desk(examples, tmp_path_factory):
    folder = tmp_path_factory.mktemp("desk")
    shutil.copy(examples / "deburr_compliant_spindle.yaml", folder / "edge.yaml")
    return folder


@pytest.fixture(scope="module")
def page(desk):
    with viewing("edge.yaml", cwd=desk) as server:
        yield server


def run(page, edits=None, **more):
    begun = page.ask("POST", "/api/job", {"edits": edits or {}, **more})
    assert begun.status == 202, begun.body
    return page.events()[-1]


def of_run(desk, number):
    (file,) = desk.glob(f"cutwise-view-*/run-{number}.nc")
    return Result.from_file(file, load(file))


def values(result):
    return {name: measure.value for name, measure in result.measures.items()}


def test_a_run_of_the_page_is_the_run_of_the_command_line(examples, tmp_path):
    """Edit, save, run: to the last bit."""
    shutil.copy(examples / "deburr_compliant_spindle.yaml", tmp_path / "edge.yaml")
    with viewing("edge.yaml", cwd=tmp_path) as page:
        _edited_saved_run(page, tmp_path)


def _edited_saved_run(page, desk):
    edits = {"spindle.pressure": "4 bar", "numerics.time_step": "40 us"}
    told = run(page, edits)
    assert (told["state"], told["verdict"]) == ("done", "fail")
    assert told["text"].startswith("FAIL: 1 of 3 requirements not met: surface_error_max")
    shown = of_run(desk, told["run"])
    assert page.ask("POST", "/api/save", {"edits": edits}).json == {"file": "edge.yaml"}
    saved = load(desk / "edge.yaml")
    assert saved == load(desk / "edge.yaml", {}) == shown.scenario.with_({"name": saved.name})
    assert values(simulate(saved)) == values(shown)
    found = page.ask("GET", f"/api/run/{told['run']}/view")
    assert found.status == 200
    assert zlib.decompress(found.body, -15).startswith(b"CWVIEW1\n")


def test_faults_are_those_of_check_at_their_place(page):
    wrong = {"spindle.presure": "4 bar", "operation.feed": "80"}
    found = page.ask("POST", "/api/check", {"edits": wrong}).json
    told = {one["key"]: one["text"] for one in found["faults"]}
    assert set(told) == {"spindle.presure", "operation.feed"}
    assert told["operation.feed"].startswith("edge.yaml:")
    assert (
        'operation.feed: 80 has no unit; write it as text with a unit, for example "80 mm/s"' in told["operation.feed"]
    )
    assert "did you mean spindle.pressure?" in told["spindle.presure"]
    refused = page.ask("POST", "/api/job", {"edits": wrong})
    assert refused.status == 400
    assert [one["key"] for one in refused.json["faults"]] == [one["key"] for one in found["faults"]]


def test_the_keys_begin_with_what_is_turned(page):
    fields = page.ask("POST", "/api/check", {}).json["fields"]
    first = fields[0]
    assert (first["key"], first["text"], first["unit"], first["lever"]) == ("spindle.pressure", "5 bar", "bar", True)
    assert first["usual"] == ["1.2 bar", "6.5 bar"]
    assert {one["key"] for one in fields} >= {"operation.feed", "tool.flutes", "requirements.cutting_power_mean.max"}
    for one in fields:
        assert one["meaning"]


def test_one_job_at_a_time(page):
    begun = page.ask("POST", "/api/job", {"edits": LONG, "tab": "one"})
    assert begun.status == 202
    other = page.ask("POST", "/api/job", {"edits": {}, "tab": "two"})
    assert other.status == 409  # and the second tab shows the job
    assert b"running already" in other.body
    assert page.ask("POST", "/api/job", {"edits": LONG, "tab": "one"}).status == 409
    after = page.ask("POST", "/api/job", {"edits": {"spindle.pressure": "4.5 bar"}, "tab": "one"})
    assert after.status == 202  # a change supersedes
    assert page.events()[-1]["run"] == after.json["run"]


def test_cancelled_is_who_asked_for_it(page):
    assert page.ask("POST", "/api/job/cancel", {}).json == {"state": "cancelled"}  # nothing runs: no harm
    page.ask("POST", "/api/job", {"edits": LONG})
    time.sleep(0.5)
    before = time.monotonic()
    assert page.ask("POST", "/api/job/cancel", {}).json == {"state": "cancelled"}
    assert time.monotonic() - before < 4.0
    assert page.events()[-1]["state"] == "cancelled"
    assert run(page)["state"] == "done"


def test_a_job_that_does_not_stop_is_ended_with_its_process(page):
    page.ask("POST", "/api/job", {"edits": LONG})
    time.sleep(0.3)
    child = page.child()
    os.kill(child, signal.SIGSTOP)  # deaf to the polite word
    assert page.ask("POST", "/api/job/cancel", {}).json == {"state": "cancelled"}
    assert page.events()[-1] == {"state": "cancelled"}
    assert run(page)["state"] == "done"
    assert page.child() != child


def test_a_process_that_is_killed_from_outside(page):
    page.ask("POST", "/api/job", {"edits": LONG})
    time.sleep(0.3)
    os.kill(page.child(), signal.SIGKILL)
    told = page.events()[-1]
    assert told["state"] == "killed"
    assert "ended from outside (signal 9); run again" in told["text"]
    assert run(page)["state"] == "done"


def test_a_browser_that_goes_away_during_a_run(page):
    page.ask("POST", "/api/job", {"edits": LONG})
    with socket.create_connection(("127.0.0.1", page.port)) as wire:
        wire.sendall(f"GET /api/job/events HTTP/1.1\r\nhost: {page.host}\r\ncookie: {page.cookie}\r\n\r\n".encode())
        assert b"running" in wire.recv(4096) + wire.recv(4096)
    assert page.ask("GET", "/").status == 200
    page.ask("POST", "/api/job/cancel", {})
    assert page.events()[-1]["state"] == "cancelled"


def test_a_file_that_was_changed_on_disk_is_not_overwritten(page, desk):
    text = (desk / "edge.yaml").read_bytes()
    assert page.ask("POST", "/api/save", {"edits": {}}).status == 200
    changed = text + b"# mine\n"
    (desk / "edge.yaml").write_bytes(changed)
    found = page.ask("POST", "/api/save", {"edits": {"spindle.pressure": "3 bar"}})
    assert found.status == 409
    assert b"changed on disk" in found.body
    assert (desk / "edge.yaml").read_bytes() == changed
    (desk / "edge.yaml").unlink()
    assert page.ask("POST", "/api/save", {"edits": {}}).status == 409
    assert not (desk / "edge.yaml").exists()
    (desk / "edge.yaml").write_bytes(text)


def test_a_run_is_kept_as_the_command_line_writes_it(page, desk):
    number = run(page)["run"]
    assert page.ask("POST", f"/api/keep/{number}", {}).status == 202
    told = page.events()[-1]
    assert told["state"] == "done"
    kept = Path(told["files"]["run"])
    assert kept == desk / "cutwise-runs" / "deburr_compliant_spindle" / "run.nc"
    assert kept.with_name("report.html").is_file()
    assert values(Result.from_file(kept, load(kept))) == values(of_run(desk, number))
    assert page.ask("POST", "/api/keep/99", {}).status == 404
    with viewing("edge.yaml", cwd=desk) as again:  # newer than its files: it is shown
        assert b'data-run="1"' in again.ask("GET", "/").body
    with viewing(kept.parent, cwd=desk) as again:
        kept.write_bytes(b"replaced")  # what was opened stays what is shown
        assert again.ask("GET", "/api/run/1/view").status == 200
        state = again.ask("POST", "/api/check", {}).json
        assert (state["faults"], state["can_save"]) == ([], False)
        assert again.ask("POST", "/api/save", {"edits": {}}).status == 409
        made = again.ask("POST", "/api/save", {"edits": {"spindle.pressure": "4 bar"}, "as": "again.yaml"})
        assert made.json == {"file": "again.yaml"}
        assert load(kept.with_name("again.yaml"))["spindle.pressure"] == 4e5
    shutil.rmtree(desk / "cutwise-runs")


def test_a_run_with_other_values_is_not_taken_for_that_of_the_file(page, desk):
    number = run(page, {"spindle.pressure": "4 bar"})["run"]
    assert page.ask("POST", f"/api/keep/{number}", {}).status == 202
    assert page.events()[-1]["state"] == "done"
    with viewing("edge.yaml", cwd=desk) as again:
        assert b'data-run=""' in again.ask("GET", "/").body
    shutil.rmtree(desk / "cutwise-runs")


def test_a_faulty_scenario_opens_with_its_faults(desk):
    (desk / "faulty.yaml").write_text("process: deburr\noperation: {feed: 80, spindle_sped: 40000 rpm}\n")
    (desk / "broken.yaml").write_text("process: deburr\n\t- [\n")
    with viewing("faulty.yaml", cwd=desk) as server:
        state = server.ask("POST", "/api/check", {}).json
        told = {one["key"]: one["text"] for one in state["faults"]}
        assert told["operation.feed"].startswith("faulty.yaml:2:19: operation.feed: 80 has no unit")
        assert "did you mean operation.spindle_speed?" in told["operation.spindle_sped"]
        assert {one["key"]: one["text"] for one in state["fields"]}["operation.feed"] == "80"
        mended = server.ask("POST", "/api/check", {"edits": {"operation.feed": "80 mm/s"}}).json
        assert not any(one["key"] == "operation.feed" for one in mended["faults"])
    with viewing("broken.yaml", cwd=desk) as server:
        state = server.ask("POST", "/api/check", {}).json
        assert "a tab; indent with blanks" in state["faults"][0]["text"]
        assert server.ask("POST", "/api/job", {}).status == 400


def test_a_name_with_marks_of_html_is_text(desk, examples):
    text = (examples / "drill_robot.yaml").read_text()
    (desk / "<script>alert(1)<.yaml").write_text(text)
    with viewing("<script>alert(1)<.yaml", cwd=desk) as server:
        found = server.ask("GET", "/").body
        assert b"<title>&lt;script&gt;alert(1)&lt; " in found
        assert b"<script>alert" not in found


def test_an_uploaded_program_is_used_and_saved_beside_the_scenario(desk, examples):
    shutil.copy(examples / "mill_pocket.yaml", desk / "pocket.yaml")
    shutil.copy(examples / "mill_pocket.nc", desk / "mill_pocket.nc")
    program = (examples / "mill_pocket.nc").read_bytes().replace(b"F2400", b"F1200")
    with viewing("pocket.yaml", cwd=desk) as server:
        word = server.ask("POST", "/api/files?name=slower.nc", program).json["file"]
        assert server.ask("POST", "/api/check", {"edits": {"program": word}}).json["faults"] == []
        assert server.ask("POST", "/api/check", {"edits": {"program": "upload:99"}}).json["faults"]
        saved = server.ask("POST", "/api/save", {"edits": {"program": word}, "as": "slower.yaml"})
        assert saved.json == {"file": "slower.yaml"}, saved.body
        assert (desk / "slower.nc").read_bytes() == program
        assert load(desk / "slower.yaml").program.text == program.decode()
        again = server.ask("POST", "/api/save", {"edits": {"program": word}, "as": "same.yaml"})
        assert again.status == 200  # the file is there already, and the same
        word = server.ask("POST", "/api/files?name=slower.nc", program + b"(another)\n").json["file"]
        other = server.ask("POST", "/api/save", {"edits": {"program": word}, "as": "other.yaml"})
        assert other.status == 409
        assert not (desk / "other.yaml").exists()
        assert (desk / "slower.nc").read_bytes() == program


def test_a_signal_during_a_run_ends_all(desk):
    with viewing("edge.yaml", cwd=desk) as server:
        server.ask("POST", "/api/job", {"edits": LONG})
        time.sleep(0.3)
        child = server.child()
        server.process.send_signal(signal.SIGINT)
        assert server.process.wait(10) == 0
        assert server.process.stderr.read() == ""
    listed = subprocess.run(["ps", "-p", str(child), "-o", "stat="], capture_output=True, text=True, check=False).stdout
    assert listed.strip() in ("", "Z")


def test_two_runs_are_opened_side_by_side(desk, tmp_path_factory):
    result = simulate(load(desk / "edge.yaml", {"numerics.time_step": "40 us"}))
    folder = tmp_path_factory.mktemp("two")
    for name in ("a.nc", "b.nc"):
        result.save(folder / name)
    with viewing("a.nc", "b.nc", cwd=folder) as server:
        assert b'data-run="1" data-other="2"' in server.ask("GET", "/").body
        assert server.ask("POST", "/api/check", {}).json["runs"] == [1, 2]
        assert server.ask("GET", "/api/run/2/view").status == 200


def test_the_page_of_a_study(desk):
    folder = desk / "my-study"
    folder.mkdir()
    (folder / "identity.json").write_text(json.dumps({"study": "x"}))
    (folder / "report.html").write_text("<!doctype html><p>shares</p>")
    with viewing("my-study", cwd=desk) as server:
        assert server.ask("GET", "/").body.endswith(b"<p>shares</p>")
        assert server.ask("POST", "/api/check", {}).status == 404
        assert server.ask("GET", "/", cookie="").status == 403


@pytest.fixture(scope="module")
def cases(desk):
    """A finished study of three edges."""
    (desk / "three.yaml").write_text(
        "name: three\nscenario: edge.yaml\nvary:\n  spindle.pressure: {uniform: [4 bar, 5 bar]}\n"
        "  part.burr.height: {uniform: [0.7 mm, 0.9 mm]}\nwant: {measures: [surface_error_max]}\n"
        "method: monte_carlo\ncases: 3\nseed: 2\n"
    )
    said = subprocess.run(
        [sys.executable, "-m", "cutwise", "study", "three.yaml", "-o", "three"],
        cwd=desk,
        capture_output=True,
        text=True,
        check=False,
    )
    assert said.returncode in (0, 1), said.stderr
    return desk


def test_a_case_of_a_study_is_run_by_a_click(cases):
    """The command that is told, the values in the page and the run are of one case; numbers that are none are refused."""
    with viewing("three", cwd=cases) as server:
        told = server.ask("GET", "/api/study").json
        assert told["done"] == 3
        assert [one["unit"] for one in told["levers"]] == ["bar", "mm"]
        assert sorted(one["case"] for one in told["worst"]) == [0, 1, 2] == told["case"]
        begun = server.ask("POST", "/api/case/1", {})
        assert begun.status == 202
        number, edits = begun.json["run"], begun.json["edits"]
        words = shlex.split(begun.json["command"])
        assert words[:3] == ["cutwise", "run", "edge.yaml"]
        assert words[4::2] == [f"{key}={value}" for key, value in edits.items()]
        assert server.events()[-1]["state"] == "done"
        found = of_run(cases, number)
        assert values(found) == values(simulate(load(cases / "edge.yaml", edits)))
        pressure = told["levers"][0]["values"][1]
        assert 1e-5 * found.scenario["spindle.pressure"] == pytest.approx(pressure, rel=1e-6)
        shown = told["measures"][0]["values"][
            1
        ]  # of the quick runs of a study: as its own text says, not to the last digit
        assert 1e3 * found.measures["surface_error_max"].value == pytest.approx(shown, abs=0.005)
        assert b"spindle.pressure" in server.ask("GET", "/study").body
        for wrong in ("3", "99999999999999999999", "-1", "1.5", "nan"):
            assert server.ask("POST", f"/api/case/{wrong}", {}).status == 404
        assert server.ask("POST", "/api/case/1", {}, without=("x-cutwise",)).status == 403
        assert server.ask("POST", "/api/save", {"edits": edits}).status == 409  # the file is not what was opened
        assert server.ask("POST", "/api/save", {"edits": edits, "as": "case1.yaml"}).status == 200
    assert values(simulate(load(cases / "case1.yaml"))) == values(found)
