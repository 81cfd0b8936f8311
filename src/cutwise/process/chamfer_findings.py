"""What leaves nothing of a chamfer to be judged."""

from collections.abc import Iterator, Mapping

from cutwise.process.chamfer import ChamferRun
from cutwise.process.chamfer_cut import FAR_ROUND, down, mounted, ring_on
from cutwise.process.spindles import weight_on
from cutwise.results import Finding, Place
from cutwise.spec.chamfer import ChamferScenario


def unsound(run: ChamferRun, found: Mapping[str, float]) -> Iterator[Finding]:
    """At the stop, dragged round the bends, an edge that still stands, a rod that rubs, a ball that cuts nothing."""
    for path, one in zip(run.paths, run.deflected, strict=False):
        if one.stopped:
            yield Finding("at_stop", Place(path.work.name), one.travel, one.travel, "length")
        elif one.round_bend > FAR_ROUND:
            yield Finding("tip_lost", Place(path.work.name), one.round_bend, FAR_ROUND, "angle")
        elif one.moves.unsolved:
            yield Finding("unsolved", Place(path.work.name), float(one.moves.unsolved), 0.0)
    if run.forces and not any(forces.force.any() for forces in run.forces):
        yield Finding("untouched")
    for name in ("width_min", "width_deflected_min"):
        if found.get(name) == 0.0:
            yield Finding("edge_stands", measure=name, value=0.0, dimension="length")
    planned = min((path.rod.value for path in run.paths if path.rod is not None), default=0.0)
    rod = found.get("rod_clearance_deflected_min", found.get("rod_clearance_min", 0.0))
    if rod < 0.0 <= planned:  # carried there by the spindle, or by preset and part error
        yield Finding("rubs", value=rod, limit=0.0, dimension="length")


def weight(scenario: ChamferScenario, run: ChamferRun) -> Iterator[Finding]:
    """The weight of the motor at the tip on the first path; its direction of the weight in the part is said."""
    if not run.deflected or scenario.compliant is None or scenario.compliant.gravity == "off":
        return
    frame = mounted(run.paths[0], run.paths)
    towards = ", ".join(f"{part:.3g}" for part in down(scenario, frame) + 0.0)
    yield from weight_on(
        ring_on(scenario, frame), scenario.compliant.tool_reach, Place(f"along ({towards}) of the part")
    )
