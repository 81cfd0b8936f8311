"""Every key of a scenario is described and shown by an example that is itself allowed; no physics by default."""

import pytest
from pydantic import TypeAdapter

from cutwise import units
from cutwise.io.tree import compose
from cutwise.spec import fields
from cutwise.spec.kinds import ALIASES, KINDS

KEYS = [(kind, path, info) for kind, model in KINDS.items() for path, info in fields.keys(model)]
BARE = [(path, info) for _, path, info in KEYS]
NAMES = [".".join((kind, *path)) for kind, path, _ in KEYS]

# How the run is done, or what counts as ideal; everything else comes from the engineer or a library.
WITHOUT_PHYSICS = {
    "name", "process", "requirements", "library", "milling", "lead_out_time", "path_error", "tolerance", "axial_start",
    # chamfer: a plain pipe and cutter, the exact path, a set-up without error unless given
    "eccentricity", "holes", "edges", "definition", "tier", "tilt", "clearance", "pole_limit_angle", "axis", "retract",
    "preset", "part_error", "position", "radius", "wall", "angle", "ball_radius",
    "slices", "seed", "force", "time_step", "setups", "sweep", "runout", "runout_angle", "gravity", "numerics", "engagement",
    "stability", "samples", "points", "diagonal_points", "orders", "convention", "weights", "feed_moment", "load", "at", "elements",
    # drilling: flat plate where it lies, frames without a turn, one hole, the simple lip, postures by search
    "inclination", "slope_direction", "x", "y", "z", "steps", "rotation", "flange_origin", "flange_rotation",
    "urdf_remarks", "solid_remarks", "columns", "rows", "others", "lip_model", "lip_elements", "azimuths", "angle_step",
    "redundancy_angle", "singularity_margin", "drill_torque_on_arm",
    # followers as a URDF has them, no joint held, no linkage
    "multiplier", "offset", "held_joints", "linkages",
    "lead", "turn", "compare", "path_mode", "reading", "readings", "modes", "substeps", "settling_time", "text", "act_on",
    # a carrier: where the part stands, how postures are chosen, which model of the arm
    "origin", "objective", "dynamics", "sag", "station", "mode", "operation", "step_limit",
    # how a tool is led: as fed, rigid, upright, at once
    "limit_feed", "lead_in_time", "spindle", "tool_axis",
    # machine: conventions of signs and frames
    "errors_act", "zero", "words", "top",
    # milling: how corners are rounded, and how the map of stability is drawn
    "shape", "lobes", "speeds", "depths",
    # programs: how they are written
    "dialect",
    # a stock in 3D: no fixtures, no holder, how finely the surface is looked at
    "tools", "fixtures", "holder", "stock", "grid", "check", "memory_limit",
    # how sure values are, and how that is carried on; errors of an arm that has none
    "band", "method", "covariances", "measured", "bodies", "joints", "gravity_compliance", "ranges", "compensated",
    "link_weights",
    # turning: no pass without depth, towards the headstock
    "spring_passes", "towards",
    # correct: what may be changed, and how closely it is looked at
    "correct", "change", "limits", "split_gain", "residual", "iterations", "chord", "decimals", "shift_max", "draws", "vary",
    "ramp",
    # holes are led nowhere else, corners are sharp, and tools wear by nothing and scatter by nothing that is not said
    "corrections", "shift", "corner_radius", "feed_exponent", "depth_exponent", "scatter", "cases",
}  # fmt: skip


@pytest.mark.parametrize(("path", "info"), BARE, ids=NAMES)
def test_every_key_has_a_description_and_a_value_an_example(path, info):
    assert info.description
    if not fields.sections(info) or fields.dimension(info):
        assert info.examples or path[-1] == "process"


@pytest.mark.parametrize(("kind", "path", "info"), KEYS, ids=NAMES)
def test_examples_and_usual_ranges_are_allowed(kind, path, info):
    if path[-1] in ("requirements", "min", "max") or (fields.sections(info) and not fields.dimension(info)):
        return
    for example in info.examples or ():
        tree, faults = compose(str(example), "example")
        assert not faults
        owner = KINDS[kind] if len(path) == 1 else next(iter(_owners(KINDS[kind], path)))
        TypeAdapter(owner.model_fields[path[-1]].rebuild_annotation()).validate_python(tree.plain())
    usual, dimension = fields.usual(info), fields.dimension(info)
    if usual is not None and dimension is not None:
        ends = [units.parse(end, dimension) for end in (usual.low, usual.high) if end is not None]
        assert ends == sorted(ends)


def _owners(model, path):
    sections = [model]
    for step in path[:-1]:
        sections = [
            below
            for section in sections
            if step in section.model_fields
            for below in fields.inner(section.model_fields[step])
        ]
    return (section for section in sections if path[-1] in section.model_fields)


@pytest.mark.parametrize(("path", "info"), BARE, ids=NAMES)
def test_no_default_is_a_guess_about_physics(path, info):
    given_by_default = not info.is_required() and info.default is not None
    assert not given_by_default or path[-1] in WITHOUT_PHYSICS


def test_every_measure_has_a_known_dimension_and_a_description():
    for model in KINDS.values():
        for name, measure in model.measures.items():
            assert measure.dimension in units.DIMENSIONS, name
            assert measure.description


def test_aliases_mean_something():
    assert set(ALIASES.values()) <= set(KINDS)
    assert not set(ALIASES) & set(KINDS)
