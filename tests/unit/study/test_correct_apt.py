"""APT comes in and goes out: corrected by its moves, written anew, and read back to the motion that was simulated."""

import pytest

import cutwise
from cutwise.app import cli
from cutwise.io.scenario import load
from cutwise.programs.interpreter import interpret
from cutwise.programs.setup import Setup
from cutwise.programs.unroll import as_rs274
from cutwise.spec.faults import ScenarioFault

TEXT = """PARTNO/SLOT
UNITS/MM
FROM/-7.0,0.0,5.0
LOADTL/1
SPINDL/6000,RPM,CLW
PPRINT/KEPT BY NOBODY
RAPID
GOTO/-7.0,0.0,-3.0
FEDRAT/600,MMPM
GOTO/8.0,0.0,-3.0
CIRCLE/8.0,4.0,-3.0,0.0,0.0,1.0,4.0
GOTO/12.0,4.0,-3.0
DELAY/0.2
GOTO/12.0,10.0,-3.0
SPINDL/OFF
FINI
"""


def test_an_apt_program_is_corrected_and_written_as_apt(slot, tmp_path, capsys):
    (tmp_path / "slot.apt").write_text(TEXT, encoding="utf-8")
    said = slot.read_text(encoding="utf-8").replace("side.nc", "slot.apt")
    (tmp_path / "slot.yaml").write_text(said + "correct: {limits: {force_xy_peak: {max: 270 N}}}\n", encoding="utf-8")
    with pytest.raises(SystemExit) as left:
        cli.main(["correct", str(tmp_path / "slot.yaml"), "-o", str(tmp_path / "new.apt")])
    assert left.value.code == 0
    assert "slot.apt is APT" in capsys.readouterr().out
    new = (tmp_path / "new.apt").read_text(encoding="utf-8")
    ends = [move.end for move in interpret(new, "new.apt").moves]
    assert all(
        any(end == pytest.approx(one, abs=1e-9) for one in ends)
        for end in [m.end for m in interpret(TEXT, "a.apt").moves]
    )
    before, after = (
        cutwise.simulate(load(tmp_path / "slot.yaml", {"program": name})).measures for name in ("slot.apt", "new.apt")
    )
    assert after["force_xy_peak"].value <= 270.0
    assert after["cycle_time"].value < 0.9 * before["cycle_time"].value


def test_apt_as_g_code_makes_the_same_moves():
    text, begin = as_rs274(TEXT, "a.apt", Setup())
    assert begin == (-0.007, 0.0, 0.005)
    assert "G61" in text
    assert "G4 P0.2" in text
    with pytest.raises(ScenarioFault, match="cannot be written as G-code: line"):
        as_rs274(
            "PARTNO/A\nUNITS/MM\nFROM/0,0,0\nFEDRAT/100,MMPM\nMULTAX/ON\nGOTO/1,0,0,0.6,0.0,0.8\nFINI\n",
            "a.apt",
            Setup(),
        )
