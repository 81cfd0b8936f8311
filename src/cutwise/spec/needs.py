"""What a measure needs of the scenario: keys without which no run can give it, whatever else is right.

A need is a key that must be given (``tool.modes``), a key with its value (``numerics.force: tooth_resolved``), one of
several (``part.step or part.block``), or a key that must not be given (``no hole.grid``). Measures stand as patterns:
``force_*_peak``.
"""

from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase

from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.faults import split_dotted

Needs = Mapping[str, tuple[str, ...]]

_AXIAL = "material.K_ac or material.k_a11"
_FORCES = "numerics.force: tooth_resolved or numerics.force: averaged"
_TOOTH = "numerics.force: tooth_resolved"
_PASS = "path or program"

_ARM: Needs = dict.fromkeys(
    (
        "joint_*_margin",
        "wrist_margin",
        "redundancy_angle_*",
        "feed_possible_min",
        "natural_frequency_min",
        "sag_change_max",
        "deflection_arm_*",
        "deflection_base_*",
        "share_arm",
        "share_base",
    ),
    ("robot",),
)
_TERMS = "robot or machine or tool.stiffness or tool.modes or part.stiffness"
_MILLED = "robot or machine.chain or tool.stiffness or tool.modes or part.stiffness or spindle.pressure"
_STEPPED = "numerics.mode: step"
_PISTONS = "spindle.pressure"
_DRIVEN = "machine.drives or machine.control"
DEBURRING: Needs = {
    "*_force_*_z": (_AXIAL,),
    **_ARM,
    **dict.fromkeys(("deflection_*", "share_*", "stiffness_normal_*"), (_TERMS,)),
    **dict.fromkeys(("deviation_drives_max", "share_drives"), (_DRIVEN,)),
    **dict.fromkeys(("deflection_pistons_*", "share_pistons"), (_PISTONS,)),
    **dict.fromkeys(("deflection_tip_*", "share_tip"), ("tool.stiffness or tool.modes",)),
    **dict.fromkeys(("deflection_bodies_*", "share_bodies"), ("machine.chain",)),
    **dict.fromkeys(("deflection_part_stiffness_*", "share_part_stiffness"), ("part.stiffness",)),
    "energy_balance": ("numerics.mode: still", _TERMS),
    **dict.fromkeys(("burr_force_rms_*", "burr_force_peak_*", "settling_time", "path_memory_index"), (_STEPPED,)),
    **dict.fromkeys(
        (
            "surface_error_loaded", "surface_error_unloaded", "surface_error_frictionless", "tooth_force_peak_*",
            "tip_deflection_*", "stroke_margin", "edge_taper", "breakaway_force", "*loading_force",
        ),
        (_PISTONS,),
    ),
}  # fmt: skip
DRILLING: Needs = {
    "redundancy_angle": ("no hole.grid", "robot"),
    **dict.fromkeys(("wrist_margin", "joint_limit_margin", "natural_frequency_min", "share_arm"), ("robot",)),
    "share_base": ("robot.base_compliance",),
    "share_bodies": ("machine",),
    "share_part_stiffness": ("part.stiffness",),
    **dict.fromkeys(("hole_position_error_arm", "hole_position_error_total"), ("robot.accuracy or robot.errors",)),
}
MILLING: Needs = {
    "chatter_growth_*": ("tool.modes",),
    **dict.fromkeys(
        ("cutting_power_max", "spindle_torque_max", "chip_thickness_max", "plunge_force_max"),
        ("stock", "program or setups", "material"),
    ),
    **dict.fromkeys(
        (
            "air_cut_time",
            "rapids_in_stock",
            "collisions",
            "collision_depth_max",
            "surface_check_max",
            "removed_volume_error",
        ),
        ("stock", "program or setups"),
    ),
    **dict.fromkeys(
        ("deviation_min", "deviation_max", "deviation_rms", "gouge_volume", "excess_volume", "scallop_max"),
        ("part.file or part.step",),
    ),
    "fraction_in_tolerance": ("part.tolerance",),
    "deviation_*_ideal": ("part.file or part.step",),
    "tool_offset_*": ("stock", "program or setups"),
    "cycle_time_ideal": ("no robot",),
    "stops": ("no robot",),
    "cutting_time": ("shop",),
    "cost_per_part": ("shop",),
    "tool_life": ("wear",),
    **dict.fromkeys(("cost_low", "cost_high"), ("shop", "wear.scatter")),
    "stable_depth_straight": ("tool.modes",),
    "stable_depth_corner": ("tool.modes",),
    **_ARM,
    **dict.fromkeys(("stiffness_normal_*", "wall_tilt_max", "deflection_*"), (_MILLED,)),
    "floor_error_*": (f"{_MILLED} or machine.z",),
    **dict.fromkeys(("deflection_arm_*", "share_arm", "deflection_base_*", "share_base"), ("robot",)),
    **dict.fromkeys(("deflection_bodies_*", "share_bodies"), ("machine.chain",)),
    **dict.fromkeys(("deflection_tip_*", "share_tip"), ("tool.modes or tool.stiffness", _MILLED)),
    **dict.fromkeys(("deflection_part_stiffness_*", "share_part_stiffness"), ("part.stiffness",)),
    **dict.fromkeys(("deflection_pistons_*", "share_pistons", "stroke_margin"), ("spindle.pressure",)),
    "share_*": ("path.line",),
    "share_drives": ("no robot", _FORCES),
    "deviation_drives_max": ("path.line", "no robot", _FORCES),
    **dict.fromkeys(
        ("tracking_error_max_z", "drive_torque_max_z", "bandwidth_z", "phase_margin_z"),
        ("machine.z or machine.drives.z",),
    ),
    **dict.fromkeys(("stable_depth_min", "depth_margin"), ("robot or tool.modes",)),
    "energy_balance": ("numerics.mode: still", _MILLED),
    **dict.fromkeys(
        (
            "contour_error_*",
            "tracking_error_*",
            "settling_*",
            "drive_voltage_max",
            "drive_torque_*",
            "saturation_time",
            "feed_min",
            "bandwidth_*",
            "phase_margin_*",
        ),
        ("no robot", "no tools"),
    ),
    "tip_deflection_max": ("tool.modes or robot", f"{_TOOTH} or robot"),
    "wall_error_*": ("tool.modes or robot or path.line", f"{_TOOTH} or robot or path.line"),
    "force_*_peak": (_TOOTH, "no robot"),
    "force_z_peak": (_AXIAL,),
    "force_xy_*_straight": (f"{_FORCES} or robot",),
    "force_xy_*_corner": (_FORCES, "no robot"),
    "remov*": ("stock",),
    "drive_error_max": ("path_mode.blend or program",),
}
MACHINE: Needs = {
    **{name: ("robot",) for name in _ARM if "frequency" not in name and "_arm" not in name and "_base" not in name},
    "stiffness_normal_*": ("robot",),
    "deviation_*": (_PASS,),
    "share_*": (_PASS,),
    "position_start_*": (_PASS,),
    "linear_residual_max": (_PASS,),
    "energy_balance": (_PASS,),
    "work_convexity": (_PASS,),
    "stiffening_gain_best": (_PASS,),
    "wall_*": ("surface", _PASS),
    "deviation_p95": ("uncertainty",),
    "deviation_random_p95": ("uncertainty",),
    "deviation_std_*": ("uncertainty",),
    "probability_within": ("uncertainty.tolerance", _PASS),
    "volumetric_error_max": ("volume",),
    "diagonal_range_*": ("volume",),
    "map_interpolation_error": ("volume",),
}
CHAMFER: Needs = {
    "edges_*": ("part.step or part.block",),
    "length_trimmed": ("part.step or part.block",),
    "corners_joined": ("part.step or part.block",),
    "setup_width_*": ("setup",),
    **dict.fromkeys(("force_mean_*", "burr_force_*", "lateral_force_max", "chip_area"), ("material",)),
    "cutting_power_mean": ("material",),
    "*force_mean_z": (_AXIAL,),
    "burr_force_mean_*": ("part.burr",),
    **dict.fromkeys(
        ("width_deflected_*", "tip_deflection_max", "rod_clearance_deflected_min"), (f"spindle.pressure or {_TERMS}",)
    ),
    **dict.fromkeys(("stroke_margin", "breakaway_force"), ("spindle.pressure",)),
    **_ARM,
    **dict.fromkeys(("stiffness_normal_*", "deflection_*", "share_*"), (_TERMS,)),
    **dict.fromkeys(("deflection_pistons_*", "share_pistons"), (_TERMS, "spindle.pressure")),
    **dict.fromkeys(("deflection_tip_*", "share_tip"), ("tool.stiffness or tool.modes",)),
    **dict.fromkeys(("deflection_bodies_*", "share_bodies"), ("machine.chain",)),
    **dict.fromkeys(("deviation_drives_max", "share_drives"), (_DRIVEN,)),
    **dict.fromkeys(("deflection_part_stiffness_*", "share_part_stiffness"), ("part.stiffness",)),
}


def unmet(scenario: Spec, needs: Needs, measure: str) -> Iterator[str]:
    """The needs of a measure that a scenario does not meet, each with what the key is."""
    for pattern, keys in needs.items():
        if fnmatchcase(measure, pattern):
            for need in keys:
                ways = need.split(" or ")
                if not any(_given(scenario, way) for way in ways):
                    yield " or ".join(_described(scenario, way) for way in ways)


def _given(scenario: Spec, way: str) -> bool:
    key, _, wanted = way.removeprefix("no ").partition(": ")
    steps = split_dotted(key)
    if steps[0] in type(scenario).model_fields and steps[0] not in vars(scenario):
        return True  # the section is there with faults of its own: nothing is said about what it would give
    here: object = scenario
    for step in steps:
        here = getattr(here, str(step), None)
    there = here is not None and here != () and here != {}
    if way.startswith("no "):
        return not there
    return here == wanted if wanted else there


def _described(scenario: Spec, way: str) -> str:
    info = fields.field_at(type(scenario), split_dotted(way.removeprefix("no ").partition(": ")[0]))
    return way if info is None or ": " in way or not info.description else f"{way} ({info.description})"
