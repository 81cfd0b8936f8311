"""What a run says is records: code, place, value, limit and remedy, in one order, and no text is read again."""

import ast
import json
from pathlib import Path

import pytest

import cutwise
from cutwise.app.findings import notices as in_words
from cutwise.app.findings import reasons
from cutwise.io.scenario import load, read_document
from cutwise.process.recipes import simulate
from cutwise.results import Finding, Infeasible, Place, Result
from cutwise.spec.notices import notices

PROCESS = Path(cutwise.__file__).parent / "process"
SLOW = ", ".join(["1 deg/s"] * 6)
SAID = {  # a scenario, and the codes of what it says
    ("drill_robot", "contact.friction=0.01", "operation.feed_per_rev=0.3 mm/rev"): {"skates", "below_base"},
    ("machine_error_budget", "uncertainty=null", "path.samples=3", "load.force=[400000 N, 0 N, 0 N]"): {
        "beyond_first_order", "left_out",
    },
    ("chamfer_pipe_hole", "path.points=48", "setup=null", "part.edges=all", "chamfer.width=1.9 mm"): {"legs_within_wall"},
    ("chamfer_on_robot", "path.points=48", f"robot.joint_speed=[{SLOW}]"): {"too_fast"},
    ("deburr_on_robot", "path.line.from=[5000 mm, -10 mm, 800 mm]", "path.line.to=[5000 mm, 10 mm, 800 mm]"): {"unreachable"},
}  # fmt: skip


@pytest.mark.parametrize("case", SAID, ids=lambda case: " ".join(case[:2]))
def test_all_that_is_said_is_a_record(case, examples):
    result = simulate(load(examples / f"{case[0]}.yaml", [*case[1:], "requirements={}"]))
    assert {finding.code for finding in result.findings} >= SAID[case]
    own = {finding.words for finding in result.findings if finding.words}
    assert set(result.warnings) <= own
    assert set(notices(result.scenario)) <= own
    assert set(result.infeasible) == {finding.words for finding in result.findings if finding.cannot}
    assert (result.verdict == "fail") == any(finding.rank < 2 for finding in result.findings)
    ranks = [finding.rank for finding in result.findings]
    assert ranks == sorted(ranks)
    told = [*result.infeasible, *reasons(result), *in_words(result), *result.warnings]
    assert len(told) == len(set(told))


def test_records_survive_a_run_file(examples):
    case = ("drill_robot", "contact.friction=0.01")
    result = simulate(load(examples / f"{case[0]}.yaml", [case[1], "requirements={}"]))
    again = Result.from_bytes(result.to_bytes(), read_document(result.scenario.document()))
    assert again.findings == result.findings
    skates = next(told for told in result.summary()["findings"] if told["code"] == "skates")
    assert skates["limit"] == pytest.approx(0.01)
    assert skates["remedy"]["key"] == "robot.redundancy_angle"
    assert skates["text"] in result.warnings
    assert not skates["decides"]


@pytest.mark.parametrize(
    "finding",
    [
        Finding("unstable", Place("arm"), 1.2, 1.0),
        Finding("too_fast", Place(position=0.1), 0.2, 0.1, "speed", words="the joints follow less", cannot=True),
        Infeasible("nothing holds", "gives_way", Place("pads")).finding,
    ],
    ids=lambda finding: finding.code,
)
def test_a_record_is_read_back_as_it_was_written(finding):
    assert Finding.from_json(json.loads(json.dumps(finding.as_json()))) == finding


@pytest.mark.parametrize("file", sorted(PROCESS.glob("*.py")), ids=lambda path: path.name)
def test_no_row_warns_by_a_bare_sentence(file):
    """Generators of warnings yield records, or pass on those of others."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        warns = isinstance(node, ast.FunctionDef) and node.returns is not None and "Said" in ast.unparse(node.returns)
        for inner in ast.walk(node) if warns else ():
            value = inner.value if isinstance(inner, ast.Yield) else None
            assert not isinstance(value, ast.JoinedStr | ast.Constant), f"{file.name}:{inner.lineno}"
