"""The scenario to begin with."""

import re

import pytest

from cutwise.io import library
from cutwise.io.scenario import parse
from cutwise.io.template import template
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.kinds import KINDS
from cutwise.spec.notices import notices


@pytest.mark.parametrize("kind", KINDS)
def test_it_loads_without_a_fault_and_nothing_in_it_is_unusual(kind):
    scenario = parse(template(kind))
    assert scenario.process == kind
    assert notices(scenario) == ()


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_that_is_commented_out_may_be_written(kind):
    lines = template(kind).splitlines()
    keys = [number for number, line in enumerate(lines) if re.match(r"\s+# [A-Za-z_0-9]+: \S.*", line)]
    tried = 0
    for number in keys:
        line = lines[number].replace("# ", "", 1)
        if line.split(":")[0].strip() in (
            "there are",
            "duration",
            "spindle_speed",
            "step",
            "edges",
            "block",
            "burr",
            "centre_feed",
            "chord_tolerance",
            "side",
            "limit_feed",  # for a robot
            "feed_profile",  # not beside a path error over time, which the template shows
        ) or not _is_value(line):
            continue
        changed = [*lines]
        changed[number] = line
        parse("\n".join(changed))
        tried += 1
    assert tried > 10


def _is_value(line):
    """Not the name of a library entry with what it describes."""
    return line.split(":")[0].strip() not in {name for shelf in library.SHELVES for name in library.names(shelf)}


def test_unknown_kinds():
    with pytest.raises(ScenarioFault, match=r"did you mean deburr\?"):
        template("deburring")
