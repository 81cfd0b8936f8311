"""The measures that each process reports: names, dimensions, meaning. The names are part of the interface."""

import re
from collections.abc import Mapping

from cutwise.spec.scenario import MeasureSpec


def _per_axis(name: str, dimension: str, description: str, axes: str = "xyz") -> dict[str, MeasureSpec]:
    return {f"{name}_{axis}": MeasureSpec(dimension, f"{description}, {axis} direction") for axis in axes}


def _deflections(term: str, what: str, over: str = "after the lead-in") -> dict[str, MeasureSpec]:
    return {
        **_per_axis(f"deflection_{term}_mean", "small_length", f"{what}, mean {over}"),
        **_per_axis(f"deflection_{term}_max", "small_length", f"{what}, where it is largest, with its sign"),
    }


CARRIED: Mapping[str, MeasureSpec] = {
    **_deflections("pistons", "displacement by the tilting spindle where the surface is read"),
    **_deflections("arm", "displacement by the joints of the robot where the surface is read"),
    **_deflections("base", "displacement by the base of the robot where the surface is read"),
    **_deflections("tip", "displacement by the tip of the tool at rest where the surface is read"),
    **_deflections("bodies", "displacement by the bodies of the machine where the surface is read"),
    **_deflections("part_stiffness", "displacement by the part where the surface is read"),
    "share_tip": MeasureSpec("small_length", "part of the tip of the tool in it"),
    "share_bodies": MeasureSpec("small_length", "part of the bodies of the machine in it"),
    "share_part_stiffness": MeasureSpec("small_length", "part of the part in it"),
    "share_drives": MeasureSpec("small_length", "part of the feed drives in it"),
    "deviation_drives_max": MeasureSpec(
        "small_length", "largest deviation off the surface by the feed drives, with its sign"
    ),
    "share_pistons": MeasureSpec(
        "small_length", "part of the spindle in the displacement off the surface, worst place"
    ),
    "share_arm": MeasureSpec("small_length", "part of the robot's joints in it"),
    "share_base": MeasureSpec("small_length", "part of the robot's base in it"),
    "stiffness_normal_min": MeasureSpec("stiffness", "stiffness of the carrier off the surface, least along the path"),
    "stiffness_normal_max": MeasureSpec("stiffness", "stiffness of the carrier off the surface, greatest"),
    "natural_frequency_min": MeasureSpec("frequency", "lowest natural frequency of the arm along the path"),
    "energy_balance": MeasureSpec("dimensionless", "work of the force less elastic energy, relative: a check"),
    "sag_change_max": MeasureSpec("small_length", "largest change along the path of the sag under links and tool"),
    "joint_speed_margin": MeasureSpec("dimensionless", "1 minus the largest speed of a joint over its limit"),
    "feed_possible_min": MeasureSpec("speed", "feed that the joints can follow everywhere on the path"),
    "joint_limit_margin": MeasureSpec("angle", "least room of a joint to its limit"),
    "wrist_margin": MeasureSpec("dimensionless", "least |sin| of the wrist angle; 0 is singular"),
    "redundancy_angle_min": MeasureSpec("angle", "least angle of the tool about its axis"),
    "redundancy_angle_max": MeasureSpec("angle", "greatest angle of the tool about its axis"),
}

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
    **CARRIED,
}

STOCK: Mapping[str, MeasureSpec] = {
    "cutting_power_max": MeasureSpec("power", "largest mean power of the cut over a revolution"),
    "spindle_torque_max": MeasureSpec("moment", "largest mean torque of the cut over a revolution"),
    "chip_thickness_max": MeasureSpec("small_length", "largest chip thickness in contact"),
    "plunge_force_max": MeasureSpec("force", "largest mean force along the axis where the tool goes straight down"),
    "air_cut_time": MeasureSpec("time", "time of feed moves without contact"),
    "rapids_in_stock": MeasureSpec("dimensionless", "lines whose rapid move runs through the stock"),
    "collisions": MeasureSpec(
        "dimensionless", "lines in which shank or holder run into the stock, or the tool into a fixture"
    ),
    "collision_depth_max": MeasureSpec("length", "how deep the worst of them goes"),
    "surface_check_max": MeasureSpec(
        "small_length", "how far the surface between cells stands above that of all moves at random points: a check"
    ),
    "deviation_min": MeasureSpec(
        "small_length", "least deviation of the surface from the part; negative: cut into the part"
    ),
    "deviation_max": MeasureSpec(
        "small_length", "largest deviation of the surface from the part; positive: material left"
    ),
    "deviation_rms": MeasureSpec("small_length", "root mean square of the deviation over the judged area"),
    "fraction_in_tolerance": MeasureSpec("dimensionless", "share of the judged area within the tolerance of the part"),
    "gouge_volume": MeasureSpec("volume", "volume cut into the part"),
    "excess_volume": MeasureSpec("volume", "volume of material left on the judged faces"),
    "deviation_min_ideal": MeasureSpec(
        "small_length", "least deviation of the surface that the planned path would leave"
    ),
    "deviation_max_ideal": MeasureSpec(
        "small_length", "largest deviation of the surface that the planned path would leave"
    ),
    "deviation_rms_ideal": MeasureSpec("small_length", "root mean square of that deviation over the judged area"),
    "tool_offset_max": MeasureSpec(
        "small_length",
        "how far drives, bending, machine or robot move the tool off its path in contact, what drives lag along it left out",
    ),
    "tool_offset_change": MeasureSpec(
        "small_length", "largest change of the offset of the tool when the pieces of its path are halved: a check"
    ),
    "scallop_max": MeasureSpec("small_length", "largest scallop that a ball or bull-nose leaves on a face"),
}

ROBOT_MILLING: Mapping[str, MeasureSpec] = {
    **CARRIED,
    "stroke_margin": MeasureSpec("length", "stroke minus the largest piston travel"),
    "floor_error_min": MeasureSpec("small_length", "least error of the floor left by a robot, positive into the part"),
    "floor_error_max": MeasureSpec("small_length", "greatest error of the floor left by a robot"),
    "wall_tilt_max": MeasureSpec("small_angle", "largest tilt of the wall left by a robot"),
    "stable_depth_min": MeasureSpec("length", "least axial depth along the path at which the arm chatters"),
    "depth_margin": MeasureSpec("dimensionless", "1 minus axial depth over that limit; not above 0: it chatters"),
}

MILLING: Mapping[str, MeasureSpec] = {
    "contour_error_max": MeasureSpec("small_length", "largest distance of the actual position from the path"),
    "drive_error_max": MeasureSpec(
        "small_length",
        "largest distance from the path that is driven, its blended corners included: what the drives add",
    ),
    "contour_error_rms": MeasureSpec("small_length", "r.m.s. distance from the path, settling at the end included"),
    "cycle_time": MeasureSpec("time", "time from the first to the last point within the limits of the machine"),
    "cycle_time_ideal": MeasureSpec("time", "time at the programmed feed throughout, without limits of acceleration"),
    "tracking_error_max_x": MeasureSpec("small_length", "largest lag of the x axis behind its set point"),
    "tracking_error_max_y": MeasureSpec("small_length", "largest lag of the y axis behind its set point"),
    "tracking_error_max_z": MeasureSpec("small_length", "largest lag of the z axis behind its set point"),
    "settling_overshoot": MeasureSpec("small_length", "how far the tool runs over the end point along the path"),
    "settling_time": MeasureSpec("time", "time after the last set point until the tool stays within 5 µm of it"),
    "drive_voltage_max": MeasureSpec("voltage", "largest voltage of the controllers, after clipping"),
    "saturation_time": MeasureSpec("time", "time for which a controller is at its limit"),
    "feed_min": MeasureSpec("speed", "lowest actual feed on the cut (within 10 mm of the corner), at the samples"),
    "force_xy_peak": MeasureSpec("force", "largest force on the tool in the xy plane"),
    "force_x_peak": MeasureSpec("force", "largest magnitude of the force on the tool, x direction"),
    "force_y_peak": MeasureSpec("force", "largest magnitude of the force on the tool, y direction"),
    "force_z_peak": MeasureSpec("force", "largest magnitude of the force on the tool, z direction"),
    "force_xy_mean_straight": MeasureSpec("force", "mean force vector in the xy plane on the straight, at the feed"),
    "force_xy_mean_corner": MeasureSpec(
        "force", "largest mean force vector in the xy plane, each place at its own feed"
    ),
    "force_xy_peak_straight": MeasureSpec("force", "peak over a tooth in the xy plane on the straight, at the feed"),
    "force_xy_peak_corner": MeasureSpec("force", "peak over a tooth in the xy plane at the same place"),
    "engagement_angle_max": MeasureSpec("angle", "largest immersion angle on the path"),
    "engagement_angle_straight": MeasureSpec("angle", "immersion angle on the straight"),
    "removed_volume": MeasureSpec(
        "volume",
        "volume taken of the stock; by exact arcs that of the flutes sideways, without what the end of the mill "
        "takes in plunges and ramps, in 3D all of it",
    ),
    "removed_volume_error": MeasureSpec(
        "volume",
        "error of the volume taken, by what random points within the cells of a map lose: three standard deviations",
    ),
    "removal_rate_max": MeasureSpec("removal_rate", "largest volume taken per time, at the planned speed"),
    "drive_torque_max_x": MeasureSpec("moment", "largest motor torque of the x axis"),
    "drive_torque_max_y": MeasureSpec("moment", "largest motor torque of the y axis"),
    "drive_torque_max_z": MeasureSpec("moment", "largest motor torque of the z axis"),
    "bandwidth_x": MeasureSpec("frequency", "-3 dB bandwidth of the sampled x position loop"),
    "bandwidth_y": MeasureSpec("frequency", "-3 dB bandwidth of the sampled y position loop"),
    "bandwidth_z": MeasureSpec("frequency", "-3 dB bandwidth of the sampled z position loop"),
    "phase_margin_x": MeasureSpec("angle", "phase margin of the sampled x position loop"),
    "phase_margin_y": MeasureSpec("angle", "phase margin of the sampled y position loop"),
    "phase_margin_z": MeasureSpec("angle", "phase margin of the sampled z position loop"),
    "chatter_growth_straight": MeasureSpec("dimensionless", "growth of tip vibration per tooth on the straight"),
    "chatter_growth_corner": MeasureSpec("dimensionless", "growth of tip vibration per tooth in the widest contact"),
    "stable_depth_straight": MeasureSpec(
        "length", "least axial depth that chatters on the straight at the spindle speed"
    ),
    "stable_depth_corner": MeasureSpec("length", "the same in the widest contact"),
    "tip_deflection_max": MeasureSpec("small_length", "largest displacement of the tool tip by its modes"),
    "wall_error_min": MeasureSpec(
        "small_length", "least error of the wall left, drives and tip, positive into the wall"
    ),
    "wall_error_max": MeasureSpec("small_length", "greatest error of the wall left, drives and tip, into the wall"),
    **STOCK,
    "path_length": MeasureSpec("length", "length of the commanded path"),
    **ROBOT_MILLING,
    **_deflections("bodies", "displacement by the bodies of the machine and the part where the wall is read"),
    "deviation_drives_max": MeasureSpec(
        "small_length", "largest deviation of the drives off the wall over the cut, with its sign"
    ),
    "share_drives": MeasureSpec("small_length", "part of the drives in the displacement off the wall, worst place"),
    "share_bodies": MeasureSpec("small_length", "part of the bodies of the machine and the part in it"),
    "stops": MeasureSpec("dimensionless", "full stops between the first and the last point"),
    "cutting_time": MeasureSpec("time", "time in which the tool is in the cut"),
    "tool_life": MeasureSpec("time", "how long an edge lasts in this cut"),
    "cost_per_part": MeasureSpec("money", "machine's time, and the share of an edge that is worn"),
    "cost_low": MeasureSpec("money", "cost of a part with the tool life that one edge in twenty exceeds"),
    "cost_high": MeasureSpec("money", "cost of a part with the tool life that one edge in twenty does not reach"),
}


_POSTURES = (
    "stiffness_normal_min", "stiffness_normal_max", "sag_change_max", "joint_speed_margin", "feed_possible_min",
    "joint_limit_margin", "wrist_margin", "redundancy_angle_min", "redundancy_angle_max",
)  # fmt: skip


class _BodyMeasures(dict[str, MeasureSpec]):
    """Measures of a machine: the fixed names, and ``share_BODY`` for whatever its bodies are called."""

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (isinstance(name, str) and re.fullmatch(r"share_\w+", name) is not None)

    def __missing__(self, name: str) -> MeasureSpec:
        if name not in self:
            raise KeyError(name)
        body = name.removeprefix("share_")
        return MeasureSpec("small_length", f"share of body {body} along the largest error; the shares sum to it")


def _deviation(where: str, words: str) -> dict[str, MeasureSpec]:
    return {
        f"deviation_{axis}_{where}": MeasureSpec("small_length", f"error of the tool point along {axis} {words}")
        for axis in "xyz"
    }


MACHINE: Mapping[str, MeasureSpec] = _BodyMeasures(
    {
        **_deviation("start", "at the start of the pass (program: of its cuts)"),
        **_deviation("middle", "in the middle of the pass"),
        **_deviation("end", "at the end of the pass"),
        "deviation_norm_max": MeasureSpec("small_length", "largest length of the error over the pass"),
        "deviation_norm_max_at": MeasureSpec("length", "x of the ideal tool point where the error is largest"),
        "deviation_p95": MeasureSpec(
            "small_length", "95 % quantile of the error in the middle (program: where it is worst)"
        ),
        "deviation_random_p95": MeasureSpec("small_length", "95 % quantile of the random error alone, there"),
        "probability_within": MeasureSpec(
            "dimensionless", "probability that the error there stays within uncertainty.tolerance"
        ),
        **_per_axis("deviation_std", "small_length", "standard deviation of the random error there"),
        **_per_axis("position_start", "length", "ideal tool point in the part at the start"),
        "linear_residual_max": MeasureSpec("small_length", "largest difference of exact and first-order error"),
        "energy_balance": MeasureSpec("dimensionless", "relative residual of Clapeyron's balance over all loads"),
        "work_convexity": MeasureSpec(
            "dimensionless", "least second derivative of cutting force times error along the pass; not below 0"
        ),
        "stiffening_gain_best": MeasureSpec(
            "small_length", "change of the largest error if the element that brings most were 10 % stiffer"
        ),
        "wall_error_min": MeasureSpec("small_length", "smallest error of the wall along its normal"),
        "wall_error_max": MeasureSpec("small_length", "largest error of the wall along its normal"),
        "wall_flatness": MeasureSpec("small_length", "peak to valley of the wall off its least-squares plane"),
        "volumetric_error_max": MeasureSpec(
            "small_length", "largest geometric error over the map of the working space"
        ),
        "diagonal_range_max": MeasureSpec("small_length", "largest range of the error along a body diagonal"),
        **{
            f"diagonal_range_{number}": MeasureSpec("small_length", f"range of the error along body diagonal {number}")
            for number in (1, 2, 3, 4)
        },
        **{name: CARRIED[name] for name in _POSTURES},
        "map_interpolation_error": MeasureSpec(
            "small_length", "largest error of the map's tables against the functions"
        ),
    }
)

DRILLING: Mapping[str, MeasureSpec] = {
    "thrust_max": MeasureSpec("force", "largest thrust"),
    "thrust_mean": MeasureSpec("force", "mean thrust in full cut"),
    "thrust_lips": MeasureSpec("force", "thrust of the lips in full contact at nominal feed"),
    "thrust_chisel": MeasureSpec("force", "thrust of the chisel edge in full contact at nominal feed"),
    "torque_max": MeasureSpec("moment", "largest drill torque"),
    "torque_lips": MeasureSpec("moment", "torque of the lips in full contact at nominal feed"),
    "torque_chisel": MeasureSpec("moment", "torque of the chisel edge in full contact at nominal feed"),
    "torque_margin": MeasureSpec("moment", "torque of the margins, fully in the hole"),
    "lateral_force_max": MeasureSpec("force", "largest force of the hole wall on the drill"),
    "axial_deflection_max": MeasureSpec("small_length", "largest deflection of the tool tip along the drill axis"),
    "axial_deflection_mean": MeasureSpec("small_length", "mean axial deflection in full cut; negative: pushed back"),
    "lateral_deflection_max": MeasureSpec("small_length", "largest deflection of the tool tip across the drill axis"),
    "lateral_deflection_mean": MeasureSpec("small_length", "mean lateral deflection in full cut"),
    "hole_position_error_entry": MeasureSpec(
        "small_length",
        "position error of the hole at the entry surface by what the carrier yields; its own error is apart",
    ),
    "hole_position_error_exit": MeasureSpec(
        "small_length",
        "position error of the hole at the exit surface by what the carrier yields; its own error is apart",
    ),
    "hole_position_error_arm": MeasureSpec(
        "small_length", "position error of the arm itself (robot.errors, robot.accuracy)"
    ),
    "hole_position_error_total": MeasureSpec(
        "small_length", "the larger of entry and exit, and the arm's own error added to it"
    ),
    "perpendicularity_error": MeasureSpec("small_angle", "tilt of the hole between entry and exit"),
    "drill_tilt": MeasureSpec("small_angle", "tilt of the drill itself under thrust"),
    "circularity_estimate": MeasureSpec("small_length", "upper bound of the circularity error from unequal lips"),
    "oversize_estimate": MeasureSpec("small_length", "upper bound of the oversize from unequal lips"),
    "feed_per_rev_max": MeasureSpec("feed_per_revolution", "largest actual feed at breakthrough"),
    "feed_per_rev_min": MeasureSpec("feed_per_revolution", "smallest actual feed while the point enters"),
    "depth_error": MeasureSpec("small_length", "axial deflection left at the end of the dwell (blind holes)"),
    "skating_ratio": MeasureSpec(
        "dimensionless", "lateral over axial force that keeps the tip in place, worst over the entry"
    ),
    "skating_margin": MeasureSpec("dimensionless", "friction minus skating ratio; negative: the tip skates"),
    "compliance_axial": MeasureSpec("compliance", "compliance along the drill axis in the chosen posture"),
    "share_arm": MeasureSpec(
        "small_length", "part of the robot's joints in the axial deflection under the mean thrust"
    ),
    "share_base": MeasureSpec("small_length", "part of the robot's base in it"),
    "share_bodies": MeasureSpec(
        "small_length", "part of the bodies of the machine in it, the part as a block included"
    ),
    "share_part_stiffness": MeasureSpec("small_length", "part of the part in it"),
    "redundancy_angle": MeasureSpec("angle", "angle of the tool about the drill axis"),
    "wrist_margin": MeasureSpec("dimensionless", "|sin| of the wrist angle; 0 is singular"),
    "joint_limit_margin": MeasureSpec("angle", "smallest distance of a joint from its limit"),
    "natural_frequency_min": MeasureSpec("frequency", "lowest frequency of the arm at the tool"),
    "cycle_time": MeasureSpec("time", "time for a hole without retract; of a pattern, for all holes"),
    "holes_drilled": MeasureSpec("dimensionless", "number of holes that can be drilled"),
}
"""For a pattern every measure but ``cycle_time`` and ``holes_drilled`` is that of its worst hole."""


CHAMFER: Mapping[str, MeasureSpec] = {
    "width_min": MeasureSpec("length", "smallest width that the swept ball leaves"),
    "width_max": MeasureSpec("length", "largest width that the swept ball leaves"),
    "gouge_max": MeasureSpec("length", "deepest cut into the part beyond the chamfer"),
    "gouge_bound": MeasureSpec("length", "no place beyond the chamfer is cut deeper than this"),
    "rod_clearance_min": MeasureSpec("length", "smallest distance of the rod from the part"),
    "rod_clearance_bound": MeasureSpec("length", "no place of the part is nearer to the rod than this"),
    "rod_reach": MeasureSpec(
        "length", "longest rod, from the ball centre up, beside which the part stands within ten rod radii"
    ),
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
    "setup_sensitivity_z": MeasureSpec(
        "dimensionless", "width change per unit of set-up error along the tool axis, z of the pass"
    ),
    "setup_width_low": MeasureSpec("length", "smallest width along the edge, 5 % of the set-ups are below"),
    "setup_width_high": MeasureSpec("length", "largest width along the edge, 5 % of the set-ups are above"),
    **_per_axis("force_mean", "force", "mean cutting force on the tool in the frame of the pass"),
    **_per_axis("burr_force_mean", "force", "mean force of the burr alone on the tool in the frame of the pass"),
    "lateral_force_max": MeasureSpec("force", "largest force across the tool axis"),
    "chip_area": MeasureSpec("area", "largest cross-section taken off, at right angles to the edge"),
    "cutting_power_mean": MeasureSpec("power", "mean cutting power"),
    "width_deflected_min": MeasureSpec("length", "smallest width with the spindle deflected"),
    "width_deflected_max": MeasureSpec("length", "largest width with the spindle deflected"),
    "tip_deflection_max": MeasureSpec("length", "largest deflection of the tool tip"),
    "stroke_margin": MeasureSpec("length", "stroke minus the largest piston travel"),
    "rod_clearance_deflected_min": MeasureSpec("length", "smallest distance of the rod from the part while it yields"),
    "breakaway_force": MeasureSpec("force", "lateral force at the tip at which the spindle starts to yield"),
    "edges_chamfered": MeasureSpec("dimensionless", "number of edges with a proven path"),
    "edges_refused": MeasureSpec("dimensionless", "number of selected edges without one"),
    "corners_joined": MeasureSpec("dimensionless", "corners at which one path goes on into the next"),
    "length_trimmed": MeasureSpec("length", "edge length given up at corners and concave neighbours"),
    **{name: spec for name, spec in CARRIED.items() if name != "energy_balance"},
}

_TURNED = {  # lengths
    "diameter_error_mean": "mean error of the finished diameter; positive: too thick",
    "diameter_error_min": "smallest error of the finished diameter; negative: too thin",
    "diameter_error_max": "largest error of the finished diameter; positive: too thick",
    "barrel": "diameter error in the middle less the mean of both ends of what is turned; positive: barrel",
    "taper": "diameter error at the far end less that at the headstock end of what is turned",
    "cylindricity_error": "half the difference of largest and smallest diameter error",
    "roundness_error_max": "run-out of the bar that the shaft has copied, full indicator reading, largest",
    "roughness_rt": "height of the ridges that feed, nose and minor edge leave, largest; theoretical",
    "roughness_ra": "mean deviation of these ridges as parabolas, largest; theoretical",
    **{f"share_{term}": f"part of the {term} in the radius error, worst place; work: the shaft"
       for term in ("work", "headstock", "tailstock", "steady", "tool")},
}  # fmt: skip
TURNING: Mapping[str, MeasureSpec] = {
    **{name: MeasureSpec("small_length", said) for name, said in _TURNED.items()},
    **{f"force_{name}_max": MeasureSpec("force", f"largest force {said}, of all passes") for name, said in (
        ("cutting", "along the cutting speed, F_c"), ("passive", "off the shaft, F_p"), ("feed", "against the feed, F_f"))},
    "cutting_power_max": MeasureSpec("power", "largest cutting power of all passes"),
    "cycle_time": MeasureSpec("time", "time in the feed, all passes"),
    "stable_depth_min": MeasureSpec("length", "depth at which shaft or tool chatters, of the pass with least margin"),
    "depth_margin": MeasureSpec("dimensionless", "1 less the depth of cut over that at which it chatters, least"),
    **{name: CARRIED[name] for name in ("stiffness_normal_min", "stiffness_normal_max", "energy_balance")},
    **{key: spec for term in ("work", "headstock", "tailstock", "steady", "tool")
       for key, spec in _deflections(term, f"displacement by the {term}", "in the last pass").items()},
}  # fmt: skip
