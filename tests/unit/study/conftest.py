"""What several tests of corrections are made with."""

import json

import pytest

from cutwise.app import cli

TEXT = "G21 G90 G94 S6000 M3\nG0 X-7 Y0 Z5\nG0 Z-3\nG1 X8 F600\nG1 Y4\nM2\n"
SCENARIO = """process: mill
program: side.nc
stock: {x: [0 mm, 60 mm], y: [-10 mm, 40 mm], z: [-20 mm, 0 mm]}
tool: {diameter: 12 mm, flutes: 2, helix: 0 deg, flute_length: 30 mm}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
"""


@pytest.fixture(scope="session")
def slot(tmp_path_factory):
    """A slot of 12 mm by two straight flutes, that turns a corner: a run takes a third of a second."""
    folder = tmp_path_factory.mktemp("slot")
    (folder / "side.nc").write_text(TEXT, encoding="utf-8")
    (folder / "side.yaml").write_text(SCENARIO, encoding="utf-8")
    return folder / "side.yaml"


@pytest.fixture
def corrected(slot, capsys):
    """The command ``cutwise correct`` on that slot, in this process: exit code and its JSON."""

    def run(*options):
        with pytest.raises(SystemExit) as left:
            cli.main(["correct", str(slot), *options, "--json"])
        return left.value.code, json.loads(capsys.readouterr().out)

    return run
