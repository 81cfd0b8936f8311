"""What is tried of each kind of input: scenario texts and keys, units, NC, APT, URDF, CSV tables, run files, reports."""

import io
import json
import random
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

from cutwise.io.scenario import load
from cutwise.io.template import template
from cutwise.spec import fields
from cutwise.spec.faults import dotted
from cutwise.spec.kinds import KINDS as PROCESSES
from fuzz.inputs import HURTFUL, damaged, mutated, quantities
from fuzz.trial import Trial

EXAMPLES = Path(__file__).parent.parent.parent / "examples"
_BESIDE = ("mill_pocket.nc", "bracket.ngc", "bracket.tbl")

NC = """%
(facing) G21 G90 G17 G54 G64 P0.01 T1 M6 S8000 M3
#1=5 #<depth>=-2.5
G0 X0 Y0 Z5 F600
o100 repeat [3]
G1 Z[#<depth>*2] F[#1*100] X10 Y[#1+1]
G2 X20 Y0 I5 J0
G3 X10 Y10 R12
o100 endrepeat
G91 G81 X3 Z-1 R1 L2
G80 G90 G41.1 D4 G1 X1 Y1
G40 G28 Z0
G83 X5 Y5 Z-3 R1 Q0.5
o1 if [#1 GT 2]
G10 L2 P1 X1 Y2
o1 endif
M98 P2
M30
%
"""
APT = """PARTNO/bracket
UNITS/MM
LOADTL/1
SPINDL/8000,RPM,CLW
RAPID
GOTO/0,0,5,0,0,1
FEDRAT/600,MMPM
CIRCLE/10,0,0,0,0,1,10
GOTO/20,0,0
CYCLE/DRILL,5,MMPM,100,2
GODLTA/1,2,0
CYCLE/OFF
COOLNT/OFF
FINI
"""
CSV = "w [mm], height [mm], note\n# a burr\n0, 0.5, a\n10, 0.7, b\n20, 1e-1, c\n80, 0.2, d\n"
URDF = "".join(
    [
        '<?xml version="1.0"?><robot name="arm"><link name="base"/>',
        *(
            f'<link name="l{k}"><inertial><mass value="20"/></inertial></link><joint name="j{k}" type="revolute">'
            f'<parent link="{f"l{k - 1}" if k > 1 else "base"}"/><child link="l{k}"/><origin xyz="{xyz}" rpy="0 0 0"/>'
            f'<axis xyz="{axis}"/><limit lower="-2.9" upper="2.9" effort="900" velocity="2"/></joint>\n'
            for k, (xyz, axis) in enumerate(
                (
                    ("0 0 0.675", "0 0 -1"), ("0.35 0 0", "0 1 0"), ("1.15 0 0", "0 1 0"), ("1.2 0 -0.041", "-1 0 0"),
                    ("0 0 0", "0 1 0"), ("0.24 0 0", "-1 0 0"),
                ),
                1,
            )
        ),
        "</robot>",
    ]
)  # fmt: skip

Trials = Iterator[Trial]


@cache
def scenarios() -> tuple[str, ...]:
    """Good scenario texts: the examples, and the templates of every process."""
    examples = [file.read_text(encoding="utf-8") for file in sorted(EXAMPLES.glob("*.yaml"))]
    return (*examples, *(template(kind) for kind in PROCESSES))


def _beside() -> tuple[tuple[str, bytes], ...]:
    return tuple((name, (EXAMPLES / name).read_bytes()) for name in _BESIDE)


def texts(rng: random.Random) -> Trials:
    """Scenario texts with something done to them, as YAML, as JSON, as a report."""
    while True:
        text = mutated(rng.choice(scenarios()), rng)
        name = rng.choice(("s.yaml",) * 8 + ("s.json", "s.html"))
        if name == "s.html":
            text = b'<html><script type="application/json" id="scenario">' + text + b"</script></html>"
        yield Trial("scenario text", ("check", name), (*_beside(), (name, text)))


@cache
def _keys() -> tuple[tuple[str, str], ...]:
    found = []
    for example in sorted(EXAMPLES.glob("*.yaml")):
        model = type(load(example))
        found += [(example.name, dotted(path)) for path, _ in fields.keys(model)]
    return tuple(found)


def keys(rng: random.Random) -> Trials:
    """Every key of every process with what hurts."""
    units = quantities(rng)
    while True:
        example, key = rng.choice(_keys())
        value = rng.choice(HURTFUL) if rng.random() < 0.6 else next(units)
        files = (*_beside(), (example, (EXAMPLES / example).read_bytes()))
        yield Trial("key", ("check", example, "--set", f"{key}={value}"), files)


def nc(rng: random.Random) -> Trials:
    """NC programs."""
    sources = (NC, (EXAMPLES / "bracket.ngc").read_text(), (EXAMPLES / "mill_pocket.nc").read_text())
    while True:
        form = rng.choice(((), ("--json",), ("--canonical",)))
        yield Trial("NC", ("program", "p.ngc", *form), (("p.ngc", mutated(rng.choice(sources), rng)),))


def apt(rng: random.Random) -> Trials:
    """APT programs."""
    sources = (APT, (EXAMPLES / "plate.apt").read_text())
    while True:
        form = rng.choice(((), ("--json",), ("--canonical",)))
        yield Trial("APT", ("program", "p.apt", *form), (("p.apt", mutated(rng.choice(sources), rng)),))


def tool_tables(rng: random.Random) -> Trials:
    """Tool tables."""
    text, program = (EXAMPLES / "bracket.tbl").read_text(), (EXAMPLES / "bracket.ngc").read_bytes()
    while True:
        files = (("p.ngc", program), ("t.tbl", mutated(text, rng)))
        yield Trial("tool table", ("program", "p.ngc", "--tool-table", "t.tbl"), files)


def urdf(rng: random.Random) -> Trials:
    """Robots."""
    text = (EXAMPLES / "drill_robot.yaml").read_bytes()
    while True:
        files = (("d.yaml", text), ("r.urdf", mutated(URDF, rng)))
        yield Trial("URDF", ("check", "d.yaml", "--set", "robot.urdf=r.urdf"), files)


def csv(rng: random.Random) -> Trials:
    """Tables."""
    text = (EXAMPLES / "deburr_compliant_spindle.yaml").read_bytes()
    while True:
        files = (("d.yaml", text), ("b.csv", mutated(CSV, rng)))
        yield Trial("CSV", ("check", "d.yaml", "--set", "part.burr.height=b.csv"), files)


@cache
def run_file() -> bytes:
    """A short run of the deburring example."""
    from cutwise.io.scenario import load
    from cutwise.process.recipes import simulate

    result = simulate(
        load(EXAMPLES / "deburr_compliant_spindle.yaml", ["operation.duration=0.3 s", "numerics.time_step=100 us"])
    )
    return result.to_bytes()


def run_bytes(rng: random.Random) -> Trials:
    """Run files damaged on the way: the seal says it."""
    while True:
        command = rng.choice((("report", "r.nc", "-o", "r.html"), ("export", "r.nc", "-o", "x"), ("check", "r.nc")))
        yield Trial("damaged run file", command, (("r.nc", damaged(run_file(), rng)),))


def run_tampered(rng: random.Random) -> Trials:
    """Run files that another program has changed: no seal any more."""
    while True:
        command = rng.choice((("report", "r.nc", "-o", "r.html"), ("export", "r.nc", "-o", "x"), ("check", "r.nc")))
        yield Trial("tampered run file", command, (("r.nc", _tampered(run_file(), rng)),))


def _tampered(content: bytes, rng: random.Random) -> bytes:
    import h5py

    stream = io.BytesIO(content.rpartition(b"\ncutwise run file")[0])
    with h5py.File(stream, "r+") as file:
        for _ in range(rng.randint(1, 3)):
            rng.choice(_TAMPERINGS)(file, rng)
    return stream.getvalue()


def _attribute_gone(file, rng: random.Random) -> None:
    names = list(file.attrs)
    if names:
        del file.attrs[rng.choice(names)]


def _attribute_hurt(file, rng: random.Random) -> None:
    name = rng.choice(("scenario", "summary", "measures", "limits", "references", "notes"))
    file.attrs[name] = rng.choice(
        ("", "[]", "{}", "null", "1e999", "[" * 900, "NaN", '"a"', "9" * 400, '{"a": [1]}', "{")
    )


def _json_hurt(file, rng: random.Random) -> None:
    name = rng.choice(("scenario", "summary", "measures"))
    try:
        data = json.loads(file.attrs[name])
    except (KeyError, ValueError):
        return
    here = data
    while isinstance(here, dict | list) and here:
        key = rng.choice(list(here)) if isinstance(here, dict) else rng.randrange(len(here))
        if rng.random() < 0.4 or not isinstance(here[key], dict | list):
            here[key] = rng.choice((None, 10**400, 1e308, -1, "", "a\rb", [], {}, [[[1]]], True, float("nan"), "9 mm"))
            break
        here = here[key]
    file.attrs[name] = json.dumps(data)


def _array_gone(file, rng: random.Random) -> None:
    groups = [name for name in file if len(file[name])]
    if groups:
        group = file[rng.choice(groups)]
        if hasattr(group, "keys"):
            del group[rng.choice(list(group))]


def _array_hurt(file, rng: random.Random) -> None:
    import numpy as np

    groups = [file[name] for name in file if hasattr(file[name], "keys") and len(file[name])]
    if not groups:
        return
    group = rng.choice(groups)
    name = rng.choice(list(group))
    value = rng.choice((np.zeros(3), np.array(["=1+1", "b"], dtype=object), np.array(1.0), np.full((2, 2), np.nan)))
    del group[name]
    group[name] = value


_TAMPERINGS: tuple[Callable[..., None], ...] = (
    _attribute_gone, _attribute_hurt, _json_hurt, _json_hurt, _array_gone, _array_hurt,
)  # fmt: skip

CHEAP = {
    "texts": texts, "keys": keys, "nc": nc, "apt": apt, "tool_tables": tool_tables, "urdf": urdf, "csv": csv,
    "run_bytes": run_bytes,
}  # fmt: skip
ALL = {**CHEAP, "run_tampered": run_tampered}
