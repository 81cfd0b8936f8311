"""The measures that each process reports: names, dimensions, meaning. The names are part of the interface."""

from collections.abc import Mapping

from cutwise.spec.scenario import MeasureSpec


def _per_axis(name: str, dimension: str, description: str, axes: str = "xyz") -> dict[str, MeasureSpec]:
    return {f"{name}_{axis}": MeasureSpec(dimension, f"{description}, {axis} direction") for axis in axes}


DEBURRING: Mapping[str, MeasureSpec] = {
    "surface_error_mean": MeasureSpec("length", "mean edge error over the steady part; positive: burr left"),
    "surface_error_min": MeasureSpec("length", "smallest edge error over the steady part; negative: cut into the part"),
    "surface_error_max": MeasureSpec("length", "largest edge error over the steady part; positive: burr left"),
    "surface_error_loaded": MeasureSpec("length", "edge error where the spindle has been pushed out (loading plateau)"),
    "surface_error_unloaded": MeasureSpec("length", "edge error where the spindle returns (unloading plateau)"),
    "surface_error_frictionless": MeasureSpec("length", "edge error with seals without friction"),
    "fraction_partial": MeasureSpec("dimensionless", "share of the edge after the lead-in with burr left"),
    "fraction_ideal": MeasureSpec("dimensionless", "share of the edge after the lead-in within the tolerance"),
    "fraction_excessive": MeasureSpec("dimensionless", "share of the edge after the lead-in cut too deep"),
    **_per_axis("burr_force_mean", "force", "mean force of the burr on the tool, steady part"),
    **_per_axis("burr_force_rms", "force", "root mean square force of the burr on the tool, steady part"),
    **_per_axis("burr_force_peak", "force", "largest force of the burr on the tool, whole run"),
    **_per_axis("work_force_mean", "force", "mean force of the part on the tool, steady part"),
    **_per_axis("tooth_force_peak", "force", "largest force on the tool, resolved tooth by tooth, steady part"),
    "settling_time": MeasureSpec("time", "last time at which the edge error is more than 5 µm from its end value"),
    **_per_axis("tip_deflection", "length", "mean deflection at the tool tip, steady part", "xy"),
    "cutting_power_mean": MeasureSpec("power", "mean of tangential force times cutting speed, steady part"),
    "stroke_margin": MeasureSpec("length", "stroke minus the largest piston travel"),
    "path_memory_index": MeasureSpec(
        "dimensionless", "above 1 the arcs no longer carry the memory of the surface: A ω² R / v_f²"
    ),
    "edge_taper": MeasureSpec("length", "difference of the edge error over the part's face along the mill axis"),
    "breakaway_force": MeasureSpec("force", "lateral force at the tip at which the spindle starts to yield"),
    "loading_force": MeasureSpec("force", "lateral force at the tip while the spindle is pushed out"),
    "unloading_force": MeasureSpec("force", "lateral force at the tip while the spindle returns"),
}

CHAMFER: Mapping[str, MeasureSpec] = {
    "width_min": MeasureSpec("length", "smallest width that the swept ball leaves"),
    "width_max": MeasureSpec("length", "largest width that the swept ball leaves"),
    "gouge_max": MeasureSpec("length", "deepest cut into the part beyond the chamfer"),
    "rod_clearance_min": MeasureSpec("length", "smallest distance of the rod from the part"),
    "knife_margin_min": MeasureSpec("angle", "how far the contact stays on the knife, off neck and pole"),
    "tilt": MeasureSpec("angle", "tilt of the chamfer; the largest, if paths differ"),
    "leg_ratio_max": MeasureSpec("dimensionless", "longer over shorter leg, where that is largest"),
    "wedge_angle_min": MeasureSpec("angle", "smallest angle of material along the edge"),
    "wedge_angle_max": MeasureSpec("angle", "largest angle of material along the edge"),
    "path_length": MeasureSpec("length", "length of the centre path, without leads"),
    "edge_length": MeasureSpec("length", "length of the edges that are chamfered"),
    "points": MeasureSpec("dimensionless", "number of path points, without leads"),
    "cycle_time": MeasureSpec("time", "time along the edges, without leads"),
    "chord_error": MeasureSpec("length", "largest distance between centre curve and its chords"),
    "setup_sensitivity_z": MeasureSpec("dimensionless", "width change per unit of set-up error along the tool axis"),
    "setup_width_low": MeasureSpec("length", "smallest width along the edge, 5 % of the set-ups are below"),
    "setup_width_high": MeasureSpec("length", "largest width along the edge, 5 % of the set-ups are above"),
    **_per_axis("force_mean", "force", "mean cutting force on the tool in the frame of the pass"),
    "lateral_force_max": MeasureSpec("force", "largest force across the tool axis"),
    "chip_area": MeasureSpec("area", "largest cross-section taken off, across the feed"),
    "cutting_power_mean": MeasureSpec("power", "mean cutting power"),
    "width_deflected_min": MeasureSpec("length", "smallest width with the spindle deflected"),
    "width_deflected_max": MeasureSpec("length", "largest width with the spindle deflected"),
    "tip_deflection_max": MeasureSpec("length", "largest deflection of the tool tip"),
    "breakaway_force": MeasureSpec("force", "lateral force at the tip at which the spindle starts to yield"),
    "edges_chamfered": MeasureSpec("dimensionless", "number of edges with a proven path"),
    "edges_refused": MeasureSpec("dimensionless", "number of selected edges without one"),
    "length_trimmed": MeasureSpec("length", "edge length given up at corners and concave neighbours"),
}
