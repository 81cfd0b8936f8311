"""A plain turned shaft as a scenario, with a few other values: what the tests of turning are made from."""

import copy

from cutwise.io.scenario import read_document
from cutwise.process.turning import run, setup

PLAIN = {
    "name": "shaft", "process": "turn",
    "operation": {"cutting_speed": "180 m/min", "feed": "0.2 mm/rev", "passes": 1},
    "part": {
        "stock_diameter": "22 mm", "sections": [{"length": "300 mm", "diameter": "20 mm"}],
        "youngs_modulus": "210 kN/mm^2", "poisson_ratio": -0.999999,
    },
    "tool": {"nose_radius": "0.4 mm", "lead_angle": "45 deg", "trail_angle": "30 deg"},
    "material": {"K_tc": "2000 N/mm^2", "K_rc": "900 N/mm^2", "K_te": "30 N/mm", "K_re": "25 N/mm"},
    "lathe": {"headstock": "chuck", "tailstock": "none"},
    "numerics": {"station": "20 mm"},
}  # fmt: skip


def scenario(**changes):
    """The plain scenario with dotted keys changed; None takes a key away."""
    said = copy.deepcopy(PLAIN)
    for key, value in changes.items():
        *way, last = key.split("__")
        here = said
        for step in way:
            here = here.setdefault(step, {})
        here[last] = value
        if value is None:
            del here[last]
    return read_document(said)


def turned(**changes):
    return run(setup(scenario(**changes)))
